//! The patches that the leaf solves: one cell of the map under one base triangle, as a ray sees it.
//!
//! In the sheared frame of a ray (see `line`) the ray is the third axis, and a patch meets it where
//! the first two coordinates of `f = P + h N` are zero; the third is the depth. `P`, `N` are linear
//! in the parameters of the patch, the height `h` is bilinear in cell coordinates.
//!
//! A [`CellPatch`] has cell coordinates for parameters. A [`ThreadPatch`] has the barycentric weights
//! of the second and third corner: it serves triangles whose uv span no area.

use glam::{DVec2, DVec3};

use crate::simd::Quad;

use super::footprint::Area;
use super::line::MeshRay;
use super::prism::Prism;
use super::vertices::Vertex;

/// A patch and its derivatives in the middle of a box of parameters: vectors and a fourth number
/// without meaning.
#[derive(Clone, Copy)]
pub(super) struct Local<Q> {
    pub value: Q,
    pub along: [Q; 2],
    /// Bound on the distance between patch and tangent plane over the box, by Taylor's theorem.
    pub bend: Q,
}

/// A piece of surface with two parameters.
pub(super) trait Patch {
    type Quad: Quad;
    /// Middle and half sizes of the box in which all of the patch lies.
    fn whole(&self) -> [DVec2; 2];
    fn local(&self, middle: DVec2, half: DVec2) -> Local<Self::Quad>;
    /// Whether a point known to within `error` may belong to the closed patch.
    fn holds(&self, at: DVec2, error: DVec2) -> bool;
    /// Bound on the rounding of a value.
    fn rounding(&self) -> f64;
}

/// Corner heights `h00, h10, h01, h11` of a cell as `a + b x + c y + d x y`.
#[derive(Clone, Copy)]
pub(super) struct Heights {
    pub a: f64,
    pub b: f64,
    pub c: f64,
    pub d: f64,
}

impl Heights {
    /// Counted from `level`; differences of two `f32` of one map are exact, or as good as.
    #[inline(always)]
    pub fn new(corners: [f32; 4], level: f32) -> Self {
        let over = |k: usize| f64::from(corners[k]) - f64::from(level);
        let (h00, h10, h01, h11) = (over(0), over(1), over(2), over(3));
        Self { a: h00, b: h10 - h00, c: h01 - h00, d: (h11 - h01) - (h10 - h00) }
    }

    #[inline(always)]
    pub fn at(&self, x: f64, y: f64) -> f64 {
        self.a + self.b * x + (self.c + self.d * x) * y
    }
}

/// The vertices of a prism as a ray sees them.
#[derive(Clone, Copy)]
pub(super) struct Seen<Q> {
    base: Q,
    rise: Q,
    /// To the second and third corner.
    base_edges: [Q; 2],
    rise_edges: [Q; 2],
    /// The box of the footprint.
    area: Area,
    /// Bound on what `f` is off by, heights up to `half_range` from the level.
    rounding: f64,
}

impl<Q: Quad> Seen<Q> {
    #[inline(always)]
    pub fn new(ray: &MeshRay, prism: &Prism, vertices: &[Vertex], half_range: f64) -> Self {
        let corner = |k: usize| vertices[prism.corners[k] as usize];
        let (first, second, third) = (corner(0), corner(1), corner(2));
        let base = |v: Vertex| ray.sheared(v.base - ray.origin);
        let (a, b, c) = (base(first), base(second), base(third));
        let rise = |v: Vertex| ray.sheared(v.rise);
        let (n, o, p) = (rise(first), rise(second), rise(third));
        let largest =
            |a: DVec3, b: DVec3, c: DVec3| a.abs().max(b.abs()).max(c.abs()).max_element();
        let size = largest(a, b, c) + half_range * largest(n, o, p);
        Self {
            base: quad(a),
            rise: quad(n),
            base_edges: [quad(b - a), quad(c - a)],
            rise_edges: [quad(o - n), quad(p - n)],
            area: prism.area(),
            rounding: 32.0 * f64::EPSILON * prism.condition() * size,
        }
    }
}

/// A vector, and 0.
#[inline(always)]
fn quad<Q: Quad>(v: DVec3) -> Q {
    Q::of([v.x, v.y, v.z, 0.0])
}

