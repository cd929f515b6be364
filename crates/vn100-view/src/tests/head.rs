//! What stands above the panels: the goals, what is broken, warnings and notices.

use std::{sync::Arc, time::Duration};

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use vn100_analysis::{Settings, Severity, SourceResult};
use vn100_report::{goals::Goals, summary::Summary};
use vn100_session::{Command, Session};

use super::{
    PLAIN, SIZES, damaged, drawn,
    fixture::{linked, lost, short},
    measured, one, text,
};
use vn100_report::remedies::remedy_words;

use crate::{
    source::{SourceMonitor, SourceView},
    state::{Panel, ViewState},
};

fn screen(state: &ViewState, source: &SourceView, size: (u16, u16)) -> String {
    text(&drawn(state, std::slice::from_ref(source), PLAIN, size))
}

fn with_goals(duration_s: Option<u64>, until: &[&str]) -> SourceView {
    let until = until.iter().map(|goal| goal.parse().unwrap()).collect();
    let goals = Goals { duration: duration_s.map(Duration::from_secs), wall: None, until };
    SourceView { goals: Arc::new(goals), ..measured() }
}

#[test]
fn a_single_gap_is_one_gap() {
    for (gaps, shown) in [(1, "dropped 3 in 1 gap  "), (2, "dropped 3 in 2 gaps  ")] {
        let mut source = measured();
        let timing = &mut source.result.timing;
        (timing.missing, timing.missing_at_least, timing.gaps) = (Some(3), 3, gaps);
        let screen = screen(&one(), &source, (200, 60));
        assert!(screen.contains(shown), "{screen}");
    }
}

#[test]
fn the_goal_and_the_time_until_it_are_shown_at_every_size() {
    for (duration_s, until, shown) in [
        (Some(1200), &[][..], "goal: 8 min 20 s of 20 min, 11 min 40 s more"),
        (Some(500), &[], "goal: 8 min 20 s of 8 min 20 s"),
        (None, &["gyro N ±0.5%"], "goal: gyro N ±1.1 % of ±0.5 %, about 33 min more"),
        (None, &["gyro N ±3%"], "goal: gyro N ±1.1 % of ±3 %, reached"),
        (None, &["gyro K ±3%"], "goal: gyro K ±3 %: not estimated yet"),
        (Some(1200), &["gyro N ±3%"], "goal: 8 min 20 s of 20 min, 11 min 40 s more"),
        (Some(1200), &["gyro N ±0.5%"], "gyro N ±1.1 % of ±0.5 %, about 33 min more"),
        (None, &["gyro N ±0.5%", "accel N ±0.5%"], "gyro N ±1.1 % of ±0.5 %, about 33 min more"),
        (None, &["gyro N ±0.5%", "accel K ±0.5%"], "accel K ±0.5 %: not estimated yet"),
    ] {
        let source = with_goals(duration_s, until);
        for size in SIZES {
            let screen = screen(&one(), &source, size);
            assert!(screen.contains(shown), "{shown} at {size:?}:\n{screen}");
        }
    }
    let goals = Goals { wall: Some(Duration::from_secs(1200)), ..Goals::default() };
    let source = SourceView { goals: Arc::new(goals), now: Duration::from_secs(500), ..measured() };
    for size in SIZES {
        let screen = screen(&one(), &source, size);
        assert!(screen.contains("goal: by the clock 8 min 20 s of 20 min, 11 min 40 s more"), "{size:?}:\n{screen}");
    }
    assert!(!screen(&one(), &measured(), (80, 24)).contains("goal:"));
}

#[test]
fn values_and_units_below_the_curve_are_whole_at_every_width() {
    for source in [short(40), short(300), short(1500), damaged(), measured()] {
        let summary = Summary::new(&source.result, remedy_words);
        let row = &summary.sensors[0].rows[0];
        for width in 60..=200 {
            let state = ViewState { panel: Panel::Allan, expanded: true, ..one() };
            let screen = screen(&state, &source, (width, 24));
            let line = screen.lines().find(|line| line.starts_with("│ N  ")).unwrap().trim_matches('│').trim_end();
            assert!(line.ends_with(row.unit) && row.cells.iter().all(|cell| line.contains(cell)), "{width}\n{screen}");
        }
    }
}

