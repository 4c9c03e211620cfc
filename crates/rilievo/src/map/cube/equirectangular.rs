//! [`Equirectangular`]: a map wrapped around a sphere.
//!
//! u is the longitude over 360 degrees, v the latitude from the south pole over 180. Along u the map
//! closes on itself, whatever its wrap mode: texel columns `w - 1` and 0 are neighbours; the first
//! and the last column of a vertex lattice are one meridian and count as their mean. A pole is one
//! point: its height is the mean of the row next to it, or of the row that a vertex lattice has
//! there, and rows go over into it linearly. So the heights are one continuous function of the
//! direction.
//!
//! A map may be [tiled](Tiling): a whole number of times around, any number from pole to pole, where
//! it goes on by its own wrap mode. A pole then has the mean height around it, and nothing goes over
//! into that.

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use crate::map::height::HeightMap;
use crate::map::lattice::Lattice;

/// How often a map lies on a sphere, and from where on: `(u, v) * tile + shift` is looked up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tiling {
    /// Repetitions around the sphere, a whole number above 0, and from pole to pole, above 0.
    pub tile: [f64; 2],
    /// Added after tiling.
    pub shift: [f64; 2],
}

impl Default for Tiling {
    /// The map once, from longitude 0 and the south pole on.
    fn default() -> Self {
        Self { tile: [1.0; 2], shift: [0.0; 2] }
    }
}

impl Tiling {
    /// Whether the map's own poles are those of the sphere.
    fn is_whole(&self) -> bool {
        self.tile[1] == 1.0 && self.shift[1] == 0.0
    }
}

/// The heights of a map by direction.
pub(super) struct Equirectangular<'a> {
    map: &'a HeightMap,
    tiling: Tiling,
    /// Raw heights at v = 0 and v = 1.
    poles: [f64; 2],
}

impl<'a> Equirectangular<'a> {
    pub fn new(map: &'a HeightMap, tiling: Tiling) -> Self {
        let mut around = Self { map, tiling, poles: [0.0; 2] };
        around.poles = [0.0, 1.0].map(|v| around.mean_around(v));
        around
    }

    /// Mean raw height at latitude v; of the last row of the map at the poles of an untiled one.
    fn mean_around(&self, v: f64) -> f64 {
        let (map, Tiling { tile, shift }) = (self.map, self.tiling);
        let y = map.y().coordinate(v * tile[1] + shift[1]);
        let y = if self.tiling.is_whole() { y.clamp(0.0, f64::from(map.height() - 1)) } else { y };
        let (j, (low, high)) = (y.floor(), map.y().unfolded_corners(y.floor() as i32));
        let row = |j: u32| {
            let sum: f64 = (0..map.width()).map(|i| f64::from(map.raw(i, j))).sum();
            sum / f64::from(map.width())
        };
        lerp(row(low), row(high), y - j)
    }

    /// Raw height in a direction of any length but 0.
    pub fn raw(&self, [x, y, z]: [f64; 3]) -> f64 {
        if x == 0.0 && y == 0.0 {
            return self.poles[usize::from(z > 0.0)];
        }
        self.raw_at([y.atan2(x) / TAU, 0.5 + z.atan2(x.hypot(y)) / PI])
    }

    /// Raw height at any longitude u and latitude v.
    fn raw_at(&self, [u, v]: [f64; 2]) -> f64 {
        let (map, rows) = (self.map, self.map.height());
        let Tiling { tile, shift } = self.tiling;
        let x = map.x().coordinate(u * tile[0] + shift[0]);
        let y = map.y().coordinate(v * tile[1] + shift[1]);
        let columns = f64::from(map.x().period());
        let near = x.floor();
        let fraction = x - near;
        // Rounded sums may reach the end of the period; a remainder never does.
        let i = near.rem_euclid(columns) as u32 % map.x().period();
        let next = (i + 1) % map.x().period();
        let row = |j: u32| lerp(self.column(i, j), self.column(next, j), fraction);
        if !self.tiling.is_whole() {
            let (j, (low, high)) = (y.floor(), map.y().unfolded_corners(y.floor() as i32));
            return lerp(row(low), row(high), y - j);
        }
        if y < 0.0 {
            return lerp(self.poles[0], row(0), 2.0 * y.max(-0.5) + 1.0);
        }
        let beyond = y - f64::from(rows - 1);
        if beyond > 0.0 {
            return lerp(row(rows - 1), self.poles[1], 2.0 * beyond.min(0.5));
        }
        let j = (y as u32).min(rows - 2);
        lerp(self.row_or_pole(j, &row), self.row_or_pole(j + 1, &row), y - f64::from(j))
    }

