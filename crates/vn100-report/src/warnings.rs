//! The table of warnings: the text of each finding, and for each kind its meaning, its consequence
//! and a cure. Every face takes its words from here; severities and codes are those of
//! [`WarningKind`].

use vn100_analysis::noise::STANDARD_GRAVITY_M_S2;
use vn100_analysis::protocol::Quantity;
use vn100_analysis::timebase::Unevenness;
use vn100_analysis::{
    Doubt, Doubtful, Event, Finding, Happening, Peak, Rejected, Remedy, RemedyWords, Setting, Warning, WarningKind,
};

use crate::{
    names::{motion_text, names_of},
    numbers::plain::{counted, ppm, short},
};

/// What a kind of warning means, whatever was found.
#[derive(Debug, Clone, Copy)]
pub struct WarningWords {
    /// What it does to the result.
    pub why: &'static str,
    /// What to do, beside the remedies; empty if these say all.
    pub advice: &'static str,
    /// What may help, if a warning has no remedy of its own.
    pub remedies: &'static [Remedy],
    /// The standard or manual on the matter; may be empty.
    pub source: &'static str,
}

/// The words of a kind.
pub fn warning_words(kind: WarningKind) -> WarningWords {
    let (_, why, advice, remedies, source) = WORDS[kind as usize];
    WarningWords { why, advice, remedies, source }
}

const REGISTER_6: &str = "VectorNav VN-100 User Manual, register 6 and its messages";
const REGISTER_7: &str = "VectorNav VN-100 User Manual, register 7";
const ALLAN: &str = "IEEE Std 952-1997, annex C; NIST SP 1065";

