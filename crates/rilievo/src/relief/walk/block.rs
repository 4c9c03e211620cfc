//! [`Blocks`]: one ray against the sixteen cells of a block, the leaf in lanes.
//!
//! The formulas are those of `leaf`, operation by operation, so their bits are too. Lanes only find
//! out which cells have a root; the root itself is computed by the leaf's own function for the cell
//! met first, so that one division and one square root are enough.

use crate::map::{Axis, HeightMap, Samples};
use crate::simd::{Lanes, WIDTH};

use super::super::leaf::{Crossings, Gap, LeafHit};
use super::super::map_ray::MapRay;
use super::super::tile;
use super::TileFrame;

/// Column and row of each lane.
static PLACES: [[f32; WIDTH]; 2] = [
    [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0],
    [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0],
];

/// A ray in a tile, ready to be tested against blocks.
pub(super) struct Blocks<'a> {
    map: &'a HeightMap,
    ray: &'a MapRay,
    frame: &'a TileFrame,
}

/// Sixteen roots to be.
struct Gaps<L: Lanes> {
    t0: L,
    t1: L,
    b0: L,
    b1: L,
    b2: L,
    candidates: u16,
}

/// The place in the cell at both ends of a span along one axis.
struct Ends<L: Lanes> {
    t_near: L,
    t_far: L,
    near_line: L,
    far_line: L,
    f: L,
}

impl<'a> Blocks<'a> {
    #[inline(always)]
    pub fn new(map: &'a HeightMap, ray: &'a MapRay, frame: &'a TileFrame) -> Self {
        Self { map, ray, frame }
    }

    /// The first admitted crossing in the block with its corner at a mirrored cell.
    #[inline(always)]
    pub fn first_hit<L: Lanes>(&self, corner: [i32; 2], admit: Crossings) -> Option<LeafHit> {
        let [x, y] = self.frame.origin;
        let first = [corner[0] - x, corner[1] - y];
        let gaps = self.gaps::<L>(first, self.corners(corner));
        if gaps.candidates == 0 { None } else { self.first_of(&gaps, first, admit) }
    }

    /// The first admitted crossing among the candidates of a block.
    #[inline(always)]
    fn first_of<L: Lanes>(
        &self,
        gaps: &Gaps<L>,
        first: [i32; 2],
        admit: Crossings,
    ) -> Option<LeafHit> {
        let (t0, t1) = (gaps.t0.store(), gaps.t1.store());
        let (b0, b1, b2) = (gaps.b0.store(), gaps.b1.store(), gaps.b2.store());
        let mut candidates = gaps.candidates;
        while candidates != 0 {
            let lane = candidates.trailing_zeros() as usize % WIDTH;
            candidates &= candidates - 1;
            let gap = Gap { b0: b0[lane], b1: b1[lane], b2: b2[lane] };
            let cell = [first[0] + (lane as i32 & 3), first[1] + (lane as i32 >> 2)];
            if let Some(hit) = gap.first_hit([t0[lane], t1[lane]], cell, admit)
                && tile::confirms(self.map, self.ray, (t0[lane], &hit), admit)
            {
                return Some(hit);
            }
        }
        None
    }

    /// Gaps over the cells of the block that begins at a forward cell.
    #[inline(always)]
    fn gaps<L: Lanes>(&self, first: [i32; 2], corners: [L; 4]) -> Gaps<L> {
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        let x: Ends<L> = self.ends(0, first[0]);
        let y: Ends<L> = self.ends(1, first[1]);
        let t0 = x.t_near.larger(y.t_near).larger(zero);
        let t1 = x.t_far.smaller(y.t_far).smaller(one);
        let [cull_in, cull_out] = self.ray.cull;
        let cull = L::and(L::splat(cull_in).at_most(t1), t0.at_most(L::splat(cull_out)));
        let active = L::and(t0.below(t1), cull);
        let (xa, xb) = self.locals(0, &x, t0, t1);
        let (ya, yb) = self.locals(1, &y, t0, t1);
        let [h00, h10, h01, h11] = corners;
        let (near_a, far_a) = (lerp(h00, h01, ya), lerp(h10, h11, ya));
        let (near_b, far_b) = (lerp(h00, h01, yb), lerp(h10, h11, yb));
        let (dz, oz) = (L::splat(self.ray.dz), L::splat(self.ray.oz));
        let (za, zb) = (t0.times(dz).plus(oz), t1.times(dz).plus(oz));
        let b0 = za.minus(lerp(near_a, far_a, xa));
        let crossed = lerp(near_b, far_b, xa).plus(lerp(near_a, far_a, xb));
        let b1 = za.plus(zb).minus(crossed).times(L::splat(0.5));
        let b2 = zb.minus(lerp(near_b, far_b, xb));
        // Seen from the side of the start.
        let (start, middle, end) = (b0.turned_by(b0), b1.turned_by(b0), b2.turned_by(b0));
        let dips = L::and(middle.below(zero), zero.at_most(b1.times(b1).minus(b0.times(b2))));
        let root = L::or(L::or(start.at_most(zero), end.at_most(zero)), dips);
        Gaps { t0, t1, b0, b1, b2, candidates: L::bits(L::and(active, root)) }
    }

