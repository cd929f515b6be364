//! What changes the noise between the sensor and its stream: averaging and decimation on board, a
//! filter of the bias, rounding.

use imu_noise::{BoxcarWindow, RollOff};
use vn100_protocol::{Channel, ImuFilter, Quantity, Register, RegisterContents, RegisterFields};

use super::{ChannelAssessment, noise::LongTauValidity};
use crate::{
    accumulate::sensor_rates::rates_hz,
    remedy::{Remedy, Setting, Text},
    sensor::{sensor_name, sensor_of},
    snapshot::{ChannelSnapshot, Snapshot},
    warning::{Warning, WarningKind},
};

/// Refreshes of gyroscope and accelerometer per second.
const IMU_REFRESH_HZ: f64 = 800.0;

/// Averaging and decimation inside a VN-100, for one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Onboard {
    /// Refreshes of the channel's sensor per second.
    pub refresh_hz: f64,
    /// Samples of the channel per second.
    pub rate_hz: f64,
    /// The averaging window and the decimation.
    pub window: BoxcarWindow,
    /// Where the window comes from.
    pub window_from: WindowFrom,
}

/// Where the averaging window of a sensor comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WindowFrom {
    /// Register 85, within the stream.
    Register,
    /// The user gave the setting of register 85.
    Given,
    /// None: the sensor integrates over the whole interval.
    Integrated,
    /// The sensor's factory default, which may have been changed.
    Default,
}

impl WindowFrom {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Register, Self::Given, Self::Integrated, Self::Default];
}

impl Onboard {
    /// Refreshes of the magnetometer per second.
    pub const MAG_REFRESH_HZ: f64 = 250.0;

    /// How far the factor may be off, relative, as the sensor's own roll-off is not known: measured
    /// at 40 Hz with a window of four refreshes were 2.17 to 2.47 where the formula gives 2.236.
    pub const UNCERTAINTY: f64 = 0.10;

    /// [`UNCERTAINTY`](Self::UNCERTAINTY) where white noise is aliased. Where the windows cover all
    /// refreshes evenly, the density at low frequencies stays as it is, whatever the roll-off.
    pub(crate) fn uncertainty_of(window: BoxcarWindow) -> f64 {
        const EXACT: f64 = 1e-9;
        if window.white_factor() < 1.0 + EXACT { 0.0 } else { Self::UNCERTAINTY }
    }

    /// Whether the window is known; otherwise nothing can pass or fail by it.
    #[must_use]
    pub fn window_known(&self) -> bool {
        self.window_from != WindowFrom::Default
    }

    /// The window that would bring the sensor's own density into the stream.
    #[must_use]
    pub fn unaliased_window(&self) -> u32 {
        self.window.decimation.round() as u32
    }

    /// What the low pass of accelerometer and gyroscope, with their window, makes of neighbouring
    /// outputs; `None` where these are independent, or where a long window that overlaps says more.
    ///
    /// The low pass is not documented: one second of a real sensor's output has autocorrelations of
    /// 0.83, 0.49, 0.17, -0.02, -0.05 (gyro) and 0.86, 0.60, 0.35, 0.14, 0.08 (accelerometer) at
    /// lags of 1.25 ms, behind a window of four of them.
    pub(super) fn own_low_pass(&self) -> Option<RollOff> {
        (self.refresh_hz == IMU_REFRESH_HZ).then(|| Self::low_pass_of(self.window, self.rate_hz)).flatten()
    }

    /// The same of a window on gyro or accelerometer, for outputs at this rate.
    fn low_pass_of(window: BoxcarWindow, rate_hz: f64) -> Option<RollOff> {
        /// Refreshes after which the low pass has forgotten.
        const MEMORY: f64 = 3.0;
        /// Refreshes averaged from which on the window says more.
        const LONG: f64 = 8.0;
        /// Refreshes averaged from which on neighbours are alike to less than 0.3 %.
        const NEGLIGIBLE: f64 = 160.0;
        /// Of the shortest window and low pass together, more than was measured.
        const CORRELATION_S: f64 = 0.005;
        let length = f64::from(window.length.max(1));
        let between = window.decimation.max(1.0) - length;
        let is_modelled = length >= LONG && between < 0.0;
        (between < MEMORY && !is_modelled && length < NEGLIGIBLE)
            .then_some(RollOff { correlation_samples: 1.0 + CORRELATION_S * rate_hz })
    }

