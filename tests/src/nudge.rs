//! When two answers to one ray may differ: the rule of the nudge.
//!
//! A ray that touches an edge has no stable answer in finite arithmetic. So an answer that
//! differs from the oracle's is excused if, and only if, the oracle itself gives that answer to
//! some ray turned by at most 2e-6 radian. Everything else is an error of the method.

use glam::DVec3;

/// Largest turn of the direction, in radian.
pub const NUDGE: f64 = 2e-6;

/// Directions tried on each cone around the ray.
const TURNS: u32 = 16;

/// Cones tried, of half, a quarter ... of the largest turn.
const CONES: i32 = 8;

/// `direction`, turned by at most [`NUDGE`] in many ways; its length changes by 1e-12 at most.
pub fn nudged(direction: DVec3) -> impl Iterator<Item = DVec3> {
    let (a, b) = direction.normalize().any_orthonormal_pair();
    let length = direction.length();
    (0..CONES).flat_map(move |cone| {
        let radius = length * NUDGE * 0.5f64.powi(cone);
        (0..TURNS).map(move |turn| {
            let angle = f64::from(turn) / f64::from(TURNS) * std::f64::consts::TAU;
            direction + radius * (angle.cos() * a + angle.sin() * b)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nudges_turn_by_no_more_than_they_may() {
        let direction = DVec3::new(3.0, -4.0, 12.0);
        let mut largest = 0.0f64;
        for turned in nudged(direction) {
            largest = largest.max(direction.cross(turned).length() / (13.0 * 13.0));
        }
        assert!(largest <= NUDGE * 1.000_001 && largest > 0.99 * NUDGE);
    }
}
