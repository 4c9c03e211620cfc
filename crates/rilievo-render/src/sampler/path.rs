//! [`PathSampler`]: the numbers of one path, by pixel and absolute sample index.
//!
//! A path asks for numbers and pairs of numbers one after the other; each call is a dimension of
//! its own. All is a function of seed, pixel, sample index and the count of calls before, so the
//! samples of a pixel may be taken in any order, by anyone, on any day.
//!
//! [`SamplerKind::Sobol`], the default, gives every dimension a two-dimensional Sobol sequence of
//! its own (padding): its first two coordinates are a (0,2)-sequence, so every aligned run of 2^k
//! samples puts one point into each of the 2^k boxes of any shape 2^-a x 2^-(k-a). Both coordinates
//! are Owen-scrambled \[Owen1995\] and the order of samples is shuffled by the same nested scramble,
//! which keeps aligned runs together and leaves dimensions independent of each other
//! \[Burley2020\]. Nothing depends on how many samples there will be. Keys are hashes of pixel and
//! dimension, so pixels are independent too and one sample per pixel is white noise; sequences
//! spread over the screen as blue noise would need the number of samples beforehand.
//!
//! What we changed. Scrambles are Laine's and Karras' hash \[Laine2011\], in which a bit is flipped
//! by what lies below it; Burley's takes a key of 32 bits once, ours 64 bits of it in two rounds. The second
//! coordinate is the first times Pascal's triangle modulo 2, which is the sum over supersets of bit
//! places: five shifts instead of a table \[Ahmed2024\]. As bits are scrambled from the least
//! upwards and numbers are read from the most downwards, all is done on reversed numbers and
//! each coordinate is reversed once, at the end.
//!
//! [`SamplerKind::Jittered`] cuts each dimension into as many cells as there will be samples, as
//! [`super::Strata`] does for the paper's integrator. [`SamplerKind::Independent`] hashes.

use std::fmt;
use std::str::FromStr;

use glam::DVec2;

use super::{INVERSE_2_32, Permutation, grid, hash, unit};

/// Where the numbers of a path come from. Named in scene files and on the command line by its
/// [`fmt::Display`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SamplerKind {
    /// Owen-scrambled Sobol pairs: the error falls faster than with independent numbers.
    #[default]
    Sobol,
    /// Independent numbers.
    Independent,
    /// One jittered number in each of as many cells as there are samples.
    Jittered,
}

impl SamplerKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Sobol, Self::Independent, Self::Jittered];

    /// The name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sobol => "sobol",
            Self::Independent => "independent",
            Self::Jittered => "jittered",
        }
    }
}

impl fmt::Display for SamplerKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that no sampler has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no sampler is called \"{0}\"; there are \"sobol\", \"independent\" and \"jittered\"")]
pub struct UnknownSampler(pub String);

impl FromStr for SamplerKind {
    type Err = UnknownSampler;

    fn from_str(name: &str) -> Result<Self, UnknownSampler> {
        let found = Self::ALL.into_iter().find(|kind| kind.name() == name);
        found.ok_or_else(|| UnknownSampler(name.to_owned()))
    }
}

/// The numbers of one path.
#[derive(Clone, Copy, Debug)]
pub struct PathSampler {
    /// Of seed and pixel, and for independent numbers of the sample.
    key: u64,
    dimension: u64,
    source: Source,
}

/// What a kind keeps of a sample.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// The sample index, reversed.
    Sobol(u32),
    Independent,
    Jittered {
        index: u64,
        count: u64,
        grid: (u64, u64),
    },
}

impl PathSampler {
    /// The numbers of sample `sample` of a pixel. `samples`, the number of them that there will be,
    /// is the number of cells of [`SamplerKind::Jittered`] and means nothing to the other kinds; a
    /// sample beyond it begins another set of cells.
    pub fn new(kind: SamplerKind, seed: u64, pixel: [u32; 2], sample: u64, samples: u64) -> Self {
        let place = u64::from(pixel[1]) << 32 | u64::from(pixel[0]);
        let pixel = hash(hash(seed, 0), place);
        let (key, source) = match kind {
            // A sequence has 2^32 points; the next ones come from another.
            SamplerKind::Sobol => {
                (hash(pixel, 1 + (sample >> 32)), Source::Sobol((sample as u32).reverse_bits()))
            }
            SamplerKind::Independent => (hash(pixel, sample), Source::Independent),
            SamplerKind::Jittered => {
                let count = samples.max(1);
                let (index, grid) = (sample % count, grid(count));
                (hash(pixel, 1 + sample / count), Source::Jittered { index, count, grid })
            }
        };
        Self { key, dimension: 0, source }
    }

