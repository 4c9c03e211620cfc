//! [`Instance`]: a surface that stands somewhere else, shared by all that show it.
//!
//! Rays are brought into the frame of the prototype and hits are brought back. The world's tree holds
//! the boxes of the instances, the prototype its own tree: two levels, whatever the number of
//! instances. An instance takes two matrices and a pointer.
//!
//! A ray that leaves an instance starts, in the prototype's frame, within a few roundings of the
//! *world's* coordinates from its surface. Where an instance is smaller than about 2^-30 of its
//! distance from the origin, that is more than a prototype of its own size expects, and edges are
//! no longer tight; see docs/LIMITS.md.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use thiserror::Error;

use crate::accel::Aabb;
use crate::hit::Hit;
use crate::mesh::departure::Shell;
use crate::ray::Ray;

use super::Surface;
use super::place::Place;

/// A prototype and where it stands.
#[derive(Clone, Debug)]
pub struct Instance {
    prototype: Arc<Surface>,
    place: Place,
}

/// Why an instance was refused.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum InstanceError {
    /// A number of the transform or the motion is not finite or beyond 1e100.
    #[error("the transform is not finite or has numbers beyond 1e100")]
    NotFinite,
    /// The transform makes the surface flat.
    #[error("the transform has no inverse")]
    Singular,
    /// A motion that turns, but about no axis.
    #[error("the motion turns about an axis without direction")]
    NoAxis,
    /// A motion that turns further than [`Motion::MOST`](super::Motion::MOST).
    #[error("the motion turns by more than {} radian", super::Motion::MOST)]
    TooFar,
    /// The prototype moves by itself.
    #[error("a surface that moves cannot be shown again")]
    Moving,
}

impl Instance {
    /// Stands a surface somewhere. The instance of an instance shows the same prototype.
    ///
    /// # Errors
    /// [`InstanceError`] for a transform that cannot be undone, and for a prototype that moves.
    pub fn new(prototype: Arc<Surface>, world_from_local: DAffine3) -> Result<Self, InstanceError> {
        match prototype.as_ref() {
            Surface::Instance(inner) => {
                let world_from_inner = world_from_local * *inner.world_from_local();
                Self::new(Arc::clone(&inner.prototype), world_from_inner)
            }
            Surface::Moving(_) => Err(InstanceError::Moving),
            _ => Ok(Self { place: Place::new(world_from_local)?, prototype }),
        }
    }

    /// The surface shown.
    pub fn prototype(&self) -> &Arc<Surface> {
        &self.prototype
    }

    /// Where it stands.
    pub fn world_from_local(&self) -> &DAffine3 {
        &self.place.world_from_local
    }

    pub(super) fn place(&self) -> &Place {
        &self.place
    }

    /// A box around the instance.
    pub fn bounds(&self) -> Aabb {
        self.place.bounds(&self.prototype.bounds())
    }

    /// A ray in the frame of the prototype; the parameter stays.
    #[inline]
    pub fn local_ray(&self, ray: &Ray) -> Ray {
        self.place.local_ray(ray)
    }

    /// A hit of the prototype, in the world.
    pub fn world_hit(&self, hit: Hit) -> Hit {
        self.place.world_hit(hit)
    }
}

impl Shell for Instance {
    /// The corners of its prototype's box.
    fn hull(&self, _: f64) -> [DVec3; 8] {
        self.place.corners(&self.prototype.bounds())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::random::Random;
    use crate::map::{HeightMap, Lattice, Procedural, Wrap};
    use crate::mesh::{Mesh, MeshData};
    use crate::ray::Ray;
    use crate::relief::{Displacement, FaceOptions, Relief, ReliefFace};
    use crate::surface::{Quad, Sphere, World};

    fn relief(corners: [DVec3; 4], scale: f64) -> Surface {
        let map = Procedural::Fbm { octaves: 5, seed: 7 };
        let map: HeightMap = map.height_map_f32([65, 65], Lattice::Vertex, Wrap::Clamp).unwrap();
        let displacement = Displacement { scale, ..Displacement::default() };
        let options = FaceOptions { displacement, closed: true, ..FaceOptions::default() };
        ReliefFace::new(corners, Arc::new(Relief::new(map)), options).unwrap().into()
    }

    const SQUARE: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];

