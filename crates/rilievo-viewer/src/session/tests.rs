//! Sessions without a window.

use super::*;

const SCENE: &str = r#"# A comment that stays.
[camera]
position = [0.5, -1, 1] # here
look_at = [0.5, 0.5, 0]

[maps.m]
procedural = "gaussian"
size = [32, 32]

[materials.clay]
diffuse = [0.6, 0.5, 0.4]

[[shapes]]
type = "quad"
corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
material = "clay"
displacement = { map = "m", scale = 0.1 } # relief

[[shapes]]
type = "sphere"
center = [0, 0, 1]
radius = 0.2

[[shapes]]
type = "quad"
corners = [[0, 0, 2], [1, 0, 2], [1, 1, 2], [0, 1, 2]]
[shapes.displacement]
map = "m"
"#;

fn session() -> Session {
    let file = SceneFile::parse(SCENE, Path::new("dir/scene.toml")).unwrap();
    Session::new(&file, false, None)
}

#[test]
fn displaced_shapes_are_found_however_they_are_written() {
    let session = session();
    let found: Vec<_> = session.shapes.iter().map(|s| (s.index, s.map.as_str())).collect();
    assert_eq!(found, [(0, "m"), (2, "m")]);
    assert_eq!(session.shapes[1].name, "quad 3");
}

#[test]
fn edits_change_their_keys_and_nothing_else() {
    let mut session = session();
    session.together = false;
    assert_eq!(session.apply(Action::Depth(0.25)), Change::Scene);
    let expected = SCENE.replace("scale = 0.1 }", "scale = 0.25 }");
    assert_eq!(session.document().text(), expected);
    session.together = true;
    session.apply(Action::Depth(0.5));
    let text = session.document().text();
    assert_eq!(text.matches("scale = 0.5").count(), 2, "{text}");
    assert!(session.document().parse().is_ok(), "{text}");
}

#[test]
fn a_drag_is_one_step_and_can_be_taken_back_and_done_again() {
    let mut session = session();
    let start = session.document().text();
    for k in 1..9 {
        session.apply(Action::Depth(0.1 * f64::from(k)));
    }
    session.settle();
    session.apply(Action::Zero(0.5));
    let end = session.document().text();
    assert!(matches!(session.undo(), Some(Step::Text(_))));
    assert!(matches!(session.undo(), Some(Step::Text(_))));
    assert!(session.undo().is_none());
    // The camera is where one looks now, written in full.
    let camera = |text: &str| text.split("[maps").nth(1).unwrap().to_owned();
    assert_eq!(camera(&session.document().text()), camera(&start));
    session.redo();
    session.redo();
    assert_eq!(camera(&session.document().text()), camera(&end));
}

#[test]
fn numbers_that_no_relief_can_have_are_not_taken() {
    let mut session = session();
    for action in [Action::Depth(0.0), Action::Depth(f64::NAN), Action::Tile([0.0, 1.0])] {
        assert_eq!(session.apply(action), Change::None);
    }
    assert_eq!(session.document().text(), SCENE);
}

#[test]
fn every_action_leaves_a_scene_that_can_be_read() {
    let camera = CameraParts { position: DVec3::ONE, ..session().camera };
    for action in [
        Action::Zero(0.5),
        Action::Tile([2.0, 3.0]),
        Action::Roughness(0.7),
        Action::Sun(Sun::default()),
        Action::Camera(camera),
        Action::Method(Method::Dda),
        Action::Layout(Layout::Tiny),
        Action::Integrator(rilievo_render::Integrator::Path),
        Action::Samples(64),
        Action::Exposure(-1.5),
        Action::View(rilievo_render::film::tonemap::View::AgX),
    ] {
        let mut session = session();
        assert_ne!(session.apply(action.clone()), Change::None, "{action:?}");
        let text = session.document().text();
        assert_ne!(text, SCENE, "{action:?}");
        if let Err(e) = session.document().parse() {
            panic!("{action:?}: {e}\n{text}");
        }
        assert!(text.starts_with("# A comment that stays."));
    }
}

#[test]
fn presets_lay_the_map_of_a_bare_scene_on_other_shapes() {
    let text = "[camera]\nposition = [0.5, -1, 1]\nlook_at = [0.5, 0.5, 0]\n[maps.map]\nfile = \"a.png\"\n\
                [materials.lamp]\nemitted = [1, 1, 1]\n[[shapes]]\ntype = \"quad\"\n\
                corners = [[0, 0, 0], [1, 0, 0], [1, 0.5, 0], [0, 0.5, 0]]\n\
                displacement = { map = \"map\", scale = 0.05, zero = 0.5 }\n\
                [[shapes]]\ntype = \"quad\"\ncorners = [[0, 0, 2], [1, 0, 2], [1, 1, 2], [0, 1, 2]]\nmaterial = \"lamp\"\n";
    let file = SceneFile::parse(text, Path::new("presentation.toml")).unwrap();
    let mut session = Session::new(&file, true, None);
    assert_eq!(session.shapes.len(), 1);
    assert!(session.document().sun().is_some());
    for (preset, shapes) in [(Preset::Sphere, 1), (Preset::Cube, 6), (Preset::Plane, 1)] {
        assert_eq!(session.apply(Action::Preset(preset)), Change::Scene);
        assert_eq!(session.shapes.len(), shapes, "{preset:?}");
        session.document().parse().unwrap();
        let text = session.document().text();
        assert_eq!(text.matches("scale = 0.05").count(), shapes, "{text}");
    }
    assert_eq!(session.apply(Action::Preset(Preset::Mesh)), Change::None);
    session.mesh = Some("model.obj".into());
    assert_eq!(session.apply(Action::Preset(Preset::Mesh)), Change::Scene);
    session.document().parse().unwrap();
}

