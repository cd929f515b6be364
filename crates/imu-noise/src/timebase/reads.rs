//! How reads fall among the lines: whether they bring several at once, and whether they meet every
//! phase.

use super::arrivals::TOGETHER_PERIODS;

/// Part of the reads that bring several lines from which a stream is bunched.
const BUNCHED_SHARE: f64 = 0.05;

/// The same from which their phase may jump: a reader of a steady pace brings several lines in
/// nearly each read where it lies near a multiple of the period. One that takes each line as it
/// comes, and stalls at times, has no phase.
const JUMPY_SHARE: f64 = 0.5;

/// Reads over which that part is averaged.
const BUNCHED_READS: f64 = 64.0;

/// Reads in a group whose phases are looked at together.
const GROUP_READS: u32 = 16;

/// Least time in which reads are taken to have shown the earliest arrival: twice the longest usual
/// bunching.
const MIN_WINDOW_S: f64 = 0.1;

/// Longest run of empty sixteenths of a period in which reads are mixed.
const MIXED_EMPTY: u32 = 5;

/// Reads of a stream, told apart by the time between lines.
///
/// A read takes all lines there are, so the last one is less than a period late, by a phase. When
/// the time between reads is near a multiple of the period the phase drifts slowly and then jumps
/// by a whole period: that looks like a lost line. When the phases of some reads lie all over the
/// period, they cannot jump by much.
#[derive(Clone, Debug)]
pub(super) struct Reads {
    /// Lines closer than this came in one read.
    together_s: f64,
    /// Longest time a group of reads may take to count as a window.
    max_window_s: f64,
    sixteenths_per_s: f64,
    previous_s: f64,
    /// Lines of the present read.
    lines: u64,
    bunched_share: f64,
    /// Reads it is an average of.
    averaged_reads: f64,
    /// Reads of the present group.
    group_reads: u32,
    group_start_s: f64,
    /// Sixteenths of the period in which a read of the group ended.
    phases: u16,
    mixed: bool,
    window_s: f64,
}

impl Reads {
    pub(super) fn new(period_s: f64) -> Self {
        Self {
            together_s: TOGETHER_PERIODS * period_s,
            max_window_s: MIN_WINDOW_S.max(f64::from(GROUP_READS) * period_s.max(MIN_WINDOW_S)),
            sixteenths_per_s: 16.0 / period_s,
            previous_s: f64::NEG_INFINITY,
            lines: 0,
            bunched_share: 0.0,
            averaged_reads: 0.0,
            group_reads: 0,
            group_start_s: 0.0,
            phases: 0,
            mixed: false,
            window_s: MIN_WINDOW_S,
        }
    }

    /// Adds a line's stamp.
    pub(super) fn push(&mut self, at_s: f64) {
        if self.are_apart(self.previous_s, at_s) {
            self.end_read();
        }
        self.lines += 1;
        self.previous_s = at_s;
    }

    /// Two neighbouring lines came in two reads.
    pub(super) fn are_apart(&self, earlier_s: f64, later_s: f64) -> bool {
        later_s - earlier_s >= self.together_s
    }

    /// The phase of the reads may jump by a period: most bring several lines, and always near the
    /// same phase.
    pub(super) fn may_jump(&self) -> bool {
        self.bunched_share > JUMPY_SHARE && !self.mixed
    }

    /// Time within which some line arrives as early as any.
    pub(super) const fn window_s(&self) -> f64 {
        self.window_s
    }

    fn bunched(&self) -> bool {
        self.bunched_share > BUNCHED_SHARE
    }

    fn end_read(&mut self) {
        if self.lines == 0 {
            return;
        }
        let several = if self.lines > 1 { 1.0 } else { 0.0 };
        self.averaged_reads = f64::min(self.averaged_reads + 1.0, BUNCHED_READS);
        self.bunched_share += (several - self.bunched_share) / self.averaged_reads;
        self.lines = 0;
        let sixteenths = (self.previous_s * self.sixteenths_per_s) as u64;
        self.phases |= 1 << (sixteenths % 16);
        self.group_reads += 1;
        if self.group_reads == GROUP_READS {
            self.end_group();
        }
    }

    fn end_group(&mut self) {
        let empty_runs = (0..16).map(|turn| self.phases.rotate_right(turn).trailing_zeros());
        self.mixed = empty_runs.max().is_some_and(|run| run <= MIXED_EMPTY);
        let span_s = self.previous_s - self.group_start_s;
        self.window_s = if self.bunched() { span_s.clamp(MIN_WINDOW_S, self.max_window_s) } else { MIN_WINDOW_S };
        self.group_reads = 0;
        self.group_start_s = self.previous_s;
        self.phases = 0;
    }
}
