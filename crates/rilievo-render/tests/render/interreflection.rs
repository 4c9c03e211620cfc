//! Diffuse bounces, where the radiance is known.

use std::f64::consts::PI;

use glam::DVec3;
use rilievo_render::{Material, RenderOptions, RenderSettings, Rgb, render};

use crate::scenes::{
    Builder, camera, diffuse, emitter, glowing, mean_of as mean, pixel_centers, room,
};

/// One bounce ray a hit.
fn bounces(max_depth: u32) -> RenderSettings {
    RenderSettings {
        samples: 1,
        shadow_samples: 1,
        diffuse_samples: 1,
        max_depth,
        ..RenderSettings::default()
    }
}

#[test]
fn a_furnace_of_glowing_walls_sums_a_geometric_series() {
    let walls = Material { emitted: Rgb::ONE, ..diffuse(0.5) };
    for (max_depth, diffuse_samples) in [(0, 1), (1, 1), (1, 3), (4, 2)] {
        let settings = RenderSettings { diffuse_samples, samples: 2, ..bounces(max_depth) };
        let (film, stats) =
            render(&room(&walls, true, settings), &RenderOptions::default()).unwrap();
        let expected: f32 = (0..=max_depth as i32).map(|k| 0.5f32.powi(k)).sum();
        assert!(film.radiance().iter().all(|&rgb| rgb == [expected; 3]), "{max_depth}");
        let first = 24 * 24 * 2 * u64::from(diffuse_samples);
        assert_eq!(stats.rays.diffuse, first * u64::from(max_depth));
        assert_eq!((stats.rays.shadow, stats.rays.reflection), (0, 0));
    }
}

#[test]
fn a_furnace_of_lights_counts_their_light_once() {
    // Walls that are lights are seen by shadow rays; what bounce rays bring is one bounce later.
    let walls = Material { emitted: Rgb::ONE, ..diffuse(0.5) };
    for max_depth in [0, 1, 3] {
        let settings = RenderSettings { samples: 4, shadow_samples: 4, ..bounces(max_depth) };
        let scene = room(&walls, false, settings);
        let (film, _) = render(&scene, &RenderOptions::default()).unwrap();
        let expected: f64 = (0..=max_depth as i32 + 1).map(|k| 0.5f64.powi(k)).sum();
        let (mean, error) = mean(&film);
        assert!((mean - expected).abs() < 4.0 * error, "{mean} +- {error}, not {expected}");
        assert!(error < 0.01);
    }
}

/// The floor z = 0, its front upwards.
const FLOOR: [DVec3; 3] =
    [DVec3::new(-50.0, -50.0, 0.0), DVec3::new(100.0, 0.0, 0.0), DVec3::new(0.0, 100.0, 0.0)];

#[test]
fn a_panel_lights_a_floor_by_bounces_as_by_shadow_rays() {
    // 2 x 2 at height 1 over its corner: the corner formula of a rectangle.
    let expected = 0.8 / PI * 2.0 / 5.0f64.sqrt() * (2.0 / 5.0f64.sqrt()).atan();
    let panel = [DVec3::Z, DVec3::Y * 2.0, DVec3::X * 2.0];
    for as_instances in [true, false] {
        let builder = Builder::default().quad(FLOOR, diffuse(0.8));
        let builder = match as_instances {
            true => builder.surface(glowing(panel), emitter(Rgb::ONE)),
            false => builder.quad(panel, emitter(Rgb::ONE)),
        };
        let settings = RenderSettings { diffuse_samples: 16, shadow_samples: 16, ..bounces(1) };
        // All pixels see next to the same point.
        let view = camera([0.0, -5.0, 1.0], [0.0, 0.0, 0.0], 1e-4, [64, 64]);
        let (film, stats) = pixel_centers(&builder.scene(view, settings));
        let (mean, error) = mean(&film);
        assert!((mean - expected).abs() < 4.0 * error, "{as_instances}: {mean} +- {error}");
        assert!(error < 0.01 * expected);
        assert_eq!(stats.rays.shadow > 0, !as_instances);
        assert_eq!(stats.rays.diffuse, 64 * 64 * 16);
    }
}

#[test]
fn two_endless_planes_exchange_light() {
    // One unit apart; the lower one glows, the upper one sends a quarter of it back.
    let floor = Material { emitted: Rgb::ONE, ..diffuse(0.5) };
    let wide = |z: f64, side: f64| {
        let reach = 1e5;
        [
            DVec3::new(-reach, -side * reach, z),
            DVec3::X * 2.0 * reach,
            DVec3::Y * 2.0 * side * reach,
        ]
    };
    let scene = Builder::default()
        .surface(glowing(wide(0.0, 1.0)), floor)
        .surface(glowing(wide(1.0, -1.0)), diffuse(0.25))
        .scene(camera([0.0, 0.0, 0.5], [0.2, 0.0, 0.0], 1e-3, [64, 64]), bounces(2));
    let (film, _) = pixel_centers(&scene);
    // Down, up, down: 1 + 0.5 * 0.25 * 1; no ray finds the planes' ends.
    assert!(film.radiance().iter().all(|&rgb| rgb == [1.125; 3]));
}

#[test]
fn the_background_lights_a_floor_by_bounces_alone() {
    for (diffuse_samples, expected) in [(0, 0.0), (1, 0.375)] {
        let settings = RenderSettings { diffuse_samples, ..bounces(1) };
        let view = camera([0.0, -5.0, 1.0], [0.0, 0.0, 0.0], 5.0, [16, 16]);
        let builder = Builder::default().quad(FLOOR, diffuse(0.5)).background(Rgb::splat(0.75));
        let (film, stats) = pixel_centers(&builder.scene(view, settings));
        assert!(film.radiance().iter().all(|&rgb| rgb == [expected; 3]));
        assert_eq!(stats.rays.diffuse, 256 * u64::from(diffuse_samples));
    }
}
