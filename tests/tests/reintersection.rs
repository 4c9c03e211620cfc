//! A ray that leaves the surface does not meet its own start, and does not slip through.
//!
//! The judge starts exactly on the surface with the root at t = 0 divided out. As everywhere, an
//! answer may differ from the judge's only if a nudge of the direction turns the judge's into it.
//!
//! One more difference is allowed, counted and bounded: a method lifts the start along the
//! displacement by 2^-18 of the largest height. A ray that dips less than that below the surface
//! and comes out again touches it for the judge alone. Then the answer must be the judge's for the
//! lifted start.

use std::io::Write;

use glam::DVec3;
use rayon::prelude::*;
use rilievo::map::{Lattice, Wrap};
use rilievo::relief::{Method, ReliefFace};
use rilievo::{Hit, Ray};
use rilievo_tests::conformance::{Sides, difference, excused};
use rilievo_tests::kernel;
use rilievo_tests::maps::Shape;
use rilievo_tests::nudge::nudged;
use rilievo_tests::oracle::{Oracle, OracleHit, Placement, Start};
use rilievo_tests::random::Random;
use rilievo_tests::rays::Family;
use rilievo_tests::scenes::{FAR, Scene, unit_face};

/// A spawned ray, the method's answer and the judge's.
type Example = (Ray, Option<Hit>, Option<OracleHit>);

/// What became of the rays spawned from one hit.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    rays: u64,
    again: u64,
    excused: u64,
    /// Dips shallower than the lift.
    dips: u64,
    /// Hits next to the start that the judge does not see.
    self_hits: u64,
    /// Other differences from the judge.
    wrong: u64,
    example: Option<Example>,
}

impl Tally {
    fn merge(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            again: self.again + other.again,
            excused: self.excused + other.excused,
            dips: self.dips + other.dips,
            self_hits: self.self_hits + other.self_hits,
            wrong: self.wrong + other.wrong,
            example: self.example.or(other.example),
        }
    }
}

/// Whether the judge, lifted as a method lifts its start, goes on to `answer`: to the miss, or to
/// a crossing of the ray that is not lifted which lies where the lifted ray's is, but for the
/// lift's own shift along a grazing surface.
fn is_a_dip(oracle: &Oracle<'_>, ray: &Ray, start: &Start, answer: &Option<Hit>) -> bool {
    let (low, high) = oracle.map().raw_range();
    let raw = f64::from(low.abs().max(high.abs())) * 2.0f64.powi(-18);
    let lift = raw * oracle.map().unit() * oracle.placement().scale.abs();
    let side = if ray.from.is_some_and(|from| from.front) { lift } else { -lift };
    let origin = oracle.start_point(start) + side * oracle.normal();
    let lifted = Ray { origin, from: None, ..*ray };
    if excused(oracle, &lifted, answer, Sides::Same) {
        return true;
    }
    let (Some(hit), Some(next)) = (answer, oracle.closest(&lifted)) else {
        return false;
    };
    let late = Ray { origin: ray.at(hit.t * 0.9999), from: None, ..*ray };
    let crossed = difference(oracle, answer, &oracle.closest(&late), Sides::Same).is_none();
    crossed && next.position.distance(hit.position) <= 1e-3 * oracle.size()
}

fn spawn_from(hit: &Hit, face: &ReliefFace, oracle: &Oracle<'_>, random: &mut Random) -> Tally {
    const SPAWNED: u64 = 1000;
    let start = oracle.start(hit.part, hit.position);
    let mut tally = Tally { rays: SPAWNED, ..Tally::default() };
    for _ in 0..SPAWNED {
        let direction = random.direction();
        let ray = hit.spawn(direction);
        let answer = face.closest(&ray, &mut ());
        tally.again += u64::from(answer.is_some());
        let judge = oracle.closest_from(&start, direction);
        if difference(oracle, &answer, &judge, Sides::Same).is_none() {
            continue;
        }
        let same = |d: DVec3| {
            difference(oracle, &answer, &oracle.closest_from(&start, d), Sides::Same).is_none()
        };
        let towards = answer.map(|hit| hit.position - oracle.start_point(&start));
        if nudged(direction, towards, oracle.normal()).any(same) {
            tally.excused += 1;
        } else if is_a_dip(oracle, &ray, &start, &answer) {
            tally.dips += 1;
        } else if answer.is_some_and(|hit| hit.t < 1e-4 * oracle.size()) {
            tally.self_hits += 1;
            tally.example = Some((ray, answer, judge));
        } else {
            tally.wrong += 1;
            tally.example = Some((ray, answer, judge));
        }
    }
    tally
}

fn scenes() -> Vec<Scene> {
    let skewed = Placement {
        zero: 0.4,
        tile: [1.7, 1.2],
        closed: true,
        ..Placement::new(FAR, DVec3::new(1.3, 0.2, 0.1), DVec3::new(0.5, 0.9, -0.2), 0.3)
    };
    let (vertex, texel) = (Lattice::Vertex, Lattice::Texel);
    let steep = Placement { closed: true, ..unit_face(2.0) };
    vec![
        Scene::new("fbm", Shape::Fbm(1).codes([128, 128], texel, Wrap::Repeat), unit_face(0.1)),
        Scene::new("studs", Shape::Studs(4).codes([64, 64], vertex, Wrap::Clamp), unit_face(0.2)),
        Scene::new("noise", Shape::White(2).floats([40, 30], vertex, Wrap::Repeat), skewed),
        Scene::new("ripple", Shape::Ripple.floats([60, 60], vertex, Wrap::Mirror), steep),
        Scene::new("flat", Shape::Flat(0.3).codes([8, 8], texel, Wrap::Clamp), unit_face(1.0)),
    ]
}

fn reintersect(method: Method, hits: u64) {
    let mut failures = Vec::new();
    for scene in scenes() {
        let (oracle, face) = (scene.oracle(), kernel::face(&scene, method));
        let total = (0..hits)
            .into_par_iter()
            .map(|k| {
                let mut random = Random::new(&[31, k]);
                let hit = loop {
                    let family = if k % 4 == 0 { Family::Behind } else { Family::Primary };
                    let ray = family.ray(&oracle, &mut random);
                    if let Some(hit) = face.closest(&ray, &mut ()) {
                        break hit;
                    }
                };
                spawn_from(&hit, &face, &oracle, &mut random)
            })
            .reduce(Tally::default, Tally::merge);
        let _ = writeln!(std::io::stderr(), "{method} on {}: {total:?}", scene.name);
        if total.self_hits + total.wrong > 0 || total.dips > total.rays / 2000 {
            failures.push(format!("{method} on {}: {total:?}", scene.name));
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn a_thousand_hits_of_pyramid_spawn_a_thousand_rays_each() {
    reintersect(Method::Pyramid, 1000);
}

#[test]
fn every_exact_method_leaves_its_surface() {
    for method in [Method::Dda, Method::Distance, Method::DistanceCorrected] {
        reintersect(method, 50);
    }
}
