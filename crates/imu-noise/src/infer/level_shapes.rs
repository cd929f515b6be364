//! Shapes that the level of a channel may have: relaxations, steps, a ramp, cycles.

use core::f64::consts::PI;

/// Blocks at either end in which a step is not sought: a few blocks do not make a level.
const STEP_MARGIN: usize = 4;

/// Quarters of cycles in a record that are examined: all of them from one cycle to three, and from
/// there to the most cycles per block every other one.
const FEWEST_QUARTERS: usize = 4;
const FEW_QUARTERS: usize = 12;
pub(super) const MOST_PER_BLOCK: f64 = 0.4;

/// A shape of the level, in blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BlockShape {
    /// exp(-t/time constant) from the start of the first block on.
    Relaxation(f64),
    /// 0 before this time, 1 from it on.
    Step(f64),
    /// A straight line, from 0 to 1.
    Ramp,
    /// A sine of this frequency in cycles per block, with amplitude 1 and any phase.
    Cycle(f64),
}

/// So few cycles in a record that all quarters of them are examined.
pub(super) fn is_few(cycles: f64) -> bool {
    4.0 * cycles < FEW_QUARTERS as f64 - 0.5
}

#[derive(Clone, Debug)]
pub(super) struct Shaped {
    pub(super) shape: BlockShape,
    pub(super) levels: Levels,
}

/// A shape, by block.
#[derive(Clone, Debug)]
pub(super) enum Levels {
    /// Of every block.
    Each(Vec<f64>),
    /// 1 behind this block, and this much in it.
    Behind(usize, f64),
    /// A cosine and a sine about the middle, of the first half.
    Cycle(Vec<f64>, Vec<f64>),
}

/// What the weighted coefficients of a series are by block: a shape's product with it is that of
/// the coefficients.
#[derive(Default)]
pub(super) struct Weighted {
    pub(super) each: Vec<f64>,
    /// Sums of this block and all behind it.
    pub(super) behind: Vec<f64>,
    /// By block of the first half: symmetric and antisymmetric part.
    pub(super) symmetric: Vec<f64>,
    pub(super) antisymmetric: Vec<f64>,
}

impl Shaped {
    /// With a series by block; of a cycle those of the cosine and of the sine.
    #[inline(always)]
    pub(super) fn products(&self, series: &Weighted) -> [f64; 2] {
        match &self.levels {
            Levels::Each(values) => [dot(values, &series.each), 0.0],
            Levels::Behind(at, part) => [series.behind[*at] - (1.0 - part) * series.each[*at], 0.0],
            Levels::Cycle(cosine, sine) => [dot(cosine, &series.symmetric), dot(sine, &series.antisymmetric)],
        }
    }
}

/// Four times the cycles of a record that are examined: so the angles from its middle on are whole
/// steps of the table.
fn quarters_of_cycles(blocks: usize) -> impl Iterator<Item = usize> {
    let most = (4.0 * MOST_PER_BLOCK * blocks as f64) as usize;
    (FEWEST_QUARTERS..=most).filter(|quarters| *quarters < FEW_QUARTERS || quarters.is_multiple_of(2))
}

/// cos(πi/4n) for a whole turn, n blocks.
pub(super) fn cosine_table(blocks: usize) -> Vec<f64> {
    (0..8 * blocks).map(|i| (PI * i as f64 / (4 * blocks) as f64).cos()).collect()
}

/// `table`: that of cosines.
pub(super) fn shapes(blocks: usize, table: &[f64]) -> Vec<Shaped> {
    let each = |value: &dyn Fn(f64) -> f64| Levels::Each((0..blocks).map(|i| value(i as f64)).collect());
    let mut shapes = Vec::new();
    // means over blocks
    let relaxation = |time: f64| each(&|i| (-i / time).exp() * time * -(-1.0 / time).exp_m1());
    let times = (0..).map(|k| f64::from(1 << k)).take_while(|time| *time <= blocks as f64);
    shapes.extend(times.map(|time| Shaped { shape: BlockShape::Relaxation(time), levels: relaxation(time) }));
    shapes.push(Shaped { shape: BlockShape::Ramp, levels: each(&|i| i / blocks as f64) });
    for block in (STEP_MARGIN..=blocks - STEP_MARGIN).rev() {
        let step = |at, part| Shaped { shape: BlockShape::Step(at), levels: Levels::Behind(block, part) };
        shapes.push(step(block as f64 + 0.5, 0.5));
        shapes.push(step(block as f64, 1.0));
    }
    for quarters in quarters_of_cycles(blocks) {
        let steps = (0..blocks.div_ceil(2)).map(|i| quarters * (blocks - 1 - 2 * i));
        let cosine = steps.clone().map(|step| table[step % table.len()]).collect();
        // before the middle; a quarter of a turn is 2n steps
        let sine = steps.map(|step| -table[(step + 6 * blocks) % table.len()]).collect();
        let shape = BlockShape::Cycle(quarters as f64 / 4.0 / blocks as f64);
        shapes.push(Shaped { shape, levels: Levels::Cycle(cosine, sine) });
    }
    shapes
}

/// In lanes of four, whatever the order of a plain sum.
#[inline(always)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (a, a_rest) = a.as_chunks::<4>();
    let (b, b_rest) = b.as_chunks::<4>();
    for (a, b) in a.iter().zip(b) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += a * b;
        }
    }
    lanes.iter().sum::<f64>() + a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum::<f64>()
}