/// In the panel of a whole screen and in that of many, and the drift in one line.
#[test]
fn the_noise_panel_has_the_rows_of_the_summary() {
    let source = measured();
    let summary = Summary::new(&source.result, remedy_words);
    for (state, size) in [(ViewState { panel: Panel::Parameters, ..one() }, (80, 40)), (one(), (200, 60))] {
        let screen = screen(&state, &source, size);
        for row in &summary.sensors[0].rows {
            let is_shown =
                |line: &str| line.contains(row.short_label) && row.cells.iter().all(|cell| line.contains(cell));
            assert!(row.cells.is_empty() || screen.lines().any(is_shown), "{row:?}\n{screen}");
            let Some((figure, verdict)) = &row.figure else { continue };
            assert!(screen.contains(&format!("data sheet: {figure} ")) && screen.contains(&verdict.word), "{screen}");
        }
        assert!(screen.contains("drift: 95 % of heading errors (gyro_z) within "), "{screen}");
    }
}

#[test]
fn the_noise_panel_leaves_out_values_last() {
    let state = ViewState { panel: Panel::Parameters, ..one() };
    let source = with_goals(None, &["gyro N ±0.5%"]);
    let screen = screen(&state, &source, (60, 20));
    for letter in ["N", "B", "K"] {
        let named = |line: &&str| line.starts_with("│ ") && line.contains(&format!(" {letter} "));
        let mut rows = screen.lines().skip_while(|line| !named(line));
        let has_value = rows
            .by_ref()
            .take(2)
            .any(|row| row.contains(|c: char| c.is_ascii_digit()) || row.contains("not observable"));
        assert!(has_value, "{letter}\n{screen}");
    }
    assert!(screen.contains(" more lines: on a larger screen"), "{screen}");
}

#[test]
fn a_recording_that_failed_is_said_whole_at_every_width() {
    let mut source = damaged();
    let result = &mut source.result;
    (result.timing.excluded, result.timing.samples, result.link.reconnects) = (400_000, 1_000_000_000, 123);
    for width in 60..=200 {
        let screen = screen(&one(), &source, (width, 24));
        assert!(screen.lines().nth(2).unwrap().contains("RECORDING FAILED"), "{width}\n{screen}");
    }
}

#[test]
fn what_was_counted_is_whole_or_left_out_at_every_width() {
    let whole = ["RECORDING FAILED", "rec", "recorded flight.mcap", "not recorded"];
    for (place, width) in (0..40_u64).flat_map(|place| (60..=110).map(move |width| (place, width))) {
        let mut source = measured();
        let SourceResult { timing, link, .. } = &mut source.result;
        // of every number of digits, beside each other
        let count = |salt: u64| (place.wrapping_mul(salt) % 7).pow((1 + place % 7) as u32);
        (timing.samples, timing.pending, timing.excluded) = (1 + count(97), count(31), place % 2 * count(61));
        (timing.missing, timing.missing_at_least) = (Some(count(11)), count(11));
        (link.rejected.checksum, link.reconnects) = (count(13), 1 + place % 3);
        let screen = screen(&one(), &source, (width, 24));
        let line = screen.lines().nth(2).unwrap();
        let last = line.rsplit("  ").next().unwrap();
        let is_number = last.split(' ').next_back().unwrap().chars().all(|sign| sign.is_ascii_digit());
        let is_whole = whole.contains(&last) || is_number || last.ends_with("iB") || last.ends_with("°C");
        assert!(is_whole && line.chars().count() <= usize::from(width), "{width}: {line:?}");
        assert!(width < 80 || ![0, 2, 4].contains(&place) || line.contains("2.40 MiB"), "{width}: {line:?}");
    }
}

#[test]
fn a_warning_that_has_no_room_says_so() {
    let kept = damaged();
    for (warning, height) in (0..kept.warnings.len()).flat_map(|warning| (16..30).map(move |height| (warning, height)))
    {
        let state = ViewState { panel: Panel::Warnings, warning, ..one() };
        let screen = screen(&state, &kept, (60, height));
        let faults = kept.faults.all().len();
        let Some(chosen) = warning.checked_sub(faults).map(|place| &kept.warnings[place]) else { continue };
        let text = vn100_report::warnings::in_words(chosen, remedy_words);
        let last = text.split_whitespace().next_back().unwrap();
        assert!(screen.contains(last) || screen.contains("on a larger screen"), "{height} {last}\n{screen}");
    }
}

