//! Emitters that are drawn by their shapes, against what is met by chance.

use std::f64::consts::{PI, TAU};

use glam::DVec2;
use glam::DVec3;
use rilievo::surface::{Quad, Surface, World};
use rilievo::{Hit, Ray};

use super::fixtures::emitters;
use super::{Drawn, Lighting, Receiver};
use crate::sampler::chi_square::{chi_square_z, independent_points};
use crate::sampler::warp::square_to_hemisphere;
use crate::scene::Material;

/// Places above an emitter, and near one.
const PLACES: [DVec3; 2] = [DVec3::new(0.4, -0.3, 2.5), DVec3::new(0.7, 0.6, 0.75)];

/// A hit on a small tile at `at`, met from the side of `normal`.
fn tile(at: DVec3, normal: DVec3) -> Hit {
    let (u, v) = normal.any_orthonormal_pair();
    let (u, v) = if u.cross(v).dot(normal) > 0.0 { (u, v) } else { (v, u) };
    let corners = [at - u - v, at + u - v, at + u + v, at - u + v].map(|p| at + 1e-3 * (p - at));
    let world = World::new(vec![Surface::Quad(Quad::new(corners, false).unwrap())]);
    let hit = world.closest(&Ray::new(at + normal, -normal), &mut ()).unwrap();
    Hit { surface: 1, time: 0.5, ..hit }
}

/// An emitter, and the tile that it lights.
fn world(surface: &Surface, hit: &Hit) -> World {
    let (u, v) = hit.geometric_normal.any_orthonormal_pair();
    let at = hit.position;
    let corners = [at - u - v, at + u - v, at + u + v, at - u + v].map(|p| at + 1e-3 * (p - at));
    World::new(vec![surface.clone(), Surface::Quad(Quad::new(corners, false).unwrap())])
}

/// The light of the emitter, which alone shines.
fn lit_by(world: &World, material: &Material) -> Lighting {
    let dark = Material::default();
    Lighting::new(world, |surface| if surface == 0 { material } else { &dark }, &[], None)
}

/// What is met by the ray of a sample, if that counts.
fn met(all: &Lighting, world: &World, hit: &Hit, at: &Receiver, u: [DVec2; 2]) -> Option<Hit> {
    let Some(Drawn::Aim(aim)) = all.sample(world, at, u[0].x, u[1]) else { return None };
    world.closest(&aim.ray(hit), &mut ()).filter(|met| aim.finds(met))
}

#[test]
fn irradiance_is_that_of_directions_by_chance() {
    let n = 20_000;
    let points: Vec<DVec2> = independent_points(2 * n).collect();
    for (name, surface, material) in emitters() {
        for position in PLACES {
            let normal = DVec3::new(0.1, 0.2, -1.0).normalize();
            let hit = tile(position, normal);
            let world = world(&surface, &hit);
            let all = lit_by(&world, &material);
            let at = Receiver { position, normal: Some(normal), both_sides: false, time: 0.5 };
            let light = |met: &Hit, direction: DVec3| {
                material.emitted_at(met.uv).x * direction.dot(normal).max(0.0)
            };
            let (right, up) = normal.any_orthonormal_pair();
            let mut sums = [[0.0; 2]; 2];
            for pair in points.chunks_exact(2) {
                let drawn = met(&all, &world, &hit, &at, [pair[0], pair[1]]).map_or(0.0, |met| {
                    let direction = (met.position - position).normalize();
                    let pdf = all.pdf_of_hit(&world, &at, direction, &met);
                    if pdf > 0.0 { light(&met, direction) / pdf } else { 0.0 }
                });
                let local = square_to_hemisphere(pair[1]);
                let direction = local.x * right + local.y * up + local.z * normal;
                let found = world.closest(&hit.spawn(direction), &mut ());
                let found = found.filter(|met| {
                    // Walls have the density 0.
                    met.front && all.pdf_of_hit(&world, &at, direction, met) > 0.0
                });
                let found = found.map_or(0.0, |met| material.emitted_at(met.uv).x * PI);
                for (sum, value) in sums.iter_mut().zip([drawn, found]) {
                    *sum = [sum[0] + value, sum[1] + value * value];
                }
            }
            let n = f64::from(n);
            let [drawn, found] = sums.map(|[sum, squares]| {
                let mean = sum / n;
                (mean, ((squares / n - mean * mean) / n).sqrt())
            });
            let found_out = format!("{name} from {position}: {drawn:?}, by chance {found:?}");
            assert!((drawn.0 - found.0).abs() < 4.0 * drawn.1.hypot(found.1), "{found_out}");
            // Close by, the share that scattered rays find is weighed more.
            let even = position != PLACES[0] || drawn.1 < 4.0 * found.1;
            assert!(drawn.0 > 0.0 && even, "{found_out}");
        }
    }
}

