//! [`Blocks`]: one ray against the sixteen cells of a block, the leaf in lanes.
//!
//! Lanes only find out which cells have a root (see `gaps`); the root itself is computed by the
//! leaf's own function for the cell met first, so that one division and one square root are enough.

use crate::map::{Axis, HeightMap, Samples};
use crate::simd::{Lanes, Mirror, WIDTH};

use super::super::leaf::{Crossings, LeafHit};
use super::super::map_ray::MapRay;
use super::super::tile;
use super::TileFrame;
use super::gaps::{Gaps, LaneRay, StoredGaps};

/// Column and row of each lane.
pub(crate) static PLACES: [[f32; WIDTH]; 2] = [
    [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0],
    [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0],
];

/// A ray in a tile, ready to be tested against blocks.
pub(crate) struct Blocks<'a> {
    map: &'a HeightMap,
    ray: &'a MapRay,
    frame: &'a TileFrame,
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
        let cells = [
            L::splat(first[0] as f32).plus(L::load(&PLACES[0])),
            L::splat(first[1] as f32).plus(L::load(&PLACES[1])),
        ];
        let corners = block_corners(self.map, self.frame.mirror(), corner);
        let gaps = LaneRay::<L>::of(self.ray, self.frame).gaps(cells, corners);
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
        if admit == Crossings::Both {
            let (roots, lane) = (gaps.roots(), first_lane(gaps.candidates));
            if roots.sure >> lane & 1 == 1 {
                let from_above = roots.from_above >> lane & 1 == 1;
                return Some(LeafHit {
                    s: roots.s.store()[lane],
                    cell: cell_at(first, lane),
                    from_above,
                });
            }
        }
        self.first_confirmed(&gaps.store(), gaps.candidates, first, admit)
    }

    /// [`Blocks::first_of`], one candidate after the other, confirmed by the unrounded ray.
    #[inline(never)]
    fn first_confirmed(
        &self,
        gaps: &StoredGaps,
        mut candidates: u16,
        first: [i32; 2],
        admit: Crossings,
    ) -> Option<LeafHit> {
        while candidates != 0 {
            let lane = first_lane(candidates);
            candidates &= candidates - 1;
            if let Some((t0, hit)) = gaps.hit(lane, cell_at(first, lane), admit)
                && tile::confirms(self.map, self.ray, (t0, &hit), admit)
            {
                return Some(hit);
            }
        }
        None
    }
}

/// The first lane of some.
#[inline(always)]
pub(crate) fn first_lane(lanes: u16) -> usize {
    lanes.trailing_zeros() as usize % WIDTH
}

/// The cell of a lane of the block at `first`.
#[inline(always)]
pub(crate) fn cell_at(first: [i32; 2], lane: usize) -> [i32; 2] {
    [first[0] + (lane as i32 & 3), first[1] + (lane as i32 >> 2)]
}

/// Corner heights of the block with its corner at a mirrored cell.
#[inline(always)]
pub(crate) fn block_corners<L: Lanes>(map: &HeightMap, mirror: Mirror, corner: [i32; 2]) -> [L; 4] {
    // The stored cell of the block with the smallest indices.
    let x = if mirror.x { !(corner[0] + 3) } else { corner[0] };
    let y = if mirror.y { !(corner[1] + 3) } else { corner[1] };
    let cell = [x as u32, y as u32];
    match map.samples() {
        Samples::U16(samples) => match whole_rows(map, samples, cell) {
            Some(rows) => L::corners_u16(in_order(rows, mirror.y), mirror.x),
            None => {
                let rows = gathered_rows(map, samples, cell);
                L::corners_u16(in_order(rows.each_ref(), mirror.y), mirror.x)
            }
        },
        Samples::F32(samples) => match whole_rows(map, samples, cell) {
            Some(rows) => L::corners_f32(in_order(rows, mirror.y), mirror.x),
            None => {
                let rows = gathered_rows(map, samples, cell);
                L::corners_f32(in_order(rows.each_ref(), mirror.y), mirror.x)
            }
        },
    }
}

/// Rows in the order of the forward cells.
#[inline(always)]
fn in_order<T>(rows: [&T; 5], backward: bool) -> [&T; 5] {
    let [a, b, c, d, e] = rows;
    if backward { [e, d, c, b, a] } else { rows }
}

/// The five rows of samples of the block of stored cells at `cell`, of which the first five samples
/// count, if they lie whole in the map.
#[inline(always)]
fn whole_rows<'a, T>(map: &HeightMap, samples: &'a [T], cell: [u32; 2]) -> Option<[&'a [T; 8]; 5]> {
    let (width, height) = (map.width() as i32, map.height() as i32);
    let x = cell[0] as i32 + map.x().first_cell();
    let y = cell[1] as i32 + map.y().first_cell();
    if x < 0 || y < 0 || x + 5 > width || y + 5 > height {
        return None;
    }
    let width = width as usize;
    let first = samples.get(y as usize * width + x as usize..)?;
    let second = first.get(width..)?;
    let third = second.get(width..)?;
    let fourth = third.get(width..)?;
    let fifth = fourth.get(width..)?;
    Some([
        first.first_chunk()?,
        second.first_chunk()?,
        third.first_chunk()?,
        fourth.first_chunk()?,
        fifth.first_chunk()?,
    ])
}

/// The rows of a block at the border of the map, sample by sample.
#[cold]
#[inline(never)]
fn gathered_rows<T: Copy + Default>(map: &HeightMap, samples: &[T], cell: [u32; 2]) -> [[T; 8]; 5] {
    // Samples at the five lines of the block; lines beyond the last cell repeat its far one.
    let lines = |axis: &Axis, first: u32| {
        let last = axis.cells() - 1;
        std::array::from_fn::<_, 5, _>(|k| {
            let c = first + k as u32;
            if c <= last { axis.corners(c).0 } else { axis.corners(last).1 }
        })
    };
    let (columns, lines) = (lines(map.x(), cell[0]), lines(map.y(), cell[1]));
    let mut rows = [[T::default(); 8]; 5];
    for (row, j) in rows.iter_mut().zip(lines) {
        for (sample, i) in row.iter_mut().zip(columns) {
            *sample = samples[j as usize * map.width() as usize + i as usize];
        }
    }
    rows
}