    /// Turns, a mirror and a stretch by powers of two, which round nothing but the translation.
    fn transforms() -> Vec<DAffine3> {
        let far = DVec3::new(1500.0, -800.0, 40.0);
        let turned = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 1.1);
        let stretch = DAffine3::from_scale(DVec3::new(4.0, 0.25, 2.0));
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let moved = DAffine3::from_translation(far);
        vec![DAffine3::IDENTITY, moved * turned, stretch, turned * mirror, moved * turned * stretch]
    }

    #[test]
    fn a_rigid_instance_is_the_surface_made_in_its_place() {
        let mut random = Random(5);
        for world_from_local in transforms().into_iter().take(2) {
            let placed = relief(SQUARE.map(|p| world_from_local.transform_point3(p)), 0.2);
            let instance = Surface::from(
                Instance::new(Arc::new(relief(SQUARE, 0.2)), world_from_local).unwrap(),
            );
            let (a, b) = (instance.bounds(), placed.bounds());
            assert!(
                (a.min - b.min).abs().max_element() < 2.0
                    && a.contains(&Aabb::around([b.centre()]))
            );
            let mut hits = 0;
            for _ in 0..4000 {
                let at = world_from_local
                    .transform_point3(DVec3::new(0.5, 0.5, 0.1) + random.cube() * 0.4);
                let from = at + 3.0 * random.direction();
                let ray = Ray::new(from, at - from);
                let (a, b) = (instance.closest(&ray, &mut ()), placed.closest(&ray, &mut ()));
                assert_eq!(instance.occludes(&ray, &mut ()), a.is_some());
                let (Some(a), Some(b)) = (a, b) else {
                    assert!(a.is_none() && b.is_none(), "{ray:?}");
                    continue;
                };
                hits += 1;
                assert!((a.position - b.position).length() < 1e-9, "{a:?} {b:?}");
                assert!((a.geometric_normal - b.geometric_normal).length() < 1e-6, "{a:?} {b:?}");
                assert!((a.tangents[0] - b.tangents[0]).length() < 1e-9);
                assert_eq!((a.front, a.part), (b.front, b.part));
            }
            assert!(hits > 1000, "{hits}");
        }
    }

    #[test]
    fn hits_lie_on_the_ray_and_normals_on_the_side_of_the_front() {
        let mut random = Random(6);
        let prototypes = [
            relief(SQUARE, -0.3),
            Sphere::new(DVec3::splat(0.5), 0.4).unwrap().into(),
            Quad::new(SQUARE, false).unwrap().into(),
        ];
        for prototype in prototypes.map(Arc::new) {
            for world_from_local in transforms() {
                let instance = Instance::new(Arc::clone(&prototype), world_from_local).unwrap();
                let world = World::new(vec![instance.into()]);
                for _ in 0..2000 {
                    let at =
                        world_from_local.transform_point3(DVec3::splat(0.5) + 0.3 * random.cube());
                    let from = at + 5.0 * random.direction();
                    let ray = Ray::new(from, at - from);
                    let Some(hit) = world.closest(&ray, &mut ()) else { continue };
                    assert!((ray.at(hit.t) - hit.position).length() < 1e-9, "{hit:?}");
                    assert!((hit.geometric_normal.length() - 1.0).abs() < 1e-12);
                    assert_eq!(hit.front, hit.geometric_normal.dot(ray.direction) < 0.0, "{hit:?}");
                    assert!(hit.geometric_normal.dot(hit.shading_normal) > 0.0);
                }
            }
        }
    }

    #[test]
    fn rays_that_leave_a_closed_instance_neither_meet_their_start_nor_slip_through() {
        // A box of six quads as one mesh, rays from inside that bounce inside for ever.
        let positions: Vec<DVec3> = (0..8)
            .map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)))
            .collect();
        let sides =
            [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let triangles = triangles.map(|positions| crate::mesh::Triangle {
            positions,
            normals: None,
            uvs: None,
        });
        let data = MeshData { positions, triangles: triangles.collect(), ..MeshData::default() };
        let prototype = Arc::new(Surface::from(Mesh::new(data).unwrap()));
        let mut random = Random(7);
        for world_from_local in transforms() {
            let instance = Instance::new(Arc::clone(&prototype), world_from_local).unwrap();
            let world = World::new(vec![instance.into()]);
            for _ in 0..200 {
                let inside =
                    world_from_local.transform_point3(DVec3::splat(0.5) + 0.4 * random.cube());
                let mut ray = Ray::new(inside, random.direction());
                for _ in 0..20 {
                    let hit =
                        world.closest(&ray, &mut ()).unwrap_or_else(|| panic!("escaped: {ray:?}"));
                    let inward =
                        if hit.front { hit.geometric_normal } else { -hit.geometric_normal };
                    let direction = random.direction();
                    let direction =
                        if direction.dot(inward) > 0.0 { direction } else { -direction };
                    if direction.dot(inward) > 1e-3 {
                        ray = hit.spawn(direction);
                    }
                }
            }
        }
    }

    #[test]
    fn instances_of_instances_show_the_prototype() {
        let prototype = Arc::new(Surface::from(Sphere::new(DVec3::ZERO, 1.0).unwrap()));
        let up = DAffine3::from_translation(DVec3::Z);
        let twice = DAffine3::from_scale(DVec3::splat(2.0));
        let inner = Instance::new(Arc::clone(&prototype), up).unwrap();
        let outer = Instance::new(Arc::new(inner.into()), twice).unwrap();
        assert!(Arc::ptr_eq(outer.prototype(), &prototype));
        let ray = Ray::new(DVec3::new(0.0, 0.0, 10.0), DVec3::NEG_Z);
        assert_eq!(Surface::from(outer).closest(&ray, &mut ()).unwrap().t, 6.0);
    }

    #[test]
    fn transforms_that_cannot_be_undone_are_refused() {
        let prototype = Arc::new(Surface::from(Sphere::new(DVec3::ZERO, 1.0).unwrap()));
        let new = |transform| Instance::new(Arc::clone(&prototype), transform).unwrap_err();
        let flat = DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(new(flat), InstanceError::Singular);
        assert_eq!(new(DAffine3::from_translation(DVec3::NAN)), InstanceError::NotFinite);
        assert_eq!(new(DAffine3::from_scale(DVec3::splat(1e200))), InstanceError::NotFinite);
    }
}
