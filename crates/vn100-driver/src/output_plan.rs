//! From the present output of a sensor to the requested one: the registers to write, and their
//! order. Pure.

use std::fmt;

use thiserror::Error;
use vn100_protocol::{
    AsyncRate, AsyncType, BaudRate, BinaryOutput, ImuFilter, LinkLoad, MEASUREMENTS_PER_S, OUTPUT_RATES_HZ,
    PACKET_MESSAGES, PacketMessage, ProtocolControl, Register, RegisterContents, RegisterFields, RegisterValue,
    SyncControl, ValueError, WritableValue, stream::FrameKind,
};

/// The requested output of the sensor. `None` leaves a setting unchanged.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct OutputSettings {
    /// Baud rate, in bit/s.
    pub baud: Option<u32>,
    /// The message: of sentences, such as `VNYMR` or `VNIMU`, or of packets, such as `BINARY`. It
    /// replaces both the sentences and the packets of register 75 on the port of the link; packets
    /// to the other port alone stay. For packets the baud rate is raised if necessary.
    pub message: Option<String>,
    /// Rate of the message in hertz. With `None`, packets that are not sent yet get 200 Hz.
    pub rate_hz: Option<u32>,
    /// The averaging window: the number of its samples of acceleration and angular rate, at 800 per
    /// second, that the sensor averages for one measurement (register 85).
    pub window: Option<u32>,
    /// Whether each line carries the count of samples (registers 32 and 30), which shows dropped
    /// samples.
    pub count: Option<bool>,
    /// Whether the sensor saves these and all its other settings, so that they survive a loss of
    /// power.
    pub save: bool,
}

/// A register that is changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// The register.
    pub register: Register,
    /// Its fields before the change.
    pub before: RegisterFields,
    /// Its fields after the change.
    pub after: RegisterFields,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { register, before, after } = self;
        let name = match *register {
            Register::BAUD_RATE => "the baud rate",
            Register::ASYNC_TYPE => "the message",
            Register::ASYNC_RATE => "the rate",
            Register::PROTOCOL_CONTROL => "the format of the sentences",
            Register::SYNC_CONTROL => "the synchronisation",
            Register::IMU_FILTER => "the averaging windows",
            Register::BINARY_OUTPUT_1 => "the packets",
            _ => return write!(f, "register {register} from {before} to {after}"),
        };
        write!(f, "{name} (register {register}) from {before} to {after}")
    }
}

/// The reason why a sensor cannot be set as requested, with the settings that are possible.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{0}")]
pub struct PlanError(String);

impl From<ValueError> for PlanError {
    fn from(error: ValueError) -> Self {
        Self(format!("{error}; this sensor cannot be configured here"))
    }
}

fn beside(packets: LinkLoad) -> String {
    let bytes_per_s = packets.bytes_per_s;
    if bytes_per_s == 0.0 { String::new() } else { format!(", beside {bytes_per_s:.0} bytes a second of packets,") }
}

fn way_out(highest: Option<AsyncRate>, load: LinkLoad) -> String {
    let slower = highest.map(|rate| format!("at most {} Hz fit", rate.hz()));
    let faster = load.lowest_baud_rate().map(|baud| format!("take {} baud or more", baud.bits_per_s()));
    match (slower, faster) {
        (Some(slower), Some(faster)) => format!("{slower}, or {faster}"),
        (Some(way), None) | (None, Some(way)) => way,
        (None, None) => "no baud rate is high enough".into(),
    }
}

/// Measurements of the sensor per second; every `800 / rate`th one is sent.
const SAMPLES_PER_S: u16 = MEASUREMENTS_PER_S as u16;

/// The rate of packets if none is requested: the highest that fits the factory default of the baud
/// rate.
const PACKETS_HZ: u32 = 200;

/// The first port of the sensor, as a destination of packets (register 75).
const FIRST_PORT: u16 = 1;
const SECOND_PORT: u16 = 2;

/// The value of register 30 for which sentences carry the count of SyncOut pulses.
const COUNT_OF_SYNC_OUT: u8 = 3;

/// The mode of SyncOut with a pulse at the start of each measurement.
const AT_MEASUREMENT: u8 = 1;

impl OutputSettings {
    /// The registers that the plan depends on.
    pub(crate) fn registers(&self) -> impl Iterator<Item = Register> + use<> {
        let filter = self.window.map(|_| Register::IMU_FILTER);
        let line = [Register::BAUD_RATE, Register::ASYNC_TYPE, Register::ASYNC_RATE];
        let form = [Register::PROTOCOL_CONTROL, Register::SYNC_CONTROL];
        line.into_iter().chain(form).chain(BinaryOutput::REGISTERS.iter().copied()).chain(filter)
    }
}

