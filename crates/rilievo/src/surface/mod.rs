//! Surfaces of every kind, and the world that holds them.
//!
//! [`Surface`] is a closed set: one `match` for each question, no trait objects. [`World`] puts
//! surfaces into a BVH and sees to it that a ray which leaves one of them is treated as such by
//! that one alone; to its flat neighbours it says which surface the ray leaves, so that edges
//! between flat surfaces are as tight as those within a mesh. Spheres and reliefs decide by the
//! sign of `t` alone: a ray that leaves another surface exactly where it touches one of them, to
//! rounding, may be stopped by it or pass it.

mod instance;
mod lone;
mod meeting;
mod motion;
mod moving;
mod place;
mod prepared;
mod quad;
mod search;
mod sphere;
mod world;

pub use instance::{Instance, InstanceError};
pub use motion::Motion;
pub use moving::MovingInstance;
pub use quad::{Quad, QuadError};
pub use sphere::{Sphere, SphereError};
pub use world::World;

use glam::DVec3;

use crate::accel::Aabb;
use crate::hit::Hit;
use crate::mesh::Mesh;
use crate::mesh::departure::{Departure, Shell};
use crate::probe::Probe;
use crate::ray::{Origin, Ray};
use crate::relief::{ReliefFace, ReliefMesh, ReliefSphere};

/// Anything a ray can meet.
#[derive(Clone, Debug)]
pub enum Surface {
    /// An undisplaced quadrilateral.
    Quad(Quad),
    /// An undisplaced sphere.
    Sphere(Sphere),
    /// An undisplaced triangle mesh.
    Mesh(Mesh),
    /// A displaced parallelogram; boxed, being the largest.
    Face(Box<ReliefFace>),
    /// A displaced sphere.
    ReliefSphere(Box<ReliefSphere>),
    /// A displaced triangle mesh.
    ReliefMesh(Box<ReliefMesh>),
    /// Another surface, standing elsewhere.
    Instance(Box<Instance>),
    /// Another surface, on its way.
    Moving(Box<MovingInstance>),
}

impl From<Quad> for Surface {
    fn from(quad: Quad) -> Self {
        Self::Quad(quad)
    }
}

impl From<Sphere> for Surface {
    fn from(sphere: Sphere) -> Self {
        Self::Sphere(sphere)
    }
}

impl From<Mesh> for Surface {
    fn from(mesh: Mesh) -> Self {
        Self::Mesh(mesh)
    }
}

impl From<ReliefFace> for Surface {
    fn from(face: ReliefFace) -> Self {
        Self::Face(Box::new(face))
    }
}

impl From<ReliefSphere> for Surface {
    fn from(sphere: ReliefSphere) -> Self {
        Self::ReliefSphere(Box::new(sphere))
    }
}

impl From<ReliefMesh> for Surface {
    fn from(mesh: ReliefMesh) -> Self {
        Self::ReliefMesh(Box::new(mesh))
    }
}

impl From<Instance> for Surface {
    fn from(instance: Instance) -> Self {
        Self::Instance(Box::new(instance))
    }
}

impl From<MovingInstance> for Surface {
    fn from(moving: MovingInstance) -> Self {
        Self::Moving(Box::new(moving))
    }
}

impl Surface {
    /// The nearest hit within `0 <= t <= t_max`. `ray.from`, if any, is on this surface;
    /// `hit.surface` is 0.
    pub fn closest<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Hit> {
        let departure = ray.from.and_then(|from| self.departure(from, ray.time));
        Some(self.meet(ray, departure.as_ref(), probe)?.complete(ray))
    }

    /// Whether the surface is met within `0 <= t <= t_max`; rays as for [`Surface::closest`].
    pub fn occludes<P: Probe>(&self, ray: &Ray, probe: &mut P) -> bool {
        let departure = ray.from.and_then(|from| self.departure(from, ray.time));
        self.occludes_after(ray, departure.as_ref(), probe)
    }

    /// A box around the surface, at all times; empty if nothing of it can be hit.
    pub fn bounds(&self) -> Aabb {
        match self {
            Self::Quad(quad) => quad.bounds(),
            Self::Sphere(sphere) => sphere.bounds(),
            Self::Mesh(mesh) => mesh.bounds(),
            Self::Face(face) => face.bounds(),
            Self::ReliefSphere(sphere) => sphere.bounds(),
            Self::ReliefMesh(mesh) => mesh.bounds(),
            Self::Instance(instance) => instance.bounds(),
            Self::Moving(moving) => moving.bounds(),
        }
    }

    /// What flat neighbours should know of a ray that starts at `from`, on this surface, at a time.
    fn departure(&self, from: Origin, time: f64) -> Option<Departure<'_>> {
        match self {
            Self::Quad(quad) => quad.departure(from),
            Self::Sphere(_) => None,
            Self::Mesh(mesh) => mesh.departure(from),
            Self::Face(face) => Some(Departure::Shell(face.as_ref(), time)),
            Self::ReliefSphere(sphere) => Some(Departure::Shell(sphere.as_ref(), time)),
            Self::ReliefMesh(mesh) => Some(Departure::Shell(mesh.as_ref(), time)),
            Self::Instance(instance) => Some(Departure::Shell(instance.as_ref(), time)),
            Self::Moving(moving) => Some(Departure::Shell(moving.as_ref(), time)),
        }
    }

    /// [`Surface::occludes`] for a ray that leaves `departure`, of this or another surface.
    fn occludes_after<P: Probe>(
        &self,
        ray: &Ray,
        departure: Option<&Departure<'_>>,
        probe: &mut P,
    ) -> bool {
        match self {
            Self::Quad(quad) => quad.meet(ray, departure).is_some(),
            Self::Sphere(sphere) => sphere.occludes(ray),
            Self::Mesh(mesh) => mesh.occludes_after(ray, departure, probe),
            Self::Face(face) => face.occludes(ray, probe),
            Self::ReliefSphere(sphere) => sphere.occludes(ray, probe),
            Self::ReliefMesh(mesh) => mesh.occludes(ray, probe),
            Self::Instance(instance) => instance.occludes(ray, probe),
            Self::Moving(moving) => moving.occludes(ray, probe),
        }
    }
}

impl Shell for ReliefFace {
    /// Its base at the smallest and the largest offset, and at 0 as well if it has walls.
    fn hull(&self, _: f64) -> [DVec3; 8] {
        let [corner, edge_u, edge_v, normal] = self.frame();
        let (heights, options) = (self.relief().heights(), self.options());
        let d = options.displacement;
        let offset = |raw| d.scale * (f64::from(raw) * heights.unit() - d.zero);
        let (low, high) = heights.raw_range();
        let mut ends = [offset(low), offset(high)];
        if options.closed {
            let [a, b] = ends;
            ends = [a.min(b).min(0.0), a.max(b).max(0.0)];
        }
        let base = [corner, corner + edge_u, corner + edge_u + edge_v, corner + edge_v];
        std::array::from_fn(|k| base[k % 4] + ends[k / 4] * normal)
    }
}

impl Shell for ReliefSphere {
    /// The box around it.
    fn hull(&self, _: f64) -> [DVec3; 8] {
        place::corners(&self.bounds())
    }
}

impl Shell for ReliefMesh {
    /// The box around it.
    fn hull(&self, _: f64) -> [DVec3; 8] {
        place::corners(&self.bounds())
    }
}