    /// Lines of the cells along one axis, cut to the tile, and their parameters. A cell of the tile
    /// has the lines that the leaf gives it; one beyond has none between them.
    #[inline(always)]
    fn ends<L: Lanes>(&self, axis: usize, first: i32) -> Ends<L> {
        let (o, inv) = (L::splat(self.ray.o[axis]), L::splat(self.ray.inv[axis]));
        let f = L::splat(first as f32).plus(L::load(&PLACES[axis]));
        let near_line = f.larger(L::splat(self.frame.lo[axis]));
        let far_line = f.plus(L::splat(1.0)).smaller(L::splat(self.frame.hi[axis]));
        Ends {
            t_near: near_line.minus(o).times(inv),
            t_far: far_line.minus(o).times(inv),
            near_line,
            far_line,
            f,
        }
    }

    /// Local coordinates where the ray enters and leaves.
    #[inline(always)]
    fn locals<L: Lanes>(&self, axis: usize, ends: &Ends<L>, t0: L, t1: L) -> (L, L) {
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        let d = L::splat(self.ray.d[axis]);
        let start = ends.f.minus(L::splat(self.ray.o[axis]));
        let enter = t0.times(d).minus(start).larger(zero).smaller(one);
        let leave = t1.times(d).minus(start).larger(zero).smaller(one);
        (
            ends.near_line.minus(ends.f).where_else(t0.at_most(ends.t_near), enter),
            ends.far_line.minus(ends.f).where_else(ends.t_far.at_most(t1), leave),
        )
    }

    /// Corner heights of the block with its corner at a mirrored cell.
    #[inline(always)]
    fn corners<L: Lanes>(&self, corner: [i32; 2]) -> [L; 4] {
        let mirror = self.frame.mirror();
        // The stored cell of the block with the smallest indices.
        let x = if mirror.x { !(corner[0] + 3) } else { corner[0] };
        let y = if mirror.y { !(corner[1] + 3) } else { corner[1] };
        let cell = [x as u32, y as u32];
        match self.map.samples() {
            Samples::U16(samples) => {
                let mut spare = [[0; 8]; 5];
                let rows = block_rows(self.map, samples, cell, &mut spare);
                L::corners_u16(in_order(rows, mirror.y), mirror.x)
            }
            Samples::F32(samples) => {
                let mut spare = [[0.0; 8]; 5];
                let rows = block_rows(self.map, samples, cell, &mut spare);
                L::corners_f32(in_order(rows, mirror.y), mirror.x)
            }
        }
    }
}

/// Linear interpolation as `leaf::lerp`.
#[inline(always)]
fn lerp<L: Lanes>(a: L, b: L, t: L) -> L {
    t.times(b).plus(a.minus(t.times(a)))
}

/// Rows in the order of the forward cells.
#[inline(always)]
fn in_order<T>(rows: [&T; 5], backward: bool) -> [&T; 5] {
    let [a, b, c, d, e] = rows;
    if backward { [e, d, c, b, a] } else { rows }
}

/// The five rows of samples of the block of stored cells at `cell`; the first five of each count. A
/// block whose rows do not lie whole in the map is put together in `spare`.
#[inline(always)]
fn block_rows<'a, T: Copy>(
    map: &HeightMap,
    samples: &'a [T],
    cell: [u32; 2],
    spare: &'a mut [[T; 8]; 5],
) -> [&'a [T; 8]; 5] {
    let (width, height) = (map.width() as i32, map.height() as i32);
    let x = cell[0] as i32 + map.x().first_cell();
    let y = cell[1] as i32 + map.y().first_cell();
    if x >= 0 && y >= 0 && x + 5 <= width && y + 5 <= height {
        let at = y as usize * width as usize + x as usize;
        let width = width as usize;
        // The last row reaches farthest: one check serves all.
        if let Some(part) = samples.get(at..at + 4 * width + 8) {
            let rows = [
                part.first_chunk(),
                part[width..].first_chunk(),
                part[2 * width..].first_chunk(),
                part[3 * width..].first_chunk(),
                part[4 * width..].first_chunk(),
            ];
            if let [Some(a), Some(b), Some(c), Some(d), Some(e)] = rows {
                return [a, b, c, d, e];
            }
        }
    }
    gather_rows(map, samples, cell, spare);
    spare.each_ref()
}

/// The rows of a block at the border of the map, sample by sample.
#[cold]
#[inline(never)]
fn gather_rows<T: Copy>(map: &HeightMap, samples: &[T], cell: [u32; 2], rows: &mut [[T; 8]; 5]) {
    // Samples at the five lines of the block; lines beyond the last cell repeat its far one.
    let lines = |axis: &Axis, first: u32| {
        let last = axis.cells() - 1;
        std::array::from_fn::<_, 5, _>(|k| {
            let c = first + k as u32;
            if c <= last { axis.corners(c).0 } else { axis.corners(last).1 }
        })
    };
    let (columns, lines) = (lines(map.x(), cell[0]), lines(map.y(), cell[1]));
    for (row, j) in rows.iter_mut().zip(lines) {
        for (sample, i) in row.iter_mut().zip(columns) {
            *sample = samples[j as usize * map.width() as usize + i as usize];
        }
    }
}
