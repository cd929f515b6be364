//! From the structures of one channel to what is said of it.

use super::{
    ChannelCurve, FitQuality, GaussMarkovProcess, NoiseFit, NoiseModel, Parameter, SlowNoise, Status, Term, Withheld,
    density::{FLICKER, WALK, WHITE, variance_of_process},
    search::{Candidate, Found, Search},
    spectral_rows::{ChannelData, GridOctave},
    thresholds::{
        BEYOND_ANY_FILTER, BEYOND_MEMORY, FILTERS, LEAST_EDF, LEAST_EDF_OF_BOUND, MOST_COSINES, NO_BOUND, PRESENT,
        PROCESSES_INSTEAD, PROVED, RAMP_PRESENT, REJECTED,
    },
};
use crate::accumulate::record::Deviation;
use crate::infer::chi_squared;

impl NoiseModel {
    /// Fits the model to one channel, by one penalised likelihood of segments of the spectrum, the cosine
    /// coefficients of the level, and of the octaves what neither holds.
    ///
    /// Components are white noise behind any filter that forgets within forty samples, flicker noise, a
    /// random walk, Gauss-Markov processes and lines; the mean may have a ramp, a warm-up or a cycle.
    /// Intervals hold with every structure that the record does not decide against.
    ///
    /// A parameter is [`Status::Estimated`] where the likelihood excludes its absence by more than 1.96
    /// standard deviations (a ramp by 2.25) beside every other explanation; else it is bounded from above,
    /// and [`NoiseFit::rival`] says what explains as much. Limits are where the likelihood has fallen by
    /// what the level `confidence` (0 < p < 1) allows, all other parameters fitted anew, and are wider
    /// where the channel deviates from the model by more than chance. Beyond six times the expected
    /// squares the model is rejected. N that is not estimated is bounded by the octaves longer than any
    /// possible filter, and by the fit where lines cover more than half of the frequencies.
    pub fn fit(&self, curve: &ChannelCurve<'_>, confidence: f64) -> NoiseFit {
        self.fit_octaves(curve, self.grid.octaves.len(), confidence)
    }

    /// As [`fit`](Self::fit), without a ramp, to the averaging times of the first `octaves` alone: for
    /// streams whose long averaging times show something else.
    pub fn fit_part(&self, curve: &ChannelCurve<'_>, octaves: usize, confidence: f64) -> NoiseFit {
        let octaves = self.grid.octaves.partition_point(|of| of.place < octaves);
        let mut fit = self.fit_octaves(&ChannelCurve { has_ramp: false, ..*curve }, octaves, confidence);
        fit.parameters[Term::RateRamp as usize] = None;
        fit
    }

    fn fit_octaves(&self, curve: &ChannelCurve<'_>, octaves: usize, confidence: f64) -> NoiseFit {
        let data = ChannelData::new(&self.grid, curve, octaves);
        let found = data.zip(chi_squared::normal_two_sided(confidence)).and_then(|(data, z)| {
            let is_part = octaves < self.grid.octaves.len();
            ReadOut::new(self, &data, curve, z, is_part).map(|read_out| read_out.fit(confidence))
        });
        found.unwrap_or_else(|| self.without_values(Status::NotObservable))
    }

    pub(super) fn without_values(&self, status: Status) -> NoiseFit {
        let is_in = |term| term != Term::Quantization || self.layout.quantization.is_some();
        let parameter = |term| is_in(term).then_some(Parameter::without_value(status));
        NoiseFit { parameters: Term::ALL.map(parameter), ..NoiseFit::default() }
    }
}

pub(super) struct ReadOut<'a> {
    model: &'a NoiseModel,
    search: Search<'a>,
    /// Relative variance of the power of white noise of heavy tails beyond that of normal noise.
    tails: f64,
    lacks_free_band: bool,
}

