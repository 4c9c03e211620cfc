//! [`Run`]: a folder of recorded lines.
//!
//! A run is a folder such as `bench/runs/2026-11-22-epyc` with files of JSON lines; which file a line
//! stands in does not matter, its key `bench` says what it is. Lines of other programs are passed
//! over. Where a figure was recorded several times its median counts.

mod comparison;
mod machine;
mod summary;

use std::fs;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::{builds, kernels};

pub use comparison::Comparison;
pub use machine::machine;
pub use summary::summary;

/// The lines of a run that this program knows.
#[derive(Debug, Default)]
pub struct Run {
    pub kernels: Vec<kernels::Record>,
    pub builds: Vec<builds::Record>,
    pub transforms: Vec<Transform>,
}

/// What is shown of a distance transform, ours or a peer's.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
pub struct Transform {
    pub grid: String,
    pub contender: String,
    pub ns_per_voxel: f64,
}

impl Run {
    /// Reads all `.jsonl` files of `folder`.
    ///
    /// # Errors
    /// A folder or file that cannot be read, or a line of ours that lacks a key.
    pub fn read(folder: &Path) -> Result<Self, String> {
        let told = |e: std::io::Error| format!("{}: {e}", folder.display());
        let mut paths = Vec::new();
        for entry in fs::read_dir(folder).map_err(told)? {
            paths.push(entry.map_err(told)?.path());
        }
        paths.retain(|path| path.extension().is_some_and(|end| end == "jsonl"));
        paths.sort();
        let mut run = Self::default();
        for path in paths {
            let text = fs::read_to_string(&path).map_err(told)?;
            for (index, line) in text.lines().enumerate() {
                let place = || format!("{}:{}", path.display(), index + 1);
                run.take(line).map_err(|e| format!("{}: {e}", place()))?;
            }
        }
        run.kernels = medians(run.kernels);
        Ok(run)
    }

    fn take(&mut self, line: &str) -> Result<(), String> {
        if line.trim().is_empty() {
            return Ok(());
        }
        let value: Value = serde_json::from_str(line).map_err(|e| e.to_string())?;
        match value["bench"].as_str() {
            Some("kernels") => self.kernels.push(typed(value)?),
            Some("build") => self.builds.push(typed(value)?),
            Some("transforms") => self.transforms.push(typed(value)?),
            _ => {}
        }
        Ok(())
    }

    #[cfg(test)]
    pub fn of_lines(lines: &[String]) -> Result<Self, String> {
        let mut run = Self::default();
        lines.iter().try_for_each(|line| run.take(line))?;
        run.kernels = medians(run.kernels);
        Ok(run)
    }
}

fn typed<T: DeserializeOwned>(value: Value) -> Result<T, String> {
    serde_json::from_value(value).map_err(|e| e.to_string())
}

/// One record a row and contender, with the median of the rates recorded for it.
fn medians(records: Vec<kernels::Record>) -> Vec<kernels::Record> {
    let mut kept: Vec<(kernels::Record, Vec<f64>)> = Vec::new();
    for record in records {
        match kept.iter_mut().find(|(first, _)| first.is_same_row(&record)) {
            Some((_, rates)) => rates.push(record.mrays_per_s),
            None => {
                let rates = vec![record.mrays_per_s];
                kept.push((record, rates));
            }
        }
    }
    let settle = |(mut record, rates): (kernels::Record, Vec<f64>)| {
        record.mrays_per_s = crate::measure::Passes::of(rates).median;
        record
    };
    kept.into_iter().map(settle).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::example;
    use crate::rays::Family;

    fn line(rate: f64) -> String {
        let record = example("embree-grid", Family::Primary, false, rate);
        serde_json::to_string(&record).unwrap()
    }

    #[test]
    fn lines_are_sorted_by_kind_and_repeated_figures_settle_on_their_median() {
        let transform = r#"{"bench":"transforms","contender":"edt","grid":"fbm-24x8",
            "ns_per_voxel":9.5,"free":0.5}"#
            .replace('\n', "");
        let frame = r#"{"bench":"frames","peer":"povray"}"#.to_owned();
        let run =
            Run::of_lines(&[line(4.0), line(9.0), line(5.0), transform, frame, String::new()]);
        let run = run.unwrap();
        assert_eq!(run.kernels.len(), 1);
        assert_eq!(run.kernels[0].mrays_per_s, 5.0);
        assert_eq!(run.transforms[0].contender, "edt");
    }

    #[test]
    fn broken_lines_are_named() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(
            folder.path().join("a.jsonl"),
            format!("{}\n{{\"bench\":\"kernels\"}}\n", line(1.0)),
        )
        .unwrap();
        let error = Run::read(folder.path()).unwrap_err();
        assert!(error.contains("a.jsonl:2") && error.contains("missing field"), "{error}");
    }
}
