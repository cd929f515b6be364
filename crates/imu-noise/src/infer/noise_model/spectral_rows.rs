//! The statistics of one channel as powers of one density, each information once: segments of the
//! spectrum above, the cosine coefficients of the level below, and the octaves for all that neither
//! of them holds.
//!
//! Where segments hold a share s of the information above their lowest frequency, an octave less s
//! times what the segments say of it is independent of them: the octave, of all samples, is the
//! efficient estimate, and its covariance with any other one is its own variance.

use std::sync::{Arc, OnceLock};

use super::{
    density::{Component, octave_filter},
    scoring::Rows,
    thresholds::{
        FIRST, LEAST_EDF, LEAST_EDF_OF_FLOOR, LEAST_REST, LEAST_SEGMENTS, LONGER_THAN_FILTERS, MOST_LINES, STOPPED,
    },
};
use crate::accumulate::blocks::{MAX_BLOCKS, WINDOW};
use crate::accumulate::record::{Deviation, Octave, RecordShape};
use crate::accumulate::spectrum::{LONG, Powers, SHORT};
use crate::infer::level_series::{LevelSeries, MIN_BLOCKS};
use crate::infer::narrow_bands::NarrowBand;

/// Points of the spectrum in one row at most.
const MOST_POINTS: usize = 4;

/// Points that the Hann window makes of one independent point: 1 + 2 (4/9 + 1/36).
const DEPENDENCE: f64 = 1.944;

/// An octave shows most at this frequency times its averaging factor.
const OCTAVE_PEAK: f64 = 0.37;

/// An octave that can vary, with two windows or more.
#[derive(Clone, Debug)]
pub(super) struct GridOctave {
    pub(super) octave: Octave,
    /// Among all octaves of the record.
    pub(super) place: usize,
    /// Degrees of freedom by kind of noise.
    pub(super) white_edf: f64,
    pub(super) flicker_edf: f64,
    pub(super) walk_edf: f64,
}

/// What all channels of a record have in common.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    shape: RecordShape,
    components: Vec<Component>,
    pub(super) octaves: Vec<GridOctave>,
    /// Edges of frequencies, and by octave what it takes from each cell.
    edges: Vec<f64>,
    filters: Vec<Vec<f64>>,
    /// By octave and component.
    columns: Vec<Vec<f64>>,
    /// Of segments, long or short, from the first channel on that has them.
    segments: [OnceLock<SegmentGrid>; 2],
    /// Of the level of the first channel, which nearly all have in common.
    level: OnceLock<Arc<LevelGrid>>,
}

/// The level of so many blocks.
#[derive(Debug)]
struct LevelGrid {
    blocks: usize,
    block_samples: u64,
    /// Variance of each cosine coefficient, by component.
    columns: Vec<Vec<f64>>,
}

/// What segments of so many samples show.
#[derive(Clone, Debug)]
struct SegmentGrid {
    samples: usize,
    groups: Vec<Group>,
    /// By octave what it takes from each group.
    taken: Vec<Vec<f64>>,
}

/// Neighbouring points of the spectrum.
#[derive(Clone, Debug)]
struct Group {
    first: usize,
    end: usize,
    /// By component.
    densities: Vec<f64>,
}

/// One channel, in units of its first octave.
pub(super) struct ChannelData<'a> {
    pub(super) grid: &'a Grid,
    /// In units of `scale`.
    pub(super) variances: Vec<f64>,
    pub(super) scale: f64,
    segments: Option<Segments<'a>>,
    pub(super) level: Option<LevelSeries>,
    /// By line, the strongest ones alone, and by octave.
    pub(super) lines: Vec<Vec<f64>>,
    pub(super) is_averaging_known: bool,
    /// How many octaves may have a part.
    octaves: usize,
    /// No statistic of lower frequencies has a part.
    lowest: f64,
}

struct Segments<'a> {
    grid: &'a SegmentGrid,
    /// Information of the segments over that of all samples.
    share: f64,
    /// Degrees of freedom of each point.
    dof: f64,
    measured: Vec<Measured>,
}

