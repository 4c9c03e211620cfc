//! Whole pictures of the path integrator against recorded ones, pixel by pixel.
//!
//! Of each scene the mean of many renders is recorded, and the variance of one. A render passes if a
//! Z-test at significance 0.01 over all pixels, corrected as Sidak does, accepts at least 99.75 % of
//! them: the test of Mitsuba 3. Its mean must be right, too.
//!
//! Where a picture is meant to change, `RILIEVO_RECORD=1 cargo test -p rilievo-render recorded` writes the
//! records anew.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use rilievo::map::{HeightMap, Lattice, Procedural, Wrap};
use rilievo::relief::{Displacement, FaceOptions, Relief, ReliefFace};
use rilievo_render::light::{Environment, EnvironmentPlacement, Light, PointLight, SunLight};
use rilievo_render::texture::{ColourImage, Texels};
use rilievo_render::{Integrator, Material, RenderOptions, RenderSettings, Rgb, Scene, render};

use crate::closed_forms::{FLOOR, ceiling};
use crate::scenes::{Builder, camera, diffuse, emitter};

/// Pixels along a side.
const SIDE: u32 = 32;
/// Renders behind a record.
const RENDERS: u64 = 256;

/// The upper bound that a normal deviate keeps with probability `1 - (1 - 0.99^(1 / 1024)) / 2`.
const BOUND: f64 = 4.421;

fn settings(seed: u64) -> RenderSettings {
    RenderSettings {
        integrator: Integrator::Path,
        samples: 16,
        max_depth: 4,
        seed,
        ..RenderSettings::default()
    }
}

/// A room with a lamp and two balls. Without mirrors: their rare bright paths make a pixel far from normal.
fn room(seed: u64) -> Scene {
    let glossy = Material { reflective: Rgb::new(0.4, 0.3, 0.1), roughness: 0.8, ..diffuse(0.3) };
    Builder::default()
        .room(DVec3::ZERO, 1.0, &diffuse(0.6))
        .quad(ceiling([-0.4, 0.4], [-0.4, 0.4], 0.98), emitter(Rgb::new(8.0, 7.0, 5.0)))
        .sphere(DVec3::new(-0.4, 0.2, -0.6), 0.4, glossy)
        .sphere(DVec3::new(0.5, 0.4, -0.65), 0.35, diffuse(0.2))
        .scene(camera([0.0, -0.95, 0.1], [0.0, 0.3, -0.3], 70.0, [SIDE; 2]), settings(seed))
}

/// A relief of the procedural noise over the floor's middle.
fn hills(scale: f64, height: f64) -> ReliefFace {
    let map = Procedural::Fbm { octaves: 4, seed: 3 };
    let map: HeightMap = map.height_map_f32([33, 33], Lattice::Vertex, Wrap::Clamp).unwrap();
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let corners = corners.map(|[x, y]| DVec3::new(x, y, height));
    let displacement = Displacement { scale, ..Displacement::default() };
    let options = FaceOptions { displacement, ..FaceOptions::default() };
    ReliefFace::new(corners, Arc::new(Relief::new(map)), options).unwrap()
}

/// A relief under a sky and a sun.
fn open_air(seed: u64) -> Scene {
    let texel = |k: u32| {
        let (i, j) = ((k % 32) as f32, (k / 32) as f32);
        let glow = if (k % 32, k / 32) == (9, 11) { 40.0 } else { 0.0 };
        [glow + 0.01 * i, 0.5 * glow + 0.02 * j, 0.04 * j]
    };
    let image = Texels::Linear((0..32 * 16).map(texel).collect());
    let image = ColourImage::new(32, 16, image).unwrap();
    let environment = Environment::new(&image, EnvironmentPlacement::default()).unwrap();
    let sun = SunLight::new(DVec3::new(1.0, 0.4, -0.6), Rgb::new(3.0, 2.5, 2.0), 5.0).unwrap();
    Builder::default()
        .surface(hills(0.5, 0.0).into(), diffuse(0.7))
        .scene(camera([0.0, -2.6, 1.6], [0.0, 0.0, 0.1], 40.0, [SIDE; 2]), settings(seed))
        .with_environment(environment)
        .with_lamps(vec![Light::Sun(sun)])
}

