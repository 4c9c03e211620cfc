//! When two answers to one ray may differ: the rule of the nudge.
//!
//! A ray that touches an edge, or glides along a surface, has no stable answer in finite
//! arithmetic. So an answer that differs from the oracle's is excused if, and only if, the oracle
//! itself gives that answer to some ray turned by at most 2e-6 radian. Everything else is an error
//! of the method.

use glam::DVec3;

/// Largest turn of the direction, in radian.
pub const NUDGE: f64 = 2e-6;

/// Directions tried on each cone. Where a ray touches a sample between steep cells, those that
/// give the other answer may fill a narrow sector only.
const TURNS: u32 = 64;

/// Directions within [`NUDGE`] of `direction` and of its length: the one towards the point
/// `answer` (as seen from the ray's origin) and cones around it, if that is near enough, then
/// cones around `direction`, then fine steps exactly up and down along `normal`.
pub fn nudged(
    direction: DVec3,
    answer: Option<DVec3>,
    normal: DVec3,
) -> impl Iterator<Item = DVec3> {
    let length = direction.length();
    let towards = answer.and_then(DVec3::try_normalize).map(|unit| unit * length);
    let aimed = towards.into_iter().flat_map(move |centre| {
        std::iter::once(centre)
            .chain((3..20).flat_map(move |k| cone(centre, normal, NUDGE * 0.5f64.powi(k))))
    });
    let near = move |turned: &DVec3| {
        direction.cross(*turned).length() <= NUDGE * length * length && direction.dot(*turned) > 0.0
    };
    let around = (0..8).flat_map(move |k| cone(direction, normal, NUDGE * 0.999 * 0.5f64.powi(k)));
    // Gliding along a surface the answer runs away fast: fine steps up and down.
    let fine = (0..80).flat_map(move |k| {
        let angle = NUDGE * 0.999 * 0.88f64.powi(k);
        [-angle, angle].into_iter().filter_map(move |a| cone(direction, normal, a).next())
    });
    aimed.chain(around).chain(fine).filter(near)
}

/// Directions turned from `axis` by `angle`, a small one; the first of them towards `normal`.
fn cone(axis: DVec3, normal: DVec3, angle: f64) -> impl Iterator<Item = DVec3> {
    let unit = axis.normalize();
    let a = normal.reject_from(unit).try_normalize().unwrap_or(unit.any_orthonormal_vector());
    let b = unit.cross(a);
    let radius = axis.length() * angle;
    (0..TURNS).map(move |turn| {
        let at = f64::from(turn) / f64::from(TURNS) * std::f64::consts::TAU;
        axis + radius * (at.cos() * a + at.sin() * b)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nudges_turn_by_no_more_than_they_may() {
        let direction = DVec3::new(3.0, -4.0, 12.0);
        let near = direction * 0.2 + DVec3::new(2e-6, 1e-6, 0.0);
        for (answer, least) in [(None, 500), (Some(near), 900), (Some(DVec3::X), 500)] {
            let mut largest = 0.0f64;
            let mut count = 0;
            for turned in nudged(direction, answer, DVec3::Z) {
                largest = largest.max(direction.cross(turned).length() / (13.0 * 13.0));
                count += 1;
            }
            assert!(largest <= NUDGE && largest > 0.99 * NUDGE && count >= least);
        }
        let first = nudged(direction, Some(near), DVec3::Z).next().unwrap();
        assert!(first.cross(near).length() < 1e-13 * first.length());
    }
}
