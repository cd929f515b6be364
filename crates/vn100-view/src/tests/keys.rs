//! What keys do.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use vn100_session::{Command, Playback, Speed};

use super::{PLAIN, SIZES, damaged, drawn, measured, nothing, one, text};
use crate::{
    source::SourceView,
    state::Question,
    state::{Panel, ViewRequest, ViewState},
};

fn press(state: &mut ViewState, sources: &[SourceView], keys: &str) -> Option<ViewRequest> {
    let key = |c| match c {
        '\n' => KeyCode::Enter,
        '\t' => KeyCode::Tab,
        '\x1b' => KeyCode::Esc,
        '\x08' => KeyCode::Backspace,
        '↑' => KeyCode::Up,
        '↓' => KeyCode::Down,
        '←' => KeyCode::Left,
        '→' => KeyCode::Right,
        c => KeyCode::Char(c),
    };
    let mut last = None;
    for c in keys.chars() {
        last = state.key(KeyEvent::new(key(c), KeyModifiers::NONE), sources);
    }
    last
}

fn pressed(keys: &str, sources: &[SourceView]) -> (ViewState, Option<ViewRequest>) {
    let mut state = ViewState { overview: false, ..ViewState::new(sources.len()) };
    let request = press(&mut state, sources, keys);
    (state, request)
}

fn replayed() -> SourceView {
    let total = Some(20_000);
    let playback = Playback { samples: 5_000, total, speed: Speed::Max, paused: false, at_end: false };
    SourceView { playback: Some(playback), ..measured() }
}

#[test]
fn quitting_is_asked_for_in_every_usual_way() {
    let quit = Some(ViewRequest::Quit);
    assert_eq!(pressed("q", &[measured()]).1, quit);
    assert_eq!(pressed("?q", &[measured()]).1, quit, "from the help too");
    let mut state = one();
    let control = |c| KeyEvent::new(KeyCode::Char(c), KeyModifiers::CONTROL);
    assert_eq!(state.key(control('c'), &[]), quit);
    assert_eq!(state.key(control('z'), &[]), Some(ViewRequest::Suspend));
    assert_eq!(state.key(control('q'), &[]), None);
    assert_eq!(pressed("q", &[nothing()]).1, quit, "before anything is known");
}

#[test]
fn the_help_has_pages_and_closes() {
    let sources = [measured()];
    let page = |keys: &str| pressed(keys, &sources).0.help;
    assert_eq!([page("?"), page("? "), page("??↓"), page("??↑"), page("?↑")], [0, 1, 2, 0, 0].map(Some));
    assert_eq!([page("?x"), page("??s")], [None; 2]);
    assert_eq!(pressed("?x", &sources).0, one(), "a key that closes it does nothing else");
    let mut state = one();
    state.key(KeyEvent::new(KeyCode::F(1), KeyModifiers::NONE), &sources);
    assert_eq!(state.help, Some(0), "by the key that opens it elsewhere");
    for size in [(80, 16), (60, 20), (80, 24), (80, 40), (80, 60)] {
        let page = |page| text(&drawn(&ViewState { help: Some(page), ..one() }, &sources, PLAIN, size));
        let (_, behind) = page(0).split_once("page 1 of ").map(|(a, b)| (a.to_owned(), b.to_owned())).unwrap();
        let pages: usize = behind.split(',').next().unwrap().parse().unwrap();
        let all: String = (0..pages).map(page).collect();
        let words = all.replace(['│', '\n'], " ").split_whitespace().collect::<Vec<_>>().join(" ");
        for shown in ["quit and print", "pause or resume, faster, slower", "deviation between", "or rejected"] {
            assert_eq!(words.matches(shown).count(), 1, "{shown} at {size:?}:\n{all}");
        }
    }
}

#[test]
fn the_help_gives_the_confidence_of_the_intervals() {
    let source = measured();
    for (confidence, shown) in [(0.68, " 68 % confidence"), (0.95, " 95 % confidence"), (0.995, " 99.5 % confidence")] {
        let mut sources = [source.clone()];
        sources[0].result.confidence = confidence;
        let screen = text(&drawn(&ViewState { help: Some(0), ..one() }, &sources, PLAIN, (120, 40)));
        assert!(screen.contains(shown), "{shown}\n{screen}");
    }
}

