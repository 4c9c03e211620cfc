//! The path integrator, where the radiance is known.

use std::f64::consts::PI;

use glam::DVec3;
use rilievo::mesh::{Mesh, MeshData, Triangle};
use rilievo::surface::{Quad, Surface};
use rilievo_render::light::{Environment, EnvironmentPlacement, Light, PointLight, SunLight};
use rilievo_render::texture::{ColourImage, Texels};
use rilievo_render::{Integrator, Material, RenderOptions, RenderSettings, Rgb, Scene, render};

use crate::closed_forms::{FLOOR, ceiling, rectangle_irradiance};
use crate::scenes::{Builder, camera, diffuse, emitter, glowing, mean_of, room};

/// Paths of up to `max_depth` bounces.
pub fn paths(samples: u32, max_depth: u32) -> RenderSettings {
    RenderSettings { integrator: Integrator::Path, samples, max_depth, ..RenderSettings::default() }
}

/// Mean of the red channel and its standard error, over pixels that are samples of one number.
fn mean(scene: &Scene) -> (f64, f64) {
    let (film, stats) = render(scene, &RenderOptions::default()).unwrap();
    assert!(stats.complete);
    mean_of(&film)
}

/// Checks the mean against what is known; the standard error must be below `within` of it.
pub fn check(name: &str, scene: &Scene, expected: f64, within: f64) {
    let (mean, error) = mean(scene);
    let found = format!("{name}: {mean} +- {error}, not {expected}");
    assert!((mean - expected).abs() <= 4.0 * error + 1e-6 * expected, "{found}");
    assert!(error <= within * expected, "{found}");
}

/// Everything looks at the origin from the side.
pub fn at_the_origin() -> rilievo_render::CameraParts {
    camera([0.0, -5.0, 1.0], [0.0, 0.0, 0.0], 1e-4, [24, 24])
}

#[test]
fn a_furnace_of_glowing_walls_sums_a_geometric_series() {
    let walls = Material { emitted: Rgb::ONE, ..diffuse(0.5) };
    for as_instances in [false, true] {
        for max_depth in [0, 1, 4, 200] {
            // Emission after each of up to `max_depth + 1` bounces.
            let expected = (0..=max_depth + 1).map(|k| 0.5_f64.powi(k as i32)).sum();
            let scene = room(&walls, as_instances, paths(16, max_depth));
            check("furnace", &scene, expected, 0.02);
        }
    }
}

#[test]
fn two_parallel_planes_pass_light_to_and_fro() {
    let far = 1e6;
    let plane = |z| ceiling([-far, far], [-far, far], z);
    let [corner, u, v] = plane(0.0);
    let view = camera([0.0, 0.0, 0.5], [0.3, 0.2, 1.0], 50.0, [24, 24]);
    let glowing = Material { emitted: Rgb::ONE, ..diffuse(0.6) };
    let scene = Builder::default()
        .quad([corner, v, u], diffuse(0.8))
        .quad(plane(1.0), glowing)
        .scene(view, paths(64, 200));
    check("planes", &scene, 1.0 / (1.0 - 0.6 * 0.8), 0.01);
}

#[test]
fn direct_light_follows_its_formula() {
    let floor = || Builder::default().quad(FLOOR, diffuse(0.8));
    let lit = |lamp: Light| floor().scene(at_the_origin(), paths(16, 0)).with_lamps(vec![lamp]);
    let over = |irradiance: f64| 0.8 / PI * irradiance;
    let view = at_the_origin();

    let quad = ceiling([0.0, 2.0], [-1.0, 0.5], 1.5);
    let expected = over(3.0 * rectangle_irradiance([0.0, 2.0], [-1.0, 0.5], 1.5));
    let scene = floor().quad(quad, emitter(Rgb::splat(3.0))).scene(view, paths(64, 0));
    check("quad", &scene, expected, 1e-2);

    let center = DVec3::new(1.0, 0.0, 3.0);
    let expected = over(PI * 4.0 * 0.25 * (3.0 / 10.0_f64.sqrt()) / 10.0);
    let scene = floor().sphere(center, 0.5, emitter(Rgb::splat(4.0))).scene(view, paths(64, 0));
    check("sphere", &scene, expected, 1e-2);

    let place = DVec3::new(0.0, 3.0, 4.0);
    let point = PointLight::new(place, Rgb::splat(50.0)).unwrap();
    check("point", &lit(Light::Point(point)), over(50.0 * 0.8 / 25.0), 1e-6);
    let spot = point.spot(-place, [10.0, 20.0]).unwrap();
    check("spot", &lit(Light::Point(spot)), over(50.0 * 0.8 / 25.0), 1e-6);
    let aside = point.spot(-place + DVec3::Y * 5.0, [10.0, 20.0]).unwrap();
    assert_eq!(mean(&lit(Light::Point(aside))).0, 0.0);

    let slant = DVec3::new(0.0, 1.0, -1.0);
    for (angle, within) in [(0.0, 1e-6), (10.0, 1e-2)] {
        let sun = SunLight::new(slant, Rgb::splat(2.0), angle).unwrap();
        check("sun", &lit(Light::Sun(sun)), over(2.0 * 0.5_f64.sqrt()), within);
    }
}

