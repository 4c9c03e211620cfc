//! The cubic of radius 2 with B = C = 1/3, in one dimension.

use glam::DVec2;

use super::solve;

/// Where it changes its sign: the root of `7 x^3 - 36 x^2 + 60 x - 32` above 1, which is 8/7.
const ZERO: f64 = 8.0 / 7.0;

/// Mass between 0 and [`ZERO`]; beyond it the mass is half less this.
const MAIN: f64 = 0.5 + LOBE;

/// Absolute mass of one negative lobe: `(6/7)^3 / 36`.
const LOBE: f64 = 6.0 / 343.0;

/// Share of the plane's absolute mass that is negative.
pub const NEGATIVE: f64 = NEGATIVE_MASS / (POSITIVE_MASS + NEGATIVE_MASS);
const POSITIVE_MASS: f64 = 4.0 * (MAIN * MAIN + LOBE * LOBE);
const NEGATIVE_MASS: f64 = 8.0 * MAIN * LOBE;

pub fn value(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        (21.0 * x - 36.0) * x * x / 18.0 + 16.0 / 18.0
    } else if x < 2.0 {
        // -7/18 (x - 2)^2 (x - 8/7)
        -7.0 / 18.0 * (x - 2.0) * (x - 2.0) * (x - ZERO)
    } else {
        0.0
    }
}

/// Mass from 0 to `x` in `[0, 2]`.
fn mass(x: f64) -> f64 {
    if x < 1.0 {
        ((5.25 * x - 12.0) * x * x + 16.0) * x / 18.0
    } else {
        // With y = 2 - x: y^2 (y - 6/7) 7/18, integrated from y to 1, after the mass up to 1.
        let y = 2.0 - x;
        let tail = |y: f64| 7.0 / 18.0 * y * y * y * (0.25 * y - 2.0 / 7.0);
        9.25 / 18.0 + tail(1.0) - tail(y)
    }
}

/// A place in the plane, distributed as one of the parts of the product.
pub fn sample(negative: bool, u: DVec2) -> DVec2 {
    // Each axis is either in the main part or in a lobe: which, and what is left of u.x.
    let (in_lobe, x) = if negative {
        let half = u.x >= 0.5;
        ([half, !half], 2.0 * u.x - f64::from(half))
    } else {
        let main = MAIN * MAIN / (MAIN * MAIN + LOBE * LOBE);
        let lobes = u.x >= main;
        ([lobes; 2], if lobes { (u.x - main) / (1.0 - main) } else { u.x / main })
    };
    let [a, b] = [(in_lobe[0], x), (in_lobe[1], u.y)].map(|(lobe, u)| along(lobe, u));
    DVec2::new(a, b)
}

/// A place on a line, in the main part or in one of the two lobes.
fn along(lobe: bool, u: f64) -> f64 {
    let (sign, u) = if u < 0.5 { (-1.0, 1.0 - 2.0 * u) } else { (1.0, 2.0 * u - 1.0) };
    let place = if lobe {
        solve(|x| (-mass(x), -value(x)), [ZERO, 2.0], LOBE * u - MAIN)
    } else {
        solve(|x| (mass(x), value(x)), [0.0, ZERO], MAIN * u)
    };
    sign * place
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_are_those_of_the_curve() {
        assert!(value(ZERO).abs() < 1e-15 && (mass(2.0) - 0.5).abs() < 1e-15);
        assert!((mass(ZERO) - MAIN).abs() < 1e-15, "{}", mass(ZERO) - 0.5);
        assert!((value(1.0) - 1.0 / 18.0).abs() < 1e-15 && (mass(1.0) - 9.25 / 18.0).abs() < 1e-15);
        assert!((POSITIVE_MASS - NEGATIVE_MASS - 1.0).abs() < 1e-14);
    }
}