    /// The height of a row; the poles' where a vertex lattice has its row there.
    fn row_or_pole(&self, j: u32, row: &impl Fn(u32) -> f64) -> f64 {
        let on_pole = self.map.y().lattice() == Lattice::Vertex;
        match j {
            0 if on_pole => self.poles[0],
            j if on_pole && j == self.map.height() - 1 => self.poles[1],
            j => row(j),
        }
    }

    /// Raw height of sample (i, j), where the ends of a vertex lattice are one.
    fn column(&self, i: u32, j: u32) -> f64 {
        let raw = f64::from(self.map.raw(i, j));
        if i == 0 && self.map.x().lattice() == Lattice::Vertex {
            return raw.midpoint(f64::from(self.map.raw(self.map.width() - 1, j)));
        }
        raw
    }

    /// The repetitions of the map that lie on the sphere from pole to pole, some of them in part.
    pub fn repetitions(&self) -> Range<i32> {
        let Tiling { tile, shift } = self.tiling;
        shift[1].floor() as i32..(shift[1] + tile[1]).ceil() as i32
    }

    /// The direction of sample (i, j) of the first repetition around and any from pole to pole, a unit
    /// vector; none where it lies beyond a pole.
    pub fn direction(&self, [i, j]: [u32; 2], repetition: i32) -> Option<[f64; 3]> {
        let Tiling { tile, shift } = self.tiling;
        let u = (self.map.x().parameter(f64::from(i)) - shift[0]) / tile[0];
        let v = self.map.y().parameter(f64::from(j)) + f64::from(repetition);
        let v = (v - shift[1]) / tile[1];
        let ((sin, cos), (z, across)) = ((TAU * u).sin_cos(), (PI * (v - 0.5)).sin_cos());
        (0.0..=1.0).contains(&v).then_some([across * cos, across * sin, z])
    }
}

/// Linear interpolation, exact at both ends and never outside of them by more than a rounding.
fn lerp(a: f64, b: f64, t: f64) -> f64 {
    t * b + (a - t * a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Samples, Wrap};

    fn map(lattice: Lattice) -> HeightMap {
        let samples = (0..48).map(|k| ((k * 37) % 19) as f32).collect();
        HeightMap::new(8, 6, Samples::F32(samples), lattice, Wrap::Clamp).unwrap()
    }

    #[test]
    fn samples_lie_in_their_directions() {
        for lattice in [Lattice::Texel, Lattice::Vertex] {
            let map = map(lattice);
            let around = Equirectangular::new(&map, Tiling::default());
            for j in 1..5 {
                for i in 1..7 {
                    let raw = around.raw(around.direction([i, j], 0).unwrap());
                    assert!((raw - f64::from(map.raw(i, j))).abs() < 1e-12, "{lattice:?} {i} {j}");
                }
            }
        }
    }

    #[test]
    fn heights_are_continuous_over_the_date_line_and_the_poles() {
        for lattice in [Lattice::Texel, Lattice::Vertex] {
            let map = map(lattice);
            let around = Equirectangular::new(&map, Tiling::default());
            for z in [-0.9, 0.0, 0.3] {
                let west = around.raw([1.0, -1e-9, z]);
                assert!((around.raw([1.0, 1e-9, z]) - west).abs() < 1e-6);
                let west = around.raw([-1.0, -1e-9, z]);
                assert!((around.raw([-1.0, 1e-9, z]) - west).abs() < 1e-6);
            }
            for z in [-1.0, 1.0] {
                let pole = around.raw([0.0, 0.0, z]);
                for k in 0..16 {
                    let (sin, cos) = f64::from(k).sin_cos();
                    let near = around.raw([1e-9 * cos, 1e-9 * sin, z]);
                    assert!((near - pole).abs() < 1e-6, "{lattice:?} {near} {pole}");
                }
            }
        }
    }

    #[test]
    fn tiles_repeat_around_and_from_pole_to_pole() {
        let map = map(Lattice::Texel).with_lattice(Lattice::Texel, Wrap::Repeat);
        let tiling = Tiling { tile: [3.0, 2.0], shift: [0.25, 0.5] };
        let around = Equirectangular::new(&map, tiling);
        assert_eq!(around.repetitions(), 0..3);
        let mut seen = 0;
        for (j, repetition) in (0..6).flat_map(|j| around.repetitions().map(move |k| (j, k))) {
            for i in 0..8 {
                let Some(along) = around.direction([i, j], repetition) else { continue };
                assert!((around.raw(along) - f64::from(map.raw(i, j))).abs() < 1e-9);
                // A third of the way around it comes again.
                let (sin, cos) = (TAU / 3.0).sin_cos();
                let [x, y, z] = along;
                let next = [cos * x - sin * y, sin * x + cos * y, z];
                assert!((around.raw(next) - around.raw(along)).abs() < 1e-9);
                seen += 1;
            }
        }
        assert_eq!(seen, 2 * 6 * 8);
    }
}
