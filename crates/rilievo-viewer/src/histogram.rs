//! [`Histogram`]: how often heights occur on a map.

use rilievo::map::HeightMap;

/// Bins.
pub const BINS: usize = 128;
/// About how many samples are looked at: a picture needs no more.
const SAMPLES: u64 = 1 << 20;

/// How often heights occur.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Lowest and highest height.
    pub range: [f64; 2],
    /// Samples by height, from the lowest to the highest; of large maps, of a grid of them.
    pub counts: Vec<u32>,
}

impl Histogram {
    /// The histogram of a map.
    pub fn of(map: &HeightMap) -> Self {
        let (low, high) = map.raw_range();
        let span = (high - low).max(f32::MIN_POSITIVE);
        let all = u64::from(map.width()) * u64::from(map.height());
        let step = ((all / SAMPLES) as f64).sqrt().floor().max(1.0) as usize;
        let mut counts = vec![0; BINS];
        for j in (0..map.height()).step_by(step) {
            for i in (0..map.width()).step_by(step) {
                let at = (map.raw(i, j) - low) / span * BINS as f32;
                counts[(at as usize).min(BINS - 1)] += 1;
            }
        }
        let range = [low, high].map(|raw| f64::from(raw) * map.unit());
        Self { range, counts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rilievo::map::{Lattice, Samples, Wrap};

    fn map(width: u32, height: u32, code: impl Fn(u32, u32) -> u16) -> HeightMap {
        let samples = (0..height).flat_map(|j| (0..width).map(move |i| (i, j)));
        let samples = Samples::U16(samples.map(|(i, j)| code(i, j)).collect());
        HeightMap::new(width, height, samples, Lattice::Texel, Wrap::Repeat).unwrap()
    }

    #[test]
    fn a_ramp_fills_all_bins_alike_and_a_flat_map_one() {
        let ramp = Histogram::of(&map(256, 4, |i, _| (i * 257) as u16));
        assert_eq!(ramp.range, [0.0, 1.0]);
        assert!(ramp.counts.iter().all(|&count| count == 8), "{ramp:?}");
        let flat = Histogram::of(&map(8, 8, |_, _| 13_107));
        assert_eq!((flat.range, flat.counts[0]), ([0.2, 0.2], 64));
    }

    #[test]
    fn large_maps_are_looked_at_on_a_grid() {
        let large = Histogram::of(&map(4096, 2048, |i, j| ((i + j) % 2) as u16));
        let seen: u32 = large.counts.iter().sum();
        assert!((1 << 18..1 << 22).contains(&seen), "{seen}");
    }
}