/// The points of a group without lines.
struct Measured {
    place: usize,
    power: f64,
    points: f64,
    /// By component.
    densities: Vec<f64>,
    /// A filter leaves next to nothing, which says nothing of the white noise.
    is_stopped: bool,
}

impl Measured {
    /// By the neighbours within the group alone.
    fn dependence(&self) -> f64 {
        1.0 + 2.0 * (4.0 / 9.0 * (1.0 - 1.0 / self.points) + 1.0 / 36.0 * (1.0 - 2.0 / self.points).max(0.0))
    }
}

/// By component, of `points` about a frequency.
fn densities(components: &[Component], frequency: f64, points: f64, samples: usize) -> Vec<f64> {
    components.iter().map(|component| component.density_of_points(frequency, points, samples as f64)).collect()
}

impl SegmentGrid {
    fn new(samples: usize, components: &[Component], octaves: &[GridOctave], deviation: Deviation) -> Self {
        let n = samples as f64;
        let mut groups = Vec::new();
        let mut start = FIRST;
        while start < samples / 2 {
            // finer where densities are steep
            let size = if 16 * start < samples {
                1
            } else if 8 * start < samples {
                2
            } else {
                MOST_POINTS
            };
            let end = (start + size).min(samples / 2);
            let (frequency, points) = (0.5 * (start + end - 1) as f64 / n, (end - start) as f64);
            let densities = densities(components, frequency, points, samples);
            groups.push(Group { first: start, end, densities });
            start = end;
        }
        let taken = |of: &GridOctave| {
            let edge = |point: usize| (point as f64 - 0.5) / n;
            let point = |k: usize| octave_filter(&of.octave, deviation, edge(k), edge(k + 1));
            groups.iter().map(|group| (group.first..group.end).map(point).sum()).collect()
        };
        Self { samples, taken: octaves.iter().map(taken).collect(), groups }
    }
}

impl Grid {
    pub(super) fn new(shape: &RecordShape, octaves: Vec<GridOctave>, components: &[Component]) -> Self {
        let (edges, deviation) = (super::density::cells(shape), shape.deviation);
        let filter = |of: &GridOctave| {
            edges.windows(2).map(|cell| octave_filter(&of.octave, deviation, cell[0], cell[1])).collect()
        };
        let filters: Vec<Vec<f64>> = octaves.iter().map(filter).collect();
        let densities: Vec<Vec<f64>> = components
            .iter()
            .map(|component| edges.windows(2).map(|cell| component.density((cell[0] * cell[1]).sqrt())).collect())
            .collect();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let column = |(of, filter): (&GridOctave, &Vec<f64>)| {
            let shown = |(component, density): (&Component, &Vec<f64>)| {
                component.exact_octave(&of.octave, deviation).unwrap_or_else(|| product(filter, density))
            };
            components.iter().zip(&densities).map(shown).collect()
        };
        Self {
            shape: *shape,
            components: components.to_vec(),
            columns: octaves.iter().zip(&filters).map(column).collect(),
            segments: Default::default(),
            level: OnceLock::new(),
            octaves,
            edges,
            filters,
        }
    }

    fn segments(&self, samples: usize) -> Option<&SegmentGrid> {
        let place = [LONG, SHORT].iter().position(|known| *known == samples)?;
        let of = || SegmentGrid::new(samples, &self.components, &self.octaves, self.shape.deviation);
        Some(self.segments[place].get_or_init(of))
    }

    fn level(&self, blocks: usize, block_samples: u64) -> Arc<LevelGrid> {
        let of = || {
            let coefficient = |k: usize| {
                self.components.iter().map(|component| component.of_level(k, blocks, block_samples as f64)).collect()
            };
            Arc::new(LevelGrid { blocks, block_samples, columns: (1..blocks).map(coefficient).collect() })
        };
        let known = self.level.get_or_init(of);
        if (known.blocks, known.block_samples) == (blocks, block_samples) { Arc::clone(known) } else { of() }
    }

