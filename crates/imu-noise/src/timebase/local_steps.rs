//! The local steps between the samples of a sensor of unknown rate, from a bounded number of
//! samples before and after.
//!
//! Stamps need not be even: a reader may take several samples at once, a clock may be coarse, a
//! host may be late. They only need a lower edge that rises evenly, or single steps with multiples.

use std::f64::consts::TAU;

/// Samples that are examined together; the first half is decided, unless the rate changes.
const WINDOW: usize = 1024;

/// Samples of a block, represented by its mean step or its earliest sample.
const BLOCK: usize = 64;

/// The relative difference of the mean steps on both sides of a change, and of the blocks on one.
const CHANGED: f64 = 0.15;
const SAME: f64 = 0.06;

/// As above, the latter as a part of the former, if each side has this many blocks of even steps: those of
/// a rate that wanders differ more.
const SLIGHTLY_CHANGED: f64 = 0.03;
const SAME_PART: f64 = 0.15;
const BLOCKS_OF_SLIGHT_CHANGE: usize = 3;

/// Relative tolerance of a single step, of one of a clock with ticks as long, and of a sum of two.
const NEAR: f64 = 0.25;
const ON_TICKS: f64 = 0.05;
const COARSE_TICKS_S: [f64; 3] = [0.01, 0.015_625, 0.016];
/// Ticks of other clocks: of kernels, frames and digits.
const OTHER_TICKS_S: [f64; 6] = [0.001, 0.004, 0.008, 1.0 / 60.0, 0.1, 1.0];
const NEAR_SUM: f64 = 0.04;

/// If there are fewer distances between pauses than this, the distances must be as even as ticks: three or
/// four random ones are often nearly even. Chosen.
const FEW_PAUSES: usize = 8;

/// The least difference of every other step in pairs, in mean steps. Chosen.
const PAIRED: f64 = 0.1;

/// The most steps of a pattern, the mean steps by which one differs from its repetition, and the mean
/// step in periods from which the pattern is that of two sources and not of a clock. Chosen.
const LONGEST_PATTERN: usize = 12;
const NEAR_REPEATED: f64 = 0.2;
const MANY_MISSING: f64 = 1.1;

/// If samples are missing, the mean step divided by a single one is below this: with more missing
/// samples, stamps in bursts are equally likely.
const MOST_MISSING: f64 = 1.8;

/// Samples that waited are sent this many times faster, or end after this time. Chosen.
const FLUSHED_FASTER: f64 = 1.9;
const LONGEST_FLUSH_S: f64 = 2.0;

/// Steps above this many median ones are pauses, and below this part of one samples come together.
const PAUSE: f64 = 16.0;
const SHORT: f64 = 0.4;

/// The fewest samples with one stamp that show a clock that stood still.
const LEAST_STOPPED: usize = 3;

/// The most samples that wait while a host stands still, for each period that it does.
const MOST_HELD: f64 = 1.2;

/// Rises of the edge over blocks whose distance from the usual rise is more than this many times the
/// median distance are gaps; and the distance, in median distances, by which they lead away together.
const OUTLIER: f64 = 4.0;
const RETURNS: f64 = 1.6;
const MOST_SPREAD: f64 = 1.5;

/// The least mean resultant of stamps that are whole periods of a frequency, the part of the longest
/// that is as long, and the number of stamps of that search.
const LEAST_RESULTANT: f64 = 0.5;
const AS_LONG: f64 = 0.85;
const SEARCHED: usize = 256;

/// The number of steps of which the sums are compared, which hold about [`IN_A_SUM`] missing samples,
/// and the mean steps by which nine tenths of the sums differ at most: two ticks of a clock, with some
/// wander. Missing at random, four samples would be one to eight.
const LEAST_BALANCED: usize = 16;
const MOST_BALANCED: usize = 96;
const IN_A_SUM: f64 = 4.0;
const MOST_UNBALANCED: f64 = 2.3;

/// The unevenness of the stamps of an even stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unevenness {
    /// Several samples at once, as read from a buffer.
    Bursts,
    /// Stamps of a clock with long ticks.
    CoarseClock,
    /// Two samples together, then a pause: a buffer of two, or two sources.
    Pairs,
    /// No rule: late stamps, or samples that are not equally spaced.
    Irregular,
}

