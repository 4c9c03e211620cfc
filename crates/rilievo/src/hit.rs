//! [`Hit`]: where a ray meets a surface.

use glam::{DVec2, DVec3};

use crate::ray::{Origin, Part, Ray};

/// A meeting of a ray and a surface, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter, in lengths of the ray's direction.
    pub t: f64,
    /// The point, in scene units.
    pub position: DVec3,
    /// Bound on the distance between `position` and the exact point of the surface that it names,
    /// in scene units.
    pub position_error: f64,
    /// Unit normal of the surface itself; points to the surface's front, whichever side was hit.
    pub geometric_normal: DVec3,
    /// Unit normal to shade with; on the same side as `geometric_normal`.
    pub shading_normal: DVec3,
    /// Derivatives (dP/du, dP/dv) of the base surface, scene units per unit of u and v.
    pub tangents: [DVec3; 2],
    /// Parameters of the base surface, `[0, 1]^2` on quads and spheres.
    pub uv: DVec2,
    /// Map height `H` at the point; 0 where there is no displacement.
    pub height: f64,
    /// Whether the ray came from the front.
    pub front: bool,
    /// Index of the surface in its [`crate::surface::World`]; 0 for a surface traced on its own.
    pub surface: u32,
    /// The part of the surface that was hit.
    pub part: Part,
    /// When: that of the ray.
    pub time: f64,
}

impl Hit {
    /// A ray that leaves this point in `direction`; it will not meet its own start again, and
    /// cannot slip through the surface it starts on. It is traced at the same time.
    pub fn spawn(&self, direction: DVec3) -> Ray {
        let front = direction.dot(self.geometric_normal) >= 0.0;
        let from = Origin { surface: self.surface, part: self.part, front };
        Ray { from: Some(from), time: self.time, ..Ray::new(self.position, direction) }
    }

    /// A ray from this point to `end`, where `t = 1`.
    pub fn spawn_to(&self, end: DVec3) -> Ray {
        Ray { t_max: 1.0, ..self.spawn(end - self.position) }
    }
}
