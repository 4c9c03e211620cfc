//! Worlds against their surfaces, tried in turn.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::*;
use crate::accel::random::Random;
use crate::map::{HeightMap, Lattice, Samples, Wrap};
use crate::mesh::{Mesh, MeshData, Triangle};
use crate::ray::Coherence;
use crate::relief::{Displacement, FaceOptions, Relief, ReliefFace};
use crate::surface::{Quad, Sphere};

fn quad(corners: [DVec3; 4]) -> Surface {
    Surface::Quad(Quad::new(corners, false).expect("valid"))
}

/// The six sides of `center + turn * scale * [-1, 1]^3`; normals point in, or out where a bit
/// of `flips` is set.
fn closed_box(center: DVec3, turn: DMat3, flips: u32) -> World {
    let side = |k: u32| {
        let axis = DVec3::AXES[k as usize / 2] * if k & 1 == 0 { 1.0 } else { -1.0 };
        let u = DVec3::new(axis.z, axis.x, axis.y);
        let v = if flips >> k & 1 == 1 { u.cross(-axis) } else { u.cross(axis) };
        // Corner by corner from the cube's, so that neighbours share them bit for bit.
        let corners = [-u - v, u - v, u + v, v - u];
        quad(corners.map(|c| center + turn * (c - axis)))
    };
    World::new((0..6).map(side).collect())
}

fn boxes() -> Vec<(DVec3, f64, World)> {
    let far = DVec3::new(148376.0, 1234.0, -223423.0);
    let turn = DMat3::from_rotation_x(0.3) * DMat3::from_rotation_z(1.1);
    let mut all = Vec::new();
    for (center, size) in [(DVec3::ZERO, 1.0), (far, 1.0), (far, 1e-3), (DVec3::ONE, 1e6)] {
        for (turn, flips) in [(DMat3::IDENTITY, 0), (turn, 0b011010)] {
            all.push((center, size, closed_box(center, turn * size, flips)));
        }
    }
    all
}

/// A target on a side: a corner, a point on an edge, or anything.
fn target(world: &World, random: &mut Random) -> DVec3 {
    let Surface::Quad(quad) = &world.surfaces()[random.below(6)] else { unreachable!() };
    let [a, b, c, d] = quad.corners();
    match random.below(4) {
        0 => a,
        1 => a.midpoint(b),
        2 => b.lerp(c, random.unit()),
        _ => a.lerp(b, random.unit()).lerp(d.lerp(c, random.unit()), random.unit()),
    }
}

#[test]
fn a_closed_box_keeps_rays_in_and_light_out() {
    let mut random = Random(83);
    for (center, size, world) in boxes() {
        for case in 0..125_000 {
            let origin = center + 0.5 * size * random.cube();
            let direction = match case % 2 {
                0 => random.direction(),
                _ => target(&world, &mut random) - origin,
            };
            let hit = world.closest(&Ray::new(origin, direction), &mut ()).expect("escaped");
            // Shadow rays to points far outside are stopped, wherever they start.
            let outside = center + 100.0 * size * random.direction();
            let inward = (center - hit.position).dot(hit.geometric_normal) > 0.0;
            let shadow = hit.spawn_to(outside);
            let from = shadow.from.expect("spawned");
            if from.front == inward {
                assert!(world.occluded(&shadow, &mut ()), "leak: {shadow:?}");
            }
            let aimed = hit.spawn(target(&world, &mut random) - hit.position);
            if aimed.is_valid() && aimed.from.expect("spawned").front == inward {
                let next = world.closest(&aimed, &mut ());
                let next = next.unwrap_or_else(|| panic!("leak: {aimed:?} {hit:?}"));
                assert!(next.surface != hit.surface, "own start: {aimed:?}");
            }
            assert!(world.occluded(&Ray::between(outside, origin), &mut ()));
            // And to points well inside they are free.
            assert!(!world.occluded(&hit.spawn_to(center), &mut ()), "stopped at {hit:?}");
        }
    }
}

#[test]
fn a_thousand_rays_from_a_thousand_hits_on_a_quad() {
    let mut random = Random(97);
    let (_, _, world) = boxes().swap_remove(1);
    for _ in 0..1000 {
        let ray = Ray::new(0.5 * random.cube(), random.direction());
        let hit = world.closest(&ray, &mut ()).expect("escaped");
        for _ in 0..1000 {
            let spawned = hit.spawn(random.direction());
            let inward = spawned.direction.dot(-hit.position) > 0.0
                && hit.geometric_normal.dot(spawned.direction)
                    * hit.geometric_normal.dot(-hit.position)
                    > 0.0;
            let next = world.closest(&spawned, &mut ());
            assert!(next.is_none_or(|n| n.surface != hit.surface && n.t > 0.0));
            assert!(!inward || next.is_some());
        }
    }
}

