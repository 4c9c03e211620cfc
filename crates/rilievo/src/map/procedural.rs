//! [`Procedural`]: height maps from formulas.
//!
//! Each is a height `h(u, v)` in `[0, 1]` over the unit square, sampled where the lattice puts its
//! samples. The vertex lattice is the natural one: its border samples lie on the border. `flat`,
//! `gaussian` and `studded` are the seed paper's maps \[Book2007\]; the others are test shapes with
//! known answers, and `fbm` stands for rough terrain.
//!
//! The noise of `fbm` is gradient noise \[Perlin2002\] over a periodic lattice: integer hashes and a
//! table of 16 directions, no transcendental function, so that a seed means one map everywhere. The
//! period makes it seamless under [`Wrap::Repeat`].

use super::height::{HeightMap, HeightMapError, Samples};
use super::lattice::{Axis, Lattice, Wrap};

/// Most octaves of `fbm`: the finest then has 2^18 lattice cells along the map.
const MAX_OCTAVES: u32 = 16;

/// Lattice cells of the coarsest octave along u and v.
const BASE_FREQUENCY: u32 = 4;

/// Most samples of a procedural map.
const MAX_SAMPLES: u64 = 1 << 31;

/// A height map given by a formula. Below, `x = 2 u - 1` and `y = 2 v - 1`, both in `[-1, 1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Procedural {
    /// `h = value`. The paper's `flatmap` has value 1.
    Flat {
        /// The height, in `[0, 1]`.
        value: f64,
    },
    /// `h = exp(-pi (x^2 + y^2))`.
    Gaussian,
    /// Square studs of height 1 on a ground of height 0, in equal rows and columns. Stud (i, j) of
    /// `studs` covers the middle half of its share of each axis: `i + 1/4 <= u * studs[0] < i + 3/4`
    /// and alike for v. Studs and gaps are equally wide; half a gap runs along the border. The
    /// flank is one cell wide, between the last high and the first low sample.
    Studded {
        /// Number of studs along u and v, at least 1.
        studs: [u32; 2],
    },
    /// Fractal sum of gradient noise: octave `o` has `4 * 2^o` lattice cells along the map and
    /// amplitude `2^-o`; the sum is scaled so that no value can leave `[0, 1]`, mean 1/2. Seamless
    /// when repeated.
    Fbm {
        /// Number of octaves, 1 to 16.
        octaves: u32,
        /// Chooses the map.
        seed: u64,
    },
    /// `h = u`: a plane.
    Ramp,
    /// `h = 0` for `u < 1/2`, else 1: a cliff one cell wide.
    Step,
    /// `h = 1 - |x|`: a ridge along v.
    Tent,
    /// `h = (1 + cos(2 pi waves r)) / 2` with `r = sqrt(x^2 + y^2)`: rings around the middle.
    Ripple {
        /// Waves between the middle and the border.
        waves: u32,
    },
}

/// Why a procedural map was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProceduralError {
    /// A flat map outside of `[0, 1]`.
    #[error("the value of a flat map lies in [0, 1], not {value}")]
    Value {
        /// The value given.
        value: f64,
    },
    /// No studs along an axis.
    #[error("a studded map has at least 1 stud along each axis, not {studs:?}")]
    Studs {
        /// The studs given.
        studs: [u32; 2],
    },
    /// No octaves, or too many.
    #[error("fbm has 1 to 16 octaves, not {octaves}")]
    Octaves {
        /// The octaves given.
        octaves: u32,
    },
    /// More samples than a procedural map may have.
    #[error("a procedural map has at most 2^31 samples, not {width} x {height}")]
    TooMany {
        /// Samples along u.
        width: u32,
        /// Samples along v.
        height: u32,
    },
    /// A size that no height map has.
    #[error(transparent)]
    Map(#[from] HeightMapError),
}

impl Procedural {
    /// The map in `u16` samples, rounded to nearest: `size` samples along u and v.
    ///
    /// # Errors
    /// [`ProceduralError`]; sizes and parameters are checked before anything is allocated.
    pub fn height_map(
        &self,
        size: [u32; 2],
        lattice: Lattice,
        wrap: Wrap,
    ) -> Result<HeightMap, ProceduralError> {
        let samples = self.sample(size, lattice, |h| (h * 65535.0).round() as u16)?;
        Ok(HeightMap::new(size[0], size[1], Samples::U16(samples), lattice, wrap)?)
    }

    /// The map in `f32` samples.
    ///
    /// # Errors
    /// As [`Procedural::height_map`].
    pub fn height_map_f32(
        &self,
        size: [u32; 2],
        lattice: Lattice,
        wrap: Wrap,
    ) -> Result<HeightMap, ProceduralError> {
        let samples = self.sample(size, lattice, |h| h as f32)?;
        Ok(HeightMap::new(size[0], size[1], Samples::F32(samples), lattice, wrap)?)
    }