/// The kinds in their order, each with its [`WarningWords`].
const WORDS: [(WarningKind, &str, &str, &[Remedy], &str); WarningKind::ALL.len()] = [
    (
        WarningKind::Incomplete,
        "What is there is measured in full; the rest is missing, and long averaging times with it.",
        "Check cable and supply of the sensor, and the disk; copy a file again if the original is whole.",
        &[],
        "",
    ),
    (
        WarningKind::NoValidLines,
        "There is no result.",
        "A wrong baud rate, another message or another format gives none, as does a program that cuts or changes lines.",
        &[Remedy::MapColumns(None), Remedy::Configure(Setting::Message("VNIMU"))],
        REGISTER_6,
    ),
    (
        WarningKind::OtherMessages,
        "Messages that share a port are sent at different times; one of them is measured.",
        "Set one output message.",
        &[Remedy::Configure(Setting::Message("VNIMU"))],
        REGISTER_6,
    ),
    (
        WarningKind::LinkErrors,
        "Samples may be missing, and lines may be cut.",
        "End other programs on the port. After an overflow raise the baud rate, lower the output rate or shorten the message.",
        &[Remedy::Plan],
        "VectorNav VN-100 User Manual, system error codes",
    ),
    (
        WarningKind::StreamChanged,
        "A record is of one sensor at one rate: what differs is excluded, or mixed into the result as the text says.",
        "Set the sensor before the measurement, keep other programs off the port, and measure each sensor by itself.",
        &[],
        REGISTER_7,
    ),
    (
        WarningKind::Gaps,
        "Clusters average the samples that are there, and those that lack more than half are excluded. Short gaps cost little.",
        "Check cable, baud rate and USB hub; let the sensor append its counter. Channels with a rate of their own belong in a file of their own.",
        &[],
        "",
    ),
    (
        WarningKind::RejectedLines,
        "Each rejected one of the measured message is a dropped sample; a damaged digit without a checksum is not detected.",
        "The link (cable, connector, baud rate) damages them, or the program that wrote a file. Switch the checksum on (register 30).",
        &[Remedy::AcceptUnchecked],
        "",
    ),
    (
        WarningKind::RepeatedLines,
        "If a capture was looped or stored twice, its intervals are too narrow. Repeated packets and rows are measured once.",
        "Analyse one copy.",
        &[],
        "",
    ),
    (
        WarningKind::TooShort,
        "Intervals are wide, and B and K are not observable.",
        "N needs minutes, B ten minutes to hours, K hours to days.",
        &[Remedy::Plan],
        ALLAN,
    ),
    (
        WarningKind::RateAssumed,
        "All averaging times scale with it: 1 % of the rate is 1 % of every tau and 0.5 % of N.",
        "",
        &[Remedy::GiveRate(None)],
        REGISTER_7,
    ),
    (
        WarningKind::RateOffNominal,
        "Averaging times and densities are wrong by the difference, unless the time stamps are wrong.",
        "Registers may be those of another port, and a device between may repeat or select lines.",
        &[Remedy::GiveRate(None)],
        REGISTER_7,
    ),
    (
        WarningKind::StampsDoubtful,
        "Averaging times count samples and not stamps. Dropped samples at these places are detected less surely, or not at all.",
        "Record with a clock that is not set meanwhile, shorten the latency timer of a USB adapter to 1 ms, and check the supply of a \
         sensor that restarts.",
        &[Remedy::MapColumns(None), Remedy::GiveRate(None), Remedy::MeasureLive],
        "",
    ),
    (
        WarningKind::VibrationLine,
        "They raise the deviation up to their period. N is taken from the rest; if they cover most of the band, it is only bounded.",
        "Isolate the sensor on a heavy base with soft feet; keep magnetometers away from mains and motors.",
        &[],
        "",
    ),
    (
        WarningKind::NotStationary,
        "Noise parameters assume a stationary record at rest. B and K beside a change of the level are bounds, and a moved sensor has none.",
        "Measure without footsteps, doors and machines nearby, or cut the record there.",
        &[Remedy::Skip(None), Remedy::EndEarlier],
        "",
    ),
    (
        WarningKind::WarmUp,
        "At long averaging times the transient looks like K or R, which are bounds beside it.",
        "Let the sensor warm up and settle before the record.",
        &[Remedy::Skip(None)],
        "",
    ),
    (
        WarningKind::FollowsTemperature,
        "Part of the deviation at long averaging times is temperature, not noise: B, K and R are bounds.",
        "Record at a constant temperature.",
        &[],
        "",
    ),
    (
        WarningKind::MagnitudeOff,
        "Bias or scale factor are off, iron or a current is near, or the sensor was not at rest. Noise is hardly affected.",
        "Calibrate the accelerometer in six positions, and the magnetometer for hard and soft iron.",
        &[],
        "",
    ),
    (
        WarningKind::CompensatedStream,
        "B, K and R of the gyroscope are not measurable, however long the record; N is.",
        "Record the uncompensated output.",
        &[Remedy::MeasureWith(Setting::Message("VNIMU"))],
        REGISTER_6,
    ),
    (
        WarningKind::CompensationUnknown,
        "If one has, B, K and R are those of the filter, not of the sensor.",
        "",
        &[Remedy::SayCompensated],
        "",
    ),
    (
        WarningKind::LowPass,
        "N is the density at low frequencies; its interval holds with every filter that the record does not decide against.",
        "Widen the bandwidth of a filter that is not intended.",
        &[Remedy::GiveWindow],
        "",
    ),
    (
        WarningKind::SensorSettings,
        "Axes of a vehicle mix those of the sensor: one noisy axis shows on several. The register counts, not what was given.",
        "For figures of each axis of the sensor reset register 26.",
        &[],
        "VectorNav VN-100 User Manual, registers 26 and 85",
    ),
    (
        WarningKind::QuantisationFloor,
        "The curve is that of the rounding, or the channel is dead.",
        "Use an output with more digits; of values with a large constant part subtract that.",
        &[],
        "",
    ),
    (
        WarningKind::CorrelatedNoise,
        "It looks like B on a short stretch of the curve. N holds below the correlation time.",
        "Look for vibration, temperature control or air flow. For a Kalman filter model it as a Gauss-Markov process.",
        &[],
        ALLAN,
    ),
    (
        WarningKind::FullRange,
        "Values beyond a range (2.5 gauss, 16 g, 2000 deg/s) are clipped; their statistics, and the mean of such an angle, are wrong.",
        "Keep the sensor at rest, away from magnets and shocks.",
        &[],
        "",
    ),
    (
        WarningKind::UnitDoubtful,
        "A wrong unit scales every result of the channel.",
        "",
        &[Remedy::MapColumns(None)],
        "",
    ),
];

