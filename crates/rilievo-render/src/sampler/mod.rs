//! [`PathSampler`]: the numbers of a path; [`Sampler`]: Cook's jittered strata. Both are pure
//! functions of pixel, dimension and sample.
//!
//! The strata are the paper's, for trees of rays whose branches are known beforehand.
//! A dimension of a path (the place in the pixel, the point on a light, the direction of a gloss)
//! is a unit square. It is cut into as many cells as the pixel will take samples of it, each cell
//! holds one jittered point, and cells of different dimensions are associated by independent
//! random permutations \[Cook1984\]. Nothing is stored: cell order and jitter are hashes of seed,
//! pixel and dimension, so the numbers do not depend on the order in which they are asked for.
//!
//! What we changed: a count that is no product of two near factors gets the next larger grid, of
//! which the permutation leaves a random few cells empty. Each point on its own stays uniform, so
//! estimates stay unbiased. Permutations are hashed by cycle walking \[Kensler2013\].

pub mod path;
mod table;
pub mod warp;

pub use path::{PathSampler, SamplerKind};
pub(crate) use table::PixelTable;

use glam::DVec2;

/// What a point of the unit square is used for. `depth` counts bounces from the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// The place in the pixel.
    Pixel,
    /// The place on the lens.
    Lens,
    /// The time, by the first coordinate.
    Time,
    /// Which of two levels of detail, by the first coordinate.
    Level,
    /// The point on a light, by its index in the scene.
    Light {
        /// Bounces before.
        depth: u32,
        /// Index of the light.
        light: u32,
    },
    /// The direction of a glossy reflection.
    Gloss {
        /// Bounces before.
        depth: u32,
    },
    /// The direction of a diffuse bounce.
    Bounce {
        /// Bounces before.
        depth: u32,
    },
}

/// The random numbers of one pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    key: u64,
}

impl Sampler {
    /// The numbers of pixel (x, y) under `seed`.
    pub fn new(seed: u64, pixel: [u32; 2]) -> Self {
        let pixel = u64::from(pixel[1]) << 32 | u64::from(pixel[0]);
        Self { key: hash(hash(seed, 0), pixel) }
    }

    /// The key of the pixel, for shaders: low word first.
    pub fn words(&self) -> [u32; 2] {
        [self.key as u32, (self.key >> 32) as u32]
    }

    /// `count` strata of a dimension; at least one.
    pub fn strata(&self, dimension: Dimension, count: u64) -> Strata {
        let (kind, detail) = match dimension {
            Dimension::Pixel => (0, 0),
            Dimension::Light { depth, light } => (1, u64::from(depth) << 32 | u64::from(light)),
            Dimension::Gloss { depth } => (2, u64::from(depth)),
            Dimension::Bounce { depth } => (3, u64::from(depth)),
            Dimension::Lens => (4, 0),
            Dimension::Time => (5, 0),
            Dimension::Level => (6, 0),
        };
        let (nx, ny) = grid(count.max(1));
        let key = hash(hash(hash(self.key, kind), detail), count);
        let permutation = Permutation::new(nx * ny, key);
        let cell = DVec2::new(nx as f64, ny as f64).recip();
        Strata { jitter: hash(key, 0), permutation, nx, ny, cell }
    }
}

/// Which of a pixel's paths this is, among all paths of the pixel that were split alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strand {
    /// Index of the path, below `count`.
    pub index: u64,
    /// Number of paths.
    pub count: u64,
}

impl Strand {
    /// The path's `branch` of `branches`.
    pub fn split(self, branch: u32, branches: u32) -> Self {
        let branches = u64::from(branches);
        Self { index: self.index * branches + u64::from(branch), count: self.count * branches }
    }
}

/// The jittered points of one dimension of one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strata {
    jitter: u64,
    permutation: Permutation,
    nx: u64,
    ny: u64,
    /// Extent of a cell.
    cell: DVec2,
}

impl Strata {
    /// The point of sample `index`, in `[0, 1)^2`.
    pub fn point(&self, index: u64) -> DVec2 {
        self.point_in(self.permutation.image(index % (self.nx * self.ny)))
    }

    /// Appends the points of samples 0 to `count - 1`, which are no more than there are cells.
    fn extend(&self, count: u64, points: &mut Vec<DVec2>) {
        for first in (0..count).step_by(LANES) {
            let images = self.permutation.images(first);
            let some = images.into_iter().take((count - first) as usize);
            points.extend(some.map(|cell| self.point_in(cell)));
        }
    }

