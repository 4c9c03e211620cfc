//! Kind `boxes`: the distance from a voxel to the boxes that hold the surface, in linear time.
//!
//! **What is stored.** The domain is cut into voxels. A *column* is a voxel's footprint with the
//! interval of heights `[lo, hi]` over all stored cells whose inside meets the footprint's inside.
//! Any number of voxels an axis will do, more or fewer than cells. Every point of the surface over
//! a closed footprint lies in the column's closed box: it is a limit of points over the inside, and
//! the surface is continuous within the stored cells. For the slab of voxels with heights
//! `[k0, k1]` let `g = max(0, lo - k1, k0 - hi)`. Then
//!
//! ```text
//! D^2(i, j) = min over columns (i', j') of
//!             wx^2 max(|i - i'| - 1, 0)^2 + wy^2 max(|j - j'| - 1, 0)^2 + g(i', j')^2
//! ```
//!
//! is the squared distance from the closed voxel box to the union of the column boxes, so a lower
//! bound of the distance from *any* point of the voxel to the surface. One fetch, no
//! interpolation, no correction. It is a separable minimum: per slab one lower envelope along x and
//! one along y ([`transform`](super::transform)), linear in the voxels. Heights are never cut into
//! levels; only the voxels are.
//!
//! **Outside.** Sites lie in the domain, a convex box. Moving a query to the nearest point of a
//! convex set brings it no farther from any point of that set. So a point outside may use the
//! voxel of its clamped position: the top slab holds for every z above, the bottom slab below.
//!
//! **Rounding.** Squares are counted in integer multiples of `unit`, `2^-50` of the domain's
//! squared diagonal: `wx^2`, `wy^2` and every `g^2` are floored, and the transform is exact on
//! integers, so the minimum is not above the real one but for the rounding of `wx`, `wy`, `g`
//! themselves, which the margin of the domain covers. Flooring is downwards too: the stored code is
//! the largest whose value is at most `sqrt(D^2) - margin`.
//!
//! **What we changed.** \[Donnelly2005\] propagates vectors to voxels of the surface and errs upwards;
//! \[Felzenszwalb2012\] measures point to point. The box kernel, the exact height intervals and the
//! integer envelope are ours.
//!
//! **Memory.** The codes, 8 bytes a column, and 8 bytes a column of the slab in work per thread.

use rayon::prelude::*;

use super::codes::{Code, Quantiser};
use super::domain::Domain;
use super::transform::Envelope;
use crate::map::HeightMap;

/// Lines along y that are transformed together, so that memory is read in whole cache lines.
const LINES: usize = 16;

/// Distances from voxels to columns in exact integer squares.
#[derive(Debug)]
pub(super) struct Boxes {
    domain: Domain,
    size: [u32; 3],
    /// Scene units squared of one integer step.
    unit: f64,
    /// `wx^2` and `wy^2`, floored to steps.
    weights: [f64; 2],
    /// Height interval of each column, x fastest.
    pub columns: Vec<(f32, f32)>,
}

/// The stored cells whose inside meets division `i` of `n` of an axis, first and last.
fn cells_of(i: u32, n: u32, cells: u32) -> (u32, u32) {
    let (i, n, cells) = (u64::from(i), u64::from(n), u64::from(cells));
    ((i * cells / n) as u32, ((i + 1) * cells).div_ceil(n) as u32 - 1)
}

