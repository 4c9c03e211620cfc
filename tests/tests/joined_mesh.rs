//! Meshes whose parts are displaced in different ways, or not at all: closed where the whole is.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use rilievo::Ray;
use rilievo::mesh::Mesh;
use rilievo::relief::{Displacement, MeshPart, Relief, ReliefMesh};
use rilievo::surface::{Surface, World};
use rilievo_tests::joined::{self, Joined, cut, fbm, options, ray, world};
use rilievo_tests::mesh_cases::size;
use rilievo_tests::meshes::Base;
use rilievo_tests::random::Random;

#[test]
fn nothing_escapes_between_parts_with_different_maps() {
    for Joined { base, world } in joined::all() {
        let escaped = (0..40_000).into_par_iter().filter(|&k| {
            let ray = ray(&base, DVec3::new(0.01, -0.02, 0.03), k);
            let Some(hit) = world.closest(&ray, &mut ()) else { return true };
            // On along the line: left once more than entered.
            let (mut count, mut next) = (0, Some(hit));
            while let Some(hit) = next
                && count < 100
            {
                count += 1;
                next = world.closest(&hit.spawn(ray.direction), &mut ());
            }
            k % 3 == 2 && count % 2 == 0
        });
        let escaped: Vec<u64> = escaped.collect();
        let parts = world.surfaces().len();
        assert!(escaped.is_empty(), "{parts} parts: {} rays, {:?}", escaped.len(), &escaped[..1]);
    }
}

/// Cut in parts that show one map in one way, a mesh is what it is whole: the same places, no walls where it is cut.
#[test]
fn parts_with_one_map_are_the_whole() {
    for base in [Base::Torus(12, 8), Base::Spot] {
        let base = base.mesh();
        let (relief, options) =
            (Arc::new(Relief::new(fbm(97))), options(0.02 * size(&base), 0.5, true));
        let whole = ReliefMesh::new(&base, Arc::clone(&relief), options.clone()).expect("valid");
        let meshes = cut(&base, 3, |k| k % 3);
        let laid = |mesh: &Mesh| MeshPart::displaced(mesh, Arc::clone(&relief), options.clone());
        let all: Vec<_> = meshes.iter().map(laid).collect();
        let joined = ReliefMesh::joined(&all).expect("valid");
        let walls = joined.iter().flatten().map(|part| part.report().seam_walls).sum::<usize>();
        assert_eq!(walls, whole.report().seam_walls);
        assert!(joined.iter().flatten().all(|part| part.is_joined()));
        let world = world(meshes, &all);
        (0..20_000).into_par_iter().for_each(|k| {
            let mut random = Random::new(&[72, k]);
            let bounds = whole.bounds();
            let within = |random: &mut Random| {
                let at = DVec3::from_array([(); 3].map(|()| random.unit()));
                bounds.min + at * (bounds.max - bounds.min)
            };
            let ray = Ray::between(2.0 * within(&mut random), within(&mut random));
            let ray = Ray { t_max: f64::INFINITY, ..ray };
            let (a, b) = (whole.closest(&ray, &mut ()), world.closest(&ray, &mut ()));
            match (a, b) {
                (None, None) => {}
                (Some(a), Some(b)) => {
                    let off = a.position.distance(b.position);
                    assert!(off <= 1e-9 * size(&base) && a.front == b.front, "{ray:?} {a:?} {b:?}");
                }
                _ => panic!("{ray:?} {a:?} {b:?}"),
            }
        });
    }
}

#[test]
fn parts_whose_displacements_are_changed_alike_stay_closed() {
    let base = Base::Icosphere(1).mesh();
    let meshes = cut(&base, 2, |k| k % 2);
    let options = options(0.1, 0.5, false);
    let laid =
        |(k, mesh)| MeshPart::displaced(mesh, Arc::new(Relief::new(fbm(k))), options.clone());
    let all: Vec<_> = (80..).zip(&meshes).map(laid).collect();
    let joined: Vec<_> = ReliefMesh::joined(&all).expect("valid").into_iter().flatten().collect();
    let deeper = |d: Displacement| Displacement { scale: 3.0 * d.scale, ..d };
    let deeper: Vec<Surface> = (joined.iter())
        .map(|part| part.with_displacements(deeper).expect("valid").into())
        .collect();
    let world = World::new(deeper);
    let escaped = (0..20_000u64).into_par_iter().filter(|&k| {
        world.closest(&ray(&base, DVec3::new(0.02, 0.01, -0.03), k), &mut ()).is_none()
    });
    assert_eq!(escaped.count(), 0);
}
