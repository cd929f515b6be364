//! Pieces of a record, analysed by themselves and appended, say what the whole record says, bit by
//! bit.

mod state;

use std::{sync::Arc, time::Duration};

use proptest::{collection::vec, prelude::*, sample::Index};
use vn100_analysis::{
    Analysis, Assessment, AveragingTimes, NotAppended, PieceStart, RateFrom, Settings,
    noise::{Deviation, Estimator, Histogram},
};
use vn100_protocol::stream::{Batch, Mark, MarkKind, RowCounter};
use vn100_protocol::{Layout, PrintFormat, Register, RegisterContents, RegisterFields, VNIMU, VNYMR};

const RATE_HZ: u64 = 40;

/// One thing on a stream.
#[derive(Debug, Clone, Copy)]
enum Line {
    Good([i32; 13]),
    Bad,
    Printed(PrintFormat),
    /// The sensor replies its serial number.
    Serial(char),
}

/// A record, and how its rows are counted.
#[derive(Debug, Clone)]
struct Record {
    layout: Layout,
    lines: Vec<Line>,
    has_counters: bool,
    settings: Settings,
}

/// A part of its lines.
#[derive(Debug, Clone, Copy)]
struct Part {
    first: usize,
    behind: usize,
}

impl Record {
    fn whole(&self) -> Part {
        Part { first: 0, behind: self.lines.len() }
    }

    /// Data time before each line, in samples, as its counter has it.
    fn indices(&self) -> Vec<u64> {
        let is_row = |line: &Line| matches!(line, Line::Good(_) | Line::Bad);
        let first = self.lines.iter().position(|line| matches!(line, Line::Good(_))).unwrap_or(0);
        let rows = |lines: &[Line]| lines.iter().filter(|line| is_row(line)).count() as u64;
        (0..self.lines.len()).map(|line| if line <= first { 0 } else { rows(&self.lines[first..line]) }).collect()
    }

    /// What lies before the first row from `first` on, where a piece begins.
    fn start(&self, first: usize) -> PieceStart {
        let samples_in = |time: Duration| (time.as_secs_f64() * RATE_HZ as f64).ceil() as u64;
        let skip = samples_in(self.settings.skip);
        let end = self.settings.duration.map_or(u64::MAX, samples_in);
        let indices = self.indices();
        let good = |line: &usize| matches!(self.lines[*line], Line::Good(_));
        let counts = |line: &usize| good(line) && (skip..end).contains(&indices[*line]);
        let index = (first..self.lines.len()).find(good).or_else(|| (0..first).rev().find(good));
        let index = index.map_or(0, |line| indices[line]);
        let begun = (0..first).find(counts).map(|line| indices[line]);
        let samples = (0..first).filter(counts).count() as u64;
        PieceStart { index, places: begun.map_or(0, |begun| index.min(end) - begun), samples }
    }

    /// In batches of so many lines.
    fn analysed(&self, part: Part, rows: usize) -> Analysis {
        let layout = Arc::new(self.layout.clone());
        let mut analysis = Analysis::new(self.settings.clone()).starting_at(self.start(part.first));
        let indices = self.indices();
        // each reader marks the format before its first row
        let format = self.lines[..part.first].iter().rev().find_map(|line| match line {
            Line::Printed(format) => Some(*format),
            _ => None,
        });
        let mut link = Batch::default().link;
        let mut mark = format.map(|format| Mark { before_row: 0, kind: MarkKind::Printed(format) });
        for lines in (part.first..part.behind).collect::<Vec<_>>().chunks(rows) {
            let mut batch = Batch { layout: Some(Arc::clone(&layout)), ..Batch::default() };
            batch.marks.extend(mark.take());
            for line in lines {
                let before_row = batch.row_count();
                match self.lines[*line] {
                    Line::Good(row) => {
                        batch.counts.extend(&row[..layout.channels.len()]);
                        if self.has_counters {
                            let count = 7 + indices[*line] as u32;
                            batch.counters.push(RowCounter { row: before_row, count: count.into() });
                        }
                        link.tally.samples += 1;
                        link.tally.valid_sentence_bytes += 120;
                    }
                    Line::Bad => {
                        batch.marks.push(Mark { before_row, kind: MarkKind::Rejected });
                        link.tally.rejected.checksum += 1;
                    }
                    Line::Printed(format) => batch.marks.push(Mark { before_row, kind: MarkKind::Printed(format) }),
                    Line::Serial(serial) => batch.registers.push(RegisterContents {
                        register: Register::SERIAL_NUMBER,
                        fields: RegisterFields::new(serial.to_string()).unwrap(),
                    }),
                }
            }
            batch.link = link;
            analysis.absorb(&batch);
        }
        analysis.finish();
        analysis
    }