#[test]
fn a_sun_is_edited_however_lights_are_written() {
    let sun = Sun { azimuth: 30.0, elevation: 45.0, ..Sun::default() };
    let inline = "lights = [{ type = \"point\", position = [0, 0, 3], intensity = [1, 1, 1] }, \
                  { type = \"sun\", direction = [0, 0, -1], irradiance = [2, 2, 2] }] # lit\n";
    let without = "lights = [{ type = \"point\", position = [0, 0, 3], intensity = [1, 1, 1] }]\n";
    for lights in [inline, without, "lights = []\n", ""] {
        let text = format!("{lights}{SCENE}");
        let file = SceneFile::parse(&text, Path::new("dir/scene.toml")).unwrap();
        let mut session = Session::new(&file, false, None);
        assert_eq!(session.document().sun().is_some(), lights.contains("sun"), "{lights}");
        assert_eq!(session.apply(Action::Sun(sun)), Change::Scene);
        let now = session.document().sun().unwrap();
        assert!(
            (now.azimuth - 30.0).abs() < 1e-9 && (now.elevation - 45.0).abs() < 1e-9,
            "{now:?}"
        );
        let text = session.document().text();
        assert_eq!(text.matches("\"sun\"").count(), 1, "{text}");
        assert_eq!(text.matches("\"point\"").count(), lights.matches("\"point\"").count());
        assert_eq!(text.contains("# lit"), lights.contains("# lit"));
        session.document().parse().unwrap();
    }
}

#[test]
fn the_height_of_a_terrain_is_a_key_of_its_own() {
    let text = format!(
        "{SCENE}\n[[shapes]]\ntype = \"terrain\"\nmap = \"dem\"\n[maps.dem]\nfile = \"dem.tif\"\n"
    );
    let file = SceneFile::parse(&text, Path::new("dir/scene.toml")).unwrap();
    let mut session = Session::new(&file, false, None);
    session.selected = 2;
    assert!(session.shape().unwrap().terrain);
    let index = session.shape().unwrap().index;
    assert_eq!(session.document().exaggeration(index), 1.0);
    assert_eq!(session.apply(Action::Exaggeration(0.0)), Change::None);
    assert_eq!(session.apply(Action::Exaggeration(2.5)), Change::Scene);
    assert_eq!(session.document().exaggeration(index), 2.5);
    session.document().parse().unwrap();
}

#[test]
fn a_scene_that_moves_names_its_files_as_seen_from_its_new_folder() {
    // A map named as a file is, and a folder of a texture set named as a map is.
    let text = SCENE
        .replace("procedural = \"gaussian\"\nsize = [32, 32]", "file = \"a/m.png\" # the file")
        + "[[shapes]]\ntype = \"mesh\"\nfile = \"/models/spot.obj\"\ndisplacement = { map = \"m/\", scale = 0.1 }\n\
           [environment]\nfile = \"../sky.exr\"\n";
    let file = SceneFile::parse(&text, Path::new("/house/dir/scene.toml")).unwrap();
    let document = Document::of(&file);
    let moved = document.moved(Path::new("/house/other/deep/new.toml")).unwrap();
    let text = moved.text();
    for expected in [
        "file = \"../../dir/a/m.png\" # the file",
        "file = \"/models/spot.obj\"",
        "map = \"../../dir/m/\"",
        "file = \"../../sky.exr\"",
        "map = \"m\"",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    assert_eq!(moved.path(), Path::new("/house/other/deep/new.toml"));
    // In its folder nothing changes, whatever the name; and back again it is what it was.
    assert_eq!(document.moved(Path::new("/house/dir/./b.toml")).unwrap().text(), document.text());
    let back = moved.moved(Path::new("/house/dir/scene.toml")).unwrap();
    assert_eq!(back.text(), document.text());
    // What was done before it moved can be taken back where it is.
    let mut session = Session::new(&file, false, None);
    session.apply(Action::Exposure(1.0));
    session.saved(session.document().moved(Path::new("/house/other/deep/new.toml")).unwrap());
    assert!(!session.unsaved);
    session.undo();
    assert_eq!(session.document().path(), Path::new("/house/other/deep/new.toml"));
    assert!(session.document().text().contains("\"../../dir/a/m.png\""));
}
