//! [`Sampler`]: Cook's jittered strata, as a pure function of pixel, dimension and sample.
//!
//! A dimension of a path (the place in the pixel, the point on a light, the direction of a gloss)
//! is a unit square. It is cut into as many cells as the pixel will take samples of it, each cell
//! holds one jittered point, and cells of different dimensions are associated by independent
//! random permutations [Cook1984]. Nothing is stored: cell order and jitter are hashes of seed,
//! pixel and dimension, so the numbers do not depend on the order in which they are asked for.
//!
//! What we changed: a count that is no product of two near factors gets the next larger grid, of
//! which the permutation leaves a random few cells empty. Each point on its own stays uniform, so
//! estimates stay unbiased. Permutations are hashed by cycle walking [Kensler2013].

pub mod warp;

use glam::DVec2;

/// What a point of the unit square is used for. `depth` counts bounces from the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// The place in the pixel.
    Pixel,
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

    /// `count` strata of a dimension; at least one.
    pub fn strata(&self, dimension: Dimension, count: u64) -> Strata {
        let (kind, detail) = match dimension {
            Dimension::Pixel => (0, 0),
            Dimension::Light { depth, light } => (1, u64::from(depth) << 32 | u64::from(light)),
            Dimension::Gloss { depth } => (2, u64::from(depth)),
        };
        let (nx, ny) = grid(count.max(1));
        Strata { key: hash(hash(hash(self.key, kind), detail), count), nx, ny }
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Strata {
    key: u64,
    nx: u64,
    ny: u64,
}

impl Strata {
    /// The point of sample `index`, in `[0, 1)^2`.
    pub fn point(&self, index: u64) -> DVec2 {
        let cell = permute(index % (self.nx * self.ny), self.nx * self.ny, self.key);
        let jitter = hash(self.key ^ JITTER, cell);
        let x = (cell % self.nx) as f64 + unit(jitter >> 32);
        let y = (cell / self.nx) as f64 + unit(jitter & 0xffff_ffff);
        let p = DVec2::new(x / self.nx as f64, y / self.ny as f64);
        p.min(DVec2::splat(1.0 - f64::EPSILON / 2.0))
    }
}

/// Keeps jitter apart from the permutation of the same key.
const JITTER: u64 = 0x9e6c_63d0_876a_68ee;

/// A 32-bit integer as a number in `[0, 1)`.
fn unit(bits: u64) -> f64 {
    bits as f64 * (0.5f64).powi(32)
}

/// Columns and rows of at least `count` cells: two near factors if there are such, else the
/// smallest near-square grid.
fn grid(count: u64) -> (u64, u64) {
    let root = (count as f64).sqrt();
    // Factors up to a ratio of 2: every power of two has such.
    let (most, least) = (root.floor() as u64, (root * 0.7).ceil().max(1.0) as u64);
    match (least..=most).rev().find(|d| count % d == 0) {
        Some(d) => (count / d, d),
        None => {
            let nx = root.ceil() as u64;
            (nx, count.div_ceil(nx))
        }
    }
}

/// A 64-bit hash of a key and a value: the SplitMix64 finaliser over their mix [Steele2014].
fn hash(key: u64, value: u64) -> u64 {
    let mut z = key ^ value.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(0x6a09_e667_f3bc_c909);
    for _ in 0..2 {
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
    }
    z
}

/// The image of `i` under the permutation of `0..count` that `key` names.
///
/// Each round is a bijection of the next power of two; walking on until the image lies below
/// `count` restricts it to a bijection of the range.
fn permute(i: u64, count: u64, key: u64) -> u64 {
    let mask = count.next_power_of_two() - 1;
    let shift = (mask.count_ones() / 2).max(1);
    let rounds = [hash(key, 1), hash(key, 2), hash(key, 3), hash(key, 4)];
    let mut i = i;
    loop {
        for k in rounds {
            i = (i ^ k) & mask;
            i = i.wrapping_mul(k >> 32 | 1) & mask;
            i ^= i >> shift;
            i = i.wrapping_add(k >> 24) & mask;
        }
        if i < count {
            return i;
        }
    }
}
