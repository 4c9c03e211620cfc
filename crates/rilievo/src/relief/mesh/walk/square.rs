//! [`Square`]: a path over a square of 4 x 4 equal parts, in sixteen lanes.
//!
//! **Rounding.** Parameters run from 0 to 1 over the span; all coordinates there, counted from the
//! square's corner, are at most `room`, the largest of those of the span's ends and the side, plus
//! error. Rounding start and speed to `f32` moves a point by at most `3 u room`, `u = 2^-24`; a
//! computed parameter of a line is the exact one of a line moved by `4 u` of its distance from the start, at most
//! `8 u room`; a speed below `2^-20 room` is taken for that, which moves a point by as much.
//! All this is less than `2^-18 room`, by which the error is widened. Heights likewise, their room
//! being the range of the map plus the error.

use glam::DVec3;

use crate::map::{Axis, HeightMap, NodeBounds, Samples};
use crate::simd::{Lanes, Mirror, WIDTH};

use super::super::ReliefMesh;
use super::super::frame::Path;

/// Column and row of each lane.
static PLACES: [[f32; WIDTH]; 2] = [
    [0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0],
    [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0],
];

/// Share of the room by which errors are widened, and of which a speed is at least a quarter.
const WIDENING: f64 = 1.0 / (1 << 18) as f64;

/// A path over a square, rounded.
pub(super) struct Square {
    start: [f32; 3],
    speed: [f32; 3],
    inverse: [f32; 3],
    error: [f32; 3],
    /// Side of a part, cells.
    part: f32,
    /// Bound on the heights of the map, from the level.
    half_range: f32,
}

/// What a path meets of sixteen parts.
pub(super) struct Met<L> {
    pub bits: u16,
    /// Parameters over the span.
    pub near: L,
    pub far: L,
}

/// The surfaces of cells.
#[derive(Clone, Copy)]
struct Bilinear<L> {
    h00: L,
    h01: L,
    /// Slopes along x at the low and at the high side.
    low: L,
    high: L,
}

impl<L: Lanes> Bilinear<L> {
    #[inline(always)]
    fn at(self, x: L, y: L) -> L {
        let low = self.low.times(x).plus(self.h00);
        self.high.times(x).plus(self.h01).minus(low).times(y).plus(low)
    }
}

/// Without its sign.
#[inline(always)]
fn size<L: Lanes>(a: L) -> L {
    a.larger(L::splat(0.0).minus(a))
}

impl Square {
    /// The square of `side` cells at `corner`.
    #[inline(always)]
    pub fn new(
        path: &Path,
        [from, to]: [f64; 2],
        corner: [f64; 2],
        (side, mesh): (i32, &ReliefMesh),
    ) -> Self {
        let corner = DVec3::new(corner[0], corner[1], 0.0);
        let (a, b) = (path.at(from) - corner, path.at(to) - corner);
        let half_range = mesh.offsets.half_range;
        let room = DVec3::new(f64::from(side), f64::from(side), 2.0 * half_range);
        let room = room.max(a.abs()).max(b.abs()) + path.error;
        // What is spared for heights keeps flat maps from dividing by zero.
        let room = room + DVec3::new(0.0, 0.0, mesh.height_slack + 1e-30);
        let mut square = Self {
            start: [0.0; 3],
            speed: [0.0; 3],
            inverse: [0.0; 3],
            error: [0.0; 3],
            part: side as f32 * 0.25,
            half_range: half_range as f32,
        };
        for k in 0..3 {
            let least = (0.25 * WIDENING * room[k]) as f32;
            let speed = (b[k] - a[k]) as f32;
            let speed = if speed.abs() < least { least } else { speed };
            square.start[k] = a[k] as f32;
            square.speed[k] = speed;
            square.inverse[k] = 1.0 / speed;
            let slack = if k == 2 { mesh.height_slack } else { super::super::footprint::MARGIN };
            square.error[k] = (path.error[k] + slack + WIDENING * room[k]) as f32;
        }
        square
    }

    /// Parameters between two lines across an axis.
    #[inline(always)]
    fn between<L: Lanes>(&self, axis: usize, low: L, high: L) -> [L; 2] {
        let (start, error) = (self.start[axis], self.error[axis]);
        let inverse = L::splat(self.inverse[axis]);
        let low = low.minus(L::splat(start + error)).times(inverse);
        let high = high.minus(L::splat(start - error)).times(inverse);
        if self.speed[axis] < 0.0 { [high, low] } else { [low, high] }
    }

