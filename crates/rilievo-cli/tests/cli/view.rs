//! `rilievo view` starts another program, or says how to get it.

use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

const COMMAND: &str = env!("CARGO_BIN_EXE_rilievo");

/// A folder on the file system of the command. Links need no file to be written: one that another
/// thread's child holds open could not be run.
fn folder() -> TempDir {
    tempfile::tempdir_in(Path::new(COMMAND).parent().unwrap()).unwrap()
}

/// The command under another name.
fn link(folder: &TempDir, name: &str) {
    let name = format!("{name}{}", std::env::consts::EXE_SUFFIX);
    std::fs::hard_link(COMMAND, folder.path().join(name)).unwrap();
}

/// `rilievo view` of a folder, which finds no other programs.
fn view(folder: &TempDir, arguments: &[&str]) -> Output {
    let command = folder.path().join(format!("rilievo{}", std::env::consts::EXE_SUFFIX));
    let mut command = Command::new(command);
    command.arg("view").args(arguments).env("PATH", folder.path()).output().unwrap()
}

#[test]
fn without_the_viewer_it_says_how_to_get_it() {
    let folder = folder();
    link(&folder, "rilievo");
    let output = view(&folder, &["scene.toml"]);
    assert_eq!(output.status.code(), Some(1));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("cargo build --release -p rilievo-viewer"), "{told}");
}

#[test]
fn arguments_go_to_the_viewer_beside_it_and_its_exit_code_comes_back() {
    let folder = folder();
    link(&folder, "rilievo");
    // What stands in for the viewer tells its version, and refuses what is no subcommand.
    link(&folder, "rilievo-viewer");
    let output = view(&folder, &["--version"]);
    assert_eq!(output.status.code(), Some(0));
    let told = String::from_utf8(output.stdout).unwrap();
    assert_eq!(told.trim(), concat!("rilievo ", env!("CARGO_PKG_VERSION")));
    let output = view(&folder, &["a b.png", "--mesh", "m.obj"]);
    assert_eq!(output.status.code(), Some(2));
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("'a b.png'"), "{told}");
}
