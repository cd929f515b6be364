//! The screens of the view, from fixed data. Those of each panel are compared, at two sizes, with
//! the screens kept in `tests/screens`, which `VN100_WRITE_SCREENS=1` writes again.

mod colours;
pub(crate) mod fixture;
mod head;
mod keys;
mod plots;
mod restored;
mod stills;

use std::{env, fmt::Write, fs, path::Path, time::Duration};

use ratatui::{Terminal, backend::TestBackend, buffer::Buffer};
use vn100_analysis::{Finding, LinkFacts, LinkStatus, RateChange, Warning, WarningKind};
use vn100_report::health::{NextOctave, line_load, next_octave};
use vn100_session::{Playback, Speed};

use crate::{
    draw::draw,
    scene::Scene,
    source::{SourcePhase, SourceView},
    state::{Panel, Question, ViewState},
    theme::{Colours, Theme},
};
use fixture::{damaged, link, linked, lost, measured, nothing};

/// The sizes of the screens that are kept: one panel, and all of them.
const KEPT: [(u16, u16); 2] = [(80, 24), (200, 60)];

const SIZES: [(u16, u16); 4] = [(60, 20), (80, 24), (120, 40), (200, 60)];

const PLAIN: Theme = Theme { colours: Colours::None, ascii: false };

fn drawn(state: &ViewState, sources: &[SourceView], theme: Theme, (width, height): (u16, u16)) -> Buffer {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    let scene = Scene { state, sources, source: &sources[state.source], theme };
    terminal.draw(|frame| draw(frame, scene)).unwrap();
    terminal.backend().buffer().clone()
}

/// The screen as text, without spaces behind.
fn text(buffer: &Buffer) -> String {
    let mut out = String::new();
    for row in buffer.content.chunks(usize::from(buffer.area.width)) {
        let line: String = row.iter().map(ratatui::buffer::Cell::symbol).collect();
        writeln!(out, "{}", line.trim_end()).unwrap();
    }
    out
}

fn screen(state: &ViewState, source: SourceView, size: (u16, u16)) -> String {
    text(&drawn(state, &[source], PLAIN, size))
}

