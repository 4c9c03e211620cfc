//! `rilievo view` starts another program, or says how to get it.

use std::path::Path;
use std::process::Command;

/// A copy of the command in a folder without the viewer.
fn alone(folder: &Path) -> Command {
    let name = format!("rilievo{}", std::env::consts::EXE_SUFFIX);
    let copy = folder.join(name);
    std::fs::copy(env!("CARGO_BIN_EXE_rilievo"), &copy).unwrap();
    let mut command = Command::new(copy);
    command.env("PATH", folder);
    command
}

#[test]
fn without_the_viewer_it_says_how_to_get_it() {
    let folder = tempfile::tempdir().unwrap();
    let output = alone(folder.path()).args(["view", "scene.toml"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("cargo build --release -p rilievo-viewer"), "{told}");
}

#[cfg(unix)]
#[test]
fn arguments_go_to_the_viewer_beside_it_and_its_exit_code_comes_back() {
    use std::os::unix::fs::PermissionsExt;

    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join("rilievo-viewer");
    std::fs::write(&script, "#!/bin/sh\necho \"$@\"\nexit 7\n").unwrap();
    std::fs::set_permissions(&script, std::fs::Permissions::from_mode(0o755)).unwrap();
    for arguments in [["a b.png", "--mesh", "m.obj"], ["--help", "--threads", "2"]] {
        let output = alone(folder.path()).arg("view").args(arguments).output().unwrap();
        assert_eq!(output.status.code(), Some(7));
        let told = String::from_utf8(output.stdout).unwrap();
        assert_eq!(told.trim(), arguments.join(" "));
    }
}