    /// For a channel of a sensor of this make that is averaged on board.
    pub(super) fn of(channel: &Channel, results: &ChannelSnapshot, snapshot: &Snapshot) -> Option<Self> {
        let layout = snapshot.layout.as_ref().filter(|layout| !rates_hz(Some(layout)).is_empty())?;
        let filter = filter(snapshot);
        let averaging = filter.unwrap_or_default();
        // a user knows of one window alone
        let given = snapshot.given_window.filter(|_| filter.is_none() && channel.quantity != Quantity::MagneticField);
        let (refresh_hz, window, mode) = match channel.quantity {
            Quantity::MagneticField => (Self::MAG_REFRESH_HZ, averaging.mag_window, averaging.mag_mode),
            Quantity::Acceleration => (IMU_REFRESH_HZ, averaging.accel_window, averaging.accel_mode),
            Quantity::AngularRate => (IMU_REFRESH_HZ, averaging.gyro_window, averaging.gyro_mode),
            Quantity::Angle | Quantity::Quaternion | Quantity::Temperature | Quantity::Pressure | Quantity::Value => {
                return None;
            }
        };
        // bits of the mode: 1 averages the uncompensated values, 2 the compensated ones
        let averaged = mode & if layout.compensated == Some(false) { 1 } else { 2 } != 0;
        let length = if averaged { given.unwrap_or(window.into()) } else { 1 };
        let rate_hz = snapshot.rate_of(results);
        let decimation = refresh_hz / rate_hz;
        if channel.increment_step.is_some() {
            let window = BoxcarWindow { length: decimation.round() as u32, decimation };
            return Some(Self { refresh_hz, rate_hz, window, window_from: WindowFrom::Integrated });
        }
        let window_from = match (filter, given) {
            (Some(_), _) => WindowFrom::Register,
            (None, Some(_)) => WindowFrom::Given,
            (None, None) => WindowFrom::Default,
        };
        Some(Self { refresh_hz, rate_hz, window: BoxcarWindow { length, decimation }, window_from })
    }
}

fn filter(snapshot: &Snapshot) -> Option<ImuFilter> {
    let register = Register::IMU_FILTER;
    let fields = RegisterFields::new(snapshot.registers.get(&register.0)?.as_str()).ok()?;
    RegisterContents { register, fields }.value().ok()
}

/// `was_moved`: what the curves show is the motion.
pub(super) fn warnings(snapshot: &Snapshot, assessed: &[ChannelAssessment], was_moved: bool) -> Vec<Warning> {
    let names = |holds: &dyn Fn(&Channel, &ChannelSnapshot, &ChannelAssessment) -> bool| -> Vec<String> {
        (snapshot.assessed(assessed))
            .filter(|(channel, results, assessed)| holds(channel, results, assessed))
            .map(|(channel, ..)| channel.name.to_string())
            .collect()
    };
    let mut warnings = Vec::new();
    let mut filters: Vec<Onboard> = Vec::new();
    for onboard in assessed.iter().filter_map(|channel| channel.onboard) {
        if !filters.contains(&onboard) {
            filters.push(onboard);
        }
    }
    for onboard in filters {
        let mut sensors: Vec<&str> = Vec::new();
        for (channel, ..) in snapshot.assessed(assessed).filter(|(.., assessed)| assessed.onboard == Some(onboard)) {
            let sensor = sensor_of(channel.quantity).map_or("sensor", sensor_name);
            if !sensors.contains(&sensor) {
                sensors.push(sensor);
            }
        }
        if let Some((headline, details)) = decimation(&sensors, &onboard) {
            let channels = names(&|_, _, assessed| assessed.onboard == Some(onboard));
            warnings.push(Warning::new(WarningKind::DecimatedStream, channels, headline, details));
        }
    }
    warnings.extend(contradicted_window(snapshot));
    if was_moved {
        return warnings;
    }
    let tracked = names(&|_, _, assessed| {
        assessed.noise.as_ref().is_some_and(|noise| noise.long_taus == LongTauValidity::LooksCompensated)
    });
    if !tracked.is_empty() {
        let headline = format!("a filter removes the bias of {}: B and K not measurable", tracked.join(" "));
        let details = "At long averaging times the deviation falls below the white noise of the channel, which that of a sensor does \
                       not. Record its uncompensated output to measure bias instability, random walk and ramp.";
        warnings.push(Warning::new(WarningKind::CompensatedStream, tracked, headline, details));
    }
    let filtered = names(&|_, _, assessed| filtered_from_s(assessed).is_some());
    if !filtered.is_empty() {
        let from_s = assessed.iter().filter_map(filtered_from_s).fold(0.0, f64::max);
        let headline = format!("low-pass filter on {}: N fitted from {from_s:.3} s", filtered.join(" "));
        let details = "The spectrum falls towards high frequencies as noise of a sensor does not: a low pass slower than the output, of \
                       unknown transfer function. Shorter averaging times are excluded from the fit.";
        warnings.push(Warning::new(WarningKind::LowPass, filtered, headline, details));
    }
    let full = names(&|_, _, assessed| assessed.noise.as_ref().is_some_and(|noise| noise.fit.lacks_free_band));
    if !full.is_empty() {
        let headline = format!("spectral peaks cover more than half of the band on {}", full.join(" "));
        let details = "What looks like white noise between them may be theirs: only an upper bound for N is given. Measure on a heavy \
                       base, away from vibration.";
        warnings.push(Warning::new(WarningKind::LineFreeBand, full, headline, details));
    }
    warnings.extend(correlated_noise(snapshot, assessed));
    let rounded = names(&|_, _, assessed| assessed.noise.as_ref().is_some_and(|noise| !noise.rounded_away.is_empty()));
    if !rounded.is_empty() {
        let headline = format!("quantisation hides the noise of {}", rounded.join(" "));
        let details = "From sample to sample the noise is less than half a step of the printed values: the curve is that of the \
                       rounding, not of the sensor.";
        warnings.push(Warning::new(WarningKind::QuantisationFloor, rounded, headline, details));
    }
    warnings
}

