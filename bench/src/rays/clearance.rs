//! Origins that are clear of the bilinear surface and of its triangulations.
//!
//! A peer traces a cell as two triangles, split along one of its diagonals. The three surfaces
//! agree at the samples and on the cell's border and differ inside by up to a quarter of the cell's
//! twist, so a start on one may lie below another. [`clear`] first moves a point off along the
//! normal, rounds it to `f32`, then lifts it above the highest of the three.

use glam::DVec3;
use rilievo::map::HeightMap;

/// How far origins are kept from all surfaces, scene units of the unit square: some hundred times
/// the `f32` rounding of a coordinate, a sixth of a cell at 8192 x 8192.
pub const CLEARANCE: f64 = 2e-5;

/// The point beside `hit` from which a ray starts. `map` lies on the unit square, one unit of height
/// being `depth` scene units; `normal` is that of the surface at `hit`, upwards.
pub fn clear(map: &HeightMap, depth: f64, hit: DVec3, normal: DVec3) -> [f32; 3] {
    let moved = (hit + CLEARANCE * normal).as_vec3();
    let at = moved.as_dvec3();
    let lifted = if (0.0..=1.0).contains(&at.x) && (0.0..=1.0).contains(&at.y) {
        at.z.max(highest(map, at.x, at.y) * map.unit() * depth + CLEARANCE)
    } else {
        at.z
    };
    [moved.x, moved.y, (lifted as f32).next_up()]
}

/// The highest raw value at (u, v) of the bilinear surface and both splits into triangles.
fn highest(map: &HeightMap, u: f64, v: f64) -> f64 {
    let at = [map.x().coordinate(u), map.y().coordinate(v)];
    let last = [map.width() - 2, map.height() - 2];
    let cell: [u32; 2] = std::array::from_fn(|a| (at[a] as u32).min(last[a]));
    let [x, y] = std::array::from_fn(|a| at[a] - f64::from(cell[a]));
    let [h00, h10, h01, h11] = map.stored_corners(cell[0], cell[1]).map(f64::from);
    let low = h00 + (h10 - h00) * x;
    let bilinear = low + (h01 + (h11 - h01) * x - low) * y;
    let falling = if x + y < 1.0 {
        h00 + (h10 - h00) * x + (h01 - h00) * y
    } else {
        h11 + (h01 - h11) * (1.0 - x) + (h10 - h11) * (1.0 - y)
    };
    let rising = if x > y {
        h00 + (h10 - h00) * x + (h11 - h10) * y
    } else {
        h00 + (h01 - h00) * y + (h11 - h01) * x
    };
    bilinear.max(falling).max(rising)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rilievo::map::{Lattice, Samples, Wrap};

    #[test]
    fn the_highest_of_three_surfaces_is_found() {
        let saddle = Samples::U16(vec![0, 60_000, 60_000, 0]);
        let map = HeightMap::new(2, 2, saddle, Lattice::Vertex, Wrap::Repeat).unwrap();
        // The falling diagonal joins the two high corners, the rising one the two low ones.
        assert_eq!(highest(&map, 0.5, 0.5), 60_000.0);
        assert_eq!(highest(&map, 0.25, 0.25), 30_000.0);
        assert_eq!(highest(&map, 1.0, 0.0), 60_000.0);
        let bowl = Samples::U16(vec![60_000, 0, 0, 60_000]);
        let map = HeightMap::new(2, 2, bowl, Lattice::Vertex, Wrap::Repeat).unwrap();
        assert_eq!(highest(&map, 0.5, 0.5), 60_000.0);
        let start = clear(&map, 1.0, DVec3::new(0.5, 0.5, 30_000.0 / 65_535.0), DVec3::Z);
        assert!(f64::from(start[2]) > 60_000.0 / 65_535.0 + 0.5 * CLEARANCE);
    }
}
