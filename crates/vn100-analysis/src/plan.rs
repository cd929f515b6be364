//! From what a record shall show to how the sensor is set, and how long it must rest.

use std::sync::Arc;

use imu_noise::{Aim, Sensor, Term, Wanted, visible_random_walk};
use thiserror::Error;
use vn100_protocol::{
    AsyncRate, AsyncType, BaudRate, Channel, Layout, LineForm, LinkLoad, MEASUREMENTS_PER_S, OUTPUT_RATES_HZ,
    PACKET_MESSAGES, PacketMessage, VNIMU,
};

use crate::{
    datasheet::Datasheet,
    sensor::{sensor_name, sensor_of},
    want::{Known, Want},
};

/// Of sentences: the factory default.
const SENTENCES_HZ: u32 = 40;

/// Of packets: the rate at which the factory default of the averaging window aliases no noise.
const PACKETS_HZ: u32 = 200;

/// The fastest line of the sensor.
const FASTEST: BaudRate = BaudRate::ALL[BaudRate::ALL.len() - 1];

/// B, K and R of six axes are tested in one record.
const SLOW_TERMS: usize = 18;

/// Published practice leaves out between so much, in seconds; the maker states no figure.
const WARM_UP_S: [f64; 2] = [600.0, 1800.0];

/// What the sensor is to send. Its angular rates still hold the sensor's own bias.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlannedMessage {
    /// Packets with the device time.
    Packets(PacketMessage),
    /// Sentences with a counter.
    Sentences,
}

/// Behind the sensor's low pass, N is read as well as from independent samples so far apart, in
/// seconds and in intervals, with windows that leave nothing aliased. Measured of emulated records
/// were 64 to 91 ms at 200 and 800 Hz, six intervals at 40 Hz; planned with 80 ms, 18 of 24 records
/// met ±2 %.
const BEHIND_LOW_PASS_S: f64 = 0.1;
const BEHIND_LOW_PASS_INTERVALS: f64 = 6.0;

impl PlannedMessage {
    /// The sentence of [`Sentences`](Self::Sentences).
    const SENTENCE: AsyncType = AsyncType::IMU;

    /// The one with this name, in upper or lower case: that of packets, or `VNIMU`.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let is_sentence = Self::Sentences.name().eq_ignore_ascii_case(name);
        PacketMessage::named(name).map(Self::Packets).or(is_sentence.then_some(Self::Sentences))
    }

    /// As the sensor is asked for it.
    #[must_use]
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

    /// Whether it carries axes of this sensor.
    #[must_use]
    pub fn holds(self, sensor: Sensor) -> bool {
        let is_of = |channel: &Channel| sensor_of(channel.quantity) == Some(sensor);
        self.layout().is_some_and(|layout| layout.channels.iter().any(is_of))
    }

    /// Seconds between two samples of the sensor's axes; more where its low pass makes neighbours
    /// alike, so that N is read at longer averaging times.
    fn interval_s(self, sensor: Sensor, rate_hz: u32) -> f64 {
        let is_of = |channel: &&Channel| sensor_of(channel.quantity) == Some(sensor);
        let layout = self.layout();
        let channel = layout.as_ref().and_then(|layout| layout.channels.iter().find(is_of));
        let stride = channel.map_or(1, |channel| channel.stride(rate_hz.into()));
        let interval_s = stride as f64 / f64::from(rate_hz);
        match sensor {
            Sensor::Magnetometer => interval_s,
            Sensor::Gyroscope | Sensor::Accelerometer => {
                (BEHIND_LOW_PASS_INTERVALS * interval_s).max(BEHIND_LOW_PASS_S)
            }
        }
    }

    /// Bytes of a packet, or of a sentence with its counter.
    fn frame_bytes(self) -> u32 {
        let form = LineForm { count: true, ..LineForm::default() };
        match self {
            Self::Packets(packets) => packets.packet_length() as u32,
            Self::Sentences => Self::SENTENCE.line_length(form).unwrap_or_default(),
        }
    }

    /// `None` where the sensor has no such rate.
    fn load(self, rate_hz: u32) -> Option<LinkLoad> {
        match self {
            Self::Packets(packets) => LinkLoad::of_packets(&packets.output(1, rate_hz)?),
            Self::Sentences => {
                Some(LinkLoad::of_lines(self.frame_bytes(), AsyncRate::new(rate_hz).filter(|rate| rate.hz() > 0)?))
            }
        }
    }

    /// The rates of the sensor in hertz, the highest first.
    fn rates_hz(self) -> Vec<u32> {
        match self {
            Self::Packets(_) => {
                (1..=MEASUREMENTS_PER_S).rev().filter(|hz| MEASUREMENTS_PER_S.is_multiple_of(*hz)).collect()
            }
            Self::Sentences => OUTPUT_RATES_HZ.into_iter().rev().collect(),
        }
    }
}

