//! The window on `[-1, 1]`, in one dimension.

use std::f64::consts::PI;

use super::solve;

const TERMS: [f64; 4] = [0.35875, 0.48829, 0.14128, 0.01168];

pub fn value(x: f64) -> f64 {
    if x.abs() > 1.0 {
        return 0.0;
    }
    let waves = TERMS.iter().enumerate();
    waves.map(|(k, a)| a * (PI * k as f64 * x).cos()).sum::<f64>() / (2.0 * TERMS[0])
}

/// Mass from 0 to `x`, and the value there, by the recurrence of Chebyshev.
fn mass(x: f64) -> (f64, f64) {
    let (sin, cos) = (PI * x).sin_cos();
    let (sin2, cos2) = (2.0 * sin * cos, 2.0 * cos * cos - 1.0);
    let (sin3, cos3) = (sin * cos2 + cos * sin2, cos * cos2 - sin * sin2);
    let [a, b, c, d] = TERMS;
    let mass = a * x + (b * sin + c * sin2 / 2.0 + d * sin3 / 3.0) / PI;
    (mass / (2.0 * a), (a + b * cos + c * cos2 + d * cos3) / (2.0 * a))
}

pub fn sample(u: f64) -> f64 {
    let (sign, u) = if u < 0.5 { (-1.0, 1.0 - 2.0 * u) } else { (1.0, 2.0 * u - 1.0) };
    sign * solve(mass, [0.0, 1.0], 0.5 * u)
}