/// The steps of some samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Steps {
    pub(super) period_s: f64,
    /// `None` for steps that are nearly equal, or multiples of a nearly equal step.
    pub(super) unevenness: Option<Unevenness>,
    /// The possible lasting rise of the lower edge of the stamps without a missing sample.
    pub(super) jump_s: f64,
}

/// Samples whose step is known.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stretch {
    pub(super) stamps_s: Vec<f64>,
    /// `None` without an even step.
    pub(super) steps: Option<Steps>,
    /// Whether the rate changed before them, or they are the first ones.
    pub(super) begins: bool,
}

#[derive(Clone, Debug, Default)]
pub(super) struct LocalSteps {
    pub(super) pending_s: Vec<f64>,
    /// Whether samples have been taken, and whether the rate is still that of the last of them.
    has_begun: bool,
    continues: bool,
    last: Option<Steps>,
}

impl LocalSteps {
    /// Adds a sample. Returns the samples that are decided with it.
    pub(super) fn push(&mut self, at_s: f64) -> Option<Stretch> {
        self.pending_s.push(at_s);
        (self.pending_s.len() == WINDOW).then(|| self.take(WINDOW / 2))
    }

    /// The next samples, if no other follows; `None` if all were taken.
    pub(super) fn finish(&mut self) -> Option<Stretch> {
        (!self.pending_s.is_empty()).then(|| self.take(WINDOW))
    }

    fn take(&mut self, most: usize) -> Stretch {
        part_equal_stamps(&mut self.pending_s);
        let usual_s = match self.last {
            Some(last) => last.unevenness.is_none().then_some(last.period_s),
            None => median(&differences(&self.pending_s)),
        };
        // samples that waited follow each other too soon
        let waited = usual_s.map_or(0, |usual_s| self.waited(usual_s));
        let running = self.pending_s.len() - standing(&self.pending_s[waited..]);
        let mut even_s = spread(&self.pending_s[waited..running], usual_s.unwrap_or_default());
        let mut until = self.pending_s.len();
        if let Some((place, before_s, after_s)) = change_of_rate(&even_s) {
            if !self.has_begun && 2 * place <= even_s.len() && is_flush(place, before_s, after_s) {
                even_s.drain(..place);
            } else {
                even_s.truncate(place);
                until = waited + place;
            }
        }
        let steps = steps_of(&even_s, self.last);
        let taken = if until < self.pending_s.len() { until } else { most.min(until) };
        let stretch = Stretch { stamps_s: self.pending_s.drain(..taken).collect(), steps, begins: !self.continues };
        self.continues = taken < until || self.pending_s.is_empty();
        self.has_begun = true;
        self.last = steps.filter(|_| self.continues);
        stretch
    }

    /// The number of first samples, up to half a window, at less than half of the usual step.
    fn waited(&self, usual_s: f64) -> usize {
        let is_short = |pair: &&[f64]| pair[1] - pair[0] < 0.5 * usual_s;
        Some(self.pending_s.windows(2).take_while(is_short).count()).filter(|waited| *waited <= WINDOW / 2).unwrap_or(0)
    }
}

/// The number of last samples with the stamp of the one before them, if a clock may have stopped.
fn standing(stamps_s: &[f64]) -> usize {
    let equal = stamps_s.iter().rev().take_while(|other| Some(*other) == stamps_s.last()).count();
    if equal < LEAST_STOPPED { 0 } else { equal - 1 }
}