    /// The point of a cell.
    #[inline]
    fn point_in(&self, cell: u64) -> DVec2 {
        let jitter = hash(self.jitter, cell);
        // No division where a shift does.
        let (column, row) = if self.nx.is_power_of_two() {
            (cell & (self.nx - 1), cell >> self.nx.trailing_zeros())
        } else {
            (cell % self.nx, cell / self.nx)
        };
        // Below 2^63, and signed numbers convert in one instruction.
        let x = column as i64 as f64 + unit((jitter >> 32) as u32);
        let y = row as i64 as f64 + unit(jitter as u32);
        let p = DVec2::new(x, y) * self.cell;
        p.min(DVec2::splat(1.0 - f64::EPSILON / 2.0))
    }
}

/// 2^-32.
const INVERSE_2_32: f64 = 1.0 / 4_294_967_296.0;

/// A 32-bit integer as a number in `[0, 1)`.
fn unit(bits: u32) -> f64 {
    f64::from(bits) * INVERSE_2_32
}

/// Columns and rows of at least `count` cells: two near factors if there are such, else the
/// smallest near-square grid.
fn grid(count: u64) -> (u64, u64) {
    let root = (count as f64).sqrt();
    // Factors up to a ratio of 2: every power of two has such.
    let (most, least) = (root.floor() as u64, (root * 0.7).ceil().max(1.0) as u64);
    match (least..=most).rev().find(|&d| count.is_multiple_of(d)) {
        Some(d) => (count / d, d),
        None => {
            let nx = root.ceil() as u64;
            (nx, count.div_ceil(nx))
        }
    }
}

/// A 64-bit hash of a key and a value: the SplitMix64 finaliser over their mix \[Steele2014\].
fn hash(key: u64, value: u64) -> u64 {
    let mut z = key ^ value.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(0x6a09_e667_f3bc_c909);
    for _ in 0..2 {
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
    }
    z
}

/// Images of a permutation that are found at once.
const LANES: usize = 16;

/// A permutation of `0..count`, hashed.
///
/// Each round is a bijection of the next power of two; walking on until the image lies below
/// `count` restricts it to a bijection of the range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Permutation {
    count: u64,
    rounds: [u64; 8],
}

impl Permutation {
    /// The permutation of `0..count` that `key` names.
    fn new(count: u64, key: u64) -> Self {
        Self { count, rounds: [1, 2, 3, 4, 5, 6, 7, 8].map(|round| hash(key, round)) }
    }

    /// The images of `first` and the numbers after it, for counts up to 2^15; anything below
    /// `count` where a number is no longer below it. All arithmetic of [`Permutation::image`] is modulo a power of two no
    /// larger than 2^15, so 16 bits suffice.
    fn images(&self, first: u64) -> [u64; LANES] {
        let mask = (self.count.next_power_of_two() - 1) as u16;
        let shift = (mask.count_ones() / 2).max(1);
        let mut lanes: [u16; LANES] = std::array::from_fn(|k| first as u16 + k as u16);
        for k in self.rounds {
            let (flip, factor, offset) = (k as u16, (k >> 32) as u16 | 1, (k >> 24) as u16);
            for i in &mut lanes {
                *i = (*i ^ flip) & mask;
                *i = i.wrapping_mul(factor) & mask;
                *i ^= *i >> shift;
                *i = i.wrapping_add(offset) & mask;
            }
        }
        let mut images = lanes.map(u64::from);
        if !self.count.is_power_of_two() {
            for (k, image) in images.iter_mut().enumerate() {
                if first + k as u64 >= self.count {
                    *image = 0;
                } else if *image >= self.count {
                    // Walk on.
                    *image = self.image(*image);
                }
            }
        }
        images
    }

