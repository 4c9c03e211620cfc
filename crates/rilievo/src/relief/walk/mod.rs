//! Method `pyramid`: descent of the min-max pyramid, front to back, sixteen lanes at a time.
//!
//! **Frame.** Stored cells are counted in mirrored coordinates: `g = c` along an axis on which the
//! ray rises through them, `g = !c` (that is `-1 - c`) where it falls. Then every direction rises,
//! blocks stay aligned to powers of four (`g & -size` is the corner of the block that holds `g`, by
//! two's complement also below 0), and only loads know about mirroring: they permute lanes.
//!
//! **Order.** A path rises in x and in y, so lane `4 y + x` rises along it: the lowest set bit of a
//! node's mask is the child met first. No sorting and no stored parameters. Because the intervals
//! of children tile their node's, the first hit found is the nearest.
//!
//! **Stack.** Sixteen bits a level, the deepest level in the lowest: the position of the lowest set
//! bit names level and lane, and clearing low bits of the current `g` names the node. Levels 0 to 3
//! (1024 cells a side) are one 64-bit word; a second one is looked at when the first is empty.
//!
//! **Climb.** A ray that starts inside the height range starts at the level-0 node of its own cell.
//! When nothing is left to do, the parent is tested with the lanes up to the child just left
//! cleared, up to the smallest node that also holds the ray's end. Cells at cleared lanes lie behind
//! the start along x or y: their interval ends at or before 0, and the leaf would skip them.
//!
//! **No miss.** A child is visited unless its interval is empty or the ray's height over that
//! interval, widened by the slack of the cull, stays outside the child's bounds. The height
//! `z(s) = s dz + oz` is monotone in floating point, so over any cell of the child it lies within
//! the two ends as computed; the leaf's proof (see `leaf`) says that such a cell has no root. The
//! interval is cut to the ray's `cull` and to the tile here but not in the leaf: outside `cull` the
//! ray is clear of the whole map's range by more than the slack, or past its own end. A ray that is
//! known to start above the surface stays above it until its first root, so minima could not cull
//! anything: they are not read.
//!
//! **Slack of the cull.** The test computes `s dz + (oz -+ c)` with `c = 2 slack` instead of
//! `(s dz + oz) -+ slack`: one operation less. Both roundings that differ are below `ulp(2 A)` each
//! as long as the ray is inside the padded height range, i.e. below `slack / 4`; so the computed
//! height is beyond the leaf's by at least `slack`, which is what the leaf's proof asks for.

mod block;
mod frame;
mod node;

use crate::map::{HeightMap, Pyramid};
use crate::probe::Probe;
use crate::simd::Lanes;

use super::leaf::{Crossings, LeafHit};
use super::map_ray::MapRay;
use block::Blocks;
use node::Nodes;

pub(crate) use frame::TileFrame;

/// Levels in the first word of the stack.
const LOW_LEVELS: u32 = 4;

/// The first admitted crossing in a tile, found through the pyramid.
#[inline(always)]
pub(crate) fn walk_pyramid<L: Lanes, P: Probe>(
    (map, pyramid): (&HeightMap, &Pyramid),
    ray: &MapRay,
    frame: &TileFrame,
    admit: Crossings,
    probe: &mut P,
) -> Option<LeafHit> {
    let nodes = Nodes::new(pyramid, ray, frame);
    let blocks = Blocks::new(map, ray, frame);
    let top = pyramid.levels() - 1;
    let start = nodes.start();
    // The next node to test when nothing is left to do, and the last one.
    let (mut next, last, home) = match start {
        Some(start) => (0, start.last_level.min(top), start.cell),
        None => (top, top, frame.turn),
    };
    let [mut x, mut y] = home;
    let (mut todo, mut high) = (0u64, 0u64);
    loop {
        if todo != 0 {
            let bit = todo.trailing_zeros();
            todo &= todo - 1;
            let (level, lane) = (bit / 16, (bit % 16) as i32);
            [x, y] = child([x, y], level, lane);
            if level == 0 {
                probe.cell();
                if let Some(hit) = blocks.first_hit::<L>([x, y], admit) {
                    return Some(hit);
                }
            } else {
                probe.node();
                todo |= u64::from(nodes.met::<L>(level - 1, [x, y])) << (16 * (level - 1));
            }
        } else if high != 0 {
            let bit = high.trailing_zeros();
            high &= high - 1;
            let (level, lane) = (bit / 16 + LOW_LEVELS, (bit % 16) as i32);
            [x, y] = child([x, y], level, lane);
            probe.node();
            push((&mut todo, &mut high), level - 1, nodes.met::<L>(level - 1, [x, y]));
        } else if next <= last {
            [x, y] = home;
            probe.node();
            let mut mask = nodes.met::<L>(next, home);
            if next > 0 && start.is_some() {
                mask &= !1u16 << lane_of(home, next);
            }
            push((&mut todo, &mut high), next, mask);
            next += 1;
        } else {
            return None;
        }
    }
}

/// Adds the lanes of a node to the words of the stack.
#[inline(always)]
fn push((low, high): (&mut u64, &mut u64), level: u32, mask: u16) {
    if level < LOW_LEVELS {
        *low |= u64::from(mask) << (16 * level);
    } else {
        *high |= u64::from(mask) << (16 * (level - LOW_LEVELS));
    }
}

/// Corner of the block at a lane of the node of `level` that holds `cell`.
#[inline(always)]
fn child(cell: [i32; 2], level: u32, lane: i32) -> [i32; 2] {
    let side = 2 * level + 2;
    let node = -1i32 << (side + 2);
    [(cell[0] & node) + ((lane & 3) << side), (cell[1] & node) + ((lane >> 2) << side)]
}

/// The lane that holds `cell` in its node of `level`.
#[inline(always)]
fn lane_of(cell: [i32; 2], level: u32) -> u32 {
    let [x, y] = cell.map(|g| (g >> (2 * level + 2)) as u32 & 3);
    4 * y + x
}
