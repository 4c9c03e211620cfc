//! Any map, placement and ray: the pyramid gives the bits of the walk over every cell, and the
//! oracle's answer but for rays that a nudge turns from one answer to the other.

#![no_main]

use libfuzzer_sys::arbitrary::{self, Arbitrary, Unstructured};
use libfuzzer_sys::fuzz_target;
use rilievo::glam::DVec3;
use rilievo::map::{HeightMap, Lattice, Samples, Wrap};
use rilievo::relief::Method;
use rilievo::{Hit, Ray};
use rilievo_tests::conformance::{Sides, difference, excused, same_bits};
use rilievo_tests::kernel;
use rilievo_tests::oracle::{Oracle, OracleHit, Placement};
use rilievo_tests::scenes::Scene;

/// A whole number of quarters in [-limit, limit]: lattice lines, corners and planes are met often.
fn quarter(u: &mut Unstructured<'_>, limit: i32) -> arbitrary::Result<f64> {
    Ok(f64::from(u.int_in_range(-4 * limit..=4 * limit)?) / 4.0)
}

/// A number in [-limit, limit], on a quarter or anywhere.
fn number(u: &mut Unstructured<'_>, limit: i32) -> arbitrary::Result<f64> {
    if u.ratio(1, 2)? {
        return quarter(u, limit);
    }
    Ok((f64::from(u32::arbitrary(u)?) / f64::from(u32::MAX) * 2.0 - 1.0) * f64::from(limit))
}

fn vector(u: &mut Unstructured<'_>, limit: i32) -> arbitrary::Result<DVec3> {
    Ok(DVec3::new(number(u, limit)?, number(u, limit)?, number(u, limit)?))
}

fn scene_and_ray(u: &mut Unstructured<'_>) -> arbitrary::Result<Option<(Scene, Ray)>> {
    let (width, height) = (u.int_in_range(2..=20u32)?, u.int_in_range(2..=20u32)?);
    let lattice = *u.choose(&[Lattice::Vertex, Lattice::Texel])?;
    let wrap = *u.choose(&[Wrap::Repeat, Wrap::Clamp, Wrap::Mirror])?;
    let codes: Result<Vec<u16>, _> = (0..width * height).map(|_| u16::arbitrary(u)).collect();
    let map = HeightMap::new(width, height, Samples::U16(codes?), lattice, wrap);
    let edges = [vector(u, 2)?, vector(u, 2)?];
    if edges[0].cross(edges[1]).length() < 0.1 {
        return Ok(None);
    }
    let scale = *u.choose(&[0.05, 0.3, -0.3, 2.0])?;
    let mut place = Placement::new(vector(u, 1)?, edges[0], edges[1], scale);
    place.zero = f64::from(u.int_in_range(0..=4u8)?) / 4.0;
    place.tile = [*u.choose(&[1.0, 2.0, 0.6])?, *u.choose(&[1.0, 3.0, 1.7])?];
    place.shift = [quarter(u, 1)?, number(u, 1)?];
    (place.closed, place.one_sided) = (bool::arbitrary(u)?, bool::arbitrary(u)?);
    let ray = Ray::new(vector(u, 3)?, vector(u, 3)?);
    let map = map.expect("a map of at least 2 x 2 codes");
    Ok(ray.is_valid().then(|| (Scene::new("fuzzed", map, place), ray)))
}

/// Whether the judge keeps its answer when the start moves by 1e-7. Fuzzers find rays that start on
/// the surface's border, where both answers are right, as they are for rays inside a flat part.
fn is_settled(oracle: &Oracle<'_>, ray: &Ray, judge: &Option<OracleHit>) -> bool {
    [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]).all(|axis| {
        let moved = oracle.closest(&Ray { origin: ray.origin + 1e-7 * axis, ..*ray });
        match (judge, moved) {
            (None, None) => true,
            (Some(a), Some(b)) => a.position.distance(b.position) <= 1e-3 * oracle.size(),
            _ => false,
        }
    })
}

fuzz_target!(|bytes: &[u8]| {
    let Ok(Some((scene, ray))) = scene_and_ray(&mut Unstructured::new(bytes)) else { return };
    let every_cell = kernel::face(&scene, Method::Dda).closest(&ray, &mut ());
    let pyramid = kernel::face(&scene, Method::Pyramid).closest(&ray, &mut ());
    assert!(same_bits(&every_cell, &pyramid), "{every_cell:?}\n{pyramid:?}");
    let oracle = scene.oracle();
    let judge = oracle.closest(&ray);
    let inside = |hit: &Hit| hit.geometric_normal.dot(ray.direction.normalize()).abs() < 1e-9;
    if pyramid.as_ref().is_some_and(inside) || !is_settled(&oracle, &ray, &judge) {
        return;
    }
    let differs = difference(&oracle, &pyramid, &judge, Sides::Either).is_some();
    let fair = !differs || excused(&oracle, &ray, &pyramid, Sides::Either);
    assert!(fair, "{ray:?}\n{pyramid:?}\n{judge:?}");
});
