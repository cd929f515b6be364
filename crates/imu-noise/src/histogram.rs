//! How often each value came, in a bounded number of bins.

/// Most bins a histogram has.
pub const MAX_BINS: usize = 16_384;

/// Fewest places allocated, so that the first samples do not move them again and again.
const MIN_PLACES: usize = 64;

/// Exact frequencies of the counts of one channel, in at most [`MAX_BINS`] bins.
///
/// The bin width is the smallest power of two of counts with which the span from the smallest to the largest bin is
/// within [`MAX_BINS`]; bins are aligned at 0 (bin b holds b·width <= count < (b+1)·width). So the histogram depends on
/// the samples only, not on their order or division. At most 128 KiB.
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
    /// Bin number of the first place.
    first: i64,
    /// Frequencies; places outside the span of the samples hold 0.
    places: Vec<u64>,
}

impl Histogram {
    /// A histogram without samples: no bins.
    #[must_use]
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

    /// Width of every bin in counts, a power of two.
    #[must_use]
    pub const fn bin_width_counts(&self) -> u64 {
        1 << self.width_log2
    }

    /// Number of samples.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.places.iter().sum()
    }

    /// The bins that have samples, in rising order: lowest count of the bin, and number of samples.
    pub fn bins(&self) -> impl Iterator<Item = (i64, u64)> {
        let occupied = self.places.iter().enumerate().filter(|&(_, &frequency)| frequency > 0);
        occupied.map(|(place, &frequency)| ((self.first + place as i64) << self.width_log2, frequency))
    }

    /// Makes room for a count outside the places, coarser if need be, and adds it.
    #[cold]
    #[inline(never)]
    fn push_outside(&mut self, count: i32) {
        let occupied: Vec<_> = self.bins().collect();
        let count = i64::from(count);
        let lowest = occupied.first().map_or(count, |&(lower, _)| lower.min(count));
        let highest = occupied.last().map_or(count, |&(lower, _)| lower.max(count));
        let span = |width_log2: u32| ((highest >> width_log2) - (lowest >> width_log2) + 1) as usize;
        while span(self.width_log2) > MAX_BINS {
            self.width_log2 += 1;
        }
        let span = span(self.width_log2);
        // Free places on both sides: a slowly growing span moves the frequencies a few times, not each time.
        let len = (2 * span).clamp(MIN_PLACES, MAX_BINS);
        self.first = (lowest >> self.width_log2) - ((len - span) / 2) as i64;
        self.places = vec![0; len];
        for (lower, frequency) in occupied.into_iter().chain([(count, 1)]) {
            self.places[((lower >> self.width_log2) - self.first) as usize] += frequency;
        }
    }
}

impl PartialEq for Histogram {
    /// Equal bins; how many places are kept free is no part of it.
    fn eq(&self, other: &Self) -> bool {
        self.width_log2 == other.width_log2 && self.bins().eq(other.bins())
    }
}

impl Eq for Histogram {}
