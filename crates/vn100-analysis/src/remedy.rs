//! What the user can do, as data that the faces put into words.

/// An action of the user against a limit of the result.
#[derive(Debug, Clone, PartialEq)]
pub enum Remedy {
    /// Give the nominal sample rate: this one in hertz, if it was measured.
    GiveRate(Option<f64>),
    /// Exclude the beginning of the record: this many minutes, if the length is known.
    Skip(Option<f64>),
    /// End the measurement before the end of the record.
    EndEarlier,
    /// Accept sentences that carry no checksum.
    AcceptUnchecked,
    /// Name the columns of a CSV file, or the fields of messages: by this map, if one is known.
    MapColumns(Option<String>),
    /// Name one topic of a bag.
    GiveTopic,
    /// State whether a filter has removed the bias from the rates.
    SayCompensated,
    /// Give the data sheet of the sensor.
    GiveDatasheet,
    /// Take from the data sheet what a record does not show.
    FillFromDatasheet,
    /// Give the error of the scale factor.
    GiveScaleFactor,
    /// State the setting of register 85.
    GiveWindow,
    /// Measure the packets of a stream that carries sentences as well.
    MeasurePackets,
    /// Judge by typical figures as by limits.
    TypicalIsLimit,
    /// Set the sensor permanently.
    Configure(Setting),
    /// Set a sensor that has lost its settings as it was.
    Restore {
        /// Its port.
        port: String,
        /// Header of its message, if that has changed.
        message: Option<String>,
        /// Its output rate in Hz, if that is known.
        rate_hz: Option<f64>,
    },
    /// Set the sensor for one measurement.
    MeasureWith(Setting),
    /// Measure the live sensor, whose port then has a short latency.
    MeasureLive,
    /// Poll the temperature of a live sensor between its sentences.
    ReadTemperature,
    /// Record the live sensor, with its temperature and the conditions.
    Record,
    /// Plan how long a record must be.
    Plan,
}

/// A setting of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Setting {
    /// The message, by its header.
    Message(&'static str),
    /// The averaging window of register 85, in refreshes.
    Window(u32),
}

/// The words of a face for a remedy: what to do, as an imperative without a full stop.
pub type RemedyWords = fn(&Remedy) -> String;