/// Parts the stamps of a clock that stood still for several samples and caught up with the next one.
fn part_equal_stamps(stamps_s: &mut [f64]) {
    let rises: Vec<f64> = differences(stamps_s).into_iter().filter(|step_s| *step_s > 0.0).collect();
    let Some(period_s) = median(&rises) else { return };
    let mut first = 0;
    while first < stamps_s.len() {
        let at_s = stamps_s[first];
        let equal = stamps_s[first..].iter().take_while(|other| **other == at_s).count();
        let before_s = first.checked_sub(1).map(|before| at_s - stamps_s[before]);
        let behind_s = stamps_s.get(first + equal).map_or(0.0, |behind_s| behind_s - at_s);
        let has_caught_up = behind_s >= ((1.0 - NEAR_SUM) * equal as f64 - 0.5) * period_s;
        // after a pause they had waited
        if equal >= LEAST_STOPPED && before_s.is_none_or(|step_s| step_s < 2.0 * period_s) && has_caught_up {
            // evenly, unless samples are missing after them
            let step_s = Some(behind_s / equal as f64).filter(|step_s| difference(*step_s, period_s) < NEAR_SUM);
            let step_s = step_s.unwrap_or(period_s);
            (1..equal).for_each(|place| stamps_s[first + place] = at_s + place as f64 * step_s);
        }
        first += equal;
    }
}

/// The stamps with the samples that waited while a host stood still at most a period apart, up to
/// the last of them.
fn spread(stamps_s: &[f64], period_s: f64) -> Vec<f64> {
    let mut spread_s = stamps_s.to_vec();
    let step_s = |place: usize| stamps_s.get(place).map_or(f64::INFINITY, |at_s| at_s - stamps_s[place - 1]);
    let mut before = None;
    for place in 1..stamps_s.len() {
        if step_s(place) >= SHORT * period_s {
            before = Some(place - 1).filter(|_| step_s(place) >= PAUSE * period_s);
        }
        let ends = before.filter(|_| step_s(place + 1) >= SHORT * period_s);
        let Some(before) = ends else { continue };
        // more samples than the stall had time for are faster ones
        if (place - before) as f64 * period_s <= MOST_HELD * (stamps_s[place] - stamps_s[before]) {
            for held in (before + 1..place).rev() {
                spread_s[held] = (spread_s[held + 1] - period_s).max(stamps_s[before]);
            }
        }
    }
    spread_s
}

/// Whether the first samples, at this step, had waited when the recording began: they come much
/// faster than the later ones, or soon end.
fn is_flush(samples: usize, step_s: f64, later_step_s: f64) -> bool {
    let is_short = step_s * samples as f64 <= LONGEST_FLUSH_S;
    step_s < later_step_s && (is_short || FLUSHED_FASTER * step_s < later_step_s)
}

fn difference(one: f64, other: f64) -> f64 {
    (one / other - 1.0).abs().max((other / one - 1.0).abs())
}

/// The place of a change of an even mean step, and the local steps before and after it.
fn change_of_rate(stamps_s: &[f64]) -> Option<(usize, f64, f64)> {
    let size = (stamps_s.len() / 16).clamp(16, BLOCK);
    let steps_s = differences(stamps_s);
    // the longest step may be a gap
    let mean =
        |block: &[f64]| (block.iter().sum::<f64>() - block.iter().copied().fold(0.0, f64::max)) / (size - 1) as f64;
    let means: Vec<f64> = steps_s.chunks_exact(size).map(mean).collect();
    let is_even = |means: &[f64], mean: f64, same: f64| {
        5 * means.iter().filter(|other| (*other / mean - 1.0).abs() < same).count() >= 4 * means.len()
    };
    let parts = (1..means.len().saturating_sub(1)).filter_map(|block| {
        let (before, after) = (median(&means[..block])?, median(&means[block..])?);
        let (by, least) = (difference(before, after), block.min(means.len() - block));
        let is_slight = by <= CHANGED;
        let same = if is_slight { SAME_PART * by } else { SAME };
        let is_seen = by > SLIGHTLY_CHANGED && (!is_slight || least >= BLOCKS_OF_SLIGHT_CHANGE);
        let is_change = is_seen && is_even(&means[..block], before, same) && is_even(&means[block..], after, same);
        let rest = |means: &[f64], mean: f64| means.iter().map(|other| (other - mean).abs()).sum::<f64>();
        is_change.then(|| (rest(&means[..block], before) + rest(&means[block..], after), block, before, after))
    });
    let (_, block, before, after) = parts.min_by(|a, b| a.0.total_cmp(&b.0))?;
    // relative to a step between the two, the lag has its extreme at the change
    let (between, sign) = (0.5 * (before + after), if after > before { -1.0 } else { 1.0 });
    let around = (block - 1) * size..((block + 1) * size + 1).min(stamps_s.len());
    let lag = |place: usize| sign * (stamps_s[place] - place as f64 * between);
    let place = around.max_by(|a, b| lag(*a).total_cmp(&lag(*b)))? + 1;
    let (first, rest) = stamps_s.split_at(place.min(stamps_s.len()));
    // the mean step of a clock with long ticks is known to two of them
    let by = difference(before, after).min(CHANGED);
    let is_known = |part: &[f64]| part.len() >= BLOCK && by * part.chunk_by(|a, b| a == b).count() as f64 > 2.0;
    if !(is_known(first) && is_known(rest)) {
        return None;
    }
    let (before, after) = (steps_of(first, None)?, steps_of(rest, None)?);
    // samples that are missing at random may look like uneven ones for a while
    let is_lossy = is_lossy(first, before, after) || is_lossy(rest, after, before);
    let are_even = before.unevenness.is_none() && after.unevenness.is_none();
    let are_long = first.len().min(rest.len()) >= BLOCKS_OF_SLIGHT_CHANGE * size;
    let least = if are_even && are_long { SLIGHTLY_CHANGED } else { CHANGED };
    let is_change = !is_lossy && difference(before.period_s, after.period_s) > least;
    is_change.then_some((place, before.period_s, after.period_s))
}

