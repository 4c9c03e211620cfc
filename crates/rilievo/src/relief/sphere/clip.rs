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

/// Where a part begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Beginning {
    /// On the outer ball, outside of the surface.
    Roof,
    /// On the inner ball, inside of it.
    Floor,
    /// At the ray's own start, on whichever side.
    Origin,
}

/// A straight part of a ray, relative to the sphere's centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    pub start: DVec3,
    pub direction: DVec3,
    /// The ray's parameter at the start, and how far the part goes on from there.
    pub t: f64,
    pub length: f64,
    /// Where the line that the part is on is closest to the centre, from the start.
    pub nearest: f64,
    pub from: Beginning,
}

/// Parts of the ray from `origin`, relative to the centre.
#[inline(always)]
pub(super) fn parts(radii: &Radii, origin: DVec3, direction: DVec3) -> [Option<Part>; 2] {
    let none = [None; 2];
    let per_length = 1.0 / direction.length_squared();
    let (wide, mut origin, mut moved) = (1.5 * radii.roof, origin, 0.0);
    if origin.length_squared() > wide * wide {
        let chord = Chord::new(origin, direction, per_length);
        let Some(half) = chord.half(wide, per_length) else { return none };
        moved = (chord.middle - half).max(0.0);
        origin += moved * direction;
    }
    let chord = Chord::new(origin, direction, per_length);
    let Some(half) = chord.half(radii.roof, per_length) else { return none };
    let part = |from: f64, to: f64, beginning: Beginning| {
        let beginning = if from > 0.0 { beginning } else { Beginning::Origin };
        let from = from.max(0.0);
        (from <= to).then(|| Part {
            start: origin + from * direction,
            direction,
            t: moved + from,
            length: to - from,
            nearest: chord.middle - from,
            from: beginning,
        })
    };
    let (enter, leave) = (chord.middle - half, chord.middle + half);
    match chord.half(radii.floor, per_length) {
        Some(half) => [
            part(enter, chord.middle - half, Beginning::Roof),
            part(chord.middle + half, leave, Beginning::Floor),
        ],
        None => [part(enter, leave, Beginning::Roof), None],
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
