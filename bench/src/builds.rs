//! `build`: the pyramid of a map, in nanoseconds a sample of one thread.

use rilievo::map::{HeightMap, Layout, Pyramid};
use serde::{Deserialize, Serialize};

use crate::args::BuildArgs;
use crate::measure::interleaved;
use crate::one_thread;
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
}

/// Measures every map and size, both layouts in turn.
///
/// # Errors
/// A map that cannot be read, or an output that cannot be written.
pub fn run(args: &BuildArgs) -> Result<(), String> {
    for &map in &args.maps {
        for &size in &args.sizes {
            say(format_args!("{} {size}", map.name()));
            let heights = map.load(size)?;
            for record in measure(args.passes.into(), map.name(), &heights) {
                if args.output.json {
                    object(&record)?;
                } else {
                    let Record { layout, ns_per_texel, bytes_per_texel, spread, .. } = &record;
                    print(&format!(
                        "{:14} {size:6} {layout:8} {ns_per_texel:7.3} ns/texel +-{:.0} %, \
                         {bytes_per_texel:.3} B/texel",
                        map.name(),
                        spread * 50.0
                    ))?;
                }
            }
        }
    }
    Ok(())
}

fn measure(passes: usize, map: &str, heights: &HeightMap) -> Vec<Record> {
    let size = heights.width();
    let texels = f64::from(size) * f64::from(heights.height());
    let works = Layout::ALL.map(|layout| move || Pyramid::build_as(heights, layout).bytes());
    let measured = one_thread(|| interleaved(&works, passes));
    let record = |(layout, (bytes, taken)): (Layout, (u64, crate::measure::Passes))| Record {
        bench: "build".to_owned(),
        map: map.to_owned(),
        size,
        layout: layout.name().to_owned(),
        build_seconds: taken.median,
        ns_per_texel: taken.median * 1e9 / texels,
        spread: taken.spread(),
        passes,
        bytes_per_texel: bytes as f64 / texels,
    };
    Layout::ALL.into_iter().zip(measured).map(record).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapName;

    #[test]
    fn both_layouts_are_measured() {
        let records = measure(2, "gaussian", &MapName::Gaussian.load(257).unwrap());
        let [default, tiny] = &records[..] else { panic!("{records:?}") };
        assert_eq!((default.layout.as_str(), tiny.layout.as_str()), ("default", "tiny"));
        assert!(default.ns_per_texel > 0.0 && tiny.bytes_per_texel < default.bytes_per_texel);
    }
}