/// Whether uneven samples are those of `others` with some missing.
fn is_lossy(stamps_s: &[f64], steps: Steps, others: Steps) -> bool {
    let steps_s = differences(stamps_s);
    let singles = steps_s.iter().filter(|step_s| (*step_s / others.period_s - 1.0).abs() <= NEAR).count();
    let is_slower = steps.period_s > others.period_s;
    is_slower && steps.unevenness.is_some() && others.unevenness.is_none() && 4 * singles >= steps_s.len()
}

/// The steps of these samples; `None` for fewer than two, or without an even step. `last` are the
/// steps of the samples before.
fn steps_of(stamps_s: &[f64], last: Option<Steps>) -> Option<Steps> {
    let steps_s = differences(stamps_s);
    let uneven = |(period_s, jump_s): (f64, f64)| {
        let (unevenness, tick_s) = unevenness(&steps_s, period_s);
        let tick_s = if unevenness == Unevenness::CoarseClock { tick_s } else { 0.0 };
        Steps { period_s, unevenness: Some(unevenness), jump_s: jump_s.max(tick_s) }
    };
    // a clock that shows this few times has no step that can be seen
    if 12 * equal_stamps(stamps_s) > stamps_s.len().max(8 * BLOCK) {
        return None;
    }
    if let Some(period_s) = pairs(&steps_s) {
        return Some(Steps { period_s, unevenness: Some(Unevenness::Pairs), jump_s: 0.0 });
    }
    let regular = singles(&steps_s);
    if let Some(Some(steps)) = regular {
        return Some(steps);
    }
    let searched_s = &stamps_s[..stamps_s.len().min(SEARCHED)];
    let is_single = |period_s: &f64| {
        2 * steps_s.iter().filter(|step_s| (**step_s / period_s - 1.0).abs() < 0.5).count() >= steps_s.len()
    };
    let common = match last {
        // samples that are missing at random leave no pattern
        _ if regular.is_some() => None,
        Some(last) => {
            last.unevenness.is_none().then_some((resultant(searched_s, last.period_s.recip()), last.period_s))
        }
        None => common_period(searched_s).filter(|(_, period_s)| is_single(period_s)),
    };
    let mean_s = steps_s.iter().sum::<f64>() / steps_s.len() as f64;
    if let Some((_, period_s)) = common.filter(|(length, _)| *length >= LEAST_RESULTANT)
        && !(mean_s > MANY_MISSING * period_s && repeat(&steps_s))
    {
        return Some(Steps { period_s, unevenness: None, jump_s: 0.0 });
    }
    match edge_step(stamps_s).filter(|_| steps_s.len() >= BLOCK) {
        Some(edge) => Some(uneven(edge)),
        None if steps_s.len() < BLOCK || are_balanced(&steps_s, LEAST_BALANCED) => {
            (mean_s > 0.0).then(|| uneven((mean_s, 2.0 * mean_s)))
        }
        None => None,
    }
}

