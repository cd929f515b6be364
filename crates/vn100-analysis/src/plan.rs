//! From what a record is to show to how the sensor is set, and how long it must rest.

use std::sync::Arc;

use imu_noise::{Aim, Sensor, Term, Wanted};
use thiserror::Error;
use vn100_protocol::{
    AsyncRate, AsyncType, BaudRate, Channel, Layout, LinkLoad, MEASUREMENTS_PER_S, OUTPUT_RATES_HZ, PACKET_MESSAGES,
    PacketMessage, ProtocolControl, VNIMU,
};

use crate::{
    datasheet::{Datasheet, floor_of_flicker},
    noise_figure::NoiseFigure,
    sensor::{sensor_name, sensor_of},
    want::{Known, Want},
};

/// The rate of sentences in hertz: the factory default.
const SENTENCES_HZ: u32 = 40;

/// The rate of packets in hertz, at which the factory default of the window aliases no noise.
const PACKETS_HZ: u32 = 200;

const FASTEST: BaudRate = BaudRate::ALL[BaudRate::ALL.len() - 1];

/// The number of slow terms that are tested in one record: B, K and R of six axes.
pub(crate) const SLOW_TERMS: usize = 18;

/// Published practice excludes a warm-up between these lengths, in seconds; the maker states none.
const WARM_UP_S: [f64; 2] = [600.0, 1800.0];

/// What the sensor is to send: in either case angular rates that contain the bias of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlannedMessage {
    /// Packets with the device time.
    Packets(PacketMessage),
    /// Sentences with a counter.
    Sentences,
}

/// The distance of independent samples with which N would be estimated as precisely, behind the
/// low-pass filter of the sensor and with windows that alias no noise: in seconds, and in
/// intervals. From emulated records it was 64 to 91 ms at 200 and 800 Hz, and six intervals at 40
/// Hz; planned with 80 ms, 18 of 24 records met ±2 %.
const BEHIND_LOW_PASS_S: f64 = 0.1;
const BEHIND_LOW_PASS_INTERVALS: f64 = 6.0;

/// The same of the magnetometer, which has no low-pass filter that a stream shows: it is looked for all
/// the same. Planned with one interval, 13 of 40 emulated records met ±2 %, 24 of 40 ±5 % and 17 of 40
/// ±10 %; with three of them, 34, 35 and 37.
const WITHOUT_LOW_PASS_INTERVALS: f64 = 3.0;

impl PlannedMessage {
    /// The sentence that [`Sentences`](Self::Sentences) stands for.
    const SENTENCE: AsyncType = AsyncType::IMU;

    /// The planned message with this name, in any letter case; `None` for any other.
    pub fn named(name: &str) -> Option<Self> {
        let is_sentence = Self::Sentences.name().eq_ignore_ascii_case(name);
        PacketMessage::named(name).map(Self::Packets).or(is_sentence.then_some(Self::Sentences))
    }

    /// The name by which the sensor is set to the message.
    pub fn name(self) -> &'static str {
        match self {
            Self::Packets(packets) => packets.name,
            Self::Sentences => Self::SENTENCE.header().unwrap_or_default(),
        }
    }

    /// The channels of a row.
    fn layout(self) -> Option<Arc<Layout>> {
        match self {
            Self::Packets(packets) => packets.layout(),
            Self::Sentences => Some(Arc::new(VNIMU.clone())),
        }
    }

    /// Whether the message has axes of this sensor.
    pub fn holds(self, sensor: Sensor) -> bool {
        let is_of = |channel: &Channel| sensor_of(channel.quantity) == Some(sensor);
        self.layout().is_some_and(|layout| layout.channels.iter().any(is_of))
    }

    /// Seconds between independent samples with which N of the axes of a sensor would be estimated as
    /// precisely: more than between two samples, as a low-pass filter correlates neighbours or may do so.
    fn interval_s(self, sensor: Sensor, rate_hz: u32) -> f64 {
        let is_of = |channel: &&Channel| sensor_of(channel.quantity) == Some(sensor);
        let layout = self.layout();
        let channel = layout.as_ref().and_then(|layout| layout.channels.iter().find(is_of));
        let stride = channel.map_or(1, |channel| channel.stride(rate_hz.into()));
        let interval_s = stride as f64 / f64::from(rate_hz);
        match sensor {
            Sensor::Magnetometer => WITHOUT_LOW_PASS_INTERVALS * interval_s,
            Sensor::Gyroscope | Sensor::Accelerometer => {
                (BEHIND_LOW_PASS_INTERVALS * interval_s).max(BEHIND_LOW_PASS_S)
            }
        }
    }

    /// Bytes of a packet, or of a sentence with its counter.
    fn frame_bytes(self) -> u32 {
        let control = ProtocolControl { serial_count: 3, ..ProtocolControl::default() };
        match self {
            Self::Packets(packets) => packets.packet_length() as u32,
            Self::Sentences => Self::SENTENCE.line_length(&control).unwrap_or_default(),
        }
    }

    /// The load of the message; `None` where the sensor does not have the rate.
    fn load(self, rate_hz: u32) -> Option<LinkLoad> {
        match self {
            Self::Packets(packets) => LinkLoad::of_packets(&packets.output(1, rate_hz)?),
            Self::Sentences => {
                Some(LinkLoad::of_lines(self.frame_bytes(), AsyncRate::new(rate_hz).filter(|rate| rate.hz() > 0)?))
            }
        }
    }

    /// The output rates of the message in hertz, the highest first.
    fn rates_hz(self) -> Vec<u32> {
        match self {
            Self::Packets(_) => {
                (1..=MEASUREMENTS_PER_S).rev().filter(|hz| MEASUREMENTS_PER_S.is_multiple_of(*hz)).collect()
            }
            Self::Sentences => OUTPUT_RATES_HZ.into_iter().rev().collect(),
        }
    }
}

