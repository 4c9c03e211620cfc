//! Renders whose radiance is known.

use std::f64::consts::PI;

use crate::scenes::{Builder, camera, diffuse, emitter, pixel_centers};
use glam::DVec3;
use rilievo_render::{Material, RenderOptions, RenderSettings, Rgb, Scene, render};

/// Irradiance at the origin, facing +z, from a rectangle of radiance 1 at `height` above it that
/// spans `x` and `y`: the sum over its corners of the textbook corner formula.
pub fn rectangle_irradiance(x: [f64; 2], y: [f64; 2], height: f64) -> f64 {
    let corner = |x: f64, y: f64| {
        let (a, b) = (x / height, y / height);
        let half = |a: f64, b: f64| a / a.hypot(1.0) * (b / a.hypot(1.0)).atan();
        0.5 * (half(a, b) + half(b, a))
    };
    corner(x[1], y[1]) - corner(x[0], y[1]) - corner(x[1], y[0]) + corner(x[0], y[0])
}

/// A quad in the plane `z`, its front downwards.
pub fn ceiling(x: [f64; 2], y: [f64; 2], z: f64) -> [DVec3; 3] {
    [
        DVec3::new(x[0], y[0], z),
        DVec3::new(0.0, y[1] - y[0], 0.0),
        DVec3::new(x[1] - x[0], 0.0, 0.0),
    ]
}

/// The floor z = 0, |x|, |y| <= 50, its front upwards.
pub const FLOOR: [DVec3; 3] =
    [DVec3::new(-50.0, -50.0, 0.0), DVec3::new(100.0, 0.0, 0.0), DVec3::new(0.0, 100.0, 0.0)];

/// Shadow samples of one ray per pixel, nothing else.
fn direct(shadow_samples: u32) -> RenderSettings {
    RenderSettings { shadow_samples, max_depth: 0, ..RenderSettings::default() }
}

#[test]
fn a_quad_light_lights_a_floor_at_any_place_and_scale() {
    let far = DVec3::new(148_376.0, 1234.0, -223_423.0);
    let light = ceiling([0.0, 2.0], [-1.0, 0.5], 1.5);
    let expected = 0.8 / PI * 3.0 * rectangle_irradiance([0.0, 2.0], [-1.0, 0.5], 1.5);
    for (center, scale) in [(DVec3::ZERO, 1.0), (far, 1.0), (far, 1e-3), (DVec3::ONE, 1e6)] {
        let place = |[corner, u, v]: [DVec3; 3]| [center + scale * corner, scale * u, scale * v];
        let eye = (center + scale * DVec3::new(0.0, -5.0, 1.0)).to_array();
        let scene = Builder::default()
            .quad(place(FLOOR), diffuse(0.8))
            .quad(place(light), emitter(Rgb::splat(3.0)))
            // All pixels see next to the same point, so that they are samples of one number.
            .scene(camera(eye, center.to_array(), 1e-4, [64, 64]), direct(16));
        let (film, stats) = pixel_centers(&scene);
        let n = film.radiance().len() as f64;
        let values = || film.radiance().iter().map(|p| f64::from(p[0]));
        let mean = values().sum::<f64>() / n;
        let error = (values().map(|x| (x - mean).powi(2)).sum::<f64>() / n / n).sqrt();
        let found = format!("{mean} +- {error}, not {expected} at {center} x {scale}");
        assert!((mean - expected).abs() < 4.0 * error, "{found}");
        assert!(error < 1e-3 * expected, "{found}");
        assert_eq!((stats.rays.camera, stats.rays.shadow), (64 * 64, 64 * 64 * 16));
    }
}

#[test]
fn an_edge_casts_a_penumbra_of_the_right_width() {
    // Light of width 1 at z = 2; an opaque half plane x < 0 at z = 1: the penumbra on the floor is
    // |x| < 1/2, and beside it is the umbra.
    let scene = Builder::default()
        .quad(FLOOR, diffuse(1.0))
        .quad(ceiling([-0.5, 0.5], [-1.0, 1.0], 2.0), emitter(Rgb::ONE))
        .quad(ceiling([-60.0, 0.0], [-60.0, 60.0], 1.0), diffuse(0.5))
        .scene(camera([0.0, 0.0, 0.8], [0.0, 1e-6, 0.0], 90.0, [128, 32]), direct(1024));
    let (film, _) = pixel_centers(&scene);
    let points = film.layers()[0].values().chunks_exact(3);
    let (mut umbra, mut penumbra, mut lit) = (0, 0, 0);
    for (p, rgb) in points.zip(film.radiance()) {
        let [x, y] = [p[0], p[1]].map(f64::from);
        let seen = [(-x).clamp(-0.5, 0.5), 0.5];
        let expected = rectangle_irradiance(seen.map(|l| l - x), [-1.0 - y, 1.0 - y], 2.0) / PI;
        let found = f64::from(rgb[0]);
        if x < -0.5 {
            assert_eq!(found, 0.0, "x = {x}");
            umbra += 1;
        } else {
            assert!((found - expected).abs() < 0.003, "x = {x}: {found}, not {expected}");
            if x > 0.5 { lit += 1 } else { penumbra += 1 }
        }
    }
    assert!(umbra > 1000 && penumbra > 300 && lit > 1000, "{umbra} {penumbra} {lit}");
}

