//! What the judge says of an answer.

use glam::DVec3;
use rilievo::{Hit, Ray};

use super::MeshOracle;
use crate::nudge;

/// What the judge says of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is the judge's own, to rounding.
    Equal,
    /// It is the judge's own for a ray a nudge away.
    Excused,
    /// It is neither.
    Wrong,
}

impl MeshOracle<'_> {
    /// What to think of the nearest hit that was found along a ray, of distances equal to `near`. `cells` hold all
    /// that the ray may meet.
    pub fn judge(
        &self,
        ray: &Ray,
        cells: &[(u32, [i32; 2])],
        found: Option<&Hit>,
        near: f64,
    ) -> Verdict {
        let near = near / ray.direction.length();
        let t = found.map(|hit| hit.t);
        let first = |crossings: Vec<f64>| {
            crossings.into_iter().find(|&t| t >= 0.0).filter(|&t| t <= ray.t_max)
        };
        if agree(first(self.crossings_among(ray, cells)), t, near) {
            return Verdict::Equal;
        }
        let answer = found.map(|hit| hit.position - ray.origin);
        let normal = found.map_or(DVec3::Z, |hit| hit.geometric_normal);
        let excused = nudge::nudged(ray.direction, answer, normal).any(|direction| {
            let turned = Ray { direction, ..*ray };
            agree(first(self.crossings(&turned)), t, 1e4 * near)
        });
        if excused { Verdict::Excused } else { Verdict::Wrong }
    }
}

/// Whether two answers are the same, to rounding.
fn agree(expected: Option<f64>, found: Option<f64>, near: f64) -> bool {
    match (expected, found) {
        (Some(a), Some(b)) => (a - b).abs() <= near,
        (None, None) => true,
        _ => false,
    }
}
