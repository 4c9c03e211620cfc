//! Method `dda`: every cell under the ray, in order, no hierarchy \[Amanatides1987, Musgrave1988\].
//!
//! Unlike the textbook walk, no parameter is accumulated: each comes from its line's integer index,
//! so the cells visited are exactly those whose interval is not empty.

use crate::map::HeightMap;
use crate::probe::Probe;

use super::leaf::{Crossings, LeafHit, Span};
use super::map_ray::MapRay;
use super::tile::Tile;

/// The first admitted crossing among the tile's cells from the one at `from` on, without those that
/// begin at or after `to`.
#[inline(never)]
pub(crate) fn walk_cells<P: Probe>(
    map: &HeightMap,
    ray: &MapRay,
    tile: &Tile,
    [from, to]: [f32; 2],
    (admit, probe): (Crossings, &mut P),
) -> Option<LeafHit> {
    let mut cell = tile.cell_at(ray, from);
    loop {
        probe.cell();
        if let Some(span) = Span::new(ray, cell[0], cell[1])
            && let Some(hit) = tile.intersect(map, ray, (cell, &span), admit)
        {
            return Some(hit);
        }
        let far = [ray.t_far(0, cell[0]), ray.t_far(1, cell[1])];
        let leave = far[0].min(far[1]);
        let mut ended = leave >= to;
        for axis in 0..2 {
            if far[axis] <= leave {
                cell[axis] += 1;
                ended |= cell[axis] >= tile.axes[axis].to;
            }
        }
        if ended {
            return None;
        }
    }
}