#[test]
fn flat_surfaces_on_one_plane_do_not_shadow_each_other() {
    // Two tiles with a common edge, and a mesh triangle lying over both.
    let tile = |x: f64| {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[u, v]| DVec3::new(x + u, v, 0.0))
    };
    let corners = vec![DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y];
    let triangle = Triangle { positions: [0, 1, 2], normals: None, uvs: None };
    let data = MeshData { positions: corners, triangles: vec![triangle], ..Default::default() };
    let mesh = Surface::Mesh(Mesh::new(data).expect("valid"));
    let world = World::new(vec![quad(tile(0.0)), mesh, quad(tile(1.0))]);
    let mut random = Random(101);
    for x in [0.5, 1.0, 1.0 - 1e-16, 1.0 + 1e-13] {
        let down = Ray::new(DVec3::new(x, 0.25, 1.0), -DVec3::Z);
        let hit = world.closest(&down, &mut ()).expect("hit");
        // All lie at t = 1: the smallest index wins.
        assert_eq!((hit.t, hit.surface), (1.0, u32::from(x > 1.0 + 1e-14)));
        for _ in 0..1000 {
            assert!(!world.occluded(&hit.spawn(random.direction()), &mut ()));
        }
    }
}

#[test]
fn equals_every_surface_tried_in_turn() {
    let mut random = Random(103);
    let mut surfaces = Vec::new();
    for k in 0..60 {
        let (c, u, v) = (2.0 * random.cube(), random.cube(), random.cube());
        surfaces.push(match k % 2 {
            0 => quad([c, c + u, c + u + v, c + v]),
            _ => Surface::Sphere(Sphere::new(c, 0.1 + 0.4 * random.unit()).expect("valid")),
        });
    }
    // Worlds with a tree and worlds so small that they are a list.
    for (count, cases) in [(60, 20_000), (4, 5000), (3, 5000), (1, 5000)] {
        let world = World::new(surfaces[..count].to_vec());
        assert!(world.surfaces().iter().all(|s| world.bounds().contains(&s.bounds())));
        check_against_every_surface(&world, cases, &mut random);
    }
}

fn check_against_every_surface(world: &World, cases: usize, random: &mut Random) {
    let mut packet = Vec::new();
    for case in 0..cases {
        let mut ray = Ray::new(3.0 * random.cube(), random.direction());
        ray.t_max = if case % 4 == 0 { 2.0 } else { f64::INFINITY };
        let hit = world.closest(&ray, &mut ());
        let brute = world.surfaces().iter().enumerate().filter_map(|(index, surface)| {
            let hit = surface.closest(&ray, &mut ())?;
            assert!(surface.occludes(&ray, &mut ()));
            Some(Hit { surface: index as u32, ..hit })
        });
        let brute = brute.min_by(|a, b| a.t.total_cmp(&b.t));
        assert_eq!(hit, brute);
        assert_eq!(hit.is_some(), world.occluded(&ray, &mut ()));
        for exempt in 0..world.surfaces().len() as u32 {
            let others = world.surfaces().iter().enumerate();
            let mut others = others.filter(|&(index, _)| index as u32 != exempt);
            let expected = others.any(|(_, surface)| surface.occludes(&ray, &mut ()));
            assert_eq!(world.occluded_before(&ray, exempt, &mut ()), expected);
        }
        packet.push((ray, hit));
        if packet.len() == 1 + case % 20 {
            let (rays, expected): (Vec<_>, Vec<_>) = packet.drain(..).unzip();
            for coherence in [Coherence::Coherent, Coherence::Incoherent] {
                let mut hits = vec![None; rays.len()];
                world.closest_each((&rays, coherence), &mut hits, &mut ());
                assert_eq!(hits, expected);
            }
            check_occluded_each(world, &rays);
        }
    }
}

/// Rays that are traced together, some of which may pass through one surface, against each alone.
fn check_occluded_each(world: &World, rays: &[Ray]) {
    let exempt: Vec<Option<u32>> =
        (0..rays.len()).map(|k| (k % 3 == 0).then_some(k as u32 % 7)).collect();
    let mut occluded = vec![false; rays.len()];
    world.occluded_each(rays, &exempt, (&mut occluded, &mut ()));
    for ((ray, exempt), occluded) in rays.iter().zip(exempt).zip(occluded) {
        let alone = match exempt {
            Some(exempt) => world.occluded_before(ray, exempt, &mut ()),
            None => world.occluded(ray, &mut ()),
        };
        assert_eq!(occluded, alone, "{ray:?} {exempt:?}");
    }
}

