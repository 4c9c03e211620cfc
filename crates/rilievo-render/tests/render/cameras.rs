//! Lenses and motion in a whole render.

use std::sync::Arc;

use glam::DVec3;
use rilievo::map::{Lattice, Procedural, Wrap};
use rilievo::relief::{Displacement, FaceOptions, Relief, ReliefFace};
use rilievo::surface::{Quad, Surface, World};
use rilievo_render::{
    Aov, Camera, Film, Lens, Pose, Projection, RenderOptions, RenderSettings, Rgb, Scene,
    SceneParts, render,
};

use crate::scenes::{camera, diffuse, emitter, lamp};

fn scene(world: Vec<Surface>, camera: Camera, samples: u32) -> Scene {
    let material_of = (0..world.len() as u32).collect();
    let mut materials = vec![diffuse(0.5); world.len()];
    *materials.last_mut().unwrap() = emitter(Rgb::ONE);
    Scene::new(SceneParts {
        world: World::new(world),
        materials,
        material_of,
        camera,
        background: Rgb::ZERO,
        ambient: Rgb::splat(0.2),
        settings: RenderSettings { samples, ..RenderSettings::default() },
    })
    .unwrap()
}

fn film(scene: &Scene, aovs: &[Aov]) -> Film {
    render(scene, &RenderOptions { aovs, ..RenderOptions::default() }).unwrap().0
}

#[test]
fn rays_of_a_lens_and_a_moving_camera_find_the_same_in_packets_and_alone() {
    let codes = Procedural::Fbm { octaves: 5, seed: 3 };
    let heights = codes.height_map([64, 64], Lattice::Vertex, Wrap::Clamp).unwrap();
    let options = FaceOptions {
        displacement: Displacement { scale: 0.3, ..Displacement::default() },
        ..FaceOptions::default()
    };
    let [x, y, _] = DVec3::AXES;
    let corners = [DVec3::ZERO, x, x + y, y];
    let face = ReliefFace::new(corners, Arc::new(Relief::new(heights)), options).unwrap();
    let world = || vec![Surface::Face(Box::new(face.clone())), lamp([0.2, -0.5, 1.5], 0.6)];
    let still = Camera::new(camera([0.5, -0.9, 0.9], [0.5, 0.5, 0.1], 45.0, [48, 40])).unwrap();
    let lens = Lens { radius: 0.2, focus_distance: 1.3, blades: 5, rotation: 0.3 };
    let end = Pose {
        position: DVec3::new(0.7, -0.9, 0.7),
        look_at: DVec3::new(0.5, 0.5, 0.1),
        up: DVec3::Z,
    };
    let camera = still.with_lens(lens).unwrap().with_motion(end, [0.0, 1.0]).unwrap();
    let scene = scene(world(), camera, 16);
    // Rays whose work is counted go one by one.
    let alone = film(&scene, &[Aov::Steps]);
    assert_eq!(film(&scene, &[]).radiance(), alone.radiance());
    assert!(alone.radiance().iter().any(|rgb| rgb[0] > 0.0));
}

#[test]
fn a_moving_camera_sees_each_thing_for_its_share_of_the_time() {
    // A wall that shines where x < 0, seen from a camera that goes from x = -1 to x = 1.
    let [x, _, z] = DVec3::AXES;
    let wall = [-9.0 * x - 9.0 * z, -9.0 * z, 9.0 * z, -9.0 * x + 9.0 * z];
    let world = || vec![Surface::Quad(Quad::new(wall, false).unwrap())];
    let parts = camera([-1.0, -3.0, 0.0], [-1.0, 0.0, 0.0], 40.0, [2, 2]);
    let still = Camera::new(parts).unwrap();
    let still = still.with_projection(Projection::Orthographic { height: 1e-3 }).unwrap();
    let end = Pose { position: DVec3::new(1.0, -3.0, 0.0), look_at: x, up: z };
    for (shutter, share) in
        [([0.0, 1.0], 0.5), ([0.25, 0.75], 0.5), ([0.0, 0.5], 1.0), ([0.4, 0.8], 0.25)]
    {
        let camera = still.with_motion(end, shutter).unwrap();
        let seen = film(&scene(world(), camera, 256), &[]).radiance()[0][0];
        assert!((f64::from(seen) - share).abs() < 0.02, "{shutter:?}: {seen}");
    }
}

#[test]
fn a_lens_spreads_an_edge_over_its_circle_of_confusion() {
    // The same wall at rest, twice as far away as what is in focus: of each point of the image the
    // lens sees a disk of its own size, so the edge at x = 0 becomes a ramp from -r to r.
    let [x, _, z] = DVec3::AXES;
    let wall = [-9.0 * x - 9.0 * z, -9.0 * z, 9.0 * z, -9.0 * x + 9.0 * z];
    let world = || vec![Surface::Quad(Quad::new(wall, false).unwrap())];
    let lens = Lens { radius: 0.5, focus_distance: 1.0, blades: 0, rotation: 0.0 };
    for (at, share) in [(-0.6, 1.0), (0.0, 0.5), (0.25, 0.1955), (0.6, 0.0)] {
        let parts = camera([at, -2.0, 0.0], [at, 0.0, 0.0], 0.01, [2, 2]);
        let camera = Camera::new(parts).unwrap().with_lens(lens).unwrap();
        let seen = film(&scene(world(), camera, 1024), &[]).radiance()[0][0];
        assert!((f64::from(seen) - share).abs() < 0.01, "{at}: {seen}");
    }
}
