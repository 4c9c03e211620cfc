//! Hits of the GPU beside those of the CPU, on the scenes and rays of the conformance suite.
//!
//! Where both differ, the rule of the nudge decides: the oracle must give the GPU's answer to some ray
//! turned by at most 2e-6 radian. Without an adapter nothing is tried, and stderr says so.
//! `RILIEVO_RAYS` sets the rays a scene, `RILIEVO_STEP` = n takes every n-th scene only.

use std::io::Write;

use rilievo::relief::{Method, ReliefFace};
use rilievo::surface::{Surface, World};
use rilievo::{Hit, Ray};
use rilievo_gpu::{Gpu, GpuWorld};
use rilievo_tests::conformance::{Plan, Sides, TOLERANCE, difference, excused, names_its_point};
use rilievo_tests::kernel;
use rilievo_tests::nudge::nudged;
use rilievo_tests::oracle::Oracle;
use rilievo_tests::random::Random;
use rilievo_tests::rays::Family;
use rilievo_tests::scenes;

/// The system's GPU; none, said on stderr, if there is none.
fn gpu() -> Option<Gpu> {
    match Gpu::open() {
        Ok(gpu) => {
            let _ = writeln!(std::io::stderr(), "GPU: {}", gpu.name());
            Some(gpu)
        }
        Err(error) => {
            let _ = writeln!(std::io::stderr(), "SKIPPED, nothing was tried on a GPU: {error}");
            None
        }
    }
}

/// How the answers of both compare.
#[derive(Debug, Default)]
struct Tally {
    rays: u64,
    hits: u64,
    /// Same part of the surface, same side.
    same_part: u64,
    /// Largest distance between the two points, in sizes of the face.
    farthest: f64,
    excused: u64,
    /// Spawned rays that one of both stops at the very start.
    creases: u64,
    /// Steps of the GPU.
    steps: u64,
    faults: Vec<String>,
}

impl Tally {
    /// Whether two answers are the same to the tolerance.
    fn agrees(&mut self, cpu: &Option<Hit>, gpu: &Option<Hit>, size: f64, sides: Sides) -> bool {
        self.rays += 1;
        self.hits += u64::from(gpu.is_some());
        match (cpu, gpu) {
            (None, None) => true,
            (Some(a), Some(b)) => {
                let apart = a.position.distance(b.position) / size;
                let near = apart <= TOLERANCE && (sides == Sides::Either || a.front == b.front);
                if near {
                    self.farthest = self.farthest.max(apart);
                    self.same_part += u64::from(a.part == b.part);
                }
                near
            }
            _ => false,
        }
    }

    fn fault(&mut self, what: String) {
        if self.faults.len() < 20 {
            let _ = writeln!(std::io::stderr(), "FAULT {what}");
        }
        self.faults.push(what);
    }
}

/// Rays of all families at a scene.
fn family_rays(plan: &Plan, oracle: &Oracle<'_>, index: u64) -> Vec<(Family, Ray)> {
    let family = |k: u64| Family::ALL[(k % Family::ALL.len() as u64) as usize];
    let ray = |k| (family(k), family(k).ray(oracle, &mut Random::new(&[plan.seed, index, k])));
    (0..plan.rays).map(ray).collect()
}

#[test]
fn hits_on_displaced_faces_are_those_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let plan = Plan::new(scenes::all(), 240);
    let mut tally = Tally::default();
    for (index, scene) in (0..).zip(&plan.scenes) {
        let oracle = scene.oracle();
        let face = kernel::face(scene, Method::Pyramid);
        let world = World::new(vec![Surface::from(face.clone())]);
        let on_gpu = GpuWorld::new(&gpu, &world).expect("a face can be traced");
        let rays = family_rays(&plan, &oracle, index);
        let plain: Vec<Ray> = rays.iter().map(|(_, ray)| *ray).collect();
        let found = on_gpu.closest(&plain).expect("traced");
        let mut spawned = Vec::new();
        let mut random = Random::new(&[plan.seed, index, u64::MAX]);
        for ((family, ray), traced) in rays.iter().zip(&found) {
            let cpu = face.closest(ray, &mut ());
            tally.steps += traced.work;
            let sides = if *family == Family::Border { Sides::Either } else { Sides::Same };
            if !tally.agrees(&cpu, &traced.hit, oracle.size(), sides) {
                if excused(&oracle, ray, &traced.hit, sides)
                    || difference(&oracle, &traced.hit, &oracle.closest(ray), sides).is_none()
                {
                    tally.excused += 1;
                } else {
                    let name = &scene.name;
                    tally.fault(format!("{name}, {family:?} {ray:?}: {cpu:?} {:?}", traced.hit));
                }
            }
            let named = traced.hit.is_none_or(|hit| names_its_point(&oracle, ray, &hit));
            if !named {
                let hit = traced.hit;
                tally.fault(format!("{}, {family:?} {ray:?}: {hit:?} names another", scene.name));
            }
            spawned.extend(cpu.map(|hit| hit.spawn(random.direction())));
        }
        let found = on_gpu.closest(&spawned).expect("traced");
        for (ray, traced) in spawned.iter().zip(&found) {
            let cpu = face.closest(ray, &mut ());
            if !tally.agrees(&cpu, &traced.hit, oracle.size(), Sides::Same) {
                if starts_on_a_crease(&cpu, &traced.hit, ray, &oracle) {
                    tally.creases += 1;
                } else if nudged_on_the_cpu(&face, ray, &traced.hit, &oracle) {
                    tally.excused += 1;
                } else {
                    let name = &scene.name;
                    tally.fault(format!("{name}, spawned {ray:?}: {cpu:?} {:?}", traced.hit));
                }
            }
        }
    }
    let _ = writeln!(
        std::io::stderr(),
        "{} rays in {} scenes, {} hits, {} in the CPU's part, {:.1e} of the size apart at most, \
         {} excused, {} start on a crease, {} faults, {:.1} steps a ray",
        tally.rays,
        plan.scenes.len(),
        tally.hits,
        tally.same_part,
        tally.farthest,
        tally.excused,
        tally.creases,
        tally.faults.len(),
        tally.steps as f64 / tally.rays as f64,
    );
    assert!(tally.faults.is_empty(), "{} faults", tally.faults.len());
    assert!(tally.hits * 5 > tally.rays, "too few hits to mean anything");
}

/// Whether one of two answers is the start of a spawned ray, to rounding. A ray that leaves a crease into
/// the solid is stopped there or let go, as the last bits of its start say.
fn starts_on_a_crease(
    cpu: &Option<Hit>,
    gpu: &Option<Hit>,
    ray: &Ray,
    oracle: &Oracle<'_>,
) -> bool {
    let near = |hit: &Option<Hit>| {
        hit.is_some_and(|hit| hit.position.distance(ray.origin) <= 1e-9 * oracle.size())
    };
    near(cpu) || near(gpu)
}

/// Whether the CPU gives an answer to some ray a nudge away.
fn nudged_on_the_cpu(
    face: &ReliefFace,
    ray: &Ray,
    answer: &Option<Hit>,
    oracle: &Oracle<'_>,
) -> bool {
    let towards = answer.map(|hit| hit.position - ray.origin);
    let mut tally = Tally::default();
    nudged(ray.direction, towards, oracle.normal()).any(|direction| {
        let cpu = face.closest(&Ray { direction, ..*ray }, &mut ());
        tally.agrees(&cpu, answer, oracle.size(), Sides::Same)
    })
}
