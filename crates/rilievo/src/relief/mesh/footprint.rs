//! [`Footprint`]: which part of the unfolded map a base triangle shows.

use crate::map::{HeightMap, Pyramid, Run};

use super::super::Relief;

/// By how much footprints and cells are widened wherever something is left out, in cells: the leaf
/// reports nothing farther from a cell or a triangle (see `leaf::REACH`).
pub(super) const MARGIN: f64 = 1.0 / (1 << 20) as f64;

/// Blocks along the longer side of a footprint at which its range is no longer refined.
const FINE: f64 = 16.0;

/// Runs of an axis beyond which the whole map is taken for shown.
const MANY_RUNS: usize = 6;

/// The box of a footprint in lattice coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    pub low: [f64; 2],
    pub high: [f64; 2],
}

impl Area {
    #[inline(always)]
    pub fn of([a, b, c]: [[f64; 2]; 3]) -> Self {
        // By comparisons: lattice coordinates are no NaN.
        let lesser = |x: f64, y: f64| if x < y { x } else { y };
        let larger = |x: f64, y: f64| if x > y { x } else { y };
        let least = |k: usize| lesser(lesser(a[k], b[k]), c[k]);
        let most = |k: usize| larger(larger(a[k], b[k]), c[k]);
        Self { low: [least(0), least(1)], high: [most(0), most(1)] }
    }

    /// The longer side.
    #[inline(always)]
    pub fn extent(&self) -> f64 {
        let (width, height) = (self.high[0] - self.low[0], self.high[1] - self.low[1]);
        if width > height { width } else { height }
    }

    /// First cell and one past the last cell along each axis that the widened box touches.
    #[inline(always)]
    pub fn cells(&self) -> [[i32; 2]; 2] {
        let first = |k: usize| floor(self.low[k] - MARGIN);
        let end = |k: usize| floor(self.high[k] + MARGIN) + 1;
        [[first(0), end(0)], [first(1), end(1)]]
    }
}

/// The whole number at or below, by a cast, which saturates: faster than a call.
#[inline(always)]
pub(super) fn floor(x: f64) -> i32 {
    let whole = x as i32;
    whole.saturating_sub(i32::from(x < f64::from(whole)))
}

/// A closed triangle in lattice coordinates; it may be a segment or a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint {
    corners: [[f64; 2]; 3],
    /// Outward normals of the sides, and twice for those of a segment.
    sides: [Side; 3],
    pub area: Area,
}

/// A half plane that holds the triangle: `normal . p <= limit`, and `>= least` where it is flat.
#[derive(Clone, Copy, Debug)]
struct Side {
    normal: [f64; 2],
    limit: f64,
    least: f64,
}

impl Footprint {
    pub fn new(corners: [[f64; 2]; 3]) -> Self {
        let [a, b, c] = corners;
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let sign = if area < 0.0 { -1.0 } else { 1.0 };
        let sides = [0, 1, 2].map(|k| {
            let (p, q) = (corners[k], corners[(k + 1) % 3]);
            let normal = [sign * (q[1] - p[1]), sign * (p[0] - q[0])];
            let along = |p: [f64; 2]| normal[0] * (p[0] - a[0]) + normal[1] * (p[1] - a[1]);
            let values = corners.map(along);
            Side {
                normal,
                limit: values[0].max(values[1]).max(values[2]),
                least: values[0].min(values[1]).min(values[2]),
            }
        });
        Self { corners, sides, area: Area::of(corners) }
    }

    /// First cell and one past the last cell of a row of cells that the widened footprint touches.
    pub fn row(&self, row: i32) -> [i32; 2] {
        let ends = [f64::from(row) - MARGIN, f64::from(row) + 1.0 + MARGIN];
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..3 {
            let (p, q) = (self.corners[k], self.corners[(k + 1) % 3]);
            let rise = q[1] - p[1];
            // The part of the side that runs through the row.
            let [a, b] = ends.map(|y| (y - p[1]) / rise);
            let (from, to) =
                if rise == 0.0 { (0.0, 1.0) } else { (a.min(b).max(0.0), a.max(b).min(1.0)) };
            let level = rise == 0.0 && (p[1] < ends[0] || p[1] > ends[1]);
            if from <= to && !level {
                for t in [from, to] {
                    let x = p[0] + t * (q[0] - p[0]);
                    (low, high) = (low.min(x), high.max(x));
                }
            }
        }
        let slack = MARGIN + 1e-12 * (low.abs() + high.abs());
        [floor(low - slack), floor(high + slack).saturating_add(1)]
    }

