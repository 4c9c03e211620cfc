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
//! (1024 cells a side) are one 64-bit word; others are looked at when it is empty.
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
//! anything: they are not read. Known it is of rays that enter through the top and of those that leave
//! the surface upward. A look at the surface under all others costs as much as the minima of the few
//! nodes they meet (measured: shadow and diffuse rays, no difference beyond 4 %).
//!
//! **Slack of the cull (proof).** The test computes `s dz + oz'` with `oz'` the float next below (or
//! above) `oz -+ 2 slack`, instead of `(s dz + oz) -+ slack`: one operation less. `oz'` is beyond
//! `oz` by at least `2 slack`, however coarse the floats at `oz`: half a step may be lost in the
//! difference, and a whole one is added. The product is the leaf's own. Each of the two sums that
//! differ rounds by at most `ulp(2 A) / 2 = slack / 8` while the height is inside the padded range.
//! So the computed height is beyond the leaf's by more than `slack`, which the leaf's proof asks for.

mod block;
mod frame;
mod gaps;
mod node;
mod stack;

use crate::map::{HeightMap, Pyramid};
use crate::probe::Probe;
use crate::simd::Lanes;

use super::leaf::{Crossings, LeafHit};
use super::map_ray::MapRay;
use node::Nodes;
use stack::lane_of;

use block::Blocks;

pub(crate) use block::{PLACES, block_corners, cell_at, first_lane};
pub(crate) use frame::{TileFrame, Unfolding};
pub(crate) use gaps::{Gaps, LaneRay, StoredGaps};
pub(crate) use node::{LINES, Side, bound, culled_heights};
pub(crate) use stack::{Stack, child};

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
    let mut at = home;
    let mut stack = Stack::default();
    loop {
        if let Some((level, lane)) = stack.pop() {
            at = child(at, level, lane);
            if level > 0 {
                probe.node();
                stack.push(level - 1, nodes.met::<L>(level - 1, at));
                continue;
            }
            probe.cell();
            if let Some(hit) = blocks.first_hit::<L>(at, admit) {
                return Some(hit);
            }
        } else if next <= last {
            at = home;
            probe.node();
            let mut met = nodes.met::<L>(next, home);
            if next > 0 && start.is_some() {
                met &= !1u16 << lane_of(home, next);
            }
            stack.push(next, met);
            next += 1;
        } else {
            return None;
        }
    }
}