/// The present or the requested output of the sensor.
#[derive(Debug, Clone, PartialEq)]
struct Output {
    baud: BaudRate,
    message: AsyncType,
    rate: AsyncRate,
    protocol: ProtocolControl,
    sync: Option<SyncControl>,
    filter: Option<ImuFilter>,
    /// The first binary output; `None` if its fields are not understood.
    binary: Option<BinaryOutput>,
    other_packets: LinkLoad,
}

/// The writes that set a sensor, and its output after them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OutputPlan {
    pub(crate) changes: Vec<Change>,
    pub(crate) frames: FrameKind,
    pub(crate) rate_hz: f64,
}

/// The change that sends packets to the second port in place of the first: the sensor does not
/// report on which of its ports it receives a command.
pub(crate) fn to_second_port(changes: &[Change]) -> Option<Change> {
    let change = changes.iter().find(|change| change.register == Register::BINARY_OUTPUT_1)?;
    let contents = RegisterContents { register: change.register, fields: change.after.clone() };
    let output: BinaryOutput = contents.value().ok()?;
    let moved = BinaryOutput { async_mode: SECOND_PORT, ..output.clone() };
    (output.async_mode == FIRST_PORT).then(|| Change { after: moved.fields(), ..change.clone() })
}

/// The writes that set the sensor to `settings`, from its present registers. A sentence replaces
/// packets that arrive here.
///
/// At each step the output fits the line: a higher baud rate is set before more output, less output
/// before a lower baud rate.
pub(crate) fn plan(
    current: &[RegisterContents],
    settings: &OutputSettings,
    packets_arrive: bool,
) -> Result<OutputPlan, PlanError> {
    let old = Output::from_registers(current, settings)?;
    let new = old.with(settings, packets_arrive)?;
    new.check_fit()?;
    let mut baud = change(Some(&old.baud), Some(&new.baud));
    let mut rate = change(Some(&old.rate), Some(&new.rate));
    let mut protocol = change(Some(&old.protocol), Some(&new.protocol));
    let mut packets = change(old.binary.as_ref(), new.binary.as_ref());
    let is_shorter = old.protocol.serial_count != 0 && new.protocol.serial_count == 0;
    let ordered = [
        baud.take_if(|_| new.baud > old.baud),
        rate.take_if(|_| new.rate < old.rate),
        protocol.take_if(|_| is_shorter),
        packets.take_if(|_| new.message != AsyncType::OFF),
        change(Some(&old.message), Some(&new.message)),
        rate,
        change(old.sync.as_ref(), new.sync.as_ref()),
        protocol,
        change(old.filter.as_ref(), new.filter.as_ref()),
        packets,
        baud,
    ];
    let (frames, rate_hz) = match &new.binary {
        Some(binary) if new.sends_packets_alone() => (FrameKind::Packet(binary.header()), binary.rate_hz()),
        _ => (FrameKind::Sentence(new.message), new.rate.hz().into()),
    };
    Ok(OutputPlan { changes: ordered.into_iter().flatten().collect(), frames, rate_hz })
}

/// The fields to write so that a register contains `fields` again. If packets are off, firmware 2
/// reports no group of fields, but refuses such a value in a write. For packets that are off, the
/// time on request is written instead, the factory default of firmware 3.
pub(crate) fn writable(register: Register, fields: &RegisterFields) -> RegisterFields {
    let output = RegisterContents { register, fields: fields.clone() }.value::<BinaryOutput>();
    match output {
        Ok(output) if output.groups == 0 => {
            BinaryOutput { async_mode: 0, rate_divisor: 0, groups: 1, field_words: vec![1] }.fields()
        }
        _ => fields.clone(),
    }
}

impl Output {
    /// The output that the registers set, as far as `settings` depend on it.
    fn from_registers(current: &[RegisterContents], settings: &OutputSettings) -> Result<Self, PlanError> {
        let protocol: ProtocolControl = required(current)?;
        let counts = settings.count.is_some() || protocol.serial_count == COUNT_OF_SYNC_OUT;
        // malformed packet settings have no known load: the sensor itself refuses an excess
        let output = |contents: &RegisterContents| contents.value::<BinaryOutput>().ok();
        let is_first = |contents: &&RegisterContents| contents.register == Register::BINARY_OUTPUT_1;
        let others = current.iter().filter(|contents| !is_first(contents)).filter_map(output);
        Ok(Self {
            baud: required(current)?,
            message: required(current)?,
            rate: required(current)?,
            protocol,
            sync: if counts { value(current)? } else { None },
            filter: value(current)?,
            binary: current.iter().find(is_first).and_then(output),
            other_packets: others.filter_map(|output| LinkLoad::of_packets(&output)).sum(),
        })
    }