/// A cell over a triangle whose uv span an area; parameters are cell coordinates.
pub(super) struct CellPatch<'a, Q> {
    prism: &'a Prism,
    heights: Heights,
    /// Lattice coordinates of the cell's corner, from the triangle's first corner.
    corner: DVec2,
    /// The part of the cell in the box of the triangle.
    low: DVec2,
    high: DVec2,
    base: Q,
    rise: Q,
    base_along: [Q; 2],
    rise_along: [Q; 2],
    rounding: f64,
}

/// Boxes are this much larger than what they hold, in cells: rounding of their own arithmetic.
const SPARE: f64 = 1.0 / (1u64 << 40) as f64;

impl<'a, Q: Quad> CellPatch<'a, Q> {
    #[inline(always)]
    pub fn new(seen: &Seen<Q>, prism: &'a Prism, cell: [i32; 2], heights: Heights) -> Self {
        let [g, h] = prism.weights;
        let corner = DVec2::new(
            f64::from(cell[0]) - prism.lattice[0][0],
            f64::from(cell[1]) - prism.lattice[0][1],
        );
        let [mut low, mut high] = [DVec2::ZERO, DVec2::ONE];
        for k in 0..2 {
            let first = f64::from(cell[k]);
            low[k] = (seen.area.low[k] - first).clamp(0.0, 1.0);
            high[k] = (seen.area.high[k] - first).clamp(0.0, 1.0);
        }
        Self {
            prism,
            heights,
            corner,
            low: low - SPARE,
            high: high + SPARE,
            base: seen.base,
            rise: seen.rise,
            base_along: along([g, h], seen.base_edges),
            rise_along: along([g, h], seen.rise_edges),
            rounding: seen.rounding,
        }
    }
}

/// What grows by two vectors along the second and third weight, along x and y.
#[inline(always)]
fn along<Q: Quad>([g, h]: [[f64; 2]; 2], [e, f]: [Q; 2]) -> [Q; 2] {
    [e.scaled(g[0]).plus(f.scaled(h[0])), e.scaled(g[1]).plus(f.scaled(h[1]))]
}

impl<Q: Quad> Patch for CellPatch<'_, Q> {
    type Quad = Q;

    #[inline(always)]
    fn whole(&self) -> [DVec2; 2] {
        [0.5 * (self.low + self.high), 0.5 * (self.high - self.low)]
    }

    #[inline(always)]
    fn local(&self, middle: DVec2, half: DVec2) -> Local<Q> {
        let (x, y) = (middle.x, middle.y);
        let (u, v) = (self.corner.x + x, self.corner.y + y);
        let Heights { b, c, d, .. } = self.heights;
        let height = self.heights.at(x, y);
        let (slope_x, slope_y) = (b + d * y, c + d * x);
        let [px, py] = self.base_along;
        let [nx, ny] = self.rise_along;
        let rise = self.rise.plus(nx.scaled(u)).plus(ny.scaled(v));
        let value = self.base.plus(px.scaled(u)).plus(py.scaled(v)).plus(rise.scaled(height));
        let along = [
            px.plus(nx.scaled(height)).plus(rise.scaled(slope_x)),
            py.plus(ny.scaled(height)).plus(rise.scaled(slope_y)),
        ];
        // Second derivatives: 2 h_x N_x, h_xy N + h_x N_y + h_y N_x, 2 h_y N_y.
        let steep_x = slope_x.abs() + d.abs() * half.y;
        let steep_y = slope_y.abs() + d.abs() * half.x;
        let (nx, ny) = (nx.size(), ny.size());
        let rise = rise.size().plus(nx.scaled(half.x)).plus(ny.scaled(half.y));
        let mixed = rise.scaled(d.abs()).plus(ny.scaled(steep_x)).plus(nx.scaled(steep_y));
        let bend = nx
            .scaled(steep_x * half.x * half.x)
            .plus(mixed.scaled(half.x * half.y))
            .plus(ny.scaled(steep_y * half.y * half.y));
        Local { value, along, bend }
    }

    #[inline(always)]
    fn holds(&self, at: DVec2, error: DVec2) -> bool {
        let outside = (at - at.clamp(DVec2::ZERO, DVec2::ONE)).abs();
        if outside.x > error.x || outside.y > error.y {
            return false;
        }
        let (u, v) = (self.corner.x + at.x, self.corner.y + at.y);
        let [g, h] = self.prism.weights;
        let weights = [g[0] * u + g[1] * v, h[0] * u + h[1] * v];
        let first = 1.0 - weights[0] - weights[1];
        let slack = 16.0 * f64::EPSILON * self.prism.condition();
        let off = |gx: f64, gy: f64| gx.abs() * error.x + gy.abs() * error.y + slack;
        weights[0] >= -off(g[0], g[1])
            && weights[1] >= -off(h[0], h[1])
            && first >= -off(g[0] + h[0], g[1] + h[1])
    }

    #[inline(always)]
    fn rounding(&self) -> f64 {
        self.rounding
    }
}

