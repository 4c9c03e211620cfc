//! [`Departure`]: what the surface a ray leaves says about the surfaces it touches.
//!
//! The start of a ray that leaves a surface is off it by rounding. Next to an edge it may lie on
//! the wrong side of the neighbour: a ray into the neighbour would then leak, and a ray away from
//! it would be stopped. An interval `t > epsilon` mends neither. Geometry decides:
//!
//! * A ray that leaves a planar primitive never meets what lies wholly on or behind its plane, as
//!   seen from the side it leaves to. So do coplanar neighbours, and those around convex edges.
//! * Where the start lies *on* a neighbour's plane to rounding, and the surface left lies wholly
//!   on one side of that plane, so does the true start: a ray towards that side never meets the
//!   neighbour, any other one does, at `t = 0` at least.
//!
//! Elsewhere the sign of the computed `t` is right and decides.
//!
//! Most rays leave a surface and cross no flat one, so nothing is computed before a crossing asks.

use glam::DVec3;

use super::crossing::Crossing;

/// A point this close to a plane is on it, as a fraction of the largest coordinate.
const ON_PLANE: f64 = 32.0 * f64::EPSILON;

/// Relative error of a computed normal, in products of its two edges.
const NORMAL_ERROR: f64 = 8.0 * f64::EPSILON;

/// A surface that is not flat, as its neighbours see it.
pub(crate) trait Shell {
    /// Eight points in whose hull the surface lies at a time.
    fn hull(&self, time: f64) -> [DVec3; 8];
}

/// The surface that a ray leaves.
#[derive(Clone, Copy)]
pub(crate) enum Departure<'a> {
    /// A triangle, and whether the ray leaves to where its normal points.
    Triangle([DVec3; 3], bool),
    /// A parallelogram, likewise, and its plane if that is known.
    Parallelogram(&'a [DVec3; 4], Option<&'a Plane>, bool),
    /// A surface that fills a shell, and when the ray leaves it.
    Shell(&'a dyn Shell, f64),
}

impl Departure<'_> {
    /// The surface lies in the hull of these points; some may be the same.
    fn hull(&self) -> [DVec3; 8] {
        match *self {
            Self::Triangle([a, b, c], _) => [a, b, c, c, c, c, c, c],
            Self::Parallelogram(&[a, b, c, d], ..) => [a, b, c, d, d, d, d, d],
            Self::Shell(shell, time) => shell.hull(time),
        }
    }

    /// Of a planar surface: its plane, and whether the ray leaves to where the normal points.
    fn plane(&self) -> Option<(Plane, bool)> {
        match *self {
            Self::Triangle(corners, front) => Some((Plane::through(&corners), front)),
            Self::Parallelogram(&[a, b, _, d], plane, front) => {
                Some((plane.copied().unwrap_or_else(|| Plane::through(&[a, b, d])), front))
            }
            Self::Shell(..) => None,
        }
    }

    /// The parameter, at least 0, at which a ray that starts at `start` meets the triangle
    /// `corners` whose plane its line crosses at `crossing`; `None` if it does not.
    #[inline]
    pub(crate) fn meeting(
        &self,
        start: DVec3,
        corners: &[DVec3; 3],
        crossing: &Crossing,
    ) -> Option<f64> {
        self.meeting_in(&Plane::through(corners), start, corners, crossing)
    }

    /// [`Departure::meeting`] with a triangle whose plane is known.
    #[inline]
    pub(crate) fn meeting_in(
        &self,
        plane: &Plane,
        start: DVec3,
        corners: &[DVec3; 3],
        crossing: &Crossing,
    ) -> Option<f64> {
        if let Some((own, front)) = self.plane() {
            let leaving = if front { Side::Front } else { Side::Back };
            if corners.iter().all(|&p| own.side(p, 0.0) != leaving) {
                return None;
            }
        }
        let at_or_after = (crossing.t >= 0.0).then_some(crossing.t);
        if plane.side(start, ON_PLANE) != Side::On {
            return at_or_after;
        }
        let sides = self.hull().map(|p| plane.side(p, ON_PLANE));
        match (sides.contains(&Side::Front), sides.contains(&Side::Back)) {
            (true, true) => at_or_after,
            (true, false) => crossing.front.then_some(crossing.t.max(0.0)),
            (false, true) => (!crossing.front).then_some(crossing.t.max(0.0)),
            (false, false) => None,
        }
    }
}

