//! A capture at the pace of the sensor: held back by the clock, let go at once, or stopped, as
//! whoever watches wants it.

use std::time::Duration;

use tokio::{
    sync::{mpsc, watch},
    time::{Instant, sleep_until},
};
use tokio_util::sync::CancellationToken;
use vn100_capture::{End, Event};

/// Events that may wait for the analysis; a full queue holds the pace back.
const WAITING_EVENTS: usize = 4;

/// Rates of replay one steps through, in seconds of data a second; behind the last one it is as
/// fast as the machine can.
const STEPS: [f64; 10] = [0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 100.0, 300.0, 1000.0];

/// How fast a capture is replayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Speed {
    /// So many seconds of data in a second; above 0.
    Times(f64),
    /// As fast as the machine can.
    Max,
}

impl std::str::FromStr for Speed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let times = text.strip_suffix('x').and_then(|times| times.parse::<f64>().ok());
        match times {
            _ if text == "max" => Ok(Self::Max),
            Some(times) if (1e-3..=1e6).contains(&times) => Ok(Self::Times(times)),
            _ => Err("neither \"max\" nor a speed such as \"1x\" or \"10x\"".into()),
        }
    }
}

impl Speed {
    fn next(self, faster: bool) -> Self {
        match (self, faster) {
            (Self::Max, true) => Self::Max,
            (Self::Max, false) => Self::Times(STEPS[STEPS.len() - 1]),
            (Self::Times(now), true) => STEPS.into_iter().find(|step| *step > now).map_or(Self::Max, Self::Times),
            (Self::Times(now), false) => {
                Self::Times(STEPS.into_iter().rev().find(|step| *step < now).unwrap_or(STEPS[0]))
            }
        }
    }
}

/// Where a replay is, and how it goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// Samples replayed.
    pub rows: u64,
    /// How fast it goes on.
    pub speed: Speed,
    /// It stands still.
    pub paused: bool,
    /// Nothing more comes: the capture was replayed to its end, or as much of it as was to be
    /// measured.
    pub at_end: bool,
}

/// What a replay may be asked for while it runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PaceWish {
    /// Stops it where it is, or lets it go on.
    PauseOrGoOn,
    /// A second of data more.
    Step,
    /// The next higher speed.
    Faster,
    /// The next lower speed.
    Slower,
    /// As fast as possible until so many samples are replayed.
    RunTo(u64),
}

/// When the next sample is due. Pure: the time comes in.
#[derive(Debug)]
struct Pace {
    rate_hz: f64,
    position: Position,
    /// From when on, and from which sample, the clock runs.
    since: (Instant, u64),
    /// Samples up to here are due at once.
    run_to: u64,
}

/// What is to be waited for before the next sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Due {
    Now,
    At(Instant),
    /// Nothing but a wish.
    Never,
}

impl Pace {
    fn new(rate_hz: f64, position: Position, run_to: u64, now: Instant) -> Self {
        Self { rate_hz, position, since: (now, position.rows), run_to }
    }

    fn due(&self) -> Due {
        let Position { rows, speed, paused, .. } = self.position;
        match speed {
            _ if rows < self.run_to => Due::Now,
            _ if paused => Due::Never,
            Speed::Max => Due::Now,
            Speed::Times(times) => {
                let data_s = (rows - self.since.1) as f64 / self.rate_hz;
                let wait = Duration::try_from_secs_f64(data_s / times).unwrap_or(Duration::MAX);
                self.since.0.checked_add(wait).map_or(Due::Never, Due::At)
            }
        }
    }

    fn passed(&mut self, rows: u64, now: Instant) {
        self.position.rows += rows;
        if self.position.rows <= self.run_to {
            self.since = (now, self.position.rows);
        }
    }

    fn obey(&mut self, wish: PaceWish, now: Instant) {
        let position = &mut self.position;
        match wish {
            PaceWish::PauseOrGoOn | PaceWish::Step | PaceWish::RunTo(_) if position.at_end => {}
            PaceWish::PauseOrGoOn => position.paused = !position.paused,
            PaceWish::Step => {
                position.paused = true;
                self.run_to = position.rows + self.rate_hz.ceil() as u64;
            }
            PaceWish::Faster => position.speed = position.speed.next(true),
            PaceWish::Slower => position.speed = position.speed.next(false),
            PaceWish::RunTo(rows) => self.run_to = rows,
        }
        self.since = (now, position.rows);
    }

