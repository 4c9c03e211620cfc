//! [`SphereLight`]: a sphere that emits outwards, sampled over the cone it fills.

use glam::{DVec2, DVec3};

use super::{LightSample, clear_share};
use crate::colour::Rgb;
use crate::sampler::warp::{square_to_cone, square_to_cone_pdf};

/// A sphere that emits outwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereLight {
    pub(super) center: DVec3,
    pub(super) radius: f64,
    pub(super) surface: u32,
    pub(super) emitted: Rgb,
}

impl SphereLight {
    pub(super) fn sample(&self, point: DVec3, u: DVec2) -> Option<LightSample> {
        let axis = self.center - point;
        let distance = axis.length();
        let sin = self.radius / distance;
        // From inside, only the dark back of the sphere is seen.
        if sin >= 1.0 {
            return None;
        }
        // 1 - cos of the cone's half angle, without cancellation.
        let sin2 = sin * sin;
        let height = sin2 / (1.0 + (1.0 - sin2).sqrt());
        let local = square_to_cone(u, height);
        let forward = axis / distance;
        let (right, up) = forward.any_orthonormal_pair();
        let direction = (local.x * right + local.y * up + local.z * forward).normalize();
        // The nearer meeting with the sphere; at the rim the square root is held at 0.
        let along = axis.dot(direction);
        let beside = axis - along * direction;
        let half_chord = (self.radius * self.radius - beside.length_squared()).max(0.0).sqrt();
        let position = point + (along - half_chord) * direction;
        let normal = (position - self.center) / self.radius;
        Some(LightSample {
            position,
            direction,
            weight: self.emitted / square_to_cone_pdf(DVec3::Z, height),
            clear: clear_share(point, position, normal),
        })
    }
}
