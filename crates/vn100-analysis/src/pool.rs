//! Several recordings of one sensor taken together: one curve, one set of parameters, the interval
//! of one more recording, and the outlier among them.

mod not_pooled;

use imu_noise::{Interval, OctaveSum, Parameter, Status, Term};
use noise_comparison::{RandomEffects, common_bound, holm};
use vn100_protocol::{Channel, Quantity, Register};

use crate::{assessment::LEAST_EDF, comparison::ComparedRecord, sensor::sensor_of};

pub use not_pooled::{NotPooled, Unpooled};

/// Several recordings of one sensor taken as one. A recording is referred to by its place among
/// those given, from 0.
#[derive(Debug, Clone)]
pub struct Pool {
    /// Two-sided level of every interval.
    pub confidence: f64,
    /// All recordings, including those excluded.
    pub parts: Vec<PoolPart>,
    /// What was assumed without evidence: serial numbers, averaging windows.
    pub notes: Vec<String>,
    /// By channel of the recordings in the pool; empty where fewer than two recordings belong
    /// together.
    pub channels: Vec<PooledChannel>,
}

/// One of the recordings.
#[derive(Debug, Clone, PartialEq)]
pub struct PoolPart {
    /// The name of the recording in texts.
    pub name: String,
    /// Serial number of the sensor; `None` where the recording does not contain it.
    pub serial: Option<String>,
    /// Number of samples in the statistics of the recording.
    pub samples: u64,
    /// Data time of these samples, in seconds.
    pub duration_s: f64,
    /// Why the recording is excluded; `None` for a recording in the pool.
    pub refused: Option<String>,
}

/// One channel over all recordings, in the channel's own unit.
#[derive(Debug, Clone)]
pub struct PooledChannel {
    /// The channel, which is the same in every recording.
    pub channel: Channel,
    /// Every octave that any recording has.
    pub octaves: Vec<PooledOctave>,
    /// N, B, K, and Q where it was fitted; none for a channel that is no axis of a sensor.
    pub parameters: Vec<PooledParameter>,
}

/// The sum of one octave over all recordings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PooledOctave {
    /// Averaging factor.
    pub m: u64,
    /// Averaging time in seconds.
    pub tau_s: f64,
    /// The deviation: √(sum of all squares / number of all terms); `None` where the sum is not
    /// known.
    pub deviation: Option<f64>,
    /// Number of squared differences in the sum.
    pub terms: u64,
    /// Degrees of freedom, and confidence limits of a deviation of 1, by sampling alone:
    /// differences between recordings are not in them. The degrees of freedom are those of the
    /// recordings, added with the weight of each in the sum (Welch, 1947; Satterthwaite, 1946).
    /// `None` where they are not known.
    pub relative: Option<Interval>,
    /// Number of recordings that have this octave.
    pub parts: usize,
}

/// A parameter over all recordings, in the unit of its term.
#[derive(Debug, Clone, PartialEq)]
pub struct PooledParameter {
    /// The parameter.
    pub term: Term,
    /// The estimate of each recording; `None` for one that is excluded.
    pub parts: Vec<Option<Parameter>>,
    /// The mean of the recordings and its interval; `None` with fewer than three estimates, which
    /// are only listed.
    pub pooled: Option<RandomEffects>,
    /// The common upper bound, where at least three recordings bound the parameter and none
    /// estimates it, if the parameter is the same in all; else `None`.
    pub common_bound: Option<f64>,
    /// The probability of the farthest recording, corrected for all parameters of all channels as
    /// well (Holm); `None` without [`pooled`](Self::pooled).
    pub corrected: Option<f64>,
}

impl PooledParameter {
    /// The place of the outlier: a recording so far off that any would be as far in less than 5 %
    /// of pools.
    #[must_use]
    pub fn outlier(&self) -> Option<usize> {
        let farthest = self.pooled?.farthest?;
        self.corrected.is_some_and(|p| p < 0.05).then_some(farthest.record)
    }
}