/// What the user has fixed of the measurement; `None` is left to the plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Given {
    /// The message.
    pub message: Option<PlannedMessage>,
    /// Output rate in hertz.
    pub rate_hz: Option<u32>,
    /// Baud rate.
    pub baud: Option<BaudRate>,
    /// Two-sided level of the intervals, 0 < p < 1.
    pub confidence: f64,
}

/// A measurement as planned.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// The length for each want, in the order asked.
    pub wants: Vec<PlannedWant>,
    /// The message; its packets have the magnetic field if the magnetometer is wanted.
    pub message: PlannedMessage,
    /// Bytes of a packet, or of a sentence with its counter.
    pub frame_bytes: u32,
    /// Output rate in hertz.
    pub rate_hz: u32,
    /// The averaging window in refreshes: all between two outputs, so that no noise is aliased.
    pub window: u32,
    /// Baud rate.
    pub baud: BaudRate,
    /// The warm-up to exclude at the beginning, in seconds.
    pub warm_up_s: f64,
    /// Length after the warm-up in seconds, rounded up; `None` where a want is out of reach.
    pub record_s: Option<f64>,
}

/// How long a record must be for one want.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedWant {
    /// What is wanted.
    pub want: Want,
    /// Seconds after the warm-up; `None` where 100 days are too short.
    pub record_s: Option<f64>,
    /// For a random walk: the length in seconds if the sensor had no bias instability, which hides
    /// the random walk; else `None`.
    pub without_bias_instability_s: Option<f64>,
    /// For a limit: the value that the sensor is assumed to have; else `None`.
    pub taken_at: Option<TakenAt>,
}

/// The value that a sensor to be judged by a limit is assumed to have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TakenAt {
    /// The value in SI units.
    pub value: f64,
    /// Where the value is from.
    pub from: TakenFrom,
    /// Whether the value and the limit are those of the minimum of the deviation, which a verdict
    /// compares with a figure for B; else they are those of the parameter.
    pub is_minimum: bool,
}

/// Where an assumed value is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TakenFrom {
    /// It is the figure of the data sheet.
    Datasheet,
    /// [`TakenAt::BESIDE`] times the limit, because the figure of the data sheet is too near to it.
    Limit,
    /// [`TakenAt::BESIDE`] times the limit, because the data sheet has no figure.
    LimitAlone,
}

/// Why no measurement can be planned, in a sentence that says what can be changed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct PlanningError(String);

impl Plan {
    /// The fraction of records of the planned length that meet a want on all of its axes together; a
    /// rate random walk on each of them.
    pub const MET_IN: f64 = 0.8;

    /// The part of the baud rate up to which a rate is recommended: the rest is room for replies
    /// and for a clock that is too fast.
    pub const MOST_LOAD: f64 = 0.9;

