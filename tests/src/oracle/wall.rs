//! Upright walls: on the border of a closed face, and on the seams of a vertex lattice that
//! repeats with a jump.
//!
//! The front of a wall is its airy side: the side from which one looks at the surface from above.
//! A border wall faces outwards where the surface stands above the plane of the face, and inwards
//! where it lies below; a seam wall faces the lower of its two sides.

use glam::DVec2;
use rilievo::map::{Axis, Lattice, Wrap};
use rilievo::{Part, Wall};

use super::Oracle;
use super::search::Search;

/// The line of the lattice a wall stands on.
pub(super) struct Stand {
    pub(super) axis: usize,
    pub(super) coordinate: f64,
}

impl Oracle<'_> {
    /// Whether the surface may jump at lattice line `line` of axis 0 (x) or 1 (y).
    pub fn is_seam(&self, axis: usize, line: i32) -> bool {
        let axis = if axis == 0 { self.map.x() } else { self.map.y() };
        jumps(axis) && line.rem_euclid(axis.period() as i32) == 0
    }

    pub(super) fn stand_of(&self, wall: Wall) -> Stand {
        let (axis, coordinate) = match wall {
            Wall::LowU => (0, self.at_zero.x),
            Wall::HighU => (0, self.at_zero.x + self.per_uv.x),
            Wall::LowV => (1, self.at_zero.y),
            Wall::HighV => (1, self.at_zero.y + self.per_uv.y),
            Wall::SeamU(x) => (0, f64::from(x)),
            Wall::SeamV(y) => (1, f64::from(y)),
        };
        Stand { axis, coordinate }
    }

    /// Offset of the surface at `foot`, by the cell that reaches it from the smaller (`side` -1)
    /// or larger (+1) coordinate along `axis`.
    fn offset_beside(&self, axis: usize, foot: DVec2, side: f64) -> f64 {
        let mut cell = foot.floor();
        if side < 0.0 && cell[axis] == foot[axis] {
            cell[axis] -= 1.0;
        }
        self.patch(cell.x as i32, cell.y as i32).value(foot - cell)
    }
}

impl Search<'_> {
    pub(super) fn walls(&mut self) {
        let oracle = self.oracle;
        if oracle.place.closed {
            for wall in [Wall::LowU, Wall::HighU, Wall::LowV, Wall::HighV] {
                self.wall(wall);
            }
        }
        let (low, high) = (oracle.low, oracle.high);
        seams(oracle.map.x(), low.x, high.x).for_each(|x| self.wall(Wall::SeamU(x)));
        seams(oracle.map.y(), low.y, high.y).for_each(|y| self.wall(Wall::SeamV(y)));
    }

    fn wall(&mut self, wall: Wall) {
        let (ray, oracle) = (self.ray, self.oracle);
        let Stand { axis, coordinate } = oracle.stand_of(wall);
        let along = 1 - axis;
        let t = (coordinate - ray.o[axis]) / ray.d[axis];
        // A ray within the plane of a wall, and NaN, touch nothing; nor does a ray its own wall.
        let own = self.start.is_some_and(|start| start.part == Part::Wall(wall));
        if own || !(t >= 0.0 && t <= ray.t_max) || ray.d[axis] == 0.0 {
            return;
        }
        let at = ray.at(t);
        if at[along] < oracle.low[along] || at[along] > oracle.high[along] {
            return;
        }
        let mut foot = at.truncate();
        foot[axis] = coordinate;
        let below = oracle.offset_beside(axis, foot, -1.0);
        let above = oracle.offset_beside(axis, foot, 1.0);
        // Offsets on the wall's two sides, at smaller and larger lattice coordinate.
        let seam = matches!(wall, Wall::SeamU(_) | Wall::SeamV(_));
        let (left, right) = if seam {
            (below, above)
        } else if coordinate <= oracle.low[axis] {
            (0.0, above)
        } else {
            (below, 0.0)
        };
        if at.z < left.min(right) || at.z > left.max(right) {
            return;
        }
        let faces_up = left > right;
        let front = faces_up == (ray.d[axis] < 0.0);
        if front || !oracle.place.one_sided {
            self.offer(t, front, Part::Wall(wall));
        }
    }
}

fn jumps(axis: &Axis) -> bool {
    axis.lattice() == Lattice::Vertex && axis.wrap() == Wrap::Repeat
}

/// The seams of an axis strictly inside the window.
fn seams(axis: &Axis, low: f64, high: f64) -> impl Iterator<Item = i32> + use<> {
    let period = axis.period() as i32;
    let first = (low / f64::from(period)).floor() as i32 + 1;
    let end = if jumps(axis) { (high / f64::from(period)).ceil() as i32 } else { first };
    (first..end).map(move |k| k * period)
}