/// What was found, in a few words without a full stop.
pub fn headline(warning: &Warning) -> String {
    let on = warning.channels.join(" ");
    match &warning.finding {
        Finding::Said(text) => text.clone(),
        Finding::RecordingCut => "the recording was cut: its end or a part is missing".into(),
        Finding::OnlyReplies(replies, None) => {
            format!("{}, all of them replies: asynchronous output is off", counted(*replies, "line"))
        }
        Finding::OnlyReplies(replies, Some(output)) => format!(
            "{}, all of them replies: output {output} is set (register 6), and paused or lost",
            counted(*replies, "line")
        ),
        Finding::NothingMeasured(packets, sentences, first) => {
            let first = first.map_or_else(String::new, |first| format!(", the first {first},"));
            let (packets, sentences) = (counted(*packets, "binary packet"), counted(*sentences, "valid line"));
            format!("{packets} and {sentences}{first} of no message that is measured")
        }
        Finding::NoSentence(bytes) => format!("{bytes} bytes without a valid line"),
        Finding::OtherSentences(count, first, measured) => {
            format!("{} of another message excluded, first {first}; {measured} measured", counted(*count, "line"))
        }
        Finding::OtherPackets(count, header, measured) => {
            let header = header.map_or_else(String::new, |header| format!(" ({header})"));
            format!("{}{header} excluded, {measured} measured", counted(*count, "other binary packet"))
        }
        Finding::SplitPackets(parts) => {
            format!("{} of split packets skipped: they have too many fields", counted(*parts, "part"))
        }
        Finding::DeviceError(error, count) => format!("unsolicited device error, {}: {error}", counted(*count, "time")),
        Finding::PortShared(program) => format!("{program} has the port open too"),
        Finding::RateChanged(change, excluded) => format!(
            "sample rate changed from {} to {} Hz after {}: {} at another rate excluded",
            short(change.from_hz),
            short(change.to_hz),
            counted(change.after_samples, "sample"),
            counted(*excluded, "sample")
        ),
        Finding::FalseRate { samples, arrival_hz, device_hz } => format!(
            "first {} excluded: taken for {} Hz before the sensor reported {} Hz",
            counted(*samples, "sample"),
            short(*arrival_hz),
            short(*device_hz)
        ),
        Finding::BurstExcluded(samples) => {
            format!("{} at another rate excluded: they arrived in a burst", counted(*samples, "sample"))
        }
        Finding::TwoSensors([before, then], is_excluded) => {
            let result = if *is_excluded { "the second is excluded" } else { "the result mixes two sensors" };
            format!("serial number changed from {before} to {then}: {result}")
        }
        Finding::DecimalsChanged(times) => format!("number of printed decimals changed {}", counted(*times, "time")),
        Finding::Dropped { missing, gaps, samples } => format!(
            "{} dropped in {} ({:.2} % of the record)",
            counted(*missing, "sample"),
            counted(*gaps, "gap"),
            100.0 * *missing as f64 / (missing + samples) as f64
        ),
        Finding::TimeSteps(times) => {
            format!("the sensor's own time stepped ahead {}: samples lost there are unknown", counted(*times, "time"))
        }
        Finding::Absent(rows, channels) => {
            let counts: Vec<_> = channels.iter().map(|(channel, absent)| format!("{channel} {absent}")).collect();
            format!("values absent in {}: {}", counted(*rows, "row"), counts.join(", "))
        }
        Finding::OutOfRange(count, rows) => {
            format!(
                "{count} of {rows} values of {on} are far beyond those of the first rows or the sensor's range, and missing"
            )
        }
        Finding::Rejected(what, count, of) | Finding::AllRejected(what, count, of) => rejected(what, *count, *of),
        Finding::Repeated(count, of) => format!("{count} of {} repeat an earlier one exactly", counted(*of, "sample")),
        Finding::TooShort(samples @ 0..2) => format!("{}: a deviation needs at least 2", counted(*samples, "sample")),
        Finding::TooShort(samples) => {
            format!("{} are few: N, B and K are uncertain, or not observable", counted(*samples, "sample"))
        }
        Finding::RateAssumed(hz) => format!("sample rate unknown: {hz} Hz assumed, the factory default"),
        Finding::RateUnsure(hz, missing) => {
            format!("rate of {hz:.2} Hz unsure: by its times {:.0} % of the samples are missing", 100.0 * missing)
        }
        Finding::RateNotListed(hz) => format!("lines arrive at {hz} Hz, which is not one of the sensor's rates"),
        Finding::RateOff(measured_hz, nominal_hz) => format!(
            "measured rate {measured_hz:.4} Hz, {} from the nominal {nominal_hz} Hz",
            ppm(1e6 * (measured_hz / nominal_hz - 1.0))
        ),
        Finding::PacketRate(hz) => {
            format!("{hz:.2} Hz by the packets' own time: a VN-100 sends at 800 Hz over a whole number")
        }
        Finding::RegisterRate(register, set_hz, hz) => {
            format!("register {register} sets packets of {set_hz} Hz, but they come at {hz} Hz by their own time")
        }
        Finding::FalseReport { reported_hz, arrival_hz } => {
            let [reported, arrival] = [reported_hz, arrival_hz].map(|hz| short(*hz));
            format!("the sensor reports {reported} Hz, but its lines arrive at {arrival} Hz")
        }
        Finding::Backwards(times) => format!("time stamps step backwards {}", counted(*times, "time")),
        Finding::Reordered(rows) => {
            format!("{} out of order or with a false time, put in order", counted(*rows, "row"))
        }
        Finding::Restarts(times) => {
            format!("the sensor restarted {}: samples lost there are unknown", counted(*times, "time"))
        }
        Finding::StampsRefused(refusal, false) => refusal.to_string(),
        Finding::StampsRefused(refusal, true) => format!("{refusal}; until the link disconnected"),
        Finding::Together(share, together) => {
            format!("{:.0} % of the lines arrive together with the one before, {together:.1} at a time", 100.0 * share)
        }
        Finding::Flushed(rows) => format!("the first {} had waited, and were stamped together", counted(*rows, "row")),
        Finding::Uneven(Unevenness::Bursts | Unevenness::Pairs) => {
            "rows come several at a time, as read from a buffer".into()
        }
        Finding::Uneven(Unevenness::CoarseClock) => {
            "stamps are those of a coarse clock, whose ticks are about as long as the steps between rows".into()
        }
        Finding::Uneven(Unevenness::Irregular) => {
            "stamps are not equally spaced: wrong if the sampling is not, right if the stamps alone are uneven".into()
        }
        Finding::Peaks(peaks) => format!("spectral peak: {}", list(peaks, 1, peak)),
        Finding::NoFreeBand => format!("spectral peaks cover more than half of the band on {on}"),
        Finding::Moved(motion) => motion_text(motion),
        Finding::Events(events) => format!("not stationary: {}", list(events, 1, happening)),
        Finding::WarmUp(found) => format!("warm-up transient: {}", list(found, 1, warm_up)),
        Finding::Temperature(_, share) if *share <= 0.0 => format!("bias of {on} follows the temperature"),
        Finding::Temperature(worst, share) => {
            format!("bias of {on} follows the temperature, up to {:.0} % of the variance of {worst}", 100.0 * share)
        }
        Finding::Gravity(m_s2) => {
            format!("mean acceleration {m_s2:.3} m/s^2, {:+.3} from standard gravity", m_s2 - STANDARD_GRAVITY_M_S2)
        }
        Finding::Field(gauss) => format!("mean magnetic field {gauss:.4} gauss; the Earth's is 0.22 to 0.67"),
        Finding::Compensated(message) => format!("{message} is bias-compensated: gyro B and K not measurable"),
        Finding::BiasTracked => format!("a filter removes the bias of {on}: B and K not measurable"),
        Finding::MaybeCompensated => "unknown whether a filter has removed the gyroscope bias".into(),
        Finding::LowPass(samples) => {
            format!("low-pass filter on {on}: white noise correlated over {samples:.1} samples")
        }
        Finding::Rotated => "axes rotated by the sensor (register 26)".into(),
        Finding::WindowIgnored(given, Some([accel, gyro])) => {
            format!("averaging window {given} ignored: register 85 is {accel} (accel), {gyro} (gyro)")
        }
        Finding::WindowIgnored(given, None) => {
            format!("averaging window {given} ignored: only rates and accelerations in messages of a VN-100 have one")
        }
        Finding::TwoValues => format!("no more than two values on {on}"),
        Finding::RoundedAway => format!("quantisation hides the noise of {on}"),
        Finding::Correlated(found) => {
            format!("correlated noise, in addition to white noise: {}", list(found, 1, process))
        }
        Finding::Saturated(samples, axes, [from_s, to_s]) => {
            let axes: Vec<_> = axes.iter().map(|(axis, count)| format!("{axis} {count}")).collect();
            format!(
                "the sensor reports saturation in {}, from {from_s:.3} to {to_s:.3} s: {}",
                counted(*samples, "sample"),
                axes.join(", ")
            )
        }
        Finding::RangeReached => format!("end of the sensor's range reached on {on}"),
        Finding::TurnsRestarted => format!("{on} restarted after several thousand turns"),
        Finding::UnitDoubtful(doubts) => list(doubts, doubts.len(), doubtful),
    }
}

