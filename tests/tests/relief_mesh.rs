//! Displaced meshes: all methods agree bit for bit, and a closed mesh stays closed.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};
use rayon::prelude::*;
use rilievo::map::{DistanceMap, DistanceOptions, HeightMap, Lattice, Layout, Metric, Wrap};
use rilievo::mesh::{Mesh, MeshData, Triangle};
use rilievo::relief::{Displacement, Edges, MeshOptions, Method, Relief, ReliefMesh};
use rilievo::{Counters, Ray, SimdLevel};
use rilievo_tests::maps::Shape;
use rilievo_tests::mesh_oracle::{Closing, MeshOracle};
use rilievo_tests::meshes::Base;
use rilievo_tests::nudge;
use rilievo_tests::random::Random;

/// A base with a map on it, of a thickness as a share of its size.
struct Case {
    name: &'static str,
    base: Base,
    map: HeightMap,
    thickness: f64,
    zero: f64,
    edges: Edges,
    tile: [f64; 2],
}

impl Case {
    fn mesh(&self, method: Method, place: DAffine3) -> ReliefMesh {
        self.mesh_over(method, place, None)
    }

    /// Over a distance map of a size, if the method walks one; by default that of the library.
    fn mesh_over(&self, method: Method, place: DAffine3, size: Option<[u32; 3]>) -> ReliefMesh {
        let mesh = self.base.placed(place);
        let scale = self.thickness * self::size(&mesh);
        let displacement =
            Displacement { scale, zero: self.zero, tile: self.tile, shift: [0.1, -0.3] };
        let mut relief = Relief::new(self.map.clone());
        if let Some(kind) = method.distance_kind() {
            let sides = [0.3 * self::size(&mesh); 2];
            let metric = Metric::of_face(&self.map, sides, scale);
            let default = DistanceOptions::by_default(&self.map, kind, metric);
            let options = DistanceOptions { size: size.unwrap_or(default.size), ..default };
            let map = DistanceMap::from_height(&self.map, kind, &options).expect(self.name);
            relief = relief.with_distance(map).expect(self.name);
        }
        let options = MeshOptions {
            displacement,
            method,
            edges: self.edges,
            closed: true,
            ..MeshOptions::default()
        };
        ReliefMesh::new(&mesh, Arc::new(relief), options).expect(self.name)
    }
}

/// The diagonal of a mesh's box.
fn size(mesh: &Mesh) -> f64 {
    let bounds = mesh.bounds();
    (bounds.max - bounds.min).length()
}

fn cases() -> Vec<Case> {
    let texel = |shape: Shape, size, wrap| shape.codes(size, Lattice::Texel, wrap);
    let case = |name, base, map, thickness| Case {
        name,
        base,
        map,
        thickness,
        zero: 0.5,
        edges: Edges::Shared,
        tile: [1.0, 1.0],
    };
    vec![
        case("torus", Base::Torus(12, 8), texel(Shape::Fbm(1), [48, 32], Wrap::Repeat), 0.03),
        case("thin", Base::Torus(12, 8), texel(Shape::White(2), [48, 32], Wrap::Repeat), 0.001),
        case("thick", Base::Torus(9, 6), texel(Shape::Fbm(3), [40, 24], Wrap::Repeat), 0.3),
        Case {
            zero: 2.0,
            ..case("inward", Base::Icosphere(2), texel(Shape::Fbm(4), [33, 17], Wrap::Clamp), 0.02)
        },
        case("sphere", Base::Icosphere(1), texel(Shape::White(5), [31, 18], Wrap::Mirror), 0.05),
        case(
            "cube",
            Base::Cube,
            Shape::Studs(4).floats([20, 13], Lattice::Vertex, Wrap::Mirror),
            0.05,
        ),
        Case {
            edges: Edges::AsAuthored,
            ..case("authored", Base::Cube, texel(Shape::Fbm(6), [20, 13], Wrap::Repeat), 0.1)
        },
        case("folded", Base::Folded(7), texel(Shape::Fbm(8), [16, 12], Wrap::Repeat), 0.05),
        case("trough", Base::Trough, texel(Shape::Ripple, [24, 40], Wrap::Repeat), 0.05),
        Case {
            tile: [5.0, 7.0],
            ..case("quad", Base::Quad, texel(Shape::White(9), [5, 4], Wrap::Repeat), 0.04)
        },
        case("coarse", Base::Torus(20, 14), texel(Shape::White(10), [4, 3], Wrap::Repeat), 0.05),
        case("spot", Base::Spot, texel(Shape::Fbm(11), [96, 96], Wrap::Repeat), 0.01),
        case("flat", Base::Icosphere(1), texel(Shape::Flat(0.7), [9, 9], Wrap::Repeat), 0.05),
        case("deep", Base::Icosphere(1), texel(Shape::Fbm(12), [40, 20], Wrap::Repeat), 0.3),
        case("film", Base::Spot, texel(Shape::White(13), [64, 64], Wrap::Repeat), 0.001),
        case("fur", Base::Spot, texel(Shape::Fbm(14), [48, 48], Wrap::Mirror), 0.2),
        matched(case("matched", Base::Spot, texel(Shape::Fbm(17), [64, 64], Wrap::Repeat), 0.02)),
    ]
}

