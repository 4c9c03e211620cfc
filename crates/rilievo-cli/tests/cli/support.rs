//! Runs the command in a folder of its own.

use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use rilievo::map::{Lattice, Procedural, Samples, Wrap};
use rilievo_io::image::write_png_grey16;
use serde_json::Value;

/// A folder that goes away with its test.
pub struct Folder(tempfile::TempDir);

/// What a run left.
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Self {
            code: output.status.code(),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }
}

impl Run {
    /// The run ended with `code` and neither panicked nor said more than one error.
    #[track_caller]
    pub fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{}", self.stderr);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        let errors = self.stderr.lines().filter(|line| line.starts_with("error: ")).count();
        assert_eq!(errors, usize::from(code == 1 || code == 2), "{}", self.stderr);
        self
    }

    /// The last line of standard output.
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_str(self.stdout.lines().next_back().unwrap()).unwrap()
    }
}

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    /// Names of everything in the folder, hidden files too.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> =
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The command with words parted by spaces, ready to be run in the folder.
    pub fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rilievo"));
        command.current_dir(self.0.path()).args(words.split_whitespace()).stdin(Stdio::null());
        command
    }

    pub fn run(&self, words: &str) -> Run {
        self.command(words).output().unwrap().into()
    }

    /// Writes `map.png`, 32 x 32 samples of noise that tile, and `scene.toml` that shows it.
    pub fn with_scene(self) -> Self {
        let noise = Procedural::Fbm { octaves: 3, seed: 1 };
        let map = noise.height_map([32, 32], Lattice::Texel, Wrap::Repeat).unwrap();
        let Samples::U16(codes) = map.samples() else { panic!("codes were asked for") };
        write_png_grey16(&self.path("map.png"), [32, 32], codes).unwrap();
        self.write("scene.toml", SCENE);
        self
    }
}

/// A relief with a glossy ball above it, under a lamp.
const SCENE: &str = r#"
[camera]
position   = [0.5, -1.4, 1.3]
look_at    = [0.5, 0.5, 0.0]
up         = [0, 0, 1]
fov        = 40.0
resolution = [48, 40]

[render]
samples = 4
shadow_samples = 2
glossy_samples = 2
diffuse_samples = 1

[maps.noise]
file = "map.png"

[materials.clay]
diffuse = [0.6, 0.5, 0.4]
[materials.ball]
diffuse = [0.1, 0.1, 0.1]
reflective = [0.5, 0.5, 0.5]
roughness = 0.2
[materials.lamp]
emitted = [8, 8, 8]

[[shapes]]
type = "quad"
corners = [[0,0,0], [1,0,0], [1,1,0], [0,1,0]]
material = "clay"
displacement = { map = "noise", scale = 0.2, zero = 0.5, tile = [2, 2] }

[[shapes]]
type = "sphere"
center = [0.5, 0.5, 0.4]
radius = 0.15
material = "ball"

[[shapes]]
type = "quad"
corners = [[0.2,0.2,2], [0.2,0.8,2], [0.8,0.8,2], [0.8,0.2,2]]
material = "lamp"
"#;
