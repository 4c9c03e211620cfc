//! Maps and random points for the tests of this folder.

use crate::map::{HeightMap, Lattice, Metric, Procedural, Samples, Wrap};

/// A 64-bit linear congruential generator with the constants of MMIX.
pub(super) struct Random(pub u64);

impl Random {
    /// The next number in `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A point between two corners; each coordinate is one of the ends a third of the time.
    pub fn point(&mut self, (low, high): ([f64; 3], [f64; 3])) -> [f64; 3] {
        std::array::from_fn(|a| {
            let t = (self.unit() * 1.5 - 0.25).clamp(0.0, 1.0);
            low[a] + (high[a] - low[a]) * t
        })
    }
}

/// White noise: the roughest map there is.
pub(super) fn noise([w, h]: [u32; 2], lattice: Lattice, wrap: Wrap) -> HeightMap {
    let mut random = Random(9);
    let samples = (0..w * h).map(|_| (random.unit() * 65535.0) as u16).collect();
    HeightMap::new(w, h, Samples::U16(samples), lattice, wrap).unwrap()
}

/// Maps of both sample types, both lattices and all wraps, none square, each with a metric; flat
/// faces, deep ones and stretched ones.
pub(super) fn cases() -> Vec<(HeightMap, Metric)> {
    let (vertex, texel) = (Lattice::Vertex, Lattice::Texel);
    let studs = Procedural::Studded { studs: [2, 3] };
    let fbm = Procedural::Fbm { octaves: 3, seed: 3 };
    let maps = [
        noise([7, 5], vertex, Wrap::Repeat),
        noise([6, 9], texel, Wrap::Repeat),
        studs.height_map([12, 10], texel, Wrap::Mirror).unwrap(),
        Procedural::Step.height_map([8, 3], vertex, Wrap::Clamp).unwrap(),
        fbm.height_map_f32([11, 14], texel, Wrap::Clamp).unwrap(),
        Procedural::Gaussian.height_map_f32([10, 9], vertex, Wrap::Mirror).unwrap(),
        Procedural::Flat { value: 0.5 }.height_map([3, 2], vertex, Wrap::Repeat).unwrap(),
    ];
    let faces = [([1.0, 1.0], 0.3), ([3.0, 0.5], 1.5), ([1.0, 4.0], 0.02)];
    let mut cases = Vec::new();
    for map in maps {
        for (sides, scale) in faces {
            let metric = Metric::of_face(&map, sides, scale);
            cases.push((map.clone(), metric));
        }
    }
    cases
}