/// Lamps of all kinds: points, a spot, a ball, and a relief that glows by itself.
fn lamps(seed: u64) -> Scene {
    let mut lamps = Vec::new();
    for k in 0..40 {
        let turn = f64::from(k) * 2.4;
        let place = DVec3::new(1.8 * turn.cos(), 1.8 * turn.sin(), 0.2 + 0.02 * f64::from(k));
        let colour = Rgb::new(f64::from(k % 3), 1.0, f64::from(k % 5)) * 0.02;
        lamps.push(Light::Point(PointLight::new(place, colour).unwrap()));
    }
    let spot = PointLight::new(DVec3::new(0.0, 0.0, 3.0), Rgb::splat(2.0)).unwrap();
    lamps.push(Light::Point(spot.spot(DVec3::new(0.1, 0.3, -1.0), [5.0, 15.0]).unwrap()));
    let glowing = Material { emitted: Rgb::new(0.5, 0.2, 0.1), ..diffuse(0.5) };
    Builder::default()
        .quad(FLOOR, diffuse(0.6))
        .surface(hills(0.4, 0.1).into(), glowing)
        .sphere(DVec3::new(-1.3, -1.2, 0.4), 0.15, emitter(Rgb::new(2.0, 4.0, 6.0)))
        .scene(camera([0.0, -4.5, 2.4], [0.0, 0.0, 0.1], 45.0, [SIDE; 2]), settings(seed))
        .with_lamps(lamps)
}

/// The green channel of a render.
fn green(scene: &Scene) -> Vec<f64> {
    let (film, _) = render(scene, &RenderOptions::default()).unwrap();
    film.radiance().iter().map(|p| f64::from(p[1])).collect()
}

fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/render/recorded").join(name)
}

/// Mean and variance of each pixel over many renders.
fn record(name: &str, scene: impl Fn(u64) -> Scene) {
    let mut sums = vec![[0.0; 2]; (SIDE * SIDE) as usize];
    for seed in 0..RENDERS {
        for (sum, value) in sums.iter_mut().zip(green(&scene(seed))) {
            sum[0] += value;
            sum[1] += value * value;
        }
    }
    let n = RENDERS as f64;
    let mut bytes = Vec::new();
    for [sum, squares] in sums {
        let variance = (squares - sum * sum / n).max(0.0) / (n - 1.0);
        for value in [sum / n, variance] {
            bytes.extend((value as f32).to_le_bytes());
        }
    }
    std::fs::write(path(name), bytes).unwrap();
}

fn check(name: &str, scene: impl Fn(u64) -> Scene) {
    if std::env::var_os("RILIEVO_RECORD").is_some() {
        return record(name, scene);
    }
    let bytes = std::fs::read(path(name)).unwrap();
    let numbers =
        bytes.chunks_exact(4).map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap())));
    let numbers: Vec<f64> = numbers.collect();
    // A seed that no record has seen.
    let found = green(&scene(1_000_000));
    assert_eq!(numbers.len(), 2 * found.len());
    let (mut accepted, mut difference, mut variances) = (0, 0.0, 0.0);
    for (found, record) in found.iter().zip(numbers.chunks_exact(2)) {
        let (mean, variance) = (record[0], record[1] * (1.0 + 1.0 / RENDERS as f64));
        // What is not random is recorded to single precision.
        let deviation = variance.sqrt().max(1e-6 * (1.0 + mean));
        accepted += u32::from((found - mean).abs() <= BOUND * deviation);
        difference += found - mean;
        variances += variance;
    }
    let share = f64::from(accepted) / f64::from(SIDE * SIDE);
    assert!(share >= 0.9975, "{name}: {share} of the pixels accepted");
    let deviations = difference / variances.sqrt();
    assert!(deviations.abs() < 4.0, "{name}: the mean is {deviations} deviations off");
}

#[test]
fn recorded_room() {
    check("room", room);
}

#[test]
fn recorded_open_air() {
    check("open_air", open_air);
}

#[test]
fn recorded_lamps() {
    check("lamps", lamps);
}
