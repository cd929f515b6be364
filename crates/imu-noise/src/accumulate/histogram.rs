//! Frequencies of the values of one channel.

use schemars::JsonSchema;
use serde::Serialize;

/// The most bins of a histogram.
pub const MAX_BINS: usize = 16_384;

/// Fewest places allocated, so that the first samples do not reallocate them often.
const MIN_PLACES: usize = 64;

/// Exact frequencies of the counts of one channel, in at most [`MAX_BINS`] bins.
///
/// The bin width is the smallest power of two, in counts, for which all samples are in at most
/// [`MAX_BINS`] bins; bins are aligned at 0 (bin b holds b·width <= count < (b+1)·width). So the
/// histogram depends only on the samples, not on their order or division. At most 128 KiB.
///
/// ```
/// use imu_noise::Histogram;
///
/// let mut histogram = Histogram::new();
/// histogram.push(&[3, -1, 3]);
/// assert_eq!(histogram.bins().collect::<Vec<_>>(), [(-1, 1), (3, 2)]);
/// assert_eq!((histogram.bin_width_counts(), histogram.total()), (1, 3));
/// ```
#[derive(Clone, Debug, Default)]
pub struct Histogram {
    /// Binary logarithm of the bin width.
    width_log2: u32,
    first: i64,
    /// Frequencies; places outside the span of the samples hold 0.
    places: Vec<u64>,
}

/// A histogram in bins of one width.
#[derive(Clone, Debug, PartialEq, JsonSchema, Serialize)]
pub struct HistogramBars {
    /// Lower end of the first bin.
    pub first: f64,
    /// Width of every bin.
    pub width: f64,
    /// Samples in each bin.
    pub counts: Vec<u64>,
}

impl Histogram {
    /// A histogram without samples: no bins.
    pub const fn new() -> Self {
        Self { width_log2: 0, first: 0, places: Vec::new() }
    }

    /// Adds samples.
    pub fn push(&mut self, counts: &[i32]) {
        for &count in counts {
            let place = (i64::from(count) >> self.width_log2).wrapping_sub(self.first) as usize;
            match self.places.get_mut(place) {
                Some(frequency) => *frequency += 1,
                None => self.push_outside(count),
            }
        }
    }

    /// Width of every bin in counts, a power of two; 1 without samples.
    pub const fn bin_width_counts(&self) -> u64 {
        1 << self.width_log2
    }

    /// Number of samples.
    pub fn total(&self) -> u64 {
        self.bins().map(|(_, frequency)| frequency).sum()
    }

    /// The bins that have samples, in ascending order: lowest count of the bin, and number of samples.
    pub fn bins(&self) -> impl Iterator<Item = (i64, u64)> {
        let bins = (self.first..).zip(&self.places).filter(|(_, frequency)| **frequency > 0);
        bins.map(|(bin, frequency)| (bin << self.width_log2, *frequency))
    }

    /// The actual step between neighbouring values in counts, which need not be an integer: the even
    /// distance of values, or of clusters of them, each so frequent that one between them would have
    /// occurred as well; beside a single value of this kind the least distance of any two. `None` below
    /// two bins, where the printed digit may be the step, and if the samples are too few, or too far
    /// apart, to show a step.
    pub fn step_counts(&self) -> Option<f64> {
        self.values().map(|(_, step)| step)
    }

    /// The first value of the core, and the step from value to value.
    fn values(&self) -> Option<(f64, f64)> {
        /// Samples of every value in the core: a value as frequent is absent with probability e^-8.
        const LEAST: u64 = 8;
        /// Divisor of the frequency of the most frequent value: 2.35 standard deviations from the
        /// middle of normal noise.
        const CORE: u64 = 16;
        /// The largest difference in bins between steps that rounding and rotated axes scatter.
        const EVEN: f64 = 1.25;
        /// The least fraction of the samples in the core: normal noise has 0.98 there.
        const MOST: f64 = 0.75;
        let width = self.bin_width_counts() as i64;
        let frequent = |least: u64| self.bins().filter(|(_, frequency)| *frequency >= least).collect::<Vec<_>>();
        let mut core = frequent(LEAST.max(self.bins().map(|(_, frequency)| frequency).max()? / CORE));
        // if a step is wider than the noise, its core is one or two values
        if core.len() < 3 {
            core = frequent(LEAST);
        }
        let samples = |bins: &[(i64, u64)]| bins.iter().map(|(_, frequency)| frequency).sum::<u64>() as f64;
        // of fine values few are so frequent by chance, and most are beside them
        if samples(&core) < MOST * self.total() as f64 {
            return None;
        }
        // beside one value any other is a step away at least
        if core.len() == 1 && width == 1 {
            let step = Some(self.spacing_counts()).filter(|step| step.is_finite() && *step >= 2.0);
            return step.map(|step| (core[0].0 as f64, step));
        }
        let centre = |cluster: &[(i64, u64)]| {
            let sum: f64 = cluster.iter().map(|(count, frequency)| *count as f64 * *frequency as f64).sum();
            sum / samples(cluster) + (width - 1) as f64 / 2.0
        };
        let clusters = || core.chunk_by(|a, b| b.0 - a.0 == width);
        let centres: Vec<f64> = clusters().map(centre).collect();
        let (first, last) = (centres.first()?, centres.last()?);
        let steps = centres.len() - 1;
        let step = (last - first) / steps as f64;
        let widest = (clusters().map(<[_]>::len).max()? as i64 * width) as f64;
        let is_even = centres.windows(2).all(|pair| (pair[1] - pair[0] - step).abs() <= EVEN * width as f64);
        // two clusters that are wider than rounding scatters may be noise at two levels
        let most_wide = if steps == 1 { (2 * width) as f64 } else { step / 2.0 };
        let is_apart = steps >= 1 && step >= (2 * width) as f64 && widest <= most_wide;
        (is_apart && is_even).then_some((*first, step))
    }