/// What is fixed before anything is planned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Given {
    /// What is sent.
    pub message: Option<PlannedMessage>,
    /// Output rate in hertz.
    pub rate_hz: Option<u32>,
    /// Baud rate.
    pub baud: Option<BaudRate>,
    /// Two-sided level of the intervals, 0 < p < 1.
    pub confidence: f64,
}

/// A measurement as it should be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// How long for what, in the order asked.
    pub wants: Vec<PlannedWant>,
    /// What is sent: packets, with the magnetic field where something of it is wanted.
    pub message: PlannedMessage,
    /// Bytes of a packet, or of a sentence with its counter.
    pub frame_bytes: u32,
    /// Output rate in hertz.
    pub rate_hz: u32,
    /// Values averaged for one that is sent, all that are taken: white noise keeps its density.
    pub window: u32,
    /// Baud rate.
    pub baud: BaudRate,
    /// To be excluded at the beginning, in seconds.
    pub warm_up_s: f64,
    /// Length after the warm-up in seconds, rounded up; `None` where something is out of reach.
    pub record_s: Option<f64>,
}

/// How long a record must be for one want.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedWant {
    /// What is wanted.
    pub want: Want,
    /// Seconds after the warm-up; `None` where 100 days are too short.
    pub record_s: Option<f64>,
    /// For a random walk: seconds if the sensor had no bias instability that hides it.
    pub without_bias_instability_s: Option<f64>,
    /// For a random walk: 20 √3 N/K, the rule of thumb, in seconds.
    pub by_rule_s: Option<f64>,
    /// For a limit: the value that the sensor is taken to have, in SI units. Nearer to the limit it
    /// takes longer.
    pub taken_at: Option<f64>,
}

/// A measurement cannot be made so.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PlanningError {
    /// The data sheet does not say what the length depends on.
    #[error(
        "the length for {want:?} depends on {missing}, which the data sheet {datasheet:?} does not give for that sensor: add it, or give a \
         value, as in \"gyro K >= 2e-7\""
    )]
    NotQuoted {
        /// What is wanted.
        want: String,
        /// The parameters without a figure.
        missing: &'static str,
        /// Name of the data sheet.
        datasheet: String,
    },
    /// The line is too slow.
    #[error("{frame_bytes} bytes {rate_hz} times a second do not fit {baud} baud; {}", match highest_hz {
        Some(hz) => format!("reduce the rate to {hz} Hz, or use a higher baud rate"),
        None => "use a higher baud rate".into(),
    })]
    DoesNotFit {
        /// Bytes of a packet or a sentence.
        frame_bytes: u32,
        /// The rate asked for.
        rate_hz: u32,
        /// The baud rate.
        baud: u32,
        /// The highest rate that fits.
        highest_hz: Option<u32>,
    },
    /// The message lacks the sensor of a figure.
    #[error("{want:?} cannot be planned with {message}, which has no {sensor}: use {}", messages.join(" or "))]
    NotInMessage {
        /// What is wanted.
        want: String,
        /// What is sent.
        message: &'static str,
        /// What the figure is of.
        sensor: &'static str,
        /// Messages that have it.
        messages: Vec<&'static str>,
    },
    /// The sensor has no such rate.
    #[error("{message} has no rate of {rate_hz} Hz: use one of {}", list(rates_hz))]
    NoSuchRate {
        /// What is sent.
        message: &'static str,
        /// The rate asked for.
        rate_hz: u32,
        /// The rates in hertz.
        rates_hz: Vec<u32>,
    },
}

impl Plan {
    /// The share of records of the planned length that meet a want, all its axes together.
    pub const MET_IN: f64 = 0.8;

    /// The share of the line up to which a rate or a baud rate is recommended: the rest is room for
    /// replies and for a clock that is too fast.
    pub const MOST_LOAD: f64 = 0.9;

