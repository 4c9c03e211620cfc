//! Methods `pyramid` and `dda`: which cells under a prism are shown to the leaf; those by distance are
//! in `by_distance`.
//!
//! **Pyramid.** A prism is entered by a straight line in lattice coordinates with an error (see
//! `frame`): the parameters at which the line is between the lowest and highest height of the prism
//! and inside of its three sides, all widened by the error. What is left is walked through the
//! 4 x 4 pyramid of the map, from the smallest level of which 4 x 4 nodes hold it, at any place:
//! sixteen children at once are cut by their borders and bounds, widened (`square`); of the first
//! sixteen, which have no common parent, each is held against its own bounds before it waits. Where the error is
//! larger than 0.4 of a child, a new frame is made about the node: the error falls with the size of
//! the node times its range of heights, which for a block of 4 x 4 cells are its own. In a block,
//! cells are left out whose surface the line cannot touch (`square::Square::cells`).
//!
//! **Why it misses nothing.** A root that the leaf reports lies within [`MARGIN`] of its cell and its triangle,
//! and its height within the bounds of the cell to four margins of the map's range. In every frame that
//! is good for a region with that root the line is, at the root's parameter, within the
//! error of it. So each test is a necessary condition on one and the same parameter, and spans
//! found in one frame may be cut by another. Only the leaf decides, and its answer for a cell
//! depends on ray, prism and cell alone; of all answers the nearest counts, of equal ones the
//! first by prism and cell. What is left out begins later than the nearest so far by more than
//! parameters are off (`Prism::t_slack`). So both methods agree bit for bit.
//!
//! **Dda** shows every cell under every prism whose box the ray meets to the leaf: the referee. It
//! is slow by nature, and shares no bound with the pyramid.

mod by_distance;
mod cells;
mod descent;
mod forward;
mod square;

use crate::map::{Axis, Run};
use crate::probe::Probe;
use crate::simd::{Lanes, Quad};

use super::ReliefMesh;
use super::footprint::{MARGIN, floor};
use super::frame::{Path, keep};
use super::line::MeshRay;
use super::nearest::Nearest;
use super::prism::{Prism, Shape};
use cells::Cells;
use descent::Descent;

/// One ray through one prism; says whether the search is over.
pub(super) struct PrismWalk<'a, P> {
    pub mesh: &'a ReliefMesh,
    pub index: u32,
    pub ray: &'a MeshRay,
    pub nearest: &'a mut Nearest,
    pub probe: &'a mut P,
}

impl<P: Probe> PrismWalk<'_, P> {
    /// [`Method::Pyramid`](super::Method::Pyramid).
    #[inline(always)]
    pub fn through_pyramid<L: Lanes>(self) -> bool {
        let Self { mesh, index, ray, .. } = self;
        let prism = &mesh.prisms[index as usize];
        let spare = prism.t_slack / ray.speed();
        if prism.shape == Shape::Thread {
            return self.every_cell();
        }
        let Self { nearest, probe, .. } = self;
        let cells = Cells { mesh, index, prism, ray, spare, seen: &mut None, nearest, probe };
        let mut span = [0.0, cells.limit()];
        let path = prism.path(ray);
        if !path.is_blind() {
            span = clip::<L::Quad>(&path, span, prism, mesh.height_slack);
            if span[0] > span[1] {
                return false;
            }
        }
        let shown = prism.cells;
        let heights = mesh.relief.heights();
        let mut descent = Descent::<P, L> { cells };
        let mut next_x = Part::new(heights.x(), &path, 0, span, shown[0]);
        while let Some((run_x, span)) = next_x.next(heights.x(), &path) {
            let mut next_y = Part::new(heights.y(), &path, 1, span, shown[1]);
            while let Some((run_y, span)) = next_y.next(heights.y(), &path) {
                if descent.tile([&run_x, &run_y], shown, (&path, span)) {
                    return true;
                }
            }
        }
        false
    }

    /// [`Method::Dda`](super::Method::Dda).
    #[inline(never)]
    pub fn every_cell(self) -> bool {
        let Self { mesh, index, ray, nearest, probe } = self;
        let prism = &mesh.prisms[index as usize];
        let spare = prism.t_slack / ray.speed();
        Cells { mesh, index, prism, ray, spare, seen: &mut None, nearest, probe }.all()
    }

    /// Shows only some cells under the prism to the leaf, each with the number of its triangle.
    pub fn listed(self, cells: &[(u32, [i32; 2])]) {
        let Self { mesh, index, ray, nearest, probe } = self;
        let prism = &mesh.prisms[index as usize];
        let spare = prism.t_slack / ray.speed();
        let mut shown = Cells { mesh, index, prism, ray, spare, seen: &mut None, nearest, probe };
        for (_, cell) in cells {
            shown.leaf_of_any(*cell);
        }
    }
}

