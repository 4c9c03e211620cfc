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
    studio.paint(Some(shown), &[touch, touch], &mut Vec::new()).unwrap();
    let painted = load(&studio, &session);
    // Nothing was copied: the heights lie where they lay.
    assert_eq!(Arc::as_ptr(painted.relief(0).unwrap()), address);
    assert!(rendered(&painted) != before.0);
    let higher = painted.pick(DVec2::new(0.5, 0.5)).unwrap();
    assert!(higher.position.z > pick.position.z, "{higher:?}");
    studio.paint(Some(painted), &[Painting::Swap(1)], &mut Vec::new()).unwrap();
    let back = load(&studio, &session);
    let after = (rendered(&back), format!("{:?}", back.relief(0).unwrap().heights()));
    assert!(after == before);
    assert_eq!(
        studio.paint(Some(back), &[Painting::Swap(9)], &mut Vec::new()),
        Err(PaintError::Forgotten)
    );
}

#[test]
fn spheres_are_painted_where_the_brush_is() {
    // A map that repeats, moved, and a sphere that no other shape lends its map.
    let sphere = scene_text(STUDS)
        .replace(
            "type = \"quad\"\ncorners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]",
            "type = \"sphere\"\ncenter = [0.5, 0.5, 0]\nradius = 0.4",
        )
        .replace("scale = 0.1", "scale = 0.1, tile = [2, 1.5], shift = [0.3, 0.2]");
    let mut studio = Studio::default();
    let session = session(&sphere, Path::new("scene.toml"));
    let shown = load(&studio, &session);
    let before = (rendered(&shown), format!("{:?}", shown.relief(0).unwrap().heights()));
    assert!(shown.histogram(0).is_some());
    let at = DVec2::new(0.45, 0.4);
    let pick = shown.pick(at).unwrap();
    let (place, size) = pick.map.unwrap();
    assert_eq!(size, [64, 64]);
    let dab = Dab { tool: Tool::Raise, at: place, radius: 5.0, strength: 0.5 };
    let touch = Painting::Touch(Touch { stroke: 1, surface: pick.surface, dab });
    studio.paint(Some(shown), &[touch], &mut Vec::new()).unwrap();
    let painted = load(&studio, &session);
    assert!(rendered(&painted) != before.0);
    let higher = painted.pick(at).unwrap();
    assert!(higher.height > pick.height + 0.3, "{} {}", higher.height, pick.height);
    studio.paint(Some(painted), &[Painting::Swap(1)], &mut Vec::new()).unwrap();
    let back = load(&studio, &session);
    assert!((rendered(&back), format!("{:?}", back.relief(0).unwrap().heights())) == before);
}

#[test]
fn meshes_are_painted_where_the_brush_is() {
    let dir = tempfile::tempdir().unwrap();
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
               f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
    std::fs::write(dir.path().join("plate.obj"), obj).unwrap();
    let mesh = scene_text(STUDS).replace(
        "type = \"quad\"\ncorners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]",
        "type = \"mesh\"\nfile = \"plate.obj\"",
    );
    let mut studio = Studio::default();
    let session = session(&mesh, &dir.path().join("scene.toml"));
    let shown = load(&studio, &session);
    let pick = shown.pick(DVec2::splat(0.5)).unwrap();
    let dab = Dab { tool: Tool::Raise, at: pick.map.unwrap().0, radius: 9.0, strength: 0.6 };
    let touch = Painting::Touch(Touch { stroke: 1, surface: pick.surface, dab });
    let mut edits = Vec::new();
    studio.paint(Some(shown), &[touch], &mut edits).unwrap();
    assert_eq!(edits.len(), 1);
    let higher = load(&studio, &session).pick(DVec2::splat(0.5)).unwrap();
    assert!(higher.position.z > pick.position.z + 0.003, "{higher:?} {pick:?}");
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
    studio
        .paint(
            Some(shown),
            &[Painting::Touch(Touch { stroke: 1, surface: 0, dab })],
            &mut Vec::new(),
        )
        .unwrap();
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
fn a_painted_terrain_is_saved_as_the_quad_that_it_is() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    let rows: Vec<String> = (0..12)
        .map(|j| {
            (0..12)
                .map(|i| format!("{}", 500 + (i * 37 + j * 91) % 60))
                .collect::<Vec<_>>()
                .join(" ")
        })
        .collect();
    let head = "ncols 12\nnrows 12\nxllcorner 0\nyllcorner 0\ncellsize 30\n";
    std::fs::write(path("dem.asc"), format!("{head}{}\n", rows.join("\n"))).unwrap();
    let text = "[camera]\nposition = [0, -0.5, 0.4]\nlook_at = [0, 0, 0]\nresolution = [40, 30]\n\
                [render]\nsamples = 1\n[maps.dem]\nfile = \"dem.asc\"\n\
                [[shapes]]\ntype = \"terrain\"\nmap = \"dem\"\nunit = 1000\nexaggeration = 2\nclosed = true\n";
    let mut studio = Studio::default();
    let mut session = session(text, &path("scene.toml"));
    let shown = load(&studio, &session);
    let depth = shown.facts().displacements[0].1.scale;
    session.learn(&shown.facts());
    session.apply(Action::Exaggeration(3.0));
    let shown = load(&studio, &session);
    session.learn(&shown.facts());
    let deeper = shown.facts().displacements[0].1.scale;
    assert!((deeper / depth - 1.5).abs() < 1e-12, "{depth} {deeper}");
    let dab = Dab { tool: Tool::Raise, at: DVec2::splat(0.4), radius: 4.0, strength: 0.9 };
    let touch = Painting::Touch(Touch { stroke: 1, surface: 0, dab });
    studio.paint(Some(shown), &[touch], &mut Vec::new()).unwrap();
    let painted = load(&studio, &session);
    let meaning = save::map(&path("painted.png"), painted.relief(0).unwrap().heights()).unwrap();
    session.take_map(Path::new("painted.png"), meaning);
    let text = session.document().text();
    assert!(!text.contains("terrain") && text.contains("closed = true"), "{text}");
    save::scene(&path("saved.toml"), &text).unwrap();
    let file = SceneFile::read(&path("saved.toml"), &Limits::default()).unwrap();
    let saved = Studio::default().load(&file, None).unwrap();
    for at in [[0.5, 0.5], [0.4, 0.6], [0.6, 0.45], [0.5, 0.7]].map(DVec2::from) {
        let [one, other] = [&painted, &saved].map(|shown| shown.pick(at).unwrap().position);
        assert!((one - other).length() < 1e-4, "{one} {other}");
    }
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