    /// The height at (u, v) of the unit square, in `[0, 1]` for valid parameters.
    pub fn height(&self, u: f64, v: f64) -> f64 {
        let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        match *self {
            Self::Flat { value } => value,
            Self::Gaussian => (-std::f64::consts::PI * (x * x + y * y)).exp(),
            Self::Studded { studs } => {
                let high = |t: f64, n: u32| (0.25..0.75).contains(&(t * f64::from(n)).fract());
                f64::from(u8::from(high(u, studs[0]) && high(v, studs[1])))
            }
            Self::Fbm { octaves, seed } => fbm(u, v, octaves, seed),
            Self::Ramp => u,
            Self::Step => f64::from(u8::from(u >= 0.5)),
            Self::Tent => 1.0 - x.abs(),
            Self::Ripple { waves } => {
                let turns = f64::from(waves) * x.hypot(y);
                0.5 + 0.5 * (std::f64::consts::TAU * turns).cos()
            }
        }
    }

    fn check(&self) -> Result<(), ProceduralError> {
        match *self {
            Self::Flat { value } if !(0.0..=1.0).contains(&value) => {
                Err(ProceduralError::Value { value })
            }
            Self::Studded { studs } if studs.contains(&0) => Err(ProceduralError::Studs { studs }),
            Self::Fbm { octaves, .. } if !(1..=MAX_OCTAVES).contains(&octaves) => {
                Err(ProceduralError::Octaves { octaves })
            }
            _ => Ok(()),
        }
    }

    fn sample<T>(
        &self,
        [width, height]: [u32; 2],
        lattice: Lattice,
        encode: impl Fn(f64) -> T,
    ) -> Result<Vec<T>, ProceduralError> {
        self.check()?;
        if width < 2 || height < 2 {
            return Err(HeightMapError::TooSmall { width, height }.into());
        }
        if width > 1 << 24 || height > 1 << 24 {
            return Err(HeightMapError::TooLarge { width, height }.into());
        }
        let count = u64::from(width) * u64::from(height);
        if count > MAX_SAMPLES {
            return Err(ProceduralError::TooMany { width, height });
        }
        let axis = |n: u32| Axis::new(n, lattice, Wrap::Clamp);
        let (x, y) = (axis(width), axis(height));
        let mut samples = Vec::with_capacity(count as usize);
        for j in 0..height {
            let v = y.parameter(f64::from(j));
            samples.extend((0..width).map(|i| encode(self.height(x.parameter(f64::from(i)), v))));
        }
        Ok(samples)
    }
}

