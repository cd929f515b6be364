//! The kinds of warnings.

use vn100_analysis::{Remedy, Setting, WarningKind};

use super::{Explanation, advice};

pub(super) fn explanations() -> Vec<Explanation> {
    WarningKind::ALL.map(entry).into()
}

fn entry(kind: WarningKind) -> Explanation {
    let (meaning, why, template, remedies) = words(kind);
    Explanation {
        group: "Warnings",
        code: kind.name(),
        aliases: Vec::new(),
        title: kind.severity().name().into(),
        meaning: meaning.into(),
        why,
        advice: advice(template, remedies),
        source: source(kind),
    }
}

/// The standard or manual on the matter.
const fn source(kind: WarningKind) -> &'static str {
    use WarningKind as Kind;
    match kind {
        Kind::CompensatedStream | Kind::OtherMessages => "VectorNav VN-100 User Manual, register 6 and its messages",
        Kind::DecimatedStream => "VectorNav VN-100 User Manual, register 85",
        Kind::RotatedAxes => "VectorNav VN-100 User Manual, register 26",
        Kind::RateAssumed | Kind::RateOffNominal => "VectorNav VN-100 User Manual, register 7",
        Kind::DeviceErrors => "VectorNav VN-100 User Manual, system error codes",
        Kind::LinkBudget => "VectorNav VN-100 User Manual, registers 5 and 7",
        Kind::TooShort | Kind::CorrelatedNoise => "IEEE Std 952-1997, annex C; NIST SP 1065",
        _ => "",
    }
}

type Words = (&'static str, &'static str, &'static str, &'static [Remedy]);

