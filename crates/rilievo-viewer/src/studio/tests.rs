//! Scenes that are edited, painted, saved and read again, without a window.

use super::*;
use crate::brush::Tool;
use crate::save;
use crate::session::{Action, Session};
use rilievo_render::{CameraParts, Film, RenderOptions};

fn scene_text(map: &str) -> String {
    format!(
        "[camera]\nposition = [0.5, -0.7, 0.9]\nlook_at = [0.5, 0.5, 0]\nresolution = [40, 30]\n\
         [render]\nsamples = 1\nshadow_samples = 1\nambient = [0.2, 0.2, 0.2]\n\
         [maps.m]\n{map}\n\
         [[lights]]\ntype = \"sun\"\ndirection = [1, 0.5, -0.6]\nirradiance = [3, 3, 3]\n\
         [[shapes]]\ntype = \"quad\"\ncorners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]\n\
         displacement = {{ map = \"m\", scale = 0.1 }}\n"
    )
}

const STUDS: &str = "procedural = \"studded\"\nsize = [64, 64]\nstuds = [3, 3]";

fn session(text: &str, path: &Path) -> Session {
    Session::new(&SceneFile::parse(text, path).unwrap(), false, None)
}

fn rendered(shown: &Shown) -> Film {
    let options = RenderOptions { threads: 1, ..RenderOptions::default() };
    rilievo_render::render(&shown.scene, &options).unwrap().0
}

fn load(studio: &Studio, session: &Session) -> Shown {
    studio.load(&session.document().parse().unwrap(), None).unwrap()
}

#[test]
fn depth_zero_and_tile_change_the_picture_over_the_same_pyramid() {
    let studio = Studio::default();
    let mut session = session(&scene_text(STUDS), Path::new("scene.toml"));
    let first = load(&studio, &session);
    session.learn(&first.facts());
    let relief = Arc::clone(first.relief(0).unwrap());
    let mut films = vec![rendered(&first)];
    for action in [Action::Depth(0.2), Action::Zero(0.5), Action::Tile([2.0, 2.0])] {
        session.apply(action.clone());
        let shown = load(&studio, &session);
        assert!(Arc::ptr_eq(shown.relief(0).unwrap(), &relief), "{action:?}");
        let facts = shown.facts();
        assert_eq!(facts.displacements[0].1, session.shapes[0].displacement, "{action:?}");
        let film = rendered(&shown);
        assert!(films.iter().all(|old| *old != film), "{action:?}");
        films.push(film);
    }
    // A higher relief hides more of what is behind it.
    let center = |scale: f64| {
        let mut other = self::session(&scene_text(STUDS), Path::new("scene.toml"));
        other.apply(Action::Depth(scale));
        load(&studio, &other).pick(DVec2::new(0.5, 0.4)).unwrap().position.z
    };
    assert!(center(0.2) > center(0.05));
}

#[test]
fn a_stroke_taken_back_gives_the_picture_and_the_bytes_of_before() {
    let mut studio = Studio::default();
    let session = session(&scene_text(STUDS), Path::new("scene.toml"));
    let shown = load(&studio, &session);
    let before = (rendered(&shown), format!("{:?}", shown.relief(0).unwrap().heights()));
    let address = Arc::as_ptr(shown.relief(0).unwrap());
    let pick = shown.pick(DVec2::new(0.5, 0.5)).unwrap();
    let (at, size) = pick.map.unwrap();
    assert_eq!(size, [64, 64]);
    let dab = Dab { tool: Tool::Raise, at, radius: 9.0, strength: 0.6 };
    let touch = Painting::Touch(Touch { stroke: 1, surface: pick.surface, dab });
    studio.paint(Some(shown), &[touch, touch]).unwrap();
    let painted = load(&studio, &session);
    // Nothing was copied: the heights lie where they lay.
    assert_eq!(Arc::as_ptr(painted.relief(0).unwrap()), address);
    assert!(rendered(&painted) != before.0);
    let higher = painted.pick(DVec2::new(0.5, 0.5)).unwrap();
    assert!(higher.position.z > pick.position.z, "{higher:?}");
    studio.paint(Some(painted), &[Painting::Swap(1)]).unwrap();
    let back = load(&studio, &session);
    let after = (rendered(&back), format!("{:?}", back.relief(0).unwrap().heights()));
    assert!(after == before);
    assert_eq!(studio.paint(Some(back), &[Painting::Swap(9)]), Err(PaintError::Forgotten));
}

