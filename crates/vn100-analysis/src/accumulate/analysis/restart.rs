//! A measurement whose beginning is given up on the way: a warm-up that is over, or everything.

use std::time::Duration;

use super::Analysis;
use crate::accumulate::repeats::Repeats;

impl Analysis {
    /// Leaves out everything that came so far, as warm-up, and gives the data time that is: the
    /// results are those of a measurement whose [`skip`](crate::Settings::skip) was that time from
    /// the start.
    pub fn end_warm_up(&mut self) -> Duration {
        let so_far = self.data_time();
        self.warm_up = Some(so_far);
        self.forget();
        so_far
    }

    /// Begins anew: data time, and what was asked for in it, counts from here. What the link
    /// carried still counts, and the samples so far are among those left out. Gives the data time
    /// that has passed.
    pub fn start_over(&mut self) -> Duration {
        let so_far = self.data_time();
        self.forget();
        (self.index, self.bad_lines_pending) = (0, 0);
        (self.rate_change, self.arrivals_until) = (None, None);
        self.false_rate = None;
        (self.warm_up, self.recent) = (None, None);
        so_far
    }
}

impl Analysis {
    /// The data time left out at the beginning.
    pub(super) fn skipped(&self) -> Duration {
        self.warm_up.unwrap_or(self.settings.skip)
    }

    pub(super) fn data_time(&self) -> Duration {
        Duration::try_from_secs_f64(self.index as f64 / self.timing.rate_hz).unwrap_or(Duration::MAX)
    }

    /// The samples so far are left out.
    pub(super) fn forget(&mut self) {
        let timing = &mut self.timing;
        timing.left_out += timing.samples;
        (timing.samples, timing.missing, timing.gaps, timing.segments) = (0, 0, 0, 0);
        self.missing_by_bad_lines = 0;
        self.in_segment = false;
        self.repeats = Repeats::default();
        if let Some(layout) = self.layout.take() {
            self.begin(layout);
        }
    }
}
