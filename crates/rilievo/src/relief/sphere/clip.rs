//! The parts of a ray between the two balls that hold the surface.
//!
//! Inside the inner ball there is no surface, so a ray has at most two parts: one on the way in, one
//! on the way out. Every `Z` along them is then at least the inner radius over the square root of 3,
//! however close to the centre the ray passes, and nothing cancels.
//!
//! The ray's start is first moved to a ball half as large again, then all is computed anew from
//! there: a camera ten radii or a million away makes no difference beyond the rounding of its own
//! coordinates.

use glam::DVec3;

use super::radii::Radii;

/// A straight part of a ray, relative to the sphere's centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub start: DVec3,
    pub direction: DVec3,
    /// The ray's parameter at the start, and how far the part goes on from there.
    pub t: f64,
    pub length: f64,
}

/// Parts of the ray from `origin`, relative to the centre.
#[inline(always)]
pub(super) fn parts(radii: &Radii, origin: DVec3, direction: DVec3) -> [Option<Part>; 2] {
    let none = [None; 2];
    let per_length = 1.0 / direction.length_squared();
    let wide = Chord::new(origin, direction, per_length);
    let Some(half) = wide.half(1.5 * radii.roof, per_length) else { return none };
    let moved = (wide.middle - half).max(0.0);
    let origin = origin + moved * direction;
    let chord = Chord::new(origin, direction, per_length);
    let Some(half) = chord.half(radii.roof, per_length) else { return none };
    let part = |from: f64, to: f64| {
        let from = from.max(0.0);
        (from <= to).then(|| Part {
            start: origin + from * direction,
            direction,
            t: moved + from,
            length: to - from,
        })
    };
    let (enter, leave) = (chord.middle - half, chord.middle + half);
    match chord.half(radii.floor, per_length) {
        Some(half) => [part(enter, chord.middle - half), part(chord.middle + half, leave)],
        None => [part(enter, leave), None],
    }
}

/// Where a line comes closest to the centre.
struct Chord {
    /// Parameter there.
    middle: f64,
    /// Squared distance there.
    distance: f64,
}

impl Chord {
    #[inline(always)]
    fn new(origin: DVec3, direction: DVec3, per_length: f64) -> Self {
        let middle = -origin.dot(direction) * per_length;
        Self { middle, distance: (origin + middle * direction).length_squared() }
    }

    /// Half the chord inside a ball, in parameters.
    #[inline(always)]
    fn half(&self, radius: f64, per_length: f64) -> Option<f64> {
        let square = radius * radius - self.distance;
        (square >= 0.0).then(|| (square * per_length).sqrt())
    }
}

impl Part {
    /// Where the part, or the line that it is on, is closest to the centre, from its start.
    #[inline(always)]
    pub fn nearest(&self) -> f64 {
        -self.start.dot(self.direction) / self.direction.length_squared()
    }
}