    fn with(&self, settings: &OutputSettings, packets_arrive: bool) -> Result<Self, PlanError> {
        let mut new = self.clone();
        if let Some(bits_per_s) = settings.baud {
            let allowed = || list(BaudRate::ALL.map(BaudRate::bits_per_s));
            new.baud = BaudRate::new(bits_per_s).ok_or_else(|| not_allowed("the baud rate", bits_per_s, allowed()))?;
        }
        let packets = settings.message.as_deref().and_then(PacketMessage::named);
        match (&settings.message, packets) {
            (_, Some(packets)) => new.set_packets(packets, settings.rate_hz)?,
            (Some(name), None) => {
                let sentences = (0..=u8::MAX).map(AsyncType).filter_map(AsyncType::header);
                let allowed = || list(sentences.chain(PACKET_MESSAGES.map(|message| message.name)));
                let message = AsyncType::from_header(name.as_bytes());
                new.message = message.ok_or_else(|| not_allowed("the message", name, allowed()))?;
                if let Some(binary) = new.binary.as_mut().filter(|_| packets_arrive) {
                    binary.async_mode = 0;
                }
            }
            (None, None) => {}
        }
        match settings.rate_hz {
            None => {}
            Some(hz) if new.sends_packets_alone() => new.set_packet_rate(hz)?,
            Some(hz) => {
                let rate = AsyncRate::new(hz).filter(|rate| rate.hz() > 0);
                new.rate = rate.ok_or_else(|| not_allowed("the rate", hz, list(OUTPUT_RATES_HZ)))?;
            }
        }
        if new.sends_packets_alone() && settings.baud.is_none() && !new.packets().fits(new.baud) {
            new.baud = new.packets().lowest_baud_rate().unwrap_or(new.baud);
        }
        if let Some(window) = settings.window {
            let filter = new.filter.as_mut().ok_or_else(|| missing(Register::IMU_FILTER))?;
            let allowed = || format!("1 to {SAMPLES_PER_S} samples");
            let samples = u16::try_from(window).ok().filter(|samples| (1..=SAMPLES_PER_S).contains(samples));
            let samples = samples.ok_or_else(|| not_allowed("the window", window, allowed()))?;
            (filter.accel_window, filter.gyro_window) = (samples, samples);
        }
        new.set_count(settings.count, self.counts_lines())?;
        Ok(new)
    }

    /// Whether no sentence is sent between the packets of the first output.
    fn sends_packets_alone(&self) -> bool {
        self.message == AsyncType::OFF && self.binary.as_ref().is_some_and(|binary| binary.rate_hz() > 0.0)
    }

    fn packets(&self) -> LinkLoad {
        self.binary.as_ref().and_then(LinkLoad::of_packets).unwrap_or(LinkLoad::NONE) + self.other_packets
    }

    fn set_packets(&mut self, packets: PacketMessage, rate_hz: Option<u32>) -> Result<(), PlanError> {
        let binary = self.binary.as_ref().ok_or_else(|| missing(Register::BINARY_OUTPUT_1))?;
        self.message = AsyncType::OFF;
        // unchanged if it is sent already
        if binary.rate_hz() > 0.0 && packets.is_of(binary) {
            return Ok(());
        }
        let rate_hz = rate_hz.unwrap_or(PACKETS_HZ);
        let mode = if binary.async_mode == 0 { FIRST_PORT } else { binary.async_mode };
        self.binary = Some(packets.output(mode, rate_hz).ok_or_else(|| not_a_packet_rate(rate_hz))?);
        Ok(())
    }

    fn set_packet_rate(&mut self, hz: u32) -> Result<(), PlanError> {
        let divisor = MEASUREMENTS_PER_S.checked_div(hz).filter(|_| MEASUREMENTS_PER_S.is_multiple_of(hz));
        let divisor = divisor.and_then(|divisor| u16::try_from(divisor).ok()).ok_or_else(|| not_a_packet_rate(hz))?;
        if let Some(binary) = &mut self.binary {
            binary.rate_divisor = divisor;
        }
        Ok(())
    }

    /// Whether each sentence carries a count of sentences.
    fn counts_lines(&self) -> bool {
        let one_a_line =
            |sync: &SyncControl| sync.out_mode == AT_MEASUREMENT && sync.out_skip == self.measurements_skipped();
        self.protocol.serial_count == COUNT_OF_SYNC_OUT && self.sync.as_ref().is_some_and(one_a_line)
    }