#[test]
fn what_is_broken_is_never_cut_and_listed_first() {
    let cause = "opening /dev/serial/by-id/usb-FTDI_USB_Serial_Converter_A50285BI-if00-port0 failed: gone";
    let mut source = linked(damaged(), lost(cause, 4));
    source.faults.watch(&source.result.source, source.now - Duration::from_secs(12));
    for size in SIZES {
        let above = screen(&one(), &source, size);
        let words: String = above.split_whitespace().collect();
        for shown in ["!!DISCONNECTEDfor12s,attempt4:opening/dev/serial", "failed:gone", "RECORDINGFAILEDfor1min3s"] {
            assert!(words.contains(shown), "{shown} at {size:?}:\n{above}");
        }
        let mut state = one();
        state.key(KeyEvent::new(KeyCode::Char('!'), KeyModifiers::NONE), std::slice::from_ref(&source));
        let panel = screen(&ViewState { expanded: true, ..state }, &source, size);
        for shown in ["fault    DISCONNECTED", "attempt 4", "fault    RECORDING FAILED"] {
            // the rows above leave room for one
            if size.1 < 24 && shown.ends_with("FAILED") {
                continue;
            }
            assert!(panel.contains(shown), "{shown} at {size:?}:\n{panel}");
        }
    }
}

#[test]
fn notices_have_one_row() {
    let row = "note: compensated-stream   ! reads";
    assert_eq!(screen(&one(), &damaged(), (80, 24)).matches(row).count(), 1);
}

#[test]
fn warnings_stand_by_their_severity() {
    let severities: Vec<Severity> = damaged().warnings.iter().map(|warning| warning.severity).collect();
    assert!(severities.is_sorted() && severities.contains(&Severity::Note));
    let state = ViewState { panel: Panel::Warnings, expanded: true, ..one() };
    let screen = screen(&state, &damaged(), (80, 24));
    let place = |name: &str| screen.find(name).unwrap_or_else(|| panic!("{name}\n{screen}"));
    assert!(place("fault    REC") < place("caution  gaps") && place("caution  gaps") < place("note     comp"));
}

#[test]
fn one_unit_for_a_sensor_on_all_panels() {
    let screen = screen(&one(), &measured(), (120, 40));
    for shown in ["of the gyro, deg/h ─", "Signal of gyro_x, deg/h ─", "gyro_x      deg/h"] {
        assert!(screen.contains(shown), "{shown}\n{screen}");
    }
}

#[test]
fn the_data_sheet_has_its_line_in_the_plot() {
    let with = screen(&one(), &measured(), (80, 24));
    assert!(with.contains("data sheet"), "{with}");
    let mut source = measured();
    source.result.channels.iter_mut().for_each(|channel| channel.verdict = None);
    assert!(!screen(&one(), &source, (80, 24)).contains("data sheet"));
}

#[tokio::test(start_paused = true)]
async fn the_elapsed_time_begins_anew_with_the_measurement() {
    let (events, inbox) = tokio::sync::mpsc::channel(4);
    let session = Session::of_events(vn100_analysis::SourceFacts::default(), inbox, Settings::default());
    let mut monitor = SourceMonitor::of(&session, Goals::default());
    let mut state = session.state.clone();
    state.wait_for(|state| matches!(state.stage, vn100_session::Stage::Measuring)).await.unwrap();
    let evaluation = vn100_report::Evaluation::new(None, Vec::new(), false).unwrap();
    let elapsed_s = |monitor: &mut SourceMonitor, now_s| {
        monitor.look(Duration::from_secs(now_s), &evaluation);
        monitor.shown.elapsed.as_secs()
    };
    assert_eq!(elapsed_s(&mut monitor, 10), 10);
    assert_eq!(monitor.command(Command::EndWarmUp), None);
    assert_eq!(elapsed_s(&mut monitor, 11), 11);
    assert_eq!(monitor.command(Command::StartOver), None);
    assert_eq!(elapsed_s(&mut monitor, 13), 2);
    drop(events);
}
