//! The judge: a relief face traced in `f64` over every cell, with no hierarchy.
//!
//! The surface is the one the definitions name, and nothing here is shared with the kernels that
//! are judged: the face is `S(u, v) = c0 + u e1 + v e2 + w(u, v) N` with `u, v` in `[0, 1]` and
//! `w = scale * (H(u tile + shift) - zero)`; `H` is bilinear between samples. A ray is taken to
//! *lattice coordinates* `(x, y, w)`: x and y count cells, w is the offset in scene units. That
//! map is affine, so `t` is the same on both sides, and in it a cell is the graph of
//! `a + b x + c y + d x y`: the ray meets it where a quadratic in `t` vanishes (`cell`).
//!
//! The corner `c0` is subtracted before anything else, so a face far from the origin keeps the
//! digits its corners and the ray have.
//!
//! [`Oracle::closest`] takes, row by row, every column whose closed cell the ray can touch;
//! [`Oracle::closest_of_all_cells`] takes every cell there is and tests the former.

mod cell;
mod search;
mod wall;

use glam::{DVec2, DVec3};
use rilievo::map::{Axis, HeightMap};
use rilievo::{Part, Ray};

use cell::Patch;
use search::{Cells, Search};

/// Where a relief stands and how it is displaced; the words are those of a scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Corners c0, c1, c2, c3; u runs c0 to c1, v runs c0 to c3.
    pub corners: [DVec3; 4],
    /// Scene units per unit of height; may be negative or zero.
    pub scale: f64,
    /// The height that is not displaced.
    pub zero: f64,
    /// Repetitions of the map along u and v.
    pub tile: [f64; 2],
    /// Parameter of the map at u = 0 and v = 0.
    pub shift: [f64; 2],
    /// Whether walls join the border to the plane of the face.
    pub closed: bool,
    /// Whether rays from behind pass through.
    pub one_sided: bool,
}

impl Placement {
    /// A parallelogram with the map once on it, open and two-sided.
    pub fn new(c0: DVec3, e1: DVec3, e2: DVec3, scale: f64) -> Self {
        Self {
            corners: [c0, c0 + e1, c0 + e1 + e2, c0 + e2],
            scale,
            zero: 0.0,
            tile: [1.0; 2],
            shift: [0.0; 2],
            closed: false,
            one_sided: false,
        }
    }
}

/// The answer of the oracle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OracleHit {
    /// Ray parameter.
    pub t: f64,
    /// The point, in world space.
    pub position: DVec3,
    /// Parameters of the face.
    pub uv: DVec2,
    /// Offset along the face normal, scene units.
    pub offset: f64,
    /// Whether the ray came from the front: above a cell, or the airy side of a wall.
    pub front: bool,
    /// The cell or wall.
    pub part: Part,
}

/// A place on the surface from which a ray starts, in lattice coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    part: Part,
    /// x and y of the start; w is that of the surface there.
    at: DVec2,
    offset: f64,
}

/// A ray in lattice coordinates.
#[derive(Clone, Copy, Debug)]
struct Local {
    o: DVec3,
    d: DVec3,
    t_max: f64,
    /// Cells are widened by this much on every side, in cells, so that a root on a shared border
    /// is not lost between two of them: a few roundings of the coordinates along the ray.
    margin: f64,
}

impl Local {
    fn new(o: DVec3, d: DVec3, t_max: f64, farthest: DVec2) -> Self {
        let reach = o.truncate().abs().max(farthest).max_element();
        Self { o, d, t_max, margin: 16.0 * f64::EPSILON * (1.0 + reach) }
    }

    fn at(&self, t: f64) -> DVec3 {
        self.o + t * self.d
    }

    /// The part of `[ta, tb]` on which coordinate `axis` lies in `[low, high]`.
    fn clip(&self, axis: usize, low: f64, high: f64, [ta, tb]: [f64; 2]) -> Option<[f64; 2]> {
        let (o, d) = (self.o[axis], self.d[axis]);
        if d == 0.0 {
            return (low <= o && o <= high).then_some([ta, tb]);
        }
        let (t0, t1) = ((low - o) / d, (high - o) / d);
        let (a, b) = (ta.max(t0.min(t1)), tb.min(t0.max(t1)));
        (a <= b).then_some([a, b])
    }
}

/// A face to be judged by.
pub struct Oracle<'a> {
    map: &'a HeightMap,
    place: Placement,
    e1: DVec3,
    e2: DVec3,
    normal: DVec3,
    /// Lattice coordinate per unit of u and v, and at u = v = 0.
    per_uv: DVec2,
    at_zero: DVec2,
    /// The window u, v in `[0, 1]` in lattice coordinates.
    low: DVec2,
    high: DVec2,
}

impl<'a> Oracle<'a> {
    /// The face `place` with the relief of `map`.
    pub fn new(map: &'a HeightMap, place: Placement) -> Self {
        let [c0, c1, _, c3] = place.corners;
        let (e1, e2) = (c1 - c0, c3 - c0);
        let coordinate = |s: usize, axis: &Axis| {
            let (from, to) = (place.shift[s], place.tile[s] + place.shift[s]);
            (axis.coordinate(from), axis.coordinate(to))
        };
        let (x0, x1) = coordinate(0, map.x());
        let (y0, y1) = coordinate(1, map.y());
        let periods = DVec2::new(f64::from(map.x().period()), f64::from(map.y().period()));
        let (from, to) = (DVec2::new(x0, y0), DVec2::new(x1, y1));
        Self {
            map,
            e1,
            e2,
            normal: e1.cross(e2).normalize(),
            per_uv: periods * DVec2::from_array(place.tile),
            at_zero: from,
            low: from.min(to),
            high: from.max(to),
            place,
        }
    }

