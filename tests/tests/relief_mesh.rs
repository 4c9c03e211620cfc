//! Displaced meshes: all methods agree bit for bit, and a closed mesh stays closed.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};
use rayon::prelude::*;
use rilievo::map::{Lattice, Layout, Wrap};
use rilievo::mesh::{Mesh, MeshData, Triangle};
use rilievo::relief::{Displacement, MeshOptions, Method, Relief, ReliefMesh};
use rilievo::{Counters, Ray, SimdLevel};
use rilievo_tests::maps::Shape;
use rilievo_tests::mesh_cases::{
    all_cases, case, cases, places, point_near, ray, reach, size, target,
};
use rilievo_tests::mesh_oracle::Verdict;
use rilievo_tests::random::Random;

fn rays(default: u64) -> u64 {
    std::env::var("RILIEVO_RAYS").ok().and_then(|n| n.parse().ok()).unwrap_or(default)
}

#[test]
fn every_method_equals_every_cell_bit_for_bit() {
    for case in all_cases() {
        for place in places() {
            let (all, oracle) = (case.mesh(Method::Dda, place), case.oracle(place));
            let brute = |ray: &Ray| all.closest_among(ray, |ray| oracle.cells_near(ray));
            let (mut hits, mut wrong) = (0, Vec::new());
            let answers: Vec<_> = (0..rays(400))
                .into_par_iter()
                .map(|k| {
                    let mut random = Random::new(&[31, k]);
                    let mut ray = ray(&all, &mut random);
                    let expected = brute(&ray);
                    if let (true, Some(hit)) = (random.one_in(2), expected) {
                        ray = hit.spawn(random.direction() * reach(&all));
                        return (ray, brute(&ray));
                    }
                    (ray, expected)
                })
                .collect();
            let contenders = case.contenders(place);
            for (ray, expected) in answers {
                hits += u64::from(expected.is_some());
                for (name, mesh) in &contenders {
                    let found = mesh.closest(&ray, &mut ());
                    if found != expected || mesh.occludes(&ray, &mut ()) != expected.is_some() {
                        wrong.push((name, ray, expected, found));
                    }
                }
            }
            let count = wrong.len();
            assert!(hits * 10 > rays(400), "{}: {hits} hits", case.name);
            assert!(wrong.is_empty(), "{}: {count} wrong, first {:#?}", case.name, wrong[0]);
        }
    }
}

/// The cells that brute force and judge leave out, because a line passes their ball, hold nothing: `dda` and the
/// leaf over all cells of all triangles give the same bits.
#[test]
fn cells_far_from_a_line_hold_nothing() {
    for case in all_cases() {
        for place in places() {
            let (mesh, oracle) = (case.mesh(Method::Dda, place), case.oracle(place));
            let all = oracle.all_cells();
            (0..rays(8)).into_par_iter().for_each(|k| {
                let mut random = Random::new(&[37, k]);
                let first = ray(&mesh, &mut random);
                let hit = mesh.closest(&first, &mut ());
                let spawned = hit.map(|hit| hit.spawn(random.direction() * reach(&mesh)));
                for ray in std::iter::once(first).chain(spawned) {
                    let expected = mesh.closest(&ray, &mut ());
                    let near = mesh.closest_among(&ray, |ray| oracle.cells_near(ray));
                    assert_eq!(near, expected, "{}: {ray:?}", case.name);
                    let every = mesh.closest_among(&ray, |_| all.clone());
                    assert_eq!(every, expected, "{}: {ray:?}", case.name);
                    let crossings = oracle.crossings(&ray);
                    assert_eq!(crossings, oracle.every_crossing(&ray), "{}", case.name);
                }
            });
        }
    }
}

#[test]
fn every_answer_is_the_oracles() {
    for case in all_cases() {
        let place = DAffine3::from_rotation_x(0.2) * DAffine3::from_translation(DVec3::splat(3.0));
        let mesh = case.mesh(Method::Pyramid, place);
        let oracle = case.oracle(place);
        let near = 1e-9 * reach(&mesh);
        let faults: Vec<_> = (0..rays(400))
            .into_par_iter()
            .filter_map(|k| {
                let mut ray = ray(&mesh, &mut Random::new(&[32, k]));
                ray.t_max = f64::INFINITY;
                let found = mesh.closest(&ray, &mut ());
                match oracle.judge(&ray, &oracle.cells_near(&ray), found.as_ref(), near) {
                    Verdict::Equal => None,
                    verdict => Some((verdict, ray, oracle.first(&ray), found)),
                }
            })
            .collect();
        let (excused, wrong): (Vec<_>, Vec<_>) =
            faults.into_iter().partition(|fault| fault.0 == Verdict::Excused);
        let count = wrong.len();
        assert!(wrong.is_empty(), "{}: {count} wrong, first {:#?}", case.name, wrong[0]);
        assert!(excused.len() as u64 * 200 <= rays(400), "{}: {}", case.name, excused.len());
    }
}

