//! [`Place`]: where a prototype stands, and how rays and hits go there and back.
//!
//! Rays are brought into the frame of the prototype by an affine map, which keeps their parameter;
//! hits are brought back.

use glam::{DAffine3, DMat3, DVec3};

use crate::accel::{Aabb, GROWTH};
use crate::hit::Hit;
use crate::mesh::COORDINATE_LIMIT;
use crate::ray::Ray;

use super::InstanceError;

/// Where a prototype stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub world_from_local: DAffine3,
    local_from_world: DAffine3,
}

impl Place {
    /// Checks a transform.
    pub fn new(world_from_local: DAffine3) -> Result<Self, InstanceError> {
        // Negated, so that NaN is refused.
        let wild = |p: DVec3| !p.abs().cmple(DVec3::splat(COORDINATE_LIMIT)).all();
        let DAffine3 { matrix3: DMat3 { x_axis, y_axis, z_axis }, translation } = world_from_local;
        if [x_axis, y_axis, z_axis, translation].into_iter().any(wild) {
            return Err(InstanceError::NotFinite);
        }
        let volume = world_from_local.matrix3.determinant().abs();
        let place = Self::unchecked(world_from_local);
        let longest = x_axis.length() * y_axis.length() * z_axis.length();
        let spans = volume > 1e-12 * longest;
        if !spans || !place.local_from_world.is_finite() {
            return Err(InstanceError::Singular);
        }
        Ok(place)
    }

    /// The place of a transform that is known to be sound.
    pub fn unchecked(world_from_local: DAffine3) -> Self {
        Self { world_from_local, local_from_world: world_from_local.inverse() }
    }

    /// The corners of a box of the prototype.
    pub fn corners(&self, bounds: &Aabb) -> [DVec3; 8] {
        corners(bounds).map(|p| self.world_from_local.transform_point3(p))
    }

    /// A box around all that stands here and lies in a box of the prototype.
    pub fn bounds(&self, bounds: &Aabb) -> Aabb {
        if bounds.is_empty() {
            return *bounds;
        }
        let placed = Aabb::around(self.corners(bounds));
        placed.grown(GROWTH * (placed.largest_coordinate() + self.reach(bounds)))
    }

    /// Bound on what is added up in a transformed point of a box of the prototype.
    pub fn reach(&self, bounds: &Aabb) -> f64 {
        let DMat3 { x_axis, y_axis, z_axis } = self.world_from_local.matrix3;
        let sum = x_axis.abs() + y_axis.abs() + z_axis.abs();
        sum.max_element() * bounds.largest_coordinate()
    }

    /// A ray in the frame of the prototype; the parameter stays.
    #[inline]
    pub fn local_ray(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.local_from_world.transform_point3(ray.origin),
            direction: self.local_from_world.transform_vector3(ray.direction),
            ..*ray
        }
    }

    /// A hit of the prototype, in the world.
    pub fn world_hit(&self, hit: Hit) -> Hit {
        let linear = self.world_from_local.matrix3;
        // Normals are turned by the inverse's transpose, so they stay on their side.
        let turn = self.local_from_world.matrix3.transpose();
        let stretch = linear.x_axis.abs() + linear.y_axis.abs() + linear.z_axis.abs();
        let position = self.world_from_local.transform_point3(hit.position);
        let summed = stretch.max_element() * hit.position.abs().max_element()
            + self.world_from_local.translation.abs().max_element();
        let geometric_normal = (turn * hit.geometric_normal).normalize();
        let shading_normal = (turn * hit.shading_normal).normalize();
        // A stretch may open the angle between the two beyond a right one.
        let sided = geometric_normal.dot(shading_normal) > 0.0;
        Hit {
            position,
            position_error: stretch.length() * hit.position_error + 8.0 * f64::EPSILON * summed,
            geometric_normal,
            shading_normal: if sided { shading_normal } else { geometric_normal },
            tangents: hit.tangents.map(|tangent| linear * tangent),
            ..hit
        }
    }
}

/// The corners of a box.
pub(super) fn corners(Aabb { min, max }: &Aabb) -> [DVec3; 8] {
    std::array::from_fn(|k| {
        let pick = |axis: usize| if k >> axis & 1 == 0 { min[axis] } else { max[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    })
}
