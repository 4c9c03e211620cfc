//! [`Prism`]: what a base triangle spans between its lowest and highest height, and [`Sheet`]: the
//! displaced triangle as a function of lattice coordinates.

use glam::{DMat3, DVec3};

use super::footprint::{Area, Footprint, MARGIN};
use super::frame::{Frame, Path, Region};
use super::line::MeshRay;
use super::vertices::Vertex;

/// How the uv of a base triangle serve as coordinates of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// Its uv span an area.
    Spread,
    /// Its uv lie on a line or in a point: every cell under it goes to the leaf, which then counts
    /// in barycentric weights.
    Thread,
}

/// Steeper slopes count as this steep.
const MOST_STEEP: f32 = (1 << 20) as f32;

/// A base triangle made ready for rays. Heights are counted from the level of the map.
#[derive(Clone, Debug)]
pub(super) struct Prism {
    /// Vertices.
    pub corners: [u32; 3],
    /// Unfolded lattice coordinates of the corners.
    pub lattice: [[f64; 2]; 3],
    /// First cell and one past the last along each axis that the footprint touches.
    pub cells: [[i32; 2]; 2],
    /// Change of the second and third barycentric weight along x and y, per cell.
    pub weights: [[f64; 2]; 2],
    /// Lowest and highest height over the footprint, rounded outwards.
    pub heights: [f32; 2],
    /// How much a rounding of a lattice coordinate is magnified in a weight, at least 1; rounded up.
    condition: f32,
    /// Bound on the slope of the surface against its base, so that a lift clears it; rounded up.
    steepness: f32,
    pub shape: Shape,
    /// Whether uv run against the corners.
    mirrored: bool,
    /// Bound on the distance between a reported point and the ray, in scene units, beyond rounding:
    /// a margin of a cell.
    pub t_slack: f64,
    /// The frame about [`Prism::centre`], over all of the prism.
    pub frame: Frame,
}

impl Prism {
    /// `reach` bounds all coordinates of rays and mesh, relative to the mesh's centre.
    pub fn new(
        corners: [u32; 3],
        vertices: &[Vertex],
        lattice: [[f64; 2]; 3],
        [low, high]: [f64; 2],
        reach: f64,
    ) -> Self {
        let heights = [(low as f32).next_down(), (high as f32).next_up()];
        let range = heights.map(f64::from);
        let [a, b, c] = lattice;
        let (e, f) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let area = difference_of_products(e[0], f[1], e[1], f[0]);
        let weights = [[f[1] / area, -f[0] / area], [-e[1] / area, e[0] / area]];
        let [width, height] =
            [0, 1].map(|k| 1.0 + a[k].max(b[k]).max(c[k]) - a[k].min(b[k]).min(c[k]));
        let [g, h] = weights;
        let condition =
            1.0 + (g[0].abs() + h[0].abs()) * width + (g[1].abs() + h[1].abs()) * height;
        // Beyond this the weights have no digits left.
        let spread = condition < 1e12;
        let shape = if spread { Shape::Spread } else { Shape::Thread };
        let mut prism = Self {
            corners,
            lattice,
            cells: Area::of(lattice).cells(),
            weights: if spread { weights } else { [[0.0; 2]; 2] },
            heights,
            condition: if spread { (condition as f32).next_up() } else { 4.0 },
            steepness: MOST_STEEP,
            shape,
            mirrored: spread && area < 0.0,
            t_slack: 0.0,
            frame: Frame::BLIND,
        };
        let size = (range[1] - range[0]).abs() + range[0].abs().max(range[1].abs());
        let [p, q, r] = corners.map(|k| vertices[k as usize]);
        let rise = p.rise.length().max(q.rise.length()).max(r.rise.length());
        let edges = (q.base - p.base).length() + (r.base - p.base).length();
        prism.t_slack = 8.0 * MARGIN * (edges + size * rise);
        if spread {
            let sheet = prism.sheet(vertices);
            let centre = prism.centre();
            let half = 0.5 * (range[1] - range[0]);
            let corners = lattice.map(|p| [p[0] - centre.x, p[1] - centre.y]);
            let region = Region::Triangle(corners, half);
            let [along_x, along_y] = sheet.base_along.map(DVec3::length);
            let [bend_x, bend_y] = sheet.rise_along.map(DVec3::length);
            let (along_x, along_y) = (along_x + size * bend_x, along_y + size * bend_y);
            prism.t_slack = 8.0 * MARGIN * (along_x + along_y + 4.0 * size * rise);
            let cell =
                sheet.base_along[0].cross(sheet.base_along[1]).length() / (along_x + along_y);
            let steepness = (((range[1] - range[0]) * rise / cell) as f32).next_up();
            if steepness < MOST_STEEP {
                prism.steepness = steepness;
            }
            prism.frame = Frame::about(&sheet, centre, &region, prism.rounding(reach));
        }
        prism
    }

    /// Lowest and highest height over the footprint.
    #[inline(always)]
    pub fn range(&self) -> [f64; 2] {
        self.heights.map(f64::from)
    }

    /// How much a rounding of a lattice coordinate is magnified in a weight, at least 1.
    #[inline(always)]
    pub fn condition(&self) -> f64 {
        f64::from(self.condition)
    }

    /// Bound on the slope of the surface against its base.
    #[inline(always)]
    pub fn steepness(&self) -> f64 {
        f64::from(self.steepness)
    }

