//! Names of what is measured, in words.

use imu_noise::Status;
use vn100_protocol::{Quantity, Tally};

/// What measures this.
#[must_use]
pub fn sensor(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Angle | Quantity::Quaternion => "orientation",
        Quantity::MagneticField => "magnetic field",
        Quantity::Acceleration => "acceleration",
        Quantity::AngularRate => "angular rate",
        Quantity::Temperature => "temperature",
        Quantity::Pressure => "pressure",
    }
}

/// A status of a parameter, in words.
#[must_use]
pub fn in_words(status: Status) -> &'static str {
    match status {
        Status::Estimated => "estimated",
        Status::Bounded => "at most",
        Status::NotObservable => "not observable",
        Status::NotMeasurable => "not measurable",
        Status::ModelRejected => "no model fits",
    }
}

/// How many, and of which kinds.
#[must_use]
pub fn rejected_lines(tally: &Tally) -> String {
    let bad = &tally.rejected;
    let kinds = [
        ("checksum", bad.checksum),
        ("unchecked", bad.unchecked),
        ("grammar", bad.grammar),
        ("range", bad.range),
        ("truncated", bad.truncated),
        ("too long", bad.too_long),
    ];
    let present: Vec<_> =
        kinds.iter().filter(|(_, count)| *count > 0).map(|(kind, count)| format!("{count} {kind}")).collect();
    if present.is_empty() { "0".into() } else { format!("{} ({})", bad.total(), present.join(", ")) }
}

/// How many questions the line brought back; nothing on a line that does not echo.
#[must_use]
pub fn echoes(count: u64) -> String {
    if count == 0 { String::new() } else { format!("{count} echoed questions, ") }
}
