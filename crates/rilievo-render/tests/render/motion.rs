//! Surfaces that move: blurred edges and shadows, one time for each path, the same bytes always.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use rilievo::map::{Lattice, Procedural, Wrap};
use rilievo::relief::{Displacement, FaceOptions, Relief, ReliefFace};
use rilievo::surface::{Motion, MovingInstance, Quad, Sphere, Surface};
use rilievo_render::film::{Tile, join};
use rilievo_render::light::{Light, PointLight};
use rilievo_render::{
    Aov, Camera, Film, Integrator, Pose, Projection, RenderOptions, RenderSettings, Rgb, Scene,
    render,
};

use crate::scenes::{Builder, camera, diffuse, emitter};

const X: DVec3 = DVec3::X;
const Y: DVec3 = DVec3::Y;
const Z: DVec3 = DVec3::Z;

fn moving(surface: impl Into<Surface>, motion: Motion) -> Surface {
    let surface = Arc::new(surface.into());
    MovingInstance::new(surface, DAffine3::IDENTITY, motion).unwrap().into()
}

fn quad([corner, u, v]: [DVec3; 3]) -> Quad {
    Quad::new([corner, corner + u, corner + u + v, corner + v], false).unwrap()
}

fn settings(integrator: Integrator, samples: u32) -> RenderSettings {
    RenderSettings { integrator, samples, ..RenderSettings::default() }
}

/// Looks along y at the square |x| < 1, |z| < 1 / 16, 32 x 2 pixels.
fn flat(scene: Scene, shutter: [f64; 2]) -> Scene {
    let parts = camera([0.0, -5.0, 0.0], [0.0; 3], 40.0, [32, 2]);
    let camera = Camera::new(parts).unwrap().with_shutter(shutter).unwrap();
    let projection = Projection::Orthographic { height: 1.0 / 8.0 };
    scene.with_camera(camera.with_projection(projection).unwrap())
}

fn picture(scene: &Scene, aovs: &[Aov]) -> Film {
    render(scene, &RenderOptions { aovs, ..RenderOptions::default() }).unwrap().0
}

/// The first row of a picture, red.
fn row(scene: &Scene) -> Vec<f64> {
    picture(scene, &[]).radiance()[..32].iter().map(|rgb| f64::from(rgb[0])).collect()
}

fn any() -> rilievo_render::CameraParts {
    camera([0.0, -5.0, 0.0], [0.0; 3], 40.0, [32, 2])
}

#[test]
fn a_blurred_edge_covers_in_proportion_to_time() {
    // A screen that shines; its right edge goes from x = -1 to x = 1.
    let screen = quad([-3.0 * X - Z, 2.0 * X, 2.0 * Z]);
    for integrator in [Integrator::Path, Integrator::Distributed] {
        for shutter in [[0.0, 1.0], [0.25, 0.75], [0.5, 0.5]] {
            let scene = Builder::default()
                .surface(moving(screen, Motion::along(2.0 * X)), emitter(Rgb::ONE))
                .scene(any(), settings(integrator, 256));
            for (k, seen) in row(&flat(scene, shutter)).into_iter().enumerate() {
                // The edge is left of a place for a share of the time.
                let (place, [open, close]) = ((k as f64 + 0.5) / 32.0, shutter);
                let dark = (place - open) / (close - open).max(1e-9);
                let share = 1.0 - dark.clamp(0.0, 1.0);
                // Strata of 256 samples leave less than a twentieth of a pixel's ramp.
                let within = place > open + 0.02 && place < close - 0.02;
                let edge = (place - open).abs().min((place - close).abs()) < 0.02;
                if !edge {
                    let most = if within { 0.02 } else { 0.0 };
                    assert!((seen - share).abs() <= most, "{integrator} {shutter:?} {k}: {seen}");
                }
            }
        }
    }
}

#[test]
fn a_blurred_shadow_is_that_of_the_times_of_its_paths() {
    // A wall in the light of a far lamp; the edge of the screen before it passes as above.
    let screen = quad([-3.0 * X - Z - 2.0 * Y, 2.0 * X, 2.0 * Z]);
    let wall = [4.0 * X - 4.0 * Z, -8.0 * X, 8.0 * Z];
    for integrator in [Integrator::Path, Integrator::Distributed] {
        let lamp = PointLight::new(-1e4 * Y, Rgb::splat(1e8)).unwrap();
        let shadow = |motion| {
            // Seen past the screen: from behind the wall's side that is lit, by a camera between.
            let scene = Builder::default()
                .quad(wall, diffuse(1.0))
                .surface(moving(screen, motion), diffuse(0.0))
                .scene(any(), settings(integrator, 256));
            let scene = scene.with_lamps(vec![Light::Point(lamp)]);
            let scene = flat(scene, [0.0, 1.0]);
            let parts = camera([0.0, -1.0, 0.0], [0.0; 3], 40.0, [32, 2]);
            let projection = Projection::Orthographic { height: 1.0 / 8.0 };
            let near = Camera::new(parts).unwrap().with_projection(projection).unwrap();
            row(&scene.with_camera(near))
        };
        let lit = shadow(Motion::along(-9.0 * Z - 9.0 * X))[31];
        assert!(lit > 0.1);
        for (k, seen) in shadow(Motion::along(2.0 * X)).into_iter().enumerate() {
            let share = (k as f64 + 0.5) / 32.0;
            assert!((seen / lit - share).abs() < 0.03, "{integrator} {k}: {} {share}", seen / lit);
        }
    }
}