    /// Degrees of freedom of an octave in a mixture of noises with these parameters, by those of each
    /// alone, as if differences of all were as much alike as those of the one they share most with.
    pub(super) fn mixed_edf(&self, place: usize, parameters: &[f64]) -> Option<f64> {
        let of = &self.octaves[place];
        let each = self.components.iter().zip(&self.columns[place]).zip(parameters);
        let (sum, spread) = each.fold((0.0, 0.0), |(sum, spread), ((component, column), parameter)| {
            let share: f64 = column * parameter;
            let edf = match component {
                Component::Flicker => of.flicker_edf,
                Component::Walk => of.walk_edf,
                Component::GaussMarkov(time) if (of.octave.m as f64) < *time => of.walk_edf,
                _ => of.white_edf,
            };
            (sum + share, spread + share / edf.sqrt())
        });
        let edf = (sum / spread).powi(2);
        edf.is_finite().then_some(edf)
    }

    /// What an octave shows of each component with parameter 1.
    pub(super) fn columns(&self, place: usize) -> &[f64] {
        &self.columns[place]
    }
}

impl<'a> Segments<'a> {
    fn new(
        grid: &'a SegmentGrid,
        components: &[Component],
        powers: &Powers,
        bands: &[NarrowBand],
        scale: f64,
        lowest: f64,
        samples: f64,
    ) -> Option<Self> {
        let n = grid.samples as f64;
        let is_free = |k: usize| {
            powers.powers[k] > 0.0
                && k as f64 >= lowest * n
                && bands.iter().all(|band| !band.covers(k as f64 / n, 2.0 / n))
        };
        let measured = |(place, group): (usize, &Group)| {
            let free: Vec<usize> = (group.first..group.end).filter(|k| is_free(*k)).collect();
            let points = free.len() as f64;
            let mean = |of: &dyn Fn(usize) -> f64| free.iter().map(|k| of(*k)).sum::<f64>() / points;
            let densities = match free.len() {
                0 => return None,
                some if some == group.end - group.first => group.densities.clone(),
                _ => densities(components, mean(&|k| k as f64) / n, points, grid.samples),
            };
            let power = mean(&|k| powers.powers[k]) / scale;
            Some(Measured { place, power, points, densities, is_stopped: false })
        };
        let measured: Vec<Measured> = grid.groups.iter().enumerate().filter_map(measured).collect();
        let share = (powers.averages * n / DEPENDENCE / samples).min(1.0);
        let is_enough = powers.segments >= LEAST_SEGMENTS && measured.len() > 8;
        is_enough.then_some(Self { grid, share, dof: 2.0 * powers.averages / DEPENDENCE, measured })
    }

    fn mean_density(&self) -> f64 {
        let add = |(sum, points): (f64, f64), of: &Measured| (sum + of.points * of.power, points + of.points);
        let (sum, points) = self.measured.iter().fold((0.0, 0.0), add);
        sum / points
    }
}

