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

    /// The ids of the parts with content, by the numbers of their pages.
    fn ids(&mut self, ms: u64) -> Vec<(usize, &'static str)> {
        let state = self.drawer.draw(self.after(ms));
        let shown = state.parts.iter().filter(|drawn| !drawn.part.html.is_empty());
        shown.map(|drawn| (drawn.page, drawn.part.id)).collect()
    }

    /// The content of a part of the first page.
    fn html(&mut self, id: &str, ms: u64) -> String {
        let state = self.drawer.draw(self.after(ms));
        state.since(0, 0).find(|part| part.id == id).unwrap().html.to_string()
    }

    /// Draws: how many samples are in the results that are shown, and when they were drawn.
    fn shown(&mut self, ms: u64) -> (u64, u128) {
        self.drawer.draw(self.after(ms));
        let drawn = self.drawer.sources[0].drawn.as_ref().unwrap();
        (drawn.assessment.samples, drawn.at.duration_since(self.begin).as_millis())
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

const PARTS: [&str; 11] = [
    "now",
    "identity",
    "statuses",
    "allan",
    "parameters",
    "cautions",
    "signal",
    "datasheet",
    "axes",
    "statistics",
    "record",
];

#[test]
fn each_of_several_sources_has_a_page_and_all_of_them_a_list() {
    let mut imu = Watched::new(&["imu"]);
    imu.measure();
    let ids = imu.ids(0);
    assert!(PARTS.iter().all(|id| ids.contains(&(0, id))), "{ids:?}");
    assert!(imu.drawer.html(imu.begin, 0).unwrap().contains("<h1>imu: noise, live</h1>"));
    assert_eq!(imu.drawer.html(imu.begin, 1), None);
    let mut both = Watched::new(&["imu", "other"]);
    both.measure();
    let ids = both.ids(0);
    assert_eq!(ids.iter().filter(|(page, _)| *page == 0).collect::<Vec<_>>(), [&(0, "sources")]);
    assert!(PARTS.iter().all(|id| ids.contains(&(1, id))), "{ids:?}");
    let second: Vec<&str> = ids.iter().filter(|(page, _)| *page == 2).map(|(_, id)| *id).collect();
    assert_eq!(second, ["now", "identity", "allan", "record"], "without samples");
    let list = both.drawer.html(both.begin, 0).unwrap();
    assert!(list.contains("<h1>Noise of 2 sources, live</h1>") && list.contains("<a href=\"2\">other</a>"), "{list}");
    assert!(both.drawer.html(both.begin, 2).unwrap().contains("<h1>other: noise, live</h1>"));
    assert_eq!(both.drawer.html(both.begin, 3), None);
}

#[test]
fn a_page_asked_for_again_within_a_quarter_of_a_second_is_the_same() {
    let mut imu = Watched::new(&["imu"]);
    imu.measure();
    let first = imu.drawer.state(imu.after(0));
    imu.measure();
    assert!(Arc::ptr_eq(&imu.drawer.state(imu.after(249)), &first));
    let next = imu.drawer.state(imu.after(250));
    assert!(next.since(first.version, 0).any(|part| part.id == "now"));
}

/// Of all samples so far each time they are drawn again.
#[test]
fn results_are_drawn_again_after_half_of_the_time_then_twenty_seconds_then_a_twentieth() {
    let mut imu = Watched::new(&["imu"]);
    imu.measure();
    assert_eq!(imu.shown(6000), (3600, 6000));
    imu.measure();
    assert_eq!(imu.shown(11_999), (3600, 6000));
    assert_eq!(imu.shown(12_000), (7200, 12_000));
    imu.measure();
    assert_eq!(imu.shown(60_000), (10_800, 60_000));
    imu.measure();
    assert_eq!(imu.shown(79_999), (10_800, 60_000));
    assert_eq!(imu.shown(80_000), (14_400, 80_000));
    assert_eq!(imu.shown(600_000), (14_400, 600_000));
    assert_eq!((imu.shown(630_000), imu.shown(632_000)), ((14_400, 600_000), (14_400, 632_000)));
    // at the end at once
    imu.measure();
    imu.set(Stage::Ended(Arc::new(End::SourceEnded)), None);
    assert_eq!(imu.shown(632_001), (18_000, 632_001));
    assert_eq!(imu.shown(900_000), (18_000, 632_001));
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
