//! A metal: GGX facets that reflect by Fresnel's law, with what several facets reflect put back.
//!
//! `f cos = F D G2 / (4 view.z) (1 + F0 (1 - E) / E)` \[Turquin2019\], drawn by visible normals.

use glam::{DVec2, DVec3};

use super::Drawn;
use super::albedo;
use super::frame::Side;
use super::fresnel::MetalFresnel;
use super::lost_slopes::widened;
use super::microfacet::{SMOOTH, reflection};
use crate::colour::Rgb;
use crate::sampler::warp;
use crate::scene::{Conductor, Metal};
use crate::texture::Footprint;

/// A metal at a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct MetalLobe {
    fresnel: MetalFresnel,
    alpha: f64,
    /// What several facets add, as a factor.
    several: Rgb,
}

impl MetalLobe {
    pub(super) fn new(model: &Conductor, at: &Footprint, view: DVec3) -> Self {
        let fresnel = match &model.metal {
            Metal::Colours { facing, edge } => {
                MetalFresnel::of_colours(facing.at(at), edge.at(at).min(Rgb::ONE))
            }
            Metal::Index { eta, k } => MetalFresnel::Index { eta: *eta, k: *k },
        };
        let alpha = widened(width(model.roughness.at(at)), at.lost_slopes);
        let several = match model.compensated && alpha >= SMOOTH {
            true => several(fresnel.facing(), view.z, alpha),
            false => Rgb::ONE,
        };
        Self { fresnel, alpha, several }
    }

    pub(super) fn albedo(&self, view: DVec3) -> Rgb {
        self.fresnel.at(view.z)
    }

    pub(super) fn is_delta(&self) -> bool {
        self.alpha < SMOOTH
    }

    pub(super) fn evaluate(&self, view: DVec3, side: &Side) -> (Rgb, f64) {
        let (mut value, mut pdf) = (Rgb::ZERO, 0.0);
        if self.is_delta() || !side.is_reflection() {
            return (value, pdf);
        }
        for light in side.both() {
            if let Some(met) = reflection(view, light, self.alpha) {
                value += met.value * self.fresnel.at(met.cosine);
                pdf += met.pdf;
            }
        }
        (value * self.several, pdf)
    }

    pub(super) fn sample(&self, view: DVec3, u: DVec2) -> Option<Drawn> {
        let roughness = self.alpha.sqrt();
        let delta = self.is_delta().then(|| (self.fresnel.at(view.z), 1.0));
        let light = reflected(view, self.alpha, u)?;
        Some(Drawn { light, delta, folds: true, transmitted: false, roughness })
    }
}

/// The GGX width of a roughness, which a texture may have brought out of range.
pub(super) fn width(roughness: f64) -> f64 {
    let roughness = roughness.clamp(0.0, 1.0);
    roughness * roughness
}

/// The factor on a lobe of reflectance `facing` that puts back what several facets reflect.
pub(super) fn several(facing: Rgb, cosine: f64, alpha: f64) -> Rgb {
    let [a, b] = albedo::gloss(cosine, alpha);
    let single = (a + b).min(1.0);
    1.0 + facing * ((1.0 - single) / single)
}

/// `view` reflected by a facet that it sees; none if it leaves into the surface.
#[inline]
pub(super) fn reflected(view: DVec3, alpha: f64, u: DVec2) -> Option<DVec3> {
    if alpha < SMOOTH {
        return Some(DVec3::new(-view.x, -view.y, view.z));
    }
    let facet = warp::square_to_visible_normal(u, view, alpha);
    let light = 2.0 * view.dot(facet) * facet - view;
    (light.z > 0.0).then_some(light)
}