    /// Switches the count in sentences on or off, or lets a count that is on follow the rate.
    fn set_count(&mut self, count: Option<bool>, counted_lines: bool) -> Result<(), PlanError> {
        let Some(count) = count.or(counted_lines.then_some(true)) else { return Ok(()) };
        if !count && !counted_lines {
            // an output pulse for another purpose, such as a camera, is left unchanged, but
            // sentences no longer carry its count
            if self.protocol.serial_count == COUNT_OF_SYNC_OUT {
                self.protocol.serial_count = 0;
            }
            return Ok(());
        }
        let skip = self.measurements_skipped();
        let sync = self.sync.as_mut().ok_or_else(|| missing(Register::SYNC_CONTROL))?;
        // the output pulse marks the start of every measurement that is sent, and its pulses are
        // counted
        (self.protocol.serial_count, sync.out_mode, sync.out_skip) =
            if count { (COUNT_OF_SYNC_OUT, AT_MEASUREMENT, skip) } else { (0, 0, 0) };
        Ok(())
    }

    /// Measurements between two that are sent; 0 if nothing is sent.
    fn measurements_skipped(&self) -> u16 {
        let rate_hz = u16::try_from(self.rate.hz()).unwrap_or(SAMPLES_PER_S);
        SAMPLES_PER_S.checked_div(rate_hz).map_or(0, |measurements| measurements.saturating_sub(1))
    }

    fn check_fit(&self) -> Result<(), PlanError> {
        let &Self { message, rate, baud, .. } = self;
        let packets = self.packets();
        let (has, carries) = (baud.bits_per_s(), baud.bytes_per_s());
        if let Some(binary) = self.binary.as_ref().filter(|_| self.sends_packets_alone() && !packets.fits(baud)) {
            return Err(PlanError(format!(
                "{} packets a second need {:.0} bytes a second, and {has} baud carry {carries}; {}",
                binary.rate_hz() as u32,
                packets.bytes_per_s,
                way_out(None, packets)
            )));
        }
        // a message of unknown length has no known load: the sensor itself refuses an excess
        let Some(length) = message.line_length(&self.protocol) else { return Ok(()) };
        let load = LinkLoad::of_lines(length, rate) + packets;
        if load.fits(baud) {
            return Ok(());
        }
        let uncounted = message.line_length(&ProtocolControl { serial_count: 0, ..self.protocol });
        let fits = uncounted.is_some_and(|length| (LinkLoad::of_lines(length, rate) + packets).fits(baud));
        Err(PlanError(format!(
            "{} at {rate} Hz{} needs {:.0} bytes a second and {has} baud carry {carries}; {}{}",
            message.header().unwrap_or("the message"),
            beside(packets),
            load.bytes_per_s,
            way_out(packets.highest_rate_beside(length, baud), load),
            if self.protocol.serial_count == COUNT_OF_SYNC_OUT && fits { ", or switch the count off" } else { "" }
        )))
    }
}

fn value<T: RegisterValue>(current: &[RegisterContents]) -> Result<Option<T>, ValueError> {
    let contents = current.iter().find(|contents| T::REGISTERS.contains(&contents.register));
    contents.map(RegisterContents::value).transpose()
}

fn required<T: RegisterValue>(current: &[RegisterContents]) -> Result<T, PlanError> {
    value(current)?.ok_or_else(|| missing(T::REGISTERS[0]))
}

/// The write that changes `before` to `after`, `None` if they are equal. Values are compared, not
/// their printed form.
fn change<T: WritableValue + PartialEq>(before: Option<&T>, after: Option<&T>) -> Option<Change> {
    let (before, after) = before.zip(after).filter(|(before, after)| before != after)?;
    Some(Change { register: after.register(), before: before.fields(), after: after.fields() })
}

/// The error for a rate that is not 800 Hz divided by an integer.
fn not_a_packet_rate(asked_hz: u32) -> PlanError {
    let rates = (1..=MEASUREMENTS_PER_S).filter(|hz| MEASUREMENTS_PER_S.is_multiple_of(*hz));
    not_allowed("the rate of packets", asked_hz, list(rates))
}

fn not_allowed(setting: &str, asked: impl fmt::Display, allowed: String) -> PlanError {
    PlanError(format!("{setting} can be {allowed}, not {asked}"))
}

fn missing(register: Register) -> PlanError {
    PlanError(format!("this sensor lacks register {register}, which the setting needs"))
}

fn list(values: impl IntoIterator<Item = impl ToString>) -> String {
    let texts: Vec<_> = values.into_iter().map(|value| value.to_string()).collect();
    texts.join(", ")
}

#[cfg(test)]
mod tests;