impl<'a> ReadOut<'a> {
    /// `None` if the channel does not show more than it has parameters, or no structure explains it.
    pub(super) fn new(
        model: &'a NoiseModel,
        data: &'a ChannelData<'a>,
        curve: &ChannelCurve<'_>,
        z: f64,
        is_part: bool,
    ) -> Option<Self> {
        let is_parted = curve.signal.is_some_and(|(signal, _)| signal.is_parted);
        let has_ramp = curve.has_ramp && !is_parted;
        let shapes = if is_part { None } else { model.shapes_of(data) };
        let parameters = 3 + usize::from(model.layout.quantization.is_some()) + usize::from(has_ramp);
        let shown = data.octaves_in_use() + usize::from(has_ramp) + if data.has_segments() { 8 } else { 0 };
        if shown <= parameters {
            return None;
        }
        let search = Search::new(data, &model.layout, shapes, has_ramp, z).of_record()?;
        let tails = curve.fourth_cumulant.max(0.0) / (data.scale * data.scale) / model.shape.samples as f64;
        let lacks_free_band = curve.bands.iter().map(|band| band.share_of_band).sum::<f64>() > 0.5;
        Some(Self { model, search, tails, lacks_free_band })
    }

    /// Of a record that shows what is expected, for plans: a short filter is not looked for.
    pub(super) fn expecting(model: &'a NoiseModel, data: &'a ChannelData<'a>, z: f64) -> Option<Self> {
        let search = Search::new(data, &model.layout, model.shapes_of(data), true, z).of_expectation()?;
        Some(Self { model, search, tails: 0.0, lacks_free_band: false })
    }

    /// One parameter, of which the model holds.
    pub(super) fn parameter(&self, term: Term, confidence: f64) -> Option<Parameter> {
        match term {
            Term::White => self.white_parameter(confidence),
            other => Some(self.amplitude(other, self.slow(other, self.model.column(other)?))),
        }
    }

    pub(super) fn fit(&self, confidence: f64) -> NoiseFit {
        let fit = if self.search.dispersion < REJECTED { self.parameters(confidence) } else { None };
        fit.unwrap_or_else(|| self.rejected(confidence))
    }

    /// No model holds: N is bounded by the curve.
    fn rejected(&self, confidence: f64) -> NoiseFit {
        let without_values = self.model.without_values(Status::ModelRejected);
        let mut rejected = NoiseFit { lacks_free_band: self.lacks_free_band, ..without_values };
        // a filter may be why
        let ceiling = self.white_ceiling(MOST_COSINES as f64, 1.0 - confidence);
        if let Some(white) = &mut rejected.parameters[Term::White as usize]
            && ceiling.is_finite()
        {
            *white = self
                .amplitude(Term::White, Found { value: 0.0, lower: 0.0, upper: ceiling, evidence: 0.0, rival: None });
        }
        rejected
    }

    /// `None` if N lies above what the curve itself leaves.
    fn parameters(&self, confidence: f64) -> Option<NoiseFit> {
        let (model, search) = (self.model, &self.search);
        let best = search.best();
        let mut fit = model.without_values(Status::NotObservable);
        fit.lacks_free_band = self.lacks_free_band;
        fit.parameters[Term::White as usize] = Some(self.white_parameter(confidence)?);
        let slow = [(Term::BiasInstability, FLICKER), (Term::RateRandomWalk, WALK)];
        let quantization = model.layout.quantization.map(|column| (Term::Quantization, column));
        for (term, column) in slow.into_iter().chain(quantization) {
            let found = self.slow(term, column);
            fit.rivals[term as usize] = found.rival;
            fit.parameters[term as usize] = Some(self.amplitude(term, found));
        }
        if search.has_ramp {
            let (parameter, rival) = self.ramp();
            fit.parameters[Term::RateRamp as usize] = Some(parameter);
            fit.rivals[Term::RateRamp as usize] = rival;
        }
        fit.is_process_proved = best.has_processes && search.rise_by_processes() > PROVED;
        // a B that is estimated stands in the place of processes
        let has_flicker = fit.parameter(Term::BiasInstability).is_some_and(|of| of.value.is_some());
        let likeliest = search.likeliest(false).filter(|_| has_flicker).unwrap_or(best);
        fit.likeliest = self.slow_noise(&likeliest.scored.parameters);
        self.add_filter(&mut fit);
        self.add_curve(&mut fit);
        Some(fit)
    }

    fn slow(&self, term: Term, column: usize) -> Found {
        let search = &self.search;
        let mut found = search.slow(column, column == WALK);
        // without the level nothing distinguishes a walk from a ramp
        if search.has_ramp && search.data.level.is_none() && term != Term::Quantization {
            found.evidence = 0.0;
        }
        if term == Term::BiasInstability && search.rise_by_processes() > PROCESSES_INSTEAD && found.evidence > PRESENT {
            found = Found { evidence: 0.0, rival: Some(Withheld::MayBeProcess), ..found };
        }
        found
    }

