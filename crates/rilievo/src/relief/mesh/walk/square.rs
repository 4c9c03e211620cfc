//! [`Square`]: a path over a square of 4 x 4 equal parts, in sixteen lanes.
//!
//! **Rounding.** Parameters run from 0 to 1 over the span; all coordinates there, counted from the
//! square's corner, are at most `room`, the largest of those of the span's ends and the side, plus
//! error. Rounding start and speed to `f32` moves a point by at most `3 u room`, `u = 2^-24`. The
//! parameter of a line across x or y is the sum of that of its place in the square, rounded twice at
//! `room` at most, and that of the first part's line, rounded once at `1.25 room` at most, itself
//! rounded at `2.25 room` at most: it is the exact one of a line moved by less than `6 u room`. One of a
//! height is the exact one of a height moved by `4 u` of its distance from the start, at most `8 u room`.
//! A speed below `2^-20 room` is taken for that, which moves a point by as much. All this is less than
//! `2^-18 room`, by which the error is widened. The room of heights is the range of the map plus the error.

use glam::DVec3;

use crate::map::{Axis, HeightMap, NodeBounds, Samples};
use crate::simd::{Lanes, Mirror, Quad, WIDTH};

use super::super::ReliefMesh;
use super::super::footprint::MARGIN;
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
    /// Of these, the fourth number has no meaning.
    start: [f32; 4],
    speed: [f32; 4],
    error: [f32; 4],
    /// Parameters that a part takes, along x and y.
    pace: [f32; 4],
    /// Parameters at which the first part is entered and left, along x and y.
    ends: [[f32; 4]; 2],
    /// Parameters per unit.
    inverse: [f32; 4],
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
    pub fn new<Q: Quad>(
        path: &Path,
        [from, to]: [f64; 2],
        corner: [f64; 2],
        (side, mesh): (i32, &ReliefMesh),
    ) -> Self {
        let quad = |v: DVec3| Q::of([v.x, v.y, v.z, 0.0]);
        let (start, speed, error) = (quad(path.start), quad(path.speed), quad(path.error));
        let start = start.minus(Q::of([corner[0], corner[1], 0.0, 0.0]));
        let (a, b) = (start.plus(speed.scaled(from)), start.plus(speed.scaled(to)));
        let (half_range, height_slack) = (mesh.offsets.half_range, mesh.height_slack);
        let side = f64::from(side);
        // What is spared for heights keeps flat maps from dividing by zero.
        let spared = height_slack + 1e-30;
        let room = Q::of([side, side, 2.0 * half_range + spared, 1.0]);
        let room = room.larger(a.size()).larger(b.size()).plus(error);
        let room = room.plus(Q::of([0.0, 0.0, spared, 0.0]));
        let speed = b.minus(a);
        let least = room.scaled(0.25 * WIDENING);
        let speed = speed.size().larger(least).turned_by(speed);
        let slack = Q::of([MARGIN, MARGIN, height_slack, 0.0]);
        let error = error.plus(slack).plus(room.scaled(WIDENING));
        let inverse = Q::splat(1.0).over(speed);
        let part = 0.25 * side;
        let low = Q::splat(0.0).minus(a).minus(error).times(inverse);
        let high = Q::splat(part).minus(a).plus(error).times(inverse);
        Self {
            start: a.rounded(),
            speed: speed.rounded(),
            error: error.rounded(),
            pace: inverse.scaled(part).rounded(),
            ends: [low.smaller(high).rounded(), low.larger(high).rounded()],
            inverse: inverse.rounded(),
            half_range: half_range as f32,
        }
    }

    /// Parameters at which parts of a column or row are entered and left.
    #[inline(always)]
    fn across<L: Lanes>(&self, axis: usize) -> [L; 2] {
        let place = L::load(&PLACES[axis]).times(L::splat(self.pace[axis]));
        let [enter, leave] = &self.ends;
        [place.plus(L::splat(enter[axis])), place.plus(L::splat(leave[axis]))]
    }

    /// Parameters between two heights.
    #[inline(always)]
    fn between<L: Lanes>(&self, low: L, high: L) -> [L; 2] {
        let (start, error) = (self.start[2], self.error[2]);
        let per_height = L::splat(self.inverse[2]);
        let low = low.minus(L::splat(start + error)).times(per_height);
        let high = high.minus(L::splat(start - error)).times(per_height);
        [low.smaller(high), low.larger(high)]
    }

    /// A coordinate at a parameter.
    #[inline(always)]
    fn point<L: Lanes>(&self, axis: usize, t: L) -> L {
        t.times(L::splat(self.speed[axis])).plus(L::splat(self.start[axis]))
    }

    /// The parts met between these heights.
    #[inline(always)]
    pub fn parts<L: Lanes>(&self, low: L, high: L) -> Met<L> {
        let [near_x, far_x] = self.across::<L>(0);
        let [near_y, far_y] = self.across::<L>(1);
        let [near_h, far_h] = self.between(low, high);
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
        let [ex, ey, eh, _] = self.error;
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

/// Lowest and highest height of a node, or of a block at level -1, over the level; nothing for the top of
/// the pyramid.
#[inline(always)]
pub(super) fn heights_of(
    mesh: &ReliefMesh,
    level: i32,
    place: [i32; 2],
    turn: [i32; 2],
) -> Option<[f32; 2]> {
    let pyramid = mesh.relief.pyramid();
    let above = (level + 1) as u32;
    if above >= pyramid.levels() {
        return None;
    }
    let across = pyramid.nodes(above)[0] as usize;
    let (x, y) = ((place[0] ^ turn[0]) as usize, (place[1] ^ turn[1]) as usize);
    let lane = (4 * (y & 3) + (x & 3)) % WIDTH;
    let (high, low) = match pyramid.node(above, (y >> 2) * across + (x >> 2)) {
        NodeBounds::Wide { max, min } => (f32::from(max[lane]), f32::from(min[lane])),
        NodeBounds::Tiny { max, min, base, step } => {
            (base + f32::from(max[lane]) * step, base + f32::from(min[lane]) * step)
        }
    };
    let code = pyramid.code();
    let height = |bound: f32| code.base + bound * code.step - mesh.offsets.level;
    Some([height(low), height(high)])
}

/// Corners `h00 h10 h01 h11` of the cells of a block, forward.
#[inline(always)]
pub(super) fn cell_corners<L: Lanes>(mesh: &ReliefMesh, place: [i32; 2], turn: [i32; 2]) -> [L; 4] {
    let map = mesh.relief.heights();
    let cell = [4 * (place[0] ^ turn[0]) as u32, 4 * (place[1] ^ turn[1]) as u32];
    match map.samples() {
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
    }
}

/// Asks for the samples of a block before they are needed.
#[inline(always)]
pub(super) fn fetch_block<L: Lanes>(mesh: &ReliefMesh, place: [i32; 2], turn: [i32; 2]) {
    let map = mesh.relief.heights();
    let x = 4 * (place[0] ^ turn[0]) + map.x().first_cell();
    let y = 4 * (place[1] ^ turn[1]) + map.y().first_cell();
    let (first, width) =
        (y.max(0) as usize * map.width() as usize + x.max(0) as usize, map.width());
    match map.samples() {
        Samples::U16(samples) => fetch_rows::<L, u16>(samples, first, width as usize),
        Samples::F32(samples) => fetch_rows::<L, f32>(samples, first, width as usize),
    }
}

/// Asks for five rows.
#[inline(always)]
fn fetch_rows<L: Lanes, T>(samples: &[T], first: usize, width: usize) {
    for row in 0..5 {
        if let Some(sample) = samples.get(first + row * width) {
            L::fetch(sample);
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
