//! How the reads of the host fall among the samples: how many samples a read returns, and at which
//! phases of the period.

/// Samples closer together than this many periods were returned by one read. Chosen: above the
/// jitter within a read, below half a period.
pub(super) const TOGETHER_PERIODS: f64 = 0.2;

/// Twice the longest usual bunching (USB adapters collect for 16 ms, slow readers up to 50 ms).
pub(super) const BUNCHING_S: f64 = 0.1;

/// The fraction of reads with several samples above which a stream is bunched. Chosen: rare stalls
/// of the host remain below it.
const BUNCHED_SHARE: f64 = 0.05;

/// The fraction above which the phase may jump: a reader at a steady pace near a multiple of the
/// period returns several samples in nearly each read. A reader that takes each sample as it
/// arrives, and stalls at times, remains below it.
const JUMPY_SHARE: f64 = 0.5;

/// The number of reads over which these fractions are averaged. Chosen.
const AVERAGED_READS: f64 = 64.0;

/// The number of reads in a group whose phases are examined together: as many as there are
/// sixteenths.
const GROUP_READS: u32 = 16;

/// The longest run of sixteenths of a period without a read in a group that counts as mixed: of
/// sixteen random phases fewer than 1 % have a longer run.
const MIXED_EMPTY: u32 = 5;

/// Reads of a stream, separated by the times between samples.
///
/// A read returns all samples that have arrived, so that the last of them is less than a period
/// late: that lateness is the phase of the read. If the time between reads is close to a multiple
/// of the period, the phase drifts and then jumps by a whole period, which looks like a dropped
/// sample; phases that are spread over the whole period cannot jump.
#[derive(Clone, Debug, Default)]
pub(super) struct ReadPattern {
    together_s: f64,
    /// The longest time that a group of reads may take to define the window.
    max_window_s: f64,
    sixteenths_per_s: f64,
    previous_s: f64,
    samples: u64,
    bunched_share: f64,
    /// The number of reads over which `bunched_share` is averaged.
    averaged_reads: f64,
    /// Reads of the present group, its start, and the sixteenths of the period in which they ended.
    group_reads: u32,
    group_start_s: f64,
    phases: u16,
    is_mixed: bool,
    /// Within this time some sample arrives as early as any: the duration of a group of reads in a
    /// bunched stream.
    pub(super) window_s: f64,
}

impl ReadPattern {
    pub(super) fn new(period_s: f64) -> Self {
        Self {
            together_s: TOGETHER_PERIODS * period_s,
            max_window_s: BUNCHING_S.max(f64::from(GROUP_READS) * period_s.max(BUNCHING_S)),
            sixteenths_per_s: 16.0 / period_s,
            previous_s: f64::NEG_INFINITY,
            window_s: BUNCHING_S,
            ..Self::default()
        }
    }

    pub(super) fn push(&mut self, at_s: f64) {
        if self.are_apart(self.previous_s, at_s) {
            self.end_read();
        }
        self.samples += 1;
        self.previous_s = at_s;
    }

    /// Whether two neighbouring samples were returned by two reads.
    pub(super) fn are_apart(&self, earlier_s: f64, later_s: f64) -> bool {
        later_s - earlier_s >= self.together_s
    }

    /// Whether most reads return several samples, and end near one phase.
    pub(super) fn may_jump(&self) -> bool {
        self.bunched_share > JUMPY_SHARE && !self.is_mixed
    }

    fn end_read(&mut self) {
        if self.samples == 0 {
            return;
        }
        let several = if self.samples > 1 { 1.0 } else { 0.0 };
        self.averaged_reads = f64::min(self.averaged_reads + 1.0, AVERAGED_READS);
        self.bunched_share += (several - self.bunched_share) / self.averaged_reads;
        self.samples = 0;
        let sixteenths = (self.previous_s * self.sixteenths_per_s) as u64;
        self.phases |= 1 << (sixteenths % 16);
        self.group_reads += 1;
        if self.group_reads == GROUP_READS {
            self.end_group();
        }
    }

    fn end_group(&mut self) {
        let empty_runs = (0..16).map(|turn| self.phases.rotate_right(turn).trailing_zeros());
        self.is_mixed = empty_runs.max().is_some_and(|run| run <= MIXED_EMPTY);
        let span_s = self.previous_s - self.group_start_s;
        let is_bunched = self.bunched_share > BUNCHED_SHARE;
        self.window_s = if is_bunched { span_s.clamp(BUNCHING_S, self.max_window_s) } else { BUNCHING_S };
        self.group_reads = 0;
        self.group_start_s = self.previous_s;
        self.phases = 0;
    }
}
