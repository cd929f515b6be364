//! The noise parameters of one axis, as far as its stream carries them.

use schemars::JsonSchema;
use serde::Serialize;

use crate::hypothesis_tests::holm;
use imu_noise::{
    BoxcarWindow, ChannelCurve, Deviation, Grade, GraphicalReadings, NoiseFit, NoiseModel, Octave, PROVED_P, Parameter,
    Sensor, Status, Term, Withheld, curve_minimum, white_deficit,
};
use vn100_protocol::Channel;

use super::{
    ChannelAssessment, OctaveVariances, axis_temperature::AxisTemperature, onboard::Onboard, white_budget::WhiteBudget,
};
use crate::{
    sensor::sensor_of,
    snapshot::{RateFrom, Snapshot},
};

/// If a filter takes the bias of a gyroscope out, with a time constant of tens of seconds, deviations
/// up to this averaging time, in seconds, still show the sensor.
pub const BEFORE_FILTER_S: f64 = 10.0;

/// The noise parameters of one axis.
#[derive(Debug, Clone)]
pub struct ChannelNoise {
    /// What the axis measures.
    pub sensor: Sensor,
    /// The fit itself; its parameters hold for the stream, see [`parameter`](Self::parameter).
    pub fit: NoiseFit,
    /// By the graphical method, for comparison with published figures only.
    pub classical: GraphicalReadings,
    /// Why bias instability, random walk and ramp are not those of the sensor.
    pub long_taus: LongTauValidity,
    /// What N is uncertain by.
    pub white_budget: WhiteBudget,
    /// Terms that are those of the rounding: the noise is less than half of a step of the values.
    pub(super) rounded_away: &'static [Term],
    /// The level has a step, a cycle or a warm-up, which the slow terms would be fitted to: they are no
    /// more than bounded.
    pub level_changes: bool,
    /// How the bias follows the temperature; `None` without one, and for magnetometers.
    pub temperature: Option<AxisTemperature>,
}

/// Why a gyroscope has no grade.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NoGrade {
    /// The sensor was moved.
    Moved,
    /// The stream does not carry its bias instability.
    BiasNotInStream,
    /// The sample rate is assumed, and N with it.
    RateAssumed,
    /// Its angle random walk is not known from above.
    WhiteNotKnown,
    /// Its bias instability is not known from above.
    BiasNotKnown,
}

/// Whether long averaging times show the sensor's own noise: bias instability, random walk, ramp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LongTauValidity {
    /// They do.
    Sensor,
    /// No: the message is that of the attitude filter, which removes the bias.
    Compensated,
    /// No: a filter removes the bias, as the curve falls below the white noise of short averaging
    /// times.
    LooksCompensated,
    /// No: the ambient magnetic field dominates.
    Surroundings,
    /// No: the sensor was moved.
    Motion,
    /// No: the axis has one value for long, or a sample far out.
    Spoiled,
}

impl ChannelNoise {
    /// Why the slow terms are no more than bounded; `None` where the record decides.
    pub fn withheld(&self) -> Option<Withheld> {
        match () {
            // what follows the temperature is a change of the level too
            () if self.follows_temperature() => Some(Withheld::Temperature),
            () if self.level_changes => Some(Withheld::LevelChange),
            () => SLOW.into_iter().find_map(|term| self.fit.rival(term)),
        }
    }