#[test]
fn nothing_escapes_from_inside_of_a_closed_mesh() {
    for case in all_cases() {
        if !case.is_closed() {
            continue;
        }
        for place in places() {
            let mesh = case.mesh(Method::Pyramid, place);
            let oracle = case.oracle(place);
            let size = reach(&mesh);
            let inside = |point: DVec3, random: &mut Random| {
                (0..3).all(|_| {
                    let t = oracle.crossings(&Ray::new(point, size * random.direction()));
                    t.iter().filter(|&&t| t >= 0.0).count() % 2 == 1
                })
            };
            let mut random = Random::new(&[33]);
            let mut origins = Vec::new();
            for _ in 0..2000 {
                let point = point_near(&mesh, &mut random);
                if origins.len() < 20 && inside(point, &mut random) {
                    origins.push(point);
                }
            }
            assert!(origins.len() >= 10, "{}: {} origins inside", case.name, origins.len());
            let leaks: Vec<_> = (0..rays(2000))
                .into_par_iter()
                .filter_map(|k| {
                    let mut random = Random::new(&[34, k]);
                    let origin = origins[k as usize % origins.len()];
                    let direction = match random.integer(0, 2) {
                        0 => size * random.direction(),
                        // At a vertex or a point of an edge, displaced somewhere.
                        _ => target(&mesh, &mut random) - origin,
                    };
                    let ray = Ray::new(origin, direction);
                    let Some(hit) = mesh.closest(&ray, &mut ()) else { return Some((ray, 0)) };
                    // On along the same line to the end: left once more than entered.
                    let mut crossed = vec![hit.front];
                    let mut next = mesh.closest(&hit.spawn(direction), &mut ());
                    while let Some(hit) = next
                        && crossed.len() < 1000
                    {
                        crossed.push(hit.front);
                        next = mesh.closest(&hit.spawn(direction), &mut ());
                    }
                    let back = hit.spawn(origin - hit.position);
                    let returns = !mesh.occludes(&Ray { t_max: 0.999_999, ..back }, &mut ());
                    (crossed.len() % 2 == 0 || !returns).then_some((ray, crossed.len()))
                })
                .collect();
            let count = leaks.len();
            let escaped = leaks.iter().filter(|leak| leak.1 == 0).count();
            assert_eq!(escaped, 0, "{}: {:?}", case.name, leaks[0]);
            // A spawned ray may pass a dip, or start in a fold, thinner than its lift; and at a pole that it
            // is aimed at all walls are nearer than that. A knot is folds all over.
            let one_in = match mesh.report().folded.is_empty() {
                _ if case.base.has_poles() => 200,
                _ if case.name == "knot" => 500,
                true => 20_000,
                false => 500,
            };
            let most = (rays(2000) / one_in) as usize;
            assert!(count <= most, "{}: {count} do not alternate, {:?}", case.name, leaks[0]);
        }
    }
}

/// Bit for bit the same at every SIMD level, in both layouts of the pyramid, for codes and floats.
#[test]
fn levels_and_layouts_give_the_same_bits() {
    let case = &cases()[0];
    let mesh = case.base.mesh();
    let scale = case.thickness * size(&mesh);
    let make = |layout, simd| {
        let displacement = Displacement { scale, tile: [1.5, 2.0], ..Displacement::default() };
        let options = MeshOptions { displacement, simd, ..MeshOptions::default() };
        let relief = Relief::with_layout(case.map.clone(), layout);
        ReliefMesh::new(&mesh, Arc::new(relief), options).expect("valid")
    };
    let reference = make(Layout::Default, SimdLevel::detect());
    for layout in Layout::ALL {
        for &simd in SimdLevel::available() {
            let other = make(layout, simd);
            for k in 0..3000 {
                let ray = ray(&reference, &mut Random::new(&[35, k]));
                assert_eq!(reference.closest(&ray, &mut ()), other.closest(&ray, &mut ()));
            }
        }
    }
}

/// A ray along an axis is not cut before it leaves the box, whatever the sign of its zeros.
#[test]
fn rays_along_axes_reach_the_far_side() {
    let mesh = case("cube").mesh(Method::Pyramid, DAffine3::IDENTITY);
    for axis in 0..3 {
        for zero in [0.0, -0.0] {
            for side in [-1.0, 1.0] {
                let mut direction = DVec3::splat(zero);
                direction[axis] = side;
                let hit = mesh.closest(&Ray::new(DVec3::ZERO, direction), &mut ());
                let hit = hit.expect("the middle is inside");
                assert!(!hit.front && (0.7..1.3).contains(&hit.t), "{hit:?}");
            }
        }
    }
}

