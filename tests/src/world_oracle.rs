//! The judge of whole worlds: every surface has a judge of its own, and all of them are asked.
//!
//! No tree, no box of the library, no order. Reliefs are judged by [`Oracle`], [`SphereOracle`] and [`MeshOracle`], triangles
//! by their determinants, balls by their quadratic; instances of a surface, at rest or moving, share its judge, and the
//! ball around all that it shows ([`Ball`]) says which of them a ray passes.

mod flat;

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use rilievo::map::CubeFace;
use rilievo::mesh::Mesh;
use rilievo::relief::{Edges, ReliefFace, ReliefMesh, ReliefSphere};
use rilievo::surface::{MovingInstance, Surface, World};
use rilievo::{Hit, Ray};

use crate::ball::{Ball, Line};
use crate::mesh_oracle::{Closing, MeshOracle};
use crate::nudge::nudged;
use crate::oracle::{self, Oracle};
use crate::sphere::oracle::SphereOracle;

/// A world to be judged by.
pub struct WorldOracle<'a> {
    shown: Vec<Shown<'a>>,
}

/// A surface of the world.
struct Shown<'a> {
    judge: Arc<Judge<'a>>,
    /// For an instance: where it stands, and a ball around its prototype in that frame.
    place: Option<(Place<'a>, Ball)>,
}

/// Where an instance stands.
enum Place<'a> {
    /// Its frame, from the world.
    Still(DAffine3),
    Moving(&'a MovingInstance),
}

/// The judge of one surface, in a frame of its own.
enum Judge<'a> {
    Triangles { corners: Vec<[DVec3; 3]>, one_sided: bool },
    Sphere { center: DVec3, radius: f64 },
    Face(Box<Oracle<'a>>),
    ReliefSphere(Box<SphereOracle>),
    ReliefMesh(Box<MeshOracle<'a>>),
}

/// The nearest meeting of a ray with a world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldHit {
    /// Ray parameter.
    pub t: f64,
    /// The point, in world space.
    pub position: DVec3,
    /// Index of the surface.
    pub surface: u32,
}

impl<'a> WorldOracle<'a> {
    /// Judges of all surfaces of a world.
    ///
    /// # Errors
    /// The first kind of surface that has no judge: a displaced mesh that is one-sided, of several maps, or open
    /// without walls.
    pub fn new(world: &'a World) -> Result<Self, String> {
        let mut prototypes = HashMap::new();
        let mut shown = Vec::new();
        for surface in world.surfaces() {
            let (prototype, place) = match surface {
                Surface::Instance(instance) => {
                    let local_from_world = instance.world_from_local().inverse();
                    (instance.prototype(), Place::Still(local_from_world))
                }
                Surface::Moving(moving) => (moving.prototype(), Place::Moving(moving)),
                _ => {
                    shown.push(Shown { judge: Arc::new(Judge::new(surface)?), place: None });
                    continue;
                }
            };
            let (judge, ball) = match prototypes.entry(Arc::as_ptr(prototype).addr()) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(free) => {
                    let judge = Judge::new(prototype)?;
                    let ball = judge.around();
                    free.insert((Arc::new(judge), ball))
                }
            };
            shown.push(Shown { judge: Arc::clone(judge), place: Some((place, *ball)) });
        }
        Ok(Self { shown })
    }

    /// The nearest meeting with `0 <= t <= t_max`. The ray's `from` is not looked at.
    pub fn closest(&self, ray: &Ray) -> Option<WorldHit> {
        let met = (0..).zip(&self.shown).filter_map(|(surface, shown)| {
            let t = shown.meet(ray)?;
            (t <= ray.t_max).then(|| WorldHit { t, position: ray.at(t), surface })
        });
        met.min_by(|a, b| a.t.total_cmp(&b.t))
    }

    /// Whether an answer is this judge's for some ray a nudge away, within a distance of `near`.
    pub fn excuses(&self, answer: &Option<Hit>, ray: &Ray, near: f64) -> bool {
        let towards = answer.map(|hit| hit.position - ray.origin);
        let normal = answer.map_or(DVec3::Z, |hit| hit.geometric_normal);
        nudged(ray.direction, towards, normal).any(|direction| {
            match (answer, self.closest(&Ray { direction, ..*ray })) {
                (None, None) => true,
                (Some(hit), Some(judge)) => hit.position.distance(judge.position) <= near,
                _ => false,
            }
        })
    }
}

