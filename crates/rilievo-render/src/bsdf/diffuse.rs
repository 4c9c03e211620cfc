//! Oren and Nayar's diffuser in the energy-preserving form of \[Portsmouth2025\], drawn by the cosine.
//!
//! Fujii's variant of the model plus a lobe for what meets several slopes; the albedo of a white
//! one is 1 at every roughness and angle, to the 1e-3 of the polynomial that stands in for its integral.
//! Roughness 0 is Lambert's.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use super::frame::Side;
use crate::colour::Rgb;

/// A diffuser at a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct OrenNayar {
    pub(super) colour: Rgb,
    roughness: f64,
    /// Of single slopes.
    scale: f64,
    /// Colour of the lobe of several slopes, over pi and over the mean of what single ones lose.
    several: Rgb,
    /// What single slopes lose towards the viewer.
    lost: f64,
}

impl OrenNayar {
    pub(super) fn new(colour: Rgb, roughness: f64, view: DVec3) -> Self {
        let scale = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * roughness);
        let mut all = Self { colour, roughness, scale, several: Rgb::ZERO, lost: 0.0 };
        if roughness > 0.0 {
            let mean = scale * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * roughness);
            let gone = (1.0 - mean).max(1e-9);
            all.several = colour * colour * mean / (1.0 - colour * gone) / (PI * gone);
            all.lost = 1.0 - all.single(view.z);
        }
        all
    }

    /// Albedo of single white slopes.
    fn single(&self, cosine: f64) -> f64 {
        let s = 1.0 - cosine;
        let g = s
            * (0.057_108_528_9 + s * (0.491_881_867 + s * (-0.332_181_442 + s * 0.071_442_995_3)));
        self.scale * (1.0 + self.roughness * g)
    }

    /// `f |cos|` and the density of directions drawn by the cosine.
    #[inline]
    pub(super) fn evaluate(&self, view: DVec3, side: &Side) -> (Rgb, f64) {
        let light = side.light;
        if light.z <= 0.0 || !side.is_reflection() {
            return (Rgb::ZERO, 0.0);
        }
        let pdf = light.z * FRAC_1_PI;
        let cosine = pdf * side.softened();
        if self.roughness == 0.0 {
            return (cosine * self.colour, pdf);
        }
        let s = view.dot(light) - view.z * light.z;
        let slope = if s > 0.0 { s / view.z.max(light.z) } else { s };
        let single = self.scale * (1.0 + self.roughness * slope);
        let several = PI * self.lost * (1.0 - self.single(light.z));
        (cosine * (single * self.colour + several * self.several), pdf)
    }
}