    /// The samples come at another rate than was thought.
    fn set_rate(&mut self, rate_hz: f64, now: Instant) {
        if rate_hz != self.rate_hz {
            self.rate_hz = rate_hz;
            self.since = (now, self.position.rows);
        }
    }
}

/// Where a replay begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beginning {
    /// How fast.
    pub speed: Speed,
    /// Standing still.
    pub paused: bool,
    /// So many samples come at once.
    pub run_to: u64,
}

/// The events of a capture, each sample when it is due by the rate of the moment, and where that
/// is. They end with the capture, or on `stop`; the speed may be chosen behind the end too.
///
/// # Panics
/// Outside a tokio runtime with time enabled.
#[must_use]
pub fn paced(
    mut events: mpsc::Receiver<Event>,
    mut wishes: mpsc::Receiver<PaceWish>,
    rate_hz: watch::Receiver<f64>,
    beginning: Beginning,
    stop: CancellationToken,
) -> (mpsc::Receiver<Event>, watch::Receiver<Position>) {
    let Beginning { speed, paused, run_to } = beginning;
    let (sender, paced) = mpsc::channel(WAITING_EVENTS);
    let first = Position { rows: 0, speed, paused, at_end: false };
    let (told, position) = watch::channel(first);
    tokio::spawn(async move {
        let mut pace = Pace::new(*rate_hz.borrow(), first, run_to, Instant::now());
        while let Some(event) = events.recv().await {
            let rows = if let Event::Batch(batch) = &event { batch.row_count() as u64 } else { 0 };
            pace.set_rate(*rate_hz.borrow(), Instant::now());
            loop {
                let due = if rows == 0 { Due::Now } else { pace.due() };
                let wait = async {
                    match due {
                        Due::Now => {}
                        Due::At(time) => sleep_until(time).await,
                        Due::Never => std::future::pending().await,
                    }
                };
                tokio::select! {
                    // a wish that came in time counts
                    biased;
                    () = stop.cancelled() => {
                        // whoever measures may have left
                        let _ = sender.send(Event::End(End { error: None, csv: None })).await;
                        return;
                    }
                    Some(wish) = wishes.recv() => {
                        pace.obey(wish, Instant::now());
                        told.send_replace(pace.position);
                    }
                    () = wait => break,
                }
            }
            pace.position.at_end = matches!(event, Event::End(_));
            if sender.send(event).await.is_err() {
                // whoever measures has enough
                pace.position.at_end = true;
                told.send_replace(pace.position);
                break;
            }
            pace.passed(rows, Instant::now());
            told.send_replace(pace.position);
        }
        drop(sender);
        while let Some(wish) = wishes.recv().await {
            pace.obey(wish, Instant::now());
            told.send_replace(pace.position);
        }
    });
    (paced, position)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vn100_protocol::VNYMR;
    use vn100_protocol::stream::Batch;

    const RATE_HZ: f64 = 40.0;

    struct Replay {
        wishes: mpsc::Sender<PaceWish>,
        stop: CancellationToken,
        paced: mpsc::Receiver<Event>,
        position: watch::Receiver<Position>,
        began: Instant,
    }

    /// A capture of so many samples, a batch each.
    fn replay(rows: usize, beginning: Beginning) -> Replay {
        let (events, capture) = mpsc::channel(rows + 1);
        let layout = std::sync::Arc::new(VNYMR.clone());
        let row = || Batch {
            layout: Some(std::sync::Arc::clone(&layout)),
            counts: vec![0; layout.channels.len()],
            ..Batch::default()
        };
        (0..rows).for_each(|_| events.try_send(Event::Batch(row())).unwrap());
        events.try_send(Event::End(End { error: None, csv: None })).unwrap();
        let (wishes, wished) = mpsc::channel(8);
        let stop = CancellationToken::new();
        let (rate, rate_hz) = watch::channel(RATE_HZ);
        drop(rate);
        let (paced, position) = paced(capture, wished, rate_hz, beginning, stop.clone());
        Replay { wishes, stop, paced, position, began: Instant::now() }
    }

    impl Replay {
        /// Takes all that comes within so many seconds; how many samples that was, and whether the
        /// end was among it.
        async fn take(&mut self, seconds: f64) -> (usize, bool) {
            let until = Instant::now() + Duration::from_secs_f64(seconds);
            let mut rows = 0;
            loop {
                match tokio::time::timeout_at(until, self.paced.recv()).await {
                    Ok(Some(Event::Batch(_))) => rows += 1,
                    Ok(Some(Event::End(_))) => return (rows, true),
                    Ok(_) | Err(_) => return (rows, false),
                }
            }
        }
    }

    const AT_ONCE: Beginning = Beginning { speed: Speed::Max, paused: false, run_to: 0 };

    fn times(times: f64) -> Beginning {
        Beginning { speed: Speed::Times(times), ..AT_ONCE }
    }

    #[tokio::test(start_paused = true)]
    async fn samples_come_at_the_pace_asked_for() {
        let mut one = replay(1000, times(1.0));
        assert_eq!(one.take(2.01).await, (81, false));
        let mut ten = replay(1000, times(10.0));
        assert_eq!(ten.take(2.001).await, (801, false));
        let mut all = replay(1000, AT_ONCE);
        assert_eq!(all.take(0.001).await, (1000, true));
        assert_eq!(all.position.borrow().rows, 1000);
        assert!(all.position.borrow().at_end);
    }

    #[tokio::test(start_paused = true)]
    async fn a_paused_replay_steps_by_a_second() {
        let mut replay = replay(1000, Beginning { paused: true, ..times(1.0) });
        assert_eq!(replay.take(60.0).await, (0, false));
        for _ in 0..2 {
            replay.wishes.send(PaceWish::Step).await.unwrap();
            assert_eq!(replay.take(60.0).await, (40, false));
        }
        replay.wishes.send(PaceWish::PauseOrGoOn).await.unwrap();
        assert_eq!(replay.take(1.001).await, (41, false), "time spent paused is not made up for");
    }

    #[tokio::test(start_paused = true)]
    async fn going_on_to_a_place_takes_no_time() {
        let mut replay = replay(1000, times(1.0));
        replay.wishes.send(PaceWish::RunTo(500)).await.unwrap();
        assert_eq!(replay.take(0.001).await.0, 501);
        assert_eq!(replay.take(1.0).await.0, 40);
        replay.wishes.send(PaceWish::Faster).await.unwrap();
        assert_eq!(replay.take(1.001).await.0, 81);
        assert_eq!(replay.position.borrow().speed, Speed::Times(2.0));
    }

    #[tokio::test(start_paused = true)]
    async fn behind_the_end_the_speed_is_chosen_and_nothing_else() {
        for measured in [None, Some(3)] {
            let mut replay = replay(10, AT_ONCE);
            match measured {
                None => assert_eq!(replay.take(0.001).await, (10, true)),
                // a measurement that has enough leaves
                Some(rows) => {
                    for _ in 0..rows {
                        replay.paced.recv().await.unwrap();
                    }
                    replay.paced.close();
                }
            }
            for wish in [PaceWish::PauseOrGoOn, PaceWish::Step, PaceWish::RunTo(2), PaceWish::Slower] {
                replay.wishes.send(wish).await.unwrap();
            }
            let slower = replay.position.wait_for(|position| position.speed == Speed::Times(1000.0)).await.unwrap();
            assert!(slower.at_end && !slower.paused, "{slower:?}");
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_replay_that_is_stopped_ends_well() {
        let mut replay = replay(1000, times(1.0));
        assert_eq!(replay.take(0.001).await, (1, false));
        replay.stop.cancel();
        assert_eq!(replay.take(1.0).await, (0, true));
        assert!(replay.began.elapsed() < Duration::from_secs(1));
    }

    #[test]
    fn speeds_are_read_and_stepped_through() {
        for (text, speed) in [("1x", Speed::Times(1.0)), ("0.5x", Speed::Times(0.5)), ("max", Speed::Max)] {
            assert_eq!(text.parse(), Ok(speed));
        }
        for wrong in ["", "x", "0x", "-1x", "fast", "10", "nanx", "1e9x"] {
            assert!(wrong.parse::<Speed>().is_err(), "{wrong}");
        }
        assert_eq!(Speed::Times(1000.0).next(true), Speed::Max);
        assert_eq!(Speed::Max.next(false), Speed::Times(1000.0));
        assert_eq!(Speed::Times(3.0).next(false), Speed::Times(2.0));
        assert_eq!(Speed::Times(0.05).next(false), Speed::Times(0.1));
    }
}
