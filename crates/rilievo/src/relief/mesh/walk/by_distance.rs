//! Methods `distance` and `distance-corrected` under a prism: steps through the map's distances where the
//! line is good, cells near the surface.
//!
//! In a frame the ray is a line with a remainder (see `frame`), which is what `corridor` asks for:
//! steps are shrunk by it. Where no step leads on and the remainder is wider than half a voxel, a new frame is
//! made about the stretch that the line takes next: a box around it, widened by the remainder, holds
//! every root of the stretch. The remainder falls with the size of that box times its range of
//! heights, so two or three frames are enough. A frame that is not good for its own footprint, or
//! blind, is not walked: the footprint is cut in four and each part tries its own.
//!
//! **Why it misses nothing.** As for the pyramid (see the parent module): every step, stretch and cell
//! left out rests on a condition that a root meets at its own parameter in every frame whose region
//! holds it. The region of a new frame holds the roots of its stretch, because the old frame was good for
//! them. To the remainder come what roots may lie beside their cell and its heights, [`MARGIN`] and the
//! mesh's slack of heights, so distances and heights of columns are shrunk and widened by them too.
//! Each tile is walked alone: distances know the stored cells only, and so does a tile.

use glam::DVec3;

use crate::map::{DistanceMap, Run};
use crate::probe::Probe;
use crate::simd::PortableQuad;

use super::super::footprint::{Footprint, MARGIN, floor};
use super::super::frame::{Frame, Path, Region};
use super::super::prism::Shape;
use super::cells::Cells;
use super::{PrismWalk, clip, runs};
use crate::relief::corridor::{Corridor, Line};

/// Footprints of at most this many cells along their longer side are not cut.
const FEW_CELLS: i32 = 8;

/// Errors above this share of a footprint's longer side call for a cut.
const POOR: f64 = 0.25;

/// Errors above this many voxels call for a new frame.
const WIDE: f64 = 0.5;

/// A new frame has to have less than this share of the old one's error.
const WORTH: f64 = 0.7;

/// Frames within frames at most.
const DEPTH: u32 = 6;

/// Cells shown last, which are not shown again.
const REMEMBERED: usize = 8;

/// Unfolded cells, first and one past the last along x and y.
type Part = [[i32; 2]; 2];

/// The walk under one tile of one prism.
struct March<'a, P> {
    cells: Cells<'a, P, PortableQuad>,
    footprint: &'a Footprint,
    distances: &'a DistanceMap,
    /// Stored from unfolded coordinates: sign and shift, along x and y.
    stored: [[f64; 2]; 2],
    shown: [Option<[i32; 2]>; REMEMBERED],
    next: usize,
}

impl<P: Probe> PrismWalk<'_, P> {
    /// By the distance map of the mesh's relief.
    #[inline(never)]
    pub fn by_distance(self, distances: &DistanceMap) -> bool {
        let Self { mesh, index, ray, nearest, probe, .. } = self;
        let prism = &mesh.prisms[index as usize];
        let (seen, spare) = (&mut None, prism.t_slack / ray.speed());
        let mut cells = Cells { mesh, index, prism, ray, spare, seen, nearest, probe };
        if prism.shape == Shape::Thread {
            return cells.all();
        }
        let mut span = [0.0, cells.limit()];
        let mut path = None;
        if !prism.frame.is_blind() {
            let own = prism.path(ray);
            span = clip::<PortableQuad>(&own, span, prism, mesh.height_slack);
            path = Some(own);
        }
        if span[0] > span[1] {
            return false;
        }
        let (heights, footprint) = (mesh.relief.heights(), &prism.footprint());
        let [x, y] = prism.cells;
        let mut march = March {
            cells,
            footprint,
            distances,
            stored: [[0.0; 2]; 2],
            shown: [None; REMEMBERED],
            next: 0,
        };
        for run_x in runs(heights.x(), x) {
            for run_y in runs(heights.y(), y) {
                march.stored = [stored(&run_x), stored(&run_y)];
                let part = [(x, &run_x), (y, &run_y)]
                    .map(|(all, run)| [all[0].max(run.start), all[1].min(run.end())]);
                if march.enter(part, (path.as_ref(), span)) {
                    return true;
                }
            }
        }
        false
    }
}

/// Sign and shift from unfolded to stored coordinates.
fn stored(run: &Run) -> [f64; 2] {
    let (start, first) = (f64::from(run.start), f64::from(run.first));
    if run.flipped { [-1.0, first + 1.0 + start] } else { [1.0, first - start] }
}

