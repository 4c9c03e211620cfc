//! The judge of displaced spheres: `f64`, every cell of all six faces in plain lists of 8 x 8.
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
use rilievo::map::{CubeFace, HeightMap};
use rilievo::relief::Displacement;
use rilievo::{Hit, Ray};

use super::SphereScene;
use crate::ball::{Ball, Line};
use crate::nudge::nudged;

/// Cells along a side of what one ball holds.
const BLOCK: u32 = 8;

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

/// Up to [`BLOCK`] x [`BLOCK`] cells: their face and the first of them.
struct Block {
    face: CubeFace,
    first: [u32; 2],
    /// About the centre: what the cells show is in the convex hull of the block's corners at its smallest and at
    /// its largest `1 / Z`.
    ball: Ball,
}

/// A displaced sphere to be judged by.
pub struct SphereOracle {
    center: DVec3,
    radius: f64,
    largest: f64,
    /// Cells along a face.
    cells: u32,
    /// `q` at the lattice points of all faces.
    lattice: Vec<f64>,
    blocks: Vec<Block>,
    /// Size of a cell.
    step: f64,
}

impl SphereOracle {
    /// The sphere of a scene.
    pub fn new(scene: &SphereScene) -> Self {
        let faces = CubeFace::ALL.map(|face| scene.heights.face(face));
        Self::of(faces, (scene.center, scene.radius), scene.displacement)
    }

    /// A sphere by its faces' maps in the order of [`CubeFace::ALL`], its centre and radius, and how the maps count.
    pub fn of(
        faces: [&HeightMap; 6],
        (center, radius): (DVec3, f64),
        displacement: Displacement,
    ) -> Self {
        let cells = faces[0].x().cells();
        let step = 2.0 / f64::from(cells);
        let at = |k: u32| f64::from(k) * step - 1.0;
        let mut largest = 0.0f64;
        let mut lattice = Vec::with_capacity(6 * (cells as usize + 1).pow(2));
        for map in faces {
            for j in 0..=cells {
                for i in 0..=cells {
                    let (a, b) = (at(i), at(j));
                    let height = f64::from(map.raw(i, j)) * map.unit();
                    let distance = radius + displacement.scale * (height - displacement.zero);
                    largest = largest.max(distance);
                    lattice.push((1.0 + a * a + b * b).sqrt() / distance);
                }
            }
        }
        let mut oracle = Self { center, radius, largest, cells, lattice, blocks: Vec::new(), step };
        let starts = || (0..cells).step_by(BLOCK as usize);
        oracle.blocks = CubeFace::ALL
            .into_iter()
            .flat_map(|face| starts().flat_map(move |j| starts().map(move |i| (face, [i, j]))))
            .map(|(face, first)| Block { face, first, ball: oracle.ball(face, first) })
            .collect();
        oracle
    }

    /// `q` at a lattice point of a face.
    fn q(&self, face: CubeFace, [i, j]: [u32; 2]) -> f64 {
        let side = self.cells as usize + 1;
        self.lattice[(face.index() * side + j as usize) * side + i as usize]
    }

    /// A lattice coordinate as a direction's.
    fn at(&self, k: u32) -> f64 {
        f64::from(k) * self.step - 1.0
    }

    /// One past the last cell of a block that begins with this one.
    fn end(&self, first: u32) -> u32 {
        (first + BLOCK).min(self.cells)
    }

    /// Around all that a block shows.
    fn ball(&self, face: CubeFace, first: [u32; 2]) -> Ball {
        let end = first.map(|k| self.end(k));
        let mut range = [f64::INFINITY, 0.0f64];
        for j in first[1]..=end[1] {
            for i in first[0]..=end[0] {
                let q = self.q(face, [i, j]);
                range = [range[0].min(q), range[1].max(q)];
            }
        }
        let corners = [first, [end[0], first[1]], [first[0], end[1]], end];
        let points =
            corners.map(|[i, j]| range.map(|q| face.from_frame([self.at(i), self.at(j), 1.0]) / q));
        Ball::around(points.as_flattened())
    }

    fn cell(&self, face: CubeFace, [i, j]: [u32; 2]) -> Cell {
        let [q00, q10, q01, q11] =
            [[i, j], [i + 1, j], [i, j + 1], [i + 1, j + 1]].map(|point| self.q(face, point));
        let quadric = [q00, q10 - q00, q01 - q00, (q11 - q10) - (q01 - q00)];
        Cell { face, corner: [self.at(i), self.at(j)], quadric }
    }

    /// The cells of a block.
    fn cells_of(&self, block: &Block) -> impl Iterator<Item = Cell> {
        let Block { face, first: [i, j], .. } = *block;
        let rows = j..self.end(j);
        rows.flat_map(move |j| (i..self.end(i)).map(move |i| self.cell(face, [i, j])))
    }

    /// A ball that holds it.
    pub fn around(&self) -> Ball {
        Ball::of(self.center, self.largest)
    }

    /// What distances are measured by: the radius, and how exactly `f64` can name a point there.
    pub fn tolerance(&self) -> f64 {
        1e-9 * self.radius + 1e-12 * self.center.length()
    }

    /// The nearest meeting with `after < t <= t_max`. The ray's `from` is not looked at.
    pub fn closest(&self, ray: &Ray, after: f64) -> Option<SphereHit> {
        // From the point nearest to the centre, so that far origins cost no digits.
        let direction = ray.direction;
        let arm = ray.origin - self.center;
        let middle = -arm.dot(direction) / direction.length_squared();
        let near = arm + middle * direction;
        let range = [after - middle, ray.t_max - middle];
        let line = Line::of(&Ray::new(near, direction));
        let blocks = self.blocks.iter().filter(|block| !line.misses(&block.ball));
        let cells = blocks.flat_map(|block| self.cells_of(block));
        let hits = cells.filter_map(|cell| self.meet(&cell, near, direction, range));
        let (e, front) = hits.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let position = self.center + (near + e * direction);
        Some(SphereHit { t: middle + e, position, front })
    }

    /// Whether an answer to a ray is this judge's, to rounding.
    pub fn agrees(&self, answer: &Option<Hit>, ray: &Ray) -> bool {
        agree(answer, &self.closest(ray, -1e-300), self.tolerance())
    }

    /// Whether it is this judge's for some ray a nudge away.
    pub fn excuses(&self, answer: &Option<Hit>, ray: &Ray) -> bool {
        let towards = answer.map(|hit| hit.position - ray.origin);
        let normal = ray.origin - self.center;
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
