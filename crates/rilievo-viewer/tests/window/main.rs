//! The window as a person meets it: opened, a slider dragged with the mouse, looked at, painted on, saved, closed.
//!
//! It needs the X server `Xvfb` and `xdotool`, and a graphics adapter, in software if there is no other. Where
//! one is missing that is told on stderr, and the test is skipped.

#![cfg(target_os = "linux")]

mod desk;
mod journal;
mod screen;

use std::path::Path;
use std::time::Duration;

use desk::Desk;
use screen::{bright, different};

/// A hill on a plate, seen from the side: bright in front of black.
const SCENE: &str = "[camera]\nposition = [0.5, -1.6, 0.3]\nlook_at = [0.5, 0.5, 0.2]\nfov = 40\nresolution = [64, 48]\n\
     [render]\nsamples = 4\nambient = [1, 1, 1]\n\
     [maps.hill]\nprocedural = \"gaussian\"\nsize = [64, 64]\n\
     [materials.chalk]\ndiffuse = [0.9, 0.9, 0.9]\n\
     [[shapes]]\ntype = \"quad\"\ncorners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]\n\
     material = \"chalk\"\ndisplacement = { map = \"hill\", scale = 0.1 }\n";

/// Until a window has answered.
const SOON: Duration = Duration::from_millis(1500);

/// The hill, in a file.
fn hill(folder: &Path) -> Vec<String> {
    std::fs::write(folder.join("scene.toml"), SCENE).unwrap();
    vec!["scene.toml".to_owned()]
}

/// The hill as it is seen before and after the slider of its depth is dragged.
fn grown(desk: &mut Desk) -> [Vec<[u8; 3]>; 2] {
    let before = desk.seen("picture");
    let seen = bright(&before);
    let share = seen as f64 / before.len() as f64;
    assert!((0.02..0.6).contains(&share), "a plate and a hill in front of black: {share}");
    let depth = desk.deepens();
    assert!(depth <= 0.25, "{depth}");
    let after = desk.picture();
    let grown = bright(&after) as f64 / seen as f64;
    assert!(grown > 1.1, "the hill takes {grown} times the pixels it took");
    assert!(before != after);
    [before, after]
}

#[test]
fn a_dragged_slider_changes_the_picture_alike_on_cpu_and_gpu() {
    let open = |backend: &str| {
        Desk::open(|folder| {
            let mut arguments = hill(folder);
            arguments.extend(["--backend".to_owned(), backend.to_owned()]);
            arguments
        })
    };
    let Some(mut desk) = open("cpu") else { return };
    assert_eq!(desk.journal.renders, "cpu");
    let by_cpu = grown(&mut desk);
    drop(desk);
    let Some(mut desk) = open("gpu") else { return };
    if let Err(why) = desk.journal.wait_for_gpu() {
        return desk::skip(&why);
    }
    let by_gpu = grown(&mut desk);
    assert_ne!(desk.journal.renders, "cpu");
    for (cpu, gpu) in by_cpu.iter().zip(&by_gpu) {
        let share = different(cpu, gpu);
        assert!(share < 0.01, "{share} of the pixels differ");
    }
}

#[test]
fn closing_asks_what_becomes_of_edits_and_saves_where_it_is_told() {
    let Some(mut desk) = Desk::open(|folder| {
        std::fs::create_dir(folder.join("elsewhere")).unwrap();
        hill(folder)
    }) else {
        return;
    };
    desk.deepens();
    desk.picture();
    desk.closes();
    std::thread::sleep(SOON);
    desk.clicks("go on");
    // The path of the scene is another one before it is saved.
    desk.clicks("Save");
    std::thread::sleep(SOON);
    desk.writes("scene path", "elsewhere/deep.toml");
    desk.closes();
    std::thread::sleep(SOON);
    desk.clicks("save and close");
    assert_eq!(desk.ended(), Some(0));
    let saved = std::fs::read_to_string(desk.folder().join("elsewhere/deep.toml")).unwrap();
    assert!(saved.contains("scale = 0.2"), "{saved}");
    let read = std::fs::read_to_string(desk.folder().join("scene.toml")).unwrap();
    assert_eq!(read, SCENE);
}

#[test]
fn without_edits_it_closes_at_once() {
    let Some(mut desk) = Desk::open(hill) else { return };
    desk.closes();
    assert_eq!(desk.ended(), Some(0));
}

#[test]
fn a_quick_hand_takes_hold_of_the_wipe() {
    let Some(mut desk) = Desk::open(|folder| {
        let mut arguments = hill(folder);
        arguments.extend(["--compare-method", "dda", "--backend", "cpu"].map(str::to_owned));
        arguments
    }) else {
        return;
    };
    let before = desk.seen("picture");
    let [x, y] = desk.middle("wipe");
    let [left, _, width, _] = desk.journal.widgets["picture"];
    let to = left + width * 9 / 10;
    assert!(to - x > 100, "{x} to {to}");
    desk.drags([x, y], [to, y], |_| ());
    std::thread::sleep(SOON);
    desk.journal.catch_up();
    assert!((desk.middle("wipe")[0] - to).abs() <= 2, "{} {to}", desk.middle("wipe")[0]);
    // Nothing but the line has moved.
    let share = different(&before, &desk.seen("picture"));
    assert!(share < 0.03, "{share}");
}
