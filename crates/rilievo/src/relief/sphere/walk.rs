//! The methods: which cells of a segment the leaf is shown, in order.
//!
//! [`by_cells`] shows every cell under the segment. [`by_pyramid`] goes down the face's min-max
//! pyramid, whose lines are lines of cells, and leaves out blocks and cells that the ray passes.
//!
//! **Bound.** A ray that comes from outside passes a block if its distance from the centre, over the
//! whole of the block, is larger than the block's highest radius; one that comes from inside, if it is
//! smaller than the lowest, less what flat cells sink (`radii`). That distance is `N / q` with `N^2` a
//! quadratic in s, decreasing up to the point closest to the centre and increasing from there: one
//! comparison of `N^2` with `(r q)^2` decides, without root or division. No curvature is lost: the
//! bound of a block is a part of a shell around the centre.
//!
//! **No miss (proof).** Over a block left out the ray is on one side of the surface by more than
//! [`Radii::above`] says, 2^-42 of q at least. The leaf's coefficients are off by some 2^-50 of q, so
//! the least value of its quadratic, that of the true gap but for this, keeps its sign, and so does
//! the discriminant: nothing is reported there. A ray from outside is outside up to its first
//! crossing, so one side is enough.

use super::radii::Radii;
use super::segment::{Root, Segment};
use crate::map::{Samples, SideBounds};
use crate::probe::Probe;
use crate::relief::Relief;

/// Children of a node.
const LANES: usize = 16;

/// Most levels of a pyramid over a face.
const LEVELS: usize = 8;