/// Where a point lies with respect to a plane, to rounding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Front,
    On,
    Back,
}

/// The plane of a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plane {
    point: DVec3,
    /// Cross product of two edges.
    normal: DVec3,
    /// Product of the lengths of these edges, and length of the normal.
    edges: f64,
    length: f64,
    reach: f64,
}

impl Plane {
    pub(crate) fn through(&[a, b, c]: &[DVec3; 3]) -> Self {
        let (e, f) = (b - a, c - a);
        let normal = e.cross(f);
        Self {
            point: a,
            normal,
            edges: e.length() * f.length(),
            length: normal.length(),
            reach: a.abs().max(b.abs()).max(c.abs()).max_element(),
        }
    }

    /// The side of `p`, which is itself known to the fraction `error` of its largest coordinate
    /// or the plane's.
    fn side(&self, p: DVec3, error: f64) -> Side {
        let r = p - self.point;
        let height = self.normal.dot(r);
        let reach = self.reach.max(p.abs().max_element());
        let bound = error * self.length * reach + NORMAL_ERROR * self.edges * r.length();
        if height > bound {
            Side::Front
        } else if height < -bound {
            Side::Back
        } else {
            Side::On
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLOOR: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];

    /// Leaves the floor upwards at its border x = 1, `off` beyond it, along `direction`.
    fn meets(neighbour: [DVec3; 3], off: f64, direction: DVec3) -> bool {
        let start = DVec3::new(1.0 + off, 0.5, 0.0);
        let [a, b, c] = neighbour;
        let n = (b - a).cross(c - a);
        let t = n.dot(a - start) / n.dot(direction);
        let crossing = Crossing { t, weights: [0.0; 3], front: n.dot(direction) < 0.0 };
        let departure = Departure::Parallelogram(&FLOOR, None, true);
        departure.meeting(start, &neighbour, &crossing).is_some_and(|t| t >= 0.0)
    }

    #[test]
    fn decides_at_every_kind_of_neighbour() {
        let wall = |top: DVec3| [DVec3::X, top, DVec3::new(1.0, 1.0, 0.0)];
        let outwards = DVec3::new(1.0, 0.0, 1.0);
        let inwards = DVec3::new(-1.0, 0.0, 1.0);
        for off in [-2e-16, 0.0, 2e-16] {
            for flip in [false, true] {
                let turn = |[a, b, c]: [DVec3; 3]| if flip { [a, c, b] } else { [a, b, c] };
                let upright = turn(wall(DVec3::new(1.0, 0.5, 1.0)));
                assert!(meets(upright, off, outwards), "leak at {off}");
                assert!(!meets(upright, off, inwards), "stopped at {off}");
                let overhang = turn(wall(DVec3::new(0.0, 0.5, 1.0)));
                assert!(meets(overhang, off, DVec3::Z));
                let hanging = turn(wall(DVec3::new(1.0, 0.5, -1.0)));
                assert!(!meets(hanging, off, outwards) && !meets(hanging, off, inwards));
                let coplanar = turn(wall(DVec3::new(2.0, 0.5, 0.0)));
                assert!(!meets(coplanar, off, outwards) && !meets(coplanar, off, DVec3::Z));
            }
        }
        // Not on the plane of the wall: the parameter alone decides.
        let far = wall(DVec3::new(1.0, 0.5, 1.0)).map(|p| p + DVec3::X);
        assert!(meets(far, 0.0, outwards) && !meets(far, 0.0, inwards));
    }
}
