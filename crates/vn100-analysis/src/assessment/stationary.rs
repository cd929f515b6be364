//! Warnings of what is not stationary: spectral peaks, disturbances, changes of noise and level.

use imu_noise::{Disturbance, LevelShape, NoiseChanges, SpectralLine, Spikes};
use vn100_protocol::{Channel, Quantity};

use super::{ChannelAssessment, Stationarity, mains::mains_hz};
use crate::{
    remedy::Remedy,
    snapshot::Snapshot,
    warning::{Event, Finding, Happening, Peak, Warning},
};

/// The highest frequency that a peak of the stream may really have: half the sensor's own rate.
const HIGHEST_HZ: f64 = 400.0;

pub(super) fn warnings(snapshot: &Snapshot, assessed: &[ChannelAssessment]) -> Vec<Warning> {
    let channels: Vec<_> =
        snapshot.assessed(assessed).map(|(channel, _, assessed)| (channel, &assessed.stationarity)).collect();
    [vibration(&channels, snapshot), disturbances(&channels, snapshot), warm_up(&channels)]
        .into_iter()
        .flatten()
        .collect()
}

type Of<'a> = (&'a Channel, &'a Stationarity);

fn vibration(channels: &[Of<'_>], snapshot: &Snapshot) -> Option<Warning> {
    let shakes = Shake::all(channels);
    let axes = names(shakes.iter().flat_map(|shake| shake.axes.iter().map(|(channel, _)| *channel)));
    let peaks = shakes.iter().map(|shake| shake.peak(snapshot.timing.rate_hz)).collect();
    Warning::of_any(Finding::Peaks(peaks), axes)
}

/// Frequencies at which else a line may really be, as the samples do not tell.
fn aliases_hz(line_hz: f64, rate_hz: f64) -> Vec<f64> {
    let pairs = (1..).flat_map(|n| [f64::from(n) * rate_hz - line_hz, f64::from(n) * rate_hz + line_hz]);
    let others = pairs.take_while(|hz| *hz <= HIGHEST_HZ).filter(|hz| hz - line_hz > 0.05);
    // at half the rate two of them are one
    let mut others: Vec<f64> = others.take(6).collect();
    others.dedup_by(|a, b| (*a - *b).abs() < 0.05);
    others.truncate(3);
    others
}

/// Whether two neighbouring lines are one vibration: what turns is never quite steady.
pub(crate) fn have_one_cause(a: &SpectralLine, b: &SpectralLine) -> bool {
    const APART: f64 = 1.03;
    b.frequency_hz < APART * a.frequency_hz
}

/// The frequency in hertz of lines that are one vibration, and their share in the variance.
pub(crate) fn frequency_and_share<'a>(lines: impl Iterator<Item = &'a SpectralLine> + Clone) -> (f64, f64) {
    let share: f64 = lines.clone().map(|line| line.share_of_variance).sum();
    let weighted: f64 = lines.map(|line| line.share_of_variance * line.frequency_hz).sum();
    (weighted / share, share)
}

struct Shake<'a> {
    frequency_hz: f64,
    /// Channels, and the share of the lines in the variance of each.
    axes: Vec<(&'a Channel, f64)>,
}

