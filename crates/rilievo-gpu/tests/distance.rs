//! Distance maps on a GPU: the exact methods beside the pyramid on the same GPU, bit for bit, and the approximate ones, the
//! paper's own and fixed steps, beside the CPU's. Without an adapter nothing is tried, and stderr says so. `RILIEVO_RAYS` sets the rays a scene,
//! `RILIEVO_STEP` = n takes every n-th of the scenes only.

use std::io::Write;
use std::sync::Arc;

use rilievo::glam::DVec3;
use rilievo::map::{
    DistanceKind, DistanceMap, DistanceOptions, HeightMap, Metric, RowMut, Samples,
};
use rilievo::relief::{Displacement, FaceOptions, Method, Relief, ReliefFace};
use rilievo::surface::{Surface, World};
use rilievo::{Hit, Ray};
use rilievo_gpu::{Gpu, GpuWorld, MapEdit};
use rilievo_render::Traced;
use rilievo_tests::conformance::Plan;
use rilievo_tests::kernel;
use rilievo_tests::nudge::nudged;
use rilievo_tests::random::Random;
use rilievo_tests::rays::Family;
use rilievo_tests::scenes::{self, Scene};

fn gpu() -> Option<Gpu> {
    Gpu::open()
        .map_err(|error| writeln!(std::io::stderr(), "SKIPPED, no distance was walked: {error}"))
        .ok()
}

fn world(scene: &Scene, method: Method) -> World {
    World::new(vec![Surface::from(kernel::face(scene, method))])
}

fn on_gpu(gpu: &Gpu, world: &World, rays: &[Ray]) -> Vec<Traced> {
    GpuWorld::new(gpu, world).expect("a face can be traced").closest(rays).expect("traced")
}

/// Rays of all families at a scene, and rays that leave its surface.
fn rays(plan: &Plan, scene: &Scene, exact: &World, index: u64) -> Vec<Ray> {
    let oracle = scene.oracle();
    let family = |k: u64| Family::ALL[(k % Family::ALL.len() as u64) as usize];
    let ray = |k| family(k).ray(&oracle, &mut Random::new(&[plan.seed, index, k]));
    let mut rays: Vec<Ray> = (0..plan.rays).map(ray).collect();
    let mut random = Random::new(&[plan.seed, index, u64::MAX]);
    let hits: Vec<_> = rays.iter().filter_map(|ray| exact.closest(ray, &mut ())).collect();
    rays.extend(hits.iter().map(|hit| hit.spawn(random.direction())));
    rays
}

fn steps_a_ray(found: &[Traced]) -> f64 {
    found.iter().map(|traced| traced.work).sum::<u64>() as f64 / found.len().max(1) as f64
}

#[test]
fn exact_walks_by_distance_hit_what_the_pyramid_hits_bit_for_bit() {
    let Some(gpu) = gpu() else { return };
    let plan = Plan::new(scenes::all().into_iter().step_by(3).collect(), 72);
    let (mut count, mut hits) = (0, 0);
    for (index, scene) in (0..).zip(&plan.scenes) {
        let exact = world(scene, Method::Pyramid);
        let rays = rays(&plan, scene, &exact, index);
        let want = on_gpu(&gpu, &exact, &rays);
        hits += want.iter().filter(|traced| traced.hit.is_some()).count();
        for method in [Method::Distance, Method::DistanceCorrected] {
            let found = on_gpu(&gpu, &world(scene, method), &rays);
            for ((ray, want), found) in rays.iter().zip(&want).zip(&found) {
                assert_eq!(found.hit, want.hit, "{}, {method}: {ray:?}", scene.name);
            }
            count += rays.len();
        }
    }
    let _ = writeln!(std::io::stderr(), "{count} rays, none differs; {hits} hits a method");
    assert!(hits * 4 > count / 2, "too few hits to mean anything");
}

#[test]
fn steps_do_not_depend_on_the_unit_of_heights() {
    let Some(gpu) = gpu() else { return };
    let scene = scenes::named("fbm 64");
    let oracle = scene.oracle();
    let rays: Vec<Ray> =
        (0..200).map(|k| Family::ALL[0].ray(&oracle, &mut Random::new(&[14, k]))).collect();
    let traced = |unit: f32| {
        let like = kernel::face(&scene, Method::Distance);
        let map = like.relief().heights();
        let heights = map.samples();
        let raw = |at: u32| match heights {
            Samples::U16(codes) => f32::from(codes[at as usize]),
            Samples::F32(all) => all[at as usize],
        };
        let samples = (0..map.width() * map.height()).map(|at| unit * raw(at)).collect();
        let samples = Samples::F32(samples);
        let (lattice, wrap) = (map.x().lattice(), map.x().wrap());
        let map = HeightMap::new(map.width(), map.height(), samples, lattice, wrap).unwrap();
        let scale = f64::from(0.3 / map.raw_range().1);
        let metric = Metric::of_face(&map, [1.0, 1.0], scale);
        let kind = DistanceKind::Boxes;
        let options = DistanceOptions::by_default(&map, kind, metric);
        let distances = DistanceMap::from_height(&map, kind, &options).unwrap();
        let relief = Arc::new(Relief::new(map).with_distance(distances).unwrap());
        let displacement = Displacement { scale, ..like.options().displacement };
        let options = FaceOptions { displacement, ..like.options().clone() };
        let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let face = ReliefFace::new(corners, relief, options).unwrap();
        on_gpu(&gpu, &World::new(vec![face.into()]), &rays)
    };
    let [usual, tiny] = [1.0, 2.0f32.powi(-90)].map(|unit| {
        let found = traced(unit);
        (steps_a_ray(&found), found.iter().filter(|traced| traced.hit.is_some()).count())
    });
    assert!(usual.1 > 50 && usual.1 == tiny.1, "{usual:?} {tiny:?}");
    assert!((usual.0 - tiny.0).abs() < 0.01 * usual.0, "{usual:?} {tiny:?}");
}

