//! Every method against the oracle, and the exact ones against each other in bits.
//!
//! `RILIEVO_RAYS=10000000` runs the acceptance size, `RILIEVO_STEP=7` every seventh scene only; the
//! defaults are for every day.

use std::io::Write;

use rilievo::Ray;
use rilievo::relief::Method;
use rilievo_tests::conformance::{Plan, Sides, TOLERANCE, check, difference};
use rilievo_tests::kernel::{self, DDA, DISTANCE, DISTANCE_CORRECTED};
use rilievo_tests::random::Random;
use rilievo_tests::rays::Family;
use rilievo_tests::scenes;

#[test]
fn exact_methods_give_the_oracles_answer_and_one_anothers_bits() {
    let plan = Plan::new(scenes::all(), 20_000);
    let mut entries = vec![DDA, DISTANCE, DISTANCE_CORRECTED];
    entries.extend(kernel::pyramid_everywhere());
    let report = check(&entries, &plan);
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

/// Rays aimed exactly at samples, from behind and from the front, of a face with one side: slivers of
/// neighbouring cells saw a crossing of the wrong sign there, or the only one of the right sign.
#[test]
fn one_sided_faces_are_met_exactly_at_their_samples() {
    let scene = scenes::named("fbm 129 x 65 floats, Texel Clamp, one-sided closed");
    let oracle = scene.oracle();
    let face = kernel::face(&scene, Method::Pyramid);
    for (origin, direction) in [
        (
            [1.1735180484196936, -0.4687699256563838, -0.1460397385096523],
            [-0.2821836164747158, 0.9377171359517018, 0.20263015455698624],
        ),
        (
            [-0.18145903554751452, 1.4212686902534335, -0.8437198481286026],
            [0.6063004482891685, -0.27220682847070055, 0.7471969010497005],
        ),
        (
            [0.39658264365615936, 0.9840929238787615, -0.15287735033573985],
            [0.4330832249053578, -0.5265735722995231, 0.7315457560954708],
        ),
        (
            [0.46487350113736503, 0.9214245143796855, 0.8248927508756227],
            [0.7347955720359539, 0.3997128017506172, -0.5480010432773165],
        ),
    ] {
        let ray = Ray::new(origin.into(), direction.into());
        let answer = face.closest(&ray, &mut ());
        let differs = difference(&oracle, &answer, &oracle.closest(&ray), Sides::Same);
        assert!(differs.is_none(), "{differs:?} for {ray:?}: {answer:?}");
    }
}
