//! [`MeshRay`]: a ray in the frame of a mesh, cut to its box, and sheared for the leaf.

use glam::DVec3;

use crate::accel::{Aabb, SlabRay};
use crate::ray::Ray;

/// A ray that starts where it enters the box of a mesh, relative to the mesh's centre. It is made
/// once for a ray and a mesh: its rounding is the same for all that is in the mesh, so nothing can
/// open between two parts of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshRay {
    pub origin: DVec3,
    pub direction: DVec3,
    /// Parameter of the original ray at `origin`.
    pub t_start: f64,
    /// Largest parameter of interest, from `origin`.
    pub t_max: f64,
    /// Two minor axes and the axis along which the ray is longest; they keep handedness
    /// \[Woop2013\].
    axes: [usize; 3],
    shear: [f64; 2],
    /// Direction along the longest axis, and its inverse.
    along: f64,
    per_depth: f64,
}

impl MeshRay {
    /// `bounds` is relative to `centre`.
    #[inline(always)]
    pub fn new(ray: &Ray, centre: DVec3, bounds: &Aabb) -> Option<Self> {
        let mut local = Ray { origin: ray.origin - centre, ..*ray };
        if !local.is_valid() {
            return None;
        }
        let t_start = SlabRay::new(&local).entry(bounds, ray.t_max)?;
        local.origin += t_start * local.direction;
        let direction = local.direction;
        let d = indexed(direction);
        let z = direction.abs().max_position() & 3;
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let (x, y) = if d[z] < 0.0 { (y, x) } else { (x, y) };
        // Wider than any rounding: only what is far beyond the box is cut off.
        let mut leave = f64::INFINITY;
        for k in 0..3 {
            let d = direction[k];
            if d == 0.0 {
                continue;
            }
            let face = if d > 0.0 { bounds.max[k] } else { bounds.min[k] };
            let t = (face - local.origin[k]) / d;
            // Passes over NaN.
            leave = if t < leave { t } else { leave };
        }
        leave = if leave > 0.0 { leave } else { 0.0 };
        let size = (bounds.max - bounds.min).max_element();
        let t_max = (leave + 0.1 * size / d[z].abs()).min(ray.t_max - t_start);
        Some(Self {
            origin: local.origin,
            direction,
            t_start,
            t_max,
            axes: [x, y, z],
            shear: [d[x] / d[z], d[y] / d[z]],
            along: d[z],
            per_depth: 1.0 / d[z],
        })
    }

    /// The ray for a tree in the mesh's frame.
    #[inline(always)]
    pub fn as_ray(&self) -> Ray {
        Ray { t_max: self.t_max, ..Ray::new(self.origin, self.direction) }
    }

    /// Scene units of depth per unit of the parameter.
    #[inline(always)]
    pub fn speed(&self) -> f64 {
        self.along.abs()
    }

    /// A vector with the ray turned into the third axis.
    #[inline(always)]
    pub fn sheared(&self, v: DVec3) -> DVec3 {
        let [x, y, z] = self.axes;
        let v = indexed(v);
        let [x, y, z] = [v[x & 3], v[y & 3], v[z & 3]];
        DVec3::new(x - self.shear[0] * z, y - self.shear[1] * z, z)
    }

    /// About [`MeshRay::t`], to three roundings, by a product.
    #[inline(always)]
    pub fn t_about(&self, depth: f64) -> f64 {
        depth * self.per_depth
    }

    /// Parameter at a depth along the third axis.
    #[inline(always)]
    pub fn t(&self, depth: f64) -> f64 {
        depth / self.along
    }
}

/// Coordinates to index without a jump for each axis; four, so that `& 3` is in bounds.
#[inline(always)]
fn indexed(v: DVec3) -> [f64; 4] {
    [v.x, v.y, v.z, 0.0]
}
