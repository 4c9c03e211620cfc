//! The `f64` answers of a batch: `refine` for all rays at once.
//!
//! Nearly every root lies inside of its cell; the loop over the rays then has no branch. The others
//! are refined one by one.

use crate::map::HeightMap;
use crate::ray::Ray;

use super::super::refine::{self, Root};
use super::super::trace::{Crossing, refined_across};
use super::{BATCH, Batch, BatchHits, lanes_of};

/// Roots side by side.
struct Roots {
    s: [f64; BATCH],
    local: [[f64; BATCH]; 2],
    raw: [f64; BATCH],
    error: [f64; BATCH],
    /// 1 where the root lies inside of its cell.
    inside: [u64; BATCH],
}

impl Batch<'_> {
    /// Writes the crossings of the rays that met the surface before their ends; `rising` where larger
    /// raw heights lie in front.
    #[inline(always)]
    pub fn answer(
        &self,
        hits: &BatchHits,
        (heights, rising): (&HeightMap, bool),
        rays: &[Ray],
        found: &mut [Option<Crossing>],
    ) {
        let mut corners = [[0.0f32; BATCH]; 4];
        let (mut cells, mut s0) = ([[0; BATCH]; 2], [0.0; BATCH]);
        for k in lanes_of(hits.any) {
            let cell = self.lanes.unfolded(k, hits.cell[k]);
            let [h00, h10, h01, h11] = self.placement.corners(heights, cell);
            (corners[0][k], corners[1][k], corners[2][k], corners[3][k]) = (h00, h10, h01, h11);
            (cells[0][k], cells[1][k]) = (cell[0], cell[1]);
            s0[k] = f64::from(hits.s[k]);
        }
        let window = &self.placement.window;
        let roots = self.roots(&corners, &cells, &s0);
        for k in lanes_of(hits.any) {
            let (cell, t_max) = ([cells[0][k], cells[1][k]], rays[k].t_max);
            let front = (hits.from_above >> k & 1 == 1) == rising;
            found[k] = if roots.inside[k] == 1 {
                let root = Root {
                    s: roots.s[k],
                    cell,
                    local: [roots.local[0][k], roots.local[1][k]],
                    raw: roots.raw[k],
                    error: roots.error[k],
                };
                Crossing::of_surface(&self.clipped.exact(k), t_max, &root, front)
            } else {
                let maps = (heights, window);
                refined_across(&self.clipped.exact(k), t_max, maps, (cell, s0[k], front))
            };
        }
    }

    /// The roots of all rays over cells with given corner heights.
    #[inline(always)]
    fn roots(
        &self,
        corners: &[[f32; BATCH]; 4],
        cells: &[[i32; BATCH]; 2],
        s0: &[f64; BATCH],
    ) -> Roots {
        let none = [0.0; BATCH];
        let mut to =
            Roots { s: none, local: [none; 2], raw: none, error: none, inside: [0; BATCH] };
        for k in 0..BATCH {
            let h = [corners[0][k], corners[1][k], corners[2][k], corners[3][k]];
            let cell = [cells[0][k], cells[1][k]];
            let (root, inside) =
                refine::inside(&self.clipped.exact(k), &self.placement.window, (cell, h), s0[k]);
            to.s[k] = root.s;
            (to.local[0][k], to.local[1][k]) = (root.local[0], root.local[1]);
            (to.raw[k], to.error[k]) = (root.raw, root.error);
            to.inside[k] = u64::from(inside);
        }
        to
    }
}
