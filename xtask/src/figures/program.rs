//! [`Program`]: the released `rilievo`, and what it reports.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use crate::say;

/// The released program.
pub struct Program {
    path: PathBuf,
}

/// How many threads a call may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Threads {
    /// One per processor.
    All,
    One,
}

/// What a call reported.
pub struct Report(Value);

impl Program {
    /// Builds the program from the sources at `root`.
    pub fn build(root: &Path) -> Result<Self, String> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let output = Command::new(cargo)
            .args(["build", "--release", "--locked", "--bin", "rilievo"])
            .arg("--message-format=json-render-diagnostics")
            .current_dir(root)
            .stderr(std::process::Stdio::inherit())
            .output()
            .map_err(|e| format!("cannot run cargo: {e}"))?;
        let text = String::from_utf8_lossy(&output.stdout);
        // Cargo says where it put the program; the folder may be anywhere.
        let messages = text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
        let path = messages.filter_map(|m| m["executable"].as_str().map(PathBuf::from)).next_back();
        path.filter(|_| output.status.success())
            .map(|path| Self { path })
            .ok_or_else(|| "the program does not build".to_owned())
    }

    /// Calls the program with `--json --quiet` and reads its object. Exit code 3, "unequal", is an
    /// answer like any other.
    pub fn call<A: AsRef<OsStr>>(&self, threads: Threads, words: &[A]) -> Result<Report, String> {
        let told: Vec<_> = words.iter().map(|w| w.as_ref().to_string_lossy()).collect();
        let told = told.join(" ");
        say(&format!("rilievo {told}"));
        let mut command = Command::new(&self.path);
        command.args(words).args(["--json", "--quiet"]);
        if threads == Threads::One {
            command.env("RAYON_NUM_THREADS", "1");
        }
        let output = command.output().map_err(|e| format!("rilievo {told}: {e}"))?;
        if !matches!(output.status.code(), Some(0 | 3)) {
            let why = String::from_utf8_lossy(&output.stderr).into_owned();
            return Err(format!("rilievo {told}: {}: {why}", output.status));
        }
        let text = String::from_utf8_lossy(&output.stdout);
        let value = text.lines().last().and_then(|line| serde_json::from_str(line).ok());
        value.map(Report).ok_or_else(|| format!("rilievo {told}: no JSON object"))
    }
}

impl Report {
    /// A number of the object.
    pub fn number(&self, key: &str) -> Result<f64, String> {
        self.0[key].as_f64().ok_or_else(|| format!("no number {key:?} in {}", self.0))
    }

    /// Samples along x and y of all maps of a scene, in words.
    pub fn map_sizes(&self) -> Result<String, String> {
        let all = ["sphere_maps", "maps"].map(|key| Some(self.0[key].as_array()?.iter()));
        let [Some(spheres), Some(others)] = all else {
            return Err(format!("no maps in {}", self.0));
        };
        let size =
            |map: &Value| Some(format!("{} x {}", map["width"].as_u64()?, map["height"].as_u64()?));
        let sizes: Option<Vec<_>> = spheres.chain(others).map(size).collect();
        sizes
            .map(|sizes| sizes.join(", "))
            .ok_or_else(|| format!("a map without size in {}", self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_name_what_they_lack() {
        let report = Report(serde_json::json!({ "pixels": 7, "peak_rss_bytes": null }));
        assert_eq!(report.number("pixels"), Ok(7.0));
        assert!(report.number("peak_rss_bytes").is_err_and(|why| why.contains("peak_rss_bytes")));
    }

    #[test]
    fn scenes_tell_the_sizes_of_their_maps() {
        let map = |side: u32| serde_json::json!([{ "width": side, "height": 2 * side }]);
        let report = Report(serde_json::json!({ "maps": map(3), "sphere_maps": map(5) }));
        assert_eq!(report.map_sizes(), Ok("5 x 10, 3 x 6".to_owned()));
        assert!(Report(serde_json::json!({ "maps": [] })).map_sizes().is_err());
    }

    #[test]
    fn a_program_that_cannot_run_is_an_error() {
        let program = Program { path: "no-such-program".into() };
        assert!(program.call(Threads::One, &["info"]).is_err());
    }
}