/// Whether this many successive steps always take nearly the same time, as with a clock of few digits
/// for a rate that wanders: samples that are missing at random leave other times.
fn are_balanced(steps_s: &[f64], steps: usize) -> bool {
    let mean_s = steps_s.iter().sum::<f64>() / steps_s.len() as f64;
    let mut times_s: Vec<f64> = steps_s.windows(steps).map(|all| all.iter().sum()).collect();
    times_s.sort_by(f64::total_cmp);
    let between_s =
        |first: usize, last: usize| times_s.get(last).map_or(f64::INFINITY, |last_s| last_s - times_s[first]);
    let (all, tail) = (times_s.len(), times_s.len() / 20);
    // beyond them are pauses, and not another rate
    all > 0 && between_s(tail, 19 * all / 20) <= MOST_UNBALANCED * mean_s && between_s(0, all - 1) <= PAUSE * mean_s
}

/// Whether the steps repeat, each after the same number of others, as with two sources.
fn repeat(steps_s: &[f64]) -> bool {
    let mean_s = steps_s.iter().sum::<f64>() / steps_s.len() as f64;
    let is_same = |pair: &(&f64, &f64)| (pair.0 - pair.1).abs() <= NEAR_REPEATED * mean_s;
    let after = |steps: usize| steps_s.iter().zip(&steps_s[steps.min(steps_s.len())..]).filter(is_same).count();
    (2..=LONGEST_PATTERN).any(|steps| 10 * after(steps) >= 9 * steps_s.len().saturating_sub(steps))
        && 2 * after(1) < steps_s.len()
}

/// The most samples in a row with one stamp.
fn equal_stamps(stamps_s: &[f64]) -> usize {
    stamps_s.chunk_by(|a, b| a == b).map(<[f64]>::len).max().unwrap_or_default()
}

/// The mean step of samples that come in pairs: every other step is shorter, by more than the steps vary.
fn pairs(steps_s: &[f64]) -> Option<f64> {
    let every_other = |first: usize| steps_s.iter().copied().skip(first).step_by(2).collect::<Vec<_>>();
    let (one, other) = (every_other(0), every_other(1));
    let (one_s, other_s) = (median(&one)?, median(&other)?);
    let (period_s, difference_s) = (0.5 * (one_s + other_s), (one_s - other_s).abs());
    let varies =
        |steps_s: &[f64], about_s: f64| median(&steps_s.iter().map(|s| (s - about_s).abs()).collect::<Vec<_>>());
    let variation_s = varies(&one, one_s)?.max(varies(&other, other_s)?);
    // equal stamps belong to a coarse clock
    let equal = steps_s.iter().filter(|step_s| **step_s <= 0.0).count();
    // steps that differ by a tick of a coarse clock come from one that is half a tick longer or shorter;
    // of the ticks of digits both steps are multiples
    let is_multiple = |tick_s: &&f64| (one_s / **tick_s - (one_s / **tick_s).round()).abs() <= ON_TICKS;
    let mut ticks_s = COARSE_TICKS_S.iter().chain(OTHER_TICKS_S.iter().filter(is_multiple));
    let is_clock = ticks_s.any(|tick_s| (difference_s / tick_s - 1.0).abs() < NEAR_SUM);
    let is_rule = difference_s > f64::max(PAIRED * period_s, 3.0 * variation_s) && steps_s.len() >= BLOCK;
    (is_rule && 20 * equal < steps_s.len() && !is_clock).then_some(period_s)
}

