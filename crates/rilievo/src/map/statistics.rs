//! [`HeightStatistics`]: what the samples of a height map say about it.

use super::height::{HeightMap, Samples};
use super::lattice::Lattice;

/// Facts about the samples of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightStatistics {
    /// Distinct values.
    pub levels: u64,
    /// The border along x, between the last column and the first, and the one along y.
    pub seams: [Seam; 2],
}

/// Differences of neighbouring samples across a border that repeats, and everywhere else along the
/// same axis. In heights, not negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seam {
    /// Largest difference across the border.
    pub largest: f64,
    /// Mean difference across the border.
    pub mean: f64,
    /// Largest difference inside.
    pub inner_largest: f64,
    /// Mean difference inside.
    pub inner_mean: f64,
    /// Whether the border should be taken for one that repeats, see [`Seam::tiles`].
    tiles: bool,
}

impl Seam {
    /// Whether the map repeats without a visible border. A vertex lattice shows its first and its
    /// last sample at the same place: they must be equal. Of a texel lattice they are neighbours:
    /// the difference may be at most twice the largest inside, at most three times the mean inside.
    pub fn tiles(&self) -> bool {
        self.tiles
    }
}

impl HeightStatistics {
    /// Looks at every sample of `heights`.
    pub fn of(heights: &HeightMap) -> Self {
        let (w, h) = (heights.width(), heights.height());
        let along_x = seam(heights, [w, h], |i, j| heights.raw(i, j));
        let along_y = seam(heights, [h, w], |i, j| heights.raw(j, i));
        Self { levels: levels(heights.samples()), seams: [along_x, along_y] }
    }
}

/// The seam between the last and the first of `n` samples on each of `lines` lines.
fn seam(heights: &HeightMap, [n, lines]: [u32; 2], raw: impl Fn(u32, u32) -> f32) -> Seam {
    let unit = heights.unit();
    let step = |i: u32, k: u32, line: u32| {
        (f64::from(raw(i, line)) - f64::from(raw(k, line))).abs() * unit
    };
    let (mut across, mut inside) = ((0.0f64, 0.0), (0.0f64, 0.0));
    let add = |sum: &mut (f64, f64), d: f64| *sum = (sum.0.max(d), sum.1 + d);
    for line in 0..lines {
        add(&mut across, step(n - 1, 0, line));
        (1..n).for_each(|i| add(&mut inside, step(i - 1, i, line)));
    }
    let lines = f64::from(lines);
    let (mean, inner_mean) = (across.1 / lines, inside.1 / (lines * f64::from(n - 1)));
    let tiles = match heights.x().lattice() {
        Lattice::Vertex => across.0 == 0.0,
        Lattice::Texel => across.0 <= 2.0 * inside.0 && mean <= 3.0 * inner_mean,
    };
    Seam { largest: across.0, mean, inner_largest: inside.0, inner_mean, tiles }
}

/// Number of distinct values.
fn levels(samples: &Samples) -> u64 {
    match samples {
        Samples::U16(codes) => {
            let mut seen = vec![false; 1 << 16];
            codes.iter().for_each(|&code| seen[usize::from(code)] = true);
            seen.iter().filter(|&&seen| seen).count() as u64
        }
        Samples::F32(values) => {
            let mut sorted = values.clone();
            sorted.sort_unstable_by(f32::total_cmp);
            // By value, so that both zeros are one level.
            sorted.dedup();
            sorted.len() as u64
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Procedural, Wrap};

    #[test]
    fn a_ramp_tiles_across_but_not_along_its_slope() {
        let ramp = Procedural::Ramp.height_map([17, 9], Lattice::Vertex, Wrap::Repeat).unwrap();
        let found = HeightStatistics::of(&ramp);
        assert_eq!(found.levels, 17);
        let [x, y] = found.seams;
        assert!(!x.tiles() && y.tiles());
        assert_eq!((x.largest, x.mean, y.largest, y.inner_mean), (1.0, 1.0, 0.0, 0.0));
        assert!((x.inner_mean - 1.0 / 16.0).abs() < 1e-12);
        let texel = HeightStatistics::of(&ramp.with_lattice(Lattice::Texel, Wrap::Repeat));
        assert!(!texel.seams[0].tiles() && texel.seams[1].tiles());
    }

    #[test]
    fn periodic_noise_tiles_and_a_cut_out_of_it_does_not() {
        let noise = Procedural::Fbm { octaves: 4, seed: 3 };
        let map = noise.height_map([64, 64], Lattice::Texel, Wrap::Repeat).unwrap();
        assert!(HeightStatistics::of(&map).seams.iter().all(Seam::tiles));
        let cut: Vec<f32> = (0..64 * 40).map(|k| map.raw(k % 40, k / 40)).collect();
        let cut = HeightMap::new(40, 64, Samples::F32(cut), Lattice::Texel, Wrap::Repeat).unwrap();
        let [x, y] = HeightStatistics::of(&cut).seams;
        assert!(!x.tiles() && y.tiles(), "{x:?} {y:?}");
    }

    #[test]
    fn both_zeros_are_one_level() {
        let samples = Samples::F32(vec![0.0, -0.0, 1.0, 1.0]);
        let map = HeightMap::new(2, 2, samples, Lattice::Texel, Wrap::Repeat).unwrap();
        assert_eq!(HeightStatistics::of(&map).levels, 2);
    }
}
