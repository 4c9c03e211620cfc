//! [`Pair`]: one world on the CPU and on the GPU, and [`Tally`]: how their answers compare.

use std::io::Write;

use rilievo::glam::DVec3;
use rilievo::surface::World;
use rilievo::{Hit, Ray};
use rilievo_gpu::{Gpu, GpuWorld};
use rilievo_tests::nudge::nudged;
use rilievo_tests::random::Random;

/// Largest distance between two points that count as one, in sizes.
const TOLERANCE: f64 = 1e-5;

/// The system's GPU; none, said on stderr, if there is none.
pub fn gpu() -> Option<Gpu> {
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

/// A whole number from the environment, or `usual`.
pub fn asked(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// How the answers of both compare.
#[derive(Debug, Default)]
pub struct Tally {
    rays: u64,
    hits: u64,
    same_part: u64,
    /// Largest distance between the two points, in sizes.
    farthest: f64,
    excused: u64,
    /// Spawned rays that one of both stops at the very start.
    starts: u64,
    steps: u64,
    faults: u64,
}

/// One surface on both.
pub struct Pair<'a> {
    pub name: String,
    pub world: &'a World,
    pub on_gpu: GpuWorld<'a>,
    pub centre: DVec3,
    pub size: f64,
}

impl Pair<'_> {
    /// How far apart two answers are, in sizes; nothing if they differ.
    fn apart(&self, cpu: &Option<Hit>, gpu: &Option<Hit>) -> Option<f64> {
        match (cpu, gpu) {
            (None, None) => Some(0.0),
            (Some(a), Some(b)) => {
                let apart = a.position.distance(b.position) / self.size;
                (apart <= TOLERANCE && a.front == b.front).then_some(apart)
            }
            _ => None,
        }
    }

    fn excused(&self, ray: &Ray, answer: &Option<Hit>) -> bool {
        let towards = answer.map(|hit| hit.position - ray.origin);
        nudged(ray.direction, towards, ray.origin - self.centre).any(|direction| {
            let cpu = self.world.closest(&Ray { direction, ..*ray }, &mut ());
            self.apart(&cpu, answer).is_some()
        })
    }

    /// Whether one of two answers is the start of a spawned ray, to rounding.
    fn at_start(&self, ray: &Ray, answers: [&Option<Hit>; 2]) -> bool {
        let near = |hit: &Option<Hit>| {
            hit.is_some_and(|hit| hit.position.distance(ray.origin) <= 1e-9 * self.size)
        };
        ray.from.is_some() && answers.into_iter().any(near)
    }

    /// Traces rays on both; returns the CPU's hits.
    fn compare(&self, rays: &[Ray], tally: &mut Tally) -> Vec<Hit> {
        let found = self.on_gpu.closest(rays).expect("traced");
        let mut hits = Vec::new();
        for (ray, traced) in rays.iter().zip(&found) {
            let cpu = self.world.closest(ray, &mut ());
            hits.extend(cpu);
            tally.rays += 1;
            tally.hits += u64::from(traced.hit.is_some());
            tally.steps += traced.work;
            if let (Some(a), Some(b)) = (cpu, traced.hit) {
                tally.same_part += u64::from(a.part == b.part);
            }
            if let Some(apart) = self.apart(&cpu, &traced.hit) {
                tally.farthest = tally.farthest.max(apart);
            } else if self.at_start(ray, [&cpu, &traced.hit]) {
                tally.starts += 1;
            } else if self.excused(ray, &traced.hit) {
                tally.excused += 1;
            } else {
                tally.faults += 1;
                if tally.faults <= 20 {
                    let (name, hit) = (&self.name, traced.hit);
                    let text = format!("FAULT {name}, {ray:?}:\n  CPU {cpu:?}\n  GPU {hit:?}");
                    let _ = writeln!(std::io::stderr(), "{text}");
                }
            }
        }
        hits
    }

    /// The rays, and one spawned from each hit.
    pub fn judge(&self, rays: &[Ray], random: &mut Random, tally: &mut Tally) {
        let hits = self.compare(rays, tally);
        let spawned: Vec<Ray> = hits.iter().map(|hit| hit.spawn(random.direction())).collect();
        self.compare(&spawned, tally);
    }
}

impl Tally {
    pub fn report(&self, what: &str) {
        let Self { rays, hits, same_part, farthest, excused, starts, steps, faults } = self;
        let _ = writeln!(
            std::io::stderr(),
            "{what}: {rays} rays, {hits} hits, {same_part} in the CPU's part, {farthest:.1e} of the size \
             apart at most, {excused} excused, {starts} stopped at their start, {faults} faults, \
             {:.1} steps a ray",
            *steps as f64 / *rays as f64,
        );
        assert_eq!(*faults, 0, "{what}");
        assert!(hits * 5 > *rays && excused * 100 < *rays, "{what}: {self:?}");
    }
}
