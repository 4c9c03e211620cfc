//! Kind `published`: the seed paper's brute force, as it was \[Book2007, 3.3\].
//!
//! "For each point p in the three-dimensional map, the distance between the height at that point
//! and p is set as an initial distance. Then, all points within that distance on the height map are
//! checked. If a point p' is closer to p than the current distance, the distance is updated."
//!
//! The points are the texel points: the samples of the stored cells. The surface between them may
//! be nearer, so that the stored value is an *upper* bound: steps of its length overshoot, and the
//! trilinear reading between nodes overshoots again. Kept to reproduce the paper, and as the
//! baseline. Where a node of the map is not over a sample, the initial distance is taken to the
//! bilinear height there, as the paper reads heights anywhere. Codes are floored, so that
//! quantisation adds no error of the unsafe kind.
//!
//! Time: nodes times the samples within the vertical distance, up to `O(nx ny nz w h)`.

use rayon::prelude::*;

use super::codes::{Code, Quantiser};
use super::domain::Domain;
use crate::map::HeightMap;

/// The codes of all nodes; rows of nodes in parallel.
pub(super) fn codes<C: Code>(
    heights: &HeightMap,
    domain: &Domain,
    size: [u32; 3],
    quantiser: &Quantiser,
) -> Vec<C> {
    let texels = Texels::new(heights, domain);
    let [nx, ny, nz] = size;
    let mut codes = vec![C::default(); nx as usize * ny as usize * nz as usize];
    codes.par_chunks_mut(nx as usize).enumerate().for_each(|(row, out)| {
        let (j, k) = (row as u32 % ny, row as u32 / ny);
        let (y, z) = (domain.division(1, j, ny - 1), domain.division(2, k, nz - 1));
        for (i, code) in out.iter_mut().enumerate() {
            let x = domain.division(0, i as u32, nx - 1);
            *code = C::store(quantiser.code(texels.distance([x, y, z])));
        }
    });
    codes
}

/// The corners of the stored cells, as raw heights, x fastest.
pub(super) struct Texels<'a> {
    domain: &'a Domain,
    raw: Vec<f32>,
    width: usize,
    rows: usize,
}

impl<'a> Texels<'a> {
    pub fn new(heights: &HeightMap, domain: &'a Domain) -> Self {
        let sample = |axis: &crate::map::Axis, i: u32| {
            if i < axis.cells() { axis.corners(i).0 } else { axis.corners(i - 1).1 }
        };
        let [cells_x, cells_y] = domain.cells;
        let raw = (0..=cells_y)
            .flat_map(|j| (0..=cells_x).map(move |i| (i, j)))
            .map(|(i, j)| heights.raw(sample(heights.x(), i), sample(heights.y(), j)))
            .collect();
        Self { domain, raw, width: cells_x as usize + 1, rows: cells_y as usize + 1 }
    }

    /// Bilinear raw height at (x, y) of the domain.
    fn height(&self, x: f64, y: f64) -> f64 {
        let (i, j) = ((x as usize).min(self.width - 2), (y as usize).min(self.rows - 2));
        let (fx, fy) = (x - i as f64, y - j as f64);
        let at = |di: usize, dj: usize| f64::from(self.raw[(j + dj) * self.width + i + di]);
        let (low, high) =
            (at(0, 0) + (at(1, 0) - at(0, 0)) * fx, at(0, 1) + (at(1, 1) - at(0, 1)) * fx);
        low + (high - low) * fy
    }

    /// The paper's distance of `p`, scene units.
    pub fn distance(&self, p: [f64; 3]) -> f64 {
        let metric = self.domain.metric;
        let initial = (p[2] - self.height(p[0], p[1])).abs() * metric.z;
        let (i0, i1) = within(p[0], initial / metric.x, self.width);
        let (j0, j1) = within(p[1], initial / metric.y, self.rows);
        let mut nearest = initial * initial;
        for j in j0..j1 {
            let dy = (j as f64 - p[1]) * metric.y;
            let row = &self.raw[j * self.width..][i0..i1];
            for (i, &raw) in row.iter().enumerate() {
                let dx = ((i0 + i) as f64 - p[0]) * metric.x;
                let dz = (f64::from(raw) - p[2]) * metric.z;
                nearest = nearest.min(dx * dx + dy * dy + dz * dz);
            }
        }
        nearest.sqrt()
    }
}

/// The half-open range of indices below `n` within `radius` of `x`.
fn within(x: f64, radius: f64, n: usize) -> (usize, usize) {
    let first = (x - radius).ceil().max(0.0) as usize;
    let last = (x + radius).floor().min(n as f64 - 1.0);
    (first.min(n), last as usize + 1)
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{Random, cases};
    use super::*;
    use crate::map::{
        DistanceBits, DistanceKind, DistanceMap, DistanceOptions, Lattice, Metric, Procedural,
        Pyramid, Wrap, exact_distance,
    };

    fn published(map: &HeightMap, metric: Metric, size: [u32; 3]) -> DistanceMap {
        let options = DistanceOptions { size, metric, bits: DistanceBits::U16 };
        DistanceMap::from_height(map, DistanceKind::Published, &options).unwrap()
    }

    #[test]
    fn nodes_over_samples_hold_the_distance_to_the_nearest_sample() {
        for (map, metric) in cases() {
            let [cells_x, cells_y] = [map.x().cells(), map.y().cells()];
            let size = [cells_x + 1, cells_y + 1, 4];
            let stored = published(&map, metric, size);
            let domain = Domain::of(&map, metric).unwrap();
            let texels = Texels::new(&map, &domain);
            for at in 0..size.iter().product() {
                let node = [at % size[0], at / size[0] % size[1], at / size[0] / size[1]];
                let z = domain.division(2, node[2], 3);
                let brute = texels.raw.iter().enumerate().map(|(t, &raw)| {
                    let (i, j) = ((t % texels.width) as f64, (t / texels.width) as f64);
                    let dx = (i - f64::from(node[0])) * metric.x;
                    let dy = (j - f64::from(node[1])) * metric.y;
                    dx.hypot(dy).hypot((f64::from(raw) - z) * metric.z)
                });
                let want = brute.fold(f64::INFINITY, f64::min);
                let d = stored.at(node[0], node[1], node[2]);
                assert!((0.0..=stored.quantum() * 1.001).contains(&(want - d)), "{node:?}");
            }
        }
    }

    #[test]
    fn a_step_is_overshot_nearly_everywhere_near_it() {
        let map = Procedural::Step.height_map([32, 32], Lattice::Vertex, Wrap::Clamp).unwrap();
        let metric = Metric::of_face(&map, [1.0, 1.0], 1.0);
        let stored = published(&map, metric, [34, 34, 32]);
        let pyramid = Pyramid::build(&map);
        let mut random = Random(3);
        let high = f64::from(map.raw_range().1);
        let over = (0..500)
            .filter(|_| {
                let p = random.point(([13.0, 0.0, 0.0], [20.0, 33.0, high]));
                let (_, upper) = exact_distance(&map, &pyramid, metric, p, 0.0);
                stored.safe_distance(p) > upper
            })
            .count();
        // 390 when written.
        assert!(over > 300, "{over} of 500");
    }
}