impl<P: Probe> March<'_, P> {
    /// Walks a part of a tile in a frame good for all of it, or in better ones for parts of it; says
    /// whether the search is over.
    fn enter(&mut self, part: Part, (path, span): (Option<&Path>, [f64; 2])) -> bool {
        let low = part.map(|[first, _]| f64::from(first));
        let high = part.map(|[_, end]| f64::from(end));
        if self.footprint.misses(low, high) {
            return false;
        }
        let mut span = [span[0], span[1].min(self.cells.limit())];
        if let Some(path) = path {
            for k in 0..2 {
                span = path.within(span, k, [low[k] - MARGIN, high[k] + MARGIN]);
            }
            let ([low, high], slack) = (self.cells.prism.range(), self.cells.mesh.height_slack);
            span = path.within(span, 2, [low - slack, high + slack]);
        }
        if span[0] > span[1] {
            return false;
        }
        let size = (part[0][1] - part[0][0]).max(part[1][1] - part[1][0]);
        let error = |path: &Path| path.error.x.max(path.error.y);
        match path {
            Some(path) if size <= FEW_CELLS || error(path) <= POOR * f64::from(size) => {
                return self.walk((path, span), 0);
            }
            None if size <= FEW_CELLS => return self.show_all(part),
            _ => {}
        }
        let halves = |[first, end]: [i32; 2]| {
            let middle = first + (end - first) / 2;
            [[first, middle], [middle, end]]
        };
        for y in halves(part[1]) {
            for x in halves(part[0]) {
                if x[0] >= x[1] || y[0] >= y[1] {
                    continue;
                }
                let better = self.frame_of([x, y]);
                let better = match (&better, path) {
                    (Some(better), Some(old)) if error(better) >= error(old) => path,
                    (Some(better), _) => Some(better),
                    (None, _) => path,
                };
                if self.enter([x, y], (better, span)) {
                    return true;
                }
            }
        }
        false
    }

    /// A frame about a part of a tile and all heights under the prism.
    fn frame_of(&self, part: Part) -> Option<Path> {
        let [low, high] = self.cells.prism.range();
        let slack = self.cells.mesh.height_slack;
        let [x, y] = part.map(|ends| ends.map(f64::from));
        let low = DVec3::new(x[0] - MARGIN, y[0] - MARGIN, low - slack);
        let high = DVec3::new(x[1] + MARGIN, y[1] + MARGIN, high + slack);
        self.frame_about([low, high])
    }

    /// A frame about what of a box lies over the footprint and between the prism's heights, if it can see.
    fn frame_about(&self, [mut low, mut high]: [DVec3; 2]) -> Option<Path> {
        let Cells { mesh, prism, ray, .. } = self.cells;
        let area = &self.footprint.area;
        for k in 0..2 {
            low[k] = low[k].max(area.low[k] - MARGIN);
            high[k] = high[k].min(area.high[k] + MARGIN);
        }
        let slack = mesh.height_slack;
        low.z = low.z.max(prism.range()[0] - slack);
        high.z = high.z.min(prism.range()[1] + slack);
        // Nothing is in an empty box; a frame about its middle says nothing wrong.
        let (centre, half) = (0.5 * (low + high), 0.5 * (high - low).max(DVec3::ZERO));
        let rounding = prism.rounding(mesh.reach);
        let frame =
            Frame::about(&prism.sheet(&mesh.vertices), centre, &Region::Box(half), rounding);
        (!frame.is_blind()).then(|| frame.path(centre, ray.origin, ray.direction))
    }

    /// Walks a span of a path; says whether the search is over.
    fn walk(&mut self, (path, span): (&Path, [f64; 2]), depth: u32) -> bool {
        let corridor = Corridor::new(self.distances, self.line(path), span);
        let mut t = span[0];
        loop {
            let end = span[1].min(self.cells.limit());
            if t > end {
                return false;
            }
            self.cells.probe.step();
            let look = corridor.look(t, end);
            if corridor.leads_on(&look, t) {
                t = look.safe;
                continue;
            }
            let mut past = corridor.past(&look, t);
            if look.near[0] <= look.near[1] {
                let refined = (corridor.width() > WIDE && depth < DEPTH)
                    .then(|| self.stretch(path, [t, past], end))
                    .flatten();
                if let Some((better, to)) = refined {
                    past = past.max(to);
                    if self.walk((&better, [t, to]), depth + 1) {
                        return true;
                    }
                } else if self.show(path, look.near) {
                    return true;
                }
            }
            if past <= t {
                // Parameters have run out of digits: what is left is shown.
                return self.show(path, [t, end]);
            }
            t = past;
        }
    }

    /// A much better frame about a stretch from `from` on, at least up to `to`, and its end.
    fn stretch(&self, path: &Path, [from, to]: [f64; 2], end: f64) -> Option<(Path, f64)> {
        let error = path.error.x.max(path.error.y);
        let speed = path.speed.x.abs().max(path.speed.y.abs());
        let to = to.max(from + error / speed).min(end);
        let (a, b) = (path.at(from), path.at(to));
        let wide = path.error + DVec3::new(MARGIN, MARGIN, self.cells.mesh.height_slack);
        let better = self.frame_about([a.min(b) - wide, a.max(b) + wide])?;
        (better.error.x.max(better.error.y) < WORTH * error).then_some((better, to))
    }

    /// A path over stored cells and raw heights, for what roots the leaf may report.
    fn line(&self, path: &Path) -> Line {
        let mesh = self.cells.mesh;
        let mut line = Line { start: [0.0; 3], speed: [0.0; 3], error: [0.0; 3] };
        for k in 0..2 {
            let [sign, shift] = self.stored[k];
            line.start[k] = sign * path.start[k] + shift;
            line.speed[k] = sign * path.speed[k];
            line.error[k] = path.error[k] + 2.0 * MARGIN;
        }
        line.start[2] = path.start.z + f64::from(mesh.offsets.level);
        line.speed[2] = path.speed.z;
        line.error[2] = path.error.z + 2.0 * mesh.height_slack;
        line
    }

    /// Shows the cells that a path may touch the surface of within a span; says whether the search is
    /// over.
    fn show(&mut self, path: &Path, span: [f64; 2]) -> bool {
        let (a, b) = (path.at(span[0]), path.at(span[1]));
        let mut part = [[0; 2]; 2];
        for k in 0..2 {
            let room = path.error[k] + MARGIN;
            let area = &self.footprint.area;
            let low = (a[k].min(b[k]) - room).max(area.low[k] - MARGIN);
            let high = (a[k].max(b[k]) + room).min(area.high[k] + MARGIN);
            part[k] = [floor(low), floor(high).saturating_add(1)];
        }
        let (mesh, slack) = (self.cells.mesh, self.cells.mesh.height_slack);
        for j in part[1][0]..part[1][1] {
            let row = [f64::from(j) - MARGIN, f64::from(j) + 1.0 + MARGIN];
            let in_row = path.within(span, 1, row);
            if in_row[0] > in_row[1] {
                continue;
            }
            for i in part[0][0]..part[0][1] {
                let column = [f64::from(i) - MARGIN, f64::from(i) + 1.0 + MARGIN];
                let over = path.within(in_row, 0, column);
                if over[0] > over[1] || self.shown.contains(&Some([i, j])) {
                    continue;
                }
                let corners = mesh.relief.heights().unfolded_corners(i, j);
                let level = f64::from(mesh.offsets.level);
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                for raw in corners.map(|raw| f64::from(raw) - level) {
                    (low, high) = (low.min(raw), high.max(raw));
                }
                let met = path.within(over, 2, [low - slack, high + slack]);
                if met[0] <= met[1] && self.show_cell([i, j]) {
                    return true;
                }
            }
        }
        false
    }

    /// Shows a cell to the leaf if it lies over the footprint; says whether the search is over.
    fn show_cell(&mut self, cell: [i32; 2]) -> bool {
        let low = cell.map(f64::from);
        self.shown[self.next % REMEMBERED] = Some(cell);
        self.next += 1;
        if self.footprint.misses(low, low.map(|x| x + 1.0)) {
            return false;
        }
        let corners = self.cells.mesh.relief.heights().unfolded_corners(cell[0], cell[1]);
        self.cells.leaf(cell, corners)
    }

    /// Shows all cells of a part; says whether the search is over.
    fn show_all(&mut self, [x, y]: Part) -> bool {
        for j in y[0]..y[1] {
            for i in x[0]..x[1] {
                if self.show_cell([i, j]) {
                    return true;
                }
            }
        }
        false
    }
}
