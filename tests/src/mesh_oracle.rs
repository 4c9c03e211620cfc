//! The judge of displaced meshes: every cell of every triangle, solved in the height.
//!
//! At an offset `o` the base is a level triangle with corners `P_k + o N_k`; seen along the ray these are
//! points `A_k(o)` of a plane, linear in `o`, and the ray meets the level triangle at weights
//! proportional to `A_1 x A_2`, `A_2 x A_0`, `A_0 x A_1`: quadratics in `o` with a common
//! denominator, their sum \[Ogaki2023\]. Put into the bilinear height of a cell that is a polynomial
//! of degree 5, whose roots are separated by sign variations of its Bernstein coefficients. It
//! shares lattice and samples of the map with the library and nothing else: another unknown, another
//! solver, other normals, no bounds, no frames.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use rilievo::Ray;
use rilievo::map::{HeightMap, Lattice, Wrap};
use rilievo::mesh::Mesh;
use rilievo::relief::Displacement;

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
    cells: Vec<[i32; 2]>,
    centre: DVec3,
    radius: f64,
}

/// An edge with what its sides show; nothing stands for offset 0.
struct BaseWall {
    ends: [DVec3; 2],
    normals: [DVec3; 2],
    sides: [Option<[DVec2; 2]>; 2],
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
            let points: Vec<_> = points.collect();
            let centre = points.iter().sum::<DVec3>() / 6.0;
            let radius = points.iter().map(|p| p.distance(centre)).fold(0.0, f64::max);
            let cells = cells_under(&lattice);
            oracle.triangles.push(BaseTriangle {
                corners,
                normals,
                lattice,
                cells,
                centre,
                radius,
            });
            for k in 0..3 {
                let (mut a, mut b) = (k, (k + 1) % 3);
                if key(corners[a]) > key(corners[b]) {
                    (a, b) = (b, a);
                }
                edges.entry([key(corners[a]), key(corners[b])]).or_default().push(BaseWall {
                    ends: [corners[a], corners[b]],
                    normals: [normals[a], normals[b]],
                    sides: [Some([lattice[a], lattice[b]]), None],
                });
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
                        let BaseWall { ends, normals, sides } = first;
                        oracle.walls.push(BaseWall { ends, normals, sides });
                    }
                }
            }
        }
        // Jumps between tiles need walls inside of triangles, which the oracle does not know.
        let tiled = map.x().lattice() == Lattice::Vertex && map.x().wrap() == Wrap::Repeat;
        assert!(!tiled, "a map that may jump between tiles");
        oracle
    }

    fn offset(&self, raw: f64) -> f64 {
        self.displacement.scale * (raw * self.map.unit() - self.displacement.zero)
    }

    fn raw(&self, offset: f64) -> f64 {
        (offset / self.displacement.scale + self.displacement.zero) / self.map.unit()
    }

    /// All parameters at which a line meets the mesh, in order; double roots may be missing.
    pub fn crossings(&self, ray: &Ray) -> Vec<f64> {
        let d = ray.direction;
        let across = d.normalize().any_orthonormal_pair();
        let axes = [across.0, across.1];
        let mut all = Vec::new();
        for triangle in &self.triangles {
            let off = (triangle.centre - ray.origin).reject_from(d).length();
            if off <= triangle.radius * (1.0 + 1e-9) {
                self.cross_triangle(triangle, ray, axes, &mut all);
            }
        }
        for wall in &self.walls {
            self.cross_wall(wall, ray, &mut all);
        }
        all.sort_by(f64::total_cmp);
        all
    }

    /// The first parameter at least 0.
    pub fn first(&self, ray: &Ray) -> Option<f64> {
        self.crossings(ray).into_iter().find(|&t| t >= 0.0)
    }

    fn cross_triangle(&self, base: &BaseTriangle, ray: &Ray, axes: [DVec3; 2], all: &mut Vec<f64>) {
        let seen = |v: DVec3| DVec2::new(v.dot(axes[0]), v.dot(axes[1]));
        let p = base.corners.map(|p| seen(p - ray.origin));
        let n = base.normals.map(seen);
        for &[i, j] in &base.cells {
            let h = self.map.unfolded_corners(i, j).map(f64::from);
            let (low, high) =
                h.iter().fold((f64::MAX, f64::MIN), |(a, b), &h| (a.min(h), b.max(h)));
            let (whole_low, whole_high) = self.map.raw_range();
            let pad = 1e-3 * (high - low) + 1e-6 * f64::from(whole_high - whole_low).max(1e-6);
            let (low, high) = (low - pad, high + pad);
            let ends = [self.offset(low), self.offset(high)];
            // Corner k at a share s of the way from the low to the high end.
            let start = [0, 1, 2].map(|k| p[k] + ends[0] * n[k]);
            let step = n.map(|n| (ends[1] - ends[0]) * n);
            let weight = |a: usize, b: usize| {
                vec![
                    start[a].perp_dot(start[b]),
                    start[a].perp_dot(step[b]) + step[a].perp_dot(start[b]),
                    step[a].perp_dot(step[b]),
                ]
            };
            let weights = [weight(1, 2), weight(2, 0), weight(0, 1)];
            let combine = |of: [f64; 3]| -> Vec<f64> {
                (0..3).map(|c| (0..3).map(|k| of[k] * weights[k][c]).sum()).collect()
            };
            let sum = combine([1.0; 3]);
            let x = combine(base.lattice.map(|l| l.x - f64::from(i)));
            let y = combine(base.lattice.map(|l| l.y - f64::from(j)));
            let [h00, h10, h01, h11] = h.map(|h| h - low);
            let twist = (h11 - h01) - (h10 - h00);
            let mut gap = vec![0.0; 6];
            add(&mut gap, &times(&times(&sum, &sum), &[-h00, high - low]), 1.0);
            add(&mut gap, &times(&x, &sum), -(h10 - h00));
            add(&mut gap, &times(&y, &sum), -(h01 - h00));
            add(&mut gap, &times(&x, &y), -twist);
            for s in roots(&gap) {
                let at = |p: &[f64]| p[0] + s * (p[1] + s * p[2]);
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

    fn cross_wall(&self, wall: &BaseWall, ray: &Ray, all: &mut Vec<f64>) {
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
                Some([a, b]) => {
                    let l = a.lerp(b, s);
                    self.map.raw_at_lattice(l.x, l.y)
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

/// Unfolded cells that a triangle in lattice coordinates touches.
fn cells_under(corners: &[DVec2; 3]) -> Vec<[i32; 2]> {
    let low = corners[0].min(corners[1]).min(corners[2]) - 1e-6;
    let high = corners[0].max(corners[1]).max(corners[2]) + 1e-6;
    let mut cells = Vec::new();
    for j in low.y.floor() as i32..=high.y.floor() as i32 {
        for i in low.x.floor() as i32..=high.x.floor() as i32 {
            let centre = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5);
            let apart = (0..3).any(|k| {
                let (a, b, c) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
                let normal = (b - a).perp();
                let side = normal.dot(c - a).signum();
                let reach = 0.5 * (normal.x.abs() + normal.y.abs()) * (1.0 + 1e-6);
                side * normal.dot(centre - a) < -reach - 1e-9 * normal.length()
            });
            if !apart {
                cells.push([i, j]);
            }
        }
    }
    cells
}

fn times(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; a.len() + b.len() - 1];
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            product[i + j] += a * b;
        }
    }
    product
}

fn add(to: &mut [f64], other: &[f64], factor: f64) {
    for (to, x) in to.iter_mut().zip(other) {
        *to += factor * x;
    }
}

/// Roots in [0, 1] of a polynomial by its coefficients, lowest first.
pub fn roots(coefficients: &[f64]) -> Vec<f64> {
    let n = coefficients.len() - 1;
    let choose = |n: usize, k: usize| (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64);
    let bernstein: Vec<f64> = (0..=n)
        .map(|i| (0..=i).map(|k| choose(i, k) / choose(n, k) * coefficients[k]).sum())
        .collect();
    let mut found = Vec::new();
    separate(bernstein, 0.0, 1.0, &mut found);
    found
}

/// Adds the roots between `from` and `to` of a polynomial by its Bernstein coefficients there.
fn separate(b: Vec<f64>, from: f64, to: f64, found: &mut Vec<f64>) {
    let signs: Vec<bool> = b.iter().filter(|&&b| b != 0.0).map(|&b| b > 0.0).collect();
    if b[0] == 0.0 {
        found.push(from);
    }
    if signs.windows(2).all(|pair| pair[0] == pair[1]) {
        return;
    }
    if to - from < 1e-15 {
        found.push(0.5 * (from + to));
        return;
    }
    let n = b.len();
    let (mut low, mut high) = (Vec::with_capacity(n), vec![0.0; n]);
    let mut row = b;
    for k in 0..n {
        low.push(row[0]);
        high[n - 1 - k] = row[n - 1 - k];
        for i in 0..n - 1 - k {
            row[i] = 0.5 * (row[i] + row[i + 1]);
        }
    }
    let middle = 0.5 * (from + to);
    separate(low, from, middle, found);
    separate(high, middle, to, found);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_known_polynomials() {
        // (s - 1/4)(s - 1/2)(s - 3/4), and with a double root at 1/3.
        let cubic = times(&times(&[-0.25, 1.0], &[-0.5, 1.0]), &[-0.75, 1.0]);
        let found = roots(&cubic);
        assert_eq!(found.len(), 3);
        assert!(found.iter().zip([0.25, 0.5, 0.75]).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(roots(&[1.0, 0.0, 1.0]).is_empty());
        assert_eq!(roots(&[0.0, 1.0]), [0.0]);
    }
}