    /// The next number, in `[0, 1)`.
    #[inline]
    pub fn one(&mut self) -> f64 {
        let key = self.next_key();
        match self.source {
            Source::Sobol(sample) => {
                let index = shuffled(sample, key);
                unit(scrambled(index, mixed(key, 1)).reverse_bits())
            }
            // 53 bits.
            Source::Independent => (key >> 11) as f64 * (INVERSE_2_32 / 2_097_152.0),
            Source::Jittered { index, count, .. } => jittered(key, (count, 1), index).x,
        }
    }

    /// The next pair of numbers, in `[0, 1)^2`, spread well over the square as a pair.
    #[inline]
    pub fn two(&mut self) -> DVec2 {
        let key = self.next_key();
        match self.source {
            Source::Sobol(sample) => {
                let index = shuffled(sample, key);
                let x = scrambled(index, mixed(key, 1));
                let y = scrambled(second(index), mixed(key, 2));
                // Both are reversed at once.
                let both = (u64::from(x) << 32 | u64::from(y)).reverse_bits();
                DVec2::new(unit(both as u32), unit((both >> 32) as u32))
            }
            Source::Independent => DVec2::new(unit((key >> 32) as u32), unit(key as u32)),
            Source::Jittered { index, grid, .. } => jittered(key, grid, index),
        }
    }

    /// For shaders: the key, low word first; what is kept of the sample; how many numbers and pairs were taken.
    pub fn words(&self) -> [u32; 4] {
        let sample = match self.source {
            Source::Sobol(sample) => sample,
            Source::Independent => 0,
            // A sample is below the count of samples.
            Source::Jittered { index, .. } => index as u32,
        };
        [self.key as u32, (self.key >> 32) as u32, sample, self.dimension as u32]
    }

    /// Goes to a dimension: as if so many numbers or pairs had been taken.
    ///
    /// Paths of a pixel that differ in what they met agree again on what a dimension is used for.
    #[inline]
    pub fn seek(&mut self, dimension: u32) {
        self.dimension = u64::from(dimension);
    }

    #[inline]
    fn next_key(&mut self) -> u64 {
        self.dimension += 1;
        hash(self.key, self.dimension)
    }
}

/// A key of its own for each of a dimension's scrambles: one round of the SplitMix64 finaliser.
#[inline]
fn mixed(key: u64, which: u64) -> u64 {
    let mut z = key.wrapping_add(which.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A permutation of the 32-bit numbers in which each bit is flipped by a hash of those below it.
#[inline]
fn scrambled(mut x: u32, key: u64) -> u32 {
    let [low, high] = [key as u32, (key >> 32) as u32];
    x = x.wrapping_add(low);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x = x.wrapping_mul(high | 1);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x = x.wrapping_add(high.rotate_left(16));
    x ^= x.wrapping_mul(0xc7af_e638);
    x = x.wrapping_mul(low.rotate_left(16) | 1);
    x ^ x.wrapping_mul(0x8d22_f6e6)
}

/// The index of a sample, given reversed, in the order of a dimension: each bit is flipped by a
/// hash of those above it, so numbers below 2^k stay together.
#[inline]
fn shuffled(reversed: u32, key: u64) -> u32 {
    scrambled(reversed, key).reverse_bits()
}

/// The second Sobol coordinate of `index`, reversed as the first one is `index` itself: the bit of
/// place j is the sum modulo 2 of the bits of all places whose binary digits hold those of j.
#[inline]
fn second(index: u32) -> u32 {
    let mut v = index;
    v ^= v >> 16;
    v ^= (v & 0xff00_ff00) >> 8;
    v ^= (v & 0xf0f0_f0f0) >> 4;
    v ^= (v & 0xcccc_cccc) >> 2;
    v ^ (v & 0xaaaa_aaaa) >> 1
}

/// The jittered point of a sample in a grid of columns and rows.
fn jittered(key: u64, (columns, rows): (u64, u64), index: u64) -> DVec2 {
    let cell = Permutation::new(columns * rows, key).image(index);
    let jitter = hash(key, cell);
    let corner = DVec2::new((cell % columns) as f64, (cell / columns) as f64);
    let place = corner + DVec2::new(unit((jitter >> 32) as u32), unit(jitter as u32));
    let point = place / DVec2::new(columns as f64, rows as f64);
    point.min(DVec2::splat(1.0 - f64::EPSILON / 2.0))
}

#[cfg(test)]
mod tests;
