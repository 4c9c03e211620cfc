//! How large a distance map is made when nobody says.
//!
//! | kind | size | why |
//! |---|---|---|
//! | boxes | cells, at most 256 a side; 32 deep | 4 MiB of 16-bit codes, built in a fraction of a second |
//! | corrected | cells, at most 128 a side; 32 deep | a search for every node: seconds, not minutes |
//! | published | samples, 32 deep; less where the brute force would look at more than 2^31 samples | the paper's one node a sample |
//!
//! Finer maps shorten few steps: past the map's own cells no column gets narrower than the cell that
//! the leaf tests anyway, and with 32 slabs a step from the top of the domain already skips most of
//! the empty part of the shell.

use super::{DistanceBits, DistanceKind, DistanceOptions};
use crate::map::{HeightMap, Metric};

/// Slabs or node layers.
const DEPTH: u32 = 32;

/// Samples that the published brute force may look at: some ten seconds of one core.
const PUBLISHED_WORK: f64 = (1u64 << 31) as f64;

impl DistanceOptions {
    /// The options of a map of `heights` in `metric` when nobody says otherwise: 16 bits, and a size
    /// that follows from the map's; see the table at the head of `default_size`.
    pub fn by_default(heights: &HeightMap, kind: DistanceKind, metric: Metric) -> Self {
        let cells = [heights.x().cells(), heights.y().cells()];
        let [x, y] = match kind {
            DistanceKind::Boxes => cells.map(|n| n.min(256)),
            DistanceKind::Corrected => cells.map(|n| n.min(128) + 1),
            DistanceKind::Published => published(heights, metric),
        };
        Self { size: [x, y, DEPTH], metric, bits: DistanceBits::U16 }
    }
}

/// One node a sample, or as many as the brute force can pay for.
fn published(heights: &HeightMap, metric: Metric) -> [u32; 2] {
    let nodes = [heights.x(), heights.y()].map(|axis| axis.cells() + 1);
    let (low, high) = heights.raw_range();
    // A node looks at the samples within its height above or below the surface: on average about a
    // quarter of the depth to either side.
    let reach = 0.5 * (f64::from(high) - f64::from(low)) * metric.z;
    let looks = |n: u32, side: f64| (1.0 + reach / side).min(f64::from(n));
    let each = looks(nodes[0], metric.x) * looks(nodes[1], metric.y) * f64::from(DEPTH);
    let work = nodes.iter().map(|&n| f64::from(n)).product::<f64>() * each;
    let shrink = (PUBLISHED_WORK / work).sqrt().min(1.0);
    nodes.map(|n| ((f64::from(n) * shrink) as u32).max(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{DistanceMap, Lattice, Procedural, Wrap};

    const KINDS: [DistanceKind; 3] =
        [DistanceKind::Published, DistanceKind::Boxes, DistanceKind::Corrected];

    #[test]
    fn small_maps_keep_their_resolution_and_every_default_is_accepted() {
        for (size, wrap) in [([2, 2], Wrap::Repeat), ([33, 5], Wrap::Clamp)] {
            let map = Procedural::Gaussian.height_map(size, Lattice::Vertex, wrap).unwrap();
            let cells = [map.x().cells(), map.y().cells()];
            let metric = Metric::of_face(&map, [1.0, 1.0], 0.1);
            for kind in KINDS {
                let options = DistanceOptions::by_default(&map, kind, metric);
                let nodes = if kind == DistanceKind::Boxes { 0 } else { 1 };
                assert_eq!(options.size, [cells[0] + nodes, cells[1] + nodes, DEPTH]);
                DistanceMap::from_height(&map, kind, &options).unwrap();
            }
        }
    }

    #[test]
    fn large_maps_are_capped_and_deep_ones_cost_the_published_kind_more() {
        let map = Procedural::Tent.height_map([1025, 513], Lattice::Vertex, Wrap::Clamp).unwrap();
        let size = |kind, scale| {
            let metric = Metric::of_face(&map, [2.0, 1.0], scale);
            DistanceOptions::by_default(&map, kind, metric).size
        };
        assert_eq!(size(DistanceKind::Boxes, 0.1), [256, 256, DEPTH]);
        assert_eq!(size(DistanceKind::Corrected, 0.1), [129, 129, DEPTH]);
        let (shallow, deep) =
            (size(DistanceKind::Published, 0.001), size(DistanceKind::Published, 1.0));
        assert_eq!(shallow, [1027, 515, DEPTH]);
        assert!(deep[0] < 200 && deep[0] > deep[1] && deep[1] > 10, "{deep:?}");
    }
}