impl<'a> ChannelData<'a> {
    /// `None` if a variance is missing, zero or no number. `known_octaves` of the first ones may
    /// have a part.
    pub(super) fn new(grid: &'a Grid, curve: &super::ChannelCurve<'_>, known_octaves: usize) -> Option<Self> {
        let variances: Vec<f64> = grid.octaves.iter().filter_map(|of| curve.variances.get(of.place).copied()).collect();
        let is_usable = |value: &f64| value.is_finite() && *value > 0.0;
        let scale = *variances.first()?;
        if variances.len() != grid.octaves.len() || !variances.iter().all(is_usable) {
            return None;
        }
        let is_part = known_octaves < grid.octaves.len();
        let lowest =
            if is_part { OCTAVE_PEAK / grid.octaves[known_octaves.checked_sub(1)?].octave.m as f64 } else { 0.0 };
        let level = curve.signal.and_then(|(signal, unit)| LevelSeries::of(signal, unit / scale.sqrt()));
        let shown = grid.shape.share_of_windows(&grid.octaves[0].octave) * grid.shape.samples as f64;
        let segments = curve.signal.and_then(|(signal, unit)| {
            let lowest = level.as_ref().map_or(0.0, |level| 0.5 / level.block_samples as f64).max(lowest);
            let powers = signal.spectrum().powers()?;
            let segments = grid.segments(powers.segment_samples)?;
            Segments::new(segments, &grid.components, &powers, curve.bands, scale / (unit * unit), lowest, shown)
        });
        let mut bands: Vec<&NarrowBand> = curve.bands.iter().filter(|band| band.power > 0.0).collect();
        bands.sort_by(|a, b| b.power.total_cmp(&a.power));
        let (strongest, others) = bands.split_at(bands.len().min(MOST_LINES));
        let groups = strongest.iter().map(core::slice::from_ref).chain((!others.is_empty()).then_some(others));
        let lines = groups.map(|group| {
            // of a part of a band, twice its width times the density
            let of_part = |octave: &Octave, (from, to, share): &(f64, f64, f64)| {
                share * octave_filter(octave, grid.shape.deviation, *from, *to) / (2.0 * (to - from))
            };
            let of_band = |octave: &Octave, band: &NarrowBand| {
                band.power / scale * band.parts.iter().map(|part| of_part(octave, part)).sum::<f64>()
            };
            let of = |octave: &Octave| group.iter().map(|band| of_band(octave, band)).sum();
            grid.octaves.iter().map(|grid_octave| of(&grid_octave.octave)).collect()
        });
        let lines = lines.collect();
        let variances: Vec<f64> = variances.iter().map(|variance| variance / scale).collect();
        let mut segments = segments;
        if let Some(segments) = &mut segments {
            let is_long = |of: &GridOctave| of.octave.m >= LONGER_THAN_FILTERS && of.white_edf >= LEAST_EDF_OF_FLOOR;
            let long = grid.octaves.iter().zip(&variances).filter(|(of, _)| is_long(of));
            let floor =
                long.map(|(of, variance)| of.octave.m as f64 * variance).fold(segments.mean_density(), f64::min);
            segments.measured.iter_mut().for_each(|of| of.is_stopped = of.power < STOPPED * floor);
        }
        Some(Self {
            grid,
            variances,
            scale,
            segments,
            level,
            lines,
            is_averaging_known: curve.is_averaging_known,
            octaves: known_octaves,
            lowest,
        })
    }

    /// What a record in whole blocks and without segments shows of components of these squares.
    pub(super) fn expecting(grid: &'a Grid, squares: &[f64]) -> Self {
        let sum = |columns: &mut dyn Iterator<Item = f64>| columns.zip(squares).map(|(a, b)| a * b).sum::<f64>();
        let variances: Vec<f64> = grid.columns.iter().map(|columns| sum(&mut columns.iter().copied())).collect();
        let scale = variances.first().copied().unwrap_or(1.0);
        let mut length = WINDOW as u64;
        while grid.shape.samples / length >= MAX_BLOCKS as u64 {
            length *= 2;
        }
        let blocks = (grid.shape.samples / length) as usize;
        let coefficient = |(k, columns): (usize, &Vec<f64>)| {
            let sign = if k % 4 < 2 { 1.0 } else { -1.0 };
            sign * (sum(&mut columns.iter().copied()) / scale).sqrt()
        };
        let of_level = grid.level(blocks, length);
        let coefficients: Vec<f64> = (1..).zip(&of_level.columns).map(coefficient).collect();
        let level = LevelSeries { block_samples: length, coefficients, white_factor: 1.0 };
        Self {
            grid,
            variances: variances.iter().map(|variance| variance / scale).collect(),
            scale,
            segments: None,
            level: (blocks >= MIN_BLOCKS).then_some(level),
            lines: Vec::new(),
            is_averaging_known: true,
            octaves: grid.octaves.len(),
            lowest: 0.0,
        }
    }

    /// Those that may have a part, each with its variance.
    pub(super) fn octaves(&self) -> impl Iterator<Item = (&GridOctave, f64)> {
        self.grid.octaves.iter().zip(self.variances.iter().copied()).take(self.octaves)
    }

    /// How many of them have more than a few degrees of freedom.
    pub(super) fn octaves_in_use(&self) -> usize {
        self.octaves().filter(|(of, _)| of.walk_edf >= LEAST_EDF).count()
    }

