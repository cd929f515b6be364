//! The picture of the README in `stills/`: a measurement of an emulated sensor, replayed. It is drawn
//! again with `VN100_WRITE_STILLS=1 cargo test -p vn100-view stills`; otherwise the picture kept must be
//! the one that is drawn.

use std::{env, fmt::Write, fs, io::Cursor, path::Path, time::Duration};

use ratatui::{
    buffer::{Buffer, Cell},
    layout::Rect,
    style::{Color, Modifier},
};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Settings, SourceFacts};
use vn100_capture::{Capture, CaptureOptions};
use vn100_protocol::stream::ReadOptions;
use vn100_report::Evaluation;
use vn100_session::{Playback, Session, Speed};
use vn100_sim::{Generator, Message, Profile, capture::write_next};

use super::{drawn, nothing, one};
use crate::{
    source::{SourcePhase, SourceView},
    state::ViewState,
    theme::{Colours, Theme},
};

const RATE_HZ: u32 = 40;
const SAMPLES: u64 = 2 * 3600 * RATE_HZ as u64;

/// Columns and rows of a character, in pixels.
const CELL: (f64, f64) = (8.4, 17.0);

/// Two hours in a few seconds: the first picture of the README.
#[test]
fn a_measurement_from_its_beginning() {
    const MINUTES: [f64; 12] = [0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 30.0, 60.0, 90.0, 120.0];
    let mut generator = Generator::new(&Profile::lab3(), RATE_HZ, 1).unwrap();
    let message = Message::named("VNIMU").unwrap();
    let (mut capture, mut written) = (Vec::new(), 0);
    let frames = MINUTES.map(|minutes| {
        let samples = (minutes * 60.0 * f64::from(RATE_HZ)) as u64;
        (written..samples).for_each(|_| write_next(&mut capture, message, &mut generator));
        written = samples;
        let source = replayed(capture.clone(), samples);
        let state = ViewState { axis: Some(1), ..one() };
        drawn(&state, &[source], THEME, (120, 34))
    });
    compare("live", &animated(&frames), 500_000);
}

const THEME: Theme = Theme { colours: Colours::Dark, ascii: false };

/// Keeps the picture if that is asked for, or compares it with the one kept.
fn compare(name: &str, svg: &str, most_bytes: usize) {
    assert!(svg.len() < most_bytes, "{name} takes {} bytes", svg.len());
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("stills").join(format!("{name}.svg"));
    if env::var_os("VN100_WRITE_STILLS").is_some() {
        fs::write(&file, svg).unwrap();
    }
    assert!(fs::read_to_string(&file).unwrap_or_default() == svg, "{name} is not what is drawn");
}

/// A replay that has come so far: to the end of these lines.
fn replayed(capture: Vec<u8>, samples: u64) -> SourceView {
    let settings = Settings { rate_hz: Some(RATE_HZ.into()), recent: true, ..Settings::default() };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let measured = runtime.block_on(async {
        let capture = Capture::from_reader(Cursor::new(capture), &CaptureOptions::default()).unwrap();
        let events = capture.read(ReadOptions::default(), CancellationToken::new()).unwrap();
        Session::of_events(SourceFacts::default(), events, settings).result.await.unwrap().measured
    });
    assert_eq!(measured.timing.samples, samples);
    let mut result = measured.exact();
    Evaluation::new(None, Vec::new(), false).unwrap().judge(&mut result);
    let (total, speed) = (Some(SAMPLES), Speed::Times(10.0));
    let mut source = nothing();
    source.show(result);
    SourceView {
        name: "emulated-2h.vnimu".into(),
        phase: SourcePhase::Measuring,
        elapsed: Duration::from_secs_f64(samples as f64 / f64::from(RATE_HZ) / 10.0),
        playback: Some(Playback { samples, total, speed, paused: false, at_end: samples == SAMPLES }),
        ..source
    }
}

