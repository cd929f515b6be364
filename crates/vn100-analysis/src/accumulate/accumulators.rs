//! The sums of all channels, and what is watched beside them row by row.

use std::sync::Arc;

use imu_noise::{RecordShape, SpectrumPlan};
use vn100_protocol::{Layout, PrintFormat};

use super::{channel_state::ChannelState, recent::Recent, repeats::Repeats, vector_norm::Norm};
use crate::{settings::Settings, snapshot::ChannelSnapshot, warning::advice::Findings};

/// Rows of at least so many channels never repeat while a sensor works; a few coarse channels do by
/// chance.
const MIN_CHANNELS_OF_REPEATS: usize = 9;

/// Accumulates rows into channels.
#[derive(Debug)]
pub(crate) struct Accumulators {
    layout: Option<Arc<Layout>>,
    channels: Vec<ChannelState>,
    norms: Vec<Norm>,
    /// Only if asked for.
    recent: Option<Recent>,
    /// Samples of one channel, for reuse.
    column: Vec<i32>,
    repeats: Repeats,
    printed: Option<PrintFormat>,
    coarsest: PrintFormat,
    print_changes: u64,
}

impl Accumulators {
    /// No channels yet.
    pub(crate) fn new() -> Self {
        Self {
            layout: None,
            channels: Vec::new(),
            norms: Vec::new(),
            recent: None,
            column: Vec::new(),
            repeats: Repeats::default(),
            printed: None,
            coarsest: PrintFormat::Current,
            print_changes: 0,
        }
    }

    /// Begins the channels of this message, or begins them anew.
    pub(crate) fn begin(&mut self, layout: Arc<Layout>, settings: &Settings) {
        let plan = SpectrumPlan::new();
        self.channels = layout.channels.iter().map(|channel| ChannelState::new(channel, settings, &plan)).collect();
        self.norms = Norm::all(&layout);
        self.repeats = Repeats::default();
        self.layout = Some(layout);
    }

    pub(crate) const fn layout(&self) -> Option<&Arc<Layout>> {
        self.layout.as_ref()
    }

    /// Counts per row; 0 without a layout, and then there are no rows.
    pub(crate) fn width(&self) -> usize {
        self.channels.len()
    }

    /// Adds frame-major rows, the first of them with this absolute index, without a gap between
    /// them.
    pub(crate) fn push(&mut self, counts: &[i32], first_index: u64, rate_hz: f64, keep_recent: bool) {
        let width = self.width();
        if keep_recent && self.recent.as_ref().is_none_or(|recent| recent.rate_hz() != rate_hz) {
            self.recent = Some(Recent::new(width, rate_hz));
        }
        if width >= MIN_CHANNELS_OF_REPEATS {
            counts.chunks_exact(width).for_each(|row| self.repeats.push(row));
        }
        for (index, channel) in self.channels.iter_mut().enumerate() {
            self.column.clear();
            self.column.extend(counts.chunks_exact(width).map(|row| row[index]));
            channel.push(&mut self.column);
            if let Some(recent) = &mut self.recent {
                recent.push(index, first_index, &self.column);
            }
        }
        for norm in &mut self.norms {
            norm.push(counts, width, &mut self.column);
        }
    }

    /// Samples are missing here; `None` for an unknown number.
    pub(crate) fn gap(&mut self, missing: Option<u64>) {
        self.channels.iter_mut().for_each(|channel| channel.gap(missing));
    }

    /// Takes how the sensor prints from here on; whether that changed. Values of another resolution
    /// are not comparable at the level of the last digit.
    pub(crate) fn set_print_format(&mut self, format: PrintFormat) -> bool {
        if format != PrintFormat::Current {
            self.coarsest = format;
        }
        let has_changed = self.printed.replace(format).is_some();
        self.print_changes += u64::from(has_changed);
        has_changed
    }

    pub(crate) fn forget_recent(&mut self) {
        self.recent = None;
    }

    /// The channels, with octaves of this shape.
    pub(crate) fn snapshot(&self, shape: &RecordShape) -> Vec<ChannelSnapshot> {
        self.states().map(|(state, channel)| state.snapshot(self.coarsest.decimals(channel), shape)).collect()
    }

    pub(crate) fn norms(&self) -> Vec<Norm> {
        self.norms.clone()
    }

    /// The last minutes, if they are at this rate.
    pub(crate) fn recent(&self, rate_hz: f64) -> Option<Recent> {
        self.recent.as_ref().filter(|recent| recent.rate_hz() == rate_hz).cloned()
    }

    pub(crate) fn findings(&self) -> Findings {
        let restarted = self.states().filter(|(state, _)| state.has_restarted());
        Findings {
            repeated_lines: self.repeats.repeated(),
            print_changes: self.print_changes,
            restarted: restarted.map(|(_, channel)| channel.name.to_string()).collect(),
        }
    }

    fn states(&self) -> impl Iterator<Item = (&ChannelState, &vn100_protocol::Channel)> {
        self.channels.iter().zip(self.layout.iter().flat_map(|layout| layout.channels.iter()))
    }
}