    /// A coordinate at a parameter.
    #[inline(always)]
    fn point<L: Lanes>(&self, axis: usize, t: L) -> L {
        t.times(L::splat(self.speed[axis])).plus(L::splat(self.start[axis]))
    }

    /// The parts met between these heights.
    #[inline(always)]
    pub fn parts<L: Lanes>(&self, low: L, high: L) -> Met<L> {
        let part = L::splat(self.part);
        let x = L::load(&PLACES[0]).times(part);
        let y = L::load(&PLACES[1]).times(part);
        let [near_x, far_x] = self.between(0, x, x.plus(part));
        let [near_y, far_y] = self.between(1, y, y.plus(part));
        let [near_h, far_h] = self.between(2, low, high);
        let near = near_x.larger(near_y).larger(near_h).larger(L::splat(0.0));
        let far = far_x.smaller(far_y).smaller(far_h).smaller(L::splat(1.0));
        Met { bits: L::bits(near.at_most(far)), near, far }
    }

    /// The cells of a block of 4 x 4 that the path may touch, by their corners `h00 h10 h01 h11` and
    /// the lowest and highest of each.
    ///
    /// At a root the path is within the error of a point of the cell, so its gap over the
    /// surface, `z - H(x, y)`, is at most `m = e_h + L_x e_x + L_y e_y` in size, `L` being bounds
    /// on the slopes. The gap is a quadratic in the parameter and lies between its Bernstein
    /// coefficients: a cell is left out where all three are above `m` or all below `-m`.
    #[inline(always)]
    pub fn cells<L: Lanes>(&self, [h00, h10, h01, h11]: [L; 4], [low, high]: [L; 2]) -> Met<L> {
        let Met { bits, near, far } = self.parts(low, high);
        if bits == 0 {
            return Met { bits, near, far };
        }
        let (cx, cy) = (L::load(&PLACES[0]), L::load(&PLACES[1]));
        let (xa, xb) = (self.point(0, near).minus(cx), self.point(0, far).minus(cx));
        let (ya, yb) = (self.point(1, near).minus(cy), self.point(1, far).minus(cy));
        let (za, zb) = (self.point(2, near), self.point(2, far));
        let surface = Bilinear { h00, h01, low: h10.minus(h00), high: h11.minus(h01) };
        let b0 = za.minus(surface.at(xa, ya));
        let b2 = zb.minus(surface.at(xb, yb));
        let half = L::splat(0.5);
        let b1 = za.plus(zb).minus(surface.at(xa, yb).plus(surface.at(xb, ya))).times(half);
        let (low, high) = (surface.low, surface.high);
        let twist = size(high.minus(low));
        let [ex, ey, eh] = self.error;
        let lx = size(low).larger(size(high)).plus(twist.times(L::splat(ey)));
        let (slope_left, slope_right) = (h01.minus(h00), h11.minus(h10));
        let ly = size(slope_left).larger(size(slope_right)).plus(twist.times(L::splat(ex)));
        // Rounding of the coefficients: heights grow outside of their cell.
        let grown = self.half_range * (1.0 + 2.0 * ex) * (1.0 + 2.0 * ey);
        let rounding = (grown + eh) * (1.0 / (1 << 19) as f32);
        let m = lx.times(L::splat(ex)).plus(ly.times(L::splat(ey))).plus(L::splat(eh + rounding));
        let most = b0.larger(b1).larger(b2);
        let least = b0.smaller(b1).smaller(b2);
        let near_surface = L::and(least.at_most(m), L::splat(0.0).minus(m).at_most(most));
        Met { bits: bits & L::bits(near_surface), near, far }
    }
}

/// Lowest and highest heights of the children of a node, over the level, forward.
#[inline(always)]
pub(super) fn child_heights<L: Lanes>(
    mesh: &ReliefMesh,
    level: u32,
    place: [i32; 2],
    turn: [i32; 2],
) -> [L; 2] {
    let pyramid = mesh.relief.pyramid();
    let across = pyramid.nodes(level)[0] as usize;
    let (x, y) = ((place[0] ^ turn[0]) as usize, (place[1] ^ turn[1]) as usize);
    let mirror = Mirror { x: turn[0] != 0, y: turn[1] != 0 };
    let (high, low) = match pyramid.node(level, y * across + x) {
        NodeBounds::Wide { max, min } => (L::from_u16(max, mirror), L::from_u16(min, mirror)),
        NodeBounds::Tiny { max, min, base, step } => {
            let (base, step) = (L::splat(base), L::splat(step));
            let high = base.plus(L::from_u8(max, mirror).times(step));
            (high, base.plus(L::from_u8(min, mirror).times(step)))
        }
    };
    let code = pyramid.code();
    let (base, step) = (L::splat(code.base), L::splat(code.step));
    let level = L::splat(mesh.offsets.level);
    let low = base.plus(low.times(step)).minus(level);
    [low, base.plus(high.times(step)).minus(level)]
}

