//! The judge of displaced meshes: every cell of every triangle, solved in the height.
//!
//! At an offset `o` the base is a level triangle with corners `P_k + o N_k`; seen along the ray these are
//! points `A_k(o)` of a plane, linear in `o`, and the ray meets the level triangle at weights
//! proportional to `A_1 x A_2`, `A_2 x A_0`, `A_0 x A_1`: quadratics in `o` with a common
//! denominator, their sum \[Ogaki2023\]. Put into the bilinear height of a cell that is a polynomial
//! of degree 5, whose roots are separated by sign variations of its Bernstein coefficients. It
//! shares lattice and samples of the map with the library and nothing else: another unknown, another
//! solver, other normals, no bounds of its own, no frames. Cells whose ball the line passes are
//! left out (`ball`).

mod cells;
mod polynomial;
mod verdict;
mod walls;

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use rilievo::Ray;
use rilievo::map::HeightMap;
use rilievo::mesh::Mesh;
use rilievo::relief::Displacement;

use crate::ball::{Ball, Line};
use cells::cells_under;
use polynomial::{add, bernstein, roots, times};
pub use verdict::Verdict;
use walls::{BaseWall, Shown};

/// Room for rounding where a closed border counts, in weights and cells.
const CLOSED: f64 = 1e-9;

/// A displaced mesh as the oracle sees it.
pub struct MeshOracle<'a> {
    map: &'a HeightMap,
    displacement: Displacement,
    triangles: Vec<BaseTriangle>,
    walls: Vec<BaseWall>,
}

struct BaseTriangle {
    corners: [DVec3; 3],
    normals: [DVec3; 3],
    lattice: [DVec2; 3],
    ball: Ball,
    cells: Vec<[i32; 2]>,
    /// One a cell.
    balls: Vec<Ball>,
}

/// What closes the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closing {
    /// The file's normals, no walls.
    Authored,
    /// One normal a place, walls along seams and borders.
    Walls,
}

impl<'a> MeshOracle<'a> {
    /// Lays a map on a mesh.
    ///
    /// # Panics
    /// If a triangle has no uv.
    pub fn new(
        mesh: &Mesh,
        map: &'a HeightMap,
        displacement: Displacement,
        closing: Closing,
    ) -> Self {
        let data = mesh.data();
        let lattice_of = |uv: DVec2| {
            let at =
                uv * DVec2::from_array(displacement.tile) + DVec2::from_array(displacement.shift);
            DVec2::new(map.x().coordinate(at.x), map.y().coordinate(at.y))
        };
        let key = |p: DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
        let mut shared: HashMap<[u64; 3], DVec3> = HashMap::new();
        for triangle in &data.triangles {
            let p = triangle.positions.map(|p| data.positions[p as usize]);
            let normal = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
            for k in 0..3 {
                let (e, f) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
                *shared.entry(key(p[k])).or_default() += e.angle_between(f) * normal;
            }
        }
        let (low, high) = map.raw_range();
        let mut oracle = Self { map, displacement, triangles: Vec::new(), walls: Vec::new() };
        let offsets = [low, high].map(|raw| oracle.offset(f64::from(raw)));
        let mut edges: HashMap<[[u64; 3]; 2], Vec<BaseWall>> = HashMap::new();
        for triangle in &data.triangles {
            let corners = triangle.positions.map(|p| data.positions[p as usize]);
            let normals = match (closing, triangle.normals) {
                (Closing::Authored, Some(n)) => n.map(|n| data.normals[n as usize].normalize()),
                _ => corners.map(|p| shared[&key(p)].normalize_or_zero()),
            };
            let lattice = triangle.uvs.expect("uv").map(|uv| lattice_of(data.uvs[uv as usize]));
            let points = (0..3).flat_map(|k| offsets.map(|o| corners[k] + o * normals[k]));
            let ball = Ball::around(&points.collect::<Vec<_>>());
            let cells = cells_under(&lattice);
            let mut base =
                BaseTriangle { corners, normals, lattice, ball, cells, balls: Vec::new() };
            base.balls = base.cells.iter().map(|&cell| oracle.ball(&base, cell)).collect();
            oracle.triangles.push(base);
            for k in 0..3 {
                let (mut a, mut b) = (k, (k + 1) % 3);
                let inside = lattice[(k + 2) % 3] - lattice[a].midpoint(lattice[b]);
                if key(corners[a]) > key(corners[b]) {
                    (a, b) = (b, a);
                }
                let shown = Shown { ends: [lattice[a], lattice[b]], inside };
                let (ends, normals) = ([corners[a], corners[b]], [normals[a], normals[b]]);
                let wall = oracle.wall(ends, normals, [Some(shown), None]);
                edges.entry([key(corners[a]), key(corners[b])]).or_default().push(wall);
            }
            if closing == Closing::Walls {
                oracle.add_jumps(&[corners, normals], &lattice);
            }
        }
        if closing == Closing::Walls {
            for mut uses in edges.into_values() {
                let mut first = uses.remove(0);
                if uses.is_empty() {
                    oracle.walls.push(first);
                } else {
                    for other in uses {
                        first.sides[1] = other.sides[0];
                        oracle.walls.push(first);
                    }
                }
            }
        }
        oracle
    }

