//! Renders that are killed: nothing can be done then, so what is on the disk must do.

use std::time::Duration;

use rilievo_io::Limits;
use rilievo_io::image::{Attribute, ChannelImage};

use crate::support::Folder;

/// Some tenths of a second; more where more is to be killed.
const RENDER: &str =
    "render scene.toml -o a.exr --integrator path --resolution 64x64 --checkpoint 0.02 --quiet";

/// Kills in the default suite. `RILIEVO_KILLS` asks for another number.
const KILLS: u32 = 10;

#[test]
fn a_killed_render_leaves_a_whole_picture_to_go_on_from() {
    let asked = std::env::var("RILIEVO_KILLS").ok().and_then(|n| n.parse().ok());
    let kills: u32 = asked.unwrap_or(KILLS);
    let folder = Folder::new().with_scene();
    // What a kill may leave: the old picture, or one of this render.
    folder.run("render scene.toml -o old.exr --samples 1").expect(0);
    let old = folder.bytes("old.exr");
    folder.run(&format!("{RENDER} --samples 200")).expect(0);
    let whole = folder.bytes("a.exr");
    let mut killed = 0;
    let mut random = 12345_u32;
    while killed < kills {
        std::fs::write(folder.path("a.exr"), &old).unwrap();
        loop {
            let bytes = folder.bytes("a.exr");
            let resume = if bytes == old { "" } else { "--resume" };
            let mut command = folder.command(&format!("{RENDER} --samples 200 {resume}"));
            let mut child = command.spawn().unwrap();
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            std::thread::sleep(Duration::from_millis(u64::from(random >> 24) * 2));
            let early = child.try_wait().unwrap();
            child.kill().unwrap();
            let status = child.wait().unwrap();
            let image = ChannelImage::read(&folder.path("a.exr"), &Limits::default());
            let image = image.unwrap_or_else(|why| panic!("after {killed} kills: {why}"));
            let complete = image.attribute("rilievo/complete") == Some(&Attribute::Integer(1));
            let untouched = folder.bytes("a.exr") == old;
            if complete && !untouched {
                assert!(folder.bytes("a.exr") == whole, "after {killed} kills");
            }
            if early.is_some() {
                assert!(status.success() && complete && !untouched);
                break;
            }
            killed += 1;
            if killed == kills {
                let resume = if untouched { "" } else { "--resume" };
                folder.run(&format!("{RENDER} --samples 200 {resume}")).expect(0);
                break;
            }
        }
        assert!(folder.bytes("a.exr") == whole, "after {killed} kills");
        // What was being written is gone.
        let left: Vec<_> =
            folder.names().into_iter().filter(|name| name.ends_with(".part")).collect();
        assert!(left.is_empty(), "{left:?}");
    }
}