    /// The parameters of an axis; `None` for what is no axis of a sensor. `evidence`: what is known of
    /// it beside the curve.
    pub(super) fn new(
        channel: &Channel,
        curve: &OctaveVariances,
        snapshot: &Snapshot,
        onboard: Option<Onboard>,
        evidence: &ChannelCurve<'_>,
        confidence: f64,
        models: &Models,
    ) -> Option<Self> {
        let sensor = sensor_of(channel.quantity)?;
        let window = overlapping_window(onboard);
        let model = &models.get(&curve.octaves, window)?.model;
        let compensated = snapshot.layout.as_ref().is_some_and(|layout| layout.compensated == Some(true));
        // an octave more than terms to be distinguished
        let least = 4 + usize::from(snapshot.settings.quantization);
        let evidence = ChannelCurve { variances: &curve.variances, ..*evidence };
        let part = |octaves: usize| model.fit_part(&evidence, octaves.max(least), confidence);
        let before_filter = curve.octaves.iter().take_while(|octave| curve.tau_s(octave) <= BEFORE_FILTER_S).count();
        let (fit, long_taus) = match sensor {
            Sensor::Magnetometer => (part(curve.octaves.len()), LongTauValidity::Surroundings),
            Sensor::Gyroscope if compensated => (part(before_filter), LongTauValidity::Compensated),
            Sensor::Gyroscope | Sensor::Accelerometer => {
                let whole = model.fit(&ChannelCurve { has_ramp: true, ..evidence }, confidence);
                let may_fall = |fit: &NoiseFit| fit.quality.is_none() || falls_below_white(curve, fit, window);
                let before_filter = (sensor == Sensor::Gyroscope && may_fall(&whole)).then(|| part(before_filter));
                match before_filter.filter(|before_filter| falls_below_white(curve, before_filter, window)) {
                    Some(before_filter) => (before_filter, LongTauValidity::LooksCompensated),
                    None => (whole, LongTauValidity::Sensor),
                }
            }
        };
        let tau_s: Vec<f64> = curve.octaves.iter().map(|octave| curve.tau_s(octave)).collect();
        let deviations: Vec<f64> = curve.variances.iter().map(|variance| variance.sqrt()).collect();
        let classical = match curve.shape.deviation {
            Deviation::Allan => {
                let duration_s = curve.shape.samples as f64 * curve.shape.interval_s;
                GraphicalReadings::of(sensor, &tau_s, &deviations, duration_s)
            }
            // the recipes are for the Allan deviation
            Deviation::Hadamard => GraphicalReadings::not_applicable(sensor),
        };
        let white_budget = WhiteBudget::new(fit.parameter(Term::White), snapshot, onboard);
        Some(Self {
            sensor,
            fit,
            classical,
            long_taus,
            white_budget,
            rounded_away: &[],
            level_changes: false,
            temperature: None,
        })
    }

    /// A parameter of the sensor; `None` for one that was not asked for. What rounding hides is not
    /// measurable. Where long averaging times do not show the sensor, white and quantisation noise alone
    /// are its own. The interval of white noise holds what is known of the time scale.
    pub fn parameter(&self, term: Term) -> Option<Parameter> {
        if self.rounded_away.contains(&term) {
            return self.fit.parameter(term).map(|_| Parameter::without_value(Status::NotMeasurable));
        }
        match self.long_taus {
            _ if term == Term::White => self.fit.parameter(term).map(|white| self.white_budget.widened(white)),
            _ if term == Term::Quantization => self.fit.parameter(term),
            LongTauValidity::Sensor | LongTauValidity::Motion | LongTauValidity::Spoiled => self.fit.parameter(term),
            LongTauValidity::Compensated | LongTauValidity::LooksCompensated => {
                Some(Parameter::without_value(Status::NotMeasurable))
            }
            LongTauValidity::Surroundings => None,
        }
    }

    /// N of the sensor itself, without what averaging and decimation on board add; bounded where the
    /// window is not known. `None` where N was not asked for.
    pub fn unaliased_white(&self) -> Option<Parameter> {
        self.parameter(Term::White).map(|white| self.white_budget.unaliased(white))
    }

    /// The best and the worst grade that its own N and B leave a gyroscope, or why it has none.
    pub fn grade(&self) -> Option<Result<(Grade, Grade), NoGrade>> {
        if self.sensor != Sensor::Gyroscope {
            return None;
        }
        let (white, bias) = (self.unaliased_white()?, self.parameter(Term::BiasInstability)?);
        Some(match self.long_taus {
            LongTauValidity::Motion => Err(NoGrade::Moved),
            LongTauValidity::Compensated | LongTauValidity::LooksCompensated | LongTauValidity::Surroundings => {
                Err(NoGrade::BiasNotInStream)
            }
            LongTauValidity::Sensor if self.white_budget.rate.from == RateFrom::Assumed => Err(NoGrade::RateAssumed),
            LongTauValidity::Sensor | LongTauValidity::Spoiled if white.upper.is_none() => Err(NoGrade::WhiteNotKnown),
            LongTauValidity::Sensor | LongTauValidity::Spoiled => {
                Grade::range(&white, &bias).ok_or(NoGrade::BiasNotKnown)
            }
        })
    }

