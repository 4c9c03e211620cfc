//! The judge of displaced spheres: `f64`, every cell of all six faces, no hierarchy.
//!
//! Nothing is shared with the library but the resampled heights. The judge stays in world space: with
//! `U = (X - a_i Z) / c` and `V = (Y - b_j Z) / c` in the frame of a face, a cell of size `c` is the part
//! `0 <= U <= Z`, `0 <= V <= Z` of the quadric
//!
//! ```text
//! q00 Z^2 + (q10 - q00) U Z + (q01 - q00) V Z + (q00 - q10 - q01 + q11) U V - Z = 0
//! ```
//!
//! that `1 / Z = q(U / Z, V / Z)` becomes when it is multiplied by `Z^2`. U, V and Z are linear along
//! a ray: a quadratic in its parameter. No projective parameter, no line of the lattice, no clip.

use glam::DVec3;
use rilievo::map::CubeFace;
use rilievo::{Hit, Ray};

use super::SphereScene;
use crate::ball::{Ball, Line};
use crate::nudge::nudged;

/// The answer of the judge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereHit {
    /// Ray parameter.
    pub t: f64,
    /// The point, in world space.
    pub position: DVec3,
    /// Whether the ray came from outside.
    pub front: bool,
}

/// One cell: its face, its corner's direction and the quadric.
struct Cell {
    face: CubeFace,
    corner: [f64; 2],
    /// Coefficients of Z^2, U Z, V Z and U V.
    quadric: [f64; 4],
}

/// A displaced sphere to be judged by.
pub struct SphereOracle<'a> {
    scene: &'a SphereScene,
    cells: Vec<Cell>,
    /// One a cell, about the centre: what it shows is in the convex hull of its corners at its smallest and at
    /// its largest `1 / Z`.
    balls: Vec<Ball>,
    /// Size of a cell.
    step: f64,
}

impl<'a> SphereOracle<'a> {
    /// The sphere of a scene.
    pub fn new(scene: &'a SphereScene) -> Self {
        let n = scene.heights.cells();
        let step = 2.0 / f64::from(n);
        let (mut cells, mut balls) = (Vec::new(), Vec::new());
        for face in CubeFace::ALL {
            let map = scene.heights.face(face);
            let q = |i: u32, j: u32| {
                let (a, b) = (f64::from(i) * step - 1.0, f64::from(j) * step - 1.0);
                let height = f64::from(map.raw(i, j)) * map.unit();
                let offset = scene.displacement.scale * (height - scene.displacement.zero);
                (1.0 + a * a + b * b).sqrt() / (scene.radius + offset)
            };
            for j in 0..n {
                for i in 0..n {
                    let [q00, q10, q01, q11] = [q(i, j), q(i + 1, j), q(i, j + 1), q(i + 1, j + 1)];
                    let quadric = [q00, q10 - q00, q01 - q00, (q11 - q10) - (q01 - q00)];
                    let corner = [i, j].map(|k| f64::from(k) * step - 1.0);
                    let ends = [q00.min(q10).min(q01).min(q11), q00.max(q10).max(q01).max(q11)];
                    let corners = [[0.0, 0.0], [step, 0.0], [0.0, step], [step, step]];
                    let points = corners.map(|[x, y]| {
                        ends.map(|q| face.from_frame([corner[0] + x, corner[1] + y, 1.0]) / q)
                    });
                    balls.push(Ball::around(points.as_flattened()));
                    cells.push(Cell { face, corner, quadric });
                }
            }
        }
        Self { scene, cells, balls, step }
    }

    /// What distances are measured by: the radius, and how exactly `f64` can name a point there.
    pub fn tolerance(&self) -> f64 {
        1e-9 * self.scene.radius + 1e-12 * self.scene.center.length()
    }