    /// The image of `i`, which must be below the next power of two of `count`.
    fn image(&self, mut i: u64) -> u64 {
        let mask = self.count.next_power_of_two() - 1;
        let shift = (mask.count_ones() / 2).max(1);
        loop {
            for k in self.rounds {
                i = (i ^ k) & mask;
                i = i.wrapping_mul(k >> 32 | 1) & mask;
                i ^= i >> shift;
                i = i.wrapping_add(k >> 24) & mask;
            }
            if i < self.count {
                return i;
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod chi_square;

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::chi_square::{chi_square_z, independent_points};
    use super::*;

    #[test]
    fn every_stratum_holds_one_point() {
        for count in [1, 2, 4, 6, 8, 16, 32, 144, 1024] {
            let (nx, ny) = grid(count);
            assert_eq!(nx * ny, count);
            let strata = Sampler::new(5, [8, 9]).strata(Dimension::Gloss { depth: 1 }, count);
            let cells: HashSet<_> = (0..count)
                .map(|i| strata.point(i) * DVec2::new(nx as f64, ny as f64))
                .map(|p| (p.x as u64, p.y as u64))
                .collect();
            assert_eq!(cells.len() as u64, count);
        }
    }

    #[test]
    fn permutations_are_bijections() {
        for count in (1..70).chain([1000, 4097]) {
            let images: HashSet<_> =
                (0..count).map(|i| Permutation::new(count, 3).image(i)).collect();
            assert_eq!(images.len() as u64, count);
            assert!(images.iter().all(|&i| i < count));
        }
    }

    #[test]
    fn pairs_of_images_are_uniform() {
        for count in [4u64, 5, 9, 16] {
            let n = 100_000;
            let mut observed = vec![0.0; (count * count) as usize];
            for key in 0..n {
                let [a, b] = [1, count - 1].map(|i| Permutation::new(count, key).image(i));
                observed[(a * count + b) as usize] += 1.0;
            }
            let pairs = (count * (count - 1)) as f64;
            let expected: Vec<f64> = (0..count * count)
                .map(|cell| if cell / count == cell % count { 0.0 } else { n as f64 / pairs })
                .collect();
            let z = chi_square_z(&observed, &expected);
            assert!(z < 4.0, "{count}: {z}");
        }
    }

    #[test]
    fn points_of_one_index_are_uniform_over_pixels() {
        // Counts with and without empty cells.
        for count in [1, 7, 13, 16] {
            let mut observed = vec![0.0; 1024];
            for i in 0..250_000 {
                let p = Sampler::new(1, [i % 500, i / 500])
                    .strata(Dimension::Pixel, count)
                    .point(3 % count);
                assert!(p.min_element() >= 0.0 && p.max_element() < 1.0);
                observed[(p.y * 32.0) as usize * 32 + (p.x * 32.0) as usize] += 1.0;
            }
            let z = chi_square_z(&observed, &[250_000.0 / 1024.0; 1024]);
            assert!(z < 4.0, "{count}: {z}");
        }
    }

    #[test]
    fn dimensions_and_pixels_are_independent() {
        let light = Dimension::Light { depth: 0, light: 0 };
        let other = Dimension::Light { depth: 0, light: 1 };
        let coordinate = |pixel, dimension| Sampler::new(2, pixel).strata(dimension, 16).point(5).x;
        let same = |pixel| coordinate(pixel, light);
        type Pair<'a> = &'a dyn Fn(u32, u32) -> [f64; 2];
        let pairs: [(&str, Pair<'_>); 3] = [
            ("dimensions", &|x, y| [same([x, y]), coordinate([x, y], other)]),
            ("columns", &|x, y| [same([2 * x, y]), same([2 * x + 1, y])]),
            ("rows", &|x, y| [same([x, 2 * y]), same([x, 2 * y + 1])]),
        ];
        for (name, pair) in pairs {
            let mut observed = vec![0.0; 256];
            for i in 0..100_000 {
                let [a, b] = pair(i % 400, i / 400).map(|x| (x * 16.0) as usize);
                observed[a * 16 + b] += 1.0;
            }
            let z = chi_square_z(&observed, &[100_000.0 / 256.0; 256]);
            assert!(z < 4.0, "{name}: {z}");
        }
    }

    #[test]
    fn stratified_means_converge_faster_than_random_ones() {
        let mean_square = |f: &dyn Fn(u32) -> f64| {
            (0..2000).map(|i| (f(i) - 1.0 / 3.0).powi(2)).sum::<f64>() / 2000.0
        };
        let stratified = mean_square(&|i| {
            let strata = Sampler::new(3, [i, 0]).strata(Dimension::Pixel, 64);
            (0..64).map(|k| strata.point(k).x.powi(2)).sum::<f64>() / 64.0
        });
        // Variance of x^2 is 4/45; strata leave 1/64 of it per sample, as 8 columns do.
        assert!(stratified < 2.0 * 4.0 / 45.0 / 64.0 / 64.0, "{stratified}");
        let mean: DVec2 = independent_points(100_000).sum::<DVec2>() / 100_000.0;
        assert!((mean - 0.5).abs().max_element() < 0.005);
    }
}