    /// What data sheets call in-run bias stability; `None` where B was not asked for.
    pub fn curve_minimum(&self) -> Option<Parameter> {
        let [white, bias, walk] =
            [Term::White, Term::BiasInstability, Term::RateRandomWalk].map(|term| self.parameter(term));
        Some(curve_minimum(&white?, &bias?, &walk?, self.fit.likeliest.rate_random_walk))
    }

    fn follows_temperature(&self) -> bool {
        self.temperature.as_ref().and_then(AxisTemperature::share_as_noise).is_some()
    }

    fn bound_slow_terms(&mut self) {
        let is_estimated = |term: &Term| self.fit.parameter(*term).is_some_and(|p| p.status == Status::Estimated);
        let estimated: Vec<Term> = SLOW.into_iter().filter(is_estimated).collect();
        estimated.into_iter().for_each(|term| self.fit.not_proved(term));
    }

    /// Withholds everything: what the curve shows is no noise.
    pub(super) fn was_spoiled(&mut self) {
        self.fit.withhold(Status::ModelRejected);
        self.classical = GraphicalReadings::not_applicable(self.sensor);
        if let LongTauValidity::Sensor | LongTauValidity::LooksCompensated = self.long_taus {
            self.long_taus = LongTauValidity::Spoiled;
        }
    }

    /// Withholds everything that describes the motion.
    pub(super) fn was_moved(&mut self) {
        self.fit.withhold(Status::Moved);
        self.classical = GraphicalReadings::not_applicable(self.sensor);
        self.white_budget.sampling = None;
        self.rounded_away = &[];
        if let LongTauValidity::Sensor | LongTauValidity::LooksCompensated = self.long_taus {
            self.long_taus = LongTauValidity::Motion;
        }
    }
}

const SLOW: [Term; 3] = [Term::BiasInstability, Term::RateRandomWalk, Term::RateRamp];

/// Bounds the slow terms where they would be fitted to a step, a cycle or a warm-up of the level, or to
/// what the temperature made.
pub(super) fn withhold_what_poses_as_noise(channels: &mut [ChannelAssessment]) {
    for ChannelAssessment { noise, stationarity, .. } in channels {
        let Some(noise) = noise else { continue };
        noise.level_changes = stationarity.level_poses_as_noise();
        if noise.level_changes || noise.follows_temperature() {
            noise.bound_slow_terms();
        }
    }
}

/// Bounds the terms that the record, all axes and slow terms together (Holm), does not prove.
pub(super) fn withhold_unproved(channels: &mut [ChannelAssessment]) {
    let mut tests = Vec::new();
    for (channel, assessment) in channels.iter().enumerate() {
        let noise = assessment.noise.as_ref().filter(|noise| noise.long_taus == LongTauValidity::Sensor);
        let p = |term| Some((channel, term, noise?.parameter(term)?.p?));
        tests.extend(SLOW.into_iter().filter_map(p));
    }
    let corrected = holm(&tests.iter().map(|(.., p)| *p).collect::<Vec<_>>());
    for ((channel, term, _), corrected) in tests.into_iter().zip(corrected) {
        if let Some(noise) = channels[channel].noise.as_mut().filter(|_| corrected > PROVED_P) {
            noise.fit.not_proved(term);
        }
    }
}

/// The averaging on board, where it is known and depresses short averaging times: unless the
/// sensor's own low pass does too, whose transfer function is not known.
fn overlapping_window(onboard: Option<Onboard>) -> Option<BoxcarWindow> {
    let is_alone = |onboard: &Onboard| onboard.window_known() && onboard.own_low_pass().is_none();
    onboard.filter(|onboard| is_alone(onboard) && onboard.window.overlaps()).map(|onboard| onboard.window)
}

/// Whether the deviation falls, beyond doubt, below the white noise of its short averaging times. A
/// low pass takes from the shortest ones, and removes no bias.
fn falls_below_white(curve: &OctaveVariances, short: &NoiseFit, window: Option<BoxcarWindow>) -> bool {
    const BEYOND_DOUBT: f64 = 3.7;
    let white = short.parameter(Term::White).and_then(|white| white.value);
    // after ten times what the filter remembers
    let shortest = short.correlation_samples.map_or(0.0, |samples| 10.0 * samples);
    let low_pass = curve.octaves.iter().take_while(|octave| (octave.m as f64) < shortest).count();
    let (octaves, variances) = (&curve.octaves[low_pass..], &curve.variances[low_pass..]);
    let deficit = |white| white_deficit(octaves, variances, &curve.shape, white, window);
    white.is_some_and(|white| deficit(white) > BEYOND_DOUBT)
}