/// Those, and one so deep over random uv that rays start within folds all over.
fn all_cases() -> Vec<Case> {
    let mut all = cases();
    all.push(Case {
        name: "knot",
        base: Base::Folded(15),
        map: Shape::White(16).codes([12, 16], Lattice::Texel, Wrap::Mirror),
        thickness: 0.3,
        zero: 0.5,
        edges: Edges::Shared,
        tile: [1.0, 1.0],
    });
    all
}

/// A case whose map is baked towards equal heights at seams.
fn matched(case: Case) -> Case {
    let mesh = case.mesh(Method::Pyramid, DAffine3::IDENTITY);
    Case { map: mesh.matched_heights(4), ..case }
}

fn places() -> [DAffine3; 4] {
    let far = DVec3::new(148376.0, 1234.0, -223423.0);
    let turn = DAffine3::from_rotation_x(0.7) * DAffine3::from_rotation_z(-0.4);
    [
        DAffine3::IDENTITY,
        DAffine3::from_translation(far) * turn,
        DAffine3::from_translation(far) * DAffine3::from_scale(DVec3::splat(1e-3)),
        DAffine3::from_scale(DVec3::splat(1e6)) * turn,
    ]
}

fn rays(default: u64) -> u64 {
    std::env::var("RILIEVO_RAYS").ok().and_then(|n| n.parse().ok()).unwrap_or(default)
}

/// A ray from around or inside the mesh towards it.
fn ray(mesh: &ReliefMesh, random: &mut Random) -> Ray {
    let bounds = mesh.bounds();
    let (centre, half) = (0.5 * (bounds.min + bounds.max), 0.5 * (bounds.max - bounds.min));
    let inside = |random: &mut Random, far: f64| {
        centre + half * far * DVec3::from_array([(); 3].map(|()| random.range(-1.0, 1.0)))
    };
    let origin = match random.integer(0, 3) {
        0 => centre + 3.0 * half.length() * random.direction(),
        1 => inside(random, 1.5),
        _ => inside(random, 1.0),
    };
    let mut ray = Ray::between(origin, inside(random, 0.9));
    ray.t_max = if random.one_in(4) { random.unit() } else { f64::INFINITY };
    ray
}

/// All ways to trace a case but the one that shows the leaf every cell.
fn contenders(case: &Case, place: DAffine3) -> Vec<(String, ReliefMesh)> {
    let mut all = vec![("pyramid".to_owned(), case.mesh(Method::Pyramid, place))];
    // Voxels of a cell, and of many cells.
    for (method, size) in [
        (Method::Distance, None),
        (Method::Distance, Some([5, 9, 4])),
        (Method::DistanceCorrected, Some([6, 7, 5])),
    ] {
        all.push((format!("{method}, {size:?}"), case.mesh_over(method, place, size)));
    }
    all
}