fn rejected(what: &Rejected, count: u64, of: u64) -> String {
    let of_lines = || format!("{count} of {} rejected", counted(of, "line"));
    let of_packets = || format!("{count} of {} rejected", counted(of, "packet"));
    match what {
        Rejected::Rows(rows) => {
            let reasons: Vec<_> = rows.iter().map(|(reason, count)| format!("{reason} {count}")).collect();
            format!("{} ({})", of_lines(), reasons.join(", "))
        }
        Rejected::Sentences => format!("{}: checksum mismatch or malformed", of_lines()),
        Rejected::Malformed => format!("{}: malformed", of_lines()),
        Rejected::Packets => format!("{}: checksum mismatch", of_packets()),
        Rejected::PacketNumbers => format!("{}: impossible numbers", of_packets()),
        Rejected::PacketTimes => format!("{}: false time", of_packets()),
        Rejected::NoChecksum => format!("{}: no checksum", of_lines()),
        Rejected::AcceptedUnchecked => format!("{count} of {} accepted without a checksum", counted(of, "line")),
    }
}

fn peak(Peak { frequency_hz, axes, .. }: &Peak) -> String {
    let Some((first, share)) = axes.first() else { return format!("{frequency_hz:.2} Hz") };
    let share = if *share < 0.01 { "< 1 %".into() } else { format!("{:.0} %", 100.0 * share) };
    format!("{first} {frequency_hz:.2} Hz ({share})")
}