/// The steps if single ones are the rule and the others are multiples of them, as caused by missing
/// samples; `Some(None)` if the others have a pattern that no clock explains.
fn singles(steps_s: &[f64]) -> Option<Option<Steps>> {
    let median_s = median(steps_s).filter(|median_s| *median_s > 0.0)?;
    let is_near = |step_s: &&f64| (*step_s / median_s - 1.0).abs() <= NEAR;
    let singles = steps_s.iter().filter(is_near).count();
    let single_s = steps_s.iter().filter(is_near).sum::<f64>() / singles as f64;
    let periods = || steps_s.iter().map(|step_s| step_s / single_s);
    let is_pause = |periods: f64| periods >= PAUSE;
    let kept: Vec<f64> = match 50 * periods().filter(|periods| is_pause(*periods)).count() <= steps_s.len() {
        true => periods().filter(|periods| !is_pause(*periods)).collect(),
        false => periods().collect(),
    };
    let whole = kept.iter().filter(|periods| periods.round() >= 1.0 && (*periods - periods.round()).abs() <= NEAR);
    let mean = kept.iter().sum::<f64>() / kept.len() as f64;
    let is_multiple = 10 * whole.count() >= 9 * kept.len();
    let is_rule = 2 * singles >= steps_s.len() && is_multiple;
    if !is_rule || mean >= MOST_MISSING {
        return None;
    }
    let (every, equally, length) = even_pauses(&kept);
    let whole_s = kept.iter().sum::<f64>() * single_s / kept.iter().map(|periods| periods.round()).sum::<f64>();
    let count = |is: &dyn Fn(f64) -> bool| kept.iter().filter(|periods| is(**periods)).count();
    // after a stall several follow each other
    let alone = |most: f64| kept.windows(2).filter(|pair| pair[1] < most && (SHORT..2.5).contains(&pair[0])).count();
    let are_on_ticks = 20 * count(&|periods| (periods - periods.round()).abs() <= ON_TICKS) >= 19 * kept.len();
    let summed = (IN_A_SUM / (mean - 1.0).abs()).ceil() as usize;
    // lost samples lengthen steps at random and shorten none; a clock repeats ticks about as often, or skips
    // them evenly
    let (repeated, longer) = (count(&|periods| periods <= ON_TICKS), count(&|periods| periods >= 1.5));
    let is_even = || are_balanced(&kept, summed.min(MOST_BALANCED).min(kept.len() / 8).max(LEAST_BALANCED));
    let is_of_clock = alone(ON_TICKS) > 0 && (2 * repeated >= longer || is_even());
    // whole multiples after equal numbers of steps that are no ticks: a sender leaves these samples out
    let is_tick = COARSE_TICKS_S.iter().chain(&OTHER_TICKS_S).any(|tick_s| (single_s / tick_s - 1.0).abs() < NEAR_SUM);
    let are_multiples = |tick_s: &f64| {
        let ticks = kept.iter().map(|periods| periods * single_s / tick_s);
        20 * ticks.filter(|ticks| (ticks - ticks.round()).abs() <= ON_TICKS).count() >= 19 * kept.len()
    };
    let are_left_out = equally && are_on_ticks && !is_tick;
    // uneven stamps are late at times, for long
    let uneven = |unevenness| {
        let period_s = mean * single_s;
        Some(Steps { period_s, unevenness: Some(unevenness), jump_s: period_s })
    };
    Some(match () {
        // a clock whose ticks are about as long as the steps skips one occasionally, or repeats one
        () if are_on_ticks && (is_of_clock || every && length < 2.5) && !are_left_out => {
            uneven(Unevenness::CoarseClock)
        }
        // random losses may be balanced by chance, but are no multiples of these ticks
        () if !are_left_out
            && COARSE_TICKS_S.iter().any(are_multiples)
            && summed <= MOST_BALANCED.min(kept.len() / 8)
            && are_balanced(&kept, summed.max(LEAST_BALANCED)) =>
        {
            uneven(Unevenness::CoarseClock)
        }
        () if 50 * alone(SHORT) > kept.len() => uneven(Unevenness::Irregular),
        () if every && !are_left_out => None,
        () => Some(Steps { period_s: whole_s, unevenness: None, jump_s: 0.0 }),
    })
}