#[test]
fn every_method_equals_every_cell_bit_for_bit() {
    for case in all_cases() {
        for place in places() {
            let all = case.mesh(Method::Dda, place);
            let (mut hits, mut wrong) = (0, Vec::new());
            let answers: Vec<_> = (0..rays(400))
                .into_par_iter()
                .map(|k| {
                    let mut random = Random::new(&[31, k]);
                    let mut ray = ray(&all, &mut random);
                    let expected = all.closest(&ray, &mut ());
                    if let (true, Some(hit)) = (random.one_in(2), expected) {
                        ray = hit.spawn(random.direction() * size_of(&all));
                        return (ray, all.closest(&ray, &mut ()));
                    }
                    (ray, expected)
                })
                .collect();
            let contenders = contenders(&case, place);
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

fn size_of(mesh: &ReliefMesh) -> f64 {
    let bounds = mesh.bounds();
    (bounds.max - bounds.min).length()
}

/// Whether an answer is the oracle's, to rounding.
fn agrees(expected: Option<f64>, found: Option<f64>, near: f64) -> bool {
    match (expected, found) {
        (Some(a), Some(b)) => (a - b).abs() <= near,
        (None, None) => true,
        _ => false,
    }
}

#[test]
fn every_answer_is_the_oracles() {
    for case in all_cases() {
        let place = DAffine3::from_rotation_x(0.2) * DAffine3::from_translation(DVec3::splat(3.0));
        let mesh = case.mesh(Method::Pyramid, place);
        let base = case.base.placed(place);
        let closing = match case.edges {
            Edges::Shared => Closing::Walls,
            Edges::AsAuthored => Closing::Authored,
        };
        let displacement = mesh.options().displacement;
        let oracle = MeshOracle::new(&base, &case.map, displacement, closing);
        let near = 1e-9 * size_of(&mesh);
        let faults: Vec<_> = (0..rays(400))
            .into_par_iter()
            .filter_map(|k| {
                let mut ray = ray(&mesh, &mut Random::new(&[32, k]));
                ray.t_max = f64::INFINITY;
                let found = mesh.closest(&ray, &mut ());
                let expected = oracle.first(&ray);
                let t = found.map(|hit| hit.t);
                let near = near / ray.direction.length();
                if agrees(expected, t, near) {
                    return None;
                }
                let answer = found.map(|hit| hit.position - ray.origin);
                let normal = found.map_or(DVec3::Z, |hit| hit.geometric_normal);
                let excused = nudge::nudged(ray.direction, answer, normal).any(|direction| {
                    agrees(oracle.first(&Ray { direction, ..ray }), t, 1e4 * near)
                });
                Some((excused, ray, expected, found))
            })
            .collect();
        let excused = faults.iter().filter(|fault| fault.0).count();
        let wrong: Vec<_> = faults.iter().filter(|fault| !fault.0).collect();
        let count = wrong.len();
        assert!(wrong.is_empty(), "{}: {count} wrong, first {:#?}", case.name, wrong[0]);
        assert!(excused as u64 * 200 <= rays(400), "{}: {excused} excused", case.name);
    }
}

#[test]
fn nothing_escapes_from_inside_of_a_closed_mesh() {
    for case in cases() {
        if !case.base.is_closed() || case.edges == Edges::AsAuthored {
            continue;
        }
        for place in places() {
            let mesh = case.mesh(Method::Pyramid, place);
            let base = case.base.placed(place);
            let oracle =
                MeshOracle::new(&base, &case.map, mesh.options().displacement, Closing::Walls);
            let bounds = mesh.bounds();
            let size = size_of(&mesh);
            let within = |random: &mut Random| {
                let at = DVec3::from_array([(); 3].map(|()| random.unit()));
                bounds.min + at * (bounds.max - bounds.min)
            };
            let inside = |point: DVec3, random: &mut Random| {
                (0..3).all(|_| {
                    let t = oracle.crossings(&Ray::new(point, size * random.direction()));
                    t.iter().filter(|&&t| t >= 0.0).count() % 2 == 1
                })
            };
            let mut random = Random::new(&[33]);
            let mut origins = Vec::new();
            for _ in 0..2000 {
                let point = within(&mut random);
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
            // A spawned ray may pass a dip, or start in a fold, thinner than its lift.
            let one_in = if mesh.report().folded.is_empty() { 20_000 } else { 500 };
            let most = (rays(2000) / one_in) as usize;
            assert!(count <= most, "{}: {count} do not alternate, {:?}", case.name, leaks[0]);
        }
    }
}

/// A point of an edge of the base, displaced by any height.
fn target(mesh: &ReliefMesh, random: &mut Random) -> DVec3 {
    let data = mesh.data();
    let triangle = &data.triangles[random.integer(0, data.triangles.len() as i32 - 1) as usize];
    let [a, b, c] = triangle.positions.map(|p| data.positions[p as usize]);
    let normal = (b - a).cross(c - a).normalize();
    let s = if random.one_in(3) { 0.0 } else { random.unit() };
    a.lerp(b, s) + random.range(-0.5, 0.5) * mesh.options().displacement.scale * normal
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
            sum += near.fold(size_of(&mesh), f64::min);
        }
        errors.push(sum / 400.0);
    }
    assert!(errors.windows(2).all(|two| two[1] < 0.6 * two[0]), "{errors:?}");
    assert!(errors[3] < 1e-4 * size_of(&mesh), "{errors:?}");
}
