//! Every method against the oracle, and the exact ones against each other in bits.
//!
//! `RILIEVO_RAYS=10000000` runs the acceptance size, `RILIEVO_STEP=7` every seventh scene only; the
//! defaults are for every day.

use std::io::Write;

use rilievo::relief::Method;
use rilievo_tests::conformance::{Plan, TOLERANCE, check};
use rilievo_tests::kernel::{self, DDA, DISTANCE, DISTANCE_CORRECTED, PYRAMID};
use rilievo_tests::random::Random;
use rilievo_tests::rays::Family;
use rilievo_tests::scenes;

#[test]
fn exact_methods_give_the_oracles_answer_and_one_anothers_bits() {
    let plan = Plan::new(scenes::all(), 20_000);
    let report = check(&[DDA, PYRAMID, DISTANCE, DISTANCE_CORRECTED], &plan);
    assert!(report.hits * 5 > report.rays, "too few hits to mean anything: {report}");
}

/// Hits and misses of an approximate method beside the oracle's.
#[derive(Debug, Default)]
struct Tally {
    hits: u32,
    missed: u32,
    far_off: u32,
}

fn approximate(method: Method, words: &str) -> Tally {
    let scene = scenes::named(words);
    let (oracle, face) = (scene.oracle(), kernel::face(&scene, method));
    let mut tally = Tally::default();
    for k in 0..20_000 {
        let ray = Family::Primary.ray(&oracle, &mut Random::new(&[11, k]));
        let (hit, judge) = (face.closest(&ray, &mut ()), oracle.closest(&ray));
        tally.missed += u32::from(hit.is_none() && judge.is_some());
        if let Some(hit) = hit {
            tally.hits += 1;
            let (low, high) = oracle.offsets();
            let at = oracle.parameters(hit.position);
            let beside = at.x < -TOLERANCE || at.y < -TOLERANCE;
            let beyond = at.x > 1.0 + TOLERANCE || at.y > 1.0 + TOLERANCE;
            let gap = (at.z - oracle.surface_offset(hit.uv.x, hit.uv.y)).abs();
            tally.far_off += u32::from(beside || beyond || gap > 0.1 * (high - low));
        }
    }
    let _ = writeln!(std::io::stderr(), "{method} on {}: {tally:?}", scene.name);
    tally
}

#[test]
fn march_reports_points_near_a_smooth_surface() {
    let tally = approximate(Method::March, "gaussian 100 floats");
    assert!(tally.hits > 2000 && tally.far_off == 0, "{tally:?}");
}

#[test]
fn the_published_method_reports_points_near_a_smooth_surface() {
    let tally = approximate(Method::DistancePublished, "gaussian 100 floats");
    assert!(tally.hits > 2000 && tally.far_off < tally.hits / 100, "{tally:?}");
}

#[test]
fn the_published_method_misses_at_studs() {
    let tally = approximate(Method::DistancePublished, "studs 64");
    assert!(tally.hits > 1000 && tally.missed > 0, "{tally:?}");
}