#[test]
fn a_key_leads_to_the_warnings() {
    assert_eq!(pressed("!", &[measured()]).0, ViewState { panel: Panel::Warnings, ..one() });
    assert_eq!(pressed("!↓↓", &[damaged()]).0.warning, 2);
    assert_eq!(pressed("!↓↓!", &[damaged()]).0.warning, 0, "the newest");
}

#[test]
fn panels_sensors_and_axes_are_chosen() {
    let sources = [measured()];
    assert_eq!(pressed("\t\t", &sources).0.panel, Panel::Statistics);
    assert_eq!(pressed("\t\t\t\t\t", &sources).0.panel, Panel::Allan);
    assert_eq!(pressed("2y", &sources).0, ViewState { sensor: 1, axis: Some(1), ..one() });
    assert_eq!(pressed("2ya", &sources).0, ViewState { sensor: 1, ..one() });
    assert_eq!(pressed("9", &sources).0, one(), "there is no ninth sensor");
    assert_eq!(pressed("↓", &sources).0.axis, Some(0));
    assert_eq!(pressed("↓↓↓↓", &sources).0, ViewState { sensor: 1, axis: Some(0), ..one() }, "on to the next sensor");
    assert_eq!(pressed("↓↓↓↓↑", &sources).0.axis, Some(2));
    assert!(pressed("e", &sources).0.expanded && !pressed("e\x1b", &sources).0.expanded);
}

#[test]
fn the_plot_is_chosen() {
    let plot = |keys| pressed(keys, &[measured()]).0.shows_spectrum;
    assert_eq!([plot("v"), plot("vv")], [true, false]);
}

#[test]
fn the_cursor_stays_on_the_curve() {
    let sources = [measured()];
    let octaves = &sources[0].result.channels[0].allan.points;
    let cursor = |keys| pressed(keys, &sources).0.octave(octaves);
    let known = octaves.iter().filter(|octave| octave.is_known()).count();
    assert!(known < octaves.len(), "the longest is known by too few averages");
    assert_eq!(cursor(""), Some(known - 1));
    assert_eq!(cursor("←"), Some(known - 2));
    let [right, left] = ["→", "←"].map(|key| key.repeat(99));
    assert_eq!(cursor(&right), Some(octaves.len() - 1));
    assert_eq!(cursor(&left), Some(0));
    assert_eq!(pressed("←→", &[nothing()]).0.cursor, None, "there is no curve");
}

#[test]
fn what_loses_data_is_asked_first() {
    let sources = [measured()];
    let control = |request| Some(ViewRequest::Control(request));
    assert_eq!(pressed("r", &sources).1, None);
    assert_eq!(pressed("r", &sources).0.question, Some(Question::StartOver));
    assert_eq!(pressed("ry", &sources).1, control(Command::StartOver));
    assert_eq!(pressed("w\n", &sources).1, control(Command::EndWarmUp));
    for no in ["rn", "wq", "r\x1b", "rr"] {
        assert_eq!(pressed(no, &sources), (one(), None), "{no}");
    }
}

#[test]
fn a_replay_is_paused_and_its_speed_chosen() {
    let sources = [replayed()];
    let control = |request| Some(ViewRequest::Control(request));
    assert_eq!(pressed(" ", &sources).1, control(Command::TogglePause));
    assert_eq!(pressed(">", &sources).1, control(Command::Faster));
    assert_eq!(pressed("<", &sources).1, control(Command::Slower));
    assert_eq!(pressed(" ", &[measured()]).1, None, "a live source does not wait");
}

#[test]
fn a_place_is_marked_with_a_text() {
    let live = [measured()];
    let mark = |text: &str| Some(ViewRequest::Control(Command::Mark(text.into())));
    assert_eq!(pressed("mfan on q\n", &live).1, mark("fan on q"), "letters are no keys meanwhile");
    assert_eq!(pressed("mab\x08\x08door\n", &live).1, mark("door"));
    for nothing in ["m\n", "m  \n", "mfan\x1b"] {
        assert_eq!(pressed(nothing, &live), (one(), None), "{nothing}");
    }
    let (state, request) = pressed("m", &[replayed()]);
    assert!(request.is_none() && state.question.is_none() && state.message.unwrap().contains("while a sensor"));
    let state = pressed(&format!("m{}", "long ".repeat(60)), &live).0;
    let Some(Question::Mark(typed)) = &state.question else { panic!("{:?}", state.question) };
    assert_eq!(typed.chars().count(), 120);
    let screen = text(&drawn(&state, &live, PLAIN, (60, 20)));
    assert!(screen.contains("long long _   enter / esc") || screen.contains("long_   enter / esc"), "{screen}");
}

