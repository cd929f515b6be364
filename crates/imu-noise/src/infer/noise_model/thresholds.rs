//! All thresholds of the fit, with the reason of each.
//!
//! Penalties and distances are of the log-likelihood; the benchmark `cells` is the sheet that they
//! were chosen by.

/// A term is there if the log-likelihood falls by more than half the square of this without it:
/// noise without the term shows as much in 2.5 % of records.
pub(super) const PRESENT: f64 = 1.96;

/// A ramp is there beyond so many: few coefficients of a walk look like one, as Student's t has it.
pub(super) const RAMP_PRESENT: f64 = 2.25;

/// More for any filter where the averaging on board is known: one beside it must be seen.
pub(super) const BESIDE_KNOWN_AVERAGING: f64 = 5.0;

/// More for any filter and for processes in the value of N, so that its error in white noise exceeds
/// that of the best estimate by less than 5 %.
pub(super) const FILTER_IN_VALUE: f64 = 4.0;
pub(super) const PROCESSES_IN_VALUE: f64 = 4.0;

/// For Gauss-Markov processes: one and its correlation time are two parameters.
pub(super) const PROCESSES: f64 = 3.0;

/// For a warm-up, which has an amplitude and a time constant, and for a cycle, which has a phase too:
/// in noise alone the likeliest of all of them raises the log-likelihood by as much.
pub(super) const RELAXATION: f64 = 3.0;
pub(super) const CYCLE: f64 = 5.0;

/// More parameters of two levels between which the noise switches than of one term. Each costs half the
/// logarithm of the number of blocks (Schwarz, 1978): with less, flicker noise would look like it.
pub(super) const SWITCHING_PARAMETERS: f64 = 4.0;

/// Less for a warm-up or a cycle in place of a ramp: a warm-up as slow as the record has as many parameters as
/// a line, but for its bend.
pub(super) const BENT_LINE: f64 = 1.0;

/// A shape by which the log-likelihood rises so much is there, whatever the noise.
pub(super) const DEFINITE: f64 = 15.0;
pub(super) const MOST_DEFINITE: usize = 3;

/// A shape of the level with a rise of the log-likelihood below this is not examined further.
pub(super) const LEAST_RISE: f64 = 2.0;

/// A filter is there, and so are processes, if the log-likelihood rises by so much with them: a
/// record of white noise shows that in fewer than 1 of 1000.
pub(super) const PROVED: f64 = 10.0;

/// Rows of the density deviate from the fitted one by so many standard deviations of their
/// sum of squares until the intervals are widened by it.
pub(super) const OVERDISPERSED: f64 = 3.0;

/// Beyond this ratio of the squared deviations to the expected ones no model is believed.
pub(super) const REJECTED: f64 = 6.0;

/// Octaves with fewer degrees of freedom in a random walk have no part: two that share all samples
/// show next to nothing.
pub(super) const LEAST_EDF: f64 = 2.0;

/// Least share of an octave that is not in the segments: the rest of others is not worth the error of
/// the difference.
pub(super) const LEAST_REST: f64 = 0.1;

/// A short filter before the record is known: the autocovariance at a lag is normal about zero, its
/// standard deviation a part of the mean density that falls exponentially with the lag.
///
/// No autocovariance exceeds the variance, so that 1 is the largest part a lag may need. The small
/// ones are for filters that the record hardly shows, as wide a prior would hide them (Lindley,
/// 1957). The longest filter has ten times as much: all lags of a long window are positive, and a
/// prior about zero would pull each towards zero, and N, which is their sum, far below the truth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Filter {
    pub(super) part: f64,
    /// In samples; 0 without a filter.
    pub(super) memory: f64,
}

impl Filter {
    /// Lags in use, in memories.
    const LAGS: f64 = 6.0;

    pub(super) const fn lags(self) -> usize {
        let lags = (Self::LAGS * self.memory) as usize;
        if lags < MOST_COSINES { lags } else { MOST_COSINES }
    }

    /// Of each cosine, which is twice the autocovariance.
    pub(super) fn variances(self, mean_density: f64) -> Vec<f64> {
        let of = |lag: usize| 2.0 * self.part * mean_density * (-(lag as f64 - 1.0) / self.memory).exp();
        (1..=self.lags()).map(|lag| of(lag).powi(2)).collect()
    }
}