    /// The nearest meeting with `after < t <= t_max`. The ray's `from` is not looked at.
    pub fn closest(&self, ray: &Ray, after: f64) -> Option<SphereHit> {
        // From the point nearest to the centre, so that far origins cost no digits.
        let direction = ray.direction;
        let arm = ray.origin - self.scene.center;
        let middle = -arm.dot(direction) / direction.length_squared();
        let near = arm + middle * direction;
        let range = [after - middle, ray.t_max - middle];
        let line = Line::of(&Ray::new(near, direction));
        let cells = self.cells.iter().zip(&self.balls).filter(|(_, ball)| !line.misses(ball));
        let hits = cells.filter_map(|(cell, _)| self.meet(cell, near, direction, range));
        let (e, front) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let position = self.scene.center + (near + e * direction);
        Some(SphereHit { t: middle + e, position, front })
    }

    /// Whether an answer to a ray is this judge's, to rounding.
    pub fn agrees(&self, answer: &Option<Hit>, ray: &Ray) -> bool {
        agree(answer, &self.closest(ray, -1e-300), self.tolerance())
    }

    /// Whether it is this judge's for some ray a nudge away.
    pub fn excuses(&self, answer: &Option<Hit>, ray: &Ray) -> bool {
        let towards = answer.map(|hit| hit.position - ray.origin);
        let normal = ray.origin - self.scene.center;
        nudged(ray.direction, towards, normal).any(|direction| {
            let judge = self.closest(&Ray { direction, ..*ray }, -1e-300);
            agree(answer, &judge, 1e4 * self.tolerance())
        })
    }

    /// The first root over a cell, from outside or not.
    fn meet(&self, cell: &Cell, o: DVec3, d: DVec3, [from, to]: [f64; 2]) -> Option<(f64, bool)> {
        let frame = |v: DVec3| {
            let [x, y, z] = cell.face.to_frame(v);
            [(x - cell.corner[0] * z) / self.step, (y - cell.corner[1] * z) / self.step, z]
        };
        let ([u, v, z], [du, dv, dz]) = (frame(o), frame(d));
        let [k, ku, kv, kuv] = cell.quadric;
        let a = k * dz * dz + ku * du * dz + kv * dv * dz + kuv * du * dv;
        let b = 2.0 * k * z * dz
            + ku * (u * dz + z * du)
            + kv * (v * dz + z * dv)
            + kuv * (u * dv + v * du)
            - dz;
        let c = k * z * z + ku * u * z + kv * v * z + kuv * u * v - z;
        let margin = 1e-11 / self.step;
        let inside = |e: f64| {
            let (u, v, z) = (u + e * du, v + e * dv, z + e * dz);
            let kept = |w: f64| w >= -margin * z && w <= (1.0 + margin) * z;
            z > 0.0 && kept(u) && kept(v) && from < e && e <= to
        };
        let roots = roots(a, b, c);
        let first = roots.into_iter().flatten().find(|&e| inside(e))?;
        // The quadric is positive outside: it falls where a ray comes in.
        Some((first, 2.0 * a * first + b < 0.0))
    }
}

/// Whether two answers are the same but for rounding.
pub fn agree(answer: &Option<Hit>, judge: &Option<SphereHit>, tolerance: f64) -> bool {
    match (answer, judge) {
        (None, None) => true,
        (Some(hit), Some(judge)) => {
            hit.front == judge.front && hit.position.distance(judge.position) <= tolerance
        }
        _ => false,
    }
}

/// Real roots of `a e^2 + b e + c`, in order.
fn roots(a: f64, b: f64, c: f64) -> [Option<f64>; 2] {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant.is_nan() || discriminant < 0.0 {
        return [None; 2];
    }
    let w = -0.5 * (b + discriminant.sqrt().copysign(b));
    let (first, second) = (w / a, c / w);
    let finite = |e: f64| e.is_finite().then_some(e);
    let (low, high) = if first < second { (first, second) } else { (second, first) };
    [finite(low), finite(high)]
}