    pub(super) fn has_segments(&self) -> bool {
        self.segments.is_some()
    }

    /// What the lines add to an octave with these multiples.
    pub(super) fn lines_of(&self, place: usize, multiples: &[f64]) -> f64 {
        self.lines.iter().zip(multiples).map(|(line, multiple)| line[place] * multiple).sum()
    }

    /// A column for each component, then for each line.
    pub(super) fn rows(&self) -> Rows {
        let (components, lines) = (&self.grid.components, self.lines.len());
        let mut rows = Rows { columns: vec![Vec::new(); components.len() + lines], ..Rows::default() };
        // without segments the first octave, in its own unit
        rows.mean_density = self.segments.as_ref().map_or(1.0, Segments::mean_density);
        if let Some(segments) = &self.segments {
            for of in segments.measured.iter().filter(|of| !of.is_stopped) {
                let weight = 0.5 * segments.dof * of.points;
                let densities = of.densities.iter().copied();
                let alone = weight * DEPENDENCE / of.dependence();
                rows.push(of.power, weight, alone, densities.chain(core::iter::repeat_n(0.0, lines)));
            }
        }
        self.push_octaves(&mut rows);
        rows.first_level = rows.power.len();
        if let Some(level) = &self.level {
            let (blocks, length) = (level.coefficients.len() + 1, level.block_samples as f64);
            let of_level = self.grid.level(blocks, level.block_samples);
            for (k, (coefficient, columns)) in (1..).zip(level.coefficients.iter().zip(&of_level.columns)) {
                if 0.5 * f64::from(k) / (blocks as f64 * length) < self.lowest {
                    continue;
                }
                let of = |(component, variance): (&Component, &f64)| {
                    let missing = if matches!(component, Component::White(_)) { level.white_factor } else { 1.0 };
                    missing * variance
                };
                let columns = components.iter().zip(columns).map(of).chain(core::iter::repeat_n(0.0, lines));
                rows.push(coefficient * coefficient, 0.5, 0.5, columns);
                rows.level.push(*coefficient);
            }
        }
        rows
    }

    fn push_octaves(&self, rows: &mut Rows) {
        let rest = self.rest();
        let chosen: Vec<usize> = (0..self.octaves).filter(|place| self.is_in(*place, &rest[*place])).collect();
        let weights = self.weights(&chosen);
        for (place, (weight, alone)) in chosen.into_iter().zip(weights) {
            let Rest { value, columns, .. } = &rest[place];
            let lines = self.lines.iter().map(|line| line[place]);
            rows.push(*value, weight, alone, columns.iter().copied().chain(lines));
        }
    }

    fn is_in(&self, place: usize, rest: &Rest) -> bool {
        let of = &self.grid.octaves[place];
        let is_above_level = match &self.level {
            Some(level) => 2 * of.octave.m <= level.block_samples,
            None => of.walk_edf >= LEAST_EDF,
        };
        is_above_level && rest.value > 0.0 && rest.share > LEAST_REST
    }

    /// What each octave has beyond the segments.
    fn rest(&self) -> Vec<Rest> {
        let of = |place: usize| {
            let value = self.variances[place];
            let mut rest = Rest { value, columns: self.grid.columns[place].clone(), share: 1.0 };
            let Some(segments) = &self.segments else { return rest };
            for of in &segments.measured {
                let taken = segments.grid.taken[place][of.place] * if of.is_stopped { 1.0 } else { segments.share };
                rest.value -= taken * of.power;
                for (column, density) in rest.columns.iter_mut().zip(&of.densities) {
                    *column -= taken * density;
                }
            }
            rest.share = rest.value / value;
            rest
        };
        (0..self.octaves).map(of).collect()
    }

