//! Noise models: N, B, K and a ramp by one likelihood of all that is kept of a record.

mod boxcar;
mod channel_curve;
mod channel_fit;
mod cholesky;
mod crossing;
mod density;
mod noise_fit;
mod parameter;
mod record_length;
mod scoring;
mod search;
mod shapes;
mod spectral_rows;
mod switching;
mod term;
mod thresholds;

use std::sync::{Arc, OnceLock};

use super::confidence::edf;
use super::power_law::PowerLaw;
use crate::accumulate::record::{Octave, RecordShape};
pub use boxcar::{BoxcarWindow, white_deficit};
pub use channel_curve::ChannelCurve;
use density::Component;
pub use noise_fit::{FitQuality, GaussMarkovProcess, NoiseFit, SlowNoise};
pub use parameter::{PROVED_P, Parameter, Status};
pub use record_length::{Aim, Wanted};
pub(super) use scoring::{Rows, Scored, Structure};
use search::Layout;
pub use search::Withheld;
pub(super) use shapes::{MeanShape, MeanShapes};
use spectral_rows::{ChannelData, Grid, GridOctave};
pub use term::Term;
use thresholds::{LIKE_A_FILTER, LONGEST_PROCESS, MOST_COSINES, PROCESSES_APART, SHORT_PROCESSES};

/// A noise model for all channels that were sampled together.
#[derive(Clone, Debug)]
pub struct NoiseModel {
    shape: RecordShape,
    layout: Layout,
    grid: Grid,
    /// Shapes of the mean, of as many blocks as the first channel has.
    shapes: SharedShapes,
}

type SharedShapes = Arc<OnceLock<Arc<MeanShapes>>>;

impl NoiseModel {
    /// A model of white noise, bias instability, random walk and a ramp, and of quantisation if it
    /// `is_quantized`, for `octaves` in ascending order. `window` is the averaging on board, where it is
    /// known and matters: see [`BoxcarWindow`]. It costs a few milliseconds, as do the fits.
    pub fn new(octaves: &[Octave], shape: &RecordShape, window: Option<BoxcarWindow>, is_quantized: bool) -> Self {
        let of = |(place, octave): (usize, &Octave)| {
            let of_law = |law| edf(octave, shape, law);
            Some(GridOctave {
                octave: *octave,
                place,
                white_edf: of_law(PowerLaw::White)?,
                flicker_edf: of_law(PowerLaw::Flicker)?,
                walk_edf: of_law(PowerLaw::RandomWalk)?,
            })
        };
        let octaves = octaves.iter().enumerate().filter_map(of).collect();
        let layout = layout(shape, window, is_quantized);
        Self { shape: *shape, grid: Grid::new(shape, octaves, &layout.components), layout, shapes: Arc::default() }
    }

    /// Of as many blocks as the level of a channel has.
    fn shapes_of(&self, data: &ChannelData<'_>) -> Option<Arc<MeanShapes>> {
        let blocks = data.level.as_ref()?.coefficients.len() + 1;
        let new = || Arc::new(MeanShapes::new(blocks, false));
        let known = self.shapes.get_or_init(new);
        Some(if known.blocks == blocks { Arc::clone(known) } else { new() })
    }
}

/// White noise, flicker noise, a walk, quantisation, processes, and the cosines of a short filter, which
/// nothing else explains: quantisation does.
fn layout(shape: &RecordShape, window: Option<BoxcarWindow>, is_quantized: bool) -> Layout {
    let mut components = vec![Component::white(window), Component::Flicker, Component::Walk];
    let quantization = is_quantized.then_some(components.len());
    components.extend(quantization.map(|_| Component::Quantization));
    let first = components.len();
    let longest = LONGEST_PROCESS * shape.samples as f64;
    let times = core::iter::successors(Some(longest), |time| Some(time / PROCESSES_APART));
    let times = times.take_while(|time| *time >= LIKE_A_FILTER);
    let short = SHORT_PROCESSES.into_iter().filter(|time| *time <= longest);
    components.extend(times.chain(short).map(Component::GaussMarkov));
    let processes = first..components.len();
    let most = if is_quantized { 0 } else { MOST_COSINES };
    components.extend((1..=most).map(Component::Cosine));
    let cosines = processes.end..components.len();
    Layout { components, quantization, processes, cosines }
}
