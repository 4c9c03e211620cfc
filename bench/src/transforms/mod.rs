//! `transforms`: how long distance maps take, in nanoseconds a voxel of one thread.
//!
//! The task: a grid of voxels around a relief, and for each voxel the distance to the surface. The
//! map has one cell a column and the voxels are cubes. rilievo starts from the heights; a peer that
//! transforms voxels starts from the free voxels around the same relief, which `--dump-grid` writes.
//!
//! What they compute differs, and is said in `against`: rilievo's `boxes` gives a distance that is
//! never above the true one from anywhere in the voxel, in 8 bits; `corrected` the exact distance
//! to the bilinear surface at the corners of the voxels; a Euclidean distance transform the distance
//! between centres, in floats.

mod grid;

use std::collections::BTreeMap;

use rilievo::map::{DistanceBits, DistanceKind, DistanceMap, DistanceOptions, HeightMap, Metric};
use serde::{Deserialize, Serialize};

use crate::args::TransformArgs;
use crate::measure::interleaved;
use crate::one_thread;
use crate::report::{object, print};

pub use grid::Grid;

/// One line of `transforms --json`; peers' scripts write the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Always `transforms`.
    pub bench: String,
    pub map: String,
    /// Map and voxels, as the file of `--dump-grid` is called.
    pub grid: String,
    /// Voxels along z, y and x.
    pub shape: [u32; 3],
    /// `rilievo-boxes`, `rilievo-corrected`, `rilievo-published`, or a peer.
    pub contender: String,
    /// Processor time of one thread, the median pass.
    pub cpu_seconds: f64,
    pub ns_per_voxel: f64,
    /// (slowest - fastest) / median pass.
    pub spread: f64,
    pub passes: usize,
    pub threads: usize,
    /// Bytes of the result.
    pub bytes: u64,
    /// What is computed, versions and flags.
    pub against: BTreeMap<String, String>,
}

/// Measures every map on every grid, all kinds in turn.
///
/// # Errors
/// A map that cannot be read, a size that is refused, or an output that cannot be written.
pub fn run(args: &TransformArgs) -> Result<(), String> {
    for &map in &args.maps {
        for &grid in &args.grids {
            let heights = map.load(grid.side + 1)?;
            if let Some(folder) = &args.dump_grid {
                grid.dump(&heights, &folder.join(format!("{}-{grid}.npy", map.name())))?;
            }
            for record in measure(args, map.name(), grid, &heights)? {
                if args.output.json {
                    object(&record)?;
                } else {
                    let Record { contender, ns_per_voxel, spread, .. } = &record;
                    print(&format!(
                        "{:14} {grid} {contender:18} {ns_per_voxel:9.2} ns/voxel +-{:.0} %",
                        map.name(),
                        spread * 50.0
                    ))?;
                }
            }
        }
    }
    Ok(())
}

fn measure(
    args: &TransformArgs,
    map: &str,
    grid: Grid,
    heights: &HeightMap,
) -> Result<Vec<Record>, String> {
    let metric = grid.metric(heights);
    let works: Vec<_> =
        args.kinds.iter().map(|&kind| move || transform(heights, kind, grid, metric)).collect();
    let measured = one_thread(|| interleaved(&works, args.passes.into()));
    let mut records = Vec::new();
    for (&kind, (distances, passes)) in args.kinds.iter().zip(measured) {
        let distances = distances?;
        records.push(Record {
            bench: "transforms".to_owned(),
            map: map.to_owned(),
            grid: format!("{map}-{grid}"),
            shape: [grid.depth, grid.side, grid.side],
            contender: format!("rilievo-{}", name(kind)),
            cpu_seconds: passes.median,
            ns_per_voxel: passes.median * 1e9 / grid.count() as f64,
            spread: passes.spread(),
            passes: args.passes.into(),
            threads: 1,
            bytes: distances.bytes(),
            against: BTreeMap::from([
                ("computes".to_owned(), computes(kind).to_owned()),
                ("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
            ]),
        });
    }
    Ok(records)
}

fn transform(
    heights: &HeightMap,
    kind: DistanceKind,
    grid: Grid,
    metric: Metric,
) -> Result<DistanceMap, String> {
    let options = DistanceOptions { size: grid.voxels(), metric, bits: DistanceBits::U8 };
    DistanceMap::from_height(heights, kind, &options).map_err(|e| e.to_string())
}

/// The name of a kind on the command line and in records.
pub fn name(kind: DistanceKind) -> &'static str {
    match kind {
        DistanceKind::Boxes => "boxes",
        DistanceKind::Corrected => "corrected",
        DistanceKind::Published => "published",
    }
}

fn computes(kind: DistanceKind) -> &'static str {
    match kind {
        DistanceKind::Boxes => "voxel box to column boxes, rounded down, u8",
        DistanceKind::Corrected => "node to bilinear surface, within the quantum, rounded down, u8",
        DistanceKind::Published => "node to texel points by brute force, u8",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapName;

    #[test]
    fn every_kind_is_measured_on_the_grid() {
        let args = TransformArgs {
            maps: vec![MapName::Fbm],
            grids: vec![Grid { side: 24, depth: 8 }],
            kinds: vec![DistanceKind::Boxes, DistanceKind::Corrected, DistanceKind::Published],
            passes: 1,
            dump_grid: None,
            output: crate::args::Output { json: true },
        };
        let heights = MapName::Fbm.load(25).unwrap();
        let records = measure(&args, "fbm", args.grids[0], &heights).unwrap();
        let names: Vec<_> = records.iter().map(|r| r.contender.as_str()).collect();
        assert_eq!(names, ["rilievo-boxes", "rilievo-corrected", "rilievo-published"]);
        for record in records {
            assert_eq!((record.shape, record.bytes), ([8, 24, 24], 24 * 24 * 8));
            assert!(record.ns_per_voxel > 0.0);
            let line = serde_json::to_string(&record).unwrap();
            let back: Record = serde_json::from_str(&line).unwrap();
            assert_eq!((back.grid.as_str(), back.contender), ("fbm-24x8", record.contender));
        }
    }
}
