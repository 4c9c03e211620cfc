//! One suite for everything that meets rays with a relief.
//!
//! A method joins with one [`Entry`]. For every scene and ray the first entry is compared with
//! the oracle, and every other entry with the first, bit by bit. A first entry that differs from
//! the oracle fails unless the rule of the nudge ([`crate::nudge`]) excuses it; excuses are
//! counted and printed.

mod report;

use std::io::Write;

use rayon::prelude::*;
use rilievo::{Hit, Part, Ray};

use crate::nudge::nudged;
use crate::oracle::{Oracle, OracleHit};
use crate::random::Random;
use crate::rays::Family;
use crate::scenes::Scene;

pub use report::{Disagreement, Kind, Report};

/// Largest distance of a hit from the oracle's, in sizes of the face.
pub const TOLERANCE: f64 = 1e-5;

/// Something that meets rays with the relief of one scene.
pub trait Contender: Sync {
    /// The nearest hit.
    fn closest(&self, ray: &Ray) -> Option<Hit>;

    /// Whether there is any hit.
    fn occludes(&self, ray: &Ray) -> bool {
        self.closest(ray).is_some()
    }
}

/// A contender for every scene, by name.
pub struct Entry {
    /// What reports call it.
    pub name: &'static str,
    /// Makes the contender of a scene.
    pub build: fn(&Scene) -> Box<dyn Contender + '_>,
}

/// What is tried.
pub struct Plan {
    /// The scenes.
    pub scenes: Vec<Scene>,
    /// Rays for each scene, spread over all families.
    pub rays: u64,
    /// Names the stream of random numbers.
    pub seed: u64,
}

impl Plan {
    /// These scenes with `rays` rays each, or as many as the environment's `RILIEVO_RAYS` says;
    /// with `RILIEVO_STEP` = n only every n-th scene, for long runs.
    pub fn new(scenes: Vec<Scene>, rays: u64) -> Self {
        let asked = |name: &str| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
        let step = asked("RILIEVO_STEP").map_or(1, |n| n.max(1) as usize);
        let scenes = scenes.into_iter().step_by(step).collect();
        Self { scenes, rays: asked("RILIEVO_RAYS").unwrap_or(rays), seed: 1 }
    }
}

/// Tries `entries` on every scene of `plan`; one line a scene goes to stderr.
///
/// # Panics
/// If anything disagrees without excuse; the message holds the first examples of every scene.
pub fn check(entries: &[Entry], plan: &Plan) -> Report {
    let mut total = Report::new("all scenes");
    let mut failures = String::new();
    for (index, scene) in plan.scenes.iter().enumerate() {
        let report = check_scene(entries, scene, plan, index as u64);
        // A failed write of a progress line must not fail the suite.
        let _ = writeln!(std::io::stderr(), "{report}");
        if report.failed() {
            let details = report.details();
            let _ = writeln!(std::io::stderr(), "{details}");
            failures += &details;
        }
        total = total.merge(report);
    }
    let _ = writeln!(std::io::stderr(), "{}", total.details());
    assert!(failures.is_empty(), "{total}\n{failures}");
    total
}

/// Tries `entries` on one scene, numbered `index`.
pub fn check_scene(entries: &[Entry], scene: &Scene, plan: &Plan, index: u64) -> Report {
    const BATCH: u64 = 1024;
    let oracle = scene.oracle();
    let contenders: Vec<_> =
        entries.iter().map(|entry| (entry.name, (entry.build)(scene))).collect();
    (0..plan.rays.div_ceil(BATCH))
        .into_par_iter()
        .map(|batch| {
            let mut report = Report::new(&scene.name);
            for k in batch * BATCH..plan.rays.min((batch + 1) * BATCH) {
                let family = Family::ALL[(k % Family::ALL.len() as u64) as usize];
                let mut random = Random::new(&[plan.seed, index, k]);
                let ray = family.ray(&oracle, &mut random);
                check_ray(&contenders, &oracle, &ray, family, &mut report);
            }
            report
        })
        .reduce(|| Report::new(&scene.name), Report::merge)
}

fn check_ray(
    contenders: &[(&'static str, Box<dyn Contender + '_>)],
    oracle: &Oracle<'_>,
    ray: &Ray,
    family: Family,
    report: &mut Report,
) {
    let Some(((first, contender), others)) = contenders.split_first() else {
        return;
    };
    let hit = contender.closest(ray);
    report.rays += 1;
    report.hits += u64::from(hit.is_some());
    let found = |kind, who, answer: Option<Hit>, judge: Option<OracleHit>| Disagreement {
        kind,
        who,
        family,
        ray: *ray,
        answer,
        judge,
    };
    if contender.occludes(ray) != hit.is_some() {
        report.push(found(Kind::Occlusion, first, hit, None));
    }
    for (name, other) in others {
        let answer = other.closest(ray);
        if !same_bits(&hit, &answer) {
            report.push(found(Kind::Bits, name, answer, oracle.closest(ray)));
        }
        if other.occludes(ray) != answer.is_some() {
            report.push(found(Kind::Occlusion, name, answer, None));
        }
    }
    let judge = oracle.closest(ray);
    // On the very border a touch from outside may be told as either side.
    let sides = if family == Family::Border { Sides::Either } else { Sides::Same };
    if let Some(kind) = difference(oracle, &hit, &judge, sides) {
        if excused(oracle, ray, &hit, sides) {
            *report.excuses.entry((family, kind)).or_default() += 1;
        } else {
            report.push(found(kind, first, hit, judge));
        }
    }
    if hit.is_some_and(|hit| !names_its_point(oracle, ray, &hit)) {
        report.push(found(Kind::Attributes, first, hit, judge));
    }
}

