//! [`Light`]: the emitters that are sampled.
//!
//! Every surface with an emitting material glows from its front side, seen directly and in
//! reflections. Undisplaced quads and spheres are also *lights*: diffuse surfaces receive light
//! from them through shadow rays. Emitting meshes, reliefs and walls only glow.

mod quad;
mod sphere;

use glam::DVec3;
use rilievo::surface::Surface;

use crate::colour::Rgb;

pub use quad::QuadLight;
pub use sphere::SphereLight;

/// An emitter that is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// A parallelogram, sampled uniformly by area.
    Quad(QuadLight),
    /// A sphere, sampled uniformly over the cone it fills.
    Sphere(SphereLight),
}

/// A point of a light as seen from another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// The point on the light.
    pub position: DVec3,
    /// Unit direction towards it.
    pub direction: DVec3,
    /// Radiance over the density of `direction`, W/m^2: times the receiver's cosine it estimates
    /// the irradiance.
    pub weight: Rgb,
    /// Share of the way to `position` that must be free. It is below 1 by the rounding error of
    /// the light's own place, so that the light does not shadow itself.
    pub clear: f64,
}

impl Light {
    /// The light that a surface is, if its front emits and its shape can be sampled.
    pub fn of_surface(surface: &Surface, index: u32, emitted: Rgb) -> Option<Self> {
        if emitted == Rgb::ZERO {
            return None;
        }
        match surface {
            Surface::Quad(quad) => {
                Some(Self::Quad(QuadLight::new(quad.corners(), index, emitted)))
            }
            Surface::Sphere(sphere) => Some(Self::Sphere(SphereLight {
                center: sphere.center(),
                radius: sphere.radius(),
                surface: index,
                emitted,
            })),
            Surface::Mesh(_) | Surface::Face(_) => None,
        }
    }

    /// Index of the light's surface in the world.
    pub fn surface(&self) -> u32 {
        match self {
            Self::Quad(quad) => quad.surface,
            Self::Sphere(sphere) => sphere.surface,
        }
    }

    /// A point of the light for `u` in `[0, 1)^2`, as seen from `point`; nothing where its front
    /// is not seen from there.
    pub fn sample(&self, point: DVec3, u: glam::DVec2) -> Option<LightSample> {
        match self {
            Self::Quad(quad) => quad.sample(point, u),
            Self::Sphere(sphere) => sphere.sample(point, u),
        }
    }
}

/// The share of the way from `from` to `to` that lies before the plane through `to` with unit
/// normal `normal`, whatever way coordinates were rounded.
fn clear_share(from: DVec3, to: DVec3, normal: DVec3) -> f64 {
    let across = (to - from).dot(normal).abs();
    let rounding = 32.0 * f64::EPSILON * (from.abs().max_element() + to.abs().max_element());
    1.0 - (rounding / across + 4.0 * f64::EPSILON).min(0.5)
}
