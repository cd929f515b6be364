//! Sources that are watched: the words for each, its parts, and when they are drawn again.

use vn100_analysis::End;
use vn100_session::{Playback, Speed};

use super::*;

/// A drawer of sources that the test itself moves on.
struct Watched {
    senders: Vec<watch::Sender<SourceState>>,
    drawer: Drawer,
    begin: Instant,
    analysis: Analysis,
    noise: u64,
}

impl Watched {
    fn new(names: &[&str]) -> Self {
        let settings = Settings { rate_hz: Some(1.0), recent: true, ..Settings::default() };
        let (mut senders, mut sources) = (Vec::new(), Vec::new());
        for name in names {
            let facts = SourceFacts { name: (*name).into(), ..SourceFacts::default() };
            let (sender, state) = watch::channel(SourceState::new(facts, &settings));
            senders.push(sender);
            sources.push(ServedSource { state, goals: Goals::default() });
        }
        let begin = Instant::now();
        Self { senders, drawer: drawer_of(sources, begin), begin, analysis: Analysis::new(settings), noise: 1 }
    }

    fn set(&self, stage: Stage, playback: Option<Playback>) {
        self.senders[0].send_modify(|state| (state.stage, state.playback) = (stage.clone(), playback));
    }

    /// Another hour of samples.
    fn measure(&mut self) {
        let mut batch = hour(&mut self.noise);
        batch.link.tally.samples = self.analysis.snapshot().timing.samples + 3600;
        self.analysis.absorb(&batch);
        let snapshot = Arc::new(self.analysis.snapshot());
        self.senders[0].send_modify(|state| {
            state.stage = Stage::Measuring;
            state.snapshot = Arc::clone(&snapshot);
        });
    }

    fn after(&self, ms: u64) -> Instant {
        self.begin + Duration::from_millis(ms)
    }

    fn health(&self, ms: u64) -> (bool, String) {
        self.drawer.health(self.after(ms))
    }

    fn ids(&mut self, ms: u64) -> Vec<String> {
        self.drawer.draw(self.after(ms)).parts.iter().map(|part| part.part.id.clone()).collect()
    }

    /// The content of a part.
    fn html(&mut self, id: &str, ms: u64) -> String {
        let page = self.drawer.draw(self.after(ms));
        page.parts.iter().find(|part| part.part.id == id).unwrap().part.html.to_string()
    }

    /// Draws: how many samples are in the results that are shown, and when they and the signal were
    /// drawn.
    fn shown(&mut self, ms: u64) -> (u64, u128, u128) {
        self.drawer.draw(self.after(ms));
        let source = &self.drawer.sources[0];
        let (results, signal) = (source.results.as_ref().unwrap(), source.signal.as_ref().unwrap());
        let since = |at: Instant| at.duration_since(self.begin).as_millis();
        (results.assessment.samples, since(results.at), since(signal.0))
    }
}

fn replay(paused: bool, at_end: bool) -> Option<Playback> {
    Some(Playback { samples: 10, total: Some(10), speed: Speed::Max, paused, at_end })
}

#[test]
fn a_source_is_healthy_while_it_gives_samples() {
    let mut imu = Watched::new(&["imu"]);
    let line = |is_healthy: bool, word: &str| (is_healthy, format!("imu: {word}\n"));
    assert_eq!(imu.health(9000), line(false, "preparing"));
    imu.set(Stage::Measuring, None);
    assert_eq!(imu.health(2999), line(true, "measuring"));
    assert_eq!(imu.health(3000), line(false, "no sample for 3 s"));
    assert_eq!(imu.health(4999), line(false, "no sample for 4 s"));
    imu.measure();
    imu.drawer.look(imu.after(5000));
    assert_eq!(imu.health(7999), line(true, "measuring"));
    assert_eq!(imu.health(8000), line(false, "no sample for 3 s"));
    // nothing is to come in these
    imu.set(Stage::Measuring, replay(true, false));
    assert_eq!(imu.health(60_000), line(true, "measuring"));
    imu.set(Stage::Measuring, replay(false, true));
    assert_eq!(imu.health(60_000), line(true, "replayed to its end"));
    imu.set(Stage::Finishing, None);
    assert_eq!(imu.health(60_000), line(true, "measuring"));
    imu.set(Stage::Ended(Arc::new(End::SourceEnded)), None);
    assert_eq!(imu.health(60_000), line(false, "ended"));
}

