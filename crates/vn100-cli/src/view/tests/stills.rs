//! The stills in `stills/`: screens of two hours of an emulated sensor, replayed. They are drawn
//! anew with `VN100_WRITE_STILLS=1 cargo test -p vn100-cli stills`; otherwise those kept must be
//! what is drawn.

use std::{
    env,
    fmt::Write,
    fs,
    io::Cursor,
    path::Path,
    sync::{Arc, OnceLock},
    time::Duration,
};

use ratatui::{
    buffer::{Buffer, Cell},
    style::{Color, Modifier},
};
use tokio_util::sync::CancellationToken;
use vn100_analysis::{Assessment, Settings, SourceFacts};
use vn100_capture::{Capture, CaptureOptions};
use vn100_pipeline::{Playback, Session, Speed};
use vn100_protocol::stream::ReadOptions;
use vn100_report::{Asked, Evaluation};
use vn100_sim::{Generator, Message, Profile, write_capture};

use super::{drawn, nothing, one};
use crate::view::{
    source::{SourcePhase, SourceView},
    state::{Panel, ShownAxes, ViewState},
    theme::{Colours, Theme},
};

const RATE_HZ: u32 = 40;
const SAMPLES: u64 = 2 * 3600 * RATE_HZ as u64;

/// Room that a still may take where it is kept.
const MOST_BYTES: usize = 60_000;

/// Columns and rows of a character, in pixels.
const CELL: (f64, f64) = (8.4, 17.0);

#[test]
fn every_panel() {
    check("all-panels", &ViewState { axes: ShownAxes::One(1), ..one() }, (120, 40));
}

#[test]
fn the_curves_of_all_axes() {
    check("allan", &ViewState { expanded: true, ..one() }, (100, 30));
}

#[test]
fn a_small_terminal() {
    check("warnings-80x24", &ViewState { panel: Panel::Warnings, ..one() }, (80, 24));
}

fn check(name: &str, state: &ViewState, size: (u16, u16)) {
    let theme = Theme { colours: Colours::True, ascii: false };
    let (buffer, _) = drawn(state, &[emulated()], theme, size);
    let svg = svg(&buffer);
    assert!(svg.len() < MOST_BYTES, "{name} takes {} bytes", svg.len());
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("stills").join(format!("{name}.svg"));
    if env::var_os("VN100_WRITE_STILLS").is_some() {
        fs::write(&file, &svg).unwrap();
    }
    assert!(fs::read_to_string(&file).unwrap_or_default() == svg, "{name} is not what is drawn");
}

/// A replay that has come to its end.
fn emulated() -> SourceView {
    static MADE: OnceLock<SourceView> = OnceLock::new();
    MADE.get_or_init(|| {
        let mut generator = Generator::new(&Profile::named("lab3").unwrap(), RATE_HZ, 1).unwrap();
        let mut capture = Vec::new();
        write_capture(&mut capture, &mut generator, Message::named("VNIMU").unwrap(), SAMPLES).unwrap();
        let settings = Settings { rate_hz: Some(RATE_HZ.into()), recent: true, ..Settings::default() };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let snapshot = runtime.block_on(async {
            let capture = Capture::from_reader(Cursor::new(capture), &CaptureOptions::default()).unwrap();
            let events = capture.read(ReadOptions::default(), CancellationToken::new()).unwrap();
            Session::of_events(SourceFacts::default(), events, settings).result.await.unwrap().snapshot
        });
        assert_eq!(snapshot.timing.samples, SAMPLES);
        let assessment = Assessment::new(&snapshot, 0.95);
        let verdicts = Evaluation::new(None, Asked::default(), false).unwrap().verdicts(&snapshot, &assessment);
        let (total, speed) = (Some(SAMPLES), Speed::Times(10.0));
        let mut source = nothing();
        source.show(snapshot, Arc::new(assessment));
        SourceView {
            name: "emulated-2h.vnimu".into(),
            phase: SourcePhase::Measuring,
            verdicts,
            elapsed: Duration::from_secs(720),
            playback: Some(Playback { samples: SAMPLES, total, speed, paused: false, at_end: true }),
            ..source
        }
    })
    .clone()
}

/// A screen as a picture: each row a text, each change of style or of kind of sign placed anew, so
/// that no font moves the columns.
fn svg(buffer: &Buffer) -> String {
    let (columns, rows) = (f64::from(buffer.area.width), f64::from(buffer.area.height));
    let (width, height) = (columns * CELL.0, rows * CELL.1);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\">\n\
         <style>text{{font:14px ui-monospace,Menlo,Consolas,'DejaVu Sans Mono',monospace;white-space:pre;fill:#ddd}}\
         .b{{font-weight:bold}}.r{{fill:#181818}}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#181818\"/>\n"
    );
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
    out + "</svg>\n"
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