/// Whether two answers are the same to the last bit of t, and in their part.
pub fn same_bits(a: &Option<Hit>, b: &Option<Hit>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => {
            a.t.to_bits() == b.t.to_bits() && a.part == b.part && a.front == b.front
        }
        _ => false,
    }
}

/// Whether an answer must name the judge's side of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// It must.
    Same,
    /// The point is enough.
    Either,
}

/// How an answer differs from the judge's, if it does.
pub fn difference(
    oracle: &Oracle<'_>,
    answer: &Option<Hit>,
    judge: &Option<OracleHit>,
    sides: Sides,
) -> Option<Kind> {
    match (answer, judge) {
        (None, None) => None,
        (None, Some(_)) => Some(Kind::Missed),
        (Some(_), None) => Some(Kind::False),
        (Some(hit), Some(judge)) => {
            let near = hit.position.distance(judge.position) <= TOLERANCE * oracle.size();
            if !near {
                Some(Kind::Misplaced)
            } else if sides == Sides::Same && hit.front != judge.front {
                Some(Kind::Side)
            } else {
                None
            }
        }
    }
}

/// Whether the oracle gives `answer` to some ray a nudge away.
pub fn excused(oracle: &Oracle<'_>, ray: &Ray, answer: &Option<Hit>, sides: Sides) -> bool {
    let towards = answer.map(|hit| hit.position - ray.origin);
    nudged(ray.direction, towards, oracle.normal()).any(|direction| {
        let judge = oracle.closest(&Ray { direction, ..*ray });
        difference(oracle, answer, &judge, sides).is_none()
    })
}

/// Whether a hit's point lies on the ray, and within its stated error of the surface point that
/// its uv and part name; whether its normal is a unit vector of that part; and whether uv and
/// height belong to the point.
pub fn names_its_point(oracle: &Oracle<'_>, ray: &Ray, hit: &Hit) -> bool {
    let place = oracle.placement();
    let reach = place.corners[0].abs().max_element() + oracle.size() + ray.origin.length();
    let rounding = 1e-13 * reach;
    let on_ray = hit.position.distance(ray.at(hit.t)) <= hit.position_error + 10.0 * rounding;
    let uv = oracle.parameters(hit.position).truncate();
    let right_uv = uv.distance(hit.uv) * oracle.size() <= 2.0 * hit.position_error + rounding
        || uv.distance(hit.uv) <= 1e-9;
    let unit = (hit.geometric_normal.length() - 1.0).abs() <= 1e-9
        && (hit.shading_normal.length() - 1.0).abs() <= 1e-9;
    let small = hit.position_error >= 0.0 && hit.position_error <= TOLERANCE * oracle.size();
    let own = match hit.part {
        Part::Cell(i, j) => {
            let (offset, slope) = oracle.cell_offset(i, j, hit.uv.x, hit.uv.y);
            let point = oracle.point(hit.uv.x, hit.uv.y, offset);
            let height = oracle.map().height_at(
                hit.uv.x * place.tile[0] + place.shift[0],
                hit.uv.y * place.tile[1] + place.shift[1],
            );
            let near_height = place.scale * (hit.height - place.zero) - offset;
            let [c0, c1, _, c3] = place.corners;
            let along_u = c1 - c0 + slope.x * oracle.normal();
            let along_v = c3 - c0 + slope.y * oracle.normal();
            let normal = along_u.cross(along_v).normalize();
            hit.position.distance(point) <= hit.position_error + rounding
                && (near_height.abs() <= 1e-6 * place.scale.abs().max(oracle.size())
                    || (hit.height - height).abs() <= 1e-6)
                && normal.dot(hit.geometric_normal) >= 1.0 - 1e-6
        }
        Part::Wall(_) => hit.geometric_normal.dot(oracle.normal()).abs() <= 1e-9,
        Part::Whole
        | Part::Triangle(_)
        | Part::CubeCell(..)
        | Part::TriangleCell { .. }
        | Part::SeamWall(_) => false,
    };
    on_ray && right_uv && unit && small && own
}

#[cfg(test)]
mod tests;
