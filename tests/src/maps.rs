//! Height maps for the suites, made here so that no shape of the library is needed to judge it.

use rilievo::map::{HeightMap, Lattice, Samples, Wrap};

use crate::random::Random;

/// A shape on the unit square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// One height.
    Flat(f64),
    /// Rises along u and v by these amounts.
    Ramp(f64, f64),
    /// `exp(-pi (x^2 + y^2))` on `[-1, 1]^2`.
    Gaussian,
    /// Square studs, so many on each axis, upright within one cell.
    Studs(u32),
    /// A ridge along v in the middle.
    Tent,
    /// A cliff along v at u = 0.45.
    Step,
    /// Value noise, five octaves.
    Fbm(u64),
    /// An independent height at every sample.
    White(u64),
    /// Zero but for one sample.
    Spike,
    /// Concentric waves.
    Ripple,
}

impl Shape {
    fn height(self, [i, j]: [u32; 2], [w, h]: [u32; 2]) -> f64 {
        let (u, v) = (f64::from(i) / f64::from(w - 1), f64::from(j) / f64::from(h - 1));
        let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        match self {
            Self::Flat(height) => height,
            Self::Ramp(a, b) => a * u + b * v,
            Self::Gaussian => (-std::f64::consts::PI * (x * x + y * y)).exp(),
            Self::Studs(n) => {
                let raised = |s: f64| (s * f64::from(n)).fract() >= 0.5;
                if raised(u) && raised(v) { 1.0 } else { 0.25 }
            }
            Self::Tent => 1.0 - x.abs(),
            Self::Step => f64::from(u8::from(u > 0.45)),
            Self::Fbm(seed) => fbm(seed, u, v),
            Self::White(seed) => Random::new(&[seed, u64::from(i), u64::from(j)]).unit(),
            Self::Spike => f64::from(u8::from([i, j] == [w * 3 / 5, h * 2 / 5])),
            Self::Ripple => 0.5 + 0.5 * (20.0 * (x * x + y * y).sqrt()).cos(),
        }
    }

    /// The shape as `u16` codes.
    ///
    /// # Panics
    /// If a side is below 2.
    pub fn codes(self, size: [u32; 2], lattice: Lattice, wrap: Wrap) -> HeightMap {
        let codes = grid(size)
            .map(|at| (self.height(at, size).clamp(0.0, 1.0) * 65535.0).round() as u16)
            .collect();
        HeightMap::new(size[0], size[1], Samples::U16(codes), lattice, wrap)
            .expect("codes are always valid")
    }

    /// The shape as `f32` heights.
    ///
    /// # Panics
    /// If a side is below 2.
    pub fn floats(self, size: [u32; 2], lattice: Lattice, wrap: Wrap) -> HeightMap {
        let heights = grid(size).map(|at| self.height(at, size) as f32).collect();
        HeightMap::new(size[0], size[1], Samples::F32(heights), lattice, wrap)
            .expect("shapes are finite")
    }
}

fn grid([w, h]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    (0..h).flat_map(move |j| (0..w).map(move |i| [i, j]))
}

/// Value noise with a smoothstep, halved and doubled five times, in `[0, 1]`.
fn fbm(seed: u64, u: f64, v: f64) -> f64 {
    let mut sum = 0.0;
    for octave in 0..5 {
        let frequency = 4.0 * f64::from(1 << octave);
        let (x, y) = (u * frequency, v * frequency);
        let value = |i: f64, j: f64| Random::new(&[seed, octave as u64, i as u64, j as u64]).unit();
        let (i, j) = (x.floor(), y.floor());
        let smooth = |s: f64| s * s * (3.0 - 2.0 * s);
        let (fx, fy) = (smooth(x - i), smooth(y - j));
        let low = value(i, j) + (value(i + 1.0, j) - value(i, j)) * fx;
        let high = value(i, j + 1.0) + (value(i + 1.0, j + 1.0) - value(i, j + 1.0)) * fx;
        sum += (low + (high - low) * fy) * 0.5 / f64::from(1 << octave);
    }
    sum
}