/// Compares the screens of a state with those kept.
fn check(name: &str, state: &ViewState, sources: &[SourceView]) {
    let mut screens = String::new();
    for size in KEPT {
        writeln!(screens, "=== {}x{}", size.0, size.1).unwrap();
        screens += &text(&drawn(state, sources, PLAIN, size));
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/tests/screens").join(format!("{name}.txt"));
    if env::var_os("VN100_WRITE_SCREENS").is_some() {
        fs::write(&file, &screens).unwrap();
    }
    let kept = fs::read_to_string(&file).unwrap_or_default();
    let line = screens.lines().zip(kept.lines()).position(|(now, kept)| now != kept);
    assert!(screens == kept, "{name}: line {line:?} differs; now:\n{screens}");
}

fn one() -> ViewState {
    ViewState::new(1)
}

#[test]
fn a_healthy_sensor() {
    check("healthy", &one(), &[measured()]);
}

#[test]
fn panels_alone() {
    for panel in [Panel::Parameters, Panel::Statistics, Panel::Signal] {
        let state = ViewState { panel, expanded: true, ..one() };
        check(&format!("panel-{}", panel.name().to_lowercase()), &state, &[measured()]);
    }
}

#[test]
fn the_columns_of_the_statistics_are_wide_where_they_have_room() {
    let state = ViewState { panel: Panel::Statistics, expanded: true, ..one() };
    let header = |width| {
        let screen = text(&drawn(&state, &[measured()], PLAIN, (width, 24)));
        screen.lines().find(|line| line.contains("mean")).unwrap().to_owned()
    };
    // 66 columns within the frame
    assert_eq!(header(67), "│channel     unit        mean       std      min      max recent  │");
    assert_eq!(header(68), "│channel     unit          mean        std       min       max     │");
}

#[test]
fn temperature_and_pressure_say_why_they_have_no_parameters() {
    for sensor in [3, 4] {
        let state = ViewState { panel: Panel::Parameters, sensor, ..one() };
        assert!(text(&drawn(&state, &[measured()], PLAIN, (80, 24))).contains("belongs to no axis of a sensor"));
    }
}

#[test]
fn a_damaged_stream_says_what_it_suffers_from() {
    check("damaged", &ViewState { panel: Panel::Warnings, warning: 1, ..one() }, &[damaged()]);
}

#[test]
fn every_warning_is_listed_and_read_in_full() {
    let every = WarningKind::ALL;
    // the words of the real ones are tested where they are made
    let warning = |kind: WarningKind| {
        let text = format!("{}the_end", "with much to be said about it, ".repeat(5));
        let said = Warning::new(Finding::Said(text)).of(["accel_x".into(), "accel_y".into()]);
        Warning { kind, severity: kind.severity(), ..said }
    };
    let source = SourceView { warnings: every.map(warning).into(), ..measured() };
    for (place, kind) in every.into_iter().enumerate() {
        let state = ViewState { panel: Panel::Warnings, warning: place, ..one() };
        for size in SIZES {
            // lines of text begin at the frame
            let screen = text(&drawn(&state, std::slice::from_ref(&source), PLAIN, size));
            let words: Vec<&str> = screen.split(['│', '\n']).flat_map(str::split_whitespace).collect();
            let said = words.join(" ");
            assert!(said.contains(&format!("{} accel_x accel_y", kind.name())), "{screen}");
            assert!(said.contains("the_end"), "{} at {size:?}:\n{screen}", kind.name());
        }
    }
}

#[test]
fn waiting_says_for_what_and_why_it_may_fail() {
    let measuring = |link| linked(SourceView { phase: SourcePhase::Measuring, ..nothing() }, link);
    check("waiting-opening", &one(), &[measuring(LinkFacts::default())]);
    let up = || link(LinkStatus::Connected);
    let scanning = LinkFacts { baud: Some(57_600), ..link(LinkStatus::Scanning) };
    let mut server = measuring(LinkFacts::default());
    server.result.source.kind = Some("tcp");
    let mut held = measuring(up());
    held.result.timing.pending = 336;
    let mut warming_up = measuring(up());
    let timing = &mut warming_up.result.timing;
    (timing.excluded, timing.skipped_s, timing.rate_hz) = (17 * 40, 20.0, Some(40.0));
    let error = "/dev/ttyUSB0: No such file or directory".to_owned();
    for (source, shown) in [
        (measuring(scanning), "Listening on /dev/ttyUSB0 at 57600 baud"),
        (measuring(up()), "is connected at 115200 baud; waiting for the first"),
        (server, "The server may be off"),
        (held, "Its first 336 samples are pending"),
        (warming_up, "Warm-up excluded: "),
        (nothing(), "Preparing /dev/ttyUSB0: "),
        (SourceView { phase: SourcePhase::Ended(Some(error)), ..nothing() }, "No such file or directory"),
    ] {
        for size in SIZES {
            // lines of text begin at the frame
            let screen = screen(&one(), source.clone(), size);
            let words: Vec<&str> = screen.split(['│', '\n']).flat_map(str::split_whitespace).collect();
            assert!(words.join(" ").contains(shown.trim_end()), "{shown} at {size:?}:\n{screen}");
        }
    }
}

#[test]
fn a_link_that_is_lost_or_silent() {
    let broken = |link| {
        let mut source = linked(SourceView { now: Duration::from_secs(503), ..measured() }, link);
        source.faults.watch(&source.result.source, Duration::from_secs(491));
        source
    };
    check("unplugged", &one(), &[broken(lost("the port is gone: unplugged", 4))]);
    let silent = broken(link(LinkStatus::Silent));
    for panel in [Panel::Allan, Panel::Warnings] {
        let screen = screen(&ViewState { panel, expanded: true, ..one() }, silent.clone(), (80, 24));
        assert!(screen.contains("!! SILENT for 12 s: /dev/ttyUSB0 is open, but no data arrives"), "{screen}");
    }
}

#[test]
fn the_next_octave_is_waited_for_behind_a_gap_where_one_broke_it() {
    let next = |source: &SourceView| next_octave(&source.result).unwrap();
    // 2 m samples: m of the next is 16384 at 40 Hz, and 20 000 are there
    let whole = NextOctave { tau_s: 409.6, wait_s: f64::from(2 * 16_384 - 20_000) * 0.025, broken: false };
    assert_eq!(next(&measured()), whole);
    // as of a record with a hole in its middle
    let mut torn = measured();
    torn.result.channels.iter_mut().for_each(|channel| channel.allan.points.truncate(12));
    assert_eq!(next(&torn), NextOctave { tau_s: 102.4, wait_s: 204.8, broken: true });
    assert_eq!(next_octave(&nothing().result), None);
}

#[test]
fn the_load_of_the_line_is_that_of_the_rate_that_comes() {
    let load = |source: &SourceView| line_load(&source.result).unwrap();
    let mut source = measured();
    assert!((load(&source) - 122.0 * 40.0 * 10.0 / 115_200.0).abs() < 1e-9);
    let timing = &mut source.result.timing;
    timing.rate_hz = Some(200.0);
    timing.rate_change = Some(RateChange { after_samples: 20_000, from_hz: 200.0, to_hz: 40.0 });
    timing.excluded = 400;
    assert!((load(&source) - 122.0 * (20_000.0 / 20_400.0) * 40.0 * 10.0 / 115_200.0).abs() < 1e-9);
    let screen = screen(&one(), source, (80, 24));
    assert!(screen.contains("rate 200 Hz as reported  now 40 Hz"), "{screen}");
}

#[test]
fn with_a_question_a_message_and_the_help() {
    check("help", &ViewState { help: Some(0), ..one() }, &[measured()]);
    for (state, shown) in [
        (ViewState { question: Some(Question::StartOver), ..one() }, "Discard everything so far and start over? y / n"),
        (ViewState { message: Some("saved a.json and a.svg".into()), ..one() }, "saved a.json and a.svg"),
    ] {
        for size in SIZES {
            let screen = screen(&state, measured(), size);
            assert!(screen.contains(shown), "{shown} at {size:?}:\n{screen}");
        }
    }
}

#[test]
fn a_replay_shows_how_far_it_is() {
    let total = Some(20_000);
    let playback = Some(Playback { samples: 5000, total, speed: Speed::Times(10.0), paused: false, at_end: false });
    let screen = screen(&one(), SourceView { playback, ..measured() }, (80, 24));
    assert!(screen.contains("▶ 10x     25 % ━━━━━━━━━━━━━━━━┈"), "{screen}");
}

#[test]
fn several_sources_stand_in_a_list() {
    let sources = [measured(), damaged(), nothing()];
    check("overview", &ViewState { source: 1, ..ViewState::new(3) }, &sources);
    let reason = "cannot open /dev/ttyUSB0: no such device".to_owned();
    let sources_one_ended = [measured(), SourceView { phase: SourcePhase::Ended(Some(reason)), ..nothing() }];
    let screen = text(&drawn(&ViewState::new(2), &sources_one_ended, PLAIN, (120, 40)));
    assert!(screen.contains("!! cannot open /dev/ttyUSB0: no such device"), "{screen}");
    let name = format!("/captures/{}bench.csv", "of-a-long-name-".repeat(5));
    let long = [SourceView { name, ..damaged() }, measured()];
    for (width, height) in SIZES {
        let question = Some(Question::StartOver);
        let screen = text(&drawn(&ViewState { question, ..ViewState::new(2) }, &long, PLAIN, (width, height)));
        for shown in ["      8  ", ": Discard everything so far and start over? y / n"] {
            assert!(screen.contains(shown), "{shown}\n{screen}");
        }
    }
    let many: Vec<SourceView> = (0..30)
        .map(|place| {
            let source = if place == 21 { damaged() } else { measured() };
            SourceView { name: format!("/dev/ttyUSB{place}"), ..source }
        })
        .collect();
    for size in SIZES {
        let screen = text(&drawn(&ViewState { source: 28, ..ViewState::new(30) }, &many, PLAIN, size));
        assert!(screen.contains("/dev/ttyUSB28"), "{screen}");
        assert_eq!(screen.contains("above,"), size.1 < 40, "{screen}");
    }
    let second = ViewState { source: 1, overview: false, ..ViewState::new(3) };
    assert!(text(&drawn(&second, &sources, PLAIN, (80, 24))).starts_with(" 2/3  /dev/ttyUSB1  "));
}

#[test]
fn nothing_but_ascii_where_nothing_else_is_shown() {
    let theme = Theme { colours: Colours::None, ascii: true };
    let panels = Panel::ALL.map(|panel| ViewState { panel, expanded: true, ..one() });
    let axis = ViewState { axis: Some(0), ..one() };
    let others = [one(), axis, ViewState { overview: true, ..one() }, ViewState { help: Some(0), ..one() }];
    for state in panels.into_iter().chain(others) {
        for source in [measured(), damaged()] {
            for size in SIZES {
                let buffer = drawn(&state, std::slice::from_ref(&source), theme, size);
                assert!(buffer.content.iter().all(|cell| cell.symbol().is_ascii()));
                // the key for the help in its two places, and a question
                let screen = text(&buffer).replace(" ? help", "").replace("| ?  ", "").replace("alive?", "");
                assert!(!screen.contains('?'), "unknown signs:\n{screen}");
            }
        }
    }
}

#[test]
fn too_small_still_shows_that_it_measures() {
    for size in [(59, 24), (80, 15), (40, 10)] {
        let screen = screen(&one(), measured(), size);
        assert!(screen.contains("is too small") && screen.contains("20 000 samples"), "{screen}");
    }
    let replay = |paused, at_end| Some(Playback { samples: 9, total: None, speed: Speed::Max, paused, at_end });
    for (playback, expected) in [
        (None, "the measurement continues"),
        (replay(false, false), "the replay continues"),
        (replay(true, false), "the replay is paused"),
        (replay(false, true), "the replay is at its end: q\nprints its result"),
    ] {
        let screen = screen(&one(), SourceView { playback, ..measured() }, (30, 6));
        assert!(screen.lines().map(str::trim_end).collect::<Vec<_>>().join("\n").contains(expected), "{screen}");
    }
}

#[test]
fn any_size_and_state_is_drawn() {
    let sources = [measured(), damaged(), nothing()];
    for width in (1..220).step_by(13) {
        for height in (1..70).step_by(7) {
            for panel in Panel::ALL {
                let state = ViewState { panel, overview: false, axis: Some(2), ..ViewState::new(3) };
                for source in 0..3 {
                    drawn(&ViewState { source, ..state.clone() }, &sources, PLAIN, (width, height));
                }
            }
            drawn(&ViewState::new(3), &sources, PLAIN, (width, height));
        }
    }
}

#[test]
fn a_picture_has_all_that_the_screen_has() {
    let state = ViewState { axis: Some(1), ..one() };
    let source = measured();
    let picture = |state: &ViewState| crate::save::picture(state, &source).unwrap().svg_file();
    let svg = picture(&state);
    let points = source.result.streamed().next().unwrap().allan.points.len();
    let discs = |svg: &str| svg.matches("<circle").count();
    assert!(discs(&svg) > points, "the points, and one in the legend");
    assert!(svg.contains(">N: ") && svg.contains("gyro_y") && svg.contains("°/h"));
    let svg_of_all = picture(&one());
    assert_eq!(discs(&svg_of_all), points + 1, "no two axes have the same sign");
    assert!(["gyro_x", "gyro_y", "gyro_z"].iter().all(|name| svg_of_all.contains(name)));
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert!(crate::save::picture(&state, &nothing()).is_none());
}
