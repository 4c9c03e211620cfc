//! Displaced spheres: every method and SIMD level gives the same bits, and the judge's answer.

use std::collections::BTreeMap;
use std::io::Write;

use glam::DVec3;
use rayon::prelude::*;
use rilievo::map::{CubeHeights, Lattice, Layout, Tiling, Wrap};
use rilievo::relief::{Displacement, Method, ReliefSphere};
use rilievo::{Hit, Ray, SimdLevel};
use rilievo_tests::conformance::same_bits;
use rilievo_tests::maps::Shape;
use rilievo_tests::nudge::nudged;
use rilievo_tests::random::Random;
use rilievo_tests::sphere::oracle::{SphereHit, SphereOracle, agree};
use rilievo_tests::sphere::{Family, SphereScene, scenes};

/// As many rays as the environment's `RILIEVO_RAYS` says, or `usual`.
fn rays(usual: u64) -> u64 {
    let asked = std::env::var("RILIEVO_RAYS").ok().and_then(|text| text.parse().ok());
    asked.unwrap_or(usual)
}

/// What is wrong with the attributes of a hit.
fn wrong_attributes(scene: &SphereScene, ray: &Ray, hit: &Hit, family: Family) -> Option<String> {
    let size = scene.radius + scene.center.length() + ray.origin.length();
    let off_ray = hit.position.distance(ray.at(hit.t));
    let arm = hit.position - scene.center;
    let offset = scene.displacement.scale * (hit.height - scene.displacement.zero);
    let off_height = (arm.length() - scene.radius - offset).abs();
    let outward = arm.normalize();
    let (longitude, latitude) =
        (std::f64::consts::TAU * hit.uv.x, std::f64::consts::PI * (hit.uv.y - 0.5));
    let named = DVec3::new(
        latitude.cos() * longitude.cos(),
        latitude.cos() * longitude.sin(),
        latitude.sin(),
    );
    let rounding = 1e-13 * size;
    let aimed = matches!(family, Family::Aimed | Family::AimedInside);
    let front = ray.direction.dot(hit.geometric_normal) <= 1e-6 * ray.direction.length();
    let back = ray.direction.dot(hit.geometric_normal) >= -1e-6 * ray.direction.length();
    let unit = |n: DVec3| (n.length() - 1.0).abs() < 1e-12;
    let checks = [
        ("on the ray", off_ray <= hit.position_error + 10.0 * rounding),
        ("bound", hit.position_error >= 0.0 && hit.position_error < 1e-9 * scene.radius + rounding),
        ("height", off_height <= rounding),
        ("uv", named.distance(outward) * scene.radius <= 1e-12 * scene.radius + rounding),
        // A ray through a lattice point may touch it: told as either side.
        ("side", aimed || if hit.front { front } else { back }),
        ("normals", unit(hit.geometric_normal) && unit(hit.shading_normal)),
        ("outward", hit.geometric_normal.dot(outward) > 0.0),
        ("shading side", hit.shading_normal.dot(hit.geometric_normal) > 0.0),
    ];
    checks.iter().find(|(_, right)| !right).map(|(what, _)| format!("{what}: {off_ray:e}"))
}

#[test]
fn methods_agree_bit_for_bit() {
    for (index, scene) in scenes().iter().enumerate() {
        let contenders = scene.contenders();
        (0..rays(20_000)).into_par_iter().for_each(|k| {
            let family = Family::ALL[(k % Family::ALL.len() as u64) as usize];
            let mut random = Random::new(&[51, index as u64, k]);
            let ray = scene.ray(family, &mut random);
            let hit = contenders[0].1.closest(&ray, &mut ());
            for (name, other) in &contenders[1..] {
                let answer = other.closest(&ray, &mut ());
                assert!(
                    same_bits(&hit, &answer),
                    "{}, {name}, {family:?}: {ray:?}\n{hit:?}\n{answer:?}",
                    scene.name
                );
                assert_eq!(other.occludes(&ray, &mut ()), hit.is_some());
            }
            if let Some(hit) = hit {
                let wrong = wrong_attributes(scene, &ray, &hit, family);
                assert!(wrong.is_none(), "{}, {family:?}: {wrong:?} {ray:?} {hit:?}", scene.name);
            }
        });
    }
}