/// On which other axes a peak is, and what it may be.
fn origin(Peak { axes, aliases_hz, mains_hz, .. }: &Peak) -> String {
    let others: Vec<_> = axes.iter().skip(1).map(|(axis, _)| axis.as_str()).collect();
    let also = if others.is_empty() { String::new() } else { format!(", also on {}", others.join(" ")) };
    let mains = mains_hz.map_or_else(String::new, |hz| format!(", a field that may be {hz} Hz of mains"));
    let aliases: Vec<_> = aliases_hz.iter().map(|hz| format!("{hz:.1}")).collect();
    let alias = if aliases.is_empty() { String::new() } else { format!(", or an alias of {} Hz", aliases.join(", ")) };
    format!("{also}{mains}{alias}")
}

fn happening(Happening { channel, span_s, what }: &Happening) -> String {
    let what = match what {
        Event::Sigmas(sigmas) => format!("{sigmas:.0} sigma"),
        Event::Step(amplitude, unit) => format!("a step of {amplitude:+.2e} {unit}"),
        Event::Cycle(period_s, amplitude, unit) => {
            format!("a cycle of {period_s:.0} s and {amplitude:.2e} {unit} up and down")
        }
        Event::NoiseFactor(factor) => format!("noise x{factor:.2}"),
        Event::Bursts(ratio) => {
            format!("noise in bursts (its level varies {ratio:.1} times as much as that of even noise)")
        }
        Event::Frozen(duration_s) => format!("frozen for {duration_s:.1} s"),
        Event::Outliers(count, sigmas) => format!("{} up to {sigmas:.0} sigma", counted(*count, "outlier")),
    };
    match *span_s {
        None => format!("{channel} {what}"),
        Some((start_s, end_s)) if start_s == end_s => format!("{channel} {what} at {}", clock(start_s.floor())),
        // of whole seconds, those that hold all of it
        Some((start_s, end_s)) => {
            format!("{channel} {what} from {} to {}", clock(start_s.floor()), clock(end_s.ceil()))
        }
    }
}