    /// Plans a record that shows all of `wants`, for a sensor with the figures of `datasheet`.
    ///
    /// # Errors
    /// If the given settings contradict each other or the wants, and when the
    /// data sheet does not give the size of a wanted parameter, or the white noise that hides it.
    pub fn new(wants: &[Want], given: Given, datasheet: &Datasheet) -> Result<Self, PlanningError> {
        let has_field = wants.iter().any(|want| want.figure.sensor == Sensor::Magnetometer);
        let [without_field, with_field] = PACKET_MESSAGES;
        let packets = PlannedMessage::Packets(if has_field { with_field } else { without_field });
        let message = given.message.unwrap_or(packets);
        let (rate_hz, baud) = rate_and_baud(message, given)?;
        if let Some(want) = wants.iter().find(|want| !message.holds(want.figure.sensor)) {
            let sensor = want.figure.sensor;
            let all = PACKET_MESSAGES.map(PlannedMessage::Packets).into_iter().chain([PlannedMessage::Sentences]);
            let others: Vec<_> = all.filter(|message| message.holds(sensor)).map(PlannedMessage::name).collect();
            return Err(PlanningError(format!(
                "{:?} cannot be planned with {}, which has no {}: use {}",
                want.to_string(),
                message.name(),
                sensor_name(sensor),
                others.join(" or ")
            )));
        }
        let interval_s = |want: &Want| message.interval_s(want.figure.sensor, rate_hz);
        let wants = wants.iter().map(|want| PlannedWant::new(want, interval_s(want), given.confidence, datasheet));
        let wants = wants.collect::<Result<Vec<_>, _>>()?;
        let longest = wants.iter().try_fold(0.0_f64, |longest, want| Some(longest.max(want.record_s?)));
        let white_alone = wants.iter().all(|want| want.want.figure.term == Term::White);
        Ok(Self {
            wants,
            message,
            frame_bytes: message.frame_bytes(),
            rate_hz,
            window: MEASUREMENTS_PER_S / rate_hz,
            baud,
            warm_up_s: WARM_UP_S[usize::from(!white_alone)],
            record_s: longest.map(rounded_up),
        })
    }
}

impl PlannedWant {
    fn new(want: &Want, interval_s: f64, confidence: f64, datasheet: &Datasheet) -> Result<Self, PlanningError> {
        let term = want.figure.term;
        let typical = datasheet.typical_noise(want.figure.sensor);
        let quoted = typical.iter().find(|(quoted, _)| *quoted == term).map(|(_, value)| *value);
        let is_minimum = datasheet.is_of_minimum(want.figure.sensor, term);
        let (aim, assumed, from) = match want.known {
            Known::Seen => (Aim::Found, None, None),
            Known::Within(half_width) => (Aim::HalfWidth(half_width), None, None),
            Known::AtLeast(value) => (Aim::Found, Some((term, value)), None),
            Known::AtMost(limit) => {
                let limit = if is_minimum { limit / floor_of_flicker() } else { limit };
                let (value, from) = TakenAt::beside(limit, quoted);
                let aim = if value > limit { Aim::Above(limit) } else { Aim::Below(limit) };
                (aim, Some((term, value)), Some(from))
            }
        };
        let taken_at = assumed.zip(from).map(|((_, value), from)| TakenAt {
            value: if is_minimum { value * floor_of_flicker() } else { value },
            from,
            is_minimum,
        });
        if let Some(missing) = want.missing_in(datasheet) {
            return Err(PlanningError(format!(
                "the length for {:?} depends on {missing}, which the data sheet {:?} does not give for that sensor: \
                 add it, or give a value, as in \"gyro K >= 0.5 deg/h^1.5\"",
                want.to_string(),
                datasheet.name
            )));
        }
        let truth: Vec<_> =
            typical.iter().copied().filter(|(named, _)| assumed.is_none() || *named != term).chain(assumed).collect();
        let missed = missed_on_an_axis(&want.figure);
        let length = |truth: &[(Term, f64)]| {
            Wanted { term, aim, truth, missed, tests: SLOW_TERMS }.record_s(interval_s, confidence)
        };
        let is_walk = term == Term::RateRandomWalk;
        let without: Vec<_> = truth.iter().copied().filter(|(term, _)| *term != Term::BiasInstability).collect();
        Ok(Self {
            want: want.clone(),
            record_s: length(&truth),
            without_bias_instability_s: if is_walk { length(&without) } else { None },
            taken_at,
        })
    }
}

impl TakenAt {
    /// The assumed value divided by the limit, where it is not that of the data sheet.
    pub const BESIDE: f64 = 0.8;

