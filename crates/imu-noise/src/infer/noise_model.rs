//! Noise models: N, B, K and a ramp from the octaves of a record.

mod boxcar;
mod channel_curve;
mod channel_fit;
mod covariance;
mod curve_reading;
mod fit;
mod gauss_markov;
mod joint;
mod least_half_width;
mod level_likelihood;
mod model;
mod noise_fit;
mod parameter;
mod record_length;
mod regression;
mod slope;
mod term;

use core::cell::RefCell;

use super::confidence::edf;
use super::power_law::PowerLaw;
use crate::accumulate::record::{Octave, RecordShape};
use boxcar::StreamedWhite;
pub use boxcar::{BoxcarWindow, white_deficit};
pub use channel_curve::ChannelCurve;
pub use curve_reading::{ClassicalReading, NotRead, SlopeLine, classical_reading, curve_minimum, visible_random_walk};
use joint::{Component, Phase, Phases, of_each};
pub use least_half_width::least_half_width;
use model::Model;
pub use noise_fit::{FitQuality, GaussMarkovProcess, NoiseFit};
pub use parameter::{PROVED_P, Parameter, Status};
pub use record_length::{Aim, Wanted};
use slope::Slope;
pub use term::{Term, Terms};

/// Degrees of freedom of an octave, in a random walk, to have a part in the fit: two octaves that
/// share all samples are too far from jointly normal, and would show next to nothing.
const LEAST_EDF: f64 = 2.0;

/// A noise model for all channels that were sampled together: it holds how the octaves of their
/// record vary, and together.
#[derive(Clone, Debug)]
pub struct NoiseModel {
    shape: RecordShape,
    terms: Terms,
    window: Option<BoxcarWindow>,
    /// Stochastic terms, in order.
    noise: Vec<Term>,
    /// The octaves that can vary, with two windows or more, and their places among those given.
    octaves: Vec<(usize, Octave)>,
    /// Of each of these, the degrees of freedom in a random walk, which has fewest.
    least_edf: Vec<f64>,
    /// How many of these, from the first on, have a part in the fit.
    fitted: usize,
    without_ramp: Option<Model>,
    with_ramp: Option<Model>,
}

impl NoiseModel {
    /// A model of `terms` for `octaves` in ascending order. `window` is the averaging on board,
    /// where it is known and matters: see [`BoxcarWindow`].
    ///
    /// Costs a few milliseconds; the fits of the channels are cheaper.
    #[must_use]
    pub fn new(octaves: &[Octave], shape: &RecordShape, terms: Terms, window: Option<BoxcarWindow>) -> Self {
        Self::beside(octaves, shape, terms, window, None)
    }

    /// The same for a record of another length, with the same interval, estimator and deviation:
    /// cheaper than a new one.
    #[must_use]
    pub fn of_length(&self, octaves: &[Octave], samples: u64) -> Self {
        Self::beside(octaves, &RecordShape { samples, ..self.shape }, self.terms, self.window, Some(self))
    }

    fn beside(
        octaves: &[Octave],
        shape: &RecordShape,
        terms: Terms,
        window: Option<BoxcarWindow>,
        known: Option<&Self>,
    ) -> Self {
        let noise: Vec<Term> =
            Term::ALL.into_iter().filter(|term| terms.contains(*term) && *term != Term::RateRamp).collect();
        let used = octaves.iter().copied().enumerate();
        let used =
            used.filter_map(|(place, octave)| Some(((place, octave), edf(&octave, shape, PowerLaw::RandomWalk)?)));
        let (used, least_edf): (Vec<(usize, Octave)>, Vec<f64>) = used.unzip();
        let fitted = least_edf.iter().take_while(|edf| **edf >= LEAST_EDF).count();
        let octaves_used: Vec<Octave> = used.iter().map(|(_, octave)| *octave).collect();
        let model = (!noise.is_empty() && !used.is_empty()).then(|| {
            let known = known.and_then(|known| known.without_ramp.as_ref());
            model(&octaves_used, shape, &noise, window, known)
        });
        let with_ramp = model.clone().filter(|_| terms.contains(Term::RateRamp));
        Self {
            shape: *shape,
            terms,
            window,
            without_ramp: model,
            with_ramp: with_ramp.map(|model| model.with_ramp(Slope::new(&noise, &octaves_used, shape))),
            octaves: used,
            least_edf,
            fitted,
            noise,
        }
    }
}

/// The generalised covariance of the phase of a noise, with what was asked for at short lags: all
/// pairs of octaves ask for the same ones, and each costs a logarithm.
struct RememberedPhase {
    law: PowerLaw,
    /// By lag; no number if it was not asked for.
    known: RefCell<Vec<f64>>,
}

impl RememberedPhase {
    const LAGS: usize = 8192;

    fn new(law: PowerLaw) -> Self {
        Self { law, known: RefCell::new(vec![f64::NAN; Self::LAGS]) }
    }

    /// At an integer lag.
    fn at(&self, lag: f64) -> f64 {
        let lag = lag.abs();
        let mut known = self.known.borrow_mut();
        let Some(known) = known.get_mut(lag as usize).filter(|_| lag.fract() == 0.0) else {
            return self.law.phase_covariance(lag);
        };
        if known.is_nan() {
            *known = self.law.phase_covariance(lag);
        }
        *known
    }
}

fn model(
    octaves: &[Octave],
    shape: &RecordShape,
    noise: &[Term],
    window: Option<BoxcarWindow>,
    known: Option<&Model>,
) -> Model {
    let averaged = StreamedWhite::new(window);
    let remembered = RememberedPhase::new(PowerLaw::Flicker);
    let white = |lag: f64| averaged.phase_covariance(lag);
    let quantization = |lag: f64| PowerLaw::WhitePhase.phase_covariance(lag);
    let flicker = |lag: f64| remembered.at(lag);
    let walk = |lag: f64| PowerLaw::RandomWalk.phase_covariance(lag);
    let (whites, quantizations, flickers, walks) =
        (of_each(white), of_each(quantization), of_each(flicker), of_each(walk));
    let component = |term: &Term| -> Option<Component<'_>> {
        let (phase, phases): (Phase<'_>, Phases<'_>) = match term {
            Term::Quantization => (&quantization, &quantizations),
            Term::White => (&white, &whites),
            Term::BiasInstability => (&flicker, &flickers),
            Term::RateRandomWalk => (&walk, &walks),
            Term::RateRamp => return None,
        };
        let scale = if *term == Term::White { averaged.length() } else { 1 };
        Some(Component { phase, phases, meets_at_edges: *term == Term::Quantization, scale })
    };
    let components: Vec<_> = noise.iter().filter_map(component).collect();
    Model::new(octaves, shape, &components, known)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_remembered_phase_is_the_phase() {
        for law in [PowerLaw::White, PowerLaw::Flicker] {
            let remembered = RememberedPhase::new(law);
            for lag in [0.0, 3.0, -3.0, 3.0, 8191.0, 8192.0, -70_000.0, 2.5] {
                assert_eq!(remembered.at(lag), law.phase_covariance(lag), "{law:?} {lag}");
            }
        }
    }
}