/// A level that does not settle within the record has no time constant that the record shows.
fn warm_up((channel, amplitude, unit, time_constant_s, settles): &(String, f64, String, f64, bool)) -> String {
    match settles {
        true => format!("{channel} starts {amplitude:+.2e} {unit} off, time constant about {time_constant_s:.0} s"),
        false => format!("{channel} starts {amplitude:+.2e} {unit} off and drifts to the end of the record"),
    }
}

fn process((channel, sigma, unit, time_s, apparent): &(String, f64, String, f64, f64)) -> String {
    format!(
        "{channel} {sigma:.2e} {unit} over about {time_s:.1} s, apparent random walk {apparent:.3e} {unit}/sqrt(Hz)"
    )
}

fn doubtful(Doubtful { quantity, by, value, read, likely }: &Doubtful) -> String {
    let noun = match quantity {
        Quantity::AngularRate => "rate",
        other => names_of(*other).quantity,
    };
    let seen = match by {
        Doubt::Mean => format!("mean {noun} {}", short(*value)),
        Doubt::Largest => format!("a {noun} of {value:.1}, beyond the range of inertial sensors"),
        Doubt::Noise => format!("{noun}s differ by {value:.3} from sample to sample on every axis"),
    };
    format!("{seen}, read as {read}: are the columns in {likely}?")
}

/// The places of a warning, if a headline has no room for what is known of them; empty for others.
fn places(finding: &Finding) -> String {
    const NAMED: usize = 4;
    let list = match finding {
        Finding::Peaks(peaks) if peaks.len() > 1 || peaks.iter().any(|only| !origin(only).is_empty()) => {
            list(peaks, NAMED, |found| peak(found) + &origin(found))
        }
        Finding::Events(events) if events.len() > 1 => list(events, NAMED, happening),
        Finding::WarmUp(found) if found.len() > 1 => list(found, NAMED, warm_up),
        Finding::Correlated(found) if found.len() > 1 => list(found, NAMED, process),
        _ => return String::new(),
    };
    format!("Found: {list}.")
}

/// The first of them, and how many more there are; documents have them all.
fn list<T>(all: &[T], named: usize, text: impl Fn(&T) -> String) -> String {
    let mut parts: Vec<_> = all.iter().take(named).map(text).collect();
    parts.extend((all.len() > named).then(|| format!("and {} more", all.len() - named)));
    parts.join("; ")
}

/// h:mm:ss, or m:ss, of whole seconds.
fn clock(seconds: f64) -> String {
    let whole = seconds as u64;
    match whole / 3600 {
        0 => format!("{}:{:02}", whole / 60, whole % 60),
        hours => format!("{hours}:{:02}:{:02}", whole / 60 % 60, whole % 60),
    }
}

/// Code and headline, in one line.
pub fn title(warning: &Warning) -> String {
    format!("{}: {}", warning.kind.name(), headline(warning))
}

/// The places, the consequence, the advice and the remedies of a warning, in sentences.
pub fn details(warning: &Warning, words: RemedyWords) -> String {
    let WarningWords { why, advice, .. } = warning_words(warning.kind);
    let sentences = [places(&warning.finding), why.into(), advice.into()].into_iter().filter(|text| !text.is_empty());
    sentences.chain(actions(&warning.remedies, words)).collect::<Vec<_>>().join(" ")
}

/// What was found, and the [`details`].
pub fn in_words(warning: &Warning, words: RemedyWords) -> String {
    let headline = headline(warning);
    let stop = if headline.ends_with('?') { "" } else { "." };
    format!("{headline}{stop} {}", details(warning, words))
}