    /// A ball that holds it, walls included.
    pub fn around(&self) -> Ball {
        let (low, high) = self.map.raw_range();
        let offsets = [self.offset(f64::from(low)), 0.0, self.offset(f64::from(high))];
        let corners = self.triangles.iter().flat_map(|t| t.corners.into_iter().zip(t.normals));
        let points: Vec<_> = corners.flat_map(|(p, n)| offsets.map(|o| p + o * n)).collect();
        Ball::around(&points)
    }

    fn offset(&self, raw: f64) -> f64 {
        self.displacement.scale * (raw * self.map.unit() - self.displacement.zero)
    }

    fn raw(&self, offset: f64) -> f64 {
        (offset / self.displacement.scale + self.displacement.zero) / self.map.unit()
    }

    /// A ball around what a triangle shows of a cell.
    fn ball(&self, base: &BaseTriangle, [i, j]: [i32; 2]) -> Ball {
        let [a, b, c] = base.lattice;
        // The part of the cell under the triangle's box, a little more.
        let cell = DVec2::new(f64::from(i), f64::from(j));
        let low = cell.max(a.min(b).min(c)) - 1e-4;
        let high = (cell + 1.0).min(a.max(b).max(c)) + 1e-4;
        let (e, f) = (b - a, c - a);
        let area = e.perp_dot(f);
        if area.abs() < 1e-9 * (e.length_squared() + f.length_squared()) {
            return base.ball;
        }
        let h = self.map.unfolded_corners(i, j).map(f64::from);
        let (least, most) =
            (h.iter()).fold((f64::MAX, f64::MIN), |(a, b), &h| (a.min(h), b.max(h)));
        let corners = [low, DVec2::new(high.x, low.y), DVec2::new(low.x, high.y), high];
        let points = corners.map(|at| {
            let (v, w) = ((at - a).perp_dot(f) / area, e.perp_dot(at - a) / area);
            [least, most].map(|raw| {
                let weights = [1.0 - v - w, v, w];
                let o = self.offset(raw);
                (0..3).map(|k| weights[k] * (base.corners[k] + o * base.normals[k])).sum()
            })
        });
        Ball::around(points.as_flattened())
    }

    /// All cells that the line of a ray may meet, with the numbers of their triangles: none is missing.
    pub fn cells_near(&self, ray: &Ray) -> Vec<(u32, [i32; 2])> {
        let line = Line::of(ray);
        let mut near = Vec::new();
        for (number, triangle) in (0..).zip(&self.triangles) {
            if line.misses(&triangle.ball) {
                continue;
            }
            let cells = triangle.cells.iter().zip(&triangle.balls);
            near.extend(
                cells.filter(|(_, ball)| !line.misses(ball)).map(|(&cell, _)| (number, cell)),
            );
        }
        near
    }

    /// All cells, with the numbers of their triangles.
    pub fn all_cells(&self) -> Vec<(u32, [i32; 2])> {
        let triangles = (0..).zip(&self.triangles);
        triangles.flat_map(|(number, t)| t.cells.iter().map(move |&cell| (number, cell))).collect()
    }

    /// All parameters at which a line meets the mesh, in order; double roots may be missing.
    pub fn crossings(&self, ray: &Ray) -> Vec<f64> {
        self.crossings_among(ray, &self.cells_near(ray))
    }

    /// The same, asking every cell and every wall.
    pub fn every_crossing(&self, ray: &Ray) -> Vec<f64> {
        self.crossings_of(ray, &self.all_cells(), &self.walls.iter().collect::<Vec<_>>())
    }

    /// The same, for some cells.
    pub fn crossings_among(&self, ray: &Ray, cells: &[(u32, [i32; 2])]) -> Vec<f64> {
        let line = Line::of(ray);
        let near: Vec<_> = self.walls.iter().filter(|wall| !line.misses(&wall.ball)).collect();
        self.crossings_of(ray, cells, &near)
    }