/// The filters that are possible; each is as likely as any other, and all together as likely as none.
pub(super) const FILTERS: [Filter; 9] = [
    Filter { part: 0.0, memory: 0.0 },
    Filter { part: 0.1, memory: 1.0 },
    Filter { part: 1.0, memory: 1.0 },
    Filter { part: 0.1, memory: 2.0 },
    Filter { part: 1.0, memory: 2.0 },
    Filter { part: 1.0, memory: 4.0 },
    Filter { part: 1.0, memory: 10.0 },
    Filter { part: 10.0, memory: 20.0 },
    // Gauss-Markov processes of a few samples, without cosines
    Filter { part: 0.0, memory: 0.0 },
];
pub(super) const AS_FILTER: usize = FILTERS.len() - 1;

pub(super) const MOST_COSINES: usize = 40;

/// From the correlation time of one Gauss-Markov process to that of the next.
pub(super) const PROCESSES_APART: f64 = 4.0;

/// Processes of fewer samples than this stand in the place of a short filter ([`AS_FILTER`]), with the times
/// below: with fewer of them N is wrong by more than its interval says. They are there only if the white
/// noise beside them is more than what a filter stops: a low pass of the first order is such a process with
/// nothing beside it.
pub(super) const LIKE_A_FILTER: f64 = 10.0;
pub(super) const SHORT_PROCESSES: [f64; 3] = [8.0, 4.5, 2.5];

/// Of the record: longer processes are a random walk over this record.
pub(super) const LONGEST_PROCESS: f64 = 1.0 / 32.0;

/// Lines with a power of their own in the octaves.
pub(super) const MOST_LINES: usize = 5;

/// Records are planned so long that the expected evidence for a slow term exceeds what is needed by
/// this factor: processes and cycles take a part of it (the benchmark `cells`, plans).
pub(super) const PLANNED_BIAS: f64 = 1.15;
pub(super) const PLANNED_WALK: f64 = 1.4;

/// Of the density at low frequencies: less is what a filter stops. To follow it a model would have
/// to be as exact as this is small, and it says nothing of N.
pub(super) const STOPPED: f64 = 0.05;

/// By how many memories of a short filter an octave must be longer to bound N.
pub(super) const BEYOND_MEMORY: f64 = 10.0;

/// No filter is looked for that remembers more samples than a part of this.
pub(super) const BEYOND_ANY_FILTER: f64 = 256.0;

/// An octave with fewer degrees of freedom bounds nothing.
pub(super) const LEAST_EDF_OF_BOUND: f64 = 10.0;

/// B is taken for processes where these explain the record better by so much, beyond their penalty.
pub(super) const PROCESSES_INSTEAD: f64 = 2.0;

/// Filters that are worse by so much are not fitted with processes, nor are longer ones fitted, in
/// log-likelihood.
pub(super) const HOPELESS: f64 = 5.0;

/// Structures of a smaller weight are left out.
pub(super) const NEGLIGIBLE: f64 = 1e-3;

/// Processes are longer than the memory of the filter by so much.
pub(super) const BEYOND_FILTER: f64 = 4.0;

/// Of a square: at zero itself the model may lack what keeps the other terms apart.
pub(super) const AS_GOOD_AS_ZERO: f64 = 1e-3;

/// Of the mean density over the band: white noise that is not there becomes smaller with each step of the
/// fit, and never zero.
pub(super) const NO_DENSITY: f64 = 1e-9;

/// A bound of so many times the variance of the first octave, which is a hundred times its deviation, says
/// nothing: the parameter is not observable.
pub(super) const NO_BOUND: f64 = 1e4;

/// The quantiles at which a record is looked at, low and high, of the probability that records may
/// miss: octaves of slow noise are far from independent, and what they show has heavier tails than
/// χ². These and the next two are chosen for the share of simulated records that meet a want (the
/// benchmark `cells`, plans).
pub(super) const OF_MISSED: [f64; 2] = [0.02, 0.6];

/// By how much the half-width of a slow term exceeds the expected one in few records.
pub(super) const WIDER: f64 = 1.15;

/// That of N by this times the root of itself: the shorter a record, the more they differ.
pub(super) const WIDER_WHITE: f64 = 2.0;

/// Lowest point of a segment in use: below, segments have lost their mean.
pub(super) const FIRST: usize = 5;

pub(super) const LEAST_SEGMENTS: u64 = 4;

/// Octaves that show no filter, in samples, and how many degrees of freedom they have at least.
pub(super) const LONGER_THAN_FILTERS: u64 = 64;
pub(super) const LEAST_EDF_OF_FLOOR: f64 = 10.0;
