//! The paper's material: Lambert's diffuser and a share of the light around the mirror direction.
//!
//! `f cos = diffuse cos / pi + reflective p`, with `p` the density of directions reflected by
//! visible GGX normals of width `roughness^2`, folded above the surface. The lobe integrates to 1 for
//! every view and roughness, so a white furnace stays white; what that gives up is reciprocity of
//! the glossy part, which leaves the masking of the outgoing side out. Roughness 0 is a mirror. This
//! is what [`crate::Integrator::Distributed`] averages.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use super::Drawn;
use super::diffuse::OrenNayar;
use super::frame::Side;
use super::lost_slopes::{dulled, widened};
use super::microfacet::reflected_pdf;
use crate::colour::Rgb;
use crate::sampler::warp;
use crate::scene::Material;
use crate::texture::Footprint;

/// The numbers of the paper's material.
#[derive(Clone, Copy, Debug)]
pub(super) struct LambertGloss {
    diffuse: Rgb,
    reflective: Rgb,
    /// In place of Lambert's, where slopes are lost.
    rough: Option<OrenNayar>,
    /// GGX width; 0 for a mirror.
    alpha: f64,
    /// Probability of the reflective lobe.
    share: f64,
}

impl LambertGloss {
    pub(super) fn new(material: &Material, at: &Footprint, view: DVec3) -> Self {
        let diffuse = material.diffuse.mean(at);
        let reflective = material.reflective;
        let (dull, bright) = (diffuse.max_element(), reflective.max_element());
        let share = if bright > 0.0 { bright / (dull + bright) } else { 0.0 };
        let alpha = widened(material.roughness * material.roughness, at.lost_slopes);
        let roughness = dulled(0.0, at.lost_slopes);
        let rough = (roughness > 0.0).then(|| OrenNayar::new(diffuse, roughness, view));
        Self { diffuse, reflective, rough, alpha, share }
    }

    pub(super) fn albedo(&self) -> Rgb {
        self.diffuse + self.reflective
    }

    pub(super) fn is_delta(&self) -> bool {
        self.diffuse == Rgb::ZERO && self.alpha == 0.0
    }

    pub(super) fn evaluate(&self, view: DVec3, side: &Side) -> (Rgb, f64) {
        if !side.is_reflection() {
            return (Rgb::ZERO, 0.0);
        }
        let dull = side.light.z.max(0.0) * FRAC_1_PI;
        let (mut value, mut pdf) = (dull * self.diffuse, (1.0 - self.share) * dull);
        if let Some(rough) = &self.rough {
            value = rough.evaluate(view, side).0;
        }
        if self.share > 0.0 && self.alpha > 0.0 {
            let gloss = side.folded(|light| reflected_pdf(view, light, self.alpha));
            value += gloss * self.reflective;
            pdf += self.share * gloss;
        }
        (value, pdf)
    }

    pub(super) fn sample(&self, view: DVec3, lobe: f64, u: DVec2) -> Option<Drawn> {
        if lobe >= self.share {
            let light = warp::square_to_hemisphere(u);
            let (folds, roughness) = (false, 1.0);
            return Some(Drawn { light, delta: None, folds, transmitted: false, roughness });
        }
        let mirror = self.alpha == 0.0;
        let normal =
            if mirror { DVec3::Z } else { warp::square_to_visible_normal(u, view, self.alpha) };
        let light = 2.0 * view.dot(normal) * normal - view;
        let delta = mirror.then(|| (self.reflective / self.share, self.share));
        let roughness = self.alpha.sqrt();
        Some(Drawn { light, delta, folds: true, transmitted: false, roughness })
    }
}
