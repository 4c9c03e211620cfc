//! [`Bsdf`]: a material at one hit, ready to be asked.
//!
//! [`Bsdf::new`] looks every texture up and builds the frame of the shading normal, once a hit;
//! [`Bsdf::evaluate`] and [`Bsdf::sample`] then work on numbers alone, in local coordinates with the
//! shading normal at +z. Nothing is allocated.
//!
//! Two normals: which side a direction lies on is the geometric one's to say, the lobes stand around
//! the shading one (`frame`). A diffuse lobe ends where either plane ends it. What a specular lobe
//! sends to the wrong side of the surface is mirrored back at its plane, so that tilted normals
//! neither lose energy nor leak light.

mod albedo;
mod conductor;
mod diffuse;
mod frame;
mod fresnel;
mod glass;
mod lambert_gloss;
mod microfacet;
mod principled;
mod sheen;

pub use albedo::GlassTable;

use glam::{DVec2, DVec3};
use rilievo::Hit;

use conductor::MetalLobe;
use diffuse::OrenNayar;
use frame::{Frame, Side};
use glass::GlassLobes;
use lambert_gloss::LambertGloss;
use principled::PrincipledLobes;

use crate::colour::Rgb;
use crate::sampler::warp;
use crate::scene::{Material, Model};
use crate::texture::Footprint;

/// A material evaluated at one hit. Directions are unit vectors in world space that point away
/// from the surface.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    frame: Frame,
    lobes: Lobes,
}

/// The closed set of models, with their numbers at the hit.
#[derive(Clone, Copy, Debug)]
enum Lobes {
    LambertGloss(LambertGloss),
    Diffuse(OrenNayar),
    Metal(MetalLobe),
    Glass(GlassLobes),
    Principled(PrincipledLobes),
}

/// A direction drawn by [`Bsdf::sample`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered {
    /// Where the path goes on.
    pub direction: DVec3,
    /// `f |cos| / pdf`.
    pub weight: Rgb,
    /// Density of `direction`, per steradian, as [`Bsdf::evaluate`] gives it. If `delta`, the
    /// probability of the lobe.
    pub pdf: f64,
    /// Whether the lobe is a single direction, which no light that is sampled can meet.
    pub delta: bool,
    /// Whether the path goes through the surface.
    pub transmitted: bool,
    /// Roughness of the lobe that was drawn: 0 for a mirror, 1 for a diffuser.
    pub roughness: f64,
}

/// A direction drawn from lobes, in local coordinates, before it is folded to its side.
#[derive(Clone, Copy, Debug)]
struct Drawn {
    light: DVec3,
    /// The weight, if the lobe is a single direction, and the probability of the lobe.
    delta: Option<(Rgb, f64)>,
    /// What becomes of a direction on the wrong side: mirrored back, or lost.
    folds: bool,
    transmitted: bool,
    roughness: f64,
}

impl Bsdf {
    /// The `material` at `hit`, seen from direction `view`. `footprint` is the width that one
    /// sample covers across the ray at the hit, in scene units; 0 where it is not known. Textures
    /// are averaged over it.
    pub fn new(material: &Material, hit: &Hit, view: DVec3, footprint: f64) -> Self {
        let at = Footprint::of(hit, footprint);
        let material = mixed(material, hit, &at);
        let frame = match &material.normals {
            None => Frame::new(hit, hit.shading_normal, view),
            Some(normals) => Frame::new(hit, frame::detailed(hit, normals.at(&at)), view),
        };
        let seen = (hit.front, frame.view);
        let lobes = match &material.model {
            Model::Paper | Model::Mix(_) => Lobes::LambertGloss(LambertGloss::new(material, &at)),
            Model::Diffuse(model) => {
                let colour = model.colour.at(&at).min(Rgb::ONE);
                let roughness = model.roughness.at(&at).clamp(0.0, 1.0);
                Lobes::Diffuse(OrenNayar::new(colour, roughness, frame.view))
            }
            Model::Conductor(model) => Lobes::Metal(MetalLobe::new(model, &at, frame.view)),
            Model::Glass(model) => Lobes::Glass(GlassLobes::body(model, &at, seen)),
            Model::ThinGlass(model) => Lobes::Glass(GlassLobes::thin(model, &at, frame.view)),
            Model::Principled(model) => Lobes::Principled(PrincipledLobes::new(model, &at, seen)),
        };
        Self { frame, lobes }
    }