    /// Mean distance of the values that occur in the middle half of the samples: the step of the
    /// channel, or more if there are few samples far apart; infinite if they have one value.
    pub(crate) fn spacing_counts(&self) -> f64 {
        let quarter = self.total() as f64 / 4.0;
        let mut before = 0.0;
        let middle = self.bins().filter(|&(_, frequency)| {
            let reaches = before + frequency as f64 > quarter && before < 3.0 * quarter;
            before += frequency as f64;
            reaches
        });
        let occupied: Vec<i64> = middle.map(|(lowest, _)| lowest).collect();
        match (occupied.first(), occupied.last()) {
            (Some(first), Some(last)) if first < last => (last - first) as f64 / (occupied.len() - 1) as f64,
            // more than half of the samples have one value: the least distance of any two
            _ => {
                let all: Vec<i64> = self.bins().map(|(lowest, _)| lowest).collect();
                all.windows(2).map(|pair| (pair[1] - pair[0]) as f64).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// The histogram in at most `most` bars for a drawing, including empty ones between others: the
    /// narrowest possible bars, each with the same number of actual steps, 1, 2, 4, ... Edges and
    /// width are in counts: the first bar begins half a step below the lowest value in it. `None`
    /// without samples, and if `most` is 0.
    pub fn bars(&self, most: usize) -> Option<HistogramBars> {
        let (lowest, highest) = (self.bins().next()?.0, self.bins().last()?.0);
        let values = self.values();
        let (origin, step) = values.unwrap_or((0.0, self.bin_width_counts() as f64));
        let number = |count: i64| ((count as f64 - origin) / step).round() as i64;
        let bars = |joined_log2: u32| ((number(highest) >> joined_log2) - (number(lowest) >> joined_log2) + 1) as usize;
        // two bars remain if the values lie on both sides of the origin
        let joined_log2 = (0..i64::BITS).find(|joined_log2| bars(*joined_log2) <= most)?;
        let first = number(lowest) >> joined_log2;
        let mut counts = vec![0; bars(joined_log2)];
        for (lower, frequency) in self.bins() {
            counts[((number(lower) >> joined_log2) - first) as usize] += frequency;
        }
        // a bin of several counts begins at the lowest of them
        let half = values.map_or(0.5, |(_, step)| step / 2.0);
        Some(HistogramBars {
            first: origin + (first << joined_log2) as f64 * step - half,
            width: (1_u64 << joined_log2) as f64 * step,
            counts,
        })
    }

    #[cold]
    #[inline(never)]
    fn push_outside(&mut self, count: i32) {
        let occupied: Vec<_> = self.bins().chain([(count.into(), 1)]).collect();
        let lowest = occupied.iter().map(|(lower, _)| *lower).min();
        let highest = occupied.iter().map(|(lower, _)| *lower).max();
        let Some((lowest, highest)) = lowest.zip(highest) else { return };
        let span = |width_log2: u32| ((highest >> width_log2) - (lowest >> width_log2) + 1) as usize;
        while span(self.width_log2) > MAX_BINS {
            self.width_log2 += 1;
        }
        let span = span(self.width_log2);
        // Free places on both sides: a slowly growing span moves the frequencies a few times, not each time.
        let len = (2 * span).clamp(MIN_PLACES, MAX_BINS);
        self.first = (lowest >> self.width_log2) - ((len - span) / 2) as i64;
        self.places = vec![0; len];
        for (lower, frequency) in occupied {
            self.places[((lower >> self.width_log2) - self.first) as usize] += frequency;
        }
    }
}

impl PartialEq for Histogram {
    /// The number of free places is not compared.
    fn eq(&self, other: &Self) -> bool {
        self.width_log2 == other.width_log2 && self.bins().eq(other.bins())
    }
}

impl Eq for Histogram {}
