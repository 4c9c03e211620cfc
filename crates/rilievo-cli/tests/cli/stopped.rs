//! Renders that are stopped: by a signal, by a time limit.

use rilievo_io::Limits;
use rilievo_io::image::{Attribute, ChannelImage};

use crate::support::Folder;

/// Takes minutes.
const SLOW: &str = "render scene.toml -o a.exr --resolution 256x256 --samples 4000 --json";

fn unfinished(folder: &Folder) {
    let image = ChannelImage::read(&folder.path("a.exr"), &Limits::default()).unwrap();
    assert_eq!((image.width, image.height), (256, 256));
    assert_eq!(image.attribute("rilievo/complete"), Some(&Attribute::Integer(0)));
    assert_eq!(folder.names(), ["a.exr", "map.png", "scene.toml"]);
}

#[test]
fn a_time_limit_saves_what_is_done_and_says_so() {
    let folder = Folder::new().with_scene();
    let run = folder.run(&format!("{SLOW} --time-limit 1")).expect(4);
    assert_eq!(run.json()["complete"].as_bool(), Some(false));
    unfinished(&folder);
    folder.run("render scene.toml -o a.exr --samples 1 --time-limit 1000").expect(0);
}

#[cfg(unix)]
#[test]
fn signals_save_what_is_done() {
    use std::process::{Command, Stdio};
    use std::time::Duration;

    for (signal, code) in [("-INT", 130), ("-TERM", 143)] {
        let folder = Folder::new().with_scene();
        let mut command = folder.command(SLOW);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(1500));
        let killed = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(killed.unwrap().success());
        let run = crate::support::Run::from(child.wait_with_output().unwrap()).expect(code);
        assert_eq!(run.json()["complete"].as_bool(), Some(false));
        unfinished(&folder);
    }
}

#[test]
fn nothing_rendered_harms_no_picture() {
    let folder = Folder::new().with_scene();
    folder.write("a.exr", "what was here before");
    let run = folder.run(&format!("{SLOW} --time-limit 0.001")).expect(4);
    assert!(run.stderr.contains("unchanged"), "{}", run.stderr);
    assert_eq!(folder.bytes("a.exr"), b"what was here before");
}
