//! Warnings of what is not stationary: spectral peaks, disturbances, changes of noise and level.

use imu_noise::{Disturbance, Frozen, LevelShape, NoiseChange, NoiseChanges, SpectralLine, Spikes};
use vn100_protocol::{Channel, Quantity};

use super::{ChannelAssessment, Disturbed, mains::Mains};
use crate::{
    remedy::{Remedy, Text},
    snapshot::Snapshot,
    warning::{Warning, WarningKind},
};

/// Places named in one warning; the result has them all.
const MOST_NAMED: usize = 4;

/// Places named in its headline.
const HEADLINED: usize = 1;

/// The highest frequency that a peak of the stream may really have: half the sensor's own rate.
const HIGHEST_HZ: f64 = 400.0;

pub(super) fn warnings(snapshot: &Snapshot, assessed: &[ChannelAssessment]) -> Vec<Warning> {
    let axes = snapshot.assessed(assessed);
    let channels: Vec<_> = axes.clone().map(|(channel, _, assessed)| (channel, &assessed.disturbed)).collect();
    let rejected = axes
        .filter(|(.., assessed)| assessed.noise.as_ref().is_some_and(|noise| noise.fit.quality.is_none()))
        .map(|(channel, ..)| channel);
    [vibration(&channels, &names(rejected), snapshot), disturbances(&channels, snapshot), warm_up(&channels, snapshot)]
        .into_iter()
        .flatten()
        .collect()
}

type Of<'a> = (&'a Channel, &'a Disturbed);

/// `rejected`: axes that no noise model fits.
fn vibration(channels: &[Of<'_>], rejected: &[String], snapshot: &Snapshot) -> Option<Warning> {
    let shakes = Shake::all(channels);
    let strongest = shakes.first()?;
    let peak = |shake: &Shake<'_>| {
        let (channel, share) = shake.most();
        let share = match 100.0 * share {
            percent if percent < 1.0 => "< 1 %".into(),
            percent => format!("{percent:.0} %"),
        };
        format!("{} {:.2} Hz ({share})", channel.name, shake.frequency_hz)
    };
    let also = |shake: &Shake<'_>| {
        let most = &shake.most().0.name;
        let others = names(shake.axes.iter().map(|(channel, _)| *channel).filter(|other| other.name != *most));
        if others.is_empty() { String::new() } else { format!(", also on {}", others.join(" ")) }
    };
    let headline = format!("spectral peak: {}", list(&shakes, HEADLINED, peak));
    let list = list(&shakes, MOST_NAMED, |shake| peak(shake) + &also(shake));
    // one peak on one axis is in the headline already
    let peaks = if headline.ends_with(&list) { String::new() } else { format!(": {list}") };
    let rows_hz = snapshot.timing.rate_hz;
    let alias = alias(strongest, rows_hz / strongest.most().0.stride(rows_hz) as f64);
    let axes = names(shakes.iter().flat_map(|shake| shake.axes.iter().map(|(channel, _)| *channel)));
    let disturbed: Vec<&str> = axes.iter().filter(|name| rejected.contains(name)).map(String::as_str).collect();
    let instead = match disturbed.is_empty() {
        true => String::new(),
        false => format!(
            " No noise model fits on {}; only an upper bound for N is given. A longer record does not help; another place, another rate or \
             another averaging window does.",
            disturbed.join(" ")
        ),
    };
    let cause = cause(&shakes, snapshot.timing.rate_hz);
    let details = format!(
        "Percentages are shares of the short-term variance{peaks}.{alias}{cause} Each peak is fitted by a term of its own, and N excludes it.{instead}"
    );
    Some(Warning::new(WarningKind::VibrationLine, axes, headline, details))
}

/// What makes the lines: what moves the sensor shows on gyroscope or accelerometer, an alternating
/// field on the magnetometer alone.
fn cause(shakes: &[Shake<'_>], rate_hz: f64) -> String {
    let moves = |shake: &&Shake<'_>| {
        let is_moved = |quantity| matches!(quantity, Quantity::AngularRate | Quantity::Acceleration);
        shake.axes.iter().any(|(channel, _)| is_moved(channel.quantity))
    };
    let is_field =
        |shake: &&Shake<'_>| shake.axes.iter().any(|(channel, _)| channel.quantity == Quantity::MagneticField);
    let mut text = String::new();
    if shakes.iter().any(|shake| moves(&shake)) {
        text += " Vibration of a fan, a motor or footsteps shows at averaging times up to its period: isolate the sensor on a heavy base, \
                 away from them.";
    }
    if let Some(field) = shakes.iter().filter(|shake| !moves(shake)).find(is_field) {
        let hz = field.frequency_hz;
        let mains = Mains::at(hz, rate_hz).map_or_else(String::new, |mains| format!(": mains of {mains}"));
        text += &format!(
            " The peak at {hz:.2} Hz is on the magnetometer alone: an alternating field{mains}. Keep cables, power supplies and motors away."
        );
    }
    text
}

