//! The parameters of the noise, and the terms that their results are given in.

use vn100_analysis::noise::{Sensor, Term};
use vn100_analysis::{Remedy, letter};

use super::{Entry, Explanation, entry};
use crate::names::{ParameterNames, parameter_names};

const PARAMETERS: &str = "Parameters";
const IEEE: &str = "IEEE Std 952-1997, annex C; IEEE Std 1293 for accelerometers";
const SP_1065: &str = "NIST SP 1065";

pub(super) fn explanations() -> Vec<Explanation> {
    let sensors = [Sensor::Gyroscope, Sensor::Accelerometer, Sensor::Magnetometer];
    let parameters =
        Term::ALL.into_iter().map(|term| of_term(term, sensors.map(|sensor| parameter_names(sensor, term))));
    parameters.chain(TERMS.into_iter().map(|term| entry("Terms", term))).collect()
}

/// A parameter that has a name of its own for each sensor.
fn of_term(term: Term, names: [ParameterNames; 3]) -> Explanation {
    let (meaning, why, advice, remedies): (_, _, _, &'static [Remedy]) = match term {
        Term::White => (
            "The density of the white noise of rate, specific force or field. Integrated, it makes the angle (ARW) or the velocity (VRW) \
             wander by N times the square root of time. N is the Allan deviation at 1 s on the line of slope -1/2.",
            "The short-term noise of every reading, the largest part of most error budgets, and the noise density that Kalman filters and \
             Kalibr ask for.",
            "A record of a few minutes is enough. Keep the sensor still; set its averaging window to 800/rate so that nothing aliases.",
            &[Remedy::GiveWindow],
        ),
        Term::BiasInstability => (
            "The level of flicker noise (1/f) of the bias: the floor that averaging does not get below. The Allan deviation is 0.664 B there.",
            "How well a bias can be known at best. Data sheets often print the minimum of the curve instead, which is 0.664 B or more.",
            "It needs ten minutes to hours at a constant temperature, the longer the lower it is, and a message that is not compensated.",
            &[Remedy::Plan],
        ),
        Term::RateRandomWalk => (
            "The random walk of the bias: the integral of white noise. K is the Allan deviation at 3 s on the line of slope +1/2.",
            "How fast an estimated bias goes out of date; the random walk of the bias that Kalman filters and Kalibr ask for.",
            "It needs hours: record longer, at a constant temperature. Where it is only an upper bound, it may be zero.",
            &[Remedy::Plan],
        ),
        Term::RateRamp => (
            "A steady drift of the bias. The Allan deviation is R times tau over the square root of 2: the line of slope +1.",
            "Mostly warm-up or temperature, not noise. It hides K and B at long averaging times.",
            "Let the sensor warm up, and exclude that time.",
            &[Remedy::Skip(None)],
        ),
        Term::Quantization => (
            "The rounding of an angle or a velocity that is counted in steps. The Allan deviation is the square root of 3 times Q over tau: \
             the line of slope -1.",
            "Sensors that print rates do not have it: the rounding of a rate is white noise and part of N.",
            "Fit it only for sensors that count increments of angle or velocity.",
            &[],
        ),
    };
    let [gyro, accel, mag] = names;
    let mut titles = vec![gyro.name, accel.name, mag.name];
    titles.dedup();
    let mut aliases = titles.clone();
    aliases.extend(names.map(|names| names.short).into_iter().filter(|short| !short.is_empty()));
    aliases.extend((term == Term::Quantization).then_some("quantisation"));
    aliases.sort_unstable();
    aliases.dedup();
    let mut shorts = [gyro.short, accel.short].to_vec();
    shorts.retain(|short| !short.is_empty());
    shorts.dedup();
    Explanation {
        group: PARAMETERS,
        code: letter(term).into(),
        aliases,
        title: format!("{} ({}), slope {}", titles.join(" / "), shorts.join(" / "), gyro.slope),
        meaning: meaning.into(),
        why,
        advice,
        remedies,
        source: IEEE,
    }
}

/// The terms in which results are given.
const TERMS: [Entry; 6] = [
    (
        ("edf", &["degrees of freedom"]),
        "equivalent degrees of freedom",
        [
            "The degrees of freedom of the chi-squared distribution that the variance follows about its true value. Overlapping windows are \
             correlated: their number is larger.",
            "It gives the confidence interval of each deviation: with 2 the upper limit is several times the deviation, with 100 within some \
             15 %.",
            "It is proportional to the record length divided by tau. Do not trust points with fewer than 2.",
        ],
        &[Remedy::Plan],
        SP_1065,
    ),
    (
        ("confidence interval", &["pointwise", "interval"]),
        "confidence interval",
        [
            "The range that contains the true value with the stated probability, 95 % by default. Those of deviations are pointwise: each has \
             that probability by itself, not all of them together.",
            "It covers the sampling of this record only, not variation from unit to unit, day to day or with temperature.",
            "Record longer for a narrower one; compare several records for the variation between them.",
        ],
        &[],
        SP_1065,
    ),
    (
        ("tau", &["averaging time", "m", "averaging factor"]),
        "averaging time tau = m / rate",
        [
            "The duration of one cluster: m neighbouring samples whose average is compared with that of the next m.",
            "Each noise process dominates at its own averaging times. A wrong sample rate shifts all of them.",
            "The longest one is a fraction of the record.",
        ],
        &[Remedy::Plan, Remedy::GiveRate(None)],
        "IEEE Std 952-1997, annex C; NIST SP 1065",
    ),
    (
        ("aliasing", &["decimation", "averaging window", "register 85", "sensor's own N", "own N"]),
        "aliasing of the sensor's own sampling",
        [
            "The VN-100 samples at 800 Hz (the magnetometer slower), averages some samples (register 85, 4 by default) and sends fewer. Noise \
             above half the output rate is folded into the band.",
            "The measured noise density is higher than that of the data sheet: 2.24 times for the gyroscope at 40 Hz and the factory default. \
             For a filter at this rate the measured density is the right one.",
            "Set the averaging window to 800/rate, 20 at 40 Hz, or measure at a higher rate.",
        ],
        &[Remedy::Configure(vn100_analysis::Setting::Window(20))],
        "VectorNav VN-100 User Manual, register 85 (IMU filtering configuration)",
    ),
    (
        ("Allan deviation", &["ADEV", "OADEV", "allan", "hadamard", "slope", "minimum / 0.664"]),
        "Allan deviation",
        [
            "The root of half the mean squared difference between neighbouring averages over tau. OADEV uses overlapping averages. The \
             Hadamard deviation takes second differences, which a linear drift of the rate does not change.",
            "On log-log axes each noise process is a straight line of its own slope: N -1/2, B 0, K +1/2, R +1, Q -1.",
            "Use the fitted parameters. The graphical method is given for comparison only: N and K on lines of their slope at 1 s and 3 s, B as minimum / 0.664.",
        ],
        &[],
        "IEEE Std 952-1997, annex C; NIST SP 1065",
    ),
    (
        ("minimum of the curve", &["curve minimum", "minimum", "lowest deviation", "in-run bias stability"]),
        "minimum of the Allan deviation, or in-run bias stability",
        [
            "The lowest Allan deviation of the curve, and its averaging time.",
            "Many data sheets print it as in-run bias stability. The fitted B is at most 1/0.664 times it, because other noise at that tau raises the minimum.",
            "Compare it with the data sheet's figure of the same name, and B with B.",
        ],
        &[],
        IEEE,
    ),
];