    /// Whether a box lies outside of the footprint, by more than the margin.
    pub fn misses(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        if (0..2)
            .any(|k| low[k] > self.area.high[k] + MARGIN || high[k] < self.area.low[k] - MARGIN)
        {
            return true;
        }
        let a = self.corners[0];
        self.sides.iter().any(|side| {
            let [nx, ny] = side.normal;
            let size = nx.abs() + ny.abs();
            let x = [low[0] - a[0], high[0] - a[0]];
            let y = [low[1] - a[1], high[1] - a[1]];
            let most =
                |nx: f64, ny: f64| nx * x[usize::from(nx > 0.0)] + ny * y[usize::from(ny > 0.0)];
            let (least, most) = (-most(-nx, -ny), most(nx, ny));
            let slack =
                size * (MARGIN + 1e-12 * (x[0].abs() + x[1].abs() + y[0].abs() + y[1].abs()));
            least > side.limit + slack || most < side.least - slack
        })
    }

    /// Lowest and highest raw height over the footprint, or a little beyond: no block smaller than
    /// 1/16 of the footprint is looked into, so the work does not depend on the map's size.
    pub fn raw_range(&self, relief: &Relief) -> [f32; 2] {
        let (heights, pyramid) = (relief.heights(), relief.pyramid());
        let (low, high) = heights.raw_range();
        let [x, y] = self.area.cells();
        let runs = [(heights.x(), x), (heights.y(), y)].map(|(axis, [first, end])| {
            let mut runs = Vec::new();
            let mut at = first;
            while at < end && runs.len() <= MANY_RUNS {
                let run = axis.run(at);
                at = run.end();
                runs.push(run);
            }
            runs
        });
        if runs.iter().any(|runs| runs.len() > MANY_RUNS) {
            return [low, high];
        }
        let least = self.area.extent() / FINE;
        let mut search = Search {
            footprint: self,
            heights,
            pyramid,
            least,
            low: f32::INFINITY,
            high: -f32::INFINITY,
        };
        let top = pyramid.levels() - 1;
        for run_y in &runs[1] {
            for run_x in &runs[0] {
                let [across, up] = pyramid.blocks(top);
                for by in 0..up {
                    for bx in 0..across {
                        search.block(top, [bx, by], [run_x, run_y]);
                    }
                }
            }
        }
        if search.low <= search.high { [search.low, search.high] } else { [low, high] }
    }
}

/// The range found so far.
struct Search<'a> {
    footprint: &'a Footprint,
    heights: &'a HeightMap,
    pyramid: &'a Pyramid,
    least: f64,
    low: f32,
    high: f32,
}

impl Search<'_> {
    fn take(&mut self, low: f32, high: f32) {
        self.low = self.low.min(low);
        self.high = self.high.max(high);
    }

    /// The unfolded box of stored cells, cut to the run; nothing if that is empty or misses.
    fn shown(&self, first: [u32; 2], side: u32, runs: [&Run; 2]) -> bool {
        let mut low = [0.0; 2];
        let mut high = [0.0; 2];
        for k in 0..2 {
            let run = runs[k];
            let (a, b) = if run.flipped {
                (
                    run.start + run.first - (first[k] + side - 1) as i32,
                    run.start + run.first - first[k] as i32,
                )
            } else {
                (
                    run.start + first[k] as i32 - run.first,
                    run.start + (first[k] + side - 1) as i32 - run.first,
                )
            };
            let (a, b) = (a.max(run.start), b.min(run.end() - 1));
            if a > b {
                return false;
            }
            (low[k], high[k]) = (f64::from(a), f64::from(b + 1));
        }
        !self.footprint.misses(low, high)
    }

    fn block(&mut self, level: u32, [bx, by]: [u32; 2], runs: [&Run; 2]) {
        let side = 4u32 << (2 * level);
        if !self.shown([bx * side, by * side], side, runs) {
            return;
        }
        let (low, high) = self.pyramid.bounds(level, bx, by);
        if low >= self.low && high <= self.high {
            return;
        }
        if f64::from(side) <= self.least {
            return self.take(low, high);
        }
        let below = if level > 0 { self.pyramid.blocks(level - 1) } else { self.pyramid.cells() };
        for y in 4 * by..(4 * by + 4).min(below[1]) {
            for x in 4 * bx..(4 * bx + 4).min(below[0]) {
                if level > 0 {
                    self.block(level - 1, [x, y], runs);
                } else if self.shown([x, y], 1, runs) {
                    let h = self.heights.stored_corners(x, y);
                    let low = h.iter().fold(f32::INFINITY, |a, &b| a.min(b));
                    self.take(low, h.iter().fold(-f32::INFINITY, |a, &b| a.max(b)));
                }
            }
        }
    }
}