/// The terms that are positive amplitudes; a ramp has a sign, and belongs to one recording.
const TERMS: [Term; 4] = [Term::Quantization, Term::White, Term::BiasInstability, Term::RateRandomWalk];

impl Pool {
    /// All assessed at the level `confidence`, 0 < p < 1. What differs from the first recording
    /// with samples in message, compensation, channels, rate or averaging window is excluded.
    #[must_use]
    pub fn of(records: &[ComparedRecord<'_>], confidence: f64) -> Self {
        let reference = records.iter().position(|record| why_unusable(record).is_none());
        let parts: Vec<PoolPart> = (records.iter())
            .map(|record| {
                let refused = why_unusable(record).or_else(|| difference(record, &records[reference?]));
                let timing = &record.snapshot.timing;
                PoolPart {
                    name: record.name.into(),
                    serial: serial(record),
                    samples: timing.samples,
                    duration_s: timing.duration_s(),
                    refused,
                }
            })
            .collect();
        let used: Vec<usize> = (0..parts.len()).filter(|part| parts[*part].refused.is_none()).collect();
        let notes = notes(records, &parts, &used);
        let channels = match reference.filter(|_| used.len() > 1) {
            Some(first) => records[first].snapshot.layout_channels(),
            None => &[],
        };
        let channel = |(place, channel): (usize, &Channel)| PooledChannel {
            channel: channel.clone(),
            octaves: octaves(records, &used, place, channel, confidence),
            parameters: parameters(records, &used, place, channel, confidence),
        };
        let mut channels: Vec<PooledChannel> = channels.iter().enumerate().map(channel).collect();
        correct(&mut channels);
        Self { confidence, parts, notes, channels }
    }

    /// One pool for each stream that the sensor sent, in the order of the first recording of each.
    /// Streams differ by message, channels, rate or averaging window.
    #[must_use]
    pub fn by_stream(records: &[ComparedRecord<'_>], confidence: f64) -> Vec<Self> {
        let mut groups: Vec<Vec<ComparedRecord<'_>>> = Vec::new();
        for record in records {
            let has_layout = |one: &&ComparedRecord<'_>| one.snapshot.layout.is_some();
            let belongs = |group: &[ComparedRecord<'_>]| {
                group.iter().find(has_layout).is_none_or(|first| difference(record, first).is_none())
            };
            match groups.iter_mut().find(|group| belongs(group)) {
                Some(group) => group.push(*record),
                None => groups.push(vec![*record]),
            }
        }
        groups.iter().map(|group| Self::of(group, confidence)).collect()
    }

    /// Whether every recording is in the pool.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.parts.len() > 1 && self.parts.iter().all(|part| part.refused.is_none())
    }
}

fn serial(record: &ComparedRecord<'_>) -> Option<String> {
    record.snapshot.registers.get(&Register::SERIAL_NUMBER.0).cloned()
}

fn why_unusable(record: &ComparedRecord<'_>) -> Option<String> {
    if record.snapshot.timing.samples == 0 {
        return Some("it holds no samples".into());
    }
    record.assessment.motion.as_ref().map(ToString::to_string)
}

/// What keeps `record` from being another recording of the same stream as `first`; `None` for
/// nothing.
fn difference(record: &ComparedRecord<'_>, first: &ComparedRecord<'_>) -> Option<String> {
    let (ours, theirs) = (record.snapshot, first.snapshot);
    let name = first.name;
    let (Some(layout), Some(expected)) = (&ours.layout, &theirs.layout) else { return None };
    if layout.message != expected.message {
        return Some(format!("it is of {}, and {name} of {}", layout.message, expected.message));
    }
    if layout.compensated != expected.compensated {
        let state = |compensated: Option<bool>| match compensated {
            Some(true) => "is compensated",
            Some(false) => "is not compensated",
            None => "does not say whether it is compensated",
        };
        return Some(format!("it {}, and {name} {}", state(layout.compensated), state(expected.compensated)));
    }
    let scaled = |channel: &Channel| (channel.name.clone(), channel.unit.clone(), channel.decimals, channel.scale);
    if !layout.channels.iter().map(scaled).eq(expected.channels.iter().map(scaled)) {
        return Some(format!("its channels, or their units and decimals, are not those of {name}"));
    }
    let (rate_hz, expected_hz) = (ours.timing.rate_hz, theirs.timing.rate_hz);
    if rate_hz != expected_hz {
        return Some(format!("its rate is {rate_hz} Hz, and that of {name} {expected_hz} Hz"));
    }
    let windows = ours.layout_channels().iter().zip(&record.assessment.channels).zip(&first.assessment.channels);
    windows.into_iter().find_map(|((channel, ours), theirs)| {
        let (length, expected) = (ours.onboard?.window.length, theirs.onboard?.window.length);
        (length != expected)
            .then(|| format!("the sensor averaged {length} refreshes of {}, and in {name} {expected}", channel.name))
    })
}

fn notes(records: &[ComparedRecord<'_>], parts: &[PoolPart], used: &[usize]) -> Vec<String> {
    let mut notes = Vec::new();
    let known: Vec<(&str, &String)> =
        used.iter().filter_map(|part| Some((&*parts[*part].name, parts[*part].serial.as_ref()?))).collect();
    let names = |holds: &dyn Fn(usize) -> bool| -> String {
        let names: Vec<&str> = used.iter().filter(|part| holds(**part)).map(|part| &*parts[*part].name).collect();
        names.join(", ")
    };
    if known.windows(2).any(|pair| pair[0].1 != pair[1].1) {
        let each: Vec<String> = known.iter().map(|(name, serial)| format!("{name} {serial}")).collect();
        notes.push(format!(
            "the serial numbers differ ({}): the spread is that between sensors as well as between recordings",
            each.join(", ")
        ));
    }
    if used.len() > 1 && known.len() < used.len() {
        let unknown = names(&|part| parts[part].serial.is_none());
        notes.push(format!("serial number unknown: {unknown}; the same sensor is assumed"));
    }
    let is_assumed = |part: usize| {
        records[part]
            .assessment
            .channels
            .iter()
            .filter_map(|channel| channel.onboard)
            .any(|onboard| !onboard.window_known())
    };
    if used.len() > 1 && used.iter().any(|part| is_assumed(*part)) {
        let unknown = names(&is_assumed);
        notes.push(format!("averaging window unknown: {unknown}; the factory default is assumed"));
    }
    if used.len() < 2 {
        notes.push("fewer than two recordings belong together: nothing is pooled".into());
    }
    notes
}

fn octaves(
    records: &[ComparedRecord<'_>],
    used: &[usize],
    place: usize,
    channel: &Channel,
    confidence: f64,
) -> Vec<PooledOctave> {
    let of = |part: &usize| records[*part].snapshot.channels.get(place).map_or(&[][..], |results| &results.octaves);
    let most = used.iter().map(|part| of(part).len()).max().unwrap_or(0);
    let pooled = |index: usize| {
        let found: Vec<(usize, OctaveSum)> =
            used.iter().filter_map(|part| Some((*part, *of(part).get(index)?))).collect();
        let ((_, first), others) = found.split_first()?;
        let mut all = *first;
        others.iter().for_each(|(_, sum)| all.append(sum));
        // degrees of freedom that are not known are at least one
        let edf = |part: usize| {
            let assessed = records[part].assessment.channels.get(place)?.octaves.get(index)?;
            assessed.relative.map(|relative| relative.edf)
        };
        let squares: f64 = found.iter().map(|(part, sum)| (sum.terms as f64).powi(2) / edf(*part).unwrap_or(1.0)).sum();
        let edf = (all.terms as f64).powi(2) / squares;
        Some(PooledOctave {
            m: first.m,
            tau_s: {
                let snapshot = &records[found[0].0].snapshot;
                first.m as f64 / snapshot.rate_of(snapshot.channels.get(place)?)
            },
            deviation: all.deviation_counts().map(|counts| channel.in_unit(counts)),
            terms: all.terms,
            relative: Some(edf).filter(|edf| *edf >= LEAST_EDF).and_then(|edf| Interval::new(1.0, edf, confidence)),
            parts: found.len(),
        })
    };
    (0..most).filter_map(pooled).collect()
}

fn parameters(
    records: &[ComparedRecord<'_>],
    used: &[usize],
    place: usize,
    channel: &Channel,
    confidence: f64,
) -> Vec<PooledParameter> {
    if sensor_of(channel.quantity).is_none() {
        return Vec::new();
    }
    let pooled = |term: Term| {
        let of = |part: usize| {
            let noise = records[part].assessment.channels.get(place)?.noise.as_ref()?;
            noise.parameter(term).filter(|_| used.contains(&part))
        };
        let parts: Vec<Option<Parameter>> = (0..records.len()).map(of).collect();
        parts.iter().any(Option::is_some).then(|| {
            let all: Vec<Parameter> =
                parts.iter().map(|part| part.unwrap_or(Parameter::without_value(Status::NotObservable))).collect();
            PooledParameter {
                term,
                pooled: RandomEffects::of(&all, confidence),
                common_bound: common_bound(&all, confidence),
                parts,
                corrected: None,
            }
        })
    };
    TERMS.into_iter().filter_map(pooled).collect()
}

fn correct(channels: &mut [PooledChannel]) {
    let parameters = || channels.iter().flat_map(|channel| &channel.parameters);
    let p = |parameter: &PooledParameter| Some(parameter.pooled?.farthest?.p);
    let mut corrected = holm(&parameters().filter_map(p).collect::<Vec<_>>()).into_iter();
    for parameter in channels.iter_mut().flat_map(|channel| &mut channel.parameters) {
        parameter.corrected = p(parameter).and_then(|_| corrected.next());
    }
}

impl PooledChannel {
    /// The quantity of the channel.
    #[must_use]
    pub fn quantity(&self) -> Quantity {
        self.channel.quantity
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vn100_protocol::{Layout, VNIMU, VNYMR, stream::Batch};

    use super::*;
    use crate::{Analysis, Assessment, Settings, Snapshot};

    /// A generator with its state.
    fn noise(seed: u64) -> impl FnMut() -> i32 {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        move || {
            // twelve uniform numbers make a nearly normal one
            (0..12)
                .map(|_| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    (state >> 57) as i32 - 64
                })
                .sum()
        }
    }

    /// White noise on every channel, its amplitude times `factor`.
    fn snapshot(layout: &Layout, rows: usize, seed: u64, factor: f64, rate_hz: f64) -> Snapshot {
        let mut next = noise(seed);
        let counts = (0..rows * layout.channels.len()).map(|_| (f64::from(next()) * factor).round() as i32).collect();
        let mut analysis = Analysis::new(Settings { rate_hz: Some(rate_hz), ..Settings::default() });
        analysis.absorb(&Batch { layout: Some(Arc::new(layout.clone())), counts, ..Batch::default() });
        analysis.finish();
        analysis.final_snapshot()
    }

    fn compared<T>(snapshots: &[Snapshot], of: impl Fn(&[ComparedRecord<'_>], f64) -> T) -> T {
        let assessments: Vec<Assessment> = snapshots.iter().map(|snapshot| Assessment::new(snapshot, 0.95)).collect();
        let names = ["a", "b", "c", "d", "e", "f"];
        let records: Vec<ComparedRecord<'_>> = (snapshots.iter().zip(&assessments).zip(names))
            .map(|((snapshot, assessment), name)| ComparedRecord { name, snapshot, assessment, started_ns: None })
            .collect();
        of(&records, 0.95)
    }

    fn pool(snapshots: &[Snapshot]) -> Pool {
        compared(snapshots, Pool::of)
    }

    fn magnetometer(pool: &Pool) -> &PooledChannel {
        pool.channels.iter().find(|channel| channel.channel.name == "mag_x").unwrap()
    }

    fn white(pool: &Pool) -> &PooledParameter {
        magnetometer(pool).parameters.iter().find(|parameter| parameter.term == Term::White).unwrap()
    }

    #[test]
    fn sums_and_terms_of_the_octaves_add_up() {
        let snapshots = [snapshot(&VNIMU, 3000, 1, 1.0, 40.0), snapshot(&VNIMU, 2000, 2, 1.0, 40.0)];
        let pool = pool(&snapshots);
        assert!(pool.is_whole() && pool.channels.len() == 11);
        for (place, channel) in pool.channels.iter().enumerate() {
            for (index, octave) in channel.octaves.iter().enumerate() {
                let sums: Vec<_> =
                    snapshots.iter().filter_map(|snapshot| snapshot.channels[place].octaves.get(index)).collect();
                let square = |sum: &&OctaveSum| sum.sum_squares.unwrap() as f64;
                let terms: u64 = sums.iter().map(|sum| sum.terms).sum();
                let m = octave.m as f64;
                let variance = sums.iter().map(square).sum::<f64>() / (2.0 * m * m * terms as f64);
                let expected = channel.channel.in_unit(variance.sqrt());
                assert_eq!((octave.terms, octave.parts), (terms, sums.len()));
                assert!((octave.deviation.unwrap() / expected - 1.0).abs() < 1e-14);
            }
            let edf: Vec<f64> = channel.octaves.iter().filter_map(|octave| Some(octave.relative?.edf)).collect();
            assert!(edf.len() > 8 && edf.is_sorted_by(|a, b| a >= b) && *edf.last().unwrap() >= 2.0, "{edf:?}");
        }
        // the last octave is that of the longer record alone, within one of both
        assert_eq!(white(&pool).pooled, None, "two stand side by side");
        assert_eq!(white(&pool).parts.iter().flatten().count(), 2);
    }

    #[test]
    fn one_louder_recording_is_an_outlier_and_widens_the_next() {
        let alike: Vec<Snapshot> = (10..15).map(|seed| snapshot(&VNIMU, 6000, seed, 1.0, 40.0)).collect();
        let calm = pool(&alike);
        let n = white(&calm).pooled.unwrap();
        // the amplitude of one sample over the root of the rate; a count is 1e-4 gauss
        let truth = 1e-4 * (12.0 * (128.0_f64.powi(2) - 1.0) / 12.0).sqrt() / 40_f64.sqrt();
        assert!(n.lower < truth && truth < n.upper && n.upper / n.lower < 1.05, "{n:?}, {truth}");
        assert!(n.next_lower < n.lower && n.upper < n.next_upper);
        assert_eq!(calm.channels.iter().flat_map(|c| &c.parameters).filter_map(|p| p.outlier()).count(), 0);
        let mut one_louder = alike;
        one_louder[2] = snapshot(&VNIMU, 6000, 9, 1.6, 40.0);
        let loud = pool(&one_louder);
        assert_eq!(white(&loud).outlier(), Some(2), "{:?}", white(&loud));
        for (p, outlier) in [(0.049, Some(2)), (0.05, None)] {
            assert_eq!(PooledParameter { corrected: Some(p), ..white(&loud).clone() }.outlier(), outlier, "{p}");
        }
        let wider = white(&loud).pooled.unwrap();
        assert!((wider.farthest.unwrap().ratio / 1.6 - 1.0).abs() < 0.05 && wider.spread > 0.1, "{wider:?}");
        assert!(wider.next_upper / wider.next_lower > 2.0 * n.next_upper / n.next_lower);
    }

    #[test]
    fn what_does_not_belong_is_excluded_with_the_reason() {
        let mut other_window = snapshot(&VNIMU, 500, 3, 1.0, 40.0);
        other_window.registers.insert(85, "0,20,20,20,0,0,3,3,3,0".into());
        let pool = pool(&[
            snapshot(&VNIMU, 500, 1, 1.0, 40.0),
            snapshot(&VNYMR, 500, 2, 1.0, 40.0),
            snapshot(&VNIMU, 500, 2, 1.0, 50.0),
            snapshot(&VNIMU, 0, 2, 1.0, 40.0),
            other_window,
            snapshot(&VNIMU, 500, 4, 1.0, 40.0),
        ]);
        let reasons: Vec<Option<&str>> = pool.parts.iter().map(|part| part.refused.as_deref()).collect();
        assert_eq!(
            reasons,
            [
                None,
                Some("it is of VNYMR, and a of VNIMU"),
                Some("its rate is 50 Hz, and that of a 40 Hz"),
                Some("it holds no samples"),
                Some("the sensor averaged 20 refreshes of accel_x, and in a 4"),
                None
            ]
        );
        assert!(!pool.is_whole());
        assert_eq!(white(&pool).parts.iter().filter(|part| part.is_some()).count(), 2);
        assert_eq!(magnetometer(&pool).octaves[0].parts, 2);
    }

    #[test]
    fn each_stream_of_a_sensor_has_a_pool_of_its_own() {
        let snapshots = [
            snapshot(&VNIMU, 500, 1, 1.0, 40.0),
            snapshot(&VNYMR, 500, 2, 1.0, 40.0),
            snapshot(&VNIMU, 500, 3, 1.0, 40.0),
            snapshot(&VNIMU, 500, 4, 1.0, 50.0),
            snapshot(&VNYMR, 500, 5, 1.0, 40.0),
            snapshot(&VNIMU, 0, 2, 1.0, 40.0),
        ];
        let pools = compared(&snapshots, Pool::by_stream);
        let names = |pool: &Pool| pool.parts.iter().map(|part| part.name.clone()).collect::<String>();
        assert_eq!(pools.iter().map(names).collect::<Vec<_>>(), ["acf", "be", "d"]);
        assert!(compared(&[], Pool::by_stream).is_empty());
        let said = |pool: &Pool, wanted: Unpooled| {
            pool.not_pooled().into_iter().find(|left| left.what == wanted).map(|left| left.reason)
        };
        assert_eq!(said(&pools[0], Unpooled::Recording(2)).unwrap(), "it holds no samples");
        let mag_x = pools[1].channels.iter().position(|channel| channel.channel.name == "mag_x").unwrap();
        let white = Unpooled::Parameter { channel: mag_x, term: Term::White };
        assert_eq!(said(&pools[1], white).unwrap(), "2 of 2 recordings estimate it, and a pool needs three");
        assert!(said(&pools[1], Unpooled::Spectrum).is_some() && pools[2].not_pooled().is_empty());
    }

    #[test]
    fn serial_numbers_that_differ_are_noted() {
        let with = |serial: &str, seed| {
            let mut snapshot = snapshot(&VNIMU, 300, seed, 1.0, 40.0);
            snapshot.registers.insert(Register::SERIAL_NUMBER.0, serial.into());
            snapshot
        };
        let differ = pool(&[with("0100011981", 1), with("0100011982", 2), snapshot(&VNIMU, 300, 3, 1.0, 40.0)]);
        assert!(differ.notes[0].contains("a 0100011981, b 0100011982"), "{:?}", differ.notes);
        assert!(differ.notes[1].contains("unknown: c"), "{:?}", differ.notes);
        let same = pool(&[with("1", 1), with("1", 2)]);
        assert!(same.notes.iter().all(|note| !note.contains("serial")), "{:?}", same.notes);
        let alone = pool(&[with("1", 1)]);
        assert!(alone.channels.is_empty() && alone.notes[0].contains("fewer than two"));
        assert!(pool(&[]).channels.is_empty());
    }
}
