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
//! one along y, eight lines at a time ([`erosion`](super::erosion)), linear in the voxels. Heights are never cut into
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
use super::columns::Columns;
use super::domain::Domain;
use super::erosion::{Erosion, LINES, Place, larger};
use crate::map::HeightMap;
use crate::simd::{self, Kernel, Lanes, SimdLevel};

/// Distances from voxels to columns in exact integer squares.
#[derive(Debug)]
pub(super) struct Boxes {
    domain: Domain,
    size: [u32; 3],
    /// Scene units squared of one integer step.
    unit: f64,
    /// Its reciprocal.
    pub per_unit: f64,
    /// `wx^2` and `wy^2`, floored to steps.
    pub weights: [f64; 2],
    /// Height interval of each column.
    pub columns: Columns,
}

impl Boxes {
    /// The columns of `heights` under a grid of `size` voxels.
    pub fn new(heights: &HeightMap, domain: &Domain, size: [u32; 3]) -> Self {
        Self::over(domain, size, Columns::new(heights, [size[0], size[1]]))
    }

    /// The same over columns.
    pub fn over(domain: &Domain, size: [u32; 3], columns: Columns) -> Self {
        let [x, y, z] = domain.extents();
        let unit = (x * x + y * y + z * z) / (1u64 << 50) as f64;
        let weight = |side: f64, n: u32| {
            let voxel = side / f64::from(n);
            (voxel * voxel / unit).floor()
        };
        let weights = [weight(x, size[0]), weight(y, size[1])];
        Self { domain: *domain, size, unit, per_unit: 1.0 / unit, weights, columns }
    }

    /// Lowest and highest raw height of slab `k`.
    pub fn slab(&self, k: u32) -> (f64, f64) {
        let n = self.size[2];
        (self.domain.division(2, k, n), self.domain.division(2, k + 1, n))
    }

    /// Squared vertical gap between a slab and heights `[lo, hi]`, in integer steps.
    #[inline(always)]
    pub fn vertical(&self, slab: (f64, f64), (lo, hi): (f32, f32)) -> f64 {
        let gap = larger(larger(f64::from(lo) - slab.1, slab.0 - f64::from(hi)), 0.0);
        let gap = gap * self.domain.metric.z;
        whole(gap * gap * self.per_unit)
    }

    /// Squared distance across `gap` whole voxels along `axis`, in integer steps.
    #[inline]
    pub fn across(&self, axis: usize, gap: u32) -> f64 {
        self.weights[axis] * f64::from(gap) * f64::from(gap)
    }

    /// The distance of a squared distance in steps.
    #[inline(always)]
    pub fn distance(&self, steps: f64) -> f64 {
        (steps * self.unit).sqrt()
    }

    /// The squared distance, in steps, of a distance.
    pub fn steps(&self, distance: f64) -> f64 {
        distance * distance / self.unit
    }

    /// The codes of all voxels; slabs in parallel.
    pub fn codes<C: Code>(&self, quantiser: &Quantiser) -> Vec<C> {
        self.codes_at(SimdLevel::detect(), quantiser)
    }

    /// The codes of all voxels, made with given vector instructions.
    fn codes_at<C: Code>(&self, level: SimdLevel, quantiser: &Quantiser) -> Vec<C> {
        let [nx, ny, nz] = self.size.map(|n| n as usize);
        let mut codes = vec![C::default(); nx * ny * nz];
        codes.par_chunks_mut(nx * ny).enumerate().for_each_init(
            || Work::new(nx, ny),
            |work, (k, codes)| {
                let slab = self.slab(k as u32);
                simd::run(level, Slab { boxes: self, slab, quantiser, work, codes });
            },
        );
        codes
    }
}

/// The largest whole number not above `x`, of numbers from 0 to 2^51: without a call, and eight at a
/// time.
#[inline(always)]
fn whole(x: f64) -> f64 {
    let near = (x + TWO_52) - TWO_52;
    if near > x { near - 1.0 } else { near }
}

