//! Hits of whole worlds: quads, balls, meshes, reliefs and instances of all, under one tree, beside those of the
//! CPU. Without an adapter nothing is tried, and stderr says so.

use std::io::Write;
use std::sync::Arc;

use rilievo::glam::{DAffine3, DQuat, DVec3};
use rilievo::map::{Layout, RowMut};
use rilievo::relief::{Displacement, MeshOptions, Method, Relief, ReliefMesh};
use rilievo::surface::{Instance, Motion, MovingInstance, Quad, Sphere, Surface, World};
use rilievo::{Hit, Part, Ray, SimdLevel};
use rilievo_gpu::{Gpu, GpuWorld, MapEdit};
use rilievo_render::ShadowRay;
use rilievo_tests::kernel;
use rilievo_tests::meshes::Base;
use rilievo_tests::nudge::nudged;
use rilievo_tests::random::Random;
use rilievo_tests::rays::Family;
use rilievo_tests::scenes;
use rilievo_tests::sphere;

/// Largest distance between two answers that count as one, for worlds of size 10.
const TOLERANCE: f64 = 1e-7;

/// The same on a displaced mesh of size 3, whose leaf has derivatives in floats: 1e-5 of that.
const MESH_TOLERANCE: f64 = 3e-5;

fn gpu() -> Option<Gpu> {
    Gpu::open()
        .map_err(|error| writeln!(std::io::stderr(), "SKIPPED, no world was traced: {error}"))
        .ok()
}

fn quad(random: &mut Random, shear: f64, one_sided: bool) -> Surface {
    let [corner, u, v] = [3.0, 1.5, 1.5].map(|size| size * random.direction());
    let corners = [corner, corner + u, corner + u + (1.0 + shear) * v, corner + v];
    Quad::new(corners, one_sided).unwrap().into()
}

/// Everything the shaders know, at random places, instances of it, and all of it in motion.
fn world(random: &mut Random) -> World {
    let relief = kernel::face(&scenes::named("fbm 64"), Method::Pyramid);
    let pebble = &sphere::scenes()[1];
    let pebble = pebble.sphere(Method::Pyramid, Layout::Default, SimdLevel::detect());
    let map = kernel::relief(&scenes::named("fbm 64"), Method::Pyramid, Layout::Default);
    let displacement = Displacement { scale: 0.2, zero: 0.5, ..Displacement::default() };
    let options = MeshOptions { displacement, ..MeshOptions::default() };
    let ring = ReliefMesh::new(&Base::Torus(12, 8).mesh(), map, options).unwrap();
    let mut all = vec![
        quad(random, 0.0, false),
        quad(random, 0.0, true),
        quad(random, 0.7, false),
        Sphere::new(2.0 * random.direction(), 0.8).unwrap().into(),
        Base::Torus(24, 12).mesh().into(),
        relief.into(),
        pebble.into(),
        ring.into(),
    ];
    for k in 0..16 {
        let turn = DQuat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
        let scale = DVec3::new(1.0, random.range(0.5, 1.5), random.sign());
        let place =
            DAffine3::from_scale_rotation_translation(scale, turn, 4.0 * random.direction());
        let prototype = Arc::new(all[k % 8].clone());
        all.push(Instance::new(prototype, place).unwrap().into());
    }
    for k in 0..8 {
        let motion = Motion {
            translation: random.range(0.0, 2.0) * random.direction(),
            pivot: 4.0 * random.direction(),
            axis: random.direction(),
            angle: random.range(-9.0, 9.0),
        };
        let place = DAffine3::from_translation(3.0 * random.direction());
        let way = MovingInstance::new(Arc::new(all[8 + k].clone()), place, motion);
        all.push(way.unwrap().into());
    }
    World::new(all)
}

fn same(cpu: &Option<Hit>, gpu: &Option<Hit>) -> bool {
    match (cpu, gpu) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            let on_mesh = matches!(a.part, Part::TriangleCell { .. });
            let tolerance = if on_mesh { MESH_TOLERANCE } else { TOLERANCE };
            a.position.distance(b.position) <= tolerance
                && (a.surface, a.front) == (b.surface, b.front)
                && a.geometric_normal.dot(b.geometric_normal) > 0.999
        }
        _ => false,
    }
}

