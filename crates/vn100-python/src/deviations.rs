//! The deviations of whole arrays at any averaging factors, as allantools has them.

use std::thread;

use multiversion::multiversion;
use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::{exceptions::PyValueError, prelude::*};

/// Windows of all factors that begin in as many places are summed before the next ones: the places
/// stay in the cache.
const TILE: usize = 1 << 14;

/// Independent partial sums, so that additions neither wait for each other nor stay scalar.
const LANES: usize = 8;

/// Values of each of the four parts that are summed at a time.
const PART: usize = 512;

/// Windows that are summed between looks at signals: some tenths of a second.
const PORTION: usize = 1 << 28;

/// Factors of a portion at least, which are all octaves of an array: they share the tiles.
const FEWEST: usize = 32;

/// Integers below are exact as floats, and so are the differences of windows.
const EXACT: f64 = (1_u64 << 51) as f64;

/// 1.5 · 2^52: added to a float below 2^51 and taken off again, it leaves the nearest integer, as
/// vector instructions of any processor can.
const SHIFTER: f64 = 6_755_399_441_055_744.0;

/// Binary digits of rates at most.
const DIGITS: i32 = 36;

/// Root of the mean square of the differences of windows over m, and their number, at each factor
/// m; 0 where there is no window. Phase, or rates that are summed in `work`, which has a place more
/// than the data: an array of NumPy, as that asks the system for large pages.
///
/// Values are taken as integers of a power of two, for rates at most 2^-36 of the largest: phases
/// and integers are exact up to 2^51. Only the sums of squares are rounded, by less than 1e-13.
#[pyfunction]
pub(crate) fn deviations(
    py: Python<'_>,
    data: PyReadonlyArray1<'_, f64>,
    mut work: PyReadwriteArray1<'_, f64>,
    is_phase: bool,
    hadamard: bool,
    overlapping: bool,
    factors: Vec<usize>,
) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let data = data.as_slice().map_err(|error| PyValueError::new_err(error.to_string()))?;
    let work = work.as_slice_mut().map_err(|error| PyValueError::new_err(error.to_string()))?;
    if work.len() <= data.len() {
        return Err(PyValueError::new_err("the phases need a number more than there are data"));
    }
    let counted = py.detach(|| if is_phase { of_phase(data, work) } else { of_rates(data, work) });
    let (phase, step) = counted.ok_or_else(|| {
        let is_finite = data.iter().all(|value| value.is_finite());
        PyValueError::new_err(match is_finite {
            true => "the data leave the range of floats when they are summed or divided: scale them",
            false => "the data have a gap (NaN), or an infinite value: gradev and Analyzer take gaps",
        })
    })?;
    py.check_signals()?;
    let order = if hadamard { 3 } else { 2 };
    let mut sums = Vec::with_capacity(factors.len());
    for factors in factors.chunks((PORTION / phase.len().max(1)).max(FEWEST)) {
        sums.extend(py.detach(|| {
            if overlapping {
                overlapped(phase, order, factors)
            } else {
                factors.iter().map(|m| adjacent(phase, order, *m)).collect()
            }
        }));
        py.check_signals()?;
    }
    let divisor = if hadamard { 6.0 } else { 2.0 };
    let of = |((sum, windows), m): (&(f64, usize), &usize)| {
        let root = (sum / (divisor * (*windows).max(1) as f64)).sqrt() * step;
        (root / *m as f64, *windows)
    };
    Ok(sums.iter().zip(&factors).map(of).unzip())
}

/// A fold in partial results, each over every eighth value.
#[inline]
fn lanes(values: &[f64], fold: impl Fn(f64, f64) -> f64) -> [f64; LANES] {
    let mut lanes = [0.0; LANES];
    let (chunks, rest) = values.as_chunks::<LANES>();
    for chunk in chunks {
        lanes.iter_mut().zip(chunk).for_each(|(lane, value)| *lane = fold(*lane, *value));
    }
    lanes.iter_mut().zip(rest).for_each(|(lane, value)| *lane = fold(*lane, *value));
    lanes
}