#[test]
fn a_mesh_of_many_triangles_is_sampled_as_a_whole() {
    let (n, mut positions, mut triangles) = (10, Vec::new(), Vec::new());
    for k in 0..(n + 1) * (n + 1) {
        let [i, j] = [k % (n + 1), k / (n + 1)].map(|i| f64::from(i) / f64::from(n));
        positions.push(DVec3::new(2.0 * i, -1.0 + 1.5 * j, 1.5));
    }
    for k in 0..n * n {
        let first = k / n * (n + 1) + k % n;
        // Fronts down.
        for positions in [[0, n + 1, 1], [1, n + 1, n + 2]] {
            let positions = positions.map(|corner: u32| first + corner);
            triangles.push(Triangle { positions, normals: None, uvs: None });
        }
    }
    let mesh = Mesh::new(MeshData { positions, triangles, ..MeshData::default() }).unwrap();
    let expected = 0.8 / PI * 3.0 * rectangle_irradiance([0.0, 2.0], [-1.0, 0.5], 1.5);
    let scene = Builder::default()
        .quad(FLOOR, diffuse(0.8))
        .surface(mesh.into(), emitter(Rgb::splat(3.0)))
        .scene(at_the_origin(), paths(64, 0));
    check("mesh", &scene, expected, 1e-2);
}

#[test]
fn many_lights_add_up() {
    let mut lamps = Vec::new();
    let mut irradiance = 0.0;
    for k in 0..500 {
        let turn = f64::from(k) * 2.4;
        let place = DVec3::new(turn.cos(), turn.sin(), 0.02) * (0.3 + 0.03 * f64::from(k));
        let intensity = 0.1 + f64::from(k % 7);
        lamps.push(Light::Point(PointLight::new(place, Rgb::splat(intensity)).unwrap()));
        irradiance += intensity * place.normalize().z / place.length_squared();
    }
    let scene = Builder::default()
        .quad(FLOOR, diffuse(0.8))
        .scene(at_the_origin(), paths(256, 0))
        .with_lamps(lamps);
    check("500 points", &scene, 0.8 / PI * irradiance, 0.01);
}

#[test]
fn an_environment_lights_a_floor() {
    // Two bright spots and a gradient.
    let texel = |k: u32| {
        let (i, j) = (k % 64, k / 64);
        let spot = if (i, j) == (20, 24) || (i, j) == (50, 18) { 300.0 } else { 0.0 };
        [spot + j as f32 / 32.0, 1.0, 1.0]
    };
    let texels = Texels::Linear((0..64 * 32).map(texel).collect());
    let image = ColourImage::new(64, 32, texels).unwrap();
    let environment = Environment::new(&image, EnvironmentPlacement::default()).unwrap();
    let n = 1024;
    let mut irradiance = 0.0;
    for k in 0..n * n {
        let [r, turn] = [k / n, k % n].map(|i| (f64::from(i) + 0.5) / f64::from(n));
        let (sin, cos) = (2.0 * PI * turn).sin_cos();
        let (level, z) = (r.sqrt(), (1.0 - r).sqrt());
        irradiance += environment.radiance(DVec3::new(level * cos, level * sin, z)).x;
    }
    irradiance *= PI / f64::from(n * n);
    let scene = Builder::default()
        .quad(FLOOR, diffuse(0.8))
        .scene(at_the_origin(), paths(64, 0))
        .with_environment(environment);
    check("environment", &scene, 0.8 / PI * irradiance, 0.01);
}