/// The text with a capital first letter.
pub(crate) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A sentence for each remedy.
pub fn actions(remedies: &[Remedy], words: RemedyWords) -> Vec<String> {
    remedies.iter().map(|remedy| capitalised(&words(remedy)) + ".").collect()
}

#[cfg(test)]
mod tests {
    use vn100_analysis::Severity;
    use vn100_analysis::protocol::DeviceError;
    use vn100_analysis::timebase::Refusal;

    use super::*;
    use crate::remedies::{page_words, python_words, remedy_words};

    fn on(kind: WarningKind, finding: Finding) -> Warning {
        let warning = Warning::new(finding).of(["gyro_x".into(), "gyro_y".into()]);
        assert_eq!(warning.kind, kind, "{warning:?}");
        warning
    }

    /// One finding of each kind at least, and what its headline says.
    fn samples() -> Vec<(Warning, &'static str)> {
        use WarningKind as Kind;
        let doubt = |quantity, by, value, likely| Doubtful { quantity, by, value, read: "x".into(), likely };
        let step = Happening {
            channel: "gyro_z".into(),
            span_s: Some((67.9, 67.9)),
            what: Event::Step(2.0e-3, "rad/s".into()),
        };
        let noise =
            Happening { channel: "gyro_x".into(), span_s: Some((3661.2, 3663.1)), what: Event::NoiseFactor(1.5) };
        let peak = |axes: &[&str], mains_hz| Peak {
            frequency_hz: 5.0,
            axes: axes.iter().map(|axis| ((*axis).to_owned(), 0.3)).collect(),
            aliases_hz: vec![35.0, 45.0],
            mains_hz,
        };
        let settling = |settles| ("gyro_x".into(), 4e-4, "rad/s".into(), 51.2, settles);
        let refusal = Refusal::NoTimePasses { samples: 9 };
        let dropped = Finding::Dropped { missing: 1, gaps: 1, samples: 99 };
        vec![
            (on(Kind::Incomplete, Finding::Said("the disk is full".into())), "the disk is full"),
            (on(Kind::NoValidLines, Finding::OnlyReplies(3, Some("14".into()))), "output 14 is set"),
            (
                on(Kind::OtherMessages, Finding::OtherPackets(2, None, "VNYMR".into())),
                "2 other binary packets excluded, VNYMR",
            ),
            (
                on(Kind::LinkErrors, Finding::DeviceError(DeviceError::OutputBufferOverflow, 2)),
                "device error, 2 times: VNERR",
            ),
            (on(Kind::StreamChanged, Finding::TwoSensors(["1".into(), "2".into()], true)), "the second is excluded"),
            (on(Kind::Gaps, dropped), "1 sample dropped in 1 gap (1.00 % of the record)"),
            (on(Kind::Gaps, Finding::Absent(8, vec![("yaw".into(), 5)])), "values absent in 8 rows: yaw 5"),
            (on(Kind::RejectedLines, Finding::Rejected(Rejected::Sentences, 2, 9)), "2 of 9 lines rejected: checksum"),
            (on(Kind::RepeatedLines, Finding::Repeated(3, 6)), "3 of 6 samples repeat"),
            (on(Kind::TooShort, Finding::TooShort(1)), "1 sample: a deviation needs at least 2"),
            (on(Kind::RateAssumed, Finding::RateAssumed(40.0)), "40 Hz assumed"),
            (on(Kind::RateOffNominal, Finding::RateOff(40.05, 40.0)), "+1250 ppm from the nominal 40 Hz"),
            (on(Kind::StampsDoubtful, Finding::StampsRefused(refusal, true)), "until the link disconnected"),
            (
                on(Kind::VibrationLine, Finding::Peaks(vec![peak(&["mag_x"], Some(60.0))])),
                "mag_x 5.00 Hz (30 %), a field that may be 60 Hz of mains",
            ),
            (
                on(Kind::VibrationLine, Finding::Peaks(vec![peak(&["gyro_x", "gyro_y"], None)])),
                ", also on gyro_y, or an alias of 35.0, 45.0 Hz.",
            ),
            (
                on(Kind::NotStationary, Finding::Events(vec![step, noise])),
                "gyro_z a step of +2.00e-3 rad/s at 1:07; gyro_x noise x1.50 from 1:01:01 to 1:01:04",
            ),
            (
                on(Kind::WarmUp, Finding::WarmUp(vec![settling(true)])),
                "gyro_x starts +4.00e-4 rad/s off, time constant about 51 s",
            ),
            (
                on(Kind::WarmUp, Finding::WarmUp(vec![settling(false); 5])),
                "drifts to the end of the record; and 1 more.",
            ),
            (
                on(Kind::FollowsTemperature, Finding::Temperature("gyro_y".into(), 0.5)),
                "up to 50 % of the variance of gyro_y",
            ),
            (on(Kind::MagnitudeOff, Finding::Gravity(3.923)), "3.923 m/s^2, -5.884 from standard gravity"),
            (on(Kind::CompensatedStream, Finding::BiasTracked), "removes the bias of gyro_x gyro_y"),
            (on(Kind::CompensationUnknown, Finding::MaybeCompensated), "unknown whether"),
            (on(Kind::LowPass, Finding::LowPass(4.0)), "white noise correlated over 4.0 samples"),
            (on(Kind::SensorSettings, Finding::WindowIgnored(20, Some([4, 4]))), "averaging window 20 ignored"),
            (on(Kind::QuantisationFloor, Finding::TwoValues), "no more than two values on gyro_x gyro_y"),
            (
                on(
                    Kind::CorrelatedNoise,
                    Finding::Correlated(vec![("gyro_x".into(), 1e-4, "rad/s".into(), 2.0, 3e-5)]),
                ),
                "apparent random walk 3.000e-5 rad/s/sqrt(Hz)",
            ),
            (
                on(Kind::FullRange, Finding::Saturated(3, vec![("accel_x".into(), 3)], [1.0, 2.0])),
                "from 1.000 to 2.000 s: accel_x 3",
            ),
            (
                on(
                    Kind::UnitDoubtful,
                    Finding::UnitDoubtful(vec![doubt(Quantity::Acceleration, Doubt::Mean, 1.02, "g")]),
                ),
                "mean acceleration 1.02, read as x: are the columns in g?",
            ),
            (
                on(
                    Kind::UnitDoubtful,
                    Finding::UnitDoubtful(vec![doubt(Quantity::AngularRate, Doubt::Noise, 0.5, "deg/s")]),
                ),
                "rates differ by 0.500",
            ),
        ]
    }