/// Whether the CPU gives the answer to some ray a nudge away.
fn excused(world: &World, ray: &Ray, answer: &Option<Hit>) -> bool {
    let towards = answer.map(|hit| hit.position - ray.origin);
    nudged(ray.direction, towards, DVec3::Z)
        .any(|direction| same(&world.closest(&Ray { direction, ..*ray }, &mut ()), answer))
}

/// Asks of every ray whether anything is in its way, of every other one with a surface left out; returns how many
/// answers hold for rays a nudge away only.
fn shadows(world: &World, on_gpu: &GpuWorld<'_>, rays: &[Ray]) -> usize {
    let surfaces = world.surfaces().len() as u32;
    let exempt = |k: u32| k.is_multiple_of(2).then_some(k / 2 % surfaces);
    let asked: Vec<ShadowRay> =
        (0..).zip(rays).map(|(k, ray)| ShadowRay { ray: *ray, exempt: exempt(k) }).collect();
    let found = on_gpu.occluded(&asked).unwrap();
    assert!(found.len() == rays.len() && found.contains(&true) && found.contains(&false));
    let other = asked.iter().zip(found).filter(|(shadow, met)| shadow.is_occluded(world) != *met);
    other
        .map(|(shadow, met)| {
            let answers = nudged(shadow.ray.direction, None, DVec3::Z).any(|direction| {
                let ray = Ray { direction, ..shadow.ray };
                ShadowRay { ray, ..*shadow }.is_occluded(world) == met
            });
            assert!(answers, "{shadow:?}: {met}");
        })
        .count()
}

#[test]
fn hits_in_whole_worlds_are_those_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let (mut hits, mut nudges, mut count) = (0, 0, 0);
    for seed in 0..4 {
        let mut random = Random::new(&[7, seed]);
        let world = world(&mut random);
        let on_gpu = GpuWorld::new(&gpu, &world).unwrap();
        let mut rays: Vec<Ray> = (0..1500)
            .map(|_| {
                let [from, to] =
                    [random.range(0.0, 9.0), 3.0].map(|size| size * random.direction());
                let [t_max, time] = [random.range(0.3, 3.0), random.range(0.0, 1.0)];
                Ray { t_max, time, ..Ray::new(from, to - from) }
            })
            .collect();
        let first: Vec<Hit> = rays.iter().filter_map(|ray| world.closest(ray, &mut ())).collect();
        hits += first.len();
        rays.extend(first.iter().map(|hit| hit.spawn(random.direction())));
        count += rays.len();
        nudges += shadows(&world, &on_gpu, &rays);
        for (ray, traced) in rays.iter().zip(on_gpu.closest(&rays).unwrap()) {
            let cpu = world.closest(ray, &mut ());
            if !same(&cpu, &traced.hit) {
                assert!(excused(&world, ray, &traced.hit), "{ray:?}: {cpu:?} {:?}", traced.hit);
                nudges += 1;
            }
        }
    }
    let _ = writeln!(std::io::stderr(), "{count} rays, {hits} spawned, {nudges} excused");
    assert!(hits > 1000 && nudges * 100 < count, "{hits} hits, {nudges} excused");
}