    /// `None` if N lies above what the curve itself leaves.
    fn white_parameter(&self, confidence: f64) -> Option<Parameter> {
        let parameter = self.amplitude(Term::White, self.white(confidence)?);
        Some(if self.lacks_free_band { parameter.not_proved() } else { parameter })
    }

    fn white(&self, confidence: f64) -> Option<Found> {
        let search = &self.search;
        let mut white = search.white();
        if white.value <= 0.0 || white.lower <= 0.0 {
            // a filter of any memory may be why short octaves show no white noise
            white.upper = self.white_ceiling(MOST_COSINES as f64, 1.0 - confidence);
            return Some(Found { value: 0.0, lower: 0.0, ..white });
        }
        // heavy tails make the power of all frequencies together less certain
        let beyond = search.z * (self.tails / white.value.powi(2)).sqrt();
        let wider = |end: f64| (end / white.value).ln().abs().hypot(beyond);
        (white.lower, white.upper) =
            (white.value * (-wider(white.lower)).exp(), white.value * wider(white.upper).exp());
        let memory = search.candidates.iter().filter(|of| of.score > search.best().score - 0.5 * search.z * search.z);
        let memory_of = |of: &Candidate| FILTERS[of.filter].lags() as f64;
        let memory = memory.map(memory_of).fold(0.0, f64::max);
        if white.lower > self.white_ceiling(memory, 0.01) {
            return None;
        }
        // so rarely wrong that the interval keeps its level
        let ceiling = self.white_ceiling(memory, 0.2 * (1.0 - confidence));
        white.upper = white.upper.min(ceiling.max(white.lower));
        white.value = white.value.min(white.upper);
        Some(white)
    }

    /// The square that N² is above with the probability `risk` at most: a variance is that of the
    /// white noise and whatever adds, so that its upper end bounds N². The upper ends of all octaves
    /// hold together (Bonferroni), with the degrees of freedom of a random walk, which has fewest.
    /// Behind a filter that averages over `memory` samples an octave of m samples shows 1 - memory/(2m)
    /// of the white noise.
    fn white_ceiling(&self, memory: f64, risk: f64) -> f64 {
        let shortest = (BEYOND_MEMORY * memory).clamp(1.0, BEYOND_ANY_FILTER);
        let octaves = self.search.data.octaves().enumerate();
        let counted =
            octaves.filter(|(_, (of, _))| of.octave.m as f64 >= shortest && of.walk_edf >= LEAST_EDF_OF_BOUND);
        let of = |(place, (of, value)): (usize, (&GridOctave, f64))| {
            let shown = 1.0 - memory / (2.0 * of.octave.m as f64);
            let square = value / (shown * self.search.data.grid.columns(place)[WHITE]);
            // heavy tails make each less certain
            (square, 2.0 / (2.0 / of.walk_edf + self.tails / (square * square)))
        };
        let counted: Vec<(f64, f64)> = counted.map(of).collect();
        let each = risk / counted.len() as f64;
        let bound = |(value, edf): &(f64, f64)| Some(value * edf / chi_squared::quantile(each, *edf)?);
        counted.iter().filter_map(bound).fold(f64::INFINITY, f64::min)
    }

    /// The amplitude of a term from what is known of its square.
    fn amplitude(&self, term: Term, found: Found) -> Parameter {
        let of = |square: f64| (square * self.search.data.scale).sqrt();
        if !(found.upper > 0.0 && found.upper < NO_BOUND) {
            return Parameter::without_value(Status::NotObservable);
        }
        // N is there where its interval excludes zero, at any level
        let is_there = if term == Term::White { found.lower > 0.0 } else { found.evidence > PRESENT };
        let parameter = match is_there {
            true => Parameter::estimated(of(found.value), of(found.lower), of(found.upper)),
            false => Parameter::bounded(of(found.upper)),
        };
        let p = (term != Term::White).then(|| chi_squared::normal_above(found.evidence));
        Parameter { p, ..parameter }.scaled(term.per_second(self.model.shape.interval_s))
    }