/// Noise models, each made once for all the axes that were sampled together.
pub(super) struct Models {
    made: Vec<Made>,
}

struct Made {
    octaves: Vec<Octave>,
    window: Option<BoxcarWindow>,
    model: NoiseModel,
}

impl Models {
    pub(super) fn of(snapshot: &Snapshot, curves: &[OctaveVariances]) -> Self {
        let mut models = Self { made: Vec::new() };
        let is_axis = |channel: &Channel| sensor_of(channel.quantity).is_some();
        let axes = snapshot.measured().zip(curves).filter(|((channel, _), _)| is_axis(channel));
        for ((channel, results), curve) in axes {
            let window = overlapping_window(Onboard::of(channel, results, snapshot));
            if models.get(&curve.octaves, window).is_none() {
                let model = NoiseModel::new(&curve.octaves, &curve.shape, window, snapshot.settings.quantization);
                models.made.push(Made { octaves: curve.octaves.clone(), window, model });
            }
        }
        models
    }

    fn get(&self, octaves: &[Octave], window: Option<BoxcarWindow>) -> Option<&Made> {
        self.made.iter().find(|made| made.octaves == octaves && made.window == window)
    }
}

#[cfg(test)]
mod tests {
    use imu_noise::{Estimator, RecordShape};

    use super::{super::WindowFrom, *};

    /// Of ten minutes of white noise with N = 1 that reads in every octave what is expected of it.
    fn white_fit() -> (RecordShape, NoiseFit) {
        let interval_s = 0.025;
        let shape = RecordShape {
            samples: (600.0 / interval_s) as u64,
            interval_s,
            estimator: Estimator::Strided,
            deviation: Deviation::Allan,
        };
        let octaves = shape.octaves();
        let variances: Vec<f64> = octaves.iter().map(|octave| 1.0 / (octave.m as f64 * interval_s)).collect();
        let model = NoiseModel::new(&octaves, &shape, None, false);
        let fit = model.fit(&ChannelCurve::new(&variances, true), 0.95);
        (shape, fit)
    }

    #[test]
    fn a_window_counts_that_is_known_and_overlaps() {
        let onboard = |window_from, length| {
            let window = BoxcarWindow { length, decimation: 4.0 };
            Onboard { refresh_hz: 800.0, rate_hz: 200.0, window, window_from }
        };
        for from in [WindowFrom::Register, WindowFrom::Given] {
            assert_eq!(overlapping_window(Some(onboard(from, 20))).map(|window| window.length), Some(20));
            assert_eq!(overlapping_window(Some(onboard(from, 4))), None);
        }
        assert_eq!(overlapping_window(Some(onboard(WindowFrom::Default, 20))), None);
        assert_eq!(overlapping_window(None), None);
    }

    #[test]
    fn the_whole_solution_holds_terms_that_are_only_bounded() {
        let (shape, white) = white_fit();
        let octaves = shape.octaves();
        // a walk too weak to be proved
        let variances: Vec<f64> = (octaves.iter())
            .map(|octave| {
                Term::White.variance(1.0, octave.m, &shape) + Term::RateRandomWalk.variance(0.02, octave.m, &shape)
            })
            .collect();
        let fit = NoiseModel::new(&octaves, &shape, None, false).fit(&ChannelCurve::new(&variances, true), 0.95);
        assert_eq!(fit.parameter(Term::RateRandomWalk).unwrap().status, Status::Bounded);
        let mut longest = 0.0;
        for octave in &octaves {
            let Some(found) = fit.deviation(octave.m) else { continue };
            let alone = white.deviation(octave.m).unwrap();
            assert!((alone / Term::White.variance(1.0, octave.m, &shape).sqrt() - 1.0).abs() < 0.01);
            longest = found / alone;
        }
        assert!((1.05..4.0).contains(&longest), "{longest} times the white noise");
        let last = octaves.last().unwrap().m;
        assert!(fit.deviation(last).is_none() && fit.deviation(3).is_none());
    }
}