    fn crossings_of(&self, ray: &Ray, cells: &[(u32, [i32; 2])], walls: &[&BaseWall]) -> Vec<f64> {
        let line = Line::of(ray);
        let mut all = Vec::new();
        for listed in cells.chunk_by(|a, b| a.0 == b.0) {
            let base = &self.triangles[listed[0].0 as usize];
            self.cross_cells(base, listed, (ray, &line), &mut all);
        }
        for wall in walls {
            self.cross_wall(wall, ray, &mut all);
        }
        all.sort_by(f64::total_cmp);
        all
    }

    /// The first parameter at least 0.
    pub fn first(&self, ray: &Ray) -> Option<f64> {
        self.crossings(ray).into_iter().find(|&t| t >= 0.0)
    }

    fn cross_cells(
        &self,
        base: &BaseTriangle,
        cells: &[(u32, [i32; 2])],
        (ray, line): (&Ray, &Line),
        all: &mut Vec<f64>,
    ) {
        let p = base.corners.map(|p| line.across(p - ray.origin));
        let n = base.normals.map(|n| line.across(n));
        let (whole_low, whole_high) = self.map.raw_range();
        for &(_, [i, j]) in cells {
            let h = self.map.unfolded_corners(i, j).map(f64::from);
            let (low, high) =
                h.iter().fold((f64::MAX, f64::MIN), |(a, b), &h| (a.min(h), b.max(h)));
            let pad = 1e-3 * (high - low) + 1e-6 * f64::from(whole_high - whole_low).max(1e-6);
            let (low, high) = (low - pad, high + pad);
            let ends = [self.offset(low), self.offset(high)];
            // Corner k at a share s of the way from the low to the high end.
            let start = [0, 1, 2].map(|k| p[k] + ends[0] * n[k]);
            let step = n.map(|n| (ends[1] - ends[0]) * n);
            let weight = |a: usize, b: usize| {
                [
                    start[a].perp_dot(start[b]),
                    start[a].perp_dot(step[b]) + step[a].perp_dot(start[b]),
                    step[a].perp_dot(step[b]),
                ]
            };
            let weights = [weight(1, 2), weight(2, 0), weight(0, 1)];
            let combine = |of: [f64; 3]| -> [f64; 3] {
                [0, 1, 2].map(|c| (0..3).map(|k| of[k] * weights[k][c]).sum())
            };
            let sum = combine([1.0; 3]);
            let x = combine(base.lattice.map(|l| l.x - f64::from(i)));
            let y = combine(base.lattice.map(|l| l.y - f64::from(j)));
            let [h00, h10, h01, h11] = h.map(|h| h - low);
            let twist = (h11 - h01) - (h10 - h00);
            if is_outside(&weights, &[x, y], &sum) {
                continue;
            }
            let square: [f64; 5] = times(&sum, &sum);
            let mut gap: [f64; 6] = times(&square, &[-h00, high - low]);
            let mut take = |a: &[f64; 3], b: &[f64; 3], factor: f64| {
                add(&mut gap, &times::<3, 3, 5>(a, b), factor);
            };
            take(&x, &sum, -(h10 - h00));
            take(&y, &sum, -(h01 - h00));
            take(&x, &y, -twist);
            for s in roots(&gap) {
                let at = |p: &[f64; 3]| p[0] + s * (p[1] + s * p[2]);
                let d = at(&sum);
                let w = weights.each_ref().map(|w| at(w) / d);
                let local = [at(&x) / d, at(&y) / d];
                let inside = w.iter().all(|&w| w >= -CLOSED)
                    && local.iter().all(|&x| (-CLOSED..=1.0 + CLOSED).contains(&x));
                if inside {
                    let o = ends[0] + s * (ends[1] - ends[0]);
                    let at: DVec3 =
                        (0..3).map(|k| w[k] * (base.corners[k] + o * base.normals[k])).sum();
                    all.push((at - ray.origin).dot(ray.direction) / ray.direction.length_squared());
                }
            }
        }
    }
}

/// Whether at no height between the ends weights over their sum `d`, or cell coordinates over `d`, are all where
/// they count: one of them, or what it is short of 1, is below zero all along, by what is allowed for rounding.
fn is_outside(weights: &[[f64; 3]; 3], coordinates: &[[f64; 3]; 2], d: &[f64; 3]) -> bool {
    let d_ends = bernstein(d);
    let room = 2.0 * CLOSED * d_ends.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
    let sign = match d_ends {
        d if d.iter().all(|&d| d > 0.0) => 1.0,
        d if d.iter().all(|&d| d < 0.0) => -1.0,
        _ => return false,
    };
    let below = |p: &[f64; 3]| bernstein(p).iter().all(|p| sign * p < -room);
    weights.iter().any(below)
        || coordinates.iter().any(|x| below(x) || below(&[0, 1, 2].map(|k| d[k] - x[k])))
}