/// Triangles that are out of the ordinary are reported, and what can be hit is.
#[test]
fn degenerate_triangles_are_reported_and_not_lost() {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)];
    let uvs = vec![DVec2::new(0.2, 0.3), DVec2::new(0.7, 0.3), DVec2::new(0.45, 0.3)];
    let triangle = |positions, uvs| Triangle { positions, normals: None, uvs: Some(uvs) };
    let data = MeshData {
        positions: corners.to_vec(),
        normals: Vec::new(),
        uvs,
        triangles: vec![
            // Uv on a line, uv in a point, and no area at all.
            triangle([0, 1, 2], [0, 1, 2]),
            triangle([1, 3, 2], [1, 1, 1]),
            triangle([0, 1, 1], [0, 1, 1]),
        ],
    };
    let map = Shape::White(3).codes([16, 16], Lattice::Texel, Wrap::Repeat);
    let displacement = Displacement { scale: 0.2, ..Displacement::default() };
    let mesh = Mesh::new(data).expect("valid");
    for method in [Method::Pyramid, Method::Dda] {
        let options = MeshOptions { displacement, method, ..MeshOptions::default() };
        let relief = Arc::new(Relief::new(map.clone()));
        let mesh = ReliefMesh::new(&mesh, relief, options).expect("valid");
        assert_eq!(mesh.report().no_uv_area, [0, 1]);
        assert_eq!(mesh.report().no_volume, [2]);
        for (x, y) in [(0.1, 0.1), (0.3, 0.4), (0.9, 0.05), (0.8, 0.7), (0.5, 0.5), (0.99, 0.99)] {
            let down = Ray::new(DVec3::new(x, y, 1.0), -DVec3::Z);
            let hit = mesh.closest(&down, &mut ()).expect("covered");
            let (u, v) = if x + y <= 1.0 { (0.2 + 0.5 * x + 0.25 * y, 0.3) } else { (0.7, 0.3) };
            let offset = 0.2 * map.height_at(u, v);
            assert!((hit.position.z - offset).abs() < 1e-12, "{method} {x} {y}");
        }
    }
}

/// A thread of uv over a million cells costs as many cells as it is long, not their square.
#[test]
fn a_long_thread_is_walked_along() {
    let uvs = vec![DVec2::ZERO, DVec2::splat(500.0), DVec2::splat(1000.0)];
    let triangle = Triangle { positions: [0, 1, 2], normals: None, uvs: Some([0, 1, 2]) };
    let data = MeshData {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        normals: Vec::new(),
        uvs,
        triangles: vec![triangle],
    };
    let map = Shape::White(3).codes([16, 16], Lattice::Texel, Wrap::Repeat);
    let displacement = Displacement { scale: 0.2, ..Displacement::default() };
    let options = MeshOptions { displacement, ..MeshOptions::default() };
    let mesh = Mesh::new(data).expect("valid");
    let mesh = ReliefMesh::new(&mesh, Arc::new(Relief::new(map.clone())), options).expect("valid");
    let mut counters = Counters::default();
    let down = Ray::new(DVec3::new(0.3, 0.2, 1.0), -DVec3::Z);
    let hit = mesh.closest(&down, &mut counters).expect("covered");
    let s = 500.0 * 0.3 + 1000.0 * 0.2;
    assert!((hit.position.z - 0.2 * map.height_at(s, s)).abs() < 1e-9);
    assert!(counters.cells <= 4 * 16_000, "{counters:?}");
}

/// A finer tessellation comes closer to what is hit.
#[test]
fn tessellations_converge_to_the_surface() {
    let case = &cases()[0];
    let mesh = case.mesh(Method::Pyramid, DAffine3::IDENTITY);
    let triangles = mesh.data().triangles.len() as u32;
    let mut errors = Vec::new();
    for n in [4u32, 8, 16, 32] {
        let mut sum = 0.0;
        let mut random = Random::new(&[36]);
        for _ in 0..400 {
            let base = random.integer(0, triangles as i32 - 1) as u32;
            let (i, j) = (random.unit() * f64::from(n), random.unit() * f64::from(n));
            let (i, j) =
                if i + j > f64::from(n) { (f64::from(n) - i, f64::from(n) - j) } else { (i, j) };
            // The small triangle around a place, and its middle.
            let flip = i.fract() + j.fract() > 1.0;
            let (a, b) =
                (i.floor() + f64::from(u8::from(flip)), j.floor() + f64::from(u8::from(flip)));
            let step = if flip { -1.0 } else { 1.0 };
            let at = |x: f64, y: f64| {
                let (v, w) = (x / f64::from(n), y / f64::from(n));
                mesh.point(base, [1.0 - v - w, v, w])
            };
            let corners = [at(a, b), at(a + step, b), at(a, b + step)];
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            // To the surface on either side of the facet.
            let near = [normal, -normal].into_iter().filter_map(|direction| {
                mesh.closest(&Ray::new(middle, direction), &mut ()).map(|hit| hit.t)
            });
            sum += near.fold(reach(&mesh), f64::min);
        }
        errors.push(sum / 400.0);
    }
    assert!(errors.windows(2).all(|two| two[1] < 0.6 * two[0]), "{errors:?}");
    assert!(errors[3] < 1e-4 * reach(&mesh), "{errors:?}");
}
