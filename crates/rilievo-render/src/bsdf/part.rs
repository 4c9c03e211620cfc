//! [`Part`]: a material that is no mix, at one hit: a frame and the lobes of its model.

use glam::{DVec2, DVec3};
use rilievo::Hit;

use super::conductor::MetalLobe;
use super::diffuse::OrenNayar;
use super::frame::{self, Frame, Side};
use super::glass::GlassLobes;
use super::lambert_gloss::LambertGloss;
use super::lost_slopes::dulled;
use super::principled::PrincipledLobes;
use crate::colour::Rgb;
use crate::sampler::warp;
use crate::scene::{Material, Model};
use crate::texture::Footprint;

/// A material that is no mix, evaluated at one hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
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

/// A direction drawn from the lobes of a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drawn {
    /// In local coordinates, before it is folded to its side; in world space after.
    pub light: DVec3,
    /// The weight, if the lobe is a single direction, and the probability of the lobe.
    pub delta: Option<(Rgb, f64)>,
    /// What becomes of a direction on the wrong side: mirrored back, or lost.
    pub folds: bool,
    /// Whether it goes through the surface.
    pub transmitted: bool,
    /// Roughness of the lobe: 0 for a mirror, 1 for a diffuser.
    pub roughness: f64,
}

impl Part {
    /// The `material` at `hit`, seen from direction `view`; textures are averaged over `at`.
    pub fn new(material: &Material, hit: &Hit, view: DVec3, at: &Footprint) -> Self {
        let frame = match &material.normals {
            None => Frame::new(hit, hit.shading_normal, view),
            Some(normals) => Frame::new(hit, frame::detailed(hit, normals.at(at)), view),
        };
        let seen = (hit.front, frame.view);
        let lobes = match &material.model {
            Model::Paper | Model::Mix(_) => {
                Lobes::LambertGloss(LambertGloss::new(material, at, frame.view))
            }
            Model::Diffuse(model) => {
                let colour = model.colour.at(at).min(Rgb::ONE);
                let roughness = dulled(model.roughness.at(at).clamp(0.0, 1.0), at.lost_slopes);
                Lobes::Diffuse(OrenNayar::new(colour, roughness, frame.view))
            }
            Model::Conductor(model) => Lobes::Metal(MetalLobe::new(model, at, frame.view)),
            Model::Glass(model) => Lobes::Glass(GlassLobes::body(model, at, seen)),
            Model::ThinGlass(model) => Lobes::Glass(GlassLobes::thin(model, at, frame.view)),
            Model::Principled(model) => Lobes::Principled(PrincipledLobes::new(model, at, seen)),
        };
        Self { frame, lobes }
    }

    /// As [`super::Bsdf::evaluate`].
    pub fn evaluate(&self, light: DVec3) -> (Rgb, f64) {
        self.lobes.evaluate(self.frame.view, &self.frame.side(light))
    }

    /// Draws a direction of its side of the surface; none where the path ends.
    pub fn sample(&self, lobe: f64, u: DVec2) -> Option<Drawn> {
        let drawn = self.lobes.sample(self.frame.view, lobe, u)?;
        let (light, folded) = self.frame.folded(drawn.light, drawn.transmitted);
        (!folded || drawn.folds).then_some(Drawn { light, ..drawn })
    }

    /// As [`super::Bsdf::albedo`].
    pub fn albedo(&self) -> Rgb {
        match &self.lobes {
            Lobes::LambertGloss(lobes) => lobes.albedo(),
            Lobes::Diffuse(lobe) => lobe.colour,
            Lobes::Metal(lobe) => lobe.albedo(self.frame.view),
            Lobes::Glass(lobes) => lobes.albedo(self.frame.view),
            Lobes::Principled(lobes) => lobes.albedo(),
        }
    }

    /// As [`super::Bsdf::transmits`].
    pub fn transmits(&self) -> bool {
        match &self.lobes {
            Lobes::LambertGloss(_) | Lobes::Diffuse(_) | Lobes::Metal(_) => false,
            Lobes::Glass(_) => true,
            Lobes::Principled(lobes) => lobes.transmits(),
        }
    }

    /// As [`super::Bsdf::is_delta`].
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
