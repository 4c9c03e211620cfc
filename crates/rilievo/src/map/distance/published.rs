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
struct Texels<'a> {
    domain: &'a Domain,
    raw: Vec<f32>,
    width: usize,
    rows: usize,
}

impl<'a> Texels<'a> {
    fn new(heights: &HeightMap, domain: &'a Domain) -> Self {
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
    fn distance(&self, p: [f64; 3]) -> f64 {
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
