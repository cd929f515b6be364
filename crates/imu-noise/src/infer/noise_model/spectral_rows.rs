//! The statistics of one channel as powers of one density, each information once: segments of the
//! spectrum above, the cosine coefficients of the level below, and the octaves for all that neither
//! of them holds.
//!
//! Where segments hold a share s of the information above their lowest frequency, an octave less s
//! times what the segments say of it is independent of them: the octave, of all samples, is the
//! efficient estimate, and its covariance with any other one is its own variance.

use super::{
    density::{Component, LagsOfPoints, octave_filter},
    scoring::Rows,
    thresholds::{LEAST_EDF, LEAST_REST, MOST_LINES, STOPPED},
};
use crate::accumulate::blocks::{MAX_BLOCKS, WINDOW};
use crate::accumulate::record::{Octave, RecordShape};
use crate::accumulate::spectrum::{LONG, Powers, SHORT};
use crate::infer::level_series::{LevelSeries, MIN_BLOCKS};
use crate::infer::narrow_bands::NarrowBand;

/// Lowest point of a segment in use: below, segments have lost their mean.
const FIRST: usize = 5;

/// Points of the spectrum in one row at most.
const MOST_POINTS: usize = 4;

/// Fewest segments.
const LEAST_SEGMENTS: u64 = 4;

/// Points that the Hann window makes of one independent point: 1 + 2 (4/9 + 1/36).
const DEPENDENCE: f64 = 1.944;

/// Octaves that show no filter, in samples, and how many degrees of freedom they have at least.
const LONGER_THAN_FILTERS: u64 = 64;
const LEAST_EDF_OF_FLOOR: f64 = 10.0;

/// An octave shows most at this frequency times its averaging factor.
const OCTAVE_PEAK: f64 = 0.37;

/// What all channels of a record have in common.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    shape: RecordShape,
    octaves: Vec<Octave>,
    /// Degrees of freedom in white noise and in a walk.
    white_edf: Vec<f64>,
    walk_edf: Vec<f64>,
    /// Edges of frequencies, and by octave what it takes from each cell.
    edges: Vec<f64>,
    filters: Vec<Vec<f64>>,
    /// By octave and component.
    columns: Vec<Vec<f64>>,
    /// By octave what it takes from each point of a segment, long or short.
    of_points: [Vec<Vec<f64>>; 2],
}

/// One channel, in units of its first octave.
pub(super) struct ChannelData<'a> {
    pub(super) grid: &'a Grid,
    /// In units of `scale`.
    pub(super) variances: Vec<f64>,
    pub(super) scale: f64,
    segments: Option<Segments>,
    pub(super) level: Option<LevelSeries>,
    /// By line and octave.
    lines: Vec<Vec<f64>>,
    pub(super) is_averaging_known: bool,
    /// How many octaves may have a part.
    octaves: usize,
    /// No statistic of lower frequencies has a part.
    lowest: f64,
}

struct Segments {
    samples: usize,
    /// Information of the segments over that of all samples.
    share: f64,
    groups: Vec<Group>,
}

/// Neighbouring points of the spectrum.
struct Group {
    first: usize,
    end: usize,
    frequency: f64,
    power: f64,
    points: f64,
    /// Degrees of freedom.
    dof: f64,
    /// A filter leaves next to nothing, which says nothing of the white noise.
    is_stopped: bool,
}

impl Group {
    /// By the neighbours within the group alone.
    fn dependence(&self) -> f64 {
        1.0 + 2.0 * (4.0 / 9.0 * (1.0 - 1.0 / self.points) + 1.0 / 36.0 * (1.0 - 2.0 / self.points).max(0.0))
    }
}

