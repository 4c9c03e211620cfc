//! [`SphereLight`]: a sphere that emits outwards, sampled over the cone it fills.

use glam::{DMat3, DVec2, DVec3};

use super::{LightSample, clear_share};
use crate::colour::Rgb;
use crate::sampler::warp::{square_to_cone, square_to_cone_pdf};

/// A sphere that emits outwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereLight {
    pub(super) center: DVec3,
    pub(super) radius: f64,
    pub(crate) surface: u32,
    pub(super) emitted: Rgb,
}

/// The cone that a sphere fills, seen from a point outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cone {
    /// From the point to the sphere's centre.
    axis: DVec3,
    /// Its z axis is the cone's.
    world_from_cone: DMat3,
    /// 1 less the cosine of the half angle.
    height: f64,
}

impl Cone {
    /// Density of a direction in the cone, per steradian.
    pub(super) fn pdf(&self) -> f64 {
        square_to_cone_pdf(DVec3::Z, self.height)
    }
}

/// The cone that a ball fills whose centre lies at `axis`: a frame whose z axis is the cone's, and 1 less
/// the cosine of its half angle; nothing from inside.
pub(super) fn cone_around(axis: DVec3, radius: f64) -> Option<(DMat3, f64)> {
    let distance = axis.length();
    let sin = radius / distance;
    if sin >= 1.0 {
        return None;
    }
    // 1 - cos without cancellation.
    let height = sin * sin / (1.0 + (1.0 - sin * sin).sqrt());
    let forward = axis / distance;
    let (right, up) = forward.any_orthonormal_pair();
    Some((DMat3::from_cols(right, up, forward), height))
}

impl SphereLight {
    /// The cone it fills, seen from `point`; nothing from inside, where only its back is seen.
    pub(super) fn view(&self, point: DVec3) -> Option<Cone> {
        let axis = self.center - point;
        let (world_from_cone, height) = cone_around(axis, self.radius)?;
        Some(Cone { axis, world_from_cone, height })
    }

    /// A point of the near side.
    pub(super) fn sample(&self, point: DVec3, cone: &Cone, u: DVec2) -> LightSample {
        let direction = (cone.world_from_cone * square_to_cone(u, cone.height)).normalize();
        // The nearer meeting with the sphere; at the rim the square root is held at 0.
        let along = cone.axis.dot(direction);
        let beside = cone.axis - along * direction;
        let half_chord = (self.radius * self.radius - beside.length_squared()).max(0.0).sqrt();
        let position = point + (along - half_chord) * direction;
        let normal = (position - self.center) / self.radius;
        let pdf = cone.pdf();
        LightSample {
            position,
            direction,
            weight: self.emitted / pdf,
            pdf,
            clear: clear_share(point, position, normal),
        }
    }
}