/// A room of half size 1 around `center`, seen from near its middle.
fn room(walls: &Material, settings: RenderSettings) -> Scene {
    let view = camera([0.1, 0.2, 0.05], [1.0, 0.3, 0.2], 100.0, [24, 24]);
    Builder::default().room(DVec3::ZERO, 1.0, walls).scene(view, settings)
}

#[test]
fn a_furnace_of_mirrors_sums_a_geometric_series() {
    for roughness in [0.0, 0.3, 1.0] {
        let walls = Material {
            reflective: Rgb::new(0.5, 1.0, 0.25),
            roughness,
            ..emitter(Rgb::new(1.0, 1.0, 2.0))
        };
        for max_depth in [0, 1, 5] {
            let scene = room(&walls, RenderSettings { max_depth, samples: 2, ..direct(1) });
            let (film, stats) = render(&scene, &RenderOptions::default()).unwrap();
            let terms: Vec<i32> = (0..=max_depth as i32).collect();
            let series = |r: f32| terms.iter().map(|&k| r.powi(k)).sum::<f32>();
            let expected = [series(0.5), series(1.0), 2.0 * series(0.25)];
            assert!(film.radiance().iter().all(|&rgb| rgb == expected), "{roughness} {max_depth}");
            assert_eq!(stats.rays.reflection == 0, max_depth == 0);
        }
    }
}

#[test]
fn a_furnace_of_lights_gives_pi() {
    // The walls emit 1 all around, so a wall's irradiance is pi and it sends out 1 + diffuse.
    let walls = Material { emitted: Rgb::ONE, ..diffuse(0.5) };
    let scene = room(&walls, RenderSettings { samples: 4, ..direct(64) });
    let (film, _) = render(&scene, &RenderOptions::default()).unwrap();
    let n = film.radiance().len() as f64;
    let mean = film.radiance().iter().map(|p| f64::from(p[0])).sum::<f64>() / n;
    assert!((mean - 1.5).abs() < 0.01, "{mean}");
}

#[test]
fn a_sphere_light_lights_by_its_solid_angle() {
    let scene = Builder::default()
        .quad(FLOOR, diffuse(1.0))
        .sphere(DVec3::new(0.0, 0.0, 2.0), 0.7, emitter(Rgb::splat(2.0)))
        .scene(camera([3.0, 0.0, 1.0], [0.5, 0.0, 0.0], 1e-3, [16, 16]), direct(256));
    let (film, _) = pixel_centers(&scene);
    let distance2: f64 = 0.5 * 0.5 + 4.0;
    let expected = 2.0 * 0.7 * 0.7 / distance2 * 2.0 / distance2.sqrt();
    let n = film.radiance().len() as f64;
    let mean = film.radiance().iter().map(|p| f64::from(p[0])).sum::<f64>() / n;
    assert!((mean / expected - 1.0).abs() < 2e-3, "{mean}, not {expected}");
}

/// Irradiance at `point`, facing +z, from a polygon of radiance 1 that lies above it: Lambert's
/// sum over the edges.
fn polygon_irradiance(corners: &[DVec3], point: DVec3) -> f64 {
    let ways: Vec<DVec3> = corners.iter().map(|c| (c - point).normalize()).collect();
    let next = ways.iter().cycle().skip(1);
    let edges = ways.iter().zip(next).map(|(a, b)| a.angle_between(*b) * a.cross(*b).normalize().z);
    0.5 * edges.sum::<f64>().abs()
}

