//! [`Meeting`]: where a ray meets a surface, as little as tells it from another.
//!
//! A hit carries position, normals, tangents and uv, and costs as much as the search for it. A
//! world compares meetings and completes the nearest one alone; shadow rays complete none.

use crate::hit::Hit;
use crate::mesh::Mesh;
use crate::mesh::crossing::Crossing;
use crate::mesh::departure::Departure;
use crate::probe::Probe;
use crate::ray::Ray;
use crate::relief::{self, MeshCrossing, ReliefFace, ReliefMesh, ReliefSphere, SphereCrossing};

use super::{Quad, Sphere, Surface};

/// A hit that is not worked out.
#[derive(Clone, Copy)]
pub(super) enum Meeting<'a> {
    /// A half of a quad.
    Quad(&'a Quad, usize, Crossing),
    /// A sphere at `t`, and whether from its front.
    Sphere(&'a Sphere, f64, bool),
    /// A triangle of a mesh.
    Mesh(&'a Mesh, u32, Crossing),
    /// A relief.
    Face(&'a ReliefFace, relief::Crossing),
    /// A displaced sphere.
    ReliefSphere(&'a ReliefSphere, SphereCrossing),
    /// A displaced mesh.
    ReliefMesh(&'a ReliefMesh, MeshCrossing),
}

impl Meeting<'_> {
    /// Ray parameter.
    #[inline]
    pub(super) fn t(&self) -> f64 {
        match self {
            Self::Quad(_, _, crossing) | Self::Mesh(_, _, crossing) => crossing.t,
            Self::Sphere(_, t, _) => *t,
            Self::Face(_, crossing) => crossing.t,
            Self::ReliefSphere(_, crossing) => crossing.t,
            Self::ReliefMesh(_, crossing) => crossing.t,
        }
    }

    /// The hit along the same ray; `hit.surface` is 0.
    pub(super) fn complete(&self, ray: &Ray) -> Hit {
        match self {
            Self::Quad(quad, half, crossing) => quad.complete(*half, crossing),
            Self::Sphere(sphere, t, front) => sphere.complete(ray, *t, *front),
            Self::Mesh(mesh, index, crossing) => mesh.complete(*index, crossing),
            Self::Face(face, crossing) => face.complete(ray, crossing),
            Self::ReliefSphere(sphere, crossing) => sphere.complete(crossing),
            Self::ReliefMesh(mesh, crossing) => mesh.complete(ray, crossing),
        }
    }
}

impl Surface {
    /// What [`Surface::closest`] finds, for a ray that leaves `departure`, of this or another
    /// surface.
    #[inline]
    pub(super) fn meet<P: Probe>(
        &self,
        ray: &Ray,
        departure: Option<&Departure<'_>>,
        probe: &mut P,
    ) -> Option<Meeting<'_>> {
        Some(match self {
            Self::Quad(quad) => {
                let (half, crossing) = quad.meet(ray, departure)?;
                Meeting::Quad(quad, half, crossing)
            }
            Self::Sphere(sphere) => {
                let (t, front) = sphere.meet(ray)?;
                Meeting::Sphere(sphere, t, front)
            }
            Self::Mesh(mesh) => {
                let (index, crossing) = mesh.meet(ray, departure, probe)?;
                Meeting::Mesh(mesh, index, crossing)
            }
            Self::Face(face) => Meeting::Face(face, face.first_crossing(ray, probe)?),
            Self::ReliefSphere(sphere) => {
                Meeting::ReliefSphere(sphere, sphere.first_crossing(ray, probe)?)
            }
            Self::ReliefMesh(mesh) => Meeting::ReliefMesh(mesh, mesh.first_crossing(ray, probe)?),
        })
    }
}
