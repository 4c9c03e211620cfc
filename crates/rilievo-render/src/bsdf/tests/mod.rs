//! What holds for every material: densities integrate to one and are those of the samples, energy is
//! kept, weights are values over densities.

mod closed_forms;
mod furnace;
mod lambert_gloss;
mod models;

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rilievo::Hit;
use rilievo::surface::{Quad, Surface, World};

use super::Bsdf;
use crate::colour::Rgb;
use crate::sampler::chi_square::chi_square_z;
use crate::scene::Material;

/// Cells of z and of the azimuth.
const CELLS: usize = 20;

/// Steps of the quadrature along a side of a cell.
const FINE: usize = 32;

const SAMPLES: u32 = 1_000_000;

/// Standard deviations that chi-square may exceed its mean by. One test in 30 000 does: with 300
/// tests a false alarm has probability 0.01.
const DEVIATIONS: f64 = 4.0;

/// A hit in the plane z = 0 whose shading normal leans by `tilt` radians towards +x, seen from
/// the front or from behind.
fn hit(tilt: f64, front: bool) -> Hit {
    let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|c| c.extend(0.0));
    let quad = Quad::new(corners, false).unwrap();
    let world = World::new(vec![Surface::Quad(quad)]);
    let z = if front { 1.0 } else { -1.0 };
    let ray = rilievo::Ray::new(DVec3::new(0.5, 0.5, z), DVec3::new(0.0, 0.0, -z));
    let hit = world.closest(&ray, &mut ()).unwrap();
    Hit { shading_normal: DVec3::new(tilt.sin(), 0.0, tilt.cos()), ..hit }
}

/// A direction by the angle with the normal of the viewed side and the azimuth.
fn direction(angle: f64, azimuth: f64, front: bool) -> DVec3 {
    let (sin, cos) = angle.sin_cos();
    let z = if front { cos } else { -cos };
    DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), z)
}

/// Views from above to grazing, with a tilt of the shading normal, from both sides.
fn views() -> impl Iterator<Item = (DVec3, Hit)> {
    let cases = [
        (0.1, 0.3, 0.0, true),
        (1.4, 1.0, 0.0, true),
        (1.1, 3.0, 0.4, true),
        (0.6, 1.0, 0.3, false),
    ];
    cases
        .into_iter()
        .map(|(angle, azimuth, tilt, front)| (direction(angle, azimuth, front), hit(tilt, front)))
}

/// Independent numbers in `[0, 1)`: SplitMix64 \[Steele2014\].
struct Numbers(u64);

impl Numbers {
    fn one(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / 9_007_199_254_740_992.0
    }

    fn two(&mut self) -> DVec2 {
        DVec2::new(self.one(), self.one())
    }
}

/// Draws many directions and tests them against the density; the share that was not drawn is
/// what the density does not integrate to. Lobes of single directions are left out of both.
fn check_density(name: &str, bsdf: &Bsdf) {
    let mut observed = vec![0.0; CELLS * CELLS];
    let cell = |x: f64| ((x * CELLS as f64) as usize).min(CELLS - 1);
    let mut drawn = 0.0;
    let mut numbers = Numbers(11);
    for k in 0..SAMPLES {
        let Some(scattered) = bsdf.sample(numbers.one(), numbers.two()) else { continue };
        if scattered.delta {
            continue;
        }
        let d = scattered.direction;
        assert!((d.length() - 1.0).abs() < 1e-9, "{name}: {d}");
        let turn = (d.y.atan2(d.x) / TAU).rem_euclid(1.0);
        observed[cell(0.5 + 0.5 * d.z) * CELLS + cell(turn)] += 1.0;
        drawn += 1.0;
        if k % 16 != 0 {
            continue;
        }
        let (value, pdf) = bsdf.evaluate(d);
        assert!((pdf - scattered.pdf).abs() <= 1e-9 * pdf, "{name}: {pdf}, {}", scattered.pdf);
        let error = (value - pdf * scattered.weight).abs().max_element();
        assert!(error <= 1e-9 * value.max_element(), "{name}: value {value}, pdf {pdf}");
    }
    let mut expected = vec![0.0; CELLS * CELLS];
    let turns: Vec<(f64, f64)> = (0..CELLS * FINE)
        .map(|column| (TAU * (column as f64 + 0.5) / (CELLS * FINE) as f64).sin_cos())
        .collect();
    for row in 0..CELLS {
        // Around a pole a small angle is a very small step of z.
        let fine = if row == 0 || row == CELLS - 1 { 6 * FINE } else { FINE };
        for step in 0..fine {
            let z = (row as f64 + (step as f64 + 0.5) / fine as f64) * 2.0 / CELLS as f64 - 1.0;
            let r = (1.0 - z * z).sqrt();
            for (column, (sin, cos)) in turns.iter().enumerate() {
                let density = bsdf.evaluate(DVec3::new(r * cos, r * sin, z)).1;
                let area = 4.0 * PI / (CELLS * CELLS * FINE * fine) as f64;
                expected[row * CELLS + column / FINE] += density * area * f64::from(SAMPLES);
            }
        }
    }
    let total: f64 = expected.iter().sum();
    let error = (total - drawn) / f64::from(SAMPLES);
    assert!(error.abs() < 4e-3, "{name}: {drawn} were drawn, the density says {total}");
    // What the quadrature gets wrong of the whole is no matter of the shape.
    for e in &mut expected {
        *e *= drawn / total;
    }
    let z = chi_square_z(&observed, &expected);
    assert!(z < DEVIATIONS, "{name}: chi-square is {z} deviations too large");
}

/// The mean weight of samples: the light that comes back in a white furnace. What goes through is
/// taken times `through`: radiance changes by the square of the index, power does not.
fn furnace(bsdf: &Bsdf, samples: u32, through: f64) -> Rgb {
    let mut numbers = Numbers(5);
    let draw = |_| {
        bsdf.sample(numbers.one(), numbers.two()).map(|scattered| {
            let through = if scattered.transmitted { through } else { 1.0 };
            through * scattered.weight
        })
    };
    let weights = (0..samples).filter_map(draw);
    weights.sum::<Rgb>() / f64::from(samples)
}

/// The material at a hit.
fn bsdf(material: &Material, view: DVec3, hit: &Hit) -> Bsdf {
    Bsdf::new(material, hit, view, 0.0)
}
