//! What a scene accepts, and the lights it finds.

use glam::DVec3;
use rilievo::surface::{Quad, Sphere, Surface, World};
use rilievo_render::light::Light;
use rilievo_render::{
    Camera, Material, MaterialError, RenderSettings, Rgb, Scene, SceneError, SceneParts,
};

use crate::scenes::{camera, diffuse, emitter};

/// A quad and a sphere, both of material 0.
fn parts() -> SceneParts {
    let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
    SceneParts {
        world: World::new(vec![
            Surface::Quad(Quad::new(corners, false).unwrap()),
            Surface::Sphere(Sphere::new(DVec3::Z, 0.5).unwrap()),
        ]),
        materials: vec![diffuse(0.5)],
        material_of: vec![0, 0],
        camera: Camera::new(camera([0.0, -3.0, 1.0], [0.0; 3], 40.0, [8, 8])).unwrap(),
        background: Rgb::ZERO,
        ambient: Rgb::ZERO,
        settings: RenderSettings::default(),
    }
}

#[test]
fn parts_that_do_not_fit_are_refused() {
    assert!(Scene::new(parts()).is_ok());
    let refused = |parts| Scene::new(parts).unwrap_err();
    let short = SceneParts { material_of: vec![0], ..parts() };
    assert_eq!(refused(short), SceneError::MaterialCount { surfaces: 2, found: 1 });
    let wild = SceneParts { material_of: vec![0, 3], ..parts() };
    assert_eq!(refused(wild).to_string(), "surface 1 names material 3, but there are 1");
    let rough = Material { roughness: -1.0, ..diffuse(0.5) };
    let error = MaterialError::Roughness { found: -1.0 };
    let rough = SceneParts { materials: vec![rough], ..parts() };
    assert_eq!(refused(rough), SceneError::Material { index: 0, error });
    let dark = SceneParts { background: Rgb::splat(f64::NAN), ..parts() };
    assert!(matches!(refused(dark), SceneError::Radiance { part: "background", .. }));
    let none = RenderSettings { samples: 0, ..RenderSettings::default() };
    let none = SceneParts { settings: none, ..parts() };
    assert!(matches!(refused(none), SceneError::Settings(_)));
}

#[test]
fn emitting_quads_and_spheres_are_lights() {
    assert!(Scene::new(parts()).unwrap().lights().is_empty());
    let materials = vec![diffuse(0.5), emitter(Rgb::ONE)];
    let lit = |material_of| {
        let parts = SceneParts { materials: materials.clone(), material_of, ..parts() };
        let scene = Scene::new(parts).unwrap();
        scene.lights().iter().filter_map(Light::surface).collect::<Vec<u32>>()
    };
    assert_eq!(lit(vec![1, 1]), [0, 1]);
    assert_eq!(lit(vec![0, 1]), [1]);
    assert_eq!(lit(vec![1, 0]), [0]);
}