impl Grid {
    pub(super) fn new(
        shape: &RecordShape,
        octaves: Vec<Octave>,
        [white_edf, walk_edf]: [Vec<f64>; 2],
        components: &[Component],
    ) -> Self {
        let edges = super::density::cells(shape);
        let filters: Vec<Vec<f64>> = octaves
            .iter()
            .map(|octave| {
                edges.windows(2).map(|cell| octave_filter(octave, shape.deviation, cell[0], cell[1])).collect()
            })
            .collect();
        let densities: Vec<Vec<f64>> = components
            .iter()
            .map(|component| edges.windows(2).map(|cell| component.density((cell[0] * cell[1]).sqrt())).collect())
            .collect();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let column = |(octave, filter): (&Octave, &Vec<f64>)| {
            let each = components.iter().zip(&densities);
            let of = |(component, density): (&Component, &Vec<f64>)| {
                component.exact_octave(octave, shape.deviation).unwrap_or_else(|| product(filter, density))
            };
            each.map(of).collect()
        };
        let columns = octaves.iter().zip(&filters).map(column);
        let of_points = [LONG, SHORT].map(|samples| {
            let point = |octave: &Octave, k: usize| {
                let (from, to) = ((k as f64 - 0.5) / samples as f64, (k as f64 + 0.5) / samples as f64);
                octave_filter(octave, shape.deviation, from, to.min(0.5))
            };
            octaves.iter().map(|octave| (1..=samples / 2).map(|k| point(octave, k)).collect()).collect()
        });
        Self { shape: *shape, columns: columns.collect(), octaves, white_edf, walk_edf, edges, filters, of_points }
    }

    pub(super) fn octaves(&self) -> &[Octave] {
        &self.octaves
    }

    /// What an octave shows of each component with parameter 1.
    pub(super) fn columns(&self, place: usize) -> &[f64] {
        &self.columns[place]
    }
}

impl Segments {
    fn new(powers: &Powers, bands: &[NarrowBand], scale: f64, lowest: f64, samples: f64) -> Option<Self> {
        let n = powers.segment_samples;
        let is_free = |k: &usize| {
            let frequency = *k as f64 / n as f64;
            powers.powers[*k] > 0.0 && bands.iter().all(|band| !band.covers(frequency, 2.0 / n as f64))
        };
        let first = FIRST.max((lowest * n as f64).ceil() as usize);
        let mut groups = Vec::new();
        let mut start = first;
        while start < n / 2 {
            // finer where densities are steep
            let size = if 16 * start < n {
                1
            } else if 8 * start < n {
                2
            } else {
                MOST_POINTS
            };
            let end = (start + size).min(n / 2);
            let free: Vec<usize> = (start..end).filter(is_free).collect();
            if !free.is_empty() {
                let count = free.len() as f64;
                groups.push(Group {
                    first: start,
                    end,
                    frequency: free.iter().map(|k| *k as f64).sum::<f64>() / count / n as f64,
                    power: free.iter().map(|k| powers.powers[*k]).sum::<f64>() / count / scale,
                    points: count,
                    dof: 2.0 * powers.averages * count / DEPENDENCE,
                    is_stopped: false,
                });
            }
            start = end;
        }
        let share = (powers.averages * n as f64 / DEPENDENCE / samples).min(1.0);
        (powers.segments >= LEAST_SEGMENTS && groups.len() > 8).then_some(Self { samples: n, share, groups })
    }
}

impl Segments {
    fn mean_density(&self) -> f64 {
        let add = |(sum, points): (f64, f64), of: &Group| (sum + of.points * of.power, points + of.points);
        let (sum, points) = self.groups.iter().fold((0.0, 0.0), add);
        sum / points
    }

    /// By group and component.
    fn densities(&self, components: &[Component]) -> Vec<Vec<f64>> {
        let lags = LagsOfPoints::new(components, MOST_POINTS, self.samples);
        self.groups.iter().map(|group| lags.densities(components, group.frequency, group.points)).collect()
    }
}