/// Fractal noise in `[0, 1]`, of period 1 in u and v.
fn fbm(u: f64, v: f64, octaves: u32, seed: u64) -> f64 {
    let (mut sum, mut most) = (0.0, 0.0);
    for octave in 0..octaves.min(MAX_OCTAVES) {
        let amplitude = 1.0 / f64::from(1u32 << octave);
        let seed = mix(seed ^ u64::from(octave).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        sum += amplitude * gradient_noise(u, v, BASE_FREQUENCY << octave, seed);
        most += amplitude;
    }
    // Unit gradients bound the noise by sqrt(1/2).
    0.5 + 0.5 * (sum / (most * std::f64::consts::FRAC_1_SQRT_2)).clamp(-1.0, 1.0)
}

/// Gradient noise with `frequency` lattice cells along the unit square, periodic.
fn gradient_noise(u: f64, v: f64, frequency: u32, seed: u64) -> f64 {
    let (x, y) = (u * f64::from(frequency), v * f64::from(frequency));
    let (i, j) = (x.floor(), y.floor());
    let (fx, fy) = (x - i, y - j);
    let corner = |di: i64, dj: i64| {
        let wrap = |k: f64, d: i64| (k as i64 + d).rem_euclid(i64::from(frequency)) as u64;
        let [gx, gy] = gradient(mix(seed ^ mix(wrap(i, di) ^ wrap(j, dj) << 32)));
        gx * (fx - di as f64) + gy * (fy - dj as f64)
    };
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let low = lerp(corner(0, 0), corner(1, 0), fade(fx));
    let high = lerp(corner(0, 1), corner(1, 1), fade(fx));
    lerp(low, high, fade(fy))
}

/// One of 16 unit vectors, evenly spread.
fn gradient(hash: u64) -> [f64; 2] {
    /// cos and sin of 0, 22.5, 45 and 67.5 degrees.
    const QUARTER: [[f64; 2]; 4] = [
        [1.0, 0.0],
        [0.923_879_532_511_286_7, 0.382_683_432_365_089_8],
        [std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2],
        [0.382_683_432_365_089_8, 0.923_879_532_511_286_7],
    ];
    let [x, y] = QUARTER[(hash & 3) as usize];
    match hash >> 2 & 3 {
        0 => [x, y],
        1 => [-y, x],
        2 => [-x, -y],
        _ => [y, -x],
    }
}

/// The finaliser of SplitMix64 \[Steele2014\]: a bijection that spreads every input bit.
fn mix(mut z: u64) -> u64 {
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertex(shape: Procedural, size: [u32; 2]) -> HeightMap {
        shape.height_map(size, Lattice::Vertex, Wrap::Clamp).unwrap()
    }

    #[test]
    fn the_gaussian_is_the_papers() {
        let map = vertex(Procedural::Gaussian, [257, 257]);
        assert_eq!(map.raw(128, 128), 65535.0);
        let corner = (-std::f64::consts::TAU).exp();
        assert!((map.height_at(0.0, 1.0) - corner).abs() < 1e-5);
        let half = (-std::f64::consts::PI * 0.25).exp();
        assert!((map.height_at(0.75, 0.5) - half).abs() < 1e-5);
    }

    #[test]
    fn studs_are_counted_along_each_axis_and_cover_a_quarter() {
        let size = [256, 240];
        let map = Procedural::Studded { studs: [8, 5] }
            .height_map(size, Lattice::Texel, Wrap::Repeat)
            .unwrap();
        let edges = |line: Vec<f32>| line.windows(2).filter(|w| w[0] < w[1]).count();
        assert_eq!(edges((0..size[0]).map(|i| map.raw(i, 24)).collect()), 8);
        assert_eq!(edges((0..size[1]).map(|j| map.raw(16, j)).collect()), 5);
        let Samples::U16(codes) = map.samples() else { panic!("u16 by default") };
        assert!(codes.iter().all(|&c| c == 0 || c == 65535));
        let high = codes.iter().filter(|&&c| c > 0).count();
        assert_eq!(high * 4, codes.len());
        assert!((0..size[0]).all(|i| map.raw(i, 0) == 0.0));
    }

    #[test]
    fn fbm_depends_on_its_seed_alone_varies_and_repeats_without_a_seam() {
        let shape = Procedural::Fbm { octaves: 6, seed: 7 };
        let map = shape.height_map_f32([65, 33], Lattice::Vertex, Wrap::Repeat).unwrap();
        assert_eq!(map, shape.height_map_f32([65, 33], Lattice::Vertex, Wrap::Repeat).unwrap());
        let other = Procedural::Fbm { octaves: 6, seed: 8 };
        assert_ne!(map, other.height_map_f32([65, 33], Lattice::Vertex, Wrap::Repeat).unwrap());
        let (lo, hi) = map.raw_range();
        assert!(lo >= 0.0 && hi <= 1.0 && hi - lo > 0.3, "{lo} to {hi}");
        assert!((0..33).all(|j| map.raw(0, j) == map.raw(64, j)));
        assert!((0..65).all(|i| map.raw(i, 0) == map.raw(i, 32)));
    }

    #[test]
    fn test_shapes_follow_their_formulas() {
        let at = |shape: Procedural, u: f64| shape.height(u, 0.5);
        assert_eq!([0.0, 0.25, 1.0].map(|u| at(Procedural::Ramp, u)), [0.0, 0.25, 1.0]);
        assert_eq!([0.0, 0.49, 0.5, 1.0].map(|u| at(Procedural::Step, u)), [0.0, 0.0, 1.0, 1.0]);
        assert_eq!([0.0, 0.25, 0.5, 1.0].map(|u| at(Procedural::Tent, u)), [0.0, 0.5, 1.0, 0.0]);
        let ripple = Procedural::Ripple { waves: 3 };
        assert!((at(ripple, 0.5) - 1.0).abs() < 1e-12 && (at(ripple, 1.0) - 1.0).abs() < 1e-12);
        assert!(at(ripple, 0.5 + 0.25 / 3.0).abs() < 1e-12);
        assert_eq!(vertex(Procedural::Flat { value: 1.0 }, [2, 3]).raw_range(), (65535.0, 65535.0));
    }

    #[test]
    fn bad_parameters_and_sizes_are_refused_before_allocation() {
        let make = |shape: Procedural, size| {
            shape.height_map(size, Lattice::Vertex, Wrap::Clamp).unwrap_err()
        };
        let value = 1.5;
        assert_eq!(make(Procedural::Flat { value }, [2, 2]), ProceduralError::Value { value });
        let studs = [3, 0];
        assert_eq!(make(Procedural::Studded { studs }, [2, 2]), ProceduralError::Studs { studs });
        let octaves = 17;
        let fbm = Procedural::Fbm { octaves, seed: 0 };
        assert_eq!(make(fbm, [2, 2]), ProceduralError::Octaves { octaves });
        let small = HeightMapError::TooSmall { width: 1, height: 9 };
        assert_eq!(make(Procedural::Ramp, [1, 9]), ProceduralError::Map(small));
        let (width, height) = (1 << 24, 1 << 24);
        let many = ProceduralError::TooMany { width, height };
        assert_eq!(make(Procedural::Ramp, [width, height]), many);
    }
}