impl Boxes {
    /// The columns of `heights` under a grid of `size` voxels.
    pub fn new(heights: &HeightMap, domain: &Domain, size: [u32; 3]) -> Self {
        let [x, y, z] = domain.extents();
        let unit = (x * x + y * y + z * z) / (1u64 << 50) as f64;
        let weight = |side: f64, n: u32| {
            let voxel = side / f64::from(n);
            (voxel * voxel / unit).floor()
        };
        let [nx, ny] = [size[0], size[1]];
        let mut columns = vec![(0.0, 0.0); nx as usize * ny as usize];
        columns.par_chunks_mut(nx as usize).enumerate().for_each(|(j, row)| {
            let (first_y, last_y) = cells_of(j as u32, ny, domain.cells[1]);
            for (i, column) in row.iter_mut().enumerate() {
                let (first_x, last_x) = cells_of(i as u32, nx, domain.cells[0]);
                let (mut lo, mut hi) = (f32::INFINITY, f32::NEG_INFINITY);
                for cy in first_y..=last_y {
                    for cx in first_x..=last_x {
                        for h in heights.stored_corners(cx, cy) {
                            (lo, hi) = (lo.min(h), hi.max(h));
                        }
                    }
                }
                *column = (lo, hi);
            }
        });
        let weights = [weight(x, nx), weight(y, ny)];
        Self { domain: *domain, size, unit, weights, columns }
    }

    /// Lowest and highest raw height of slab `k`.
    pub fn slab(&self, k: u32) -> (f64, f64) {
        let n = self.size[2];
        (self.domain.division(2, k, n), self.domain.division(2, k + 1, n))
    }

    /// Squared vertical gap between a slab and heights `[lo, hi]`, in integer steps.
    #[inline]
    pub fn vertical(&self, slab: (f64, f64), (lo, hi): (f32, f32)) -> f64 {
        let gap = (f64::from(lo) - slab.1).max(slab.0 - f64::from(hi)).max(0.0);
        let gap = gap * self.domain.metric.z;
        // Below 2^53: the cast is the floor, without a call.
        (gap * gap / self.unit) as i64 as f64
    }

    /// Squared distance across `gap` whole voxels along `axis`, in integer steps.
    #[inline]
    pub fn across(&self, axis: usize, gap: u32) -> f64 {
        self.weights[axis] * f64::from(gap) * f64::from(gap)
    }

    /// The distance of a squared distance in steps.
    #[inline]
    pub fn distance(&self, steps: f64) -> f64 {
        (steps * self.unit).sqrt()
    }

    /// The squared distance, in steps, of a distance.
    pub fn steps(&self, distance: f64) -> f64 {
        distance * distance / self.unit
    }

    /// The codes of all voxels; slabs in parallel.
    pub fn codes<C: Code>(&self, quantiser: &Quantiser) -> Vec<C> {
        let [nx, ny, nz] = self.size.map(|n| n as usize);
        let mut codes = vec![C::default(); nx * ny * nz];
        codes.par_chunks_mut(nx * ny).enumerate().for_each_init(
            || Work::new(nx, ny),
            |work, (k, slab)| {
                self.fill(k as u32, work, |at, steps| {
                    slab[at] = C::store(quantiser.code(self.distance(steps)));
                });
            },
        );
        codes
    }

    /// Transforms slab `k` and hands each voxel's index in it and squared distance to `put`.
    fn fill(&self, k: u32, work: &mut Work, mut put: impl FnMut(usize, f64)) {
        let (nx, ny) = (self.size[0] as usize, self.size[1] as usize);
        let slab = self.slab(k);
        for (row, columns) in work.steps.chunks_mut(nx).zip(self.columns.chunks(nx)) {
            for (f, &column) in row.iter_mut().zip(columns) {
                *f = self.vertical(slab, column);
            }
            work.envelope.transform(self.weights[0], row);
        }
        for first in (0..nx).step_by(LINES) {
            let width = LINES.min(nx - first);
            for j in 0..ny {
                for (c, &f) in work.steps[j * nx + first..][..width].iter().enumerate() {
                    work.lines[c * ny + j] = f;
                }
            }
            for line in work.lines.chunks_mut(ny).take(width) {
                work.envelope.transform(self.weights[1], line);
            }
            for j in 0..ny {
                for c in 0..width {
                    put(j * nx + first + c, work.lines[c * ny + j]);
                }
            }
        }
    }
}

/// A thread's working memory for one slab.
struct Work {
    steps: Vec<f64>,
    lines: Vec<f64>,
    envelope: Envelope,
}

