//! [`Metric`]: how large the cells of a map are in a scene.

use super::height::HeightMap;

/// Scene units per lattice cell along x and y, and per raw unit of height along z.
///
/// A face maps lattice space to its own plane by an affine map with mutually orthogonal axes when
/// its sides are at right angles; the metric is the length of those axes. Maps derived in one
/// metric serve faces of another: see [`NormalMap::with_metric`](super::NormalMap::with_metric)
/// and [`DistanceMap`](super::DistanceMap).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metric {
    /// Scene units per cell along x (along u).
    pub x: f64,
    /// Scene units per cell along y (along v).
    pub y: f64,
    /// Scene units per raw unit of height. Negative where a face turns heights around.
    pub z: f64,
}

impl Metric {
    /// The metric with one scene unit per cell and per raw unit.
    pub const UNIT: Self = Self { x: 1.0, y: 1.0, z: 1.0 };

    /// The metric of `heights` on a rectangle: `sides` are the lengths in scene units of *one
    /// repetition* of the map along u and v, `scale` is the displacement in scene units of height 1.
    pub fn of_face(heights: &HeightMap, sides: [f64; 2], scale: f64) -> Self {
        Self {
            x: sides[0] / f64::from(heights.x().period()),
            y: sides[1] / f64::from(heights.y().period()),
            z: scale * heights.unit(),
        }
    }

    /// Whether all three lengths are finite and above zero.
    pub fn is_positive(&self) -> bool {
        [self.x, self.y, self.z].iter().all(|s| s.is_finite() && *s > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Lattice, Samples, Wrap};

    #[test]
    fn a_face_metric_counts_cells_of_one_repetition() {
        let samples = Samples::U16(vec![0; 15]);
        let map = HeightMap::new(5, 3, samples, Lattice::Vertex, Wrap::Repeat).unwrap();
        let metric = Metric::of_face(&map, [2.0, 1.0], 65535.0);
        assert_eq!(metric, Metric { x: 0.5, y: 0.5, z: 1.0 });
        let map = map.with_lattice(Lattice::Texel, Wrap::Clamp);
        assert_eq!(Metric::of_face(&map, [2.0, 1.5], 0.0), Metric { x: 0.4, y: 0.5, z: 0.0 });
        assert!(metric.is_positive() && !Metric { z: 0.0, ..metric }.is_positive());
    }
}
