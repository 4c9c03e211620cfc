//! The distance from a point to the bilinear surface, to any tolerance, by branch and bound.
//!
//! Regions of the surface wait in a queue, nearest lower bound first: blocks of the min-max
//! pyramid, then cells, then patches of a cell (a part of a bilinear patch is a bilinear patch).
//!
//! * *Lower bounds.* A region lies in its box. A patch lies in the convex hull of its four
//!   corners, so for any unit vector `n` it is at least `min over corners of n . (corner - p)`
//!   away. `n` points to an almost nearest point of the patch; if it is poor the bound is loose,
//!   never wrong.
//! * *Upper bounds.* The distance to that almost nearest point, which is on the patch.
//! * *The almost nearest point* is that of the parallelogram which fits the patch best: a convex
//!   quadratic in two clamped variables, solved in closed form. A patch leaves its parallelogram by
//!   at most a quarter of its twist `h00 - h10 - h01 + h11`, and halving a patch quarters the twist.
//!   So the gap between the bounds falls by about 4 a step, and is 0 at once for a planar cell.
//!
//! Both bounds are right up to rounding, below `2^-48` of the numbers involved: positions are taken
//! relative to the query before anything is multiplied.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::map::{HeightMap, Metric, Pyramid};

/// Patches are halved at most this often; a cell's twist is then below every rounding error.
const MAX_HALVINGS: u32 = 40;

/// Bounds `(lower, upper)` of the distance from `p` to the surface of the stored cells, in scene
/// units, at most `tolerance` apart (or `2^-48` of the numbers involved, where that is more).
///
/// `p` is (x, y, z): stored-cell coordinates and raw height, any finite numbers. `pyramid` must be
/// that of `heights`, and `metric` positive.
pub fn exact_distance(
    heights: &HeightMap,
    pyramid: &Pyramid,
    metric: Metric,
    p: [f64; 3],
    tolerance: f64,
) -> (f64, f64) {
    let cells = pyramid.cells().map(f64::from);
    let (lo, hi) = heights.raw_range();
    let scale = (cells[0] + p[0].abs()) * metric.x
        + (cells[1] + p[1].abs()) * metric.y
        + (f64::from(lo.abs().max(hi.abs())) + p[2].abs()) * metric.z;
    let tolerance = tolerance.max(scale / (1u64 << 48) as f64);
    Nearest::new(heights, pyramid, metric).bounds(p, |lower, upper| upper - lower <= tolerance)
}

/// A search for the nearest point of a surface. Keeps its queue between queries, and the nearest
/// point of the last one: a good start for a query nearby.
#[derive(Debug)]
pub(super) struct Nearest<'a> {
    heights: &'a HeightMap,
    pyramid: &'a Pyramid,
    metric: Metric,
    queue: BinaryHeap<Region>,
    found: Option<[f64; 3]>,
}

impl<'a> Nearest<'a> {
    pub fn new(heights: &'a HeightMap, pyramid: &'a Pyramid, metric: Metric) -> Self {
        Self { heights, pyramid, metric, queue: BinaryHeap::new(), found: None }
    }

    /// Forgets the last nearest point, so that the next answer depends on its query alone.
    pub fn forget(&mut self) {
        self.found = None;
    }

    /// Bounds of the distance of `p`, narrowed until `done(lower, upper)` or until they meet.
    pub fn bounds(&mut self, p: [f64; 3], done: impl Fn(f64, f64) -> bool) -> (f64, f64) {
        let mut query = Query { p, metric: self.metric, upper: f64::INFINITY, nearest: [0.0; 3] };
        if let Some(q) = self.found {
            query.offer(query.relative(q));
        }
        let offered = query.upper;
        self.queue.clear();
        let top = self.pyramid.levels() - 1;
        let blocks = self.pyramid.blocks(top);
        self.push_blocks(&mut query, top, [0, blocks[0]], [0, blocks[1]]);
        let mut lower = query.upper;
        while let Some(region) = self.queue.pop() {
            lower = region.lower.min(query.upper);
            if region.lower >= query.upper || done(lower, query.upper) {
                break;
            }
            match region.part {
                Part::Block { level, at } => self.open_block(&mut query, level, at),
                Part::Patch { patch, halvings } if halvings < MAX_HALVINGS => {
                    for quarter in patch.quarters() {
                        self.push_patch(&mut query, quarter, halvings + 1, region.lower);
                    }
                }
                Part::Patch { .. } => break,
            }
            lower = query.upper;
        }
        if query.upper < offered {
            let ([x, y, z], m) = (query.nearest, self.metric);
            self.found = Some([p[0] + x / m.x, p[1] + y / m.y, p[2] + z / m.z]);
        }
        (lower, query.upper)
    }