#[test]
fn spheres_show_the_painted_map_and_cannot_be_painted() {
    let sphere = scene_text(STUDS).replace(
        "type = \"quad\"\ncorners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]",
        "type = \"sphere\"\ncenter = [0.5, 0.5, 0]\nradius = 0.4",
    );
    let mut studio = Studio::default();
    let on_sphere = session(&sphere, Path::new("scene.toml"));
    let on_plane = session(&scene_text(STUDS), Path::new("scene.toml"));
    let before = rendered(&load(&studio, &on_sphere));
    let dab = Dab { tool: Tool::Raise, at: DVec2::splat(0.5), radius: 30.0, strength: 2.0 };
    let touch = Painting::Touch(Touch { stroke: 1, surface: 0, dab });
    let shown = load(&studio, &on_sphere);
    assert_eq!(studio.paint(Some(shown), &[touch]), Err(PaintError::NoMap));
    let shown = load(&studio, &on_plane);
    studio.paint(Some(shown), &[touch]).unwrap();
    assert!(rendered(&load(&studio, &on_sphere)) != before);
}

#[test]
fn a_saved_scene_renders_to_the_same_bytes() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    let codes: Vec<u16> = (0..1024u32).map(|k| (k * 7919 % 60_000) as u16).collect();
    rilievo_io::image::write_png_grey16(&path("m.png"), [32, 32], &codes).unwrap();
    let text = scene_text("file = \"m.png\"");
    let mut studio = Studio::default();
    let mut session = session(&text, &path("scene.toml"));
    let shown = load(&studio, &session);
    session.learn(&shown.facts());
    let dab = Dab { tool: Tool::Smooth, at: DVec2::splat(0.4), radius: 9.0, strength: 0.9 };
    studio.paint(Some(shown), &[Painting::Touch(Touch { stroke: 1, surface: 0, dab })]).unwrap();
    session.apply(Action::Depth(0.137));
    let camera = CameraParts { fov: 33.0, ..session.camera };
    session.apply(Action::Camera(crate::navigation::orbit(camera, DVec2::new(0.3, 0.1))));
    let shown = load(&studio, &session);
    let (film, relief) = (rendered(&shown), shown.relief(0).unwrap());
    let meaning = save::map(&path("painted.png"), relief.heights()).unwrap();
    session.take_map(Path::new("painted.png"), meaning);
    save::scene(&path("saved.toml"), &session.document().text()).unwrap();
    // By what knows nothing of the viewer.
    let file = SceneFile::read(&path("saved.toml"), &Limits::default()).unwrap();
    let loaded = file.load(&LoadOptions::default()).unwrap();
    let options = RenderOptions { threads: 1, ..RenderOptions::default() };
    let (again, _) = rilievo_render::render(&loaded.scene, &options).unwrap();
    assert!(again == film);
    // And by the viewer, after it took the saved map.
    assert!(rendered(&load(&studio, &session)) == film);
}

#[test]
fn a_map_that_changes_on_the_disk_is_read_again() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("m.png");
    rilievo_io::image::write_png_grey16(&path, [2, 2], &[0, 1, 2, 3]).unwrap();
    let studio = Studio::default();
    let session = session(&scene_text("file = \"m.png\""), &dir.path().join("scene.toml"));
    let raw = |shown: &Shown| shown.relief(0).unwrap().heights().raw_range();
    assert_eq!(raw(&load(&studio, &session)), (0.0, 3.0));
    rilievo_io::image::write_png_grey16(&path, [3, 2], &[0, 1, 2, 3, 9, 9]).unwrap();
    assert_eq!(raw(&load(&studio, &session)), (0.0, 9.0));
}

#[test]
fn a_bare_map_is_shown_as_the_command_line_lays_it() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("m.png");
    let codes: Vec<u16> = (0..1024u32).map(|k| (k * 7919 % 60_000) as u16).collect();
    rilievo_io::image::write_png_grey16(&path, [32, 32], &codes).unwrap();
    let studio = Studio::default();
    let (file, bare) = studio.open(&path).unwrap();
    assert!(bare);
    let mut session = Session::new(&file, bare, None);
    let shown = load(&studio, &session);
    session.learn(&shown.facts());
    // The usual depth of a map that says nothing.
    let laid = session.shapes[0].displacement;
    assert_eq!((laid.scale, laid.zero), (0.05, 0.5));
    session.apply(Action::Preset(crate::session::Preset::Cube));
    let shown = load(&studio, &session);
    assert_eq!(shown.shape_of, [0, 1, 2, 3, 4, 5]);
    assert!(shown.pick(DVec2::splat(0.5)).is_some());
}