    /// Plans a record that shows all of `wants`, of a sensor as `datasheet` has it.
    ///
    /// # Errors
    /// Where what is given does not go together, and where the data sheet does not say how large a
    /// thing wanted is, or the white noise that hides it.
    pub fn new(wants: &[Want], given: Given, datasheet: &Datasheet) -> Result<Self, PlanningError> {
        let has_field = wants.iter().any(|want| want.figure.sensor == Sensor::Magnetometer);
        let [without_field, with_field] = PACKET_MESSAGES;
        let packets = PlannedMessage::Packets(if has_field { with_field } else { without_field });
        let message = given.message.unwrap_or(packets);
        let (rate_hz, baud) = rate_and_baud(message, given)?;
        if let Some(want) = wants.iter().find(|want| !message.holds(want.figure.sensor)) {
            let sensor = want.figure.sensor;
            let all = PACKET_MESSAGES.map(PlannedMessage::Packets).into_iter().chain([PlannedMessage::Sentences]);
            return Err(PlanningError::NotInMessage {
                want: want.to_string(),
                message: message.name(),
                sensor: sensor_name(sensor),
                messages: all.filter(|message| message.holds(sensor)).map(PlannedMessage::name).collect(),
            });
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
        let (aim, assumed) = match want.known {
            Known::Seen => (Aim::Found, None),
            Known::Within(half_width) => (Aim::HalfWidth(half_width), None),
            Known::AtLeast(value) => (Aim::Found, Some((term, value))),
            Known::AtMost(limit) => {
                let value = beside(limit, quoted);
                (if value > limit { Aim::Above(limit) } else { Aim::Below(limit) }, Some((term, value)))
            }
        };
        let is_quoted = |term| typical.iter().any(|(quoted, _)| *quoted == term);
        let missing = match (is_quoted(Term::White), assumed.is_some() || is_quoted(term)) {
            (true, true) => None,
            (true, false) => Some("its own size"),
            (false, _) => Some("the white noise"),
        };
        if let Some(missing) = missing {
            return Err(PlanningError::NotQuoted {
                want: want.to_string(),
                missing,
                datasheet: datasheet.name.clone(),
            });
        }
        let truth: Vec<_> =
            typical.iter().copied().filter(|(named, _)| assumed.is_none() || *named != term).chain(assumed).collect();
        let missed = 1.0 - Plan::MET_IN.powf(1.0 / f64::from(want.figure.axes()));
        let length = |truth: &[(Term, f64)]| {
            Wanted { term, aim, truth, missed, tests: SLOW_TERMS }.record_s(interval_s, confidence)
        };
        let is_walk = term == Term::RateRandomWalk;
        let without: Vec<_> = truth.iter().copied().filter(|(term, _)| *term != Term::BiasInstability).collect();
        let white = typical.iter().find(|(term, _)| *term == Term::White).map(|(_, white)| *white);
        Ok(Self {
            want: want.clone(),
            record_s: length(&truth),
            without_bias_instability_s: if is_walk { length(&without) } else { None },
            // what is visible falls as the record grows
            by_rule_s: white
                .zip(assumed)
                .filter(|_| is_walk)
                .map(|(white, (_, walk))| visible_random_walk(white, 1.0) / walk),
            taken_at: assumed.map(|(_, value)| value).filter(|_| matches!(want.known, Known::AtMost(_))),
        })
    }
}

/// What a sensor is taken to have that shall be judged by a `limit`: what is typical, but where
/// that is not known, or so near that a verdict would take for ever, a fifth below the limit.
fn beside(limit: f64, typical: Option<f64>) -> f64 {
    const NEAREST: f64 = 0.2;
    typical.filter(|typical| (typical / limit - 1.0).abs() > NEAREST).unwrap_or((1.0 - NEAREST) * limit)
}

/// The sensor's own baud rate where what is sent fits it, and as many rows as that carries, but no
/// more than are useful: long averaging times do not need more.
fn rate_and_baud(message: PlannedMessage, given: Given) -> Result<(u32, BaudRate), PlanningError> {
    let usual_hz = if message == PlannedMessage::Sentences { SENTENCES_HZ } else { PACKETS_HZ };
    let (rates_hz, frame_bytes) = (message.rates_hz(), message.frame_bytes());
    if let Some(rate_hz) = given.rate_hz.filter(|hz| !rates_hz.contains(hz)) {
        return Err(PlanningError::NoSuchRate { message: message.name(), rate_hz, rates_hz });
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
    fitting.ok_or_else(|| PlanningError::DoesNotFit {
        frame_bytes,
        rate_hz: given.rate_hz.unwrap_or(usual_hz),
        baud: baud.bits_per_s(),
        highest_hz: highest_hz(baud),
    })
}

fn list(rates_hz: &[u32]) -> String {
    rates_hz.iter().map(u32::to_string).collect::<Vec<_>>().join(", ")
}

/// To minutes, from an hour on to ten, from ten hours on to hours.
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
        for (typical, taken) in
            [(None, 8.0), (Some(8.1), 8.0), (Some(11.9), 8.0), (Some(7.9), 7.9), (Some(12.1), 12.1), (Some(1.0), 1.0)]
        {
            assert_eq!(beside(10.0, typical), taken, "{typical:?}");
        }
    }
}