/// Of a number below 2^51.
#[inline]
fn rounded(value: f64) -> f64 {
    (value + SHIFTER) - SHIFTER
}

/// The power of two by which a magnitude has so many binary digits.
fn step(most: f64, digits: i32) -> f64 {
    if most > 0.0 { 2_f64.powi(most.log2().floor() as i32 + 1 - digits) } else { 1.0 }
}

/// Whether sums and steps of numbers of this magnitude are floats.
fn is_in_range(most: f64) -> bool {
    most == 0.0 || (1e-290..1e290).contains(&most)
}

/// In whole steps, and the step; `None` beyond the range of floats, and for what is no number.
fn of_phase<'a>(data: &'a [f64], work: &'a mut [f64]) -> Option<(&'a [f64], f64)> {
    let first = data.first().copied().unwrap_or(0.0);
    // not below the limit, or no number
    let is_other = |sum: f64, value: f64| sum + if rounded(value) == value && value.abs() < EXACT { 0.0 } else { 1.0 };
    if lanes(data, is_other).iter().sum::<f64>() == 0.0 {
        return Some((data, 1.0));
    }
    let is_finite = lanes(data, |sum, value| sum + 0.0 * value).iter().sum::<f64>() == 0.0;
    let farther = |most: f64, value: f64| if (value - first).abs() > most { (value - first).abs() } else { most };
    let most = lanes(data, farther).into_iter().fold(0.0_f64, f64::max);
    if !is_finite || !is_in_range(most) {
        return None;
    }
    // whole numbers stay whole
    let step = step(most, EXACT.log2() as i32).min(1.0);
    let step = if most / step < EXACT { step } else { self::step(most, EXACT.log2() as i32) };
    let scale = 1.0 / step;
    let phase = &mut work[..data.len()];
    phase.iter_mut().zip(data).for_each(|(place, value)| *place = rounded((value - first) * scale));
    Some((phase, step))
}

/// The sums of the rates less the integer nearest their mean: as short as they can be.
fn of_rates<'a>(data: &[f64], work: &'a mut [f64]) -> Option<(&'a [f64], f64)> {
    let phase = &mut work[..=data.len()];
    phase[0] = 0.0;
    // no number if any value is none
    let mean = lanes(data, |sum, value| sum + value).iter().sum::<f64>() / data.len().max(1) as f64;
    let farther = |most: f64, value: f64| if (value - mean).abs() > most { (value - mean).abs() } else { most };
    let most = lanes(data, farther).into_iter().fold(0.0_f64, f64::max);
    if !mean.is_finite() || !is_in_range(most) {
        return None;
    }
    for digits in (1..=DIGITS).rev() {
        let step = step(most, digits);
        let (offset, scale) = ((mean / step).round_ties_even(), 1.0 / step);
        // beyond, a rate is no exact number of steps
        if offset.abs() + most * scale >= EXACT {
            continue;
        }
        if add_up(data, |rate| rounded(rate * scale) - offset, &mut phase[1..]) < EXACT / 4.0 {
            return Some((phase, step));
        }
    }
    None
}