impl<'a> Shake<'a> {
    /// The strongest first.
    fn all(channels: &[Of<'a>]) -> Vec<Self> {
        let mut lines: Vec<(&'a Channel, &'a SpectralLine)> =
            channels.iter().flat_map(|(channel, found)| found.lines.iter().map(move |line| (*channel, line))).collect();
        lines.sort_by(|(_, a), (_, b)| a.frequency_hz.total_cmp(&b.frequency_hz));
        let mut shakes: Vec<Self> = lines.chunk_by(|(_, a), (_, b)| have_one_cause(a, b)).map(Self::of).collect();
        shakes.sort_by(|a, b| b.most().1.total_cmp(&a.most().1));
        shakes
    }

    fn of(lines: &[(&'a Channel, &'a SpectralLine)]) -> Self {
        let (frequency_hz, _) = frequency_and_share(lines.iter().map(|(_, line)| *line));
        let mut axes: Vec<(&'a Channel, f64)> = Vec::new();
        for (channel, line) in lines {
            match axes.iter_mut().find(|(other, _)| other.name == channel.name) {
                Some((_, share)) => *share += line.share_of_variance,
                None => axes.push((channel, line.share_of_variance)),
            }
        }
        axes.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        Self { frequency_hz, axes }
    }

    fn most(&self) -> (&'a Channel, f64) {
        self.axes[0]
    }

    /// An alternating field shows on the magnetometer alone.
    fn peak(&self, rows_hz: f64) -> Peak {
        let is_field = |(channel, _): &(&Channel, f64)| channel.quantity == Quantity::MagneticField;
        let rate_hz = rows_hz / self.most().0.stride(rows_hz) as f64;
        let mains_hz = mains_hz(self.frequency_hz, rows_hz).filter(|_| self.axes.iter().all(is_field));
        Peak {
            frequency_hz: self.frequency_hz,
            axes: self.axes.iter().map(|(channel, share)| (channel.name.to_string(), *share)).collect(),
            aliases_hz: aliases_hz(self.frequency_hz, rate_hz),
            mains_hz,
        }
    }
}

fn disturbances(channels: &[Of<'_>], snapshot: &Snapshot) -> Option<Warning> {
    let (skipped_s, duration_s) = (snapshot.skipped.as_secs_f64(), snapshot.timing.duration_s());
    // the last of equal stretches may be longer than the rest of the record
    let within = |at_s: f64| at_s.min(duration_s + skipped_s);
    let mut found: Vec<Happening> = channels.iter().flat_map(|(channel, found)| events(channel, found)).collect();
    let start = |event: &Happening| event.span_s.map_or(f64::INFINITY, |(start_s, _)| start_s);
    found.sort_by(|a, b| start(a).total_cmp(&start(b)).then_with(|| a.channel.cmp(&b.channel)));
    for event in &mut found {
        event.span_s = event.span_s.map(|(start_s, end_s)| (within(start_s), within(end_s)));
    }
    let mut axes: Vec<String> = found.iter().map(|event| event.channel.clone()).collect();
    axes.sort();
    axes.dedup();
    Warning::of_any(Finding::Events(found), axes)
}

/// All but a warm-up.
fn events(channel: &Channel, found: &Stationarity) -> Vec<Happening> {
    let event = |span_s, what| Happening { channel: channel.name.to_string(), span_s, what };
    let unit = || channel.unit.to_string();
    let short = (found.disturbances.iter())
        .map(|&Disturbance { start_s, end_s, sigmas }| event(Some((start_s, end_s)), Event::Sigmas(sigmas)));
    let level = found.level_change.and_then(|change| match change.shape {
        LevelShape::Step { start_s, amplitude } => {
            Some(event(Some((start_s, start_s)), Event::Step(amplitude, unit())))
        }
        LevelShape::Cycle { period_s, amplitude } => Some(event(None, Event::Cycle(period_s, amplitude, unit()))),
        LevelShape::WarmUp { .. } => None,
    });
    let NoiseChanges { change, bursts, frozen, spikes } = &found.noise;
    let change = change.map(|of| event(Some((of.start_s, of.end_s)), Event::NoiseFactor(of.factor)));
    let bursts = bursts.map(|ratio| event(None, Event::Bursts(ratio)));
    let frozen = frozen.map(|of| event(Some((of.start_s, of.end_s)), Event::Frozen(of.duration_s)));
    let spikes = spikes.map(|Spikes { count, sigmas }| event(None, Event::Outliers(count, sigmas)));
    short.chain([level, change, bursts, frozen, spikes].into_iter().flatten()).collect()
}

fn warm_up(axes: &[Of<'_>]) -> Option<Warning> {
    let of = |(channel, found): &Of<'_>| match found.level_change?.shape {
        LevelShape::WarmUp { amplitude, time_constant_s, skip_s } => {
            let (name, unit) = (channel.name.to_string(), channel.unit.to_string());
            Some(((name, amplitude, unit, time_constant_s, skip_s.is_some()), skip_s))
        }
        LevelShape::Step { .. } | LevelShape::Cycle { .. } => None,
    };
    let (found, skips_s): (Vec<_>, Vec<_>) = axes.iter().filter_map(of).unzip();
    let longest_s = skips_s.into_iter().reduce(|a, b| a.zip(b).map(|(a, b)| a.max(b)))?;
    let channels: Vec<String> = found.iter().map(|(channel, ..)| channel.clone()).collect();
    let warning = Warning::new(Finding::WarmUp(found)).of(channels);
    Some(match longest_s {
        Some(skip_s) => {
            let minutes = (skip_s / 60.0).ceil();
            warning.cured_by(Remedy::Skip(Some(minutes)))
        }
        None => warning,
    })
}

fn names<'a>(channels: impl Iterator<Item = &'a Channel>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for channel in channels {
        if names.iter().all(|name| *name != channel.name) {
            names.push(channel.name.to_string());
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use imu_noise::LevelChange;

    use super::*;
    use crate::{Analysis, Settings};
    use vn100_protocol::VNYMR;

    #[test]
    fn a_warm_up_is_excluded_from_the_first_sample_on() {
        for (skip_s, minutes) in [(200.0, 4.0), (245.0, 5.0)] {
            let shape = LevelShape::WarmUp { amplitude: 4e-4, time_constant_s: 51.2, skip_s: Some(skip_s) };
            let level_change = Some(LevelChange { shape, sigmas: 9.0, is_ramp: false });
            let found = Stationarity { level_change, ..Stationarity::default() };
            let warning = warm_up(&[(&VNYMR.channels[9], &found)]).unwrap();
            assert_eq!(warning.remedies, [Remedy::Skip(Some(minutes))]);
        }
    }

    #[test]
    fn lines_within_three_percent_shake_as_one_the_strongest_first() {
        let line = |frequency_hz, share_of_variance| SpectralLine {
            frequency_hz,
            share_of_variance,
            amplitude: 1.0,
            peak_to_floor: 100.0,
        };
        let found = |lines: &[SpectralLine]| Stationarity { lines: lines.to_vec(), ..Stationarity::default() };
        // 5.0 and 5.1 Hz are one, 5.1 and 5.3 are not
        let (x, y) = (found(&[line(5.0, 0.1), line(9.0, 0.2)]), found(&[line(5.1, 0.3), line(5.3, 0.4)]));
        let channels = [(&VNYMR.channels[9], &x), (&VNYMR.channels[10], &y)];
        let shakes = Shake::all(&channels);
        let reported: Vec<_> =
            shakes.iter().map(|shake| (shake.frequency_hz, shake.most().1, shake.axes.len())).collect();
        let [(single_hz, 0.4, 1), (both_hz, 0.3, 2), (9.0, 0.2, 1)] = reported[..] else { panic!("{reported:?}") };
        assert!((single_hz - 5.3).abs() < 1e-12 && (both_hz - (0.1 * 5.0 + 0.3 * 5.1) / 0.4).abs() < 1e-12);
        assert_eq!(shakes[1].most().0.name, "gyro_y");
        let warning = vibration(&channels, &Analysis::new(Settings::default()).snapshot()).unwrap();
        assert_eq!(warning.channels, ["gyro_y", "gyro_x"]);
    }

    #[test]
    fn a_line_on_the_magnetometer_alone_is_a_field_and_shakes_nothing() {
        let line =
            |frequency_hz| SpectralLine { frequency_hz, share_of_variance: 0.35, amplitude: 1.0, peak_to_floor: 100.0 };
        let snapshot = Analysis::new(Settings::default()).snapshot();
        let (mag, gyro) = (&VNYMR.channels[3], &VNYMR.channels[10]);
        let of = |hz: f64| Stationarity { lines: vec![line(hz)], ..Stationarity::default() };
        let mains = |of: &[Of<'_>]| match vibration(of, &snapshot).unwrap().finding {
            Finding::Peaks(peaks) => peaks.iter().map(|peak| peak.mains_hz).collect::<Vec<_>>(),
            other => panic!("{other:?}"),
        };
        let (at_20, at_7) = (of(20.0), of(7.0));
        assert_eq!(mains(&[(mag, &at_20)]), [Some(60.0)]);
        assert_eq!(mains(&[(mag, &at_7)]), [None]);
        assert_eq!(mains(&[(mag, &at_20), (gyro, &at_20)]), [None]);
        assert_eq!(mains(&[(mag, &at_20), (gyro, &at_7)]).iter().flatten().count(), 1);
    }

    #[test]
    fn what_disturbs_is_listed_by_its_time_those_skipped_included() {
        let disturbed = |spans: &[(f64, f64)]| {
            let of = |&(start_s, end_s): &(f64, f64)| Disturbance { start_s, end_s, sigmas: 12.0 };
            Stationarity { disturbances: spans.iter().map(of).collect(), ..Stationarity::default() }
        };
        let (x, y) = (disturbed(&[(60.0 + 61.2, 60.0 + 64.3)]), disturbed(&[(60.0 + 7.9, 60.0 + 7.9)]));
        let mut snapshot = Analysis::new(Settings::default()).snapshot();
        snapshot.skipped = std::time::Duration::from_secs(60);
        snapshot.timing.samples = 64 * snapshot.timing.rate_hz as u64;
        let warning = disturbances(&[(&VNYMR.channels[9], &x), (&VNYMR.channels[10], &y)], &snapshot).unwrap();
        assert_eq!(warning.channels, ["gyro_x", "gyro_y"]);
        let Finding::Events(events) = warning.finding else { panic!() };
        let found: Vec<_> = events.iter().map(|event| (&*event.channel, event.span_s)).collect();
        let at_s = |seconds: f64| Some((60.0 + seconds, 60.0 + seconds));
        assert_eq!(found, [("gyro_y", at_s(7.9)), ("gyro_x", Some((60.0 + 61.2, 60.0 + 64.0)))], "within 64 s");
    }
}
