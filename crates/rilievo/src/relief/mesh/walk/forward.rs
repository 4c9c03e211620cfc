//! [`Forward`]: the unfolded cells of one tile, counted along a ray.

use glam::DVec3;

use crate::map::Run;
use crate::simd::Quad;

use super::super::footprint::MARGIN;
use super::super::frame::{Bent, Frame, Path};

/// Forward coordinates of a tile: they count stored cells, up or down, so that they rise along the
/// ray. `forward = sign unfolded + shift`, and a stored cell is a forward cell combined with `turn`.
#[derive(Clone, Copy)]
pub(super) struct Forward {
    pub sign: [i32; 2],
    pub shift: [i32; 2],
    pub turn: [i32; 2],
    /// Forward cells of the tile that the prism shows.
    pub first: [i32; 2],
    pub end: [i32; 2],
}

impl Forward {
    #[inline(always)]
    pub fn new(runs: [&Run; 2], cells: [[i32; 2]; 2], speed: DVec3) -> Self {
        let mut all =
            Self { sign: [1; 2], shift: [0; 2], turn: [0; 2], first: [0; 2], end: [0; 2] };
        for k in 0..2 {
            let run = runs[k];
            let (first, end) = (cells[k][0].max(run.start), cells[k][1].min(run.end()));
            let backward = speed[k] < 0.0;
            // Where unfolded 0 is stored, counted in the direction of the run.
            let at = if run.flipped { -(run.first + 1 + run.start) } else { run.first - run.start };
            all.turn[k] = -i32::from(run.flipped != backward);
            if backward {
                all.sign[k] = -1;
                all.shift[k] = -at;
                (all.first[k], all.end[k]) = (-at - end, -at - first);
            } else {
                all.shift[k] = at;
                (all.first[k], all.end[k]) = (first + at, end + at);
            }
        }
        all
    }

    /// The unfolded cell of a forward cell.
    #[inline(always)]
    pub fn unfolded(&self, cell: [i32; 2]) -> [i32; 2] {
        let mut unfolded = [0; 2];
        for k in 0..2 {
            unfolded[k] = if self.sign[k] > 0 {
                cell[k] - self.shift[k]
            } else {
                self.shift[k] - cell[k] - 1
            };
        }
        unfolded
    }

    /// Corner heights `h00 h10 h01 h11` of a forward cell in the order of unfolded cells.
    #[inline(always)]
    pub fn unfolded_corners(&self, [a, b, c, d]: [f32; 4]) -> [f32; 4] {
        let [a, b, c, d] = if self.sign[0] < 0 { [b, a, d, c] } else { [a, b, c, d] };
        if self.sign[1] < 0 { [c, d, a, b] } else { [a, b, c, d] }
    }

    /// The forward cells of the tile that a path may touch within a span, first and one past the last.
    #[inline(always)]
    pub fn touched<Q: Quad>(&self, path: &Path, [from, to]: [f64; 2]) -> [[i32; 2]; 2] {
        let (first, end) = (self.first, self.end);
        if path.is_blind() {
            return [[first[0], end[0]], [first[1], end[1]]];
        }
        let both = |v: DVec3| Q::of([v.x, v.y, v.x, v.y]);
        let (start, speed) = (both(path.start), both(path.speed));
        let (a, b) = (start.plus(speed.scaled(from)), start.plus(speed.scaled(to)));
        let room = both(path.error).plus(Q::splat(MARGIN));
        // Low in the first two, what is high turned over in the others.
        let turn = Q::of([0.0, 0.0, -0.0, -0.0]);
        let low = a.turned_by(turn).smaller(b.turned_by(turn)).minus(room);
        let ends = [first[0], first[1], end[0] - 1, end[1] - 1].map(f64::from);
        let beyond = [end[0], end[1], first[0] - 1, first[1] - 1].map(f64::from);
        let (ends, beyond) = (Q::of(ends).turned_by(turn), Q::of(beyond).turned_by(turn));
        let [x, y, x_end, y_end] = low.larger(ends).smaller(beyond).turned_by(turn).floors();
        [[x, x_end + 1], [y, y_end + 1]]
    }

    /// A path over unfolded cells, over forward cells.
    #[inline(always)]
    pub fn path(&self, path: &Path) -> Path {
        let mut path = *path;
        for k in 0..2 {
            let sign = f64::from(self.sign[k]);
            path.start[k] = sign * path.start[k] + f64::from(self.shift[k]);
            path.speed[k] *= sign;
        }
        path
    }

    /// A frame's bend over forward cells; `centre` is that of the frame over unfolded cells.
    #[inline(always)]
    pub fn bent(&self, frame: &Frame, mut centre: DVec3) -> Bent {
        let sign = self.sign.map(f64::from);
        for k in 0..2 {
            centre[k] = sign[k] * centre[k] + f64::from(self.shift[k]);
        }
        frame.bent(centre, sign)
    }
}
