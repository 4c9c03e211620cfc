//! [`Pyramid::update`]: after an edit only the nodes above it are made anew.
//!
//! Every level is a function of the one below, node by node, in both layouts: a tiny node keeps
//! the exact ends of its range. So what is not above a changed sample need not be looked at, and
//! what is made anew is what a full build makes.

use std::ops::Range;

use super::Pyramid;
use super::blocks::{Blocks, Sample};
use super::build::fill_coarser;
use super::code::Code;
use super::level::{Level, Wide};
use crate::map::height::{HeightMap, Samples};
use crate::map::lattice::Axis;

/// Nodes of one axis that are to be made anew: a run, and one at the far end that a wrap reaches. Either may be
/// empty.
pub type NodeRuns = [Range<u32>; 2];

impl Pyramid {
    /// The nodes of level 0 with a cell that touches a sample of `changed`, which is not empty, along an axis.
    pub fn touched_nodes(axis: &Axis, changed: &Range<u32>) -> NodeRuns {
        let cells = axis.cells();
        let (first, end, far) = if axis.first_cell() < 0 {
            // Cell c joins samples c - 1 and c.
            (changed.start, changed.end + 1, 0..0)
        } else {
            // Cell c joins samples c and c + 1, the last one of a wrap sample 0.
            let wraps = cells == axis.samples() && changed.start == 0;
            let far = if wraps { (cells - 1) / 16..cells.div_ceil(16) } else { 0..0 };
            (changed.start.saturating_sub(1), changed.end.min(cells), far)
        };
        [first / 16..end.div_ceil(16), far]
    }

    /// The nodes of the next level above nodes.
    pub fn parent_nodes(runs: &NodeRuns) -> NodeRuns {
        runs.clone().map(|run| run.start / 4..run.end.div_ceil(4))
    }

    /// Follows an edit of `heights`: columns `x` and rows `y` may have changed since this was their
    /// pyramid, nothing else. Afterwards it equals a full build. It *is* one if the heights are
    /// floats and their range has changed, for then every code means something else.
    ///
    /// # Panics
    /// If the heights have another number of cells, or a rectangle that is not empty reaches beyond
    /// them.
    pub fn update(&mut self, heights: &HeightMap, [x, y]: [Range<u32>; 2]) {
        assert_eq!(self.cells, [heights.x().cells(), heights.y().cells()], "another map");
        if x.is_empty() || y.is_empty() {
            return;
        }
        let inside = x.end <= heights.width() && y.end <= heights.height();
        assert!(inside, "samples {x:?} x {y:?} are not in the map");
        if self.code != Code::for_heights(heights) {
            *self = Self::build_as(heights, self.layout);
            return;
        }
        let mut runs = [Self::touched_nodes(heights.x(), &x), Self::touched_nodes(heights.y(), &y)];
        let code = self.code;
        match heights.samples() {
            Samples::U16(v) => update_ground(&mut self.levels[0], (heights, v), &code, &runs),
            Samples::F32(v) => update_ground(&mut self.levels[0], (heights, v), &code, &runs),
        }
        for upper in 1..self.levels.len() {
            runs = [Self::parent_nodes(&runs[0]), Self::parent_nodes(&runs[1])];
            let (below, above) = self.levels.split_at_mut(upper);
            let fine = &below[upper - 1];
            update_level(&mut above[0], &runs, |first, _| {
                move |y, max: &mut [Wide], min: &mut [Wide]| {
                    fill_coarser(fine, [first, y], max, min);
                }
            });
        }
    }

    /// Lowest and highest code of all.
    pub(crate) fn code_range(&self) -> [u16; 2] {
        self.levels.last().map_or([0; 2], |top| top.bounds.range(0))
    }
}

fn update_ground<S: Sample>(
    level: &mut Level,
    map: (&HeightMap, &[S]),
    code: &Code,
    runs: &[NodeRuns; 2],
) {
    update_level(level, runs, |first, count| {
        let mut blocks = Blocks::new(map, code, (first, count));
        move |y, max: &mut [Wide], min: &mut [Wide]| blocks.fill(y, max, min)
    });
}

/// Makes the nodes of `runs` anew: `columns` gives, for a run along x, what fills its rows.
fn update_level<F>(level: &mut Level, runs: &[NodeRuns; 2], columns: impl Fn(u32, usize) -> F)
where
    F: FnMut(u32, &mut [Wide], &mut [Wide]),
{
    let across = level.nodes[0] as usize;
    for x in runs[0].iter().filter(|run| !run.is_empty()) {
        let mut fill = columns(x.start, x.len());
        for y in runs[1].iter().flat_map(Range::clone) {
            let start = y as usize * across + x.start as usize;
            let nodes = level.bounds.run_mut(start..start + x.len());
            nodes.fill(|max, min| fill(y, max, min));
        }
    }
}
