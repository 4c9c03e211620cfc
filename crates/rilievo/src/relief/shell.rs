//! [`Shell`]: the box in which the rays of a face are walked, and the part of a ray inside it.
//!
//! Everything is straight-line `f64`: choices are selections, not branches, so that a loop over the
//! rays of a packet becomes vectors, with the bits of the ray alone.

use glam::DVec3;

/// A ray in lattice space, its direction as long as the world ray's.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LatticeRay {
    pub origin: DVec3,
    pub direction: DVec3,
    /// Added to the height at the start; see `leaf`.
    pub lift: f64,
    /// The ray's own end.
    pub t_max: f64,
}

/// A box in lattice space, a margin wider than a face's window and range of heights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shell {
    pub low: DVec3,
    pub high: DVec3,
    /// Heights between which rays are worth walking.
    pub culled: [f64; 2],
}

/// The part of a ray inside a shell, with a parameter that runs from 0 to 1 over it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClippedRay {
    pub start: DVec3,
    pub direction: DVec3,
    /// World parameter of the start, and its growth over the part.
    pub t_start: f64,
    pub t_length: f64,
    /// The part of `0..1` within the heights worth walking and the ray's own end, a little widened.
    pub cull: [f64; 2],
    /// The ray's own end; infinite if it lies beyond the box.
    pub end: f64,
    /// Whether there is such a part; else the other numbers mean nothing.
    pub valid: bool,
}

impl Shell {
    /// The part of a ray inside.
    #[inline(always)]
    pub fn clip(&self, ray: &LatticeRay) -> ClippedRay {
        let LatticeRay { origin, direction, lift, t_max } = *ray;
        let inv =
            DVec3::new(reciprocal(direction.x), reciprocal(direction.y), reciprocal(direction.z));
        let (a, b) = ((self.low - origin) * inv, (self.high - origin) * inv);
        let enter = larger64(
            larger64(smaller64(a.x, b.x), smaller64(a.y, b.y)),
            larger64(smaller64(a.z, b.z), 0.0),
        );
        let leave =
            smaller64(smaller64(larger64(a.x, b.x), larger64(a.y, b.y)), larger64(a.z, b.z));
        let length = leave - enter;
        let part = 1.0 / length;
        let own = if t_max < leave { (t_max - enter) * part } else { f64::INFINITY };
        let end = smaller64(own * (1.0 + 1e-6) + 1e-9, 1.0);
        let start = origin + enter * direction;
        let z = start.z + lift;
        let [low, high] = self.culled;
        let scale = inv.z * part;
        let (c, d) = ((low - z) * scale, (high - z) * scale);
        // Level rays are inside all the way or not at all: `scale` is huge.
        let cull = [larger64(smaller64(c, d), 0.0), smaller64(larger64(c, d), end)];
        // Not finite: the product with 0 is NaN. Empty, endless (no direction), or past the end.
        let finite = (origin + direction).dot(DVec3::ZERO) == 0.0;
        let valid = finite & (length > 0.0) & (length < f64::INFINITY) & (enter <= t_max);
        ClippedRay {
            start,
            direction: direction * length,
            t_start: enter,
            t_length: length,
            cull,
            end: own,
            valid,
        }
    }
}

/// The larger of two numbers, the second if one is NaN: one instruction.
#[inline(always)]
fn larger64(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two numbers, the second if one is NaN.
#[inline(always)]
fn smaller64(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// `1 / d`, and a huge number instead of an infinite one, so that its product with 0 is 0.
#[inline(always)]
fn reciprocal(d: f64) -> f64 {
    if d.abs() > 1e-280 { 1.0 / d } else { 1e280f64.copysign(d) }
}