    /// The placement.
    pub fn placement(&self) -> &Placement {
        &self.place
    }

    /// The height map.
    pub fn map(&self) -> &HeightMap {
        self.map
    }

    /// The longer edge of the face: what "1e-5 of the face's size" is measured by.
    pub fn size(&self) -> f64 {
        self.e1.length().max(self.e2.length())
    }

    /// The front normal of the face.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Lowest and highest offset any sample can give.
    pub fn offsets(&self) -> (f64, f64) {
        let (low, high) = self.map.raw_range();
        let (a, b) = (self.offset_of(f64::from(low)), self.offset_of(f64::from(high)));
        (a.min(b), a.max(b))
    }

    /// The world point at face parameters (u, v) and offset w.
    pub fn point(&self, u: f64, v: f64, w: f64) -> DVec3 {
        self.place.corners[0] + (u * self.e1 + v * self.e2 + w * self.normal)
    }

    /// Face parameters and offset of a world point.
    pub fn parameters(&self, point: DVec3) -> DVec3 {
        self.face_from_world(point - self.place.corners[0])
    }

    /// Face parameters of a point of the lattice.
    pub fn uv_of_lattice(&self, at: DVec2) -> DVec2 {
        (at - self.at_zero) / self.per_uv
    }

    /// The lattice coordinates the face covers, smallest and largest corner.
    pub fn window(&self) -> (DVec2, DVec2) {
        (self.low, self.high)
    }

    /// Offset of the surface at face parameters (u, v).
    pub fn surface_offset(&self, u: f64, v: f64) -> f64 {
        let at = self.at_zero + self.per_uv * DVec2::new(u, v);
        self.offset_of(self.map.raw_at_lattice(at.x, at.y))
    }

    /// Offset and its derivatives along u and v, of cell (i, j) at (u, v); the cell's formula is
    /// used even where the point lies outside it.
    pub fn cell_offset(&self, i: i32, j: i32, u: f64, v: f64) -> (f64, DVec2) {
        let at = self.at_zero + self.per_uv * DVec2::new(u, v);
        let patch = self.patch(i, j);
        let local = at - DVec2::new(f64::from(i), f64::from(j));
        (patch.value(local), patch.gradient(local) * self.per_uv)
    }

    /// The nearest meeting with `0 <= t <= t_max`. The ray's `from` is not looked at.
    pub fn closest(&self, ray: &Ray) -> Option<OracleHit> {
        Search::new(self, &self.local(ray), None).nearest(Cells::Touched)
    }

    /// The same by testing every cell of the face; slow.
    pub fn closest_of_all_cells(&self, ray: &Ray) -> Option<OracleHit> {
        Search::new(self, &self.local(ray), None).nearest(Cells::All)
    }

    /// The start of a ray on `part`, below or above the world point `near`.
    pub fn start(&self, part: Part, near: DVec3) -> Start {
        let face = self.parameters(near);
        let at = self.at_zero + self.per_uv * DVec2::new(face.x, face.y);
        match part {
            Part::Cell(i, j) => {
                let offset = self.cell_offset(i, j, face.x, face.y).0;
                Start { part, at, offset }
            }
            Part::Wall(wall) => {
                let stand = self.stand_of(wall);
                let mut at = at;
                at[stand.axis] = stand.coordinate;
                Start { part, at, offset: face.z }
            }
            Part::Whole
            | Part::Triangle(_)
            | Part::CubeCell(..)
            | Part::TriangleCell { .. }
            | Part::SeamWall(_) => Start { part, at, offset: face.z },
        }
    }

    /// The world point of a start, rounded to `f64`.
    pub fn start_point(&self, start: &Start) -> DVec3 {
        let uv = self.uv_of_lattice(start.at);
        self.point(uv.x, uv.y, start.offset)
    }

    /// The nearest meeting of a ray that starts exactly on the surface: in its own cell the root
    /// at `t = 0` is divided out of the quadratic, and its own wall is passed over.
    pub fn closest_from(&self, start: &Start, direction: DVec3) -> Option<OracleHit> {
        let d = self.lattice_from_face(self.face_from_world(direction));
        let local = Local::new(start.at.extend(start.offset), d, f64::INFINITY, self.farthest());
        Search::new(self, &local, Some(start)).nearest(Cells::Touched)
    }

    fn offset_of(&self, raw: f64) -> f64 {
        self.place.scale * (raw * self.map.unit() - self.place.zero)
    }

    fn patch(&self, i: i32, j: i32) -> Patch {
        Patch::new(self.map.unfolded_corners(i, j).map(|h| self.offset_of(f64::from(h))))
    }

    fn face_from_world(&self, p: DVec3) -> DVec3 {
        let area = self.e1.cross(self.e2).dot(self.normal);
        DVec3::new(
            p.dot(self.e2.cross(self.normal)) / area,
            p.dot(self.normal.cross(self.e1)) / area,
            p.dot(self.normal),
        )
    }

    fn lattice_from_face(&self, d: DVec3) -> DVec3 {
        DVec3::new(d.x * self.per_uv.x, d.y * self.per_uv.y, d.z)
    }

    fn local(&self, ray: &Ray) -> Local {
        let o = self.parameters(ray.origin);
        let at = self.at_zero + self.per_uv * DVec2::new(o.x, o.y);
        let d = self.lattice_from_face(self.face_from_world(ray.direction));
        Local::new(at.extend(o.z), d, ray.t_max, self.farthest())
    }

    fn farthest(&self) -> DVec2 {
        self.low.abs().max(self.high.abs())
    }
}

#[cfg(test)]
mod tests;
