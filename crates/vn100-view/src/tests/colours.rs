//! What colours mean, and that nothing is lost without them.

use imu_noise::Verdict;
use ratatui::{
    buffer::Buffer,
    style::{Color, Modifier},
};
use vn100_analysis::Point;

use super::{
    damaged, drawn,
    fixture::{linked, lost},
    measured, one,
};
use crate::{
    source::SourceView,
    state::{Panel, ViewState},
    theme::{Colours, Theme},
};

const SIZE: (u16, u16) = (120, 40);

const THEME: Theme = Theme { colours: Colours::Dark, ascii: false };

fn theme(colours: Colours) -> Theme {
    Theme { colours, ascii: false }
}

/// Colour and modifiers of the first cell of a text.
fn style_of(buffer: &Buffer, text: &str) -> (Color, Modifier) {
    let width = usize::from(buffer.area.width);
    for row in buffer.content.chunks(width) {
        let signs: Vec<&str> = row.iter().map(ratatui::buffer::Cell::symbol).collect();
        let place = (0..width).find(|place| signs[*place..].concat().starts_with(text));
        if let Some(place) = place {
            return (row[place].fg, row[place].modifier);
        }
    }
    panic!("no {text:?} on the screen");
}

#[test]
fn good_is_green_and_broken_vermilion() {
    let state = one();
    let show = |mut source: SourceView| {
        source.faults.watch(&source.result.source, source.now);
        drawn(&state, &[source], theme(Colours::Dark), SIZE)
    };
    let [good, warning, error] = [THEME.good(), THEME.warning(), THEME.error()].map(Theme::colour_of);
    assert_eq!(style_of(&show(measured()), "● up").0, good);
    assert_eq!(style_of(&show(linked(measured(), lost("", 0))), "DISCONNECTED").0, error);
    let damaged = show(damaged());
    assert_eq!(style_of(&damaged, "RECORDING FAILED").0, error);
    assert_eq!(style_of(&damaged, "rejected 4").0, warning);
    assert_eq!(style_of(&show(measured()), "rejected 0").0, Color::Reset);
    // the first one too
    let lost = |missing| {
        let mut source = measured();
        (source.result.timing.missing, source.result.timing.missing_at_least) = (Some(missing), missing);
        style_of(&show(source), &format!("dropped {missing}")).0
    };
    assert_eq!((lost(0), lost(1)), (Color::Reset, warning));
}

#[test]
fn an_axis_has_its_colour_and_its_sign_everywhere() {
    for (colours, expected) in [
        (Colours::Dark, [0, 1, 2].map(|axis| Theme::colour_of(THEME.axis(axis)))),
        (Colours::Sixteen, [Color::LightBlue, Color::LightCyan, Color::LightMagenta]),
        (Colours::None, [Color::Reset; 3]),
    ] {
        let state = one();
        let buffer = drawn(&state, &[measured()], theme(colours), SIZE);
        for (axis, sign) in ["● x", "▲ y", "◆ z"].into_iter().enumerate() {
            assert_eq!(style_of(&buffer, sign).0, expected[axis], "{colours:?}");
        }
    }
}

#[test]
fn verdicts_have_the_colour_of_what_they_mean() {
    let mut source = measured();
    let state = ViewState { panel: Panel::Parameters, expanded: true, ..one() };
    let expected = [
        (Some(Verdict::Pass), "pass", theme(Colours::Dark).good()),
        (Some(Verdict::Fail), "FAIL", theme(Colours::Dark).error()),
    ];
    for (verdict, word, style) in expected {
        for channel in source.result.channels.iter_mut().filter(|channel| channel.name.starts_with("gyro")) {
            channel.verdict.iter_mut().flatten().for_each(|figure| figure.verdict = verdict);
        }
        let buffer = drawn(&state, std::slice::from_ref(&source), theme(Colours::Dark), SIZE);
        assert_eq!(style_of(&buffer, word).0, Theme::colour_of(style), "{word}");
        let plain = drawn(&state, std::slice::from_ref(&source), theme(Colours::None), SIZE);
        style_of(&plain, word);
    }
}

#[test]
fn curves_on_each_other_hide_no_sign() {
    let mut source = measured();
    let [first, others @ ..] = &mut source.result.channels[..] else { panic!("no channels") };
    // in the order of the stream the magnetometer and the accelerometer come before
    let curve = first.allan.points.clone();
    let (octaves, known) = (curve.len(), curve.iter().filter(|point| point.is_known()).count());
    others.iter_mut().for_each(|channel| channel.allan.points.clone_from(&curve));
    let buffer = drawn(&one(), std::slice::from_ref(&source), theme(Colours::None), SIZE);
    let signs = |sign: &str| buffer.content.iter().filter(|cell| cell.symbol() == sign).count();
    // once more in the legend, once where the cursor is read out, and the first in the head
    let [discs, triangles, diamonds] = ["●", "▲", "◆"].map(signs);
    assert_eq!([discs - 3, triangles - 2, diamonds - 2], [known; 3], "side by side");
    // twice the octaves have no room for that
    for channel in &mut source.result.channels {
        let longest = channel.allan.points[octaves - 1];
        let at = |octave| Point { tau_s: longest.tau_s * 2_f64.powi(octave), edf: Some(9.0), ..longest };
        let longer = (1..=octaves as i32).map(at);
        channel.allan.points.extend(longer);
    }
    let crowded = drawn(&one(), &[source], theme(Colours::None), SIZE);
    let signs = |sign: &str| crowded.content.iter().filter(|cell| cell.symbol() == sign).count();
    let shown = ["●", "▲", "◆"].map(signs);
    assert!(shown.iter().all(|count| ((octaves + known) / 3..octaves + known).contains(count)), "in turn, {shown:?}");
}

#[test]
fn terminals_get_no_colours_they_do_not_have() {
    for panel in Panel::ALL {
        let state = ViewState { panel, axis: Some(0), ..one() };
        for (colours, allowed) in [
            (Colours::Sixteen, (|color| !matches!(color, Color::Rgb(..) | Color::Indexed(_))) as fn(Color) -> bool),
            (Colours::None, |color| color == Color::Reset),
        ] {
            let buffer = drawn(&state, &[damaged()], theme(colours), SIZE);
            let wrong = buffer.content.iter().find(|cell| !allowed(cell.fg) || !allowed(cell.bg));
            assert_eq!(wrong, None, "{colours:?} {panel:?}");
        }
    }
}

#[test]
fn without_colours_what_is_broken_is_marked() {
    let state = one();
    let buffer = drawn(&state, &[damaged()], theme(Colours::None), SIZE);
    assert!(style_of(&buffer, "RECORDING FAILED").1.contains(Modifier::REVERSED));
    assert!(style_of(&buffer, "rejected 4").1.contains(Modifier::BOLD));
}