    /// The pieces that begin at these lines.
    fn cut(&self, starts: &[Index], rows: usize) -> Vec<Analysis> {
        let mut starts: Vec<_> = starts.iter().map(|start| start.index(self.lines.len() + 1)).collect();
        starts.extend([0, self.lines.len()]);
        starts.sort_unstable();
        starts.dedup();
        let parts = starts.windows(2).map(|ends| Part { first: ends[0], behind: ends[1] });
        parts.map(|part| self.analysed(part, rows)).collect()
    }

    /// Appended in this order.
    fn pieced(&self, starts: &[Index], order: &[Index], rows: usize) -> Result<Analysis, NotAppended> {
        let mut pieces = self.cut(starts, rows);
        if pieces.is_empty() {
            pieces.push(self.analysed(self.whole(), rows));
        }
        for place in order.iter().cycle() {
            if pieces.len() == 1 {
                break;
            }
            let left = place.index(pieces.len() - 1);
            let right = pieces.remove(left + 1);
            pieces[left].append(right)?;
        }
        Ok(pieces.remove(0))
    }
}

/// All that a result is made of: in the words of `Debug`, which write every bit of a number.
fn said(analysis: &Analysis) -> String {
    let mut snapshot = analysis.final_snapshot();
    let assessment = Assessment::new(&snapshot, 0.95);
    let mut said = format!("{assessment:#?}\n");
    for channel in &mut snapshot.channels {
        let signal = channel.signal.take().unwrap();
        let bins: Vec<_> = channel.histogram.bins().collect();
        said += &format!("{:?} {:?}\n", signal.blocks(), bins);
        channel.histogram = Histogram::new();
    }
    snapshot.recent = None;
    said + &format!("{snapshot:#?}")
}

/// Splits a seed into nearly normal noise.
fn noise(state: &mut u64) -> i32 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (0..8).map(|byte| (*state >> (8 * byte) & 0xFF) as i32).sum::<i32>() - 1020
}

fn lines() -> impl Strategy<Value = Vec<Line>> {
    let stretch = prop_oneof![
        // noise, with spikes now and then, of this size
        6 => (1_usize..900, prop_oneof![Just(1), Just(3)], any::<bool>()).prop_map(|(rows, size, spikes)| (rows, size, spikes)),
        // a sensor that hangs
        1 => (1_usize..200).prop_map(|rows| (rows, 0, false)),
    ];
    let between = prop_oneof![
        3 => (0_usize..4).prop_map(|bad| vec![Line::Bad; bad]),
        1 => (0_usize..700).prop_map(|bad| vec![Line::Bad; bad]),
        1 => prop_oneof![Just(PrintFormat::Current), Just(PrintFormat::Old)].prop_map(|format| vec![Line::Printed(format)]),
        1 => prop_oneof![Just('1'), Just('2')].prop_map(|serial| vec![Line::Serial(serial)]),
    ];
    (vec((between, stretch), 1..7), 1..u64::MAX).prop_map(|(stretches, seed)| {
        let mut state = seed;
        let mut row = [0; 13];
        let mut all = Vec::new();
        let mut format = None;
        let mut heading = 0;
        for (between, (rows, size, spikes)) in stretches {
            for line in between {
                // a mark stands where the format changes
                let is_change = !matches!(line, Line::Printed(now) if format.replace(now) == Some(now));
                all.extend(is_change.then_some(line));
            }
            for i in 0..rows {
                if size > 0 {
                    row = std::array::from_fn(|channel| 100 * channel as i32 + size * noise(&mut state) / 8);
                }
                let mut line = row;
                // an angle about the end of its range, of which some is beyond
                if size > 0 {
                    heading += noise(&mut state);
                }
                line[0] = (179_000 + heading + 180_000).rem_euclid(360_000) - 180_000;
                if spikes && i % 97 == 50 {
                    line[9] += 30_000;
                }
                all.push(Line::Good(line));
            }
        }
        all
    })
}

fn settings() -> impl Strategy<Value = Settings> {
    let kind = prop_oneof![
        4 => Just((Estimator::Strided, AveragingTimes::Octave)),
        1 => Just((Estimator::Plain, AveragingTimes::Octave)),
        1 => Just((Estimator::Full, AveragingTimes::Decade)),
    ];
    let deviation = prop_oneof![3 => Just(Deviation::Allan), 1 => Just(Deviation::Hadamard)];
    let skip = prop_oneof![Just(0.0), Just(1.0), Just(3.3)];
    let duration = prop_oneof![3 => Just(None), 1 => Just(Some(Duration::from_secs(30)))];
    (kind, deviation, skip, duration).prop_map(|(kind, deviation, skip, duration)| Settings {
        estimator: kind.0,
        averaging_times: kind.1,
        deviation,
        skip: Duration::from_secs_f64(skip),
        duration,
        ..Settings::default()
    })
}

/// As in packets: three channels have a new value in every fourth row, one in every second.
fn with_slower_channels() -> Layout {
    let mut channels = VNYMR.channels.to_vec();
    channels[3..6].iter_mut().for_each(|channel| channel.refresh_hz = Some(10));
    channels[6].refresh_hz = Some(20);
    Layout { channels: channels.into(), ..VNYMR.clone() }
}