/// Where else the strongest shake may really be; empty where the stream is too fast for any.
fn alias(strongest: &Shake<'_>, rate_hz: f64) -> String {
    let arrival_hz = strongest.frequency_hz;
    // at half the rate two of them are one
    let mut others: Vec<String> = SpectralLine { frequency_hz: arrival_hz, ..*strongest.line }
        .aliases_hz(1.0 / rate_hz, HIGHEST_HZ)
        .filter(|hz| hz - arrival_hz > 0.05)
        .take(6)
        .map(|hz| format!("{hz:.1}"))
        .collect();
    others.dedup();
    others.truncate(3);
    match others.is_empty() {
        true => String::new(),
        false => format!(" At {rate_hz} Hz, sources at {} Hz and more alias to {arrival_hz:.2} Hz.", others.join(", ")),
    }
}

struct Shake<'a> {
    frequency_hz: f64,
    /// The strongest of them.
    line: &'a SpectralLine,
    /// Channels, and the share of the lines in the variance of each.
    axes: Vec<(&'a Channel, f64)>,
}

impl<'a> Shake<'a> {
    /// The strongest first.
    fn all(channels: &[Of<'a>]) -> Vec<Self> {
        /// Lines nearer to each other than this have one cause: what turns is never quite steady.
        const APART: f64 = 1.03;
        let mut lines: Vec<(&'a Channel, &'a SpectralLine)> =
            channels.iter().flat_map(|(channel, found)| found.lines.iter().map(move |line| (*channel, line))).collect();
        lines.sort_by(|(_, a), (_, b)| a.frequency_hz.total_cmp(&b.frequency_hz));
        let near = |(_, a): &(&Channel, &SpectralLine), (_, b): &(&Channel, &SpectralLine)| {
            b.frequency_hz < APART * a.frequency_hz
        };
        let mut shakes: Vec<Self> = lines.chunk_by(near).filter_map(Self::of).collect();
        shakes.sort_by(|a, b| b.most().1.total_cmp(&a.most().1));
        shakes
    }

    fn of(lines: &[(&'a Channel, &'a SpectralLine)]) -> Option<Self> {
        let (_, line) = *lines.iter().max_by(|(_, a), (_, b)| a.share_of_variance.total_cmp(&b.share_of_variance))?;
        let total: f64 = lines.iter().map(|(_, line)| line.share_of_variance).sum();
        let weighted: f64 = lines.iter().map(|(_, line)| line.share_of_variance * line.frequency_hz).sum();
        let mut axes: Vec<(&'a Channel, f64)> = Vec::new();
        for (channel, line) in lines {
            match axes.iter_mut().find(|(other, _)| other.name == channel.name) {
                Some((_, share)) => *share += line.share_of_variance,
                None => axes.push((channel, line.share_of_variance)),
            }
        }
        axes.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        Some(Self { frequency_hz: weighted / total, line, axes })
    }

    fn most(&self) -> (&'a Channel, f64) {
        self.axes[0]
    }
}

/// Something that happened on one channel, from and to seconds of data where it has a place.
struct LocatedDisturbance {
    channel: String,
    span_s: Option<(f64, f64)>,
    what: String,
}

fn disturbances(channels: &[Of<'_>], snapshot: &Snapshot) -> Option<Warning> {
    let mut found: Vec<LocatedDisturbance> =
        channels.iter().flat_map(|(channel, found)| events(channel, found)).collect();
    let start = |event: &LocatedDisturbance| event.span_s.map_or(f64::INFINITY, |(start_s, _)| start_s);
    found.sort_by(|a, b| start(a).total_cmp(&start(b)).then_with(|| a.channel.cmp(&b.channel)));
    if found.is_empty() {
        return None;
    }
    let skipped_s = snapshot.skipped.as_secs_f64();
    let place = |LocatedDisturbance { channel, span_s, what }: &LocatedDisturbance| {
        let span_s = span_s.map(|(start_s, end_s)| (start_s + skipped_s, end_s + skipped_s));
        match span_s {
            None => format!("{channel} {what}"),
            Some((start_s, end_s)) if start_s == end_s => format!("{channel} {what} at {}", clock(start_s.floor())),
            // of whole seconds, those that hold all of it
            Some((start_s, end_s)) => {
                format!("{channel} {what} from {} to {}", clock(start_s.floor()), clock(end_s.ceil()))
            }
        }
    };
    let headline = format!("not stationary: {}", list(&found, HEADLINED, place));
    let details = format!(
        "Disturbances in minutes and seconds of data, skipped time included: {}. Doors, footsteps, a bumped table, switched machines and air \
         conditioning each disturb every averaging time longer than themselves. Repeat the measurement undisturbed, or cut the record \
         there.{}",
        list(&found, MOST_NAMED, place),
        withheld(channels.iter().filter(|(_, found)| !found.is_warming_up()))
    );
    let mut axes: Vec<String> = found.into_iter().map(|event| event.channel).collect();
    axes.sort();
    axes.dedup();
    Some(Warning::new(WarningKind::NotStationary, axes, headline, details))
}

/// All but a warm-up.
fn events(channel: &Channel, found: &Disturbed) -> Vec<LocatedDisturbance> {
    let event = |span_s, what| LocatedDisturbance { channel: channel.name.to_string(), span_s, what };
    let NoiseChanges { change, bursts, frozen, spikes, .. } = &found.noise;
    let short = found
        .disturbances
        .iter()
        .map(|Disturbance { start_s, end_s, sigmas }| event(Some((*start_s, *end_s)), format!("{sigmas:.0} sigma")));
    let level = found.level_change.and_then(|change| match change.shape {
        LevelShape::Step { start_s, amplitude } => {
            Some(event(Some((start_s, start_s)), format!("a step of {amplitude:+.2e} {}", channel.unit)))
        }
        LevelShape::Cycle { period_s, amplitude } => {
            Some(event(None, format!("a cycle of {period_s:.0} s and {amplitude:.2e} {} up and down", channel.unit)))
        }
        LevelShape::WarmUp { .. } => None,
    });
    let change = change
        .map(|NoiseChange { start_s, end_s, factor, .. }| event(Some((start_s, end_s)), format!("noise x{factor:.2}")));
    let bursts = bursts.map(|ratio| {
        event(None, format!("noise in bursts (its level varies {ratio:.1} times as much as that of even noise)"))
    });
    let frozen = frozen.map(|Frozen { start_s, end_s, duration_s }| {
        event(Some((start_s, end_s)), format!("frozen for {duration_s:.1} s"))
    });
    let spikes =
        spikes.map(|Spikes { count, sigmas }| event(None, format!("{count} outliers up to {sigmas:.0} sigma")));
    short.chain([level, change, bursts, frozen, spikes].into_iter().flatten()).collect()
}

/// The axes whose slow terms are bounds only, as the rest of a sentence.
fn withheld<'a>(channels: impl Iterator<Item = &'a Of<'a>>) -> String {
    let names = names(channels.filter(|(_, found)| found.level_poses_as_noise()).map(|(channel, _)| *channel));
    match names.is_empty() {
        true => String::new(),
        false => {
            format!(
                " Noise does not explain the level change on {}: B, K and ramp are bounds only there.",
                names.join(" ")
            )
        }
    }
}

fn warm_up(axes: &[Of<'_>], snapshot: &Snapshot) -> Option<Warning> {
    let warm_ups: Vec<_> = axes
        .iter()
        .filter_map(|(channel, found)| match found.level_change?.shape {
            LevelShape::WarmUp { amplitude, time_constant_s, skip_s } => {
                Some((*channel, amplitude, time_constant_s, skip_s))
            }
            LevelShape::Step { .. } | LevelShape::Cycle { .. } => None,
        })
        .collect();
    if warm_ups.is_empty() {
        return None;
    }
    let of = |(channel, amplitude, time_constant_s, skip_s): &(&Channel, f64, f64, Option<f64>)| {
        settling(channel, *amplitude, *time_constant_s, skip_s.is_some())
    };
    let headline = format!("warm-up transient: {}", list(&warm_ups, 1, of));
    let longest = warm_ups.iter().map(|(.., skip_s)| *skip_s).reduce(|a, b| a.zip(b).map(|(a, b)| a.max(b))).flatten();
    let advice = match longest {
        Some(skip_s) => {
            let minutes = ((skip_s + snapshot.skipped.as_secs_f64()) / 60.0).ceil();
            Text::default().remedy(Remedy::Skip(Some(minutes))).then(" excludes it.")
        }
        None => "The record is too short to exclude it: let the sensor warm up and settle, and record longer.".into(),
    };
    let details = format!(
        "A sensor that warms up, a support that yields, or handling just before the start: {}. At long averaging times such a drift looks like \
         rate random walk or ramp. ",
        list(&warm_ups, MOST_NAMED, of)
    );
    let channels = names(warm_ups.iter().map(|(channel, ..)| *channel));
    let withheld = withheld(axes.iter().filter(|(_, found)| found.is_warming_up()));
    Some(Warning::new(WarningKind::WarmUp, channels, headline, Text::from(details).append(advice).then(&withheld)))
}

/// A level that does not settle within the record has no time constant that the record shows.
fn settling(channel: &Channel, amplitude: f64, time_constant_s: f64, settles: bool) -> String {
    let (name, unit) = (&channel.name, &channel.unit);
    match settles {
        true => format!("{name} starts {amplitude:+.2e} {unit} off, time constant about {time_constant_s:.0} s"),
        false => format!("{name} starts {amplitude:+.2e} {unit} off and drifts to the end of the record"),
    }
}

fn list<T>(all: &[T], most: usize, text: impl Fn(&T) -> String) -> String {
    let mut parts: Vec<_> = all.iter().take(most).map(text).collect();
    if all.len() > most {
        parts.push(format!("and {} more", all.len() - most));
    }
    parts.join("; ")
}

fn names<'a>(channels: impl Iterator<Item = &'a Channel>) -> Vec<String> {
    let mut names = Vec::new();
    for channel in channels {
        if !names.contains(&channel.name.to_string()) {
            names.push(channel.name.to_string());
        }
    }
    names
}

/// h:mm:ss, or m:ss, of whole seconds.
fn clock(seconds: f64) -> String {
    let whole = seconds as u64;
    match whole / 3600 {
        0 => format!("{}:{:02}", whole / 60, whole % 60),
        hours => format!("{hours}:{:02}:{:02}", whole / 60 % 60, whole % 60),
    }
}

#[cfg(test)]
mod tests {
    use imu_noise::LevelChange;

    use super::*;
    use crate::{Analysis, Settings};
    use vn100_protocol::VNYMR;

    #[test]
    fn a_warm_up_is_reported_with_its_time_constant_unless_it_outlasts_the_record() {
        let channel = &VNYMR.channels[9];
        let text = settling(channel, 4e-4, 51.2, true);
        assert_eq!(text, "gyro_x starts +4.00e-4 rad/s off, time constant about 51 s");
        let text = settling(channel, 4e-4, 409.6, false);
        assert_eq!(text, "gyro_x starts +4.00e-4 rad/s off and drifts to the end of the record");
    }

    #[test]
    fn a_warm_up_is_excluded_from_the_first_sample_on() {
        let shape = LevelShape::WarmUp { amplitude: 4e-4, time_constant_s: 51.2, skip_s: Some(200.0) };
        let level_change = Some(LevelChange { shape, sigmas: 9.0, is_ramp: false });
        let found = Disturbed { level_change, ..Disturbed::default() };
        let mut snapshot = Analysis::new(Settings::default()).snapshot();
        for (skipped_s, minutes) in [(0, 4.0), (45, 5.0)] {
            snapshot.skipped = std::time::Duration::from_secs(skipped_s);
            let warning = warm_up(&[(&VNYMR.channels[9], &found)], &snapshot).unwrap();
            assert_eq!(warning.details.remedies().collect::<Vec<_>>(), [&Remedy::Skip(Some(minutes))]);
        }
    }

    #[test]
    fn a_list_names_four_and_counts_the_others() {
        let listed = |count: u32| list(&(0..count).collect::<Vec<_>>(), 4, u32::to_string);
        assert_eq!((listed(0), listed(4)), (String::new(), "0; 1; 2; 3".into()));
        assert_eq!((listed(5), listed(9)), ("0; 1; 2; 3; and 1 more".into(), "0; 1; 2; 3; and 5 more".into()));
    }

    #[test]
    fn lines_within_three_percent_shake_as_one_the_strongest_first() {
        let line = |frequency_hz, share_of_variance| SpectralLine {
            frequency_hz,
            share_of_variance,
            amplitude: 1.0,
            peak_to_floor: 100.0,
        };
        let found = |lines: &[SpectralLine]| Disturbed { lines: lines.to_vec(), ..Disturbed::default() };
        // 5.0 and 5.1 Hz are one, 5.1 and 5.3 are not
        let (x, y) = (found(&[line(5.0, 0.1), line(9.0, 0.2)]), found(&[line(5.1, 0.3), line(5.3, 0.4)]));
        let channels = [(&VNYMR.channels[9], &x), (&VNYMR.channels[10], &y)];
        let shakes = Shake::all(&channels);
        let reported: Vec<_> =
            shakes.iter().map(|shake| (shake.frequency_hz, shake.most().1, shake.axes.len())).collect();
        let [(single_hz, 0.4, 1), (both_hz, 0.3, 2), (9.0, 0.2, 1)] = reported[..] else { panic!("{reported:?}") };
        assert!((single_hz - 5.3).abs() < 1e-12 && (both_hz - (0.1 * 5.0 + 0.3 * 5.1) / 0.4).abs() < 1e-12);
        assert_eq!((shakes[1].line.frequency_hz, &*shakes[1].most().0.name), (5.1, "gyro_y"));
        let warning = vibration(&channels, &[], &Analysis::new(Settings::default()).snapshot()).unwrap();
        assert_eq!(warning.channels, ["gyro_y", "gyro_x"]);
        let text = warning.to_string();
        assert!(text.contains("gyro_y 5.07 Hz (30 %), also on gyro_x"), "{text}");
        assert!(text.contains("spectral peak: gyro_y 5.30 Hz (40 %); and 2 more."), "{text}");
    }

    #[test]
    fn a_line_on_the_magnetometer_alone_is_a_field_and_shakes_nothing() {
        let line =
            |frequency_hz| SpectralLine { frequency_hz, share_of_variance: 0.35, amplitude: 1.0, peak_to_floor: 100.0 };
        let snapshot = Analysis::new(Settings::default()).snapshot();
        let (mag, gyro) = (&VNYMR.channels[3], &VNYMR.channels[10]);
        let of = |hz: f64| Disturbed { lines: vec![line(hz)], ..Disturbed::default() };
        let text = |of: &[Of<'_>]| vibration(of, &[], &snapshot).unwrap().to_string();
        let (at_20, at_7) = (of(20.0), of(7.0));
        let field = text(&[(mag, &at_20)]);
        assert!(
            !field.contains("Vibration") && field.contains("mains of 60 Hz, which shows at 60 - 40 = 20.00 Hz"),
            "{field}"
        );
        let unknown = text(&[(mag, &at_7)]);
        assert!(!unknown.contains("mains of") && unknown.contains("on the magnetometer alone"), "{unknown}");
        let both = text(&[(mag, &at_20), (gyro, &at_20)]);
        assert!(both.contains("Vibration of") && !both.contains("magnetometer alone"), "{both}");
        let apart = text(&[(mag, &at_20), (gyro, &at_7)]);
        assert!(apart.contains("Vibration of") && apart.contains("magnetometer alone"), "{apart}");
    }

    #[test]
    fn what_disturbs_is_listed_by_its_time_those_skipped_included() {
        let disturbed = |spans: &[(f64, f64)]| {
            let of = |&(start_s, end_s): &(f64, f64)| Disturbance { start_s, end_s, sigmas: 12.0 };
            Disturbed { disturbances: spans.iter().map(of).collect(), ..Disturbed::default() }
        };
        let (x, y) = (disturbed(&[(61.2, 64.3)]), disturbed(&[(7.9, 7.9)]));
        let mut snapshot = Analysis::new(Settings::default()).snapshot();
        snapshot.skipped = std::time::Duration::from_secs(60);
        let warning = disturbances(&[(&VNYMR.channels[9], &x), (&VNYMR.channels[10], &y)], &snapshot).unwrap();
        assert_eq!(warning.channels, ["gyro_x", "gyro_y"]);
        let text = warning.to_string();
        assert!(text.contains("included: gyro_y 12 sigma at 1:07; gyro_x 12 sigma from 2:01 to 2:05."), "{text}");
    }

    #[test]
    fn times_are_printed_as_clocks_do() {
        for (seconds, text) in
            [(0.0, "0:00"), (61.0, "1:01"), (3599.0, "59:59"), (3600.0, "1:00:00"), (36_061.0, "10:01:01")]
        {
            assert_eq!(clock(seconds), text);
        }
    }
}