#[test]
fn a_quad_light_need_not_be_a_parallelogram() {
    // Clockwise from above, so that the front looks down; the second is bent.
    let trapezium = [[0.0, 0.0, 1.0], [0.0, 2.0, 1.0], [1.0, 2.0, 1.0], [2.0, 0.0, 1.0]];
    let bent = [[-1.0, -1.0, 1.0], [-1.0, 1.0, 1.5], [1.0, 1.0, 1.0], [1.0, -1.0, 1.5]];
    for corners in [trapezium, bent] {
        let corners = corners.map(DVec3::from_array);
        let scene = Builder::default()
            .quad(FLOOR, diffuse(1.0))
            .corners(corners, emitter(Rgb::ONE))
            .scene(camera([3.0, 0.0, 0.5], [0.5, 0.5, 0.0], 1e-3, [16, 16]), direct(256));
        let (film, _) = pixel_centers(&scene);
        let expected = polygon_irradiance(&corners, DVec3::new(0.5, 0.5, 0.0)) / PI;
        let mean = film.radiance().iter().map(|rgb| f64::from(rgb[0])).sum::<f64>() / 256.0;
        assert!((mean / expected - 1.0).abs() < 2e-3, "{mean}, not {expected}");
    }
}

/// Coloured emitters above the plane z = 0.
fn above_the_mirror() -> Builder {
    Builder::default()
        .sphere(DVec3::new(-0.5, 1.0, 0.75), 0.5, emitter(Rgb::new(1.0, 0.5, 0.25)))
        .sphere(DVec3::new(0.75, 1.5, 0.5), 0.25, emitter(Rgb::new(0.25, 0.5, 4.0)))
        .quad(ceiling([-2.0, 1.0], [0.0, 3.0], 2.0), emitter(Rgb::new(0.5, 2.0, 0.125)))
}

#[test]
fn a_mirror_shows_what_its_mirrored_camera_sees() {
    let view = |side: f64, n| camera([0.0, -3.0, side], [0.0, 0.5, side * -0.25], 40.0, [n, n]);
    let mirror = Material { reflective: Rgb::ONE, ..diffuse(0.0) };
    let settings = RenderSettings { max_depth: 1, ..direct(1) };
    let mirrored = above_the_mirror().quad(FLOOR, mirror).scene(view(1.0, 64), settings);
    let seen = above_the_mirror().scene(view(-1.0, 64), settings);
    let ((a, _), (b, _)) = (pixel_centers(&mirrored), pixel_centers(&seen));
    let (mut compared, mut bright) = (0, 0);
    for (i, p) in a.layers()[0].values().chunks_exact(3).enumerate() {
        // The mirrored camera's image is upside down.
        let twin = (63 - i / 64) * 64 + i % 64;
        if p[2].abs() < 1e-6 {
            assert_eq!(a.radiance()[i], b.radiance()[twin], "pixel {i}");
            compared += 1;
            bright += u32::from(b.radiance()[twin] != [0.0; 3]);
        }
    }
    assert!(compared > 1000 && bright > 300, "{compared} {bright}");
}

#[test]
fn a_closed_box_lit_from_outside_stays_black() {
    for (center, half) in [
        (DVec3::ZERO, 1.0),
        (DVec3::new(148_376.0, 1234.0, -223_423.0), 1.0),
        (DVec3::new(148_376.0, 1234.0, -223_423.0), 1e3),
        (DVec3::ZERO, 1e-3),
    ] {
        let walls = Material { reflective: Rgb::splat(0.5), roughness: 0.5, ..diffuse(0.9) };
        let mut builder = Builder::default().room(center, half, &walls);
        // Bright lights all around, some only just outside.
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for side in [axis, -axis] {
                let u = DVec3::new(axis.z, axis.x, axis.y) * half * 3.0;
                let v = -side.cross(u);
                let corner = center + side * half * 1.01 - 0.5 * (u + v);
                builder = builder.quad([corner, u, v], emitter(Rgb::splat(1e6)));
            }
        }
        let view = center.to_array();
        let ahead = (center + half * DVec3::new(1.0, 0.8, 0.6)).to_array();
        let settings = RenderSettings { max_depth: 3, samples: 4, ..direct(4) };
        let scene = builder
            .sphere(center + 5.0 * half * DVec3::ONE, half, emitter(Rgb::splat(1e6)))
            .scene(camera(view, ahead, 120.0, [32, 32]), settings);
        let (film, stats) = render(&scene, &RenderOptions::default()).unwrap();
        assert!(film.radiance().iter().all(|&rgb| rgb == [0.0; 3]), "{center} {half}");
        assert!(stats.rays.shadow > 100_000);
    }
}
