//! How large a statistic of windows usually is, and when it was larger.

/// Bits of the fraction of a float that count: 8 bins an octave.
const FRACTION_BITS: u32 = 3;

/// Stretches kept.
const KEPT: usize = 8;

/// Frequencies of positive numbers in bins of an eighth of an octave, and the stretches where they peaked.
///
/// At most 8 KiB; usually the numbers of a record span fewer than 16 octaves: below 1 KiB.
#[derive(Clone, Debug)]
pub(super) struct Magnitudes {
    /// Bin number of the first place.
    first: u16,
    frequencies: Vec<u32>,
    total: u32,
    current: Option<Stretch>,
    /// Rising peaks.
    highest: Vec<Stretch>,
}

/// Windows in a row whose numbers are at least half of the highest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    pub(super) first_window: u64,
    pub(super) last_window: u64,
    pub(super) peak: f64,
}

impl Magnitudes {
    pub(super) const fn new() -> Self {
        Self { first: 0, frequencies: Vec::new(), total: 0, current: None, highest: Vec::new() }
    }

    /// Adds the number of one window: not negative, and finite.
    pub(super) fn push(&mut self, window: u64, number: f64) {
        self.count(number);
        match &mut self.current {
            Some(stretch) if stretch.last_window + 1 == window && number >= stretch.peak / 2.0 => {
                if stretch.peak < number / 2.0 {
                    stretch.first_window = window;
                }
                stretch.last_window = window;
                stretch.peak = stretch.peak.max(number);
            }
            current => {
                if let Some(ended) =
                    current.replace(Stretch { first_window: window, last_window: window, peak: number })
                {
                    self.keep(ended);
                }
            }
        }
    }

    pub(super) const fn total(&self) -> u32 {
        self.total
    }

    /// The number that the share `p` of all numbers does not exceed, interpolated within its bin; `None` without numbers.
    pub(super) fn quantile(&self, p: f64) -> Option<f64> {
        let mut missing = p * f64::from(self.total);
        for (bin, &frequency) in (self.first..).zip(&self.frequencies) {
            let frequency = f64::from(frequency);
            if frequency > 0.0 && missing <= frequency {
                let (lower, upper) = (lowest_of(bin), lowest_of(bin + 1));
                return Some(lower + (upper - lower) * missing / frequency);
            }
            missing -= frequency;
        }
        None
    }

    /// The stretches with the highest peaks, at most 9.
    pub(super) fn highest(&self) -> impl Iterator<Item = &Stretch> {
        self.highest.iter().chain(&self.current)
    }

    fn count(&mut self, number: f64) {
        let bin = bin_of(number);
        if self.frequencies.is_empty() {
            self.first = bin;
        }
        if bin < self.first {
            let lower = usize::from(self.first - bin);
            self.frequencies.splice(..0, std::iter::repeat_n(0, lower));
            self.first = bin;
        }
        let place = usize::from(bin - self.first);
        if self.frequencies.len() <= place {
            self.frequencies.resize(place + 1, 0);
        }
        self.frequencies[place] = self.frequencies[place].saturating_add(1);
        self.total = self.total.saturating_add(1);
    }

    #[inline]
    fn keep(&mut self, stretch: Stretch) {
        if self.highest.len() == KEPT {
            if stretch.peak <= self.highest[0].peak {
                return;
            }
            self.highest.remove(0);
        }
        let place = self.highest.partition_point(|kept| kept.peak < stretch.peak);
        self.highest.insert(place, stretch);
    }
}

/// Numbers below 1 share the lowest bin: they come from integers, and are 0.
fn bin_of(number: f64) -> u16 {
    let bits = number.max(0.5).to_bits() >> (f64::MANTISSA_DIGITS - 1 - FRACTION_BITS);
    bits as u16
}

fn lowest_of(bin: u16) -> f64 {
    let lowest = f64::from_bits(u64::from(bin) << (f64::MANTISSA_DIGITS - 1 - FRACTION_BITS));
    if lowest < 1.0 { 0.0 } else { lowest }
}