fn records() -> impl Strategy<Value = Record> {
    // the one has angles, the other the temperature of the sensor, the third slower channels
    let layout = prop_oneof![Just(VNYMR.clone()), Just(VNIMU.clone()), Just(with_slower_channels())];
    (layout, lines(), any::<bool>(), settings()).prop_map(|(layout, lines, has_counters, settings)| Record {
        layout,
        lines,
        has_counters,
        settings,
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn pieces_appended_in_any_order_say_what_the_whole_says(
        record in records(),
        starts in vec(any::<Index>(), 1..6),
        order in vec(any::<Index>(), 1..6),
        rows in 1_usize..500,
    ) {
        let whole = said(&record.analysed(record.whole(), 100));
        let pieces = match record.pieced(&starts, &order, rows) {
            // no two rows of a piece follow each other
            Err(NotAppended::OtherCounter(_) | NotAppended::OtherPlace { .. }) if record.has_counters => {
                return Ok(());
            }
            pieces => said(&pieces.unwrap()),
        };
        for (whole, pieces) in whole.lines().zip(pieces.lines()) {
            prop_assert_eq!(whole, pieces);
        }
        prop_assert_eq!(whole.len(), pieces.len());
    }
}

/// Of one channel that counts up, as the pieces of a record that begin at these rows.
fn counted_up(starts: &[usize]) -> Analysis {
    let lines = (0..6).map(|row| if row == 3 { Line::Bad } else { Line::Good([row; 13]) }).collect();
    let record = Record { layout: VNIMU.clone(), lines, has_counters: true, settings: Settings::default() };
    let ends = starts.iter().skip(1).copied().chain([6]);
    let mut pieces = starts.iter().zip(ends).map(|(&first, behind)| record.analysed(Part { first, behind }, 1));
    let mut whole = pieces.next().unwrap();
    pieces.for_each(|piece| whole.append(piece).unwrap());
    whole
}

#[test]
fn counters_of_pieces_tell_what_is_missing_though_a_piece_has_one_row() {
    let whole = said(&counted_up(&[0]));
    for starts in [&[0, 1][..], &[0, 2], &[0, 1, 2], &[0, 5], &[0, 4, 5], &[0, 1, 2, 4, 5]] {
        let pieces = said(&counted_up(starts));
        let differ: Vec<_> =
            pieces.lines().zip(whole.lines()).filter(|(pieces, whole)| pieces != whole).take(3).collect();
        assert!(differ.is_empty() && pieces.len() == whole.len(), "{starts:?}: {differ:#?}");
    }
}

#[test]
fn a_piece_that_tells_the_rate_tells_it_for_the_others() {
    let piece = |first: usize, told: Option<&str>| {
        let row = vec![1; VNIMU.channels.len()];
        let mut batch = Batch { layout: Some(Arc::new(VNIMU.clone())), counts: row, ..Batch::default() };
        let reply = |rate_hz: &str| RegisterContents {
            register: Register::ASYNC_RATE,
            fields: RegisterFields::new(rate_hz).unwrap(),
        };
        batch.registers.extend(told.map(reply));
        let (index, places, samples) = (first as u64, first as u64, first as u64);
        let mut analysis = Analysis::new(Settings::default()).starting_at(PieceStart { index, places, samples });
        analysis.absorb(&batch);
        analysis
    };
    for told in [[None, None], [None, Some("40")], [Some("40"), None], [Some("40"); 2]] {
        let mut whole = piece(0, told[0]);
        whole.append(piece(1, told[1])).unwrap();
        let timing = whole.snapshot().timing;
        let expected = if told.contains(&Some("40")) { RateFrom::Device } else { RateFrom::Assumed };
        assert_eq!((timing.samples, timing.rate_hz, timing.rate_from), (2, 40.0, expected), "{told:?}");
    }
    let (mut whole, other) = (piece(0, Some("40")), piece(1, Some("50")));
    assert!(matches!(whole.append(other), Err(NotAppended::OtherRate { hz: 40.0, next_hz: 50.0 })));
}

#[test]
fn pieces_with_and_without_counters_are_not_of_one_record() {
    let piece = |rows: std::ops::Range<usize>, has_counters| {
        let lines = vec![Line::Good([1; 13]); 6];
        let record = Record { layout: VNIMU.clone(), lines, has_counters, settings: Settings::default() };
        record.analysed(Part { first: rows.start, behind: rows.end }, 100)
    };
    for has_counters in [[true, false], [false, true]] {
        let mut whole = piece(0..3, has_counters[0]);
        assert!(matches!(whole.append(piece(3..6, has_counters[1])), Err(NotAppended::CounterInOne)));
        assert_eq!(whole.snapshot().timing.samples, 3, "nothing is appended");
        whole.append(piece(3..3, has_counters[1])).unwrap();
        whole.append(piece(3..6, has_counters[0])).unwrap();
        assert_eq!(whole.snapshot().timing.samples, 6);
    }
}