impl Shown<'_> {
    fn meet(&self, ray: &Ray) -> Option<f64> {
        let Some((place, ball)) = &self.place else { return self.judge.meet(ray) };
        let local_from_world = match place {
            Place::Still(local_from_world) => *local_from_world,
            Place::Moving(moving) => moving.world_from_local(ray.time).inverse(),
        };
        let local = Ray {
            origin: local_from_world.transform_point3(ray.origin),
            direction: local_from_world.transform_vector3(ray.direction),
            ..*ray
        };
        if Line::of(&local).misses(ball) { None } else { self.judge.meet(&local) }
    }
}

impl<'a> Judge<'a> {
    fn new(surface: &'a Surface) -> Result<Self, String> {
        match surface {
            Surface::Quad(quad) => {
                let [c0, c1, c2, c3] = quad.corners();
                let corners = vec![[c0, c1, c2], [c0, c2, c3]];
                Ok(Self::Triangles { corners, one_sided: quad.one_sided() })
            }
            Surface::Sphere(sphere) => {
                Ok(Self::Sphere { center: sphere.center(), radius: sphere.radius() })
            }
            Surface::Mesh(mesh) => {
                let count = mesh.data().triangles.len() as u32;
                let corners = (0..count).map(|index| mesh.corners(index)).collect();
                Ok(Self::Triangles { corners, one_sided: false })
            }
            Surface::Face(face) => Ok(Self::Face(Box::new(of_face(face)))),
            Surface::ReliefSphere(sphere) => Ok(Self::ReliefSphere(Box::new(of_sphere(sphere)))),
            Surface::ReliefMesh(mesh) => of_mesh(mesh).map(Box::new).map(Self::ReliefMesh),
            Surface::Instance(_) | Surface::Moving(_) => {
                Err("an instance of an instance".to_owned())
            }
        }
    }

    /// The first meeting at `0 <= t`; no later than the ray's end, or not.
    fn meet(&self, ray: &Ray) -> Option<f64> {
        match self {
            Self::Triangles { corners, one_sided } => {
                let met = corners.iter().filter_map(|c| flat::triangle(c, *one_sided, ray));
                met.min_by(f64::total_cmp)
            }
            Self::Sphere { center, radius } => flat::sphere(*center, *radius, ray),
            Self::Face(oracle) => oracle.closest(ray).map(|hit| hit.t),
            Self::ReliefSphere(oracle) => oracle.closest(ray, -1e-300).map(|hit| hit.t),
            Self::ReliefMesh(oracle) => oracle.first(ray),
        }
    }

    /// A ball around all it shows.
    fn around(&self) -> Ball {
        match self {
            Self::Triangles { corners, .. } => Ball::around(corners.as_flattened()),
            Self::Sphere { center, radius } => Ball::of(*center, *radius),
            Self::Face(oracle) => {
                let (low, high) = oracle.offsets();
                let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
                let points = corners.map(|(u, v)| [low, 0.0, high].map(|w| oracle.point(u, v, w)));
                Ball::around(points.as_flattened())
            }
            Self::ReliefSphere(oracle) => oracle.around(),
            Self::ReliefMesh(oracle) => oracle.around(),
        }
    }
}

fn of_face(face: &ReliefFace) -> Oracle<'_> {
    let [c0, e1, e2, _] = face.frame();
    let options = face.options();
    let displacement = &options.displacement;
    let place = oracle::Placement {
        zero: displacement.zero,
        tile: displacement.tile,
        shift: displacement.shift,
        closed: options.closed,
        one_sided: options.one_sided,
        ..oracle::Placement::new(c0, e1, e2, displacement.scale)
    };
    Oracle::new(face.relief().heights(), place)
}

fn of_sphere(sphere: &ReliefSphere) -> SphereOracle {
    let faces = CubeFace::ALL.map(|face| sphere.relief().face(face).heights());
    SphereOracle::of(faces, (sphere.center(), sphere.radius()), sphere.options().displacement)
}

fn of_mesh(mesh: &ReliefMesh) -> Result<MeshOracle<'_>, String> {
    let (options, map) = (mesh.options(), mesh.relief().heights());
    if options.one_sided {
        return Err("a displaced mesh that is one-sided".to_owned());
    }
    if mesh.walls().any(|wall| wall.beside.is_some()) {
        return Err("a displaced mesh of several maps".to_owned());
    }
    // Walls along open borders are part of the judge's walls.
    let closing = match options.edges {
        Edges::Shared => Closing::Walls,
        Edges::AsAuthored => Closing::Authored,
    };
    if closing == Closing::Walls && !options.closed && mesh.report().open_edges > 0 {
        return Err("a displaced mesh with open borders".to_owned());
    }
    let base = Mesh::new(mesh.data().clone()).map_err(|error| error.to_string())?;
    Ok(MeshOracle::new(&base, map, options.displacement, closing))
}

#[cfg(test)]
mod tests;