#[test]
fn directions_follow_the_density_of_what_they_meet() {
    const CELLS: usize = 20;
    const FINE: usize = 16;
    const SAMPLES: u32 = 50_000;
    let points: Vec<DVec2> = independent_points(2 * SAMPLES).collect();
    let cell = |d: DVec3| {
        let turn = (d.y.atan2(d.x) / TAU).rem_euclid(1.0);
        let place = |x: f64| ((x * CELLS as f64) as usize).min(CELLS - 1);
        // Fine where the emitter is.
        place((0.5 + 0.5 * d.z).sqrt()) * CELLS + place(turn)
    };
    for (name, surface, material) in emitters() {
        let position = PLACES[0];
        let hit = tile(position, DVec3::NEG_Z);
        let world = world(&surface, &hit);
        let all = lit_by(&world, &material);
        let at = Receiver { position, normal: Some(DVec3::NEG_Z), both_sides: false, time: 0.5 };
        let mut observed = vec![0.0; CELLS * CELLS];
        for pair in points.chunks_exact(2) {
            if let Some(met) = met(&all, &world, &hit, &at, [pair[0], pair[1]])
                && all.pdf_of_hit(&world, &at, DVec3::Z, &met) > 0.0
            {
                observed[cell((met.position - position).normalize())] += 1.0;
            }
        }
        let mut expected = vec![0.0; CELLS * CELLS];
        let n = CELLS * FINE;
        for k in 0..n * n {
            let root = ((k / n) as f64 + 0.5) / n as f64;
            let z = 2.0 * root * root - 1.0;
            if z >= 0.0 {
                continue;
            }
            let (sin, cos) = (TAU * ((k % n) as f64 + 0.5) / n as f64).sin_cos();
            let level = (1.0 - z * z).sqrt();
            let d = DVec3::new(level * cos, level * sin, z);
            if let Some(met) = world.closest(&hit.spawn(d), &mut ())
                && met.front
            {
                let pdf = all.pdf_of_hit(&world, &at, d, &met);
                let share = 4.0 * root * TAU / (n * n) as f64;
                expected[cell(d)] += pdf * share * f64::from(SAMPLES);
            }
        }
        let [drawn, density] =
            [&observed, &expected].map(|counts| counts.iter().sum::<f64>() / f64::from(SAMPLES));
        // What is drawn behind other parts of the emitter does not count.
        assert!(drawn <= 1.0 && drawn > 0.3, "{name}: {drawn}");
        assert!((drawn - density).abs() < 0.02, "{name}: {drawn} of {density}");
        // The sum is compared above: the test is of where they are.
        expected.iter_mut().for_each(|count| *count *= drawn / density);
        let z = chi_square_z(&observed, &expected);
        assert!(z < 5.0, "{name}: chi-square is {z} deviations too large");
    }
}

#[test]
fn what_is_drawn_of_a_convex_emitter_is_met() {
    // Nothing hides a flat relief from above, nor an undisplaced surface: no sample may be lost.
    let flat =
        ["a quad with an image", "a quad that stands", "a quad that moves", "a mesh with an image"];
    let points: Vec<DVec2> = independent_points(20_000).collect();
    for (name, surface, material) in emitters().into_iter().filter(|(n, ..)| flat.contains(n)) {
        let hit = tile(PLACES[0], DVec3::NEG_Z);
        let world = world(&surface, &hit);
        let all = lit_by(&world, &material);
        let at = Receiver { position: PLACES[0], normal: None, both_sides: false, time: 0.5 };
        let lost = points
            .chunks_exact(2)
            .filter(|pair| met(&all, &world, &hit, &at, [pair[0], pair[1]]).is_none())
            .count();
        assert_eq!(lost, 0, "{name}");
    }
}