#[test]
fn all_ways_to_find_a_light_agree() {
    // The same lamp, sampled and met (the path integrator), only met (an instance), only sampled (the
    // paper's integrator).
    let lamp = ceiling([-0.5, 0.5], [-0.7, 0.7], 0.6);
    let room = |lamp: Surface, settings| {
        Builder::default()
            .room(DVec3::ZERO, 1.0, &diffuse(0.7))
            .surface(lamp, emitter(Rgb::splat(5.0)))
            .scene(camera([0.1, -0.2, 0.05], [0.1, 0.3, -1.0], 40.0, [24, 24]), settings)
    };
    let [corner, u, v] = lamp;
    let quad = Quad::new([corner, corner + u, corner + u + v, corner + v], false).unwrap();
    for max_depth in [0, 1, 3] {
        let both = mean(&room(quad.into(), paths(64, max_depth)));
        let met = mean(&room(glowing(lamp), paths(256, max_depth)));
        let sampled = RenderSettings {
            integrator: Integrator::Distributed,
            samples: 64,
            shadow_samples: 1,
            diffuse_samples: 1,
            max_depth,
            ..RenderSettings::default()
        };
        let sampled = mean(&room(quad.into(), sampled));
        for (name, (other, error)) in [("met", met), ("sampled", sampled)] {
            let (mean, own) = both;
            // The pixels differ: their spread is no error of the mean, and a bound for it.
            let bound = 4.0 * error.hypot(own);
            let found = format!("{max_depth}: {mean}, {name} {other}, within {bound}");
            assert!((mean - other).abs() < bound.min(0.01 * mean), "{found}");
        }
    }
}

#[test]
fn a_mirror_shows_the_light_once() {
    let mirror = Material { reflective: Rgb::splat(0.9), roughness: 0.0, ..diffuse(0.0) };
    let wall =
        [DVec3::new(-9.0, 2.0, -9.0), DVec3::new(18.0, 0.0, 0.0), DVec3::new(0.0, 0.0, 18.0)];
    let sun = SunLight::new(DVec3::NEG_Z, Rgb::ONE, 0.5).unwrap();
    for roughness in [0.0, 0.05] {
        let floor = Material { roughness, ..mirror.clone() };
        let view = camera([0.0, -5.0, 5.0], [0.0, 0.0, 0.0], 1e-4, [16, 16]);
        let scene = Builder::default()
            .quad(FLOOR, floor)
            .quad(wall, emitter(Rgb::splat(2.0)))
            .scene(view, paths(64, 0))
            .with_lamps(vec![Light::Sun(sun)]);
        check("mirror", &scene, 1.8, 1e-2);
    }
}

#[test]
fn a_clamp_holds_bounces_back_and_nothing_else() {
    let walls = Material { emitted: Rgb::ONE, ..diffuse(0.5) };
    let settings = |clamp, max_depth| RenderSettings { clamp, ..paths(16, max_depth) };
    check("direct", &room(&walls, false, settings(0.01, 0)), 1.5, 0.02);
    let (held, _) = mean(&room(&walls, false, settings(0.01, 4)));
    // Four more bounces, met and sampled, of at most 0.01 each.
    assert!(held > 1.5 && held < 1.59, "{held}");
}

#[test]
fn threads_and_roulette_leave_the_bytes_alone() {
    let walls = Material { emitted: Rgb::new(0.2, 0.4, 0.6), ..diffuse(0.7) };
    let scene = room(&walls, false, paths(5, 40));
    let bytes = |threads| {
        let options = RenderOptions { threads, ..RenderOptions::default() };
        let (film, stats) = render(&scene, &options).unwrap();
        (film.radiance().to_vec(), stats.rays)
    };
    let (one, rays) = bytes(1);
    assert!(rays.diffuse > rays.camera && rays.shadow > rays.camera);
    assert!((one.clone(), rays) == bytes(3));
}
