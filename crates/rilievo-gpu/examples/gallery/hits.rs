//! First hits through the centres of pixels.

use std::fmt;
use std::io::Write;

use rayon::prelude::*;
use rilievo::surface::World;
use rilievo::{Hit, Ray};
use rilievo_gpu::GpuWorld;
use rilievo_render::Scene;
use rilievo_tests::world_oracle::WorldOracle;

/// Largest distance between two points that count as one, in sizes of the surface hit.
const TOLERANCE: f64 = 1e-5;

/// Largest sine of the angle between two normals that count as one.
const NORMAL_TOLERANCE: f64 = 1e-3;

pub const HEAD: &str = "\
| scene | rays that hit | surface is not the CPU's | cell is not | normal is not | farthest from the CPU's | median | \
farthest from the judge's | median | excused | missed | false |
| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |";

/// How the hits of a GPU compare. Distances are in sizes of the surface hit, the diagonal of its box.
#[derive(Debug, Default)]
pub struct Comparison {
    rays: usize,
    hits: usize,
    other_surface: usize,
    other_part: usize,
    other_normal: usize,
    from_cpu: Vec<f64>,
    from_judge: Vec<f64>,
    /// Answers that are the judge's for a ray a nudge away only.
    excused: usize,
    missed: usize,
    invented: usize,
}

/// What the judge says of an answer.
enum Verdict {
    /// It is the judge's, so far from it; nothing is met.
    Apart(Option<f64>),
    Excused,
    Missed,
    False,
}

impl Comparison {
    /// Traces a ray through the centre of each pixel.
    pub fn new(scene: &Scene, on_gpu: &GpuWorld<'_>) -> Result<Self, String> {
        let (world, camera) = (scene.world(), scene.camera());
        let [width, height] = camera.resolution();
        let centre = |k: u32| f64::from(k) + 0.5;
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        let rays: Vec<Ray> = pixels.map(|[x, y]| camera.ray(centre(x), centre(y))).collect();
        let found = on_gpu.closest(&rays).map_err(|error| error.to_string())?;
        let judge = WorldOracle::new(world)?;
        let verdicts: Vec<Verdict> = (rays.par_iter().zip(&found))
            .map(|(ray, traced)| verdict(world, &judge, ray, &traced.hit))
            .collect();
        let mut all = Self { rays: rays.len(), ..Self::default() };
        for ((ray, traced), verdict) in rays.iter().zip(&found).zip(verdicts) {
            let cpu = world.closest(ray, &mut ());
            if let (Some(a), Some(b)) = (cpu, traced.hit) {
                all.compare(world, &a, &b);
            }
            match verdict {
                Verdict::Apart(apart) => all.from_judge.extend(apart),
                Verdict::Excused => all.excused += 1,
                Verdict::Missed => all.missed += 1,
                Verdict::False => all.invented += 1,
            }
            if let Verdict::Missed | Verdict::False = verdict {
                let (hit, judge) = (traced.hit, judge.closest(ray));
                let text = format!("WRONG: {ray:?}\n GPU {hit:?}\n CPU {cpu:?}\n judge {judge:?}");
                let _ = writeln!(std::io::stderr(), "{text}");
            }
        }
        all.from_cpu.sort_by(f64::total_cmp);
        all.from_judge.sort_by(f64::total_cmp);
        Ok(all)
    }

    /// Whether the judge finds nothing wrong.
    pub fn is_right(&self) -> bool {
        self.missed == 0 && self.invented == 0
    }

    fn compare(&mut self, world: &World, cpu: &Hit, gpu: &Hit) {
        self.hits += 1;
        let turned = |a: rilievo::glam::DVec3, b| a.cross(b).length() > NORMAL_TOLERANCE;
        self.other_surface += usize::from(cpu.surface != gpu.surface);
        self.other_part += usize::from(cpu.surface == gpu.surface && cpu.part != gpu.part);
        let other = turned(cpu.geometric_normal, gpu.geometric_normal)
            || turned(cpu.shading_normal, gpu.shading_normal);
        self.other_normal += usize::from(other);
        self.from_cpu.push(cpu.position.distance(gpu.position) / size(world, gpu.surface));
    }
}

/// The diagonal of a surface's box.
fn size(world: &World, surface: u32) -> f64 {
    let bounds = world.surfaces()[surface as usize].bounds();
    (bounds.max - bounds.min).length()
}

fn verdict(world: &World, judge: &WorldOracle<'_>, ray: &Ray, answer: &Option<Hit>) -> Verdict {
    let expected = judge.closest(ray);
    let size = answer.map(|hit| hit.surface).or(expected.map(|hit| hit.surface));
    let size = size.map_or(1.0, |surface| self::size(world, surface));
    match (answer, &expected) {
        (None, None) => return Verdict::Apart(None),
        (Some(hit), Some(expected)) => {
            let apart = hit.position.distance(expected.position) / size;
            if apart <= TOLERANCE {
                return Verdict::Apart(Some(apart));
            }
        }
        _ => {}
    }
    if judge.excuses(answer, ray, TOLERANCE * size) {
        return Verdict::Excused;
    }
    // A hit behind the nearest one has missed that; one before it is of something that is not there.
    match (answer, expected) {
        (Some(hit), Some(expected)) if hit.t > expected.t => Verdict::Missed,
        (Some(_), _) => Verdict::False,
        (None, _) => Verdict::Missed,
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rays, hits, other_surface, other_part, other_normal, .. } = self;
        write!(f, "{hits} of {rays} | {other_surface} | {other_part} | {other_normal}")?;
        for apart in [&self.from_cpu, &self.from_judge] {
            let at = |k: usize| apart.get(k).copied().unwrap_or(0.0);
            let (last, middle) = (apart.len().saturating_sub(1), apart.len() / 2);
            write!(f, " | {} | {}", short(at(last)), short(at(middle)))?;
        }
        write!(f, " | {} | {} | {}", self.excused, self.missed, self.invented)
    }
}

/// A small number in two digits.
pub fn short(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.1e}") }
}