    /// `f |cos|` for light from direction `light`, and the density with which [`Bsdf::sample`]
    /// draws it. Lobes of a single direction count for nothing in either.
    pub fn evaluate(&self, light: DVec3) -> (Rgb, f64) {
        self.lobes.evaluate(self.frame.view, &self.frame.side(light))
    }

    /// Draws a direction by `lobe` in `[0, 1)` and `u` in `[0, 1)^2`; none where the path ends.
    pub fn sample(&self, lobe: f64, u: DVec2) -> Option<Scattered> {
        let drawn = self.lobes.sample(self.frame.view, lobe, u)?;
        let Drawn { light, delta, folds, transmitted, roughness } = drawn;
        let (direction, folded) = self.frame.folded(light, transmitted);
        if folded && !folds {
            return None;
        }
        let (weight, pdf) = match delta {
            Some(one) => one,
            None => {
                let (value, pdf) = self.evaluate(direction);
                (value / pdf, pdf)
            }
        };
        let kept = pdf > 0.0 && weight.is_finite() && weight != Rgb::ZERO;
        let delta = delta.is_some();
        kept.then_some(Scattered { direction, weight, pdf, delta, transmitted, roughness })
    }

    /// About what share of even light from all sides is sent on to the viewer.
    pub fn albedo(&self) -> Rgb {
        match &self.lobes {
            Lobes::LambertGloss(lobes) => lobes.albedo(),
            Lobes::Diffuse(lobe) => lobe.colour,
            Lobes::Metal(lobe) => lobe.albedo(self.frame.view),
            Lobes::Glass(lobes) => lobes.albedo(self.frame.view),
            Lobes::Principled(lobes) => lobes.albedo(),
        }
    }

    /// Whether light from behind the surface can reach the viewer.
    pub fn transmits(&self) -> bool {
        match &self.lobes {
            Lobes::LambertGloss(_) | Lobes::Diffuse(_) | Lobes::Metal(_) => false,
            Lobes::Glass(_) => true,
            Lobes::Principled(lobes) => lobes.transmits(),
        }
    }

    /// Whether every lobe is a single direction: light that is sampled adds nothing.
    pub fn is_delta(&self) -> bool {
        match &self.lobes {
            Lobes::LambertGloss(lobes) => lobes.is_delta(),
            Lobes::Diffuse(_) => false,
            Lobes::Metal(lobe) => lobe.is_delta(),
            Lobes::Glass(lobes) => lobes.is_delta(),
            Lobes::Principled(lobes) => lobes.is_delta(),
        }
    }
}

impl Lobes {
    fn evaluate(&self, view: DVec3, side: &Side) -> (Rgb, f64) {
        match self {
            Self::LambertGloss(lobes) => lobes.evaluate(view, side),
            Self::Diffuse(lobe) => lobe.evaluate(view, side),
            Self::Metal(lobe) => lobe.evaluate(view, side),
            Self::Glass(lobes) => lobes.evaluate(view, side),
            Self::Principled(lobes) => lobes.evaluate(view, side),
        }
    }

    fn sample(&self, view: DVec3, lobe: f64, u: DVec2) -> Option<Drawn> {
        match self {
            Self::LambertGloss(lobes) => lobes.sample(view, lobe, u),
            Self::Diffuse(_) => {
                let light = warp::square_to_hemisphere(u);
                Some(Drawn { light, delta: None, folds: false, transmitted: false, roughness: 1.0 })
            }
            Self::Metal(metal) => metal.sample(view, u),
            Self::Glass(lobes) => lobes.sample(view, lobe, u),
            Self::Principled(lobes) => lobes.sample(view, lobe, u),
        }
    }
}

/// The part of a mix that counts at a hit. It is chosen by a hash of the place, so the choice is that
/// of chance over a pixel, the same for every thread, and costs one evaluation \[Pharr2023\].
fn mixed<'a>(mut material: &'a Material, hit: &Hit, at: &Footprint) -> &'a Material {
    let place = hit.position.to_array().map(f64::to_bits);
    let mut key = 0x6d69_7865_6400_0000_u64;
    while let Model::Mix(mix) = &material.model {
        for bits in place {
            key = (key ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            key ^= key >> 29;
        }
        key = key.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let number = (key >> 11) as f64 / 9_007_199_254_740_992.0;
        material = &mix.materials[usize::from(number < mix.share.at(at))];
    }
    material
}

#[cfg(test)]
mod tests;