#[test]
fn the_judge_agrees() {
    let mut excuses = BTreeMap::new();
    let mut total = 0u64;
    let mut failures = Vec::new();
    for (index, scene) in scenes().iter().enumerate() {
        let sphere = scene.sphere(Method::Pyramid, Layout::Default, SimdLevel::detect());
        let oracle = scene.oracle();
        let count = rays(4000);
        total += count;
        let found: Vec<_> = (0..count)
            .into_par_iter()
            .filter_map(|k| {
                let family = Family::ALL[(k % Family::ALL.len() as u64) as usize];
                let mut random = Random::new(&[52, index as u64, k]);
                let ray = scene.ray(family, &mut random);
                let hit = sphere.closest(&ray, &mut ());
                if oracle.agrees(&hit, &ray) {
                    return None;
                }
                let excused = oracle.excuses(&hit, &ray);
                let judge = oracle.closest(&ray, -1e-300);
                Some((family, excused, format!("{ray:?}\n{hit:?}\n{judge:?}")))
            })
            .collect();
        for (family, excused, text) in found {
            *excuses.entry(family).or_insert(0u64) += u64::from(excused);
            if !excused {
                failures.push(format!("{}, {family:?}: {text}", scene.name));
            }
        }
    }
    let _ = writeln!(std::io::stderr(), "{total} rays, excused {excuses:?}");
    let count = failures.len();
    assert!(
        failures.is_empty(),
        "{count} of {total} rays: {}",
        failures[..count.min(5)].join("\n")
    );
    // Rays aimed at lattice points from outside often touch them, and nothing else.
    let aimed = excuses.remove(&Family::Aimed).unwrap_or(0);
    let others: u64 = excuses.values().sum();
    assert!(aimed <= total / 200 && others <= total / 10_000, "{aimed} aimed, {excuses:?}");
}

#[test]
fn nothing_escapes_from_inside() {
    for (index, scene) in scenes().iter().enumerate() {
        for method in [Method::Dda, Method::Pyramid] {
            let sphere = scene.sphere(method, Layout::Default, SimdLevel::detect());
            (0..rays(30_000)).into_par_iter().for_each(|k| {
                let mut random = Random::new(&[53, index as u64, k]);
                let family = if k % 2 == 0 { Family::Inside } else { Family::AimedInside };
                let ray = scene.ray(family, &mut random);
                let hit = sphere.closest(&ray, &mut ());
                let Some(hit) = hit else { panic!("{}, {method}: {ray:?} escapes", scene.name) };
                assert!(!hit.front, "{}, {method}: {ray:?} sees the outside", scene.name);
            });
        }
    }
}

/// All crossings along a ray, each found by leaving the one before; whether from outside. A touch
/// of a lattice point, told as a hit from the side that its cell does not show, is none.
fn hits_along(sphere: &ReliefSphere, ray: &Ray) -> Vec<bool> {
    let mut sides = Vec::new();
    let mut next = sphere.closest(ray, &mut ());
    while let Some(hit) = next
        && sides.len() < 10_000
    {
        if hit.front == (ray.direction.dot(hit.geometric_normal) < 0.0) {
            sides.push(hit.front);
        }
        next = sphere.closest(&hit.spawn(ray.direction), &mut ());
    }
    sides
}

#[test]
fn crossings_alternate_and_their_number_is_even() {
    for (index, scene) in scenes().iter().enumerate() {
        let sphere = scene.sphere(Method::Pyramid, Layout::Default, SimdLevel::detect());
        (0..rays(20_000)).into_par_iter().for_each(|k| {
            let mut random = Random::new(&[54, index as u64, k]);
            let family = [Family::Primary, Family::Aimed, Family::Axis][(k % 3) as usize];
            let ray = scene.ray(family, &mut random);
            let sides = hits_along(&sphere, &ray);
            let alternate = sides.iter().enumerate().all(|(n, front)| *front == (n % 2 == 0));
            let even = sides.len().is_multiple_of(2);
            assert!(alternate && even, "{}, {family:?}: {ray:?} {sides:?}", scene.name);
        });
    }
}

/// What the judge says of a ray spawned on the surface, if its start is `lift` radii off it.
fn lifted(oracle: &SphereOracle, scene: &SphereScene, ray: &Ray, lift: f64) -> Option<SphereHit> {
    let outwards = if ray.from.is_some_and(|from| from.front) { lift } else { -lift };
    let origin = ray.origin + outwards * (ray.origin - scene.center);
    oracle.closest(&Ray { origin, from: None, ..*ray }, 0.0)
}