/// Whether other steps come after equal numbers of single ones, as for reads of a buffer, or numbers
/// that change slowly; whether the numbers are equal; and the length of such a step in single ones.
fn even_pauses(periods: &[f64]) -> (bool, bool, f64) {
    let other: Vec<usize> = (0..periods.len()).filter(|place| (periods[*place] - 1.0).abs() > NEAR).collect();
    let between: Vec<f64> = other.windows(2).map(|pair| (pair[1] - pair[0]) as f64).collect();
    let lengths: Vec<f64> = other.iter().map(|place| periods[*place]).collect();
    let (Some(middle), Some(length)) = (median(&between), median(&lengths)) else { return (false, false, 0.0) };
    // a few numbers are about even by chance
    let near = if between.len() < FEW_PAUSES { ON_TICKS } else { NEAR };
    let is_even = |run: &&[f64]| (run[1] - 0.5 * (run[0] + run[2])).abs() <= f64::max(1.0, near * run[1]);
    let even = between.windows(3).filter(is_even).count();
    let equal = between.iter().filter(|other| **other == middle).count();
    let is_even = between.len() >= 4 && middle >= 2.0 && 10 * even >= 9 * (between.len() - 2);
    // steps of one and two in turn, at times one more of one, are those of a clock with ticks of two thirds
    // of a step; a lost sample makes a step of three
    let are_ticks = middle == 2.0 && equal < between.len() && lengths.iter().all(|other| other.round() == 2.0);
    (is_even, is_even && 10 * equal >= 9 * between.len() && !are_ticks, length)
}

/// The step by which the lower edge rises, and its variation; `None` if it does not rise evenly.
fn edge_step(stamps_s: &[f64]) -> Option<(f64, f64)> {
    let near_s = (stamps_s.last()? - stamps_s.first()?) / (stamps_s.len() - 1) as f64;
    // at least as many as have one stamp, for the first of them to be among each block
    let block = BLOCK.max(equal_stamps(stamps_s)).min(stamps_s.len() / 8).max(1);
    let lag_s = |place: usize| stamps_s[place] - place as f64 * near_s;
    let earliest = |start: usize| (start..start + block).min_by(|a, b| lag_s(*a).total_cmp(&lag_s(*b)));
    let points: Vec<usize> = (0..stamps_s.len() / block).filter_map(|number| earliest(number * block)).collect();
    let rises = || points.windows(2).map(|pair| (pair[1] - pair[0], stamps_s[pair[1]] - stamps_s[pair[0]]));
    let slopes: Vec<f64> = rises().map(|(samples, rise_s)| rise_s / samples as f64).collect();
    let slope_s = median(&slopes).filter(|slope_s| *slope_s > 0.0)?;
    let positive: Vec<f64> = differences(stamps_s).into_iter().filter(|step_s| *step_s > 0.0).collect();
    let tick_s = median(&positive)?;
    // a coarse clock moves the edge by a tick
    let tick = 1.2 * tick_s / slope_s;
    let off = |(samples, rise_s): (usize, f64)| rise_s / slope_s - samples as f64;
    let spread = median(&rises().map(|rise| off(rise).abs()).collect::<Vec<_>>())?;
    let even: Vec<(usize, f64)> =
        rises().filter(|rise| off(*rise).abs() < f64::max(1.0, OUTLIER * spread).max(tick)).collect();
    let (samples, rise_s) = even.iter().fold((0, 0.0), |sum, rise| (sum.0 + rise.0, sum.1 + rise.1));
    // an edge that varies returns, and missing samples raise it permanently
    let far: f64 = even
        .iter()
        .scan(0.0, |sum, rise| {
            *sum += off(*rise);
            Some(*sum)
        })
        .fold(0.0, |most, sum: f64| most.max(sum.abs()));
    let is_even = 3 * even.len() >= 2 * slopes.len()
        && spread < MOST_SPREAD
        && far < f64::max(1.5, RETURNS * spread).max(2.0 * tick);
    is_even.then(|| (rise_s / samples as f64, RETURNS * spread * slope_s))
}

/// The unevenness of these steps, and the usual step that is not zero.
fn unevenness(steps_s: &[f64], period_s: f64) -> (Unevenness, f64) {
    let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
    let positive: Vec<f64> = steps_s.iter().copied().filter(|step_s| *step_s > 0.0).collect();
    let tick_s = median(&positive).unwrap_or(period_s);
    let on_ticks = positive.iter().filter(|step_s| (*step_s / tick_s - (*step_s / tick_s).round()).abs() < 0.1).count();
    let close = steps_s.iter().filter(|step_s| **step_s < SHORT * period_s).count();
    let unevenness = match () {
        () if tick_s > 0.7 * period_s && share(on_ticks, positive.len()) > 0.9 => Unevenness::CoarseClock,
        () if share(close, steps_s.len()) > 0.45 => Unevenness::Bursts,
        () => Unevenness::Irregular,
    };
    (unevenness, tick_s)
}

