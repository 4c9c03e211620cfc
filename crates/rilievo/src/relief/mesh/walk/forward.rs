//! [`Forward`]: the unfolded cells of one tile, counted along a ray.

use glam::DVec3;

use crate::map::Run;

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
