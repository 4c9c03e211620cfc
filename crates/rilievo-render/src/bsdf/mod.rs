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

mod frame;
mod lambert_gloss;
mod microfacet;

use glam::{DVec2, DVec3};
use rilievo::Hit;

use crate::colour::Rgb;
use crate::scene::Material;

use frame::{Frame, Side};
use lambert_gloss::LambertGloss;

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
        let _ = footprint;
        let frame = Frame::new(hit, hit.shading_normal, view);
        let lobes = Lobes::LambertGloss(LambertGloss::new(material, hit));
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
        }
    }

    /// Whether light from behind the surface can reach the viewer.
    pub fn transmits(&self) -> bool {
        match &self.lobes {
            Lobes::LambertGloss(_) => false,
        }
    }

    /// Whether every lobe is a single direction: light that is sampled adds nothing.
    pub fn is_delta(&self) -> bool {
        match &self.lobes {
            Lobes::LambertGloss(lobes) => lobes.is_delta(),
        }
    }
}

impl Lobes {
    fn evaluate(&self, view: DVec3, side: &Side) -> (Rgb, f64) {
        match self {
            Self::LambertGloss(lobes) => lobes.evaluate(view, side),
        }
    }

    fn sample(&self, view: DVec3, lobe: f64, u: DVec2) -> Option<Drawn> {
        match self {
            Self::LambertGloss(lobes) => lobes.sample(view, lobe, u),
        }
    }
}

#[cfg(test)]
mod tests;