/// Pictures one after the other, the last one if nothing moves.
fn animated(frames: &[Buffer]) -> String {
    let area = frames[0].area;
    const FRAME_S: f64 = 1.0;
    let (total_s, share) = (FRAME_S * frames.len() as f64, 100.0 / frames.len() as f64);
    let rule = format!(
        ".f{{visibility:hidden;animation:s {total_s}s step-end infinite}}.f:last-child{{visibility:visible}}\
         @keyframes s{{0%{{visibility:visible}}{share:.3}%{{visibility:hidden}}}}\
         @media(prefers-reduced-motion){{.f{{animation:none}}}}"
    );
    let frames: String = (frames.iter().enumerate())
        .map(|(place, frame)| {
            // a delay before the first round would show the static state
            let delay_s = FRAME_S * place as f64 - total_s;
            format!("<g class=\"f\" style=\"animation-delay:{delay_s}s\">\n{}</g>\n", rows(frame))
        })
        .collect();
    document(&area, &rule, &frames)
}

fn document(area: &Rect, rule: &str, content: &str) -> String {
    let (width, height) = (f64::from(area.width) * CELL.0, f64::from(area.height) * CELL.1);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\">\n\
         <style>text{{font:14px ui-monospace,Menlo,Consolas,'DejaVu Sans Mono',monospace;white-space:pre;fill:#ddd}}\
         .b{{font-weight:bold}}.r{{fill:#181818}}{rule}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#181818\"/>\n{content}</svg>\n"
    )
}

/// A screen: each row a text, each change of style or of kind of sign placed anew, so that no font
/// moves the columns.
fn rows(buffer: &Buffer) -> String {
    let mut out = String::new();
    for (row, cells) in buffer.content.chunks(usize::from(buffer.area.width)).enumerate() {
        let top = row as f64 * CELL.1;
        let runs = runs(cells);
        for (column, cells) in runs.iter().filter(|(_, cells)| is_reversed(&cells[0])) {
            let (x, width) = (*column as f64 * CELL.0, cells.len() as f64 * CELL.0);
            let fill = colour(cells[0].fg).unwrap_or_else(|| "#ddd".into());
            writeln!(
                out,
                "<rect x=\"{x:.1}\" y=\"{top:.0}\" width=\"{width:.1}\" height=\"{:.0}\" fill=\"{fill}\"/>",
                CELL.1
            )
            .unwrap();
        }
        write!(out, "<text y=\"{:.0}\">", top + 13.0).unwrap();
        for (column, cells) in runs {
            write_run(&mut out, column, cells);
        }
        out.push_str("</text>\n");
    }
    out
}

fn write_run(out: &mut String, column: usize, cells: &[Cell]) {
    let text: String = cells.iter().map(Cell::symbol).collect();
    let text = text.trim_end();
    if text.is_empty() {
        return;
    }
    let (x, length) = (column as f64 * CELL.0, text.chars().count() as f64 * CELL.0);
    write!(out, "<tspan x=\"{x:.1}\" textLength=\"{length:.1}\"").unwrap();
    let bold = cells[0].modifier.contains(Modifier::BOLD).then_some("b");
    let reversed = is_reversed(&cells[0]).then_some("r");
    let classes: Vec<&str> = bold.into_iter().chain(reversed).collect();
    if !classes.is_empty() {
        write!(out, " class=\"{}\"", classes.join(" ")).unwrap();
    }
    if let Some(fill) = colour(cells[0].fg).filter(|_| reversed.is_none()) {
        write!(out, " fill=\"{fill}\"").unwrap();
    }
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    write!(out, ">{text}</tspan>").unwrap();
}

/// Cells of the same looks that stand together, with the column of the first. Spaces look like any.
fn runs(cells: &[Cell]) -> Vec<(usize, &[Cell])> {
    let looks = |cell: &Cell| (cell.fg, cell.modifier, cell.symbol().is_ascii());
    let mut runs = Vec::new();
    let mut begin = 0;
    for place in 1..=cells.len() {
        let same = cells.get(place).is_some_and(|cell| {
            let blank = cell.symbol() == " " && !is_reversed(cell) && !is_reversed(&cells[begin]);
            looks(cell) == looks(&cells[begin]) || (blank && cells[begin].symbol() != " ")
        });
        if !same {
            runs.push((begin, &cells[begin..place]));
            begin = place;
        }
    }
    runs
}

fn is_reversed(cell: &Cell) -> bool {
    cell.modifier.contains(Modifier::REVERSED)
}

/// `None` for the terminal's own.
fn colour(colour: Color) -> Option<String> {
    match colour {
        Color::Rgb(red, green, blue) => Some(format!("#{red:02x}{green:02x}{blue:02x}")),
        _ => None,
    }
}
