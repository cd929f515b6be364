//! The cells: which noise is measured, and what of it is true.

use std::f64::consts::{LN_2, PI};

use super::generators::{Drift, Loss, Part, White};
use crate::RATE_HZ;

pub(crate) struct Family {
    pub(crate) name: &'static str,
    pub(crate) cells: Vec<Cell>,
}

/// One kind of noise, of white standard deviation 1.
#[derive(Clone)]
pub(crate) struct Cell {
    pub(crate) name: String,
    pub(crate) duration_s: f64,
    pub(crate) rate_hz: f64,
    pub(crate) white: White,
    pub(crate) parts: Vec<Part>,
    pub(crate) loss: Option<Loss>,
    /// One count.
    pub(crate) step: f64,
    /// The averaging window that register 85 has; `None` where nobody asked.
    pub(crate) known_window: Option<u32>,
}

/// The parameters of a cell, in its unit and seconds.
pub(crate) struct Truth {
    pub(crate) white: f64,
    pub(crate) bias_instability: f64,
    pub(crate) walk: f64,
    pub(crate) ramp: f64,
    /// Whether the model has a place for what adds at long averaging times.
    pub(crate) is_of_model: bool,
}

impl Cell {
    fn new(name: impl Into<String>, duration_s: f64, parts: &[Part]) -> Self {
        Self {
            name: name.into(),
            duration_s,
            rate_hz: RATE_HZ,
            white: White::Gaussian,
            parts: parts.to_vec(),
            loss: None,
            step: 0.01,
            known_window: Some(4),
        }
    }

    pub(crate) fn samples(&self) -> usize {
        (self.duration_s * self.rate_hz) as usize
    }

    pub(crate) fn truth(&self) -> Truth {
        let interval_s = 1.0 / self.rate_hz;
        let variance = self.white.variance();
        // of more than a standard deviation a step shows no noise: its own is not the sensor's
        let is_dithered = variance > 0.0 && self.step <= 1.0;
        let rounding = if is_dithered { self.step * self.step / 12.0 } else { 0.0 };
        let mut truth = Truth {
            white: ((variance + rounding) * interval_s).sqrt(),
            bias_instability: 0.0,
            walk: 0.0,
            ramp: 0.0,
            is_of_model: true,
        };
        for part in &self.parts {
            match part {
                Part::Flicker(b) => truth.bias_instability = *b,
                Part::Walk(step) => truth.walk = step / interval_s.sqrt(),
                Part::Ramp(total) => truth.ramp = total / self.duration_s,
                Part::GaussMarkov { .. } | Part::Popcorn { .. } | Part::Resonance { .. } => truth.is_of_model = false,
                Part::Line { .. } | Part::Cycle { .. } | Part::WarmUp { .. } => {}
            }
        }
        truth
    }
}

/// Flicker noise whose Allan variance is that of the white part at `tau_s`.
fn flicker_crossing(tau_s: f64) -> Part {
    Part::Flicker((1.0 / RATE_HZ / tau_s / (2.0 * LN_2 / PI)).sqrt())
}

/// A random walk, likewise.
fn walk_crossing(tau_s: f64) -> Part {
    Part::Walk(3_f64.sqrt() / (RATE_HZ * tau_s))
}

const fn line(hz: f64, share: f64) -> Part {
    Part::Line { hz, share, drift: Drift::None }
}

/// All cells at this length of the record.
pub(crate) fn all(duration_s: f64) -> Vec<Family> {
    let cells = Cells { duration_s, flicker: flicker_crossing(5.0), walk: walk_crossing(duration_s / 30.0) };
    vec![
        Family { name: "model-class", cells: cells.model_class() },
        Family { name: "lines", cells: cells.lines() },
        Family { name: "correlated", cells: cells.correlated() },
        Family { name: "filters", cells: cells.filters() },
        Family { name: "tails", cells: cells.tails() },
        Family { name: "mixtures", cells: cells.mixtures() },
        Family { name: "gaps", cells: cells.gaps() },
        Family { name: "quantised", cells: cells.quantised() },
    ]
}