#[test]
fn at_the_end_of_a_capture_what_has_no_effect_says_why() {
    let mut source = replayed();
    source.playback = source.playback.map(|playback| Playback { at_end: true, ..playback });
    for keys in ["w", "r"] {
        let (state, request) = pressed(keys, std::slice::from_ref(&source));
        assert!(request.is_none() && state.question.is_none());
        assert!(state.message.unwrap().contains("at its end"), "{keys}");
    }
}

#[test]
fn on_a_screen_that_is_too_small_only_quitting_acts() {
    let before = ViewState { is_too_small: true, ..one() };
    for key in "sruwfeo!?=-.<>g]Q\t\n12axyz".chars() {
        let mut state = before.clone();
        let request = press(&mut state, &[measured()], &key.to_string());
        assert_eq!((state, request), (before.clone(), None), "{key:?}");
    }
    let quit = Some(ViewRequest::Quit);
    assert_eq!(press(&mut before.clone(), &[measured()], "q"), quit);
}

#[test]
fn a_page_down_turns_the_page_of_the_help() {
    let mut state = one();
    for (code, page) in [
        (KeyCode::Char('?'), Some(0)),
        (KeyCode::PageDown, Some(1)),
        (KeyCode::PageUp, Some(0)),
        (KeyCode::PageDown, Some(1)),
        (KeyCode::Home, Some(0)),
        (KeyCode::Esc, None),
    ] {
        state.key(KeyEvent::new(code, KeyModifiers::NONE), &[measured()]);
        assert_eq!(state.help, page, "{code:?}");
    }
}

#[test]
fn sources_are_chosen_in_the_overview_and_beside_it() {
    let sources = [measured(), damaged(), nothing()];
    let mut state = ViewState::new(3);
    press(&mut state, &sources, "↓↓\n");
    assert_eq!((state.source, state.overview), (2, false));
    press(&mut state, &sources, "n");
    assert_eq!(state.source, 0);
    press(&mut state, &sources, "po2");
    assert_eq!((state.source, state.overview), (1, false));
    for (code, source) in [(KeyCode::End, 2), (KeyCode::PageUp, 0), (KeyCode::PageDown, 2), (KeyCode::Home, 0)] {
        let mut state = ViewState::new(3);
        state.key(KeyEvent::new(KeyCode::End, KeyModifiers::NONE), &sources);
        state.key(KeyEvent::new(code, KeyModifiers::NONE), &sources);
        assert_eq!((state.source, state.overview), (source, true), "{code:?}");
    }
}

#[test]
fn the_address_of_the_live_page_is_on_every_screen_or_in_the_help() {
    let sources = [measured(), nothing()];
    let address = "http://127.0.0.1:8100/";
    for (overview, source, size) in
        SIZES.into_iter().flat_map(|size| [(false, 0, size), (false, 1, size), (true, 0, size)])
    {
        let mut state = ViewState { overview, source, page: Some(address.into()), ..ViewState::new(2) };
        let screen = text(&drawn(&state, &sources, PLAIN, size));
        let last = screen.lines().last().unwrap();
        assert!(last.ends_with(address) && last.starts_with(" q quit  ? help "), "{size:?}\n{screen}");
        // a long one leaves the keys their room
        let long = format!("http://{}:8100/", "a".repeat(size.0.into()));
        state.page = Some(long);
        let screen = text(&drawn(&state, &sources, PLAIN, size));
        assert!(screen.lines().last().unwrap().starts_with(" q quit  ? help "), "{size:?}\n{screen}");
        state = ViewState { page: Some(address.into()), help: Some(0), ..state };
        let screen = text(&drawn(&state, &sources, PLAIN, size));
        assert!(screen.contains(&format!("live page: {address} ")), "{size:?}\n{screen}");
    }
}