/// The first crossing among all cells under a segment.
#[inline(always)]
pub(super) fn by_cells<P: Probe>(segment: &Segment<'_>, cells: u32, probe: &mut P) -> Option<Root> {
    let last = f64::from(cells - 1);
    let forward = [0, 1].map(|k| segment.slope[k] > 0.0);
    let first = |k: usize| {
        let at = segment.origin[k];
        let cell = if forward[k] { at.floor() } else { at.ceil() - 1.0 };
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
        if leave >= 1.0 {
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

/// A segment made ready for tests of sixteen children at once.
struct Sweep<'a> {
    segment: &'a Segment<'a>,
    relief: &'a Relief,
    radii: &'a Radii,
    square: [f64; 3],
    /// Where the ray is closest to the centre, and how far to look.
    nearest: f64,
    end: f64,
    outside: bool,
    /// Whether the highest heights bound the surface on the ray's side; else the lowest.
    upper: bool,
}

/// The first crossing under a segment up to `end`, for a ray that comes from `outside` or not and is
/// closest to the centre at `nearest`.
#[inline(always)]
pub(super) fn by_pyramid<P: Probe>(
    segment: &Segment<'_>,
    (relief, radii): (&Relief, &Radii),
    (outside, nearest, end): (bool, f64, f64),
    probe: &mut P,
) -> Option<Root> {
    let (square, upper) = (segment.square(), outside == (radii.per_raw > 0.0));
    let sweep = Sweep { segment, relief, radii, square, nearest, end, outside, upper };
    let top = relief.pyramid().levels() as usize - 1;
    let mut stack = [(0u32, 0u32, 0u16); LEVELS];
    let mut level = top;
    stack[top] = (0, 0, sweep.node(top, (0, 0), probe));
    loop {
        let (x, y, open) = &mut stack[level];
        if *open == 0 {
            if level == top {
                return None;
            }
            level += 1;
            continue;
        }
        let lane = sweep.lane(open.trailing_zeros());
        *open &= *open - 1;
        let child = (4 * *x + lane % 4, 4 * *y + lane / 4);
        if level > 0 {
            level -= 1;
            stack[level] = (child.0, child.1, sweep.node(level, child, probe));
            continue;
        }
        let first = [4 * child.0, 4 * child.1];
        let mut cells = sweep.cells(first, probe);
        while cells != 0 {
            let lane = sweep.lane(cells.trailing_zeros());
            cells &= cells - 1;
            probe.cell();
            if let Some(root) = segment.meet([first[0] + lane % 4, first[1] + lane / 4]) {
                return Some(root);
            }
        }
    }
}

impl Sweep<'_> {
    /// The lane at a place of the order in which the ray passes them.
    #[inline(always)]
    fn lane(&self, place: u32) -> u32 {
        let [x, y] = self.segment.slope;
        place ^ (if x < 0.0 { 3 } else { 0 }) ^ (if y < 0.0 { 12 } else { 0 })
    }

    /// Which children of a node are to be looked at, in the ray's order.
    #[inline(always)]
    fn node<P: Probe>(&self, level: usize, (x, y): (u32, u32), probe: &mut P) -> u16 {
        probe.node();
        let pyramid = self.relief.pyramid();
        let across = pyramid.nodes(level as u32)[0] as usize;
        let code = pyramid.code();
        let mut raw = [0.0f32; LANES];
        match pyramid.side(level as u32, y as usize * across + x as usize, self.upper) {
            SideBounds::Wide(codes) => {
                for k in 0..LANES {
                    raw[k] = code.value_f32(f32::from(codes[k]));
                }
            }
            SideBounds::Tiny { steps, base, step } => {
                for k in 0..LANES {
                    raw[k] = code.value_f32(base + f32::from(steps[k]) * step);
                }
            }
        }
        let size = f64::from(4u32 << (2 * level));
        self.reached([x, y].map(|c| f64::from(4 * c) * size), size, &raw)
    }

    /// Which of 4 x 4 cells are to be shown to the leaf, in the ray's order.
    #[inline(always)]
    fn cells<P: Probe>(&self, [i, j]: [u32; 2], probe: &mut P) -> u16 {
        probe.node();
        let last = self.radii.cells;
        let rows = [0, 1, 2, 3, 4].map(|k| (j + k).min(last) as usize * (last as usize + 1));
        let columns = [0, 1, 2, 3, 4].map(|k| (i + k).min(last) as usize);
        let mut raw = [0.0f32; 25];
        match self.relief.heights().samples() {
            Samples::U16(codes) => gather(&mut raw, rows, columns, |at| f32::from(codes[at])),
            Samples::F32(values) => gather(&mut raw, rows, columns, |at| values[at]),
        }
        let mut bound = [0.0f32; LANES];
        for (lane, bound) in bound.iter_mut().enumerate() {
            let at = lane / 4 * 5 + lane % 4;
            let h = [raw[at], raw[at + 1], raw[at + 5], raw[at + 6]];
            *bound = if self.upper {
                larger(larger(h[0], h[1]), larger(h[2], h[3]))
            } else {
                -larger(larger(-h[0], -h[1]), larger(-h[2], -h[3]))
            };
        }
        self.reached([f64::from(i), f64::from(j)], 1.0, &bound)
    }

    /// Which of 4 x 4 squares of `size` cells, from `first` on, with these highest or lowest raw
    /// heights, the ray may meet the surface in.
    #[inline(always)]
    fn reached(&self, first: [f64; 2], size: f64, raw: &[f32; LANES]) -> u16 {
        let Self { segment, radii, square: [c, b, a], nearest, end, outside, .. } = *self;
        let (mut enter, mut leave) = ([[0.0; 4]; 2], [[0.0; 4]; 2]);
        for k in 0..2 {
            for i in 0..4 {
                let low = segment.crosses(k, first[k] + i as f64 * size);
                let high = segment.crosses(k, first[k] + (i + 1) as f64 * size);
                enter[k][i] = smaller(low, high);
                leave[k][i] = larger(low, high);
            }
        }
        let slack = if outside { radii.above } else { radii.below };
        let mut met = [false; LANES];
        for lane in 0..LANES {
            let s0 = larger(larger(enter[0][lane % 4], enter[1][lane / 4]), 0.0);
            let s1 = smaller(smaller(leave[0][lane % 4], leave[1][lane / 4]), end);
            let radius = radii.radius(f64::from(raw[lane]));
            let bound = radius * radius * slack;
            // Positive where the ray is farther from the centre than the bound.
            let beyond = |s: f64| {
                let q = segment.q(s);
                (c + s * (b + s * a)) - bound * (q * q)
            };
            let reaches = if outside {
                beyond(smaller(larger(nearest, s0), s1)) <= 0.0
            } else {
                (beyond(s0) >= 0.0) | (beyond(s1) >= 0.0)
            };
            met[lane] = (s0 < s1) & reaches;
        }
        let mut bits = 0;
        for (lane, met) in met.into_iter().enumerate() {
            bits |= u16::from(met) << lane;
        }
        self.in_order(bits)
    }

    /// Bits of lanes, moved to their places in the ray's order.
    #[inline(always)]
    fn in_order(&self, lanes: u16) -> u16 {
        let [x, y] = self.segment.slope;
        let mut bits = lanes;
        if x < 0.0 {
            bits = (bits & 0x5555) << 1 | (bits >> 1) & 0x5555;
            bits = (bits & 0x3333) << 2 | (bits >> 2) & 0x3333;
        }
        if y < 0.0 {
            bits = bits.rotate_left(8);
            bits = (bits & 0x0f0f) << 4 | (bits >> 4) & 0x0f0f;
        }
        bits
    }
}

/// Five rows of five samples.
#[inline(always)]
fn gather(
    raw: &mut [f32; 25],
    rows: [usize; 5],
    columns: [usize; 5],
    sample: impl Fn(usize) -> f32,
) {
    for (j, row) in rows.into_iter().enumerate() {
        for (i, column) in columns.into_iter().enumerate() {
            raw[5 * j + i] = sample(row + column);
        }
    }
}

/// One instruction, unlike `max`, which looks for NaN.
#[inline(always)]
fn larger<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// One instruction, unlike `min`, which looks for NaN.
#[inline(always)]
fn smaller<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}
