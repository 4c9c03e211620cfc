//! [`Meeting`]: where a ray meets a surface, as little as tells it from another.
//!
//! A hit carries position, normals, tangents and uv, and costs as much as the search for it. A
//! world compares meetings and completes the nearest one alone; shadow rays complete none. Where a
//! moving surface is, is worked out again then: a place is larger than a meeting.

use crate::hit::Hit;
use crate::mesh::Mesh;
use crate::mesh::crossing::Crossing;
use crate::mesh::departure::Departure;
use crate::probe::Probe;
use crate::ray::Ray;
use crate::relief::{self, MeshCrossing, ReliefFace, ReliefMesh, ReliefSphere, SphereCrossing};

use super::place::Place;
use super::{Instance, MovingInstance, Quad, Sphere, Surface};

/// A hit that is not worked out.
#[derive(Clone, Copy)]
pub(super) struct Meeting<'a> {
    met: Met<'a>,
    /// Where the surface that is met stands, if it is a prototype.
    standing: Option<Standing<'a>>,
}

/// How a prototype stands.
#[derive(Clone, Copy)]
enum Standing<'a> {
    /// Still.
    Still(&'a Place),
    /// Where the ray's time says.
    Moving(&'a MovingInstance),
}

/// What is met.
#[derive(Clone, Copy)]
enum Met<'a> {
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

impl<'a> Meeting<'a> {
    /// Of a crossing of a quad's half.
    #[inline]
    pub(super) fn of_quad(quad: &'a Quad, (half, crossing): (usize, Crossing)) -> Self {
        Self { met: Met::Quad(quad, half, crossing), standing: None }
    }

    /// Ray parameter.
    #[inline]
    pub(super) fn t(&self) -> f64 {
        self.met.t()
    }

    /// The hit along the same ray; `hit.surface` is 0.
    pub(super) fn complete(&self, ray: &Ray) -> Hit {
        let mut hit = match self.standing {
            None => self.met.complete(ray),
            Some(Standing::Still(place)) => self.placed(place, ray),
            Some(Standing::Moving(moving)) => self.placed(&moving.place(ray.time), ray),
        };
        hit.time = ray.time;
        hit
    }

    /// The hit of a prototype that stands at `place`.
    fn placed(&self, place: &Place, ray: &Ray) -> Hit {
        place.world_hit(self.met.complete(&place.local_ray(ray)))
    }
}

impl Met<'_> {
    #[inline]
    fn t(&self) -> f64 {
        match self {
            Self::Quad(_, _, crossing) | Self::Mesh(_, _, crossing) => crossing.t,
            Self::Sphere(_, t, _) => *t,
            Self::Face(_, crossing) => crossing.t,
            Self::ReliefSphere(_, crossing) => crossing.t,
            Self::ReliefMesh(_, crossing) => crossing.t,
        }
    }

    fn complete(&self, ray: &Ray) -> Hit {
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
        let met = match self {
            Self::Quad(quad) => {
                let (half, crossing) = quad.meet(ray, departure)?;
                Met::Quad(quad, half, crossing)
            }
            Self::Sphere(sphere) => {
                let (t, front) = sphere.meet(ray)?;
                Met::Sphere(sphere, t, front)
            }
            Self::Mesh(mesh) => {
                let (index, crossing) = mesh.meet(ray, departure, probe)?;
                Met::Mesh(mesh, index, crossing)
            }
            Self::Face(face) => Met::Face(face, face.first_crossing(ray, probe)?),
            Self::ReliefSphere(sphere) => {
                Met::ReliefSphere(sphere, sphere.first_crossing(ray, probe)?)
            }
            Self::ReliefMesh(mesh) => Met::ReliefMesh(mesh, mesh.first_crossing(ray, probe)?),
            Self::Instance(instance) => return instance.meet(ray, probe),
            Self::Moving(moving) => return moving.meet(ray, probe),
        };
        Some(Meeting { met, standing: None })
    }
}

/// What a ray, in the frame of a prototype that it leaves or not, meets of it.
#[inline]
fn meet_prototype<'a, P: Probe>(
    prototype: &'a Surface,
    ray: &Ray,
    probe: &mut P,
) -> Option<Meeting<'a>> {
    let departure = ray.from.and_then(|from| prototype.departure(from, ray.time));
    prototype.meet(ray, departure.as_ref(), probe)
}

impl Instance {
    /// What a ray meets of the prototype; `ray.from`, if any, is on this instance.
    fn meet<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Meeting<'_>> {
        let place = self.place();
        let meeting = meet_prototype(self.prototype(), &place.local_ray(ray), probe)?;
        Some(Meeting { standing: Some(Standing::Still(place)), ..meeting })
    }

    /// Whether a ray meets the prototype; rays as for [`Instance::meet`].
    pub(super) fn occludes<P: Probe>(&self, ray: &Ray, probe: &mut P) -> bool {
        self.prototype().occludes(&self.place().local_ray(ray), probe)
    }
}

impl MovingInstance {
    /// What a ray meets of the prototype where it is at the ray's time; `ray.from`, if any, is on this
    /// instance.
    fn meet<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Meeting<'_>> {
        let local = self.place(ray.time).local_ray(ray);
        let meeting = meet_prototype(self.prototype(), &local, probe)?;
        Some(Meeting { standing: Some(Standing::Moving(self)), ..meeting })
    }

    /// Whether a ray meets the prototype; rays as for [`MovingInstance::meet`].
    pub(super) fn occludes<P: Probe>(&self, ray: &Ray, probe: &mut P) -> bool {
        self.prototype().occludes(&self.place(ray.time).local_ray(ray), probe)
    }
}