    fn ramp(&self) -> (Parameter, Option<Withheld>) {
        let (data, interval_s) = (self.search.data, self.model.shape.interval_s);
        let Some((level, found)) = data.level.as_ref().zip(self.search.slope()) else {
            return (Parameter::without_value(Status::NotObservable), None);
        };
        let per_block = data.scale.sqrt() / (level.block_samples as f64 * interval_s);
        let parameter = match found.evidence > RAMP_PRESENT {
            true => Parameter::estimated(found.value, found.lower, found.upper),
            false => Parameter::bounded(found.lower.abs().max(found.upper.abs())),
        };
        let p = Some(2.0 * chi_squared::normal_above(found.evidence));
        (Parameter { p, ..parameter }.scaled(per_block), found.rival)
    }

    fn slow_noise(&self, parameters: &[f64]) -> SlowNoise {
        let interval_s = self.model.shape.interval_s;
        let amplitude = |term: Term, column: usize| {
            (parameters[column] * self.search.data.scale).sqrt() * term.per_second(interval_s)
        };
        let process = |column: usize| {
            let time = self.model.layout.components[column].process_time()?;
            let variance = parameters[column] * self.search.data.scale * variance_of_process(time);
            let process = GaussMarkovProcess { correlation_time_s: time * interval_s, sigma: variance.sqrt() };
            (variance > 0.0).then_some(process)
        };
        SlowNoise {
            bias_instability: amplitude(Term::BiasInstability, FLICKER),
            rate_random_walk: amplitude(Term::RateRandomWalk, WALK),
            processes: self.model.layout.processes.clone().filter_map(process).collect(),
        }
    }

    fn add_filter(&self, fit: &mut NoiseFit) {
        let (search, best) = (&self.search, self.search.best());
        let score = |is_meant: bool| {
            let meant = search.candidates.iter().filter(|of| (of.filter == 0) == is_meant);
            meant.map(|of| of.score).fold(f64::NEG_INFINITY, f64::max)
        };
        let is_proved = score(false) - score(true) > PROVED;
        if is_proved && best.filter > 0 {
            let cosines: f64 = best.scored.parameters[self.model.layout.cosines.clone()].iter().sum();
            let white = best.scored.parameters[WHITE];
            let correlation_samples = white / (white + cosines).max(1e-3 * white);
            fit.correlation_samples = (correlation_samples > 1.0).then_some(correlation_samples);
        }
        let interval_s = self.model.shape.interval_s;
        let (chi2, dof) = (search.chi2, search.dof);
        let longest =
            search.data.octaves().filter(|(of, _)| of.walk_edf >= LEAST_EDF).map(|(of, _)| of.octave.m).last();
        fit.quality = chi_squared::probability_above(chi2, dof as f64).map(|p| FitQuality {
            tau_min_s: interval_s,
            tau_max_s: interval_s * longest.unwrap_or(1) as f64,
            chi2,
            dof,
            p,
        });
    }

    /// What the likeliest structure expects of each octave, and the degrees of freedom of each in
    /// its mixture of noises.
    fn add_curve(&self, fit: &mut NoiseFit) {
        let (data, best) = (self.search.data, self.search.best());
        let components = &self.model.layout.components;
        let ramp = best.scored.multiples.first().zip(data.level.as_ref()).filter(|_| self.search.has_ramp);
        let ramp = ramp.map_or(0.0, |(multiple, level)| (multiple / level.block_samples as f64).powi(2));
        for (place, (of, _)) in data.octaves().enumerate() {
            let parameters = &best.scored.parameters;
            let (of_components, lines) = parameters.split_at(components.len());
            let m = of.octave.m as f64;
            let ramp = match self.model.shape.deviation {
                Deviation::Allan => ramp * m * m / 2.0,
                Deviation::Hadamard => 0.0,
            };
            let columns = data.grid.columns(place).iter().zip(of_components);
            let shown =
                columns.map(|(column, parameter)| column * parameter).sum::<f64>() + data.lines_of(place, lines) + ramp;
            if of.walk_edf >= LEAST_EDF {
                fit.expected.push((of.octave.m, shown * data.scale));
            }
            let mixed = data.grid.mixed_edf(place, of_components);
            fit.edf.extend(mixed.map(|edf| (of.octave.m, edf)));
        }
    }
}