/// A cell over a triangle whose uv span no area; parameters are weights.
pub(super) struct ThreadPatch<'a, Q> {
    seen: &'a Seen<Q>,
    heights: Heights,
    /// Cell coordinates of the first corner, and to the second and third.
    corner: DVec2,
    edges: [DVec2; 2],
}

impl<'a, Q: Quad> ThreadPatch<'a, Q> {
    pub fn new(seen: &'a Seen<Q>, prism: &Prism, cell: [i32; 2], heights: Heights) -> Self {
        let [a, b, c] = prism.lattice.map(DVec2::from_array);
        let cell = DVec2::new(f64::from(cell[0]), f64::from(cell[1]));
        Self { seen, heights, corner: a - cell, edges: [b - a, c - a] }
    }
}

impl<Q: Quad> Patch for ThreadPatch<'_, Q> {
    type Quad = Q;

    fn whole(&self) -> [DVec2; 2] {
        [DVec2::splat(0.5), DVec2::splat(0.5 + SPARE)]
    }

    fn local(&self, middle: DVec2, half: DVec2) -> Local<Q> {
        let (u, v) = (middle.x, middle.y);
        let [e, f] = self.edges;
        let at = self.corner + u * e + v * f;
        let Heights { b, c, d, .. } = self.heights;
        let height = self.heights.at(at.x, at.y);
        let slope = DVec2::new(b + d * at.y, c + d * at.x);
        let (slope_u, slope_v) = (slope.dot(e), slope.dot(f));
        let (h_uu, h_uv, h_vv) =
            (2.0 * d * e.x * e.y, d * (e.x * f.y + e.y * f.x), 2.0 * d * f.x * f.y);
        let [pu, pv] = self.seen.base_edges;
        let [nu, nv] = self.seen.rise_edges;
        let rise = self.seen.rise.plus(nu.scaled(u)).plus(nv.scaled(v));
        let base = self.seen.base.plus(pu.scaled(u)).plus(pv.scaled(v));
        let value = base.plus(rise.scaled(height));
        let along = [
            pu.plus(nu.scaled(height)).plus(rise.scaled(slope_u)),
            pv.plus(nv.scaled(height)).plus(rise.scaled(slope_v)),
        ];
        let steep_u = slope_u.abs() + h_uu.abs() * half.x + h_uv.abs() * half.y;
        let steep_v = slope_v.abs() + h_uv.abs() * half.x + h_vv.abs() * half.y;
        let (nu, nv) = (nu.size(), nv.size());
        let rise = rise.size().plus(nu.scaled(half.x)).plus(nv.scaled(half.y));
        let along_u = nu.scaled(steep_u).plus(rise.scaled(0.5 * h_uu.abs()));
        let mixed = rise.scaled(h_uv.abs()).plus(nv.scaled(steep_u)).plus(nu.scaled(steep_v));
        let along_v = nv.scaled(steep_v).plus(rise.scaled(0.5 * h_vv.abs()));
        let bend = along_u
            .scaled(half.x * half.x)
            .plus(mixed.scaled(half.x * half.y))
            .plus(along_v.scaled(half.y * half.y));
        Local { value, along, bend }
    }

    fn holds(&self, at: DVec2, error: DVec2) -> bool {
        let slack = 64.0 * f64::EPSILON;
        let total = 1.0 - at.x - at.y;
        if at.x < -error.x - slack || at.y < -error.y - slack || total < -error.x - error.y - slack
        {
            return false;
        }
        let [e, f] = self.edges;
        let cell = self.corner + at.x * e + at.y * f;
        let off = e.abs() * error.x + f.abs() * error.y;
        // Cells overlap a little: a thread may run along the line between two.
        let off = off + super::footprint::MARGIN;
        let outside = (cell - cell.clamp(DVec2::ZERO, DVec2::ONE)).abs();
        outside.x <= off.x && outside.y <= off.y
    }

    fn rounding(&self) -> f64 {
        self.seen.rounding
    }
}