    /// 1 where uv run as the corners do, -1 where they are mirrored.
    #[inline(always)]
    pub fn winding(&self) -> f64 {
        if self.mirrored { -1.0 } else { 1.0 }
    }

    /// The middle: lattice coordinates and height.
    #[inline(always)]
    pub fn centre(&self) -> DVec3 {
        let ([a, b, c], [low, high]) = (self.lattice, self.range());
        let third = 1.0 / 3.0;
        let (x, y) = (a[0] + b[0] + c[0], a[1] + b[1] + c[1]);
        DVec3::new(third * x, third * y, 0.5 * (low + high))
    }

    /// A ray in the frame of the prism.
    #[inline(always)]
    pub fn path(&self, ray: &MeshRay) -> Path {
        self.frame.path(self.centre(), ray.origin, ray.direction)
    }

    /// Whether the displaced triangle is a curve or a point at any height.
    pub fn has_no_volume(&self) -> bool {
        let [a, b, c] = self.corners;
        a == b || b == c || c == a
    }

    /// Whether the shell turns over between the base and the lowest or highest height: the offset
    /// goes beyond a radius of curvature. The determinant of the shell is linear in the weights and
    /// quadratic in the height, so corners, ends and extremes decide.
    pub fn folds(&self, vertices: &[Vertex], base: f64) -> bool {
        let [a, b, c] = self.corners.map(|k| vertices[k as usize]);
        let (low, high) = (self.range()[0].min(base), self.range()[1].max(base));
        [a, b, c].iter().any(|corner| {
            let at = |h: f64| {
                let edge = |end: Vertex| (end.base - a.base) + h * (end.rise - a.rise);
                edge(b).cross(edge(c)).dot(corner.rise)
            };
            let sign = at(base).signum();
            let (p, q, r) = (at(low), at(0.5 * (low + high)), at(high));
            // The extreme of the quadratic through three points.
            let extreme = 0.25 * (3.0 * p - 4.0 * q + r) / (p - 2.0 * q + r);
            let middle =
                if (0.0..=1.0).contains(&extreme) { at(low + extreme * (high - low)) } else { q };
            [p, q, r, middle].iter().any(|d| d * sign < 0.0)
        })
    }

    /// The longer side of the box of its footprint, in whole cells.
    #[inline(always)]
    pub fn extent(&self) -> f64 {
        let [width, height] = self.cells.map(|[first, end]| end - first);
        f64::from(width.max(height))
    }

    /// Bound on the distance between computed and exact points of sheet and ray, scene units.
    pub fn rounding(&self, reach: f64) -> f64 {
        64.0 * f64::EPSILON * self.condition() * reach
    }

    /// The box of its footprint.
    #[inline(always)]
    pub fn area(&self) -> Area {
        Area::of(self.lattice)
    }

    pub fn footprint(&self) -> Footprint {
        Footprint::new(self.lattice)
    }

    /// The sheet over lattice coordinates; for [`Shape::Thread`] without meaning.
    #[inline(always)]
    pub fn sheet(&self, vertices: &[Vertex]) -> Sheet {
        let corner = |k: usize| &vertices[self.corners[k] as usize];
        let (a, b, c) = (corner(0), corner(1), corner(2));
        let [g, h] = self.weights;
        let (e, f) = (b.base - a.base, c.base - a.base);
        let (n, o) = (b.rise - a.rise, c.rise - a.rise);
        Sheet {
            corner: self.lattice[0],
            base: a.base,
            base_along: [g[0] * e + h[0] * f, g[1] * e + h[1] * f],
            rise: a.rise,
            rise_along: [g[0] * n + h[0] * o, g[1] * n + h[1] * o],
        }
    }

    /// Weights of the second and third corner at lattice coordinates.
    pub fn weights_at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (x - self.lattice[0][0], y - self.lattice[0][1]);
        self.weights.map(|g| g[0] * dx + g[1] * dy)
    }
}

/// `base(x, y) + height rise(x, y)`, both linear in lattice coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheet {
    /// Lattice coordinates of the first corner.
    pub corner: [f64; 2],
    pub base: DVec3,
    /// Per cell along x and y.
    pub base_along: [DVec3; 2],
    pub rise: DVec3,
    pub rise_along: [DVec3; 2],
}

impl Sheet {
    /// The point over (x, y) at a height, z of `at`.
    pub fn point(&self, at: DVec3) -> DVec3 {
        let (dx, dy) = (at.x - self.corner[0], at.y - self.corner[1]);
        let base = self.base + dx * self.base_along[0] + dy * self.base_along[1];
        base + at.z * self.rise_at(dx, dy)
    }

    #[inline(always)]
    fn rise_at(&self, dx: f64, dy: f64) -> DVec3 {
        self.rise + dx * self.rise_along[0] + dy * self.rise_along[1]
    }

    /// Derivatives of [`Sheet::point`].
    #[inline(always)]
    pub fn jacobian(&self, at: DVec3) -> DMat3 {
        let (dx, dy) = (at.x - self.corner[0], at.y - self.corner[1]);
        DMat3::from_cols(
            self.base_along[0] + at.z * self.rise_along[0],
            self.base_along[1] + at.z * self.rise_along[1],
            self.rise_at(dx, dy),
        )
    }
}

/// `a b - c d` to a rounding or two \[Kahan2004\].
fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let cd = c * d;
    let error = c.mul_add(-d, cd);
    a.mul_add(b, -cd) + error
}