#[test]
fn spawned_rays_leave_their_start_and_do_not_slip_through() {
    const SPAWNED: u64 = 60;
    let (mut total, mut dips, mut nudges) = (0, 0, 0);
    let mut failures = Vec::new();
    for (index, scene) in scenes().iter().enumerate() {
        let sphere = scene.sphere(Method::Pyramid, Layout::Default, SimdLevel::detect());
        let oracle = scene.oracle();
        // About the library's own lift, which far centres make larger.
        let size = 1.0 + scene.center.length() / scene.radius;
        let own = 2e-13 * size;
        let lifts = [0.1, 0.3, 3.0, 10.0].map(|lift| lift * own);
        let found: Vec<_> = (0..rays(60))
            .into_par_iter()
            .flat_map_iter(|k| {
                let mut random = Random::new(&[55, index as u64, k]);
                let family = if k % 3 == 0 { Family::Inside } else { Family::Primary };
                let hit = loop {
                    let ray = scene.ray(family, &mut random);
                    if let Some(hit) = sphere.closest(&ray, &mut ()) {
                        break hit;
                    }
                };
                let spawned = |_| {
                    let ray = hit.spawn(random.direction());
                    let answer = sphere.closest(&ray, &mut ());
                    let near = |judge: &Option<SphereHit>| {
                        agree(&answer, judge, (1e-6 * size).min(1e-2) * scene.radius)
                    };
                    if near(&lifted(&oracle, scene, &ray, own)) {
                        return None;
                    }
                    // A dip shallower than one lift or the other.
                    let dip = lifts.iter().any(|&lift| near(&lifted(&oracle, scene, &ray, lift)));
                    let towards = answer.map(|hit| hit.position - ray.origin);
                    let mut turned = nudged(ray.direction, towards, hit.geometric_normal);
                    let nudge = dip
                        || turned.any(|direction| {
                            let ray = Ray { direction, ..ray };
                            near(&lifted(&oracle, scene, &ray, own))
                        });
                    Some((dip, nudge, format!("{}: {ray:?} {answer:?}", scene.name)))
                };
                (0..SPAWNED).filter_map(spawned).collect::<Vec<_>>()
            })
            .collect();
        total += rays(60) * SPAWNED;
        for (dip, nudge, text) in found {
            dips += u64::from(dip);
            nudges += u64::from(nudge && !dip);
            if !nudge {
                failures.push(text);
            }
        }
    }
    let _ = writeln!(std::io::stderr(), "{total} rays, {dips} dips, {nudges} nudges");
    let count = failures.len();
    assert!(failures.is_empty(), "{count} of {total}: {}", failures[..count.min(5)].join("\n"));
    assert!(dips + nudges <= total / 2000);
}

/// The Moon in metres, 96 cells a face.
fn moon() -> SphereScene {
    let map = Shape::Fbm(5).codes([300, 150], Lattice::Texel, Wrap::Repeat);
    SphereScene {
        name: "moon".to_owned(),
        heights: CubeHeights::resample(&map, Tiling::default()).expect("few cells"),
        center: DVec3::new(3.0e5, -2.0e5, 1.0e5),
        radius: 1_737_400.0,
        displacement: Displacement { scale: 20_000.0, zero: 0.45, ..Displacement::default() },
    }
}

#[test]
fn a_moon_keeps_its_millimetres_from_near_and_from_far() {
    let scene = moon();
    assert_eq!(scene.heights.cells(), 96);
    let sphere = scene.sphere(Method::Pyramid, Layout::Default, SimdLevel::detect());
    let oracle = scene.oracle();
    (0..rays(3000)).into_par_iter().for_each(|k| {
        let mut random = Random::new(&[56, k]);
        let up = random.direction();
        let above = Ray::new(scene.center + 2e6 * up, -up);
        let ground = sphere.closest(&above, &mut ()).expect("a ray to the centre").position;
        // From 10 m above the ground to a point 3 m beside the one below.
        let near = ground + 10.0 * up;
        let mut last = None;
        for step in 0..8 {
            let aim = ground + (3.0 + 0.01 * f64::from(step)) * up.any_orthonormal_vector();
            let direct = Ray::new(near, aim - near);
            let hit = sphere.closest(&direct, &mut ()).expect("the ground");
            let judge = oracle.closest(&direct, 0.0).expect("the ground");
            let off = hit.position.distance(judge.position);
            assert!(off < 2e-5, "{off} m from the judge's: {direct:?}");
            assert!(hit.position.distance(direct.at(hit.t)) < 1e-8);
            // Neighbours a centimetre apart, to a hundredth of a millimetre: no jitter.
            if let Some(last) = last.replace(hit.position) {
                let step = hit.position.distance(last);
                assert!((0.005..0.05).contains(&step), "{step}");
            }
            // The same point from 10 000 km away, if the way is free.
            let distant = hit.position + 1e7 * (up + 0.1 * random.direction()).normalize();
            let ray = Ray::new(distant, hit.position - distant);
            let again = sphere.closest(&ray, &mut ()).expect("the ground");
            let free = sphere.closest(&hit.spawn(distant - hit.position), &mut ()).is_none();
            assert!(!free || again.position.distance(hit.position) < 1e-6);
            assert!(!sphere.occludes(&Ray::between(near, hit.position + 1e-6 * up), &mut ()));
        }
    });
}