/// Corners `h00 h10 h01 h11` of the cells of a block, over the level, forward.
#[inline(always)]
pub(super) fn cell_corners<L: Lanes>(mesh: &ReliefMesh, place: [i32; 2], turn: [i32; 2]) -> [L; 4] {
    let map = mesh.relief.heights();
    let cell = [4 * (place[0] ^ turn[0]) as u32, 4 * (place[1] ^ turn[1]) as u32];
    let [h00, h10, h01, h11] = match map.samples() {
        Samples::U16(samples) => {
            let mut border = [[0; 8]; 5];
            let rows = block_rows(map, samples, cell, &mut border);
            L::corners_u16(in_order(rows, turn[1] != 0), turn[0] != 0)
        }
        Samples::F32(samples) => {
            let mut border = [[0.0; 8]; 5];
            let rows = block_rows(map, samples, cell, &mut border);
            L::corners_f32(in_order(rows, turn[1] != 0), turn[0] != 0)
        }
    };
    let level = L::splat(mesh.offsets.level);
    [h00.minus(level), h10.minus(level), h01.minus(level), h11.minus(level)]
}

/// Asks for the samples of a block before they are needed.
#[inline(always)]
pub(super) fn fetch_block<L: Lanes>(mesh: &ReliefMesh, place: [i32; 2], turn: [i32; 2]) {
    let map = mesh.relief.heights();
    let x = 4 * (place[0] ^ turn[0]) + map.x().first_cell();
    let y = 4 * (place[1] ^ turn[1]) + map.y().first_cell();
    let width = map.width() as usize;
    for row in 0..5 {
        let at = (y.max(0) as usize + row) * width + x.max(0) as usize;
        match map.samples() {
            Samples::U16(samples) => samples.get(at).map_or((), L::fetch),
            Samples::F32(samples) => samples.get(at).map_or((), L::fetch),
        }
    }
}

/// Rows in the order of the forward cells.
#[inline(always)]
fn in_order<T>([a, b, c, d, e]: [&[T; 8]; 5], backward: bool) -> [&[T; 8]; 5] {
    if backward { [e, d, c, b, a] } else { [a, b, c, d, e] }
}

/// Five rows of samples, of which the first five count, around the block of stored cells at `cell`;
/// copied to `border` where the map ends.
#[inline(always)]
fn block_rows<'a, T: Copy + Default>(
    map: &HeightMap,
    samples: &'a [T],
    cell: [u32; 2],
    border: &'a mut [[T; 8]; 5],
) -> [&'a [T; 8]; 5] {
    let width = map.width() as usize;
    let x = cell[0] as i32 + map.x().first_cell();
    let y = cell[1] as i32 + map.y().first_cell();
    if x >= 0
        && y >= 0
        && x as usize + 8 <= width
        && let Some(from) = samples.get(y as usize * width + x as usize..)
        && let Some(rows) = inner_rows(from, width)
    {
        return rows;
    }
    *border = border_rows(map, samples, cell);
    let [a, b, c, d, e] = border;
    [a, b, c, d, e]
}

/// Five rows, one `width` after the other, if there are as many.
#[inline(always)]
fn inner_rows<T>(from: &[T], width: usize) -> Option<[&[T; 8]; 5]> {
    let row = |k: usize| from.get(k * width..)?.first_chunk();
    Some([row(0)?, row(1)?, row(2)?, row(3)?, row(4)?])
}

/// [`block_rows`] at the border of the map, sample by sample.
#[cold]
#[inline(never)]
fn border_rows<T: Copy + Default>(map: &HeightMap, samples: &[T], cell: [u32; 2]) -> [[T; 8]; 5] {
    // Samples at the five lines of the block; lines beyond the last cell repeat its far one.
    let lines = |axis: &Axis, first: u32| {
        let last = axis.cells() - 1;
        [0, 1, 2, 3, 4].map(|k| match first + k {
            c if c <= last => axis.corners(c).0,
            _ => axis.corners(last).1,
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