/// From here on, floats are whole numbers.
const TWO_52: f64 = (1u64 << 52) as f64;

/// A slab in the making.
struct Slab<'a, C> {
    boxes: &'a Boxes,
    /// Its lowest and highest raw height.
    slab: (f64, f64),
    quantiser: &'a Quantiser,
    work: &'a mut Work,
    codes: &'a mut [C],
}

impl<C: Code> Kernel for Slab<'_, C> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { boxes, slab, quantiser, work, codes } = self;
        let (nx, ny) = (boxes.size[0] as usize, boxes.size[1] as usize);
        let Work { steps, row, lines, erosion } = work;
        let bands = steps.chunks_mut(LINES * nx).zip(boxes.columns.bounds().chunks(LINES * nx));
        for (band, columns) in bands {
            let lines = &mut lines[..nx];
            for (lane, columns) in columns.chunks(nx).enumerate() {
                for (step, &column) in row.iter_mut().zip(columns) {
                    *step = boxes.vertical(slab, column);
                }
                for (place, &step) in lines.iter_mut().zip(&*row) {
                    place[lane] = step;
                }
            }
            erosion.transform(boxes.weights[0], lines);
            for (lane, band) in band.chunks_mut(nx).enumerate() {
                for (step, place) in band.iter_mut().zip(&*lines) {
                    *step = place[lane];
                }
            }
        }
        for first in (0..nx).step_by(LINES) {
            let width = LINES.min(nx - first);
            let lines = &mut lines[..ny];
            for (place, row) in lines.iter_mut().zip(steps.chunks(nx)) {
                match row[first..].first_chunk::<LINES>() {
                    Some(whole) => *place = *whole,
                    None => place[..width].copy_from_slice(&row[first..]),
                }
            }
            erosion.transform(boxes.weights[1], lines);
            for (place, row) in lines.iter().zip(codes.chunks_mut(nx)) {
                let found = place.map(|steps| quantiser.code(boxes.distance(steps)));
                for (code, found) in row[first..first + width].iter_mut().zip(found) {
                    *code = C::store(found);
                }
            }
        }
    }
}

/// A thread's working memory for one slab.
struct Work {
    steps: Vec<f64>,
    row: Vec<f64>,
    lines: Vec<Place>,
    erosion: Erosion,
}

impl Work {
    fn new(nx: usize, ny: usize) -> Self {
        let longest = nx.max(ny);
        Self {
            steps: vec![0.0; nx * ny],
            row: vec![0.0; nx],
            lines: vec![[0.0; LINES]; longest],
            erosion: Erosion::new(longest),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::codes::quantum;
    use super::super::fixtures::{Random, cases};
    use super::*;
    use crate::map::{
        DistanceBits, DistanceKind, DistanceMap, DistanceOptions, Pyramid, exact_distance,
    };

    /// Sizes below, at and above the number of cells, none dividing the other.
    const SIZES: [[u32; 3]; 3] = [[3, 4, 5], [7, 5, 2], [17, 13, 9]];

    #[test]
    fn every_level_makes_the_same_codes() {
        for (map, metric) in cases() {
            let domain = Domain::of(&map, metric).unwrap();
            for size in SIZES {
                let boxes = Boxes::new(&map, &domain, size);
                let bits = DistanceBits::U16;
                let quantiser = Quantiser::new(&domain, quantum(&domain, bits), bits);
                let want = boxes.codes_at::<u16>(SimdLevel::PORTABLE, &quantiser);
                for &level in SimdLevel::available() {
                    assert_eq!(boxes.codes_at::<u16>(level, &quantiser), want, "{level}");
                }
            }
        }
    }

    #[test]
    fn whole_numbers_are_floors() {
        let last = (1u64 << 51) as f64;
        for x in [0.0, 0.3, 0.5, 0.999, 1.0, 1.5, 2.5, 1e9 + 0.75, last - 0.25, last] {
            assert_eq!(whole(x), x.floor());
        }
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
                    let nearest = columns.bounds().iter().enumerate().map(|(c, &(lo, hi))| {
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