    /// Half of the degrees of freedom of the rest of each octave, less what neighbours share, so
    /// that all together have the variance that they have for a common factor; and of each alone.
    fn weights(&self, chosen: &[usize]) -> Vec<(f64, f64)> {
        let cells = self.cells(chosen);
        let samples = self.grid.shape.samples as f64;
        let covariance = |i: usize, j: usize, of: &dyn Fn(&Cell) -> f64| -> f64 {
            let of = |cell: &Cell| cell.taken[i] * cell.taken[j] * of(cell) / (cell.width * samples);
            cells.iter().map(of).sum()
        };
        let mean = |i: usize, of: &dyn Fn(&Cell) -> f64| cells.iter().map(|cell| cell.taken[i] * of(cell)).sum::<f64>();
        // the windows that there are, by white noise in all of them
        let factor = |(i, place): (usize, &usize)| {
            let white = covariance(i, i, &|_| 1.0) / mean(i, &|_| 1.0).powi(2);
            (2.0 / self.grid.octaves[*place].white_edf / white).sqrt()
        };
        let factors: Vec<f64> = chosen.iter().enumerate().map(factor).collect();
        let means: Vec<f64> = (0..chosen.len()).map(|i| mean(i, &|cell| cell.density * cell.left)).collect();
        let relative = |i: usize, j: usize| {
            let of = |cell: &Cell| cell.density * cell.density * cell.left;
            factors[i] * factors[j] * covariance(i, j, &of) / (means[i] * means[j])
        };
        let relative: Vec<Vec<f64>> = (0..chosen.len()).map(|i| (0..=i).map(|j| relative(i, j)).collect()).collect();
        let dof: Vec<f64> = (0..chosen.len()).map(|i| 2.0 / relative[i][i]).collect();
        let sum: f64 = dof.iter().sum();
        let shared = |i: usize, j: usize| dof[i] * dof[j] * relative[i.max(j)][i.min(j)];
        let together: f64 = (0..chosen.len()).map(|i| (0..chosen.len()).map(|j| shared(i, j)).sum::<f64>()).sum();
        dof.iter().map(|dof| (0.5 * dof * (2.0 * sum / together).min(1.0), 0.5 * dof)).collect()
    }

    /// Frequencies, with the density as the octaves or the segments show it.
    fn cells(&self, chosen: &[usize]) -> Vec<Cell> {
        let density = |frequency: f64| {
            let of = |place: usize| self.variances[place] * self.grid.octaves[place].octave.m as f64;
            let at = (OCTAVE_PEAK / frequency).log2().clamp(0.0, (self.grid.octaves.len() - 1) as f64);
            let (below, part) = (at.floor() as usize, at.fract());
            of(below) + part * (of((below + 1).min(self.grid.octaves.len() - 1)) - of(below))
        };
        let segments = self.segments.as_ref();
        let first = segments.and_then(|segments| segments.measured.first());
        let lowest = segments
            .zip(first)
            .map(|(segments, of)| (segments.grid.groups[of.place].first as f64 - 0.5) / segments.grid.samples as f64);
        let below = self.grid.edges.windows(2).enumerate();
        let below = below.filter(|(_, cell)| lowest.is_none_or(|lowest| cell[1] <= lowest));
        let below = below.map(|(place, cell)| Cell {
            taken: chosen.iter().map(|octave| self.grid.filters[*octave][place]).collect(),
            width: cell[1] - cell[0],
            density: density((cell[0] * cell[1]).sqrt()),
            left: 1.0,
        });
        let above = segments.into_iter().flat_map(|segments| {
            let width = |of: &Group| (of.end - of.first) as f64 / segments.grid.samples as f64;
            segments.measured.iter().map(move |of| Cell {
                taken: chosen.iter().map(|octave| segments.grid.taken[*octave][of.place]).collect(),
                width: width(&segments.grid.groups[of.place]),
                density: of.power,
                left: 1.0 - segments.share,
            })
        });
        below.chain(above).collect()
    }
}

/// What an octave has beyond the segments, by component.
struct Rest {
    value: f64,
    columns: Vec<f64>,
    /// Of the octave.
    share: f64,
}

/// Frequencies of one density.
struct Cell {
    /// By octave.
    taken: Vec<f64>,
    width: f64,
    density: f64,
    /// Share of the information that is not in the segments.
    left: f64,
}