/// The span of a path inside of a prism, widened.
#[inline(always)]
fn clip<Q: Quad>(path: &Path, span: [f64; 2], prism: &Prism, height_slack: f64) -> [f64; 2] {
    let [low, high] = prism.range();
    let mut span = path.within(span, 2, [low - height_slack, high + height_slack]);
    let [g, h] = prism.weights;
    let (dx, dy) = (path.start.x - prism.lattice[0][0], path.start.y - prism.lattice[0][1]);
    let nx = Q::of([g[0], h[0], -g[0] - h[0], 0.0]);
    let ny = Q::of([g[1], h[1], -g[1] - h[1], 0.0]);
    let start = nx.scaled(dx).plus(ny.scaled(dy)).plus(Q::of([0.0, 0.0, 1.0, 0.0]));
    let speed = nx.scaled(path.speed.x).plus(ny.scaled(path.speed.y));
    let (nx, ny) = (nx.size(), ny.size());
    let room = nx.scaled(path.error.x).plus(ny.scaled(path.error.y));
    let slack = nx.plus(ny).scaled(MARGIN).plus(Q::splat(1e-12 * prism.condition()));
    let short = Q::splat(0.0).minus(room).minus(slack).minus(start);
    let (t, speed, short) = (short.over(speed).array(), speed.array(), short.array());
    for k in 0..3 {
        span = keep(span, t[k], speed[k], short[k]);
    }
    span
}

/// The cells of a range that a path may touch within a span.
#[inline(always)]
fn shown(path: &Path, axis: usize, span: [f64; 2], [first, end]: [i32; 2]) -> [i32; 2] {
    if path.is_blind() {
        return [first, end];
    }
    let (a, b) = (path.at(span[0])[axis], path.at(span[1])[axis]);
    let room = path.error[axis] + MARGIN;
    let (low, high) = (floor(a.min(b) - room), floor(a.max(b) + room));
    [first.max(low), end.min(high.saturating_add(1))]
}

/// The runs of an axis that a path may touch, one after the other.
struct Part {
    axis: usize,
    span: [f64; 2],
    /// Unfolded cells that are left.
    cells: [i32; 2],
    /// The run that holds all of them, if one does.
    single: Option<Run>,
}

impl Part {
    #[inline(always)]
    fn new(axis: &Axis, path: &Path, number: usize, span: [f64; 2], cells: [i32; 2]) -> Self {
        let first = axis.run(cells[0]);
        let single = (first.end() >= cells[1]).then_some(first);
        let cells = if single.is_some() { cells } else { shown(path, number, span, cells) };
        Self { axis: number, span, cells, single }
    }

    /// The next run, and the part of the span over it.
    #[inline(always)]
    fn next(&mut self, axis: &Axis, path: &Path) -> Option<(Run, [f64; 2])> {
        while self.cells[0] < self.cells[1] {
            if let Some(run) = self.single {
                self.cells[0] = self.cells[1];
                return Some((run, self.span));
            }
            let run = axis.run(self.cells[0]);
            self.cells[0] = run.end();
            if path.is_blind() {
                return Some((run, self.span));
            }
            let ends = [f64::from(run.start) - MARGIN, f64::from(run.end()) + MARGIN];
            let span = path.within(self.span, self.axis, ends);
            if span[0] <= span[1] {
                return Some((run, span));
            }
        }
        None
    }
}

/// The runs that cover a range of unfolded cells, cut to it.
fn runs(axis: &Axis, [first, end]: [i32; 2]) -> impl Iterator<Item = Run> {
    let mut at = first;
    std::iter::from_fn(move || {
        if at >= end {
            return None;
        }
        let run = axis.run(at);
        at = run.end();
        Some(run)
    })
}