    /// Queues the blocks or cells under a block.
    fn open_block(&mut self, query: &mut Query, level: u32, at: [u32; 2]) {
        let first = at.map(|b| 4 * b);
        if level > 0 {
            let blocks = self.pyramid.blocks(level - 1);
            let range = |a: usize| [first[a], (first[a] + 4).min(blocks[a])];
            self.push_blocks(query, level - 1, range(0), range(1));
            return;
        }
        let cells = self.pyramid.cells();
        for cy in first[1]..(first[1] + 4).min(cells[1]) {
            for cx in first[0]..(first[0] + 4).min(cells[0]) {
                let raw = self.heights.stored_corners(cx, cy).map(f64::from);
                let patch = Patch {
                    x: [0.0, 1.0].map(|d| (f64::from(cx) + d - query.p[0]) * query.metric.x),
                    y: [0.0, 1.0].map(|d| (f64::from(cy) + d - query.p[1]) * query.metric.y),
                    z: raw.map(|h| (h - query.p[2]) * query.metric.z),
                };
                self.push_patch(query, patch, 0, 0.0);
            }
        }
    }

    fn push_blocks(&mut self, query: &mut Query, level: u32, xs: [u32; 2], ys: [u32; 2]) {
        let side = f64::from(4u32 << (2 * level).min(28));
        let cells = self.pyramid.cells().map(f64::from);
        for by in ys[0]..ys[1] {
            for bx in xs[0]..xs[1] {
                let (lo, hi) = self.pyramid.bounds(level, bx, by);
                let (x0, y0) = (f64::from(bx) * side, f64::from(by) * side);
                let low = query.relative([x0, y0, f64::from(lo)]);
                let high = query.relative([
                    (x0 + side).min(cells[0]),
                    (y0 + side).min(cells[1]),
                    f64::from(hi),
                ]);
                let lower = box_distance(low, high);
                if lower < query.upper {
                    self.queue.push(Region { lower, part: Part::Block { level, at: [bx, by] } });
                }
            }
        }
    }

    fn push_patch(&mut self, query: &mut Query, patch: Patch, halvings: u32, at_least: f64) {
        let lower = at_least.max(patch.box_distance());
        if lower >= query.upper {
            return;
        }
        let near = patch.nearest();
        query.offer(near);
        let lower = lower.max(patch.hull_distance(near));
        if lower < query.upper {
            self.queue.push(Region { lower, part: Part::Patch { patch, halvings } });
        }
    }
}

/// One query: the best upper bound and the surface point it belongs to, relative to `p` and in
/// scene units.
struct Query {
    p: [f64; 3],
    metric: Metric,
    upper: f64,
    nearest: [f64; 3],
}

impl Query {
    fn relative(&self, q: [f64; 3]) -> [f64; 3] {
        let (p, m) = (self.p, self.metric);
        [(q[0] - p[0]) * m.x, (q[1] - p[1]) * m.y, (q[2] - p[2]) * m.z]
    }

    fn offer(&mut self, point: [f64; 3]) {
        let distance = length(point);
        if distance < self.upper {
            (self.upper, self.nearest) = (distance, point);
        }
    }
}

/// A part of the surface with a lower bound of its distance; the nearest is the greatest.
#[derive(Debug)]
struct Region {
    lower: f64,
    part: Part,
}

#[derive(Debug)]
enum Part {
    Block { level: u32, at: [u32; 2] },
    Patch { patch: Patch, halvings: u32 },
}

