//! The limit of a parameter: where a log-likelihood has fallen by a given drop.

/// Steps towards a limit, and how near to it, relative.
const STEPS: usize = 7;
const NEAR: f64 = 0.02;

/// The distance at which the log-likelihood has fallen by `drop`, whose root rises about evenly.
pub(super) fn crossing(drop: f64, deviation: f64, fall: impl Fn(f64) -> f64) -> f64 {
    let target = (2.0 * drop).sqrt();
    let mut distance = target * deviation;
    if !distance.is_finite() {
        return f64::INFINITY;
    }
    let (mut low, mut high) = (0.0, f64::INFINITY);
    for _ in 0..STEPS {
        let reached = (2.0 * fall(distance).max(0.0)).sqrt();
        if (reached / target - 1.0).abs() < NEAR {
            break;
        }
        if reached < target {
            low = distance
        } else {
            high = distance
        }
        let next = distance * (target / reached).clamp(0.3, 3.0);
        distance = if next > low && next < high { next } else { 0.5 * (low + high.min(2.0 * low + distance)) };
    }
    distance
}