#[test]
fn what_moves_with_the_camera_is_sharp() {
    let ball = Sphere::new(DVec3::ZERO, 0.5).unwrap();
    let shift = DVec3::new(0.7, -0.2, 0.4);
    let still = Builder::default().sphere(DVec3::ZERO, 0.5, diffuse(0.5)).background(Rgb::ONE);
    let still = still.scene(any(), settings(Integrator::Path, 64));
    let way = moving(ball, Motion::along(shift));
    let along = Builder::default().surface(way, diffuse(0.5)).background(Rgb::ONE);
    let along = along.scene(any(), settings(Integrator::Path, 64));
    let parts = camera([0.0, -3.0, 0.0], [0.0; 3], 30.0, [24, 24]);
    let end = Pose { position: parts.position + shift, look_at: shift, up: Z };
    let resting = Camera::new(parts).unwrap();
    let going = resting.with_motion(end, [0.0, 1.0]).unwrap();
    let depth = |scene: &Scene| {
        let film = picture(scene, &[Aov::Z]);
        film.layers()[0].values().to_vec()
    };
    let (along, still) = (depth(&along.with_camera(going)), depth(&still.with_camera(resting)));
    let same = along.iter().zip(&still).filter(|(a, b)| a == b || (*a - *b).abs() < 1e-5).count();
    // Pixels at the rim hold other samples: there the strata of the pixel are the same, and so is all.
    assert_eq!(same, along.len());
}

/// A displaced face that turns and a ball that falls, under the sky.
fn busy(settings: RenderSettings) -> Scene {
    let heights = Procedural::Fbm { octaves: 4, seed: 3 };
    let heights = heights.height_map([32, 32], Lattice::Vertex, Wrap::Clamp).unwrap();
    let displacement = Displacement { scale: 0.3, ..Displacement::default() };
    let options = FaceOptions { displacement, closed: true, ..FaceOptions::default() };
    let corners = [-X - Y, X - Y, X + Y, Y - X];
    let face = ReliefFace::new(corners, Arc::new(Relief::new(heights)), options).unwrap();
    let turn = Motion { angle: 1.2, axis: X + Z, ..Motion::along(0.2 * Z) };
    let ball = Sphere::new(DVec3::new(0.3, -0.4, 0.9), 0.3).unwrap();
    Builder::default()
        .surface(moving(face, turn), diffuse(1.0))
        .surface(moving(ball, Motion::along(-0.4 * Z)), diffuse(1.0))
        .background(Rgb::ONE)
        .scene(camera([1.0, -3.5, 1.8], [0.0, 0.0, 0.2], 38.0, [40, 35]), settings)
}

#[test]
fn a_white_furnace_stays_white() {
    let settings = RenderSettings { max_depth: 256, ..settings(Integrator::Path, 64) };
    let film = picture(&busy(settings), &[]);
    let mean: f64 = film.radiance().iter().map(|rgb| f64::from(rgb[0])).sum::<f64>() / 1400.0;
    assert!((mean - 1.0).abs() < 0.003, "{mean}");
}

#[test]
fn threads_parts_and_packets_leave_the_same_bytes() {
    for integrator in [Integrator::Path, Integrator::Distributed, Integrator::Aov] {
        let scene = busy(settings(integrator, 12));
        let run = |options: RenderOptions<'_>| render(&scene, &options).unwrap().0;
        let default = RenderOptions::default;
        let whole = run(RenderOptions { threads: 1, ..default() });
        let bits = |film: &Film| film.radiance().iter().flatten().map(|x| x.to_bits()).collect();
        let (same, other): (Vec<u32>, Vec<u32>) =
            (bits(&whole), bits(&run(RenderOptions { threads: 3, ..default() })));
        assert!(same == other, "{integrator} by threads");
        // Rays whose work is counted go one by one.
        let alone: Vec<u32> = bits(&run(RenderOptions { aovs: &[Aov::Steps], ..default() }));
        assert!(same == alone, "{integrator} one by one");
        let halves = [[0, 17], [17, 35]].map(|[first, end]| {
            let crop = Some(Tile { corner: [0, first], size: [40, end - first] });
            run(RenderOptions { crop, ..default() })
        });
        let joined: Vec<u32> = bits(&join(halves.to_vec()).unwrap());
        assert!(same == joined, "{integrator} by windows");
        if integrator.sums() {
            let ranges = [[0, 5], [5, 12]]
                .map(|range| run(RenderOptions { samples: Some(range), ..default() }));
            let joined: Vec<u32> = bits(&join(ranges.to_vec()).unwrap());
            assert!(same == joined, "{integrator} by samples");
        }
    }
}
