//! `build`: the pyramid of a map, in nanoseconds a sample, and live edits, both on one thread.

use rilievo::map::{HeightMap, Layout, Pyramid, RowMut};
use rilievo::relief::Relief;
use serde::{Deserialize, Serialize};

use crate::args::BuildArgs;
use crate::clock::timed;
use crate::measure::{Passes, interleaved};
use crate::one_thread;
use crate::random::unit;
use crate::report::{object, print, say};

/// One line of `build --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Always `build`.
    pub bench: String,
    pub map: String,
    /// Samples a side.
    pub size: u32,
    pub layout: String,
    /// Processor time of one thread, the median pass.
    pub build_seconds: f64,
    pub ns_per_texel: f64,
    /// (slowest - fastest) / median pass.
    pub spread: f64,
    pub passes: usize,
    pub bytes_per_texel: f64,
    /// Milliseconds of an edit of 64 x 64 samples, heights and pyramid: the mean over [`EDITS`]
    /// places, the median pass.
    pub edit_ms: f64,
}

/// Edits a pass, at random places.
const EDITS: u64 = 256;

/// Samples a side of an edit.
const EDITED: u32 = 64;

/// Measures every map and size, both layouts in turn.
///
/// # Errors
/// A map that cannot be read, or an output that cannot be written.
pub fn run(args: &BuildArgs) -> Result<(), String> {
    for &map in &args.maps {
        for &size in &args.sizes {
            say(format_args!("{} {size}", map.name()));
            let heights = map.load(size)?;
            for record in measure(args.passes.into(), map.name(), &heights)? {
                if args.output.json {
                    object(&record)?;
                } else {
                    let Record { layout, ns_per_texel, bytes_per_texel, spread, .. } = &record;
                    print(&format!(
                        "{:14} {size:6} {layout:8} {ns_per_texel:7.3} ns/texel +-{:.0} %, \
                         {bytes_per_texel:.3} B/texel, edit {:.4} ms",
                        map.name(),
                        spread * 50.0,
                        record.edit_ms
                    ))?;
                }
            }
        }
    }
    Ok(())
}

fn measure(passes: usize, map: &str, heights: &HeightMap) -> Result<Vec<Record>, String> {
    let size = heights.width();
    let texels = f64::from(size) * f64::from(heights.height());
    let works = Layout::ALL.map(|layout| move || Pyramid::build_as(heights, layout).bytes());
    let measured = one_thread(|| interleaved(&works, passes));
    let mut records = Vec::new();
    for (layout, (bytes, taken)) in Layout::ALL.into_iter().zip(measured) {
        let edit = one_thread(|| edits(heights, layout, passes))?;
        records.push(Record {
            bench: "build".to_owned(),
            map: map.to_owned(),
            size,
            layout: layout.name().to_owned(),
            build_seconds: taken.median,
            ns_per_texel: taken.median * 1e9 / texels,
            spread: taken.spread(),
            passes,
            bytes_per_texel: bytes as f64 / texels,
            edit_ms: edit.median * 1e3,
        });
    }
    Ok(records)
}

/// Seconds of an edit at random places of a copy of `heights`.
fn edits(heights: &HeightMap, layout: Layout, passes: usize) -> Result<Passes, String> {
    let mut relief = Relief::with_layout(heights.clone(), layout);
    let side = EDITED.min(heights.width());
    let most = f64::from(heights.width() - side + 1);
    let mut seconds = Vec::with_capacity(passes);
    // The first pass warms up.
    for pass in 0..=passes {
        let (edited, taken) = timed(|| {
            (0..EDITS).try_for_each(|edit| {
                let [x, y] = [0, 1].map(|draw| (unit(edit, draw) * most) as u32);
                relief.edit([x..x + side, y..y + side], |_row, samples| match samples {
                    RowMut::U16(codes) => codes.iter_mut().for_each(|code| *code = !*code),
                    RowMut::F32(values) => values.iter_mut().for_each(|value| *value = -*value),
                })
            })
        });
        edited.map_err(|e| e.to_string())?;
        if pass > 0 {
            seconds.push(taken / EDITS as f64);
        }
    }
    Ok(Passes::of(seconds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapName;

    #[test]
    fn both_layouts_are_measured() {
        let records = measure(2, "gaussian", &MapName::Gaussian.load(257).unwrap()).unwrap();
        let [default, tiny] = &records[..] else { panic!("{records:?}") };
        assert_eq!((default.layout.as_str(), tiny.layout.as_str()), ("default", "tiny"));
        assert!(default.ns_per_texel > 0.0 && tiny.bytes_per_texel < default.bytes_per_texel);
        assert!(default.edit_ms > 0.0 && tiny.edit_ms > 0.0);
    }
}