/// `world` with its sixth side displaced by a peak on its middle, towards `center`.
fn with_relief(world: &World, center: DVec3, size: f64) -> World {
    let mut surfaces = world.surfaces().to_vec();
    let Surface::Quad(floor) = &surfaces[5] else { unreachable!() };
    let samples = Samples::F32(vec![0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0]);
    let map = HeightMap::new(3, 3, samples, Lattice::Vertex, Wrap::Clamp).expect("valid");
    let [a, b, _, d] = floor.corners();
    let inward = (center - a).dot((b - a).cross(d - a)).signum();
    let displacement = Displacement { scale: size * inward, ..Displacement::default() };
    let options = FaceOptions { displacement, ..FaceOptions::default() };
    let face = ReliefFace::new(floor.corners(), Arc::new(Relief::new(map)), options);
    surfaces[5] = face.expect("valid").into();
    World::new(surfaces)
}

#[test]
fn a_relief_joins_its_flat_neighbours() {
    let mut random = Random(107);
    for (center, size, world) in boxes() {
        let closed = with_relief(&world, center, size);
        for _ in 0..20_000 {
            // The flat box has the targets: its sixth side ends on the same edges.
            let origin = center + 0.4 * size * random.cube();
            let ray = Ray::new(origin, target(&world, &mut random) - origin);
            let hit = closed.closest(&ray, &mut ()).expect("escaped");
            let shadow = hit.spawn_to(center + 100.0 * size * random.direction());
            let inwards = shadow.from.expect("spawned").front == hit.front;
            if hit.surface == 5 && inwards {
                assert!(closed.occluded(&shadow, &mut ()), "leak: {shadow:?}");
            }
        }
    }
}

#[test]
fn a_relief_among_few_surfaces_is_as_among_many() {
    let mut random = Random(109);
    for (center, size, world) in boxes() {
        let all = with_relief(&world, center, size);
        for index in [5, 4, 2] {
            // The last surfaces, the relief at their end; then as many again, far away, so that
            // the world has a tree.
            let few = all.surfaces()[index..].to_vec();
            let distant = DVec3::splat(1e9);
            let away = (0..4).map(|k| {
                let [u, v] = [DVec3::X, DVec3::Y].map(|axis| size * axis);
                let c = center + distant * f64::from(k + 1);
                quad([c, c + u, c + u + v, c + v])
            });
            let many = World::new(few.iter().cloned().chain(away).collect());
            let few = World::new(few);
            let mut rays = Vec::new();
            for case in 0..3000 {
                let origin = center + 0.9 * size * random.cube();
                let mut ray = Ray::new(origin, target(&world, &mut random) - origin);
                ray.t_max = if case % 3 == 0 { 0.9 + 0.2 * random.unit() } else { 9.0 };
                if let (1, Some(hit)) = (case % 2, few.closest(&ray, &mut ())) {
                    ray = Ray { t_max: 9.0, ..hit.spawn(size * random.direction()) };
                }
                let hit = few.closest(&ray, &mut ());
                assert_eq!(hit, many.closest(&ray, &mut ()));
                assert_eq!(few.occluded(&ray, &mut ()), hit.is_some());
                for exempt in 0..few.surfaces().len() as u32 {
                    let some = many.occluded_before(&ray, exempt, &mut ());
                    assert_eq!(few.occluded_before(&ray, exempt, &mut ()), some);
                }
                rays.push(ray);
            }
            let single: Vec<_> = rays.iter().map(|ray| few.closest(ray, &mut ())).collect();
            for coherence in [Coherence::Coherent, Coherence::Incoherent] {
                let mut hits = vec![None; rays.len()];
                few.closest_each((&rays, coherence), &mut hits, &mut ());
                assert_eq!(hits, single);
            }
            check_occluded_each(&few, &rays);
        }
    }
}

#[test]
fn an_empty_world_and_a_foreign_origin_are_no_trouble() {
    let empty = World::new(Vec::new());
    assert!(empty.bounds().is_empty() && empty.surfaces().is_empty());
    let (_, _, world) = boxes().swap_remove(0);
    let mut ray = world.closest(&Ray::new(DVec3::ZERO, DVec3::X), &mut ()).expect("hit");
    ray.surface = 999;
    assert_eq!(empty.closest(&ray.spawn(DVec3::X), &mut ()), None);
    assert!(world.closest(&ray.spawn(-DVec3::X), &mut ()).is_some());
}
