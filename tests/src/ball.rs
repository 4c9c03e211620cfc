//! Balls around what cells show, by which judges and brute force leave out what a line cannot meet.
//!
//! What a cell shows lies in the convex hull of eight points: its four corners at its lowest and at its highest
//! offset. On a mesh, for one offset `P + o N` is affine in the lattice coordinates of a triangle, and for one place affine
//! in `o`; on a sphere a cell is, for one `Z`, a square, and scales with `Z`. A ball that holds the eight holds the
//! cell; it is made larger by a thousandth of itself and by far more than coordinates are rounded. A line that
//! passes the ball does not meet the cell. Balls make a plain list: no bound of many cells is trusted but that of a whole base
//! triangle, and of 8 x 8 cells of a sphere, which are made in the same way: a square too, at its smallest and largest `Z`.

use glam::{DVec2, DVec3};
use rilievo::Ray;

/// A ball of which a line may keep clear.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    centre: DVec3,
    radius: f64,
}

impl Ball {
    /// Around points, with room for rounding.
    pub fn around(points: &[DVec3]) -> Self {
        let centre = points.iter().sum::<DVec3>() / points.len() as f64;
        let farthest = points.iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
        Self::of(centre, farthest)
    }

    /// By centre and radius, with room for rounding.
    pub fn of(centre: DVec3, radius: f64) -> Self {
        Self { centre, radius: 1.001 * radius + 1e-12 * centre.abs().max_element() }
    }
}

/// The line of a ray, seen along it.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    origin: DVec3,
    across: [DVec3; 2],
}

impl Line {
    /// The whole line, in front of the ray's origin and behind.
    pub fn of(ray: &Ray) -> Self {
        let across = ray.direction.normalize().any_orthonormal_pair();
        Self { origin: ray.origin, across: [across.0, across.1] }
    }

    /// The distance to the line of a vector from the ray's origin, as a vector in the plane across it.
    pub fn across(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.across[0]), v.dot(self.across[1]))
    }

    /// Whether the line passes a ball.
    #[inline]
    pub fn misses(&self, ball: &Ball) -> bool {
        self.across(ball.centre - self.origin).length_squared() > ball.radius * ball.radius
    }
}