#[test]
fn after_an_edit_distances_are_those_of_a_new_world() {
    let Some(gpu) = gpu() else { return };
    let scene = scenes::named("fbm 64");
    let face = kernel::face(&scene, Method::Distance);
    let first = World::new(vec![face.clone().into()]);
    let oracle = scene.oracle();
    let rays: Vec<Ray> =
        (0..300).map(|k| Family::ALL[0].ray(&oracle, &mut Random::new(&[13, k]))).collect();
    let before = on_gpu(&gpu, &first, &rays);
    let maps = GpuWorld::new(&gpu, &first).expect("a face can be traced").into_maps();
    let mut relief = Relief::clone(face.relief());
    let options = |map: &DistanceMap| DistanceOptions {
        size: map.size(),
        metric: map.metric(),
        bits: map.codes().bits(),
    };
    let options = options(relief.distance(DistanceKind::Boxes).expect("it is walked"));
    let samples = [8..40, 3..50];
    let halve = |_: u32, row: RowMut<'_>| match row {
        RowMut::U16(row) => row.iter_mut().for_each(|h| *h /= 2),
        RowMut::F32(row) => row.iter_mut().for_each(|h| *h *= 0.5),
    };
    relief.edit(samples.clone(), halve).expect("inside");
    let map = gpu.distance_map(relief.heights(), DistanceKind::Boxes, &options).expect("made");
    let relief = Arc::new(relief.with_distance(map).expect("it fits"));
    let after = World::new(vec![face.with_relief(Arc::clone(&relief)).expect("it fits").into()]);
    let edit = MapEdit { relief: &relief, samples };
    let edited = GpuWorld::edited(&gpu, &after, maps, &[edit]).expect("edited");
    let found = edited.closest(&rays).expect("traced");
    assert_eq!(found, on_gpu(&gpu, &after, &rays));
    let changed = before.iter().zip(&found).filter(|(a, b)| a.hit != b.hit).count();
    assert!(changed > 30, "{changed}");
}

/// How an approximate method fares on both.
#[derive(Debug, Default)]
struct Approximate {
    count: u64,
    /// Both answer alike, points up to a share of the distance.
    same: u64,
    /// Of the others, those to which the CPU gives the GPU's answer if they are turned by a nudge.
    nudged: u64,
    /// Missed on the CPU and on the GPU.
    missed: [u64; 2],
    steps: f64,
}

fn approximate(gpu: &Gpu, method: Method, tolerance: f64) -> Approximate {
    let plan = Plan::new(scenes::all().into_iter().step_by(4).collect(), 144);
    let mut tally = Approximate::default();
    for (index, scene) in (0..).zip(&plan.scenes) {
        let exact = world(scene, Method::Pyramid);
        let own = world(scene, method);
        let rays = rays(&plan, scene, &exact, index);
        let normal = scene.oracle().normal();
        let found = on_gpu(gpu, &own, &rays);
        tally.steps += steps_a_ray(&found) * rays.len() as f64;
        for (ray, found) in rays.iter().zip(&found) {
            let cpu = own.closest(ray, &mut ());
            let should = exact.closest(ray, &mut ()).is_some();
            tally.missed[0] += u64::from(should && cpu.is_none());
            tally.missed[1] += u64::from(should && found.hit.is_none());
            let near = |a: f64, b: f64| (a - b).abs() <= tolerance * (1.0 + a.abs());
            let alike = |cpu: Option<Hit>| match (cpu, found.hit) {
                (None, None) => true,
                (Some(a), Some(b)) => near(a.t, b.t) && a.front == b.front,
                _ => false,
            };
            let turned = |direction| own.closest(&Ray { direction, ..*ray }, &mut ());
            let towards = found.hit.map(|hit| hit.position - ray.origin);
            if alike(cpu) {
                tally.same += 1;
            } else if nudged(ray.direction, towards, normal).any(|to| alike(turned(to))) {
                tally.nudged += 1;
            } else {
                let _ =
                    writeln!(std::io::stderr(), "{}: {ray:?} {cpu:?} {:?}", scene.name, found.hit);
            }
            tally.count += 1;
        }
    }
    let Approximate { count, same, nudged, missed: [cpu, gpu], steps } = tally;
    let _ = writeln!(
        std::io::stderr(),
        "{method}, {count} rays: {cpu} missed on the CPU, {gpu} on the GPU, {same} alike, {nudged} by a nudge, {:.1} steps a ray",
        steps / count as f64,
    );
    tally
}

#[test]
fn the_published_method_misses_as_often_as_on_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let Approximate { count, same, missed: [cpu, gpu], .. } =
        approximate(&gpu, Method::DistancePublished, 1e-3);
    assert!(same * 100 >= count * 98, "{same} of {count} alike");
    assert!(cpu.abs_diff(gpu) * 20 <= cpu.max(40), "{cpu} and {gpu} missed");
}

/// A ray that comes in through the border at the very height of the surface there begins above or below it as the last bits of its
/// first point say: one family of rays is aimed at such points.
#[test]
fn fixed_steps_meet_what_they_meet_on_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let Approximate { count, same, nudged, missed: [cpu, gpu], .. } =
        approximate(&gpu, Method::March, 1e-6);
    assert!(same * 100 >= count * 98, "{same} of {count} alike");
    assert!(same + nudged == count, "{} answers are no neighbour's", count - same - nudged);
    assert!(cpu.abs_diff(gpu) * 1000 <= count, "{cpu} and {gpu} missed");
}