impl PartialEq for Region {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Region {}

impl PartialOrd for Region {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Region {
    fn cmp(&self, other: &Self) -> Ordering {
        other.lower.total_cmp(&self.lower)
    }
}

/// A bilinear patch relative to the query, scene units; `z` is `[z00, z10, z01, z11]`.
#[derive(Clone, Copy, Debug)]
struct Patch {
    x: [f64; 2],
    y: [f64; 2],
    z: [f64; 4],
}

impl Patch {
    fn box_distance(&self) -> f64 {
        let [a, b, c, d] = self.z;
        let (lo, hi) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
        box_distance([self.x[0], self.y[0], lo], [self.x[1], self.y[1], hi])
    }

    /// The point at (u, v) in `[0, 1]^2`.
    fn point(&self, u: f64, v: f64) -> [f64; 3] {
        let [a, b, c, d] = self.z;
        let (low, high) = (a + (b - a) * u, c + (d - c) * u);
        let along = |side: [f64; 2], t: f64| side[0] + (side[1] - side[0]) * t;
        [along(self.x, u), along(self.y, v), low + (high - low) * v]
    }

    /// The point of the patch over the nearest point of its parallelogram.
    fn nearest(&self) -> [f64; 3] {
        let [a, b, c, d] = self.z;
        let side_u = [self.x[1] - self.x[0], ((b - a) + (d - c)) * 0.5];
        let side_v = [self.y[1] - self.y[0], ((c - a) + (d - b)) * 0.5];
        let corner = (a + b + c + d) * 0.25 - (side_u[1] + side_v[1]) * 0.5;
        // |corner + u side_u + v side_v|^2 = uu u^2 + 2 uv u v + vv v^2 - 2 (ru u + rv v) + ...
        let uu = side_u[0] * side_u[0] + side_u[1] * side_u[1];
        let vv = side_v[0] * side_v[0] + side_v[1] * side_v[1];
        let uv = side_u[1] * side_v[1];
        let ru = -(self.x[0] * side_u[0] + corner * side_u[1]);
        let rv = -(self.y[0] * side_v[0] + corner * side_v[1]);
        let det = uu * vv - uv * uv;
        let (u, v) = ((ru * vv - rv * uv) / det, (rv * uu - ru * uv) / det);
        if (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v) {
            return self.point(u, v);
        }
        // The minimum of a convex function over a square that excludes its own lies on a side.
        let on_u = |v: f64| (((ru - uv * v) / uu).clamp(0.0, 1.0), v);
        let on_v = |u: f64| (u, ((rv - uv * u) / vv).clamp(0.0, 1.0));
        let value = |(u, v): (f64, f64)| {
            u * (uu * u - 2.0 * ru) + v * (vv * v - 2.0 * rv) + 2.0 * uv * u * v
        };
        let mut best = on_u(0.0);
        for side in [on_u(1.0), on_v(0.0), on_v(1.0)] {
            if value(side) < value(best) {
                best = side;
            }
        }
        self.point(best.0, best.1)
    }

    /// The lower bound by the plane across the direction to `near`; see the module head.
    fn hull_distance(&self, near: [f64; 3]) -> f64 {
        let length = length(near);
        if length == 0.0 {
            return 0.0;
        }
        let n = near.map(|c| c / length);
        let corner = |x: f64, y: f64, z: f64| n[0] * x + n[1] * y + n[2] * z;
        let low =
            corner(self.x[0], self.y[0], self.z[0]).min(corner(self.x[1], self.y[0], self.z[1]));
        low.min(corner(self.x[0], self.y[1], self.z[2]))
            .min(corner(self.x[1], self.y[1], self.z[3]))
    }

