//! Textures beyond `texture_memory`: the same picture, and nothing left of the temporary file.

use rilievo_io::image::write_png_rgb8;

use crate::support::Folder;

const SCENE: &str = "[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\n\
    [render]\nintegrator = \"path\"\nbackground = [1, 1, 1]\n\
    [materials.board]\ntexture = \"board.png\"\n\
    [[shapes]]\ntype = \"quad\"\nmaterial = \"board\"\n\
    corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]\n";

/// A scene with a texture of 4 MiB, as it is and held to one, and an empty folder `tmp`.
fn folder() -> Folder {
    let folder = Folder::new();
    let texel = |k: u32| [k, k >> 3, k >> 10].map(|x| (x.wrapping_mul(59) & 255) as u8);
    let texels: Vec<_> = (0..1 << 20).map(texel).collect();
    write_png_rgb8(&folder.path("board.png"), [1024; 2], &texels).unwrap();
    folder.write("whole.toml", SCENE);
    folder.write("held.toml", &SCENE.replace("[render]", "[render]\ntexture_memory = 1"));
    std::fs::create_dir(folder.path("tmp")).unwrap();
    folder
}

fn left(folder: &Folder) -> usize {
    std::fs::read_dir(folder.path("tmp")).unwrap().count()
}

#[test]
fn the_picture_is_the_same_and_the_file_goes() {
    let folder = folder();
    let flags = "--resolution 40x40 --samples 3 --quiet";
    folder.run(&format!("render whole.toml -o whole.exr {flags}")).expect(0);
    for threads in [1, 3] {
        let words = format!("render held.toml -o held.exr {flags} --threads {threads}");
        let mut command = folder.command(&words);
        let run = command.env("TMPDIR", folder.path("tmp")).output().unwrap();
        crate::support::Run::from(run).expect(0);
        let same = folder.run("diff whole.exr held.exr");
        assert_eq!(same.code, Some(0), "{}{}", same.stdout, same.stderr);
        assert_eq!(left(&folder), 0);
    }
}

#[cfg(unix)]
#[test]
fn a_stopped_or_killed_render_leaves_no_file() {
    use std::process::{Command, Stdio};
    use std::time::Duration;

    for signal in ["-INT", "-KILL"] {
        let folder = folder();
        let words = "render held.toml -o a.exr --resolution 256x256 --samples 4000";
        let mut command = folder.command(words);
        command.env("TMPDIR", folder.path("tmp")).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().unwrap();
        std::thread::sleep(Duration::from_millis(1500));
        let killed = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(killed.unwrap().success());
        let said = child.wait_with_output().unwrap().stderr;
        let said = String::from_utf8(said).unwrap();
        assert!(said.contains("do not fit texture_memory = 1"), "{said}");
        assert_eq!(left(&folder), 0);
    }
}

#[cfg(unix)]
#[test]
fn a_folder_that_is_not_there_is_named() {
    let folder = folder();
    let mut command = folder.command("render held.toml -o a.exr --resolution 8x8");
    let run = command.env("TMPDIR", folder.path("nowhere")).output().unwrap();
    let run = crate::support::Run::from(run).expect(1);
    assert!(run.stderr.contains("nowhere"), "{}", run.stderr);
    assert!(run.stderr.contains("held.toml"), "{}", run.stderr);
}