#[test]
fn after_an_edit_hits_are_those_of_a_new_world() {
    let Some(gpu) = gpu() else { return };
    let mut random = Random::new(&[8]);
    let scene = scenes::named("fbm 64");
    let mut relief = kernel::relief(&scene, Method::Pyramid, Layout::Default);
    let face = |relief: &Arc<Relief>| {
        let face = kernel::face(&scene, Method::Pyramid);
        World::new(vec![face.with_relief(Arc::clone(relief)).unwrap().into()])
    };
    let oracle = scene.oracle();
    let rays: Vec<Ray> = (0..600).map(|_| Family::ALL[0].ray(&oracle, &mut random)).collect();
    let first = face(&relief);
    let mut maps = GpuWorld::new(&gpu, &first).unwrap().into_maps();
    drop(first);
    let mut changed = 0;
    for k in 0..4 {
        let rect = [k * 13..k * 13 + 17, 5..40 + k];
        let before: Vec<_> = {
            let world = face(&relief);
            rays.iter().map(|ray| world.closest(ray, &mut ())).collect()
        };
        let mine = Arc::get_mut(&mut relief).expect("no face holds it");
        mine.edit(rect.clone(), |_, row| match row {
            RowMut::U16(row) => row.iter_mut().for_each(|h| *h = (*h / 2).wrapping_add(k as u16)),
            RowMut::F32(row) => row.iter_mut().for_each(|h| *h *= 0.4),
        })
        .unwrap();
        let after = face(&relief);
        let edit = MapEdit { relief: &relief, samples: rect };
        let on_gpu = GpuWorld::edited(&gpu, &after, maps, &[edit]).unwrap();
        let found = on_gpu.closest(&rays).unwrap();
        let fresh = GpuWorld::new(&gpu, &after).unwrap().closest(&rays).unwrap();
        for ((a, b), before) in found.iter().zip(&fresh).zip(&before) {
            assert_eq!(a.hit, b.hit);
            changed += u32::from(a.hit.map(|hit| hit.t) != before.map(|hit| hit.t));
        }
        maps = on_gpu.into_maps();
    }
    assert!(changed > 100, "{changed}");
    // Another map altogether.
    let other = World::new(vec![kernel::face(&scenes::named("spike 80"), Method::Pyramid).into()]);
    let on_gpu = GpuWorld::edited(&gpu, &other, maps, &[]).unwrap();
    let fresh = GpuWorld::new(&gpu, &other).unwrap();
    let hits = |world: &GpuWorld<'_>| -> Vec<_> {
        world.closest(&rays).unwrap().iter().map(|traced| traced.hit).collect()
    };
    assert_eq!(hits(&on_gpu), hits(&fresh));
}

#[test]
fn an_empty_world_is_met_nowhere() {
    let Some(gpu) = gpu() else { return };
    let world = World::new(Vec::new());
    let on_gpu = GpuWorld::new(&gpu, &world).unwrap();
    let found = on_gpu.closest(&[Ray::new(DVec3::ZERO, DVec3::X)]).unwrap();
    assert!(found.len() == 1 && found[0].hit.is_none());
    assert!(on_gpu.closest(&[]).unwrap().is_empty());
}

#[test]
fn what_moves_is_met_where_it_is_at_any_time_and_after_many_turns() {
    let Some(gpu) = gpu() else { return };
    let ball = || Arc::new(Surface::from(Sphere::new(DVec3::new(0.0, 3.0, 0.0), 0.5).unwrap()));
    let spins = |pivot, angle| {
        let motion = Motion { pivot, axis: DVec3::Z, angle, ..Motion::along(DVec3::Z) };
        MovingInstance::new(ball(), DAffine3::IDENTITY, motion).unwrap().into()
    };
    // Far away, too, where the world's middle is.
    for far in [DVec3::ZERO, DVec3::new(1e6, -3e5, 0.0)] {
        let world = World::new(vec![spins(DVec3::ZERO, -6000.0), spins(far, 0.5)]);
        let on_gpu = GpuWorld::new(&gpu, &world).unwrap();
        for time in [0.0, 1e-3, 0.3, 0.5, 0.999, 1.0, 2.0, f64::NAN] {
            let places = world.surfaces().iter().map(|surface| {
                let Surface::Moving(moving) = surface else { panic!("all move") };
                moving.world_from_local(time).transform_point3(DVec3::new(0.0, 3.0, 0.0))
            });
            let rays: Vec<Ray> = places
                .map(|p| Ray { time, ..Ray::new(p + 9.0 * DVec3::Z, DVec3::NEG_Z) })
                .collect();
            for (ray, traced) in rays.iter().zip(on_gpu.closest(&rays).unwrap()) {
                let (cpu, hit) = (world.closest(ray, &mut ()).unwrap(), traced.hit.unwrap());
                assert!(cpu.position.distance(hit.position) < 1e-6, "{ray:?}: {hit:?} {cpu:?}");
                assert_eq!((cpu.surface, cpu.time.to_bits()), (hit.surface, hit.time.to_bits()));
            }
        }
    }
}