/// The noise beside what follows the temperature.
pub(crate) fn beside_temperature(duration_s: f64) -> Vec<Cell> {
    let (flicker, walk) = (flicker_crossing(5.0), walk_crossing(duration_s / 30.0));
    vec![
        Cell::new("white", duration_s, &[]),
        Cell::new("white + flicker", duration_s, &[flicker]),
        Cell::new("white + walk", duration_s, &[walk]),
        Cell::new("white + flicker + walk", duration_s, &[flicker, walk]),
    ]
}

/// The noise beneath what [`disturbances`](super::disturbances) are searched in.
pub(crate) fn disturbed(duration_s: f64) -> Cell {
    Cell::new("disturbed", duration_s, &[flicker_crossing(5.0)])
}

/// White noise alone; its length is for the caller to set.
pub(crate) fn clean() -> Cell {
    Cell::new("white", 1.0, &[])
}

/// White noise with a walk; likewise.
pub(crate) fn walking() -> Cell {
    Cell::new("white and walk", 1.0, &[walk_crossing(60.0)])
}

/// White noise with a walk and flicker noise; likewise.
pub(crate) fn walking_beside_flicker() -> Cell {
    Cell::new("white, flicker and walk", 1.0, &[flicker_crossing(20.0), walk_crossing(60.0)])
}

struct Cells {
    duration_s: f64,
    /// That of most cells.
    flicker: Part,
    walk: Part,
}

impl Cells {
    fn cell(&self, name: impl Into<String>, parts: &[Part]) -> Cell {
        Cell::new(name, self.duration_s, parts)
    }

    fn model_class(&self) -> Vec<Cell> {
        let duration_s = self.duration_s;
        let alone = |name, part| Cell { white: White::None, ..self.cell(name, &[part]) };
        vec![
            self.cell("white", &[]),
            self.cell("flicker 5 s", &[self.flicker]),
            self.cell("flicker T/30", &[flicker_crossing(duration_s / 30.0)]),
            self.cell("flicker T/20", &[flicker_crossing(duration_s / 20.0)]),
            self.cell("walk 5 s", &[walk_crossing(5.0)]),
            self.cell("walk T/30", &[self.walk]),
            self.cell("walk T/10", &[walk_crossing(duration_s / 10.0)]),
            self.cell("flicker 5 s, walk T/30", &[self.flicker, self.walk]),
            alone("pure flicker", Part::Flicker(1.0)),
            alone("pure walk", Part::Walk(1.0)),
            self.cell("ramp of 1 sd", &[Part::Ramp(1.0)]),
        ]
    }

    fn lines(&self) -> Vec<Cell> {
        let with = |name: String, lines: &[Part]| self.cell(name, &[&[self.flicker], lines].concat());
        let mut cells = Vec::new();
        for hz in [0.2, 0.53, 3.0, 7.93, 18.4, 43.3] {
            for share in [0.01, 0.06, 0.2, 0.5] {
                cells.push(with(format!("{hz} Hz, {:.0} %", 100.0 * share), &[line(hz, share)]));
            }
        }
        cells.push(with("0.53 and 7.93 Hz, 6 % each".into(), &[line(0.53, 0.06), line(7.93, 0.06)]));
        for (name, drift) in [("drifting by 2 %", Drift::Once(0.02)), ("swept over a tenth", Drift::Swept(0.1))] {
            for share in [0.06, 0.2] {
                let name = format!("7.93 Hz {name}, {:.0} %", 100.0 * share);
                cells.push(with(name, &[Part::Line { hz: 7.93, share, drift }]));
            }
        }
        cells
    }