#[test]
fn one_source_that_gives_no_samples_is_enough() {
    let both = Watched::new(&["imu", "other"]);
    both.set(Stage::Measuring, None);
    assert_eq!(both.health(0), (false, "imu: measuring\nother: preparing\n".into()));
}

const PARTS: [&str; 12] = [
    "now",
    "identity",
    "verdicts",
    "cautions",
    "allan",
    "parameters",
    "datasheet",
    "axes",
    "spectrum",
    "statistics",
    "marks",
    "signal",
];

#[test]
fn the_parts_of_several_sources_differ_by_a_prefix() {
    let mut imu = Watched::new(&["imu"]);
    imu.measure();
    assert_eq!(imu.ids(0), [&["sources"], &PARTS[..]].concat());
    let mut both = Watched::new(&["imu", "other"]);
    both.measure();
    let ids = both.ids(0);
    let of = |prefix: &str| PARTS.map(|name| format!("{prefix}{name}"));
    assert_eq!((&*ids[0], &ids[1..13]), ("sources", &of("run1-")[..]));
    let (mut second, mut expected) = (ids[13..].to_vec(), of("run2-").to_vec());
    // one without samples has them in another order
    second.sort_unstable();
    expected.sort_unstable();
    assert_eq!(second, expected);
}

#[test]
fn a_page_asked_for_again_within_a_quarter_of_a_second_is_the_same() {
    let mut imu = Watched::new(&["imu"]);
    imu.measure();
    let first = imu.drawer.page(imu.after(0));
    imu.measure();
    assert!(Arc::ptr_eq(&imu.drawer.page(imu.after(249)), &first));
    let changed: Vec<_> = imu.drawer.page(imu.after(250)).since(first.version()).map(|part| part.id.clone()).collect();
    assert!(changed.contains(&"now".to_owned()), "{changed:?}");
}

/// Of all samples so far each time they are drawn again: at first after a third of the time.
#[test]
fn results_and_signal_are_drawn_again_after_a_third_of_the_time_and_then_every_ten_seconds() {
    let mut imu = Watched::new(&["imu"]);
    imu.measure();
    assert_eq!(imu.shown(6000), (3600, 6000, 6000));
    imu.measure();
    assert_eq!(imu.shown(8999), (3600, 6000, 6000));
    assert_eq!(imu.shown(9000), (7200, 9000, 9000));
    imu.measure();
    assert_eq!(imu.shown(60_000), (10_800, 60_000, 60_000));
    imu.measure();
    assert_eq!(imu.shown(69_999), (10_800, 60_000, 60_000));
    assert_eq!(imu.shown(70_000), (14_400, 70_000, 70_000));
    // at the end at once, and the signal at every look from then on
    imu.measure();
    imu.set(Stage::Ended(Arc::new(End::SourceEnded)), None);
    assert_eq!(imu.shown(70_001), (18_000, 70_001, 70_001));
    assert_eq!(imu.shown(70_002), (18_000, 70_001, 70_002));
}

#[test]
fn the_page_says_why_a_source_has_ended() {
    let mut imu = Watched::new(&["imu"]);
    imu.set(Stage::Ended(Arc::new(End::SourceFailed("it was unplugged".into()))), None);
    let now = imu.html("now", 0);
    assert!(now.contains("ENDED") && now.contains("<p class=\"warning problem\">imu: it was unplugged</p>"), "{now}");
    let document = imu.drawer.documents(imu.after(0));
    assert!(std::str::from_utf8(&document).unwrap().contains("\"imu\""));
}
