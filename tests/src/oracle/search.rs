//! One ray against the cells and walls of a face.

use glam::DVec3;
use rilievo::Part;

use super::{Local, Oracle, OracleHit, Start};

/// A root this close to a given start, in cells, is that start.
const SAME_POINT: f64 = 1e-8;

/// Which cells are tested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cells {
    /// Those whose closed square the ray can touch.
    Touched,
    /// Those of the whole face.
    All,
}

/// A ray and the nearest hit so far.
pub(super) struct Search<'a> {
    pub(super) oracle: &'a Oracle<'a>,
    pub(super) ray: &'a Local,
    pub(super) start: Option<&'a Start>,
    best: Option<OracleHit>,
}

impl<'a> Search<'a> {
    pub(super) fn new(oracle: &'a Oracle<'a>, ray: &'a Local, start: Option<&'a Start>) -> Self {
        Self { oracle, ray, start, best: None }
    }

    pub(super) fn nearest(mut self, cells: Cells) -> Option<OracleHit> {
        let (ray, oracle) = (self.ray, self.oracle);
        let (bottom, top) = oracle.offsets();
        let pad = 1e-9 * oracle.size().max(bottom.abs()).max(top.abs());
        let window = ray
            .clip(0, oracle.low.x, oracle.high.x, [0.0, ray.t_max])
            .and_then(|span| ray.clip(1, oracle.low.y, oracle.high.y, span));
        let slab = window.and_then(|span| ray.clip(2, bottom - pad, top + pad, span));
        match (slab, cells) {
            (Some(span), Cells::Touched) => self.rows(span),
            (Some(span), Cells::All) => self.all_cells(span),
            (None, _) => {}
        }
        self.walls();
        if let (Some(hit), None, Some([from, _])) = (&mut self.best, self.start, window)
            && let (Part::Cell(..), false) = (hit.part, oracle.place.one_sided)
        {
            hit.front = oracle.starts_above(ray, from).unwrap_or(hit.front);
        }
        self.best
    }

    /// Every cell whose closed square the clipped ray can touch, row by row.
    fn rows(&mut self, span: [f64; 2]) {
        let (ray, margin) = (self.ray, self.ray.margin);
        let reach = |a: f64, b: f64| {
            (a.min(b) - margin).floor() as i32..=(a.max(b) + margin).floor() as i32
        };
        let [from, to] = span.map(|t| ray.at(t));
        for j in reach(from.y, to.y) {
            let (bottom, top) = (f64::from(j) - margin, f64::from(j + 1) + margin);
            if let Some(row) = ray.clip(1, bottom, top, span) {
                let [from, to] = row.map(|t| ray.at(t));
                reach(from.x, to.x).for_each(|i| self.cell(i, j, span));
            }
        }
    }

    fn all_cells(&mut self, span: [f64; 2]) {
        let (low, high) = (self.oracle.low.floor(), self.oracle.high.floor());
        for j in low.y as i32..=high.y as i32 {
            (low.x as i32..=high.x as i32).for_each(|i| self.cell(i, j, span));
        }
    }

    fn cell(&mut self, i: i32, j: i32, span: [f64; 2]) {
        let (ray, oracle) = (self.ray, self.oracle);
        let (x, y) = (f64::from(i), f64::from(j));
        let (low, high) = (oracle.low, oracle.high);
        // A cell that only touches the window belongs to what lies beyond the face.
        if x >= high.x || y >= high.y || x + 1.0 <= low.x || y + 1.0 <= low.y {
            return;
        }
        let inside = ray
            .clip(0, x - ray.margin, x + 1.0 + ray.margin, span)
            .and_then(|span| ray.clip(1, y - ray.margin, y + 1.0 + ray.margin, span));
        let Some(span) = inside else {
            return;
        };
        let patch = oracle.patch(i, j);
        let local = ray.o - DVec3::new(x, y, 0.0);
        let own = self.start.is_some_and(|start| start.part == Part::Cell(i, j));
        let roots = if own {
            patch.other_root(local, ray.d, span)
        } else {
            patch.roots(local, ray.d, span)
        };
        for (t, gap_rises) in roots {
            let step = (t * ray.d.truncate()).length();
            let is_start = self.start.is_some() && !own && step <= SAME_POINT;
            let on_ray = t >= 0.0 && t <= ray.t_max;
            let front = !gap_rises;
            if on_ray && !is_start && (front || !oracle.place.one_sided) {
                self.offer(t, front, Part::Cell(i, j));
            }
        }
    }

    pub(super) fn offer(&mut self, t: f64, front: bool, part: Part) {
        if self.best.is_some_and(|hit| hit.t <= t) {
            return;
        }
        let at = self.ray.at(t);
        let uv = self.oracle.uv_of_lattice(at.truncate());
        let position = self.oracle.point(uv.x, uv.y, at.z);
        self.best = Some(OracleHit { t, position, uv, offset: at.z, front, part });
    }
}

impl Oracle<'_> {
    /// Whether a ray is above the surface where it enters the window, if that is beyond doubt. At
    /// the first crossing it still is. The slope of the gap says the same, but where a ray touches
    /// a sample, two roots in two cells are apart by less than their rounding.
    fn starts_above(&self, ray: &Local, t: f64) -> Option<bool> {
        let at = ray.at(t);
        // On the far border the last cell inside, not the first beyond.
        let cell = at.truncate().floor().clamp(self.low.floor(), self.high.ceil() - 1.0);
        let patch = self.patch(cell.x as i32, cell.y as i32);
        let gap = at.z - patch.value(at.truncate() - cell);
        (gap.abs() > 1e-9 * self.size()).then_some(gap > 0.0)
    }
}
