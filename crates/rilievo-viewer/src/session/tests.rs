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
