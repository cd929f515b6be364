//! Sources made of fixed numbers.

use std::{
    sync::{Arc, OnceLock},
    time::Duration,
};

use vn100_analysis::timebase::{Arrivals, NominalRate, TimebaseSummary};
use vn100_analysis::{
    Analysis, Assessment, LinkFacts, LinkStatus, MissingFrom, Parts, RateFrom, RecorderFacts, Settings, Snapshot,
    SourceFacts, SourceResult,
};
use vn100_protocol::stream::{Batch, Mark, MarkKind, StreamCounts};
use vn100_protocol::{Layout, Register, RegisterContents, RegisterFields, VNIMU, VNYMR};
use vn100_report::Evaluation;

use crate::source::{SourcePhase, SourceView};

const SAMPLES: usize = 20_000;

/// A source of which nothing is known.
pub(super) fn nothing() -> SourceView {
    let snapshot = Analysis::new(Settings::default()).snapshot();
    let facts = SourceFacts { name: "/dev/ttyUSB0".into(), kind: Some("serial"), ..SourceFacts::default() };
    let source = SourceView::new("/dev/ttyUSB0".into(), result(facts, snapshot, 0.95));
    SourceView { elapsed: Duration::from_secs(2), ..source }
}

/// The result of a snapshot with intervals of this level.
pub(super) fn result(facts: SourceFacts, snapshot: Snapshot, confidence: f64) -> SourceResult {
    let snapshot = Arc::new(snapshot);
    let assessment = Arc::new(Assessment::new(&snapshot, confidence));
    SourceResult::new(facts, snapshot, assessment, Parts::All)
}

/// A link at 115200 baud.
pub(super) fn link(status: LinkStatus) -> LinkFacts {
    LinkFacts { status, port: Some("/dev/ttyUSB0".into()), baud: Some(115_200), ..LinkFacts::default() }
}

/// A link that was lost, after so many attempts.
pub(super) fn lost(cause: &str, attempts: u32) -> LinkFacts {
    LinkFacts { status: LinkStatus::Lost, cause: Some(cause.into()), attempts, ..LinkFacts::default() }
}

/// The source with another link.
pub(super) fn linked(mut source: SourceView, link: LinkFacts) -> SourceView {
    source.result.source.link = Some(link);
    source
}

/// Five hundred seconds of white noise from a sensor without its filter, recorded.
pub(crate) fn measured() -> SourceView {
    static MADE: OnceLock<SourceView> = OnceLock::new();
    MADE.get_or_init(|| {
        let mut analysis = Analysis::new(settings());
        analysis.absorb(&batch(&VNIMU, SAMPLES, &[]));
        source(analysis.snapshot())
    })
    .clone()
}

/// Its first rows: the fewer, the wider the intervals, and the less alike their sides.
pub(super) fn short(rows: usize) -> SourceView {
    let mut analysis = Analysis::new(settings());
    analysis.absorb(&batch(&VNIMU, rows, &[]));
    source(analysis.snapshot())
}

/// The same time of a compensated stream, with rejected sentences and gaps, and a
/// failed recording.
pub(crate) fn damaged() -> SourceView {
    static MADE: OnceLock<SourceView> = OnceLock::new();
    MADE.get_or_init(|| {
        let mut analysis = Analysis::new(settings());
        let mut batch = batch(&VNYMR, SAMPLES, &[500, 501, 8000, 15_000]);
        batch.link.tally.rejected.checksum = 3;
        batch.link.tally.rejected.truncated = 1;
        batch.registers.push(RegisterContents {
            register: Register(85),
            fields: RegisterFields::new("0,4,4,4,0,0,3,3,3,0").unwrap(),
        });
        analysis.absorb(&batch);
        let now = Duration::from_secs(503);
        let mut damaged = SourceView { name: "/dev/ttyUSB1".into(), now, ..source(analysis.snapshot()) };
        let facts = &mut damaged.result.source;
        facts.recorder.as_mut().unwrap().error = Some("no space left on the device".into());
        damaged.faults.watch(facts, Duration::from_secs(440));
        damaged
    })
    .clone()
}

fn settings() -> Settings {
    Settings { rate_hz: Some(40.0), recent: true, ..Settings::default() }
}

fn source(mut snapshot: Snapshot) -> SourceView {
    (snapshot.timing.rate_from, snapshot.timing.missing_from) = (RateFrom::Device, MissingFrom::Arrival);
    snapshot.arrivals = Some(TimebaseSummary {
        samples: SAMPLES as u64,
        backwards: 0,
        nominal: Some(NominalRate::Known(40.0)),
        measured_hz: Some(40.0003),
        offset_ppm: Some(7.5),
        refusal: None,
        missing: 0,
        gaps: 0,
        unevenness: None,
        flushed: 0,
        arrivals: Some(Arrivals {
            p50_us: 25_000,
            p99_us: 26_100,
            max_us: 31_234,
            share_together: 0.0,
            samples_together: 1.0,
        }),
    });
    let path = "bench/flight.mcap".to_owned();
    let recorder = Some(RecorderFacts { path, bytes: 2_512_345, ..RecorderFacts::default() });
    let mut source = nothing();
    let link = Some(link(LinkStatus::Connected));
    let facts = SourceFacts { link, recorder, ..source.result.source.clone() };
    let mut result = result(facts, snapshot, 0.95);
    Evaluation::new(None, Vec::new(), false).unwrap().judge(&mut result);
    source.show(result);
    SourceView { phase: SourcePhase::Measuring, elapsed: Duration::from_secs(503), ..source }
}

/// White noise in every channel, with rejected sentences before these rows.
fn batch(layout: &Layout, rows: usize, bad_before: &[usize]) -> Batch {
    let mut state = 1_u64;
    let mut noise = || {
        // Knuth's constants; the sum of four is near enough to normal
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as i64 % 1001 - 500
        };
        (0..4).map(|_| uniform()).sum::<i64>()
    };
    let mut counts = Vec::with_capacity(rows * layout.channels.len());
    for row in 0..rows {
        for (place, channel) in layout.channels.iter().enumerate() {
            // a mean and a spread that suit what is measured, and a slow change in one
            let (mean, spread) = match (channel.name.as_ref(), channel.decimals) {
                ("accel_z", 3) => (-9_807, 40),
                ("mag_x", _) => (2_100, 20),
                ("mag_z", _) => (4_300, 20),
                ("temperature", _) => (225 + row as i64 / 4000, 1),
                ("pressure", _) => (101_325, 3),
                (_, 6) => (15, 600 + 100 * (place as i64 % 3)),
                _ => (0, 15),
            };
            counts.push((mean + noise() * spread / 600) as i32);
        }
    }
    let mut link = StreamCounts { connects: 1, ..StreamCounts::default() };
    link.tally.samples = rows as u64;
    link.tally.valid_sentence_bytes = 122 * rows as u64;
    let marks = bad_before.iter().map(|row| Mark { before_row: *row, kind: MarkKind::Rejected });
    Batch { layout: Some(Arc::new(layout.clone())), counts, marks: marks.collect(), link, ..Batch::default() }
}