impl Work {
    fn new(nx: usize, ny: usize) -> Self {
        Self {
            steps: vec![0.0; nx * ny],
            lines: vec![0.0; LINES * ny],
            envelope: Envelope::new(nx.max(ny)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{Random, cases};
    use super::*;
    use crate::map::{
        DistanceBits, DistanceKind, DistanceMap, DistanceOptions, Pyramid, exact_distance,
    };

    /// Sizes below, at and above the number of cells, none dividing the other.
    const SIZES: [[u32; 3]; 3] = [[3, 4, 5], [7, 5, 2], [17, 13, 9]];

    #[test]
    fn divisions_own_the_cells_they_overlap_and_no_neighbour() {
        assert_eq!(cells_of(0, 4, 4), (0, 0));
        assert_eq!(cells_of(3, 4, 4), (3, 3));
        assert_eq!(cells_of(1, 2, 5), (2, 4));
        assert_eq!(cells_of(0, 2, 5), (0, 2));
        assert_eq!(cells_of(4, 10, 3), (1, 1));
        assert_eq!(cells_of(3, 10, 3), (0, 1));
    }

    #[test]
    fn every_code_is_the_floor_of_the_brute_force_box_distance() {
        for (map, metric) in cases() {
            for size in SIZES {
                let options = DistanceOptions { size, metric, bits: DistanceBits::U16 };
                let stored = DistanceMap::from_height(&map, DistanceKind::Boxes, &options).unwrap();
                let domain = Domain::of(&map, metric).unwrap();
                let columns = Boxes::new(&map, &domain, size).columns;
                let [nx, ny, nz] = size;
                for at in 0..nx * ny * nz {
                    let voxel = [at % nx, at / nx % ny, at / nx / ny];
                    let (low, high) = stored.voxel_bounds(voxel);
                    let nearest = columns.iter().enumerate().map(|(c, &(lo, hi))| {
                        let column = [c as u32 % nx, c as u32 / nx];
                        let gap = |a: usize| {
                            f64::from(column[a].abs_diff(voxel[a]).saturating_sub(1))
                                * domain.extents()[a]
                                / f64::from(size[a])
                        };
                        let z = (f64::from(lo) - high[2]).max(low[2] - f64::from(hi)).max(0.0);
                        gap(0).hypot(gap(1)).hypot(z * metric.z)
                    });
                    let want = nearest.fold(f64::INFINITY, f64::min);
                    let d = stored.at(voxel[0], voxel[1], voxel[2]);
                    assert!(d <= want, "{size:?} {voxel:?}: {d} over {want}");
                    let slack = stored.quantum() + 1e-6 * want;
                    assert!(d + slack >= want, "{size:?} {voxel:?}: {d} well under {want}");
                }
            }
        }
    }

    #[test]
    fn no_code_is_above_the_true_distance_of_any_point_of_its_voxel() {
        let mut random = Random(1);
        for (map, metric) in cases() {
            let pyramid = Pyramid::build(&map);
            for (size, bits) in
                SIZES.into_iter().zip([DistanceBits::U16, DistanceBits::U8, DistanceBits::U16])
            {
                let options = DistanceOptions { size, metric, bits };
                let stored = DistanceMap::from_height(&map, DistanceKind::Boxes, &options).unwrap();
                for at in 0..size.iter().product() {
                    let voxel = [at % size[0], at / size[0] % size[1], at / size[0] / size[1]];
                    let d = stored.at(voxel[0], voxel[1], voxel[2]);
                    if d == 0.0 {
                        continue;
                    }
                    let p = random.point(stored.voxel_bounds(voxel));
                    let (_, upper) = exact_distance(&map, &pyramid, metric, p, 0.0);
                    assert!(d <= upper, "{size:?} {voxel:?} {p:?}: {d} over {upper}");
                    assert!(stored.safe_distance(p) <= upper);
                }
            }
        }
    }
}
