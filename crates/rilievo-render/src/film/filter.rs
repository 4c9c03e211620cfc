//! [`Filter`]: pixel filters, by filter importance sampling.
//!
//! A camera ray belongs to one pixel only and its place is drawn from the filter \[Ernst2006\], so
//! every sample has weight 1, pixels stay independent, and an image does not depend on the order
//! in which tiles are done.

use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

use glam::DVec2;

/// The shape of a pixel's response, in pixels around its centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Filter {
    /// 1 over the pixel's own square.
    Box,
    /// A product of two hats of radius 1.
    Tent,
    /// A round Gaussian of standard deviation 1/2, cut at radius 3/2.
    Gaussian,
}

impl Filter {
    /// All filters.
    pub const ALL: [Self; 3] = [Self::Box, Self::Tent, Self::Gaussian];

    /// The name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Tent => "tent",
            Self::Gaussian => "gaussian",
        }
    }

    /// Largest distance from the pixel's centre along an axis, pixels.
    pub fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian => 1.5,
        }
    }

    /// The offset from the pixel's centre, distributed as the filter, for `u` uniform in
    /// `[0, 1)^2`.
    pub fn sample(self, u: DVec2) -> DVec2 {
        match self {
            Self::Box => u - 0.5,
            Self::Tent => DVec2::new(hat(u.x), hat(u.y)),
            Self::Gaussian => {
                let kept = 1.0 - (-self.radius().powi(2) / (2.0 * SIGMA * SIGMA)).exp();
                let r = SIGMA * (-2.0 * (1.0 - u.x * kept).ln()).sqrt();
                let (sin, cos) = (TAU * u.y).sin_cos();
                r * DVec2::new(cos, sin)
            }
        }
    }

    /// The density of [`Self::sample`], per square pixel.
    pub fn pdf(self, offset: DVec2) -> f64 {
        match self {
            Self::Box => f64::from(offset.abs().max_element() <= 0.5),
            Self::Tent => {
                let hats = (1.0 - offset.abs()).max(DVec2::ZERO);
                hats.x * hats.y
            }
            Self::Gaussian => {
                let (r2, limit) = (offset.length_squared(), self.radius().powi(2));
                let kept = 1.0 - (-limit / (2.0 * SIGMA * SIGMA)).exp();
                let inside = f64::from(r2 <= limit);
                inside * (-r2 / (2.0 * SIGMA * SIGMA)).exp() / (TAU * SIGMA * SIGMA * kept)
            }
        }
    }
}

/// Standard deviation of the Gaussian, pixels.
const SIGMA: f64 = 0.5;

/// Inverse of the cumulative hat on `[-1, 1]`.
fn hat(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

impl fmt::Display for Filter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that no filter has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no filter is called \"{0}\"; there are \"box\", \"tent\" and \"gaussian\"")]
pub struct UnknownFilter(pub String);

impl FromStr for Filter {
    type Err = UnknownFilter;

    fn from_str(name: &str) -> Result<Self, UnknownFilter> {
        let found = Self::ALL.into_iter().find(|filter| filter.name() == name);
        found.ok_or_else(|| UnknownFilter(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::chi_square::{chi_square_z, independent_points};

    #[test]
    fn samples_follow_the_density() {
        const CELLS: usize = 20;
        const FINE: usize = 32;
        const SAMPLES: u32 = 200_000;
        for filter in Filter::ALL {
            let radius = filter.radius();
            let mut observed = vec![0.0; CELLS * CELLS];
            for u in independent_points(SAMPLES) {
                let place = (filter.sample(u) / radius + 1.0) * 0.5 * CELLS as f64;
                let [x, y] = place.to_array().map(|x| (x as usize).min(CELLS - 1));
                observed[y * CELLS + x] += 1.0;
            }
            let n = CELLS * FINE;
            let step = 2.0 * radius / n as f64;
            let mut expected = vec![0.0; CELLS * CELLS];
            for at in 0..n * n {
                let p = DVec2::new((at % n) as f64 + 0.5, (at / n) as f64 + 0.5) * step - radius;
                let cell = at / n / FINE * CELLS + at % n / FINE;
                expected[cell] += filter.pdf(p) * step * step * f64::from(SAMPLES);
            }
            let total = expected.iter().sum::<f64>() / f64::from(SAMPLES);
            assert!((total - 1.0).abs() < 1e-3, "{filter}: {total}");
            let z = chi_square_z(&observed, &expected);
            assert!(z < 4.0, "{filter}: {z}");
        }
    }

    #[test]
    fn names_are_read_back() {
        for filter in Filter::ALL {
            assert_eq!(filter.to_string().parse(), Ok(filter));
        }
        assert!("sinc".parse::<Filter>().is_err());
    }
}
