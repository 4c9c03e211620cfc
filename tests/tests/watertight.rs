//! Rays that must meet a relief do, and cross it in the right order.

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use rilievo::Ray;
use rilievo::map::{Lattice, Wrap};
use rilievo::relief::{Method, ReliefFace};
use rilievo_tests::kernel;
use rilievo_tests::maps::Shape;
use rilievo_tests::oracle::{Oracle, Placement};
use rilievo_tests::random::Random;
use rilievo_tests::scenes::{self, Scene};

const EXACT: [Method; 4] =
    [Method::Dda, Method::Pyramid, Method::Distance, Method::DistanceCorrected];

/// A segment from above the slab to below it that never leaves the face's window. A third run
/// along a line of the lattice, a third through one of its points.
fn crossing(oracle: &Oracle<'_>, random: &mut Random) -> Ray {
    let (low, high) = oracle.offsets();
    let depth = (high - low).max(1e-3 * oracle.size());
    let (from, to) = oracle.window();
    let mut ends = [0, 1].map(|_| [random.range(0.02, 0.98), random.range(0.02, 0.98)]);
    let line = |random: &mut Random, axis: usize| {
        let inside = (from[axis] + 0.02 * (to[axis] - from[axis])).ceil();
        let last = (to[axis] - 0.02 * (to[axis] - from[axis])).floor().max(inside);
        let mut at = from;
        at[axis] = f64::from(random.integer(inside as i32, last as i32));
        oracle.uv_of_lattice(at)[axis].clamp(0.0, 1.0)
    };
    match random.integer(0, 2) {
        0 => {
            let axis = random.integer(0, 1) as usize;
            let at = line(random, axis);
            ends[0][axis] = at;
            ends[1][axis] = at;
        }
        1 => {
            let at = [0, 1].map(|axis| line(random, axis));
            let reach = at.map(|at| random.unit() * at.min(1.0 - at));
            ends = [[at[0] - reach[0], at[1] - reach[1]], [at[0] + reach[0], at[1] + reach[1]]];
        }
        _ => {}
    }
    let [a, b] = ends;
    let top = high + depth * random.range(0.01, 1.0);
    let bottom = low - depth * random.range(0.01, 1.0);
    Ray::between(oracle.point(a[0], a[1], top), oracle.point(b[0], b[1], bottom))
}

/// All hits along a ray, each found by leaving the one before.
fn hits_along(face: &ReliefFace, ray: &Ray) -> Vec<bool> {
    let mut sides = Vec::new();
    let mut next = face.closest(ray, &mut ());
    while let Some(hit) = next
        && sides.len() < 10_000
    {
        sides.push(hit.front);
        next = face.closest(&hit.spawn(ray.direction), &mut ());
    }
    sides
}

#[test]
fn a_ray_from_above_to_below_always_hits() {
    for scene in scenes::all().into_iter().filter(|scene| !scene.place.one_sided) {
        for method in EXACT {
            let face = kernel::face(&scene, method);
            let oracle = scene.oracle();
            let leaks: Vec<_> = (0..5000u64)
                .into_par_iter()
                .map(|k| crossing(&oracle, &mut Random::new(&[21, k])))
                .filter(|ray| face.closest(ray, &mut ()).is_none())
                .collect();
            let count = leaks.len();
            assert!(leaks.is_empty(), "{}, {method}: {count} leaks, {:?}", scene.name, leaks[0]);
        }
    }
}

#[test]
fn crossings_alternate_and_their_number_is_odd() {
    let open = |scene: &Scene| !scene.place.one_sided && !scene.place.closed;
    for scene in scenes::all().into_iter().filter(open) {
        let face = kernel::face(&scene, Method::Pyramid);
        let oracle = scene.oracle();
        let wrong: Vec<_> = (0..5000u64)
            .into_par_iter()
            .filter_map(|k| {
                let mut ray = crossing(&oracle, &mut Random::new(&[22, k]));
                ray.t_max = f64::INFINITY;
                let sides = hits_along(&face, &ray);
                let alternate = sides.iter().enumerate().all(|(n, front)| *front == (n % 2 == 0));
                (!alternate || sides.len().is_multiple_of(2)).then_some((ray, sides))
            })
            .collect();
        let count = wrong.len();
        assert!(wrong.is_empty(), "{}: {count} rays, first {:?}", scene.name, wrong[0]);
    }
}

/// A cube with a relief standing outwards on every side, closed down to the cube.
fn cube(shape: Shape, centre: DVec3, half: f64) -> Vec<Scene> {
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.6);
    let sides = [
        (DVec3::X, DVec3::Y, DVec3::Z),
        (DVec3::Y, DVec3::Z, DVec3::X),
        (DVec3::Z, DVec3::X, DVec3::Y),
    ];
    let mut scenes = Vec::new();
    for (out, u, v) in sides {
        for (out, u, v) in [(out, u, v), (-out, v, u)] {
            let corner = |a: f64, b: f64| centre + turn * (half * (out + a * u + b * v));
            let map = shape.codes([40, 24], Lattice::Texel, Wrap::Repeat);
            let corners =
                [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            let base = Placement::new(DVec3::ZERO, DVec3::X, DVec3::Y, 0.6 * half);
            let place = Placement { corners, closed: true, tile: [2.0, 3.5], ..base };
            scenes.push(Scene::new("cube", map, place));
        }
    }
    scenes
}

#[test]
fn nothing_escapes_from_a_closed_cube() {
    for (shape, centre, half) in [
        (Shape::White(3), DVec3::ZERO, 1.0),
        (Shape::Studs(5), scenes::FAR, 0.7),
        (Shape::Fbm(8), DVec3::new(1.0, 2.0, 3.0), 1e4),
    ] {
        let scenes = cube(shape, centre, half);
        for method in EXACT {
            let faces: Vec<_> = scenes.iter().map(|scene| kernel::face(scene, method)).collect();
            (0..50_000u64).into_par_iter().for_each(|k| {
                let mut random = Random::new(&[23, k]);
                let at = DVec3::from_array([(); 3].map(|()| random.range(-0.99, 0.99)));
                let ray = Ray::new(centre + half * 0.57 * at, random.direction());
                let hit = faces.iter().any(|face| face.occludes(&ray, &mut ()));
                let seen = faces.iter().filter_map(|face| face.closest(&ray, &mut ()));
                let nearest = seen.min_by(|a, b| a.t.total_cmp(&b.t));
                assert!(hit && nearest.is_some(), "{method}: {ray:?} escapes");
                assert!(!nearest.unwrap().front, "{method}: {ray:?} sees the outside from within");
            });
        }
    }
}