    #[test]
    fn every_kind_is_worded_for_every_audience() {
        let samples = samples();
        for kind in WarningKind::ALL {
            assert!(samples.iter().any(|(warning, _)| warning.kind == kind), "{kind:?}");
            assert_eq!(WORDS[kind as usize].0, kind);
        }
        for (warning, said) in samples {
            let text = in_words(&warning, page_words);
            assert!(text.contains(said), "{text}");
            let remedies = warning_words(warning.kind).remedies;
            let cured = remedies.iter().cloned().fold(warning, Warning::cured_by);
            for words in [remedy_words, python_words, page_words] {
                let text = in_words(&cured, words);
                assert!(text.ends_with('.') && !text.contains("..") || text.contains(",..."), "{text}");
                assert!(!text.contains("  ") && text.len() > headline(&cured).len(), "{text}");
            }
            for words in [python_words, page_words] {
                let text = in_words(&cured, words);
                assert!(!text.contains("--") && !text.contains("vn100 "), "{text}");
            }
        }
    }

    #[test]
    fn a_question_needs_no_full_stop() {
        let doubt = Doubtful {
            quantity: Quantity::Pressure,
            by: Doubt::Mean,
            value: 1013.0,
            read: "kPa".into(),
            likely: "hPa",
        };
        let warning = Warning::new(Finding::UnitDoubtful(vec![doubt]));
        let warning = warning.cured_by(Remedy::MapColumns(Some("pressure=p:hPa,t=t:s".into())));
        let text = in_words(&warning, page_words);
        assert!(text.contains("are the columns in hPa? A wrong unit"), "{text}");
        assert!(text.ends_with("Read the columns as pressure=p:hPa,t=t:s."), "{text}");
        assert_eq!((warning.severity, title(&warning).starts_with("unit-doubtful: mean")), (Severity::Problem, true));
    }
}