/// The period, between the mean step and the part of it that missing samples leave at least, for which
/// all stamps are multiples, with any missing and slightly late samples; with the resultant length.
fn common_period(stamps_s: &[f64]) -> Option<(f64, f64)> {
    let span_s = stamps_s.last()? - stamps_s.first()?;
    let mean_hz = (stamps_s.len() - 1) as f64 / span_s;
    let step_hz = 0.25 / span_s;
    if !mean_hz.is_normal() {
        return None;
    }
    let with_length = |hz: f64| (resultant(stamps_s, hz), hz);
    let lowest_hz = mean_hz - 8.0 * step_hz;
    let candidates = ((MOST_MISSING * mean_hz - lowest_hz) / step_hz) as u32;
    let all: Vec<_> = (0..candidates).map(|index| with_length(lowest_hz + f64::from(index) * step_hz)).collect();
    let longest = all.iter().map(|(length, _)| *length).fold(0.0, f64::max);
    // multiples of the rate, and sums with that of the digits of the stamps, fit about as well
    let (_, near_hz) = *all.iter().find(|(length, _)| *length >= AS_LONG * longest)?;
    let fine = (0..41).map(|index| with_length(near_hz + (f64::from(index) - 20.0) * 0.1 * step_hz));
    let (length, hz) = fine.max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some((length, hz.recip()))
}

/// Length of the mean of the stamps as angles of a frequency (Mardia and Jupp, *Directional
/// Statistics*, 2000, section 3.4.1).
pub(super) fn resultant(stamps_s: &[f64], hz: f64) -> f64 {
    let origin_s = stamps_s.first().copied().unwrap_or_default();
    let (mut cosines, mut sines) = (0.0, 0.0);
    for at_s in stamps_s {
        let (sine, cosine) = (TAU * ((at_s - origin_s) * hz).fract()).sin_cos();
        cosines += cosine;
        sines += sine;
    }
    f64::hypot(cosines, sines) / stamps_s.len() as f64
}

fn differences(values: &[f64]) -> Vec<f64> {
    values.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

/// The lower median; `None` without values.
fn median(values: &[f64]) -> Option<f64> {
    let mut values = values.to_vec();
    let middle = values.len().checked_sub(1)? / 2;
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stamps of 1 000 samples of 10 ms, without those in these places.
    fn stamps_without(missing: &[usize]) -> Vec<f64> {
        (0..1_000).filter(|place| !missing.contains(place)).map(|place| 0.01 * place as f64).collect()
    }

    #[test]
    fn an_edge_that_missing_samples_raise_again_and_again_gives_no_step() {
        let (step_s, variation_s) = edge_step(&stamps_without(&[500])).unwrap();
        assert!((step_s - 0.01).abs() < 0.000_02 && variation_s < 1e-6, "{step_s} {variation_s}");
        assert_eq!(edge_step(&stamps_without(&[200, 500, 800])), None);
    }

    #[test]
    fn multiples_of_a_period_have_a_resultant_of_one() {
        let stamps_s = stamps_without(&[200, 500, 501, 800]);
        assert!((resultant(&stamps_s, 100.0) - 1.0).abs() < 1e-9);
        assert!(resultant(&stamps_s, 117.3) < 0.01);
        // two sources in turn, half a period apart
        let halves: Vec<f64> = (0..1_000).map(|place| 0.005 * f64::from(place)).collect();
        assert!(resultant(&halves, 100.0) < 1e-9);
    }

    #[test]
    fn steps_that_a_clock_repeats_and_skips_are_balanced_and_losses_are_not() {
        let of_clock: Vec<f64> = (0..200).map(|place| [1.0, 0.0, 2.0, 1.0][place % 4]).collect();
        assert!(are_balanced(&of_clock, 8));
        let of_losses: Vec<f64> = (0..200).map(|place| if place % 37 < 4 { 2.0 } else { 1.0 }).collect();
        assert!(!are_balanced(&of_losses, 8));
    }
}