    fn correlated(&self) -> Vec<Cell> {
        let pairs = [0.5, 5.0, 20.0, 100.0]
            .into_iter()
            .flat_map(|time_s| [0.05, 0.1, 0.2, 0.5].map(|deviation| (time_s, deviation)));
        let processes = pairs.map(|(time_s, deviation)| {
            self.cell(format!("{time_s} s, {deviation} sd"), &[Part::GaussMarkov { time_s, deviation }])
        });
        let popcorn = [20.0, 60.0].into_iter().flat_map(|dwell_s| [0.1, 0.3].map(|deviation| (dwell_s, deviation)));
        let popcorn = popcorn.map(|(dwell_s, deviation)| {
            self.cell(format!("popcorn {dwell_s} s, {deviation} sd"), &[Part::Popcorn { dwell_s, deviation }])
        });
        processes.chain(popcorn).collect()
    }

    fn filters(&self) -> Vec<Cell> {
        let mut cells = Vec::new();
        for (name, is_known) in [("known", true), ("unknown", false)] {
            for length in [1, 4, 10, 20, 24, 30, 40, 80] {
                let cell = self.cell(format!("window {length}, {name}"), &[]);
                let known_window = is_known.then_some(length);
                cells.push(Cell { white: White::Window(length), known_window, ..cell });
            }
        }
        for order in [1, 2] {
            for corner in [0.1, 0.3] {
                let cell = self.cell(format!("low pass of order {order} at {corner} of the rate"), &[]);
                cells.push(Cell { white: White::LowPass { order, corner }, ..cell });
            }
        }
        let cell = self.cell("800 Hz, low pass at 256 Hz, window 4 known", &[]);
        cells.push(Cell { white: White::EveryRefresh, rate_hz: 800.0, ..cell });
        cells
    }

    fn tails(&self) -> Vec<Cell> {
        let spikes = |probability| White::Spikes { probability, height: 8.0 };
        let whites = [
            ("Student t5", White::Student5),
            ("Laplace", White::Laplace),
            ("0.1 % spikes of 8 sd", spikes(0.001)),
            ("20 spikes of 8 sd an hour", spikes(20.0 / 3600.0 / RATE_HZ)),
        ];
        whites.into_iter().map(|(name, white)| Cell { white, ..self.cell(name, &[]) }).collect()
    }

    fn mixtures(&self) -> Vec<Cell> {
        let line = line(7.93, 0.06);
        let correlated = Part::GaussMarkov { time_s: 5.0, deviation: 0.2 };
        let window = White::Window(80);
        let cycle = Part::Cycle { period_s: 400.0, deviation: 0.3 };
        vec![
            self.cell("Gauss-Markov 5 s 0.2 sd, line of 6 %", &[correlated, line]),
            Cell {
                white: White::LowPass { order: 2, corner: 0.3 },
                ..self.cell("line of 6 %, low pass of order 2 at 0.3", &[line])
            },
            Cell { white: window, known_window: Some(80), ..self.cell("flicker, window 80 known", &[self.flicker]) },
            Cell { white: window, known_window: None, ..self.cell("flicker, window 80 unknown", &[self.flicker]) },
            self.cell("walk T/30, line of 6 %", &[self.walk, line]),
            self.cell("flicker, temperature cycle of 400 s and 0.3 sd", &[self.flicker, cycle]),
        ]
    }

    fn gaps(&self) -> Vec<Cell> {
        let mut cells = Vec::new();
        for (noise, part) in [("flicker 5 s", self.flicker), ("walk T/30", self.walk)] {
            for share in [0.01, 0.1, 0.3] {
                for (name, loss) in [("random", Loss::Random(share)), ("bunched", Loss::Bunched(share))] {
                    let cell = self.cell(format!("{noise}, {:.0} % lost, {name}", 100.0 * share), &[part]);
                    cells.push(Cell { loss: Some(loss), ..cell });
                }
            }
        }
        cells
    }

    fn quantised(&self) -> Vec<Cell> {
        let steps = [0.2, 0.5, 1.0, 4.0].into_iter();
        steps.map(|step| Cell { step, ..self.cell(format!("step of {step} sd"), &[self.flicker]) }).collect()
    }
}
