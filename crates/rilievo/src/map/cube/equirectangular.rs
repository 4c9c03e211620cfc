//! [`Equirectangular`]: a map wrapped around a sphere.
//!
//! u is the longitude over 360 degrees, v the latitude from the south pole over 180. Along u the map
//! closes on itself, whatever its wrap mode: texel columns `w - 1` and 0 are neighbours; the first
//! and the last column of a vertex lattice are one meridian and count as their mean. A pole is one
//! point: its height is the mean of the row next to it, or of the row that a vertex lattice has
//! there, and rows go over into it linearly. So the heights are one continuous function of the
//! direction.

use std::f64::consts::{PI, TAU};

use crate::map::height::HeightMap;
use crate::map::lattice::Lattice;

/// The heights of a map by direction.
pub(super) struct Equirectangular<'a> {
    map: &'a HeightMap,
    /// Raw heights at v = 0 and v = 1.
    poles: [f64; 2],
}

impl<'a> Equirectangular<'a> {
    pub fn new(map: &'a HeightMap) -> Self {
        let mean = |j: u32| {
            let sum: f64 = (0..map.width()).map(|i| f64::from(map.raw(i, j))).sum();
            sum / f64::from(map.width())
        };
        Self { map, poles: [mean(0), mean(map.height() - 1)] }
    }

    /// Raw height in a direction of any length but 0.
    pub fn raw(&self, [x, y, z]: [f64; 3]) -> f64 {
        self.raw_at([y.atan2(x) / TAU, 0.5 + z.atan2(x.hypot(y)) / PI])
    }

    /// Raw height at any longitude u and latitude v.
    fn raw_at(&self, [u, v]: [f64; 2]) -> f64 {
        let (map, rows) = (self.map, self.map.height());
        let (x, y) = (map.x().coordinate(u), map.y().coordinate(v));
        let columns = f64::from(map.x().period());
        let near = x.floor();
        let fraction = x - near;
        // Rounded sums may reach the end of the period; a remainder never does.
        let i = near.rem_euclid(columns) as u32 % map.x().period();
        let next = (i + 1) % map.x().period();
        let row = |j: u32| lerp(self.column(i, j), self.column(next, j), fraction);
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

    /// The direction of sample (i, j), a unit vector.
    pub fn direction(&self, i: u32, j: u32) -> [f64; 3] {
        let longitude = TAU * self.map.x().parameter(f64::from(i));
        let latitude = PI * (self.map.y().parameter(f64::from(j)) - 0.5);
        let ((sin, cos), (z, across)) = (longitude.sin_cos(), latitude.sin_cos());
        [across * cos, across * sin, z]
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
            let around = Equirectangular::new(&map);
            for j in 1..5 {
                for i in 1..7 {
                    let raw = around.raw(around.direction(i, j));
                    assert!((raw - f64::from(map.raw(i, j))).abs() < 1e-12, "{lattice:?} {i} {j}");
                }
            }
        }
    }

    #[test]
    fn heights_are_continuous_over_the_date_line_and_the_poles() {
        for lattice in [Lattice::Texel, Lattice::Vertex] {
            let map = map(lattice);
            let around = Equirectangular::new(&map);
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
}
