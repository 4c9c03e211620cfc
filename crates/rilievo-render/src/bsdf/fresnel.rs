//! What a smooth interface reflects, unpolarised.

use crate::colour::Rgb;

/// The fifth power of `1 - cosine`: Schlick's share of grazing light \[Schlick1994\].
#[inline]
pub(super) fn grazing(cosine: f64) -> f64 {
    let s = (1.0 - cosine).clamp(0.0, 1.0);
    let s2 = s * s;
    s2 * s2 * s
}

/// Reflectance of a clear body whose index is `eta` times that of the side where light meets it at
/// `cosine >= 0`, and the cosine inside; 1 and 0 where all is reflected.
#[inline]
pub(super) fn clear(cosine: f64, eta: f64) -> (f64, f64) {
    let sin2 = (1.0 - cosine * cosine) / (eta * eta);
    if sin2 >= 1.0 {
        return (1.0, 0.0);
    }
    let inside = (1.0 - sin2).max(0.0).sqrt();
    let parallel = (eta * cosine - inside) / (eta * cosine + inside);
    let upright = (cosine - eta * inside) / (cosine + eta * inside);
    (0.5 * (parallel * parallel + upright * upright), inside)
}

/// Reflectance of a metal.
#[derive(Clone, Copy, Debug)]
pub(super) enum MetalFresnel {
    /// Schlick's formula less a dip around 82 degrees, where the cosine is 1/7 \[Kutz2021\].
    Dip {
        /// Straight on.
        facing: Rgb,
        /// Factor on `cosine (1 - cosine)^6`.
        dip: Rgb,
    },
    /// The complex index `eta - i k`, exactly.
    Index {
        /// Real part.
        eta: Rgb,
        /// Absorption.
        k: Rgb,
    },
}

impl MetalFresnel {
    /// A metal that reflects `facing` straight on, and `edge` times Schlick's value at 82 degrees.
    pub(super) fn of_colours(facing: Rgb, edge: Rgb) -> Self {
        let cosine = 1.0 / 7.0;
        let schlick = facing + (1.0 - facing) * grazing(cosine);
        let dip = schlick * (1.0 - edge) / (cosine * grazing(cosine) * (1.0 - cosine));
        Self::Dip { facing, dip }
    }

    /// Straight on.
    pub(super) fn facing(&self) -> Rgb {
        match self {
            Self::Dip { facing, .. } => *facing,
            Self::Index { .. } => self.at(1.0),
        }
    }

    /// At `cosine` with the normal.
    #[inline]
    pub(super) fn at(&self, cosine: f64) -> Rgb {
        match self {
            Self::Dip { facing, dip } => {
                let edge = grazing(cosine);
                let value = *facing + (1.0 - *facing) * edge;
                (value - *dip * (cosine * edge * (1.0 - cosine))).max(Rgb::ZERO)
            }
            Self::Index { eta, k } => Rgb::from([0, 1, 2].map(|c| absorbing(cosine, eta[c], k[c]))),
        }
    }
}

/// Reflectance of an interface of complex index `eta - i k`.
fn absorbing(cosine: f64, eta: f64, k: f64) -> f64 {
    let c2 = cosine * cosine;
    let s2 = 1.0 - c2;
    let difference = eta * eta - k * k - s2;
    let length = (difference * difference + 4.0 * eta * eta * k * k).sqrt();
    let a = (0.5 * (length + difference)).max(0.0).sqrt();
    let upright = (length + c2 - 2.0 * a * cosine) / (length + c2 + 2.0 * a * cosine);
    let t = 2.0 * a * cosine * s2;
    let u = length * c2 + s2 * s2;
    let parallel = upright * (u - t) / (u + t);
    0.5 * (upright + parallel)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_forms() {
        assert!((clear(1.0, 1.5).0 - 0.04).abs() < 1e-15);
        assert_eq!(clear(0.0, 1.5).0, 1.0);
        // Brewster's angle: what is reflected is polarised upright.
        let angle = 1.5_f64.atan();
        let upright = (2.0 * angle).cos().powi(2);
        assert!((clear(angle.cos(), 1.5).0 - 0.5 * upright).abs() < 1e-14);
        // Total reflection from 41.8 degrees on.
        assert_eq!(clear(0.74, 1.0 / 1.5).0, 1.0);
        assert!(clear(0.75, 1.0 / 1.5).0 < 1.0);
        // There and back alike.
        let (outside, inside) = clear(0.6, 1.5);
        assert!((clear(inside, 1.0 / 1.5).0 - outside).abs() < 1e-14);
    }

    #[test]
    fn a_metal_that_absorbs_nothing_is_clear() {
        for cosine in [0.01, 0.3, 0.7, 1.0] {
            assert!((absorbing(cosine, 1.7, 0.0) - clear(cosine, 1.7).0).abs() < 1e-12);
        }
        // Aluminium at 550 nm reflects 0.91.
        assert!((absorbing(1.0, 0.96, 6.69) - 0.9210).abs() < 1e-3);
    }

    #[test]
    fn the_dip_is_where_it_was_asked_for() {
        let (facing, edge) = (Rgb::new(1.0, 0.7, 0.3), Rgb::new(1.0, 0.8, 0.5));
        let metal = MetalFresnel::of_colours(facing, edge);
        assert_eq!(metal.at(1.0), facing);
        assert!((metal.at(0.0) - 1.0).abs().max_element() < 1e-15);
        let schlick = facing + (1.0 - facing) * grazing(1.0 / 7.0);
        assert!((metal.at(1.0 / 7.0) - edge * schlick).abs().max_element() < 1e-14);
    }
}
