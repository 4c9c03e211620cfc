//! Building levels: blocks from heights, then nodes from nodes.

use rayon::prelude::*;

use super::blocks::{Blocks, Sample};
use super::code::Code;
use super::layout::Layout;
use super::level::{Level, LevelBounds, NodesMut, Wide};
use crate::map::height::{HeightMap, Samples};

/// All levels, finest first; parallel over rows of nodes, the same for any thread count.
pub(super) fn levels(heights: &HeightMap, layout: Layout, code: &Code) -> Vec<Level> {
    let mut levels = vec![ground_level(heights, layout, code)];
    while let Some(top) = levels.last()
        && top.nodes != [1, 1]
    {
        let next = coarser_level(top, layout);
        levels.push(next);
    }
    levels
}

/// A level of `nodes` whose rows `fill` writes, all lanes of maxima and minima, with what `work`
/// makes for each thread.
fn level<W, F>(
    nodes: [u32; 2],
    layout: Layout,
    work: impl Fn() -> W + Sync + Send,
    fill: F,
) -> Level
where
    F: Fn(&mut W, u32, &mut [Wide], &mut [Wide]) + Sync,
{
    let across = nodes[0] as usize;
    let mut bounds = LevelBounds::new(layout, across * nodes[1] as usize);
    let rows: Vec<NodesMut<'_>> = match &mut bounds {
        LevelBounds::Wide { max, min } => {
            let rows = max.chunks_mut(across).zip(min.chunks_mut(across));
            rows.map(|(max, min)| NodesMut::Wide { max, min }).collect()
        }
        LevelBounds::Tiny { max, min, range } => {
            let rows = max.chunks_mut(across).zip(min.chunks_mut(across));
            let rows = rows.zip(range.chunks_mut(across));
            rows.map(|((max, min), range)| NodesMut::Tiny { max, min, range }).collect()
        }
    };
    rows.into_par_iter().enumerate().for_each_init(work, |work, (y, row)| {
        row.fill(|max, min| fill(work, y as u32, max, min));
    });
    Level { nodes, bounds }
}

fn ground_level(heights: &HeightMap, layout: Layout, code: &Code) -> Level {
    match heights.samples() {
        Samples::U16(samples) => ground_level_of((heights, samples), layout, code),
        Samples::F32(samples) => ground_level_of((heights, samples), layout, code),
    }
}

fn ground_level_of<S: Sample>(
    (heights, samples): (&HeightMap, &[S]),
    layout: Layout,
    code: &Code,
) -> Level {
    let nodes = [heights.x(), heights.y()].map(|axis| axis.cells().div_ceil(16));
    let work = || Blocks::new((heights, samples), code, (0, nodes[0] as usize));
    level(nodes, layout, work, |work, y, max, min| work.fill(y, max, min))
}

/// The level above `fine`.
fn coarser_level(fine: &Level, layout: Layout) -> Level {
    let nodes = fine.nodes.map(|n| n.div_ceil(4));
    level(nodes, layout, || (), |(), y, max, min| fill_coarser(fine, [0, y], max, min))
}

/// Fills nodes above `fine`, from node (x, y) along its row: the ranges of sixteen nodes each.
pub(super) fn fill_coarser(fine: &Level, [x, y]: [u32; 2], max: &mut [Wide], min: &mut [Wide]) {
    let [across, up] = fine.nodes;
    for (x, (max, min)) in (x..).zip(max.iter_mut().zip(min)) {
        for (lane, (max, min)) in (0..).zip(max.iter_mut().zip(min)) {
            let child = [4 * x + lane % 4, 4 * y + lane / 4];
            [*min, *max] = if child[0] < across && child[1] < up {
                fine.bounds.range(child[1] as usize * across as usize + child[0] as usize)
            } else {
                [u16::MAX, 0]
            };
        }
    }
}