impl<'a> ChannelData<'a> {
    /// `None` if a variance is missing, zero or no number. `known_octaves` of the first ones may
    /// have a part.
    pub(super) fn new(
        grid: &'a Grid,
        curve: &super::ChannelCurve<'_>,
        places: &[usize],
        known_octaves: usize,
    ) -> Option<Self> {
        let variances: Vec<f64> = places.iter().filter_map(|place| curve.variances.get(*place).copied()).collect();
        let is_usable = |value: &f64| value.is_finite() && *value > 0.0;
        let scale = *variances.first()?;
        if variances.len() != grid.octaves.len() || !variances.iter().all(is_usable) {
            return None;
        }
        let is_part = known_octaves < grid.octaves.len();
        let lowest = if is_part { OCTAVE_PEAK / grid.octaves[known_octaves.checked_sub(1)?].m as f64 } else { 0.0 };
        let level = curve.signal.and_then(|(signal, unit)| LevelSeries::of(signal, unit / scale.sqrt()));
        let shown = grid.shape.share_of_windows(&grid.octaves[0]) * grid.shape.samples as f64;
        let segments = curve.signal.and_then(|(signal, unit)| {
            let lowest = level.as_ref().map_or(0.0, |level| 0.5 / level.block_samples as f64).max(lowest);
            Segments::new(&signal.spectrum().powers()?, curve.bands, scale / (unit * unit), lowest, shown)
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
            grid.octaves.iter().map(of).collect()
        });
        let lines = lines.collect();
        let variances: Vec<f64> = variances.iter().map(|variance| variance / scale).collect();
        let mut segments = segments;
        if let Some(segments) = &mut segments {
            let long = grid.octaves.iter().zip(&variances).zip(&grid.white_edf);
            let long = long.filter(|((octave, _), edf)| octave.m >= LONGER_THAN_FILTERS && **edf >= LEAST_EDF_OF_FLOOR);
            let floor =
                long.map(|((octave, variance), _)| octave.m as f64 * variance).fold(segments.mean_density(), f64::min);
            segments.groups.iter_mut().for_each(|group| group.is_stopped = group.power < STOPPED * floor);
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

    /// What a record is expected to show of components with these squares, in whole blocks and without
    /// segments.
    pub(super) fn expecting(grid: &'a Grid, components: &[Component], squares: &[f64]) -> Self {
        let sum = |columns: &mut dyn Iterator<Item = f64>| columns.zip(squares).map(|(a, b)| a * b).sum::<f64>();
        let variances: Vec<f64> = grid.columns.iter().map(|columns| sum(&mut columns.iter().copied())).collect();
        let scale = variances.first().copied().unwrap_or(1.0);
        let mut length = WINDOW as u64;
        while grid.shape.samples / length >= MAX_BLOCKS as u64 {
            length *= 2;
        }
        let blocks = (grid.shape.samples / length) as usize;
        let coefficient = |k: usize| {
            let of = |component: &Component| component.of_level(k, blocks, length as f64);
            let sign = if k % 4 < 2 { 1.0 } else { -1.0 };
            sign * (sum(&mut components.iter().map(of)) / scale).sqrt()
        };
        let coefficients: Vec<f64> = (1..blocks).map(coefficient).collect();
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

    /// Those that may have a part: each with its variance and its degrees of freedom in a walk.
    pub(super) fn octaves(&self) -> impl Iterator<Item = (&Octave, f64, f64)> {
        let all = self.grid.octaves.iter().zip(&self.variances).zip(&self.grid.walk_edf);
        all.map(|((octave, variance), walk_edf)| (octave, *variance, *walk_edf)).take(self.octaves)
    }

    /// How many of them have more than a few degrees of freedom.
    pub(super) fn octaves_in_use(&self) -> usize {
        self.octaves().filter(|(.., walk_edf)| *walk_edf >= LEAST_EDF).count()
    }

    pub(super) fn has_segments(&self) -> bool {
        self.segments.is_some()
    }

    /// How many of the strongest lines have a column.
    pub(super) fn lines(&self) -> usize {
        self.lines.len()
    }

    /// What the lines add to an octave with these multiples.
    pub(super) fn lines_of(&self, place: usize, multiples: &[f64]) -> f64 {
        self.lines.iter().zip(multiples).map(|(line, multiple)| line[place] * multiple).sum()
    }

    /// A column for each component, then for each line, then one for a ramp that the octaves alone
    /// show.
    pub(super) fn rows(&self, components: &[Component], has_ramp: bool) -> Rows {
        let lines = self.lines.len();
        let columns = components.len() + lines + usize::from(has_ramp);
        let mut rows = Rows { columns: vec![Vec::new(); columns], ..Rows::default() };
        // without segments the first octave, in its own unit
        rows.mean_density = self.segments.as_ref().map_or(1.0, Segments::mean_density);
        let others = lines + usize::from(has_ramp);
        let densities = self.segments.as_ref().map_or_else(Vec::new, |segments| segments.densities(components));
        if let Some(segments) = &self.segments {
            for (group, densities) in segments.groups.iter().zip(&densities) {
                let weight = 0.5 * group.dof;
                if group.is_stopped {
                    continue;
                }
                let densities = densities.iter().copied();
                rows.push(
                    group.power,
                    weight,
                    weight * DEPENDENCE / group.dependence(),
                    densities.chain(core::iter::repeat_n(0.0, others)),
                );
            }
        }
        self.push_octaves(&mut rows, &densities, has_ramp);
        rows.first_level = rows.power.len();
        if let Some(level) = &self.level {
            let (blocks, length) = (level.coefficients.len() + 1, level.block_samples as f64);
            for (k, coefficient) in (1..blocks).zip(&level.coefficients) {
                if 0.5 * k as f64 / (blocks as f64 * length) < self.lowest {
                    continue;
                }
                let of = |component: &Component| {
                    let missing = if matches!(component, Component::White(_)) { level.white_factor } else { 1.0 };
                    missing * component.of_level(k, blocks, length)
                };
                let columns = components.iter().map(of).chain(core::iter::repeat_n(0.0, others));
                rows.push(coefficient * coefficient, 0.5, 0.5, columns);
                rows.level.push(*coefficient);
            }
        }
        rows
    }

    fn push_octaves(&self, rows: &mut Rows, densities: &[Vec<f64>], has_ramp: bool) {
        let rest = self.rest(densities);
        let chosen: Vec<usize> = (0..self.octaves).filter(|place| self.is_in(*place, &rest[*place])).collect();
        let weights = self.weights(&chosen);
        for (place, (weight, alone)) in chosen.into_iter().zip(weights) {
            let Rest { value, columns, .. } = &rest[place];
            let lines = self.lines.iter().map(|line| line[place]);
            let m = self.grid.octaves[place].m as f64;
            let ramp = has_ramp.then_some(m * m / 2.0);
            rows.push(*value, weight, alone, columns.iter().copied().chain(lines).chain(ramp));
        }
    }

    fn is_in(&self, place: usize, rest: &Rest) -> bool {
        let octave = &self.grid.octaves[place];
        let is_above_level = match &self.level {
            Some(level) => 2 * octave.m <= level.block_samples,
            None => self.grid.walk_edf[place] >= LEAST_EDF,
        };
        is_above_level && rest.value > 0.0 && rest.share > LEAST_REST
    }

    /// What each octave has beyond the segments.
    fn rest(&self, densities: &[Vec<f64>]) -> Vec<Rest> {
        let of = |place: usize| {
            let value = self.variances[place];
            let mut rest = Rest { value, columns: self.grid.columns[place].clone(), share: 1.0 };
            let Some(segments) = &self.segments else { return rest };
            let points = &self.grid.of_points[usize::from(segments.samples != LONG)][place];
            for (group, densities) in segments.groups.iter().zip(densities) {
                let taken: f64 = points[group.first - 1..group.end - 1].iter().sum();
                let share = if group.is_stopped { 1.0 } else { segments.share };
                rest.value -= share * taken * group.power;
                for (column, density) in rest.columns.iter_mut().zip(densities) {
                    *column -= share * taken * density;
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
        let cells = self.cells();
        let taken: Vec<Vec<f64>> = chosen.iter().map(|place| self.taken(*place, &cells)).collect();
        let samples = self.grid.shape.samples as f64;
        let covariance = |a: &[f64], b: &[f64], of: &dyn Fn(&Cell) -> f64| -> f64 {
            let each = a.iter().zip(b).zip(&cells);
            each.map(|((a, b), cell)| a * b * of(cell) / (cell.width * samples)).sum()
        };
        let mean =
            |a: &[f64], of: &dyn Fn(&Cell) -> f64| -> f64 { a.iter().zip(&cells).map(|(a, cell)| a * of(cell)).sum() };
        // the windows that there are, by white noise in all of them
        let factors: Vec<f64> = chosen
            .iter()
            .zip(&taken)
            .map(|(place, a)| {
                let white = covariance(a, a, &|_| 1.0) / mean(a, &|_| 1.0).powi(2);
                (2.0 / self.grid.white_edf[*place] / white).sqrt()
            })
            .collect();
        let means: Vec<f64> = taken.iter().map(|a| mean(a, &|cell| cell.density * cell.left)).collect();
        let relative = |i: usize, j: usize| {
            let of = |cell: &Cell| cell.density * cell.density * cell.left;
            factors[i] * factors[j] * covariance(&taken[i], &taken[j], &of) / (means[i] * means[j])
        };
        let dof: Vec<f64> = (0..chosen.len()).map(|i| 2.0 / relative(i, i)).collect();
        let sum: f64 = dof.iter().sum();
        let together: f64 =
            (0..chosen.len()).map(|i| (0..chosen.len()).map(|j| dof[i] * dof[j] * relative(i, j)).sum::<f64>()).sum();
        dof.iter().map(|dof| (0.5 * dof * (2.0 * sum / together).min(1.0), 0.5 * dof)).collect()
    }

    /// Frequencies, with the density as the octaves or the segments show it.
    fn cells(&self) -> Vec<Cell> {
        let density = |frequency: f64| {
            let of = |place: usize| self.variances[place] * self.grid.octaves[place].m as f64;
            let at = (OCTAVE_PEAK / frequency).log2().clamp(0.0, (self.grid.octaves.len() - 1) as f64);
            let (below, part) = (at.floor() as usize, at.fract());
            of(below) + part * (of((below + 1).min(self.grid.octaves.len() - 1)) - of(below))
        };
        let lowest = self
            .segments
            .as_ref()
            .and_then(|segments| Some((segments.groups.first()?.first as f64 - 0.5) / segments.samples as f64));
        let below =
            self.grid.edges.windows(2).enumerate().filter(|(_, cell)| lowest.is_none_or(|lowest| cell[1] <= lowest));
        let below = below.map(|(place, cell)| Cell {
            of: CellOf::Grid(place),
            width: cell[1] - cell[0],
            density: density((cell[0] * cell[1]).sqrt()),
            left: 1.0,
        });
        let above = self.segments.iter().flat_map(|segments| {
            segments.groups.iter().map(|group| Cell {
                of: CellOf::Points(segments.samples != LONG, group.first, group.end),
                width: (group.end - group.first) as f64 / segments.samples as f64,
                density: group.power,
                left: 1.0 - segments.share,
            })
        });
        below.chain(above).collect()
    }

    fn taken(&self, place: usize, cells: &[Cell]) -> Vec<f64> {
        let of = |cell: &Cell| match cell.of {
            CellOf::Grid(cell) => self.grid.filters[place][cell],
            CellOf::Points(is_short, first, end) => {
                self.grid.of_points[usize::from(is_short)][place][first - 1..end - 1].iter().sum()
            }
        };
        cells.iter().map(of).collect()
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
    of: CellOf,
    width: f64,
    density: f64,
    /// Share of the information that is not in the segments.
    left: f64,
}

enum CellOf {
    Grid(usize),
    /// Of a short segment; first point, and the one after the last.
    Points(bool, usize, usize),
}