    fn beside(limit: f64, typical: Option<f64>) -> (f64, TakenFrom) {
        match typical {
            Some(typical) if (typical / limit - 1.0).abs() > 1.0 - Self::BESIDE => (typical, TakenFrom::Datasheet),
            Some(_) => (Self::BESIDE * limit, TakenFrom::Limit),
            None => (Self::BESIDE * limit, TakenFrom::LimitAlone),
        }
    }
}

/// The share of records in which one axis may miss the figure. A random walk is planned for each axis
/// alone: a process explains the record about as well on one of six axes.
fn missed_on_an_axis(figure: &NoiseFigure) -> f64 {
    let together = if figure.term == Term::RateRandomWalk { 1 } else { figure.axes() };
    1.0 - Plan::MET_IN.powf(1.0 / f64::from(together))
}

/// The factory default of the baud rate where the message fits it, and the highest rate that it has
/// room for, up to the one that is useful: long averaging times do not need more.
fn rate_and_baud(message: PlannedMessage, given: Given) -> Result<(u32, BaudRate), PlanningError> {
    let usual_hz = if message == PlannedMessage::Sentences { SENTENCES_HZ } else { PACKETS_HZ };
    let (rates_hz, frame_bytes) = (message.rates_hz(), message.frame_bytes());
    if let Some(rate_hz) = given.rate_hz.filter(|hz| !rates_hz.contains(hz)) {
        let all = rates_hz.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
        return Err(PlanningError(format!("{} has no rate of {rate_hz} Hz: use one of {all}", message.name())));
    }
    let fits = |rate_hz: u32, baud: BaudRate| message.load(rate_hz).is_some_and(|load| load.fits(baud));
    let has_room = |rate_hz: u32, baud: BaudRate| {
        let share = |load: LinkLoad| 10.0 * load.bytes_per_s / f64::from(baud.bits_per_s());
        message.load(rate_hz).is_some_and(|load| share(load) <= Plan::MOST_LOAD)
    };
    let highest_hz = |baud: BaudRate| rates_hz.iter().copied().find(|hz| has_room(*hz, baud));
    let fitting = match (given.rate_hz, given.baud) {
        (Some(hz), Some(baud)) => fits(hz, baud).then_some((hz, baud)),
        (Some(hz), None) => {
            let mut bauds = [BaudRate::DEFAULT].into_iter().chain(BaudRate::ALL);
            bauds.find(|baud| has_room(hz, *baud)).map(|baud| (hz, baud))
        }
        (None, given) => {
            let baud = given.unwrap_or(BaudRate::DEFAULT);
            highest_hz(baud).map(|hz| (hz.min(usual_hz), baud))
        }
    };
    let baud = given.baud.unwrap_or(FASTEST);
    fitting.ok_or_else(|| {
        let (rate_hz, bits_per_s) = (given.rate_hz.unwrap_or(usual_hz), baud.bits_per_s());
        let cure = highest_hz(baud).map_or_else(String::new, |hz| format!("reduce the rate to {hz} Hz, or "));
        PlanningError(format!(
            "{frame_bytes} bytes {rate_hz} times a second do not fit {bits_per_s} baud; {cure}use a higher baud rate"
        ))
    })
}

/// Rounded up to minutes, from an hour on to ten minutes, from ten hours on to hours.
fn rounded_up(seconds: f64) -> f64 {
    let step = match seconds {
        ..3600.0 => 60.0,
        ..36_000.0 => 600.0,
        _ => 3600.0,
    };
    (seconds / step).ceil() * step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_rounded_up_to_minutes_ten_minutes_and_hours() {
        for (seconds, rounded) in [
            (1.0, 60.0),
            (60.0, 60.0),
            (61.0, 120.0),
            (3599.0, 3600.0),
            (3601.0, 4200.0),
            (35_500.0, 36_000.0),
            (36_001.0, 39_600.0),
        ] {
            assert_eq!(rounded_up(seconds), rounded, "{seconds} s");
        }
    }

    #[test]
    fn what_shall_be_judged_lies_a_fifth_below_the_limit_unless_it_is_known_and_not_near() {
        for (typical, taken, from) in [
            (None, 8.0, TakenFrom::LimitAlone),
            (Some(8.1), 8.0, TakenFrom::Limit),
            (Some(11.9), 8.0, TakenFrom::Limit),
            (Some(7.9), 7.9, TakenFrom::Datasheet),
            (Some(12.1), 12.1, TakenFrom::Datasheet),
            (Some(1.0), 1.0, TakenFrom::Datasheet),
        ] {
            assert_eq!(TakenAt::beside(10.0, typical), (taken, from), "{typical:?}");
        }
    }
}
