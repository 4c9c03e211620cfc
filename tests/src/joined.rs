//! Meshes cut in parts that are displaced in different ways, or not at all, and rays at their edges.

use std::sync::Arc;

use glam::DVec3;
use rilievo::Ray;
use rilievo::map::{HeightMap, Lattice, Wrap};
use rilievo::mesh::{Mesh, MeshData};
use rilievo::relief::{Displacement, MeshOptions, MeshPart, Relief, ReliefMesh};
use rilievo::surface::{Surface, World};

use crate::maps::Shape;
use crate::mesh_cases::size;
use crate::meshes::Base;
use crate::random::Random;

/// A closed mesh around the origin, cut in parts.
pub struct Joined {
    /// What is displaced.
    pub base: Mesh,
    /// Its parts.
    pub world: World,
}

/// Some, each part but the last with a map and a depth of its own; the last one stays as it is.
pub fn all() -> impl Iterator<Item = Joined> {
    [(Base::Icosphere(2), 3), (Base::Cube, 4), (Base::Icosphere(1), 5)].into_iter().map(
        |(base, parts)| {
            let base = base.mesh();
            let meshes = cut(&base, parts, |k| (k * 7 + k / 3) % parts);
            let laid = |(k, mesh): (usize, &Mesh)| {
                if k + 1 == parts {
                    return MeshPart::plain(mesh);
                }
                let scale = [0.03, 0.08, -0.05, 0.02][k % 4] * size(&base);
                let relief = Arc::new(Relief::new(fbm(90 + k as u64)));
                MeshPart::displaced(mesh, relief, options(scale, 0.5, false))
            };
            let all: Vec<_> = meshes.iter().enumerate().map(laid).collect();
            Joined { world: world(meshes, &all), base }
        },
    )
}

/// The triangles of a base by the parts they fall to.
///
/// # Panics
/// If the library refuses one.
pub fn cut(base: &Mesh, parts: usize, part_of: impl Fn(usize) -> usize) -> Vec<Mesh> {
    let data = base.data();
    let part = |part| {
        let own = data.triangles.iter().enumerate().filter(|(k, _)| part_of(*k) == part);
        let triangles = own.map(|(_, triangle)| *triangle).collect();
        Mesh::new(MeshData { triangles, ..data.clone() }).expect("valid")
    };
    (0..parts).map(part).collect()
}

/// How a part is displaced.
pub fn options(scale: f64, zero: f64, closed: bool) -> MeshOptions {
    let displacement = Displacement { scale, zero, ..Displacement::default() };
    MeshOptions { displacement, closed, ..MeshOptions::default() }
}

/// The parts as surfaces of a world.
///
/// # Panics
/// If the library refuses them.
pub fn world(meshes: Vec<Mesh>, parts: &[MeshPart]) -> World {
    let joined = ReliefMesh::joined(parts).expect("valid");
    let surface = |(mesh, displaced): (Mesh, Option<ReliefMesh>)| match displaced {
        Some(displaced) => Surface::from(displaced),
        None => Surface::from(mesh),
    };
    World::new(meshes.into_iter().zip(joined).map(surface).collect())
}

/// A small map.
pub fn fbm(seed: u64) -> HeightMap {
    Shape::Fbm(seed).codes([40, 30], Lattice::Texel, Wrap::Repeat)
}

/// A ray from the middle to a corner, a point of an edge or, every third, anything else.
pub fn ray(base: &Mesh, middle: DVec3, k: u64) -> Ray {
    let mut random = Random::new(&[71, k]);
    let data = base.data();
    let triangle = &data.triangles[random.integer(0, data.triangles.len() as i32 - 1) as usize];
    let [a, b, c] = triangle.positions.map(|p| data.positions[p as usize]);
    let at = match k % 3 {
        0 => a,
        1 => a.lerp(b, random.unit()),
        _ => a.lerp(b, random.unit()).lerp(c, random.unit()),
    };
    Ray::new(middle, at - middle)
}