/// What it means, why it matters, and what to do, with places for the remedies.
const fn words(kind: WarningKind) -> Words {
    use WarningKind as Kind;
    match kind {
        Kind::RecordingFailed => (
            "The recording made during the measurement is not complete: the disk was full, too slow, or the file was removed.",
            "The result is complete, but cannot be reproduced from the recording.",
            "Free the disk or record elsewhere, and leave the file in its place.",
            &[],
        ),
        Kind::RecordingCut => (
            "The file of the recording has no end: it was cut, as by a loss of power, or its copy is not whole.",
            "What was recorded before the cut is measured in full; the rest is missing, and long averaging times with it.",
            "Copy the file again if the original is whole. Measure again if the record is too short.",
            &[],
        ),
        Kind::EndedEarly => (
            "The measurement ended before the data time asked for had passed, or because the sensor was lost for good.",
            "The record is shorter than planned: long averaging times are missing, and the intervals are wider.",
            "The end reason says why. Check cable, adapter and supply of the sensor, and measure again or resume the recording.",
            &[],
        ),
        Kind::NoValidLines => (
            "Bytes arrived, but no sample of a message that is measured.",
            "There is no result.",
            "Check baud rate, output message and format. For a table name the columns with {}.",
            &[Remedy::MapColumns(None)],
        ),
        Kind::OtherMessages => (
            "Valid sentences or packets of a message other than the measured one were excluded.",
            "Messages that share a port are sent at different times; only one of them is measured.",
            "Set one output message ({}).",
            &[Remedy::Configure(Setting::Message("VNIMU"))],
        ),
        Kind::LinkBudget => (
            "The sensor has more to send than its baud rate carries.",
            "It drops whole sentences, and the record has gaps.",
            "Raise the baud rate, lower the output rate, or choose a shorter message. {} checks what fits.",
            &[Remedy::Plan],
        ),
        Kind::DeviceErrors => (
            "The sensor reported errors that answer no command.",
            "Something else sends to the sensor, or its output buffer overflowed: samples may be missing.",
            "Check for another program on the port and for interference on the line.",
            &[],
        ),
        Kind::PortShared => (
            "Another program has the port of the sensor open too.",
            "Each byte reaches only one of the two programs: samples are missing, and lines are cut.",
            "End the other program. To use the sensor in two programs, let one of them share its data over the network.",
            &[],
        ),
        Kind::AnotherSensor => (
            "Another sensor answered during the record.",
            "The noise of two sensors is not that of either.",
            "Measure each sensor by itself.",
            &[],
        ),
        Kind::Gaps => (
            "Samples were dropped; each gap keeps its place on the time axis.",
            "Clusters average the samples that are there; those that lack more than half are excluded. Short gaps cost little, many cost \
             degrees of freedom.",
            "Check cable, baud rate and USB hub; let the sensor append its counter for exact counts.",
            &[],
        ),
        Kind::RejectedLines => (
            "Sentences, packets or rows were rejected: checksum mismatch, malformed fields, impossible numbers, or truncated.",
            "Each one of the measured message is a dropped sample. Many show a bad cable or a wrong baud rate.",
            "Shorten or shield the cable, or lower the baud rate.",
            &[],
        ),
        Kind::AbsentValues => (
            "Rows lack the values of some channels.",
            "Those samples are missing in these channels.",
            "Check how the file was exported.",
            &[],
        ),
        Kind::UnreadValues => (
            "Numbers that were zero at the beginning of a bag were treated as absent, but are not zero later.",
            "These channels are missing from the result.",
            "Name them with {}.",
            &[Remedy::MapColumns(None)],
        ),
        Kind::UncheckedLines => (
            "Sentences carry no checksum.",
            "A damaged digit in them is not detected.",
            "Switch the checksum on in the sensor (register 30). Accept such sentences with {}.",
            &[Remedy::AcceptUnchecked],
        ),
        Kind::RepeatedLines => (
            "The capture repeats earlier samples exactly, which a live sensor does not do.",
            "The capture was looped or stored twice: intervals are too narrow and long averaging times are meaningless.",
            "Analyse one copy.",
            &[],
        ),
        Kind::TooShort => (
            "There are too few samples for a deviation, or for more than a rough one.",
            "Intervals are wide, and B and K are not observable.",
            "Record longer: N needs minutes, B ten minutes to hours, K hours to days. {} says how long.",
            &[Remedy::Plan],
        ),
        Kind::RateAssumed => (
            "The capture does not contain the sample rate; the factory default of 40 Hz is assumed.",
            "All averaging times scale with it: 1 % of the rate is 1 % of every tau and 0.5 % of N.",
            "Set {} if the sensor did not run at 40 Hz.",
            &[Remedy::GiveRate(None)],
        ),
        Kind::RateChanged => (
            "The output rate changed during the record.",
            "One record has one rate: the samples at another rate are excluded.",
            "Set the rate before the measurement, and keep other programs off the port.",
            &[],
        ),
        Kind::RateOffNominal => (
            "The measured rate is none of the sensor's, not the nominal one, or unsure because many samples are missing.",
            "Averaging times and densities are wrong by the difference, unless the computer's clock is wrong.",
            "Set {} to the true rate.",
            &[Remedy::GiveRate(None)],
        ),
        Kind::StampsBackwards => (
            "Some time stamps lie before earlier ones: the clock was set, rows are out of order, or the sensor restarted and its own time began anew.",
            "Dropped samples at these places are not detected.",
            "Record with a monotonic clock, as this program does. If the sensor restarted, check its power supply.",
            &[],
        ),
        Kind::StampsRefused => (
            "The time stamps cannot be those of a sensor: too few, too coarse, or in bursts.",
            "Neither rate nor dropped samples can be derived from them.",
            "Name another column for the times ({}), or set {}.",
            &[Remedy::MapColumns(None), Remedy::GiveRate(None)],
        ),
        Kind::BunchedArrival => (
            "Sentences arrive several at a time, as a USB adapter delivers them after its latency timer.",
            "Averaging times use the index of each sample, not its arrival: the noise is not affected. Short gaps are harder to detect.",
            "Shorten the latency timer of the adapter to 1 ms, as {} does where permitted.",
            &[Remedy::MeasureLive],
        ),
        Kind::CompensatedStream => (
            "The message carries values that the attitude filter of the sensor has corrected: the bias is removed.",
            "B, K and R of the gyroscope are not measurable in it, however long the record; N is.",
            "For B and K measure the uncompensated message: {}.",
            &[Remedy::MeasureWith(Setting::Message("VNIMU"))],
        ),
        Kind::CompensationUnknown => (
            "The capture does not contain whether a filter has removed the bias of the gyroscope.",
            "If one has, B and K are the filter's, not the sensor's.",
            "State it with {}.",
            &[Remedy::SayCompensated],
        ),
        Kind::DecimatedStream => (
            "The sensor samples faster than it sends. Noise above half the output rate aliases into the band; or averaging lowers the \
             deviation at short averaging times.",
            "Aliasing raises N above the data sheet by a known factor; it is then the right density for a filter at this rate. For averaging N is corrected.",
            "Set the averaging window to 800/rate (20 at 40 Hz: {}). State a window that the capture does not contain with {}.",
            &[Remedy::Configure(Setting::Window(20)), Remedy::GiveWindow],
        ),
        Kind::PrintFormat => (
            "The printed resolution changed during the record.",
            "Rounding differs between its parts, which matters where noise is near the last digit.",
            "Keep one output format for a record.",
            &[],
        ),
        Kind::StuckDigits => (
            "A channel takes no more than two values.",
            "Its noise lies below the last printed digit, or the channel is dead: the deviation is that of rounding.",
            "Check the channel by moving the sensor. A binary output or a higher resolution shows the noise.",
            &[],
        ),
        Kind::VibrationLine => (
            "The spectrum has significant peaks: vibration, or an alternating magnetic field. A peak may be an alias of a higher frequency.",
            "It raises the deviation at the averaging times around its period. N is taken from the spectrum or the averaging times without it.",
            "Remove the source, or isolate the sensor on a heavy base with soft feet; keep magnetometers away from mains and motors.",
            &[],
        ),
        Kind::CorrelatedNoise => (
            "Besides white noise there is noise correlated over seconds.",
            "It looks like B on a short stretch of the curve, and is not bias instability.",
            "Look for vibration, temperature control or air flow around the sensor. For a Kalman filter model it as a Gauss-Markov process.",
            &[],
        ),
        Kind::LowPass => (
            "A low-pass filter slower than the output removes the high frequencies.",
            "Short averaging times show the filter; N is the density at low frequencies, known less well.",
            "Nothing, if the filter is intended. Otherwise widen its bandwidth.",
            &[],
        ),
        Kind::PossibleFilter => (
            "The spectrum may be that of a filter slower than the output; the interval of N holds with and without one.",
            "By chance white noise can look filtered in some channels; a weak filter changes N by a few percent.",
            "Measure for longer, or give the averaging window of a VN-100.",
            &[],
        ),
        Kind::LineFreeBand => (
            "Spectral peaks cover more than half of the band.",
            "What looks like white noise between them may be theirs: only an upper bound for N is given.",
            "Measure on a heavy base, away from vibration.",
            &[],
        ),
        Kind::NotStationary => (
            "The sensor was moved, or mean or noise changed during the record: a step, a drift, a disturbance.",
            "Allan deviation and noise parameters assume a stationary record at rest. A moved record has no noise figures.",
            "Exclude the disturbed part ({}, {}), or record again at rest.",
            &[Remedy::Skip(None), Remedy::EndEarlier],
        ),
        Kind::WarmUp => (
            "The level settled at the beginning of the record, as when a sensor warms up.",
            "The transient looks like K or R at long averaging times.",
            "Exclude it ({}), or let the sensor warm up before the record.",
            &[Remedy::Skip(None)],
        ),
        Kind::FollowsTemperature => (
            "The bias follows the temperature of the sensor significantly.",
            "Part of the deviation at long averaging times is temperature, not noise.",
            "Record at a constant temperature.",
            &[],
        ),
        Kind::QuantisationFloor => (
            "From sample to sample the noise is less than half a step of the values.",
            "The curve is that of the rounding.",
            "Use an output with more digits, or subtract the constant part of values that are large.",
            &[],
        ),
        Kind::FullRange => (
            "A channel reaches the end of its sensor's range.",
            "Values beyond it are clipped, and statistics of clipped values are wrong.",
            "Keep the sensor at rest, away from magnets and strong shocks.",
            &[],
        ),
        Kind::AngleRestarted => (
            "An angle turned so far that its count of turns started anew.",
            "Its mean, minimum and maximum mix the branches.",
            "Nothing, for the noise of the other channels.",
            &[],
        ),
        Kind::UnitDoubtful => (
            "A column holds magnitudes that its unit makes impossible.",
            "A wrong unit scales every result of the channel.",
            "Check the unit, and give the right one with {}.",
            &[Remedy::MapColumns(None)],
        ),
        Kind::GravityMagnitude => (
            "The magnitude of the mean acceleration is not that of gravity.",
            "Bias or scale factor are off, or the sensor was not at rest. Noise is hardly affected.",
            "Check that the sensor is at rest; calibrate the accelerometer in six positions.",
            &[],
        ),
        Kind::FieldMagnitude => (
            "The magnitude of the mean magnetic field is not that of the Earth.",
            "Iron or a current is near, or the magnetometer is not calibrated for its mounting. The heading is wrong then.",
            "Move the sensor away from iron and currents, or calibrate for hard and soft iron.",
            &[],
        ),
        Kind::RotatedAxes => (
            "The sensor turns its measurements into the axes of a vehicle (register 26).",
            "x, y and z are not those of its sensors: a noisy or disturbed axis is spread over several.",
            "Nothing. For figures of each axis of the sensor reset register 26.",
            &[],
        ),
        Kind::YawFromMagnetometer => (
            "Yaw varies much more than pitch and roll.",
            "Gravity stabilises pitch and roll; heading rests on the magnetometer and shows its noise and the ambient field.",
            "Nothing, indoors. Keep iron and currents away for a better heading.",
            &[],
        ),
    }
}
