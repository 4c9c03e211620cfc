//! Walls as the oracle sees them: along edges, and where the map jumps between tiles.

use glam::{DVec2, DVec3};
use rilievo::Ray;
use rilievo::map::{Lattice, Wrap};

use super::polynomial::roots;
use super::{CLOSED, MeshOracle};
use crate::ball::Ball;

/// An edge with what its sides show; nothing stands for offset 0.
#[derive(Clone, Copy)]
pub(super) struct BaseWall {
    pub ends: [DVec3; 2],
    pub normals: [DVec3; 2],
    pub sides: [Option<Shown>; 2],
    pub ball: Ball,
}

/// Lattice coordinates of both ends of an edge, and towards which side of it the map is looked up.
#[derive(Clone, Copy)]
pub(super) struct Shown {
    pub ends: [DVec2; 2],
    pub inside: DVec2,
}

impl MeshOracle<'_> {
    /// A wall with its ball.
    pub(super) fn wall(
        &self,
        ends: [DVec3; 2],
        normals: [DVec3; 2],
        sides: [Option<Shown>; 2],
    ) -> BaseWall {
        let (low, high) = self.map.raw_range();
        let offsets = [self.offset(f64::from(low)), self.offset(f64::from(high)), 0.0];
        let points = (0..2).flat_map(|k| offsets.map(|o| ends[k] + o * normals[k]));
        BaseWall { ends, normals, sides, ball: Ball::around(&points.collect::<Vec<_>>()) }
    }

    /// Adds walls where the map repeats on a vertex lattice: along each line between tiles that crosses a triangle.
    pub(super) fn add_jumps(&mut self, [corners, normals]: &[[DVec3; 3]; 2], lattice: &[DVec2; 3]) {
        for (axis, across) in [self.map.x(), self.map.y()].into_iter().enumerate() {
            if (across.lattice(), across.wrap()) != (Lattice::Vertex, Wrap::Repeat) {
                continue;
            }
            let period = f64::from(across.period());
            let at = lattice.map(|l| l[axis] / period);
            let (low, high) =
                at.iter().fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
            for line in low.ceil() as i64..=high.floor() as i64 {
                let line = line as f64;
                // Places where the border of the triangle crosses the line, as a corner and a share of the way to the next.
                let ends: Vec<(usize, f64)> = (0..3)
                    .map(|k| (k, (line - at[k]) / (at[(k + 1) % 3] - at[k])))
                    .filter(|(_, s)| (0.0..1.0).contains(s))
                    .collect();
                let &[(k, s), (l, r)] = ends.as_slice() else { continue };
                let both = |of: &[DVec3; 3]| {
                    [of[k].lerp(of[(k + 1) % 3], s), of[l].lerp(of[(l + 1) % 3], r)]
                };
                let shown = [
                    lattice[k].lerp(lattice[(k + 1) % 3], s),
                    lattice[l].lerp(lattice[(l + 1) % 3], r),
                ];
                let side =
                    |towards: f64| Some(Shown { ends: shown, inside: towards * DVec2::AXES[axis] });
                let (ends, normals) = (both(corners), both(normals));
                self.walls.push(self.wall(ends, normals, [side(-1.0), side(1.0)]));
            }
        }
    }

    /// The raw height at lattice coordinates, as the cell shows it that holds others near by.
    fn raw_beside(&self, at: DVec2, near: DVec2) -> f64 {
        let cell = near.floor();
        let [h00, h10, h01, h11] =
            self.map.unfolded_corners(cell.x as i32, cell.y as i32).map(f64::from);
        let DVec2 { x, y } = at - cell;
        (1.0 - x) * (1.0 - y) * h00 + x * (1.0 - y) * h10 + (1.0 - x) * y * h01 + x * y * h11
    }

    /// All meetings of a line with a wall.
    pub(super) fn cross_wall(&self, wall: &BaseWall, ray: &Ray, all: &mut Vec<f64>) {
        let d = ray.direction;
        let at =
            |s: f64| (wall.ends[0].lerp(wall.ends[1], s), wall.normals[0].lerp(wall.normals[1], s));
        let volume = |s: f64| {
            let (p, n) = at(s);
            (p - ray.origin).cross(n).dot(d)
        };
        let (f0, f1, f2) = (volume(0.0), volume(0.5), volume(1.0));
        for s in roots(&[f0, -3.0 * f0 + 4.0 * f1 - f2, 2.0 * (f0 - 2.0 * f1 + f2)]) {
            let (p, n) = at(s);
            let across = n.cross(d);
            let offset = -(p - ray.origin).cross(d).dot(across) / across.length_squared();
            let heights = wall.sides.map(|side| match side {
                Some(Shown { ends: [a, b], inside }) => {
                    let at = a.lerp(b, s);
                    self.raw_beside(at, at + 1e-7 * inside)
                }
                None => self.raw(0.0),
            });
            let raw = self.raw(offset);
            let pad = CLOSED * (heights[0] - heights[1]).abs();
            let (low, high) = (heights[0].min(heights[1]), heights[0].max(heights[1]));
            if (low - pad..=high + pad).contains(&raw) && high - low > 1e-9 * high.abs() {
                all.push((p + offset * n - ray.origin).dot(d) / d.length_squared());
            }
        }
    }
}