    /// The four patches it consists of.
    fn quarters(&self) -> [Self; 4] {
        let [a, b, c, d] = self.z;
        let mid = |p: f64, q: f64| p + (q - p) * 0.5;
        let (south, north, west, east) = (mid(a, b), mid(c, d), mid(a, c), mid(b, d));
        let centre = mid(south, north);
        let (x0, x1) = halves(self.x);
        let (y0, y1) = halves(self.y);
        [
            Self { x: x0, y: y0, z: [a, south, west, centre] },
            Self { x: x1, y: y0, z: [south, b, centre, east] },
            Self { x: x0, y: y1, z: [west, centre, c, north] },
            Self { x: x1, y: y1, z: [centre, east, north, d] },
        ]
    }
}

fn halves([a, b]: [f64; 2]) -> ([f64; 2], [f64; 2]) {
    let middle = a + (b - a) * 0.5;
    ([a, middle], [middle, b])
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// Distance of the origin from a box.
fn box_distance(low: [f64; 3], high: [f64; 3]) -> f64 {
    let gap = |a: usize| low[a].max(-high[a]).max(0.0);
    length([gap(0), gap(1), gap(2)])
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{Random, cases};
    use super::*;
    use crate::map::{Lattice, Procedural, Wrap};

    /// Least distance to a fine grid of surface points, and the most it can be too large.
    fn sampled(heights: &HeightMap, metric: Metric, p: [f64; 3]) -> (f64, f64) {
        const STEPS: u32 = 24;
        let (mut least, mut steepest) = (f64::INFINITY, 0.0f64);
        for cy in 0..heights.y().cells() {
            for cx in 0..heights.x().cells() {
                let h = heights.stored_corners(cx, cy).map(f64::from);
                let rise = (h[1] - h[0]).abs().max((h[3] - h[2]).abs());
                steepest = steepest.max(rise.max((h[2] - h[0]).abs()).max((h[3] - h[1]).abs()));
                for k in 0..(STEPS + 1) * (STEPS + 1) {
                    let (u, v) = (k % (STEPS + 1), k / (STEPS + 1));
                    let (u, v) = (f64::from(u) / f64::from(STEPS), f64::from(v) / f64::from(STEPS));
                    let (low, high) = (h[0] + (h[1] - h[0]) * u, h[2] + (h[3] - h[2]) * u);
                    let z = low + (high - low) * v;
                    least = least.min(length([
                        (f64::from(cx) + u - p[0]) * metric.x,
                        (f64::from(cy) + v - p[1]) * metric.y,
                        (z - p[2]) * metric.z,
                    ]));
                }
            }
        }
        let step = [metric.x, metric.y, 2.0 * steepest * metric.z];
        (least, length(step) / f64::from(STEPS))
    }

    #[test]
    fn bounds_enclose_the_distance_to_sampled_surfaces() {
        let mut random = Random(4);
        for (map, metric) in cases() {
            let pyramid = Pyramid::build(&map);
            let (lo, hi) = map.raw_range();
            let range = f64::from(hi - lo);
            let low = [0.0, 0.0, f64::from(lo) - range];
            let high = [map.x().cells().into(), map.y().cells().into(), f64::from(hi) + range];
            for _ in 0..12 {
                let p = random.point((low, high));
                let (least, coarse) = sampled(&map, metric, p);
                for tolerance in [0.0, 0.01] {
                    let (lower, upper) = exact_distance(&map, &pyramid, metric, p, tolerance);
                    assert!(lower <= upper && upper - lower <= tolerance + 1e-9);
                    assert!(lower <= least * (1.0 + 1e-12) + 1e-9, "{p:?}: {lower} over {least}");
                    assert!(least <= upper + coarse, "{p:?}: {upper} under {least}");
                }
            }
        }
    }

    #[test]
    fn a_plane_and_a_plateau_are_as_far_as_geometry_says() {
        let ramp = Procedural::Ramp.height_map_f32([9, 9], Lattice::Vertex, Wrap::Clamp).unwrap();
        let pyramid = Pyramid::build(&ramp);
        let metric = Metric { x: 0.125, y: 0.125, z: 1.0 };
        // A plane at 45 degrees, queried 0.25 above its middle. Stored cells start one before.
        let (lower, upper) = exact_distance(&ramp, &pyramid, metric, [5.0, 5.0, 0.75], 0.0);
        let want = 0.25 / 2.0f64.sqrt();
        assert!((lower - want).abs() < 1e-12 && (upper - want).abs() < 1e-12, "{lower} {upper}");
        let step = Procedural::Step.height_map_f32([9, 9], Lattice::Vertex, Wrap::Repeat).unwrap();
        let pyramid = Pyramid::build(&step);
        let (lower, upper) = exact_distance(&step, &pyramid, Metric::UNIT, [6.0, 4.0, 3.5], 0.0);
        assert!((lower - 2.5).abs() < 1e-12 && (upper - 2.5).abs() < 1e-12, "{lower} {upper}");
    }
}
