//! Building levels: blocks from heights, then nodes from nodes.

use rayon::prelude::*;

use super::code::Code;
use super::layout::Layout;
use super::level::{LANES, Level, LevelBounds, NodesMut, Wide};
use crate::map::height::{HeightMap, Samples};
use crate::map::lattice::Axis;

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

/// A level of `nodes` whose rows `fill` writes, all lanes of maxima and minima.
fn level<F>(nodes: [u32; 2], layout: Layout, fill: F) -> Level
where
    F: Fn(u32, &mut [Wide], &mut [Wide]) + Sync,
{
    let across = nodes[0] as usize;
    let mut bounds = LevelBounds::new(layout, across * nodes[1] as usize);
    let row = |y: usize, row: NodesMut<'_>| row.fill(|max, min| fill(y as u32, max, min));
    match &mut bounds {
        LevelBounds::Wide { max, min } => {
            let rows = max.par_chunks_mut(across).zip(min.par_chunks_mut(across)).enumerate();
            rows.for_each(|(y, (max, min))| row(y, NodesMut::Wide { max, min }));
        }
        LevelBounds::Tiny { max, min, range } => {
            let rows = max.par_chunks_mut(across).zip(min.par_chunks_mut(across));
            let rows = rows.zip(range.par_chunks_mut(across)).enumerate();
            rows.for_each(|(y, ((max, min), range))| row(y, NodesMut::Tiny { max, min, range }));
        }
    }
    Level { nodes, bounds }
}

fn ground_level(heights: &HeightMap, layout: Layout, code: &Code) -> Level {
    let nodes = [heights.x(), heights.y()].map(|axis| axis.cells().div_ceil(16));
    level(nodes, layout, |y, max, min| match heights.samples() {
        Samples::U16(v) => ground_row(heights, v, |lo, hi| (lo, hi), (y, max, min)),
        Samples::F32(v) => {
            let encode = |lo, hi| (code.below(lo), code.above(hi));
            ground_row(heights, v, encode, (y, max, min));
        }
    })
}

/// Samples that the stored cells `from..to` of an axis touch: an inclusive range, and the sample
/// reached by wrapping, if any.
fn samples_of(axis: &Axis, from: u32, to: u32) -> (usize, usize, Option<usize>) {
    let (first, _) = axis.corners(from);
    let (near, far) = axis.corners(to - 1);
    if far < near {
        (first as usize, near as usize, Some(far as usize))
    } else {
        (first as usize, far as usize, None)
    }
}

/// One row of level-0 nodes: per row of blocks, minima and maxima of whole sample rows first, then
/// of columns.
fn ground_row<T, F>(
    heights: &HeightMap,
    samples: &[T],
    encode: F,
    (node_y, max_row, min_row): (u32, &mut [Wide], &mut [Wide]),
) where
    T: Copy + PartialOrd,
    F: Fn(T, T) -> (u16, u16),
{
    let (x, y) = (heights.x(), heights.y());
    let width = heights.width() as usize;
    max_row.fill([0; LANES]);
    min_row.fill([u16::MAX; LANES]);
    let mut low = Vec::with_capacity(width);
    let mut high = Vec::with_capacity(width);
    for lane_y in 0..4 {
        let from = node_y * 16 + lane_y * 4;
        if from >= y.cells() {
            break;
        }
        let (first, last, wrapped) = samples_of(y, from, (from + 4).min(y.cells()));
        let row = |j: usize| &samples[j * width..(j + 1) * width];
        low.clear();
        low.extend_from_slice(row(first));
        high.clear();
        high.extend_from_slice(row(first));
        for j in (first + 1..=last).chain(wrapped) {
            for ((lo, hi), &h) in low.iter_mut().zip(&mut high).zip(row(j)) {
                *lo = if h < *lo { h } else { *lo };
                *hi = if h > *hi { h } else { *hi };
            }
        }
        for block in 0..x.cells().div_ceil(4) {
            let cell = block * 4;
            let (first, last, wrapped) = samples_of(x, cell, (cell + 4).min(x.cells()));
            let (mut lo, mut hi) = (low[first], high[first]);
            for i in (first + 1..=last).chain(wrapped) {
                lo = if low[i] < lo { low[i] } else { lo };
                hi = if high[i] > hi { high[i] } else { hi };
            }
            let (lo, hi) = encode(lo, hi);
            let (node, lane) = ((block / 4) as usize, (lane_y * 4 + block % 4) as usize);
            min_row[node][lane] = lo;
            max_row[node][lane] = hi;
        }
    }
}

/// The level above `fine`: the ranges of its nodes, sixteen a node.
fn coarser_level(fine: &Level, layout: Layout) -> Level {
    level(fine.nodes.map(|n| n.div_ceil(4)), layout, |y, max, min| {
        for (x, (max, min)) in (0..).zip(max.iter_mut().zip(min)) {
            for lane in 0..LANES as u32 {
                let child = [4 * x + lane % 4, 4 * y + lane / 4];
                let [lo, hi] = if child[0] < fine.nodes[0] && child[1] < fine.nodes[1] {
                    fine.bounds
                        .range(child[1] as usize * fine.nodes[0] as usize + child[0] as usize)
                } else {
                    [u16::MAX, 0]
                };
                (min[lane as usize], max[lane as usize]) = (lo, hi);
            }
        }
    })
}