/// The sums of whole numbers up to each place, and the largest magnitude of them. Four parts of a
/// block are summed at a time, so that additions do not wait for each other: no sum is rounded, and
/// so what is added first makes no difference.
fn add_up(values: &[f64], number: impl Fn(f64) -> f64, sums: &mut [f64]) -> f64 {
    let (mut before, mut longest) = (0.0, 0.0_f64);
    let farther = |most: f64, sum: f64| if sum.abs() > most { sum.abs() } else { most };
    let (blocks, rest) = values.as_chunks::<{ 4 * PART }>();
    let (sum_blocks, sums_of_rest) = sums.as_chunks_mut::<{ 4 * PART }>();
    for (block, sums) in blocks.iter().zip(sum_blocks) {
        let mut parts = [0.0; 4];
        for place in 0..PART {
            for (part, sum) in parts.iter_mut().enumerate() {
                *sum += number(block[part * PART + place]);
                sums[part * PART + place] = *sum;
            }
        }
        for (sums, part) in sums.as_chunks_mut::<PART>().0.iter_mut().zip(parts) {
            sums.iter_mut().for_each(|sum| *sum += before);
            before += part;
        }
        longest = lanes(sums, farther).into_iter().fold(longest, f64::max);
    }
    for (value, sum) in rest.iter().zip(sums_of_rest) {
        before += number(*value);
        *sum = before;
        longest = farther(longest, before);
    }
    longest
}

/// Sums of squares over all windows, and their number.
fn overlapped(phase: &[f64], order: usize, factors: &[usize]) -> Vec<(f64, usize)> {
    let windows: Vec<usize> = factors.iter().map(|m| phase.len().saturating_sub(order * m)).collect();
    let tiles = phase.len().div_ceil(TILE);
    // of each tile by itself: the sums do not depend on the threads
    let mut sums = vec![0.0; tiles * factors.len()];
    let threads = thread::available_parallelism().map_or(1, Into::into).min(tiles.max(1));
    let share = tiles.div_ceil(threads).max(1);
    thread::scope(|scope| {
        for (part, sums) in sums.chunks_mut(share * factors.len().max(1)).enumerate() {
            let windows = &windows;
            scope.spawn(move || {
                for (tile, sums) in sums.chunks_mut(factors.len().max(1)).enumerate() {
                    let begin = (part * share + tile) * TILE;
                    for ((sum, m), windows) in sums.iter_mut().zip(factors).zip(windows) {
                        let end = (begin + TILE).min(*windows);
                        if begin < end {
                            *sum = squares(phase, order, *m, begin, end - begin);
                        }
                    }
                }
            });
        }
    });
    let sum = |place: usize| sums.iter().skip(place).step_by(factors.len()).sum();
    windows.iter().enumerate().map(|(place, windows)| (sum(place), *windows)).collect()
}

/// Of the windows that begin at a multiple of m.
fn adjacent(phase: &[f64], order: usize, m: usize) -> (f64, usize) {
    let ends: Vec<f64> = phase.iter().step_by(m.max(1)).copied().collect();
    let windows = ends.len().saturating_sub(order);
    (squares(&ends, order, 1, 0, windows), windows)
}

/// The same bits, faster, with wider registers.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn squares(phase: &[f64], order: usize, m: usize, begin: usize, windows: usize) -> f64 {
    if windows == 0 {
        return 0.0;
    }
    let points = |lag: usize| &phase[begin + lag * m..][..windows];
    match order {
        2 => lane_sum([points(0), points(1), points(2)], |[p0, p1, p2]| (p2 - p1) - (p1 - p0)),
        _ => lane_sum([points(0), points(1), points(2), points(3)], |[p0, p1, p2, p3]| {
            (p3 - p2) - (p2 - p1) - ((p2 - p1) - (p1 - p0))
        }),
    }
}

#[inline(always)]
fn lane_sum<const S: usize>(slices: [&[f64]; S], z: impl Fn([f64; S]) -> f64) -> f64 {
    let chunks = slices.map(|slice| slice.as_chunks::<LANES>());
    let mut lanes = [0.0_f64; LANES];
    for chunk in 0..chunks[0].0.len() {
        let chunk = chunks.map(|(whole, _)| &whole[chunk]);
        for (lane, sum) in lanes.iter_mut().enumerate() {
            let z = z(chunk.map(|values| values[lane]));
            *sum += z * z;
        }
    }
    let rest: f64 = (0..chunks[0].1.len()).map(|place| z(chunks.map(|(_, rest)| rest[place])).powi(2)).sum();
    lanes.iter().sum::<f64>() + rest
}
