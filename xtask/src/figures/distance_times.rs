//! How long distance maps take: `boxes` over sizes, and the paper's brute force beside it.
//!
//! One thread, processor time, face 1 x 1 and depth 1: the depth at which a distance map has most to
//! tell, and the brute force most to look at. It looks at all samples within reach of each node, so
//! its work grows with the fourth power of the side. Sides are doubled, and at last made half as
//! long again, as long as the next is expected to end within [`MOST_SECONDS`].

use std::path::Path;

use super::Studio;
use super::heights::Shape;
use super::program::Threads;
use super::table::{Table, seconds};

/// Voxels or nodes along z.
const DEPTH: u32 = 32;

const MOST_SECONDS: f64 = 300.0;

/// Runs shorter than this are repeated: processor time comes in steps of 10 ms.
const ENOUGH_SECONDS: f64 = 1.0;

const MOST_RUNS: u32 = 40;

pub fn draw(studio: &Studio<'_>) -> Result<(), String> {
    let sides: &[u32] = if studio.quick { &[64, 128] } else { &[256, 512, 1024, 2048] };
    let mut boxes = Table::new(&[
        "`boxes`",
        "voxels",
        "fbm, CPU s",
        "ns a voxel",
        "studs, CPU s",
        "ns a voxel",
    ]);
    for &side in sides {
        let voxels = f64::from(side * side * DEPTH);
        let size = format!("{side} x {side} x {DEPTH}");
        let mut cells = vec![size, format!("{:.1} million", voxels / 1e6)];
        for shape in Shape::ALL {
            let took = bake(studio, (shape, side), "boxes")?;
            cells.extend([seconds(took), format!("{:.0}", took / voxels * 1e9)]);
        }
        boxes.row(cells);
    }
    let mut published = Table::new(&["map, size", "`published`, CPU s", "`boxes`, CPU s", "ratio"]);
    let most = if studio.quick { 4.0 } else { MOST_SECONDS };
    for shape in Shape::ALL {
        let mut side = if studio.quick { 64 } else { 128 };
        loop {
            let took = bake(studio, (shape, side), "published")?;
            let beside = bake(studio, (shape, side), "boxes")?;
            published.row(vec![
                format!("{}, {side} x {side} x {DEPTH}", shape.name()),
                seconds(took),
                seconds(beside),
                ratio(took, beside),
            ]);
            side = match took {
                s if s * 2f64.powi(4) <= most => side * 2,
                s if s * 1.5f64.powi(4) <= most => side * 3 / 2,
                _ => break,
            };
        }
    }
    studio.write("docs/METHODS.md", "boxes-times", &boxes.markdown())?;
    studio.write("docs/METHODS.md", "published-times", &published.markdown())
}

/// How many times as long; unknown where the shorter time is below what the clock can tell.
fn ratio(long: f64, short: f64) -> String {
    if short < 0.002 { "unknown".to_owned() } else { format!("{:.0}", long / short) }
}

/// Processor seconds of one distance map over a map of the same resolution, the mean of a few runs.
fn bake(studio: &Studio<'_>, (shape, side): (Shape, u32), kind: &str) -> Result<f64, String> {
    let map = studio.scratch(&format!("{}-{side}.png", shape.name()));
    shape.write(&map, side)?;
    let out = studio.scratch("timed.rlv");
    let size = format!("{side},{side},{DEPTH}");
    let (mut total, mut runs) = (0.0, 0);
    while total < ENOUGH_SECONDS && runs < MOST_RUNS {
        let words = [Path::new("bake"), Path::new("distance"), &map, Path::new("-o"), &out];
        let flags = ["--kind", kind, "--size", &size].map(Path::new);
        let baked = studio.program.call(Threads::One, &[&words[..], &flags].concat())?;
        total += baked.number("build_cpu_seconds")?;
        runs += 1;
    }
    Ok(total / f64::from(runs))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_need_times_that_can_be_told() {
        assert_eq!(ratio(3.0, 0.01), "300");
        assert_eq!(ratio(3.0, 0.0), "unknown");
    }
}
