//! The methods: which cells of a segment the leaf is shown, in order.
//!
//! [`among_cells`] shows every cell under a part of the segment, for `dda` all of it. [`by_pyramid`]
//! goes down the face's min-max pyramid, whose lines are lines of cells, from the smallest node that
//! holds the whole segment, and leaves out blocks and cells that the ray passes (`sweep`). The third is
//! in `by_distance`.

use super::radii::Radii;
use super::segment::{Root, Segment};
use super::sweep::{Range, Sweep};
use crate::probe::Probe;
use crate::relief::Relief;
use crate::simd::Lanes;

/// Most levels of a pyramid over a face.
const LEVELS: usize = 8;

/// By how much the cells under a segment are counted too far, for the rounding of its lines.
const BESIDE: f64 = 1e-9;

/// The first crossing among all cells under a part of a segment, of `[0, 1]`.
#[inline(always)]
pub(super) fn among_cells<P: Probe>(
    segment: &Segment<'_>,
    cells: u32,
    [from, to]: [f64; 2],
    probe: &mut P,
) -> Option<Root> {
    let last = f64::from(cells - 1);
    let forward = [0, 1].map(|k| segment.slope[k] > 0.0);
    // A little back, for the rounding of the place: cells that end before the part hold nothing.
    let first = |k: usize| {
        let at = segment.origin[k] + from * segment.slope[k];
        let cell = if forward[k] { (at - BESIDE).floor() } else { (at + BESIDE).ceil() - 1.0 };
        cell.max(0.0).min(last) as u32
    };
    let mut cell = [first(0), first(1)];
    loop {
        probe.cell();
        if let Some(root) = segment.meet(cell) {
            return Some(root);
        }
        let mut far = [0.0; 2];
        for k in 0..2 {
            let line = f64::from(cell[k]) + f64::from(u8::from(forward[k]));
            far[k] = segment.crosses(k, line);
        }
        let leave = far[0].min(far[1]);
        if leave >= to {
            return None;
        }
        for k in 0..2 {
            if far[k] <= leave {
                if !forward[k] && cell[k] == 0 || forward[k] && cell[k] + 1 == cells {
                    return None;
                }
                cell[k] = if forward[k] { cell[k] + 1 } else { cell[k] - 1 };
            }
        }
    }
}

/// The first crossing under a segment within a range.
#[inline(always)]
pub(super) fn by_pyramid<L: Lanes, P: Probe>(
    segment: &Segment<'_>,
    (relief, radii): (&Relief, &Radii),
    range: Range,
    probe: &mut P,
) -> Option<Root> {
    let sweep = Sweep::new(segment, relief, radii, range);
    let cells = radii.cells as i32;
    let (top, node) = smallest_node(segment, &sweep, cells);
    let mut stack = [([0i32; 2], 0u16); LEVELS];
    let mut level = top;
    probe.node();
    stack[level] = (node, sweep.node::<L>(level as u32, node));
    loop {
        let (node, open) = &mut stack[level % LEVELS];
        if *open == 0 {
            if level == top {
                return None;
            }
            level += 1;
            continue;
        }
        let lane = open.trailing_zeros() as i32;
        *open &= *open - 1;
        let child = [4 * node[0] + lane % 4, 4 * node[1] + lane / 4];
        let shift = 2 * level + 2;
        // Widened intervals may lead beyond the map.
        let first = [0, 1].map(|k| ((child[k] ^ sweep.turn[k]) << shift, child[k] << shift));
        if !(0..cells).contains(&first[0].0) || !(0..cells).contains(&first[1].0) {
            continue;
        }
        probe.node();
        if level > 0 {
            level -= 1;
            stack[level % LEVELS] = (child, sweep.node::<L>(level as u32, child));
            continue;
        }
        let corner = [first[0].1, first[1].1];
        let mut met = sweep.block::<L>(corner);
        while met != 0 {
            let lane = met.trailing_zeros() as i32;
            met &= met - 1;
            let cell =
                [(corner[0] + lane % 4) ^ sweep.turn[0], (corner[1] + lane / 4) ^ sweep.turn[1]];
            if !(0..cells).contains(&cell[0]) || !(0..cells).contains(&cell[1]) {
                continue;
            }
            probe.cell();
            if let Some(root) = segment.meet([cell[0] as u32, cell[1] as u32]) {
                return Some(root);
            }
        }
    }
}

/// Level and mirrored indices of the smallest node that holds all cells under a segment.
#[inline(always)]
fn smallest_node(segment: &Segment<'_>, sweep: &Sweep<'_>, cells: i32) -> (usize, [i32; 2]) {
    let (mut first, mut differing) = ([0; 2], 0);
    for (k, first) in first.iter_mut().enumerate() {
        let (from, to) = (segment.origin[k], segment.origin[k] + segment.slope[k]);
        let low = (from.min(to) - BESIDE).max(0.0) as i32;
        let high = ((from.max(to) + BESIDE) as i32).min(cells - 1);
        *first = low ^ sweep.turn[k];
        differing |= low ^ high;
    }
    // Level l holds cells that agree above their 4 + 2 l low bits.
    let bits = 32 - differing.leading_zeros();
    let level = bits.saturating_sub(3) / 2;
    (level as usize, first.map(|cell| cell >> (4 + 2 * level)))
}