/// A window that was given and that register 85 contradicts.
fn contradicted_window(snapshot: &Snapshot) -> Option<Warning> {
    let (given, filter) = snapshot.given_window.zip(filter(snapshot))?;
    let windows = [filter.accel_window, filter.gyro_window].map(u32::from);
    (windows != [given; 2]).then(|| {
        let [accel, gyro] = windows;
        let headline = format!("averaging window {given} ignored: register 85 is {accel} (accel), {gyro} (gyro)");
        Warning::new(WarningKind::DecimatedStream, Vec::new(), headline, "The stream contains the register.")
    })
}

/// From where on averaging times show the sensor behind a filter that is not its own.
fn filtered_from_s(assessed: &ChannelAssessment) -> Option<f64> {
    let fit = &assessed.noise.as_ref()?.fit;
    let own = assessed.onboard.and_then(|onboard| onboard.own_low_pass());
    let unknown =
        fit.roll_off.filter(|found| own.is_none_or(|own| found.correlation_samples > own.correlation_samples));
    unknown.and(fit.quality).map(|quality| quality.tau_min_s)
}

fn correlated_noise(snapshot: &Snapshot, assessed: &[ChannelAssessment]) -> Option<Warning> {
    let found: Vec<(String, String)> = (snapshot.assessed(assessed))
        .filter_map(|(channel, _, assessed)| {
            let fit = &assessed.noise.as_ref()?.fit;
            let apparent = fit.apparent_white()?;
            let process = fit.processes.iter().max_by(|a, b| a.sigma.total_cmp(&b.sigma))?;
            let (name, unit) = (channel.name.to_string(), &channel.unit);
            let text = format!(
                "{name} {:.2e} {unit} with a correlation time of about {:.1} s, apparent random walk {apparent:.3e} {unit}/sqrt(Hz)",
                process.sigma, process.correlation_time_s
            );
            Some((name, text))
        })
        .collect();
    if found.is_empty() {
        return None;
    }
    let (channels, list): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    let headline = format!("correlated noise, in addition to white noise, on {}", channels.join(" "));
    let details = format!(
        "{}. N holds for averaging times below the correlation time; over longer times the integral follows the apparent random walk.",
        list.join("; ")
    );
    Some(Warning::new(WarningKind::CorrelatedNoise, channels, headline, details))
}

/// What averaging and decimation on board do to white noise, and what to do about it; `None` where
/// that is less than is known of the factor.
fn decimation(sensors: &[&str], onboard: &Onboard) -> Option<(String, Text)> {
    let Onboard { refresh_hz, rate_hz, window, window_from } = *onboard;
    let averages = match window.length {
        0 | 1 => "does not average them".into(),
        length => format!("averages {length} samples"),
    };
    let source = match window_from {
        WindowFrom::Register => "register 85",
        WindowFrom::Given => "as given",
        WindowFrom::Integrated => "integrals",
        WindowFrom::Default => "factory default of register 85",
    };
    let factor = window.white_factor();
    let all = sensors.join(" and ");
    let sampling = format!("Sampled at {refresh_hz} Hz; the sensor {averages} ({source}) and outputs {rate_hz} Hz.");
    let is_imu = refresh_hz > Onboard::MAG_REFRESH_HZ;
    let window_to_set = onboard.unaliased_window();
    let advice = match is_imu {
        true => Text::from(format!(" A window of {window_to_set} (`"))
            .remedy(Remedy::Configure(Setting::Window(window_to_set)))
            .then("`) avoids it."),
        false => Text::default(),
    };
    if window.overlaps() && onboard.window_known() {
        let details = format!(
            "{sampling} Neighbouring samples share values, so that deviations at short averaging times are too low; N is corrected for it."
        );
        Some((format!("{all}: averaging window longer than the output interval"), Text::from(details).append(advice)))
    } else if factor > 1.0 + Onboard::UNCERTAINTY {
        let percent = 100.0 * Onboard::UNCERTAINTY;
        let headline = format!("aliasing raises N of {all} {factor:.2} times (±{percent:.0} %)");
        let details = format!(
            "{sampling} White noise above {} Hz aliases into the band: multiply the density of a data sheet by that factor before comparing.",
            rate_hz / 2.0
        );
        let details = Text::from(details).append(advice);
        Some((
            headline,
            match onboard.window_known() || !is_imu {
                true => details,
                false => details.then(" If register 85 is known, set ").remedy(Remedy::GiveWindow).then("."),
            },
        ))
    } else {
        None
    }
}
