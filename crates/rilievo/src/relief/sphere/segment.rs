//! [`Segment`]: a ray over one face of the cube, straight in `(x, y, q)`.
//!
//! **From face to face.** A ray leaves the face that looks along `u` for the one that looks along `v`
//! where `P . u = P . v`, if `D . v > D . u`. So the faces it passes have growing `D . u`, compared
//! exactly: each comes once, there are at most six, whatever is rounded.
//!
//! **Watertight (proof).** A point between two segments is made once: its common coordinate along the
//! edge comes from the mean of `P . u` and `P . v`, the other coordinate of each face is *set* to the
//! edge, and the gap there is a function of the point as the first of the two faces sees it, the
//! same for both. Within a segment cells share the parameters of
//! their common lines, and the local coordinate on the line that gave the parameter is set; as
//! `lerp` is exact at both ends, both cells compute the same gap on a line. A cell is active only if
//! `s0 < s1`, and active cells tile `[0, 1]`: lines are monotone in their index, and `inverse` is
//! rounded away from 0, so that the border of a face lies at 1 or beyond. A gap that changes sign
//! from one end of a ray to the other therefore does so within some active cell, and the leaf finds
//! it. Inside the inner ball the gap is negative, outside the outer ball it is positive: a ray from
//! the one to the other always hits.

use glam::DVec3;

use super::clip::{Beginning, Part};
use super::leaf::{Gap, bilinear};
use super::radii::Radii;
use crate::map::{CubeFace, Samples};
use crate::relief::sphere::CubeRelief;

/// A slope that is not 0, and leads nowhere.
const STILL: f64 = 1e-300;

/// A point over a face: cells' coordinates and `q = n / Z`.
#[derive(Clone, Copy, Debug)]
struct Over {
    face: CubeFace,
    at: [f64; 2],
    q: f64,
}

/// A part of a ray over one face; `s` runs from 0 to 1 along it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment<'a> {
    pub face: CubeFace,
    relief: &'a CubeRelief,
    radii: &'a Radii,
    /// Cells' coordinates at s = 0, slope and reciprocal slope, neither 0.
    pub origin: [f64; 2],
    pub slope: [f64; 2],
    pub inverse: [f64; 2],
    /// q at s = 0 and its slope.
    q: [f64; 2],
    /// The points at both ends, each as one face sees it: the same for both its segments.
    ends: [Over; 2],
    /// Parameters of the ray at both ends, from the start of its part.
    t: [f64; 2],
}

/// The segments of a part of a ray, in order.
pub(super) struct Segments<'a> {
    relief: &'a CubeRelief,
    radii: &'a Radii,
    part: Part,
    /// Where the next segment begins: as its face sees it, and as the one before does.
    over: Over,
    seen: Over,
    t: f64,
    left: u32,
}

impl<'a> Segments<'a> {
    #[inline(always)]
    pub fn new(relief: &'a CubeRelief, radii: &'a Radii, part: Part) -> Self {
        let over = over(radii, CubeFace::towards(part.start), part.start);
        Self { relief, radii, part, over, seen: over, t: 0.0, left: 6 }
    }

    /// Whether the part begins outside of the surface.
    #[inline(always)]
    pub fn starts_outside(&self) -> bool {
        match self.part.from {
            Beginning::Roof => true,
            Beginning::Floor => false,
            Beginning::Origin => gap_at(self.relief, self.radii, &self.over) > 0.0,
        }
    }

    #[inline(always)]
    pub fn next(&mut self) -> Option<Segment<'a>> {
        if self.left == 0 {
            return None;
        }
        self.left -= 1;
        let Self { relief, radii, part, .. } = *self;
        let face = self.over.face;
        let (t, here, there) = match self.exit() {
            Some((t, next)) => {
                let (here, there) = edge(radii, (face, next), part.start + t * part.direction);
                (t, here, Some(there))
            }
            None => {
                let end = part.start + part.length * part.direction;
                (part.length, over(radii, face, end), None)
            }
        };
        let segment = Segment::new((relief, radii), [self.over, here])
            .between([self.seen, here], [self.t, t]);
        match there {
            Some(over) => self.over = over,
            None => self.left = 0,
        }
        (self.seen, self.t) = (here, t);
        Some(segment)
    }

    /// Where the ray leaves its face before it ends, and for which.
    #[inline(always)]
    fn exit(&self) -> Option<(f64, CubeFace)> {
        let Part { start, direction, length, .. } = self.part;
        let face = self.over.face;
        let (axis, sign) = (face.axis(), face.sign());
        let (along, speed) = (sign * start[axis], sign * direction[axis]);
        let (mut first, mut next) = (length, None);
        for across in face.across() {
            for positive in [true, false] {
                let sign = if positive { 1.0 } else { -1.0 };
                let gain = sign * direction[across] - speed;
                if gain > 0.0 {
                    let t = ((along - sign * start[across]) / gain).max(self.t);
                    if t < first {
                        (first, next) = (t, Some(CubeFace::new(across, positive)));
                    }
                }
            }
        }
        Some((first, next?))
    }
}

/// A point of the ray as seen from its face, kept on it.
#[inline(always)]
fn over(radii: &Radii, face: CubeFace, point: DVec3) -> Over {
    let n = f64::from(radii.cells);
    let [x, y, z] = face.to_frame(point);
    Over { face, at: [cells(n, x / z), cells(n, y / z)], q: n / z }
}

/// A point on the edge between two faces as seen from both.
#[inline(always)]
fn edge(radii: &Radii, (here, there): (CubeFace, CubeFace), point: DVec3) -> (Over, Over) {
    let n = f64::from(radii.cells);
    let z = 0.5 * (here.sign() * point[here.axis()] + there.sign() * point[there.axis()]);
    let seen = |from: CubeFace, to: CubeFace| {
        let border = if to.is_positive() { n } else { 0.0 };
        let at = from
            .across()
            .map(|axis| if axis == to.axis() { border } else { cells(n, point[axis] / z) });
        Over { face: from, at, q: n / z }
    };
    (seen(here, there), seen(there, here))
}

/// Cells' coordinate of a coordinate from -1 to 1.
#[inline(always)]
fn cells(n: f64, a: f64) -> f64 {
    (0.5 * n * (a + 1.0)).max(0.0).min(n)
}

/// The gap at a point over a face.
#[inline(never)]
fn gap_at(relief: &CubeRelief, radii: &Radii, over: &Over) -> f64 {
    let cell = over.at.map(|c| (c as u32).min(radii.cells - 1));
    let local = [over.at[0] - f64::from(cell[0]), over.at[1] - f64::from(cell[1])];
    let corners = radii.corners(cell, raw_corners(relief, over.face, cell));
    bilinear(&corners, local) - over.q
}

/// Raw heights at the corners h00, h10, h01, h11 of a cell.
#[inline(always)]
fn raw_corners(relief: &CubeRelief, face: CubeFace, [i, j]: [u32; 2]) -> [f32; 4] {
    let across = relief.cells() as usize + 1;
    let low = j as usize * across + i as usize;
    let high = low + across;
    match relief.face(face).heights().samples() {
        Samples::U16(v) => [v[low], v[low + 1], v[high], v[high + 1]].map(f32::from),
        Samples::F32(v) => [v[low], v[low + 1], v[high], v[high + 1]],
    }
}

impl<'a> Segment<'a> {
    #[inline(always)]
    fn new((relief, radii): (&'a CubeRelief, &'a Radii), [from, to]: [Over; 2]) -> Self {
        let mut slope = [to.at[0] - from.at[0], to.at[1] - from.at[1]];
        let mut inverse = [0.0; 2];
        for k in 0..2 {
            if slope[k] == 0.0 {
                // On the last line there is a cell on one side only.
                slope[k] = if from.at[k] >= f64::from(radii.cells) { -STILL } else { STILL };
            }
            let exact = 1.0 / slope[k];
            inverse[k] = if exact > 0.0 { exact.next_up() } else { exact.next_down() };
        }
        let q = [from.q, to.q - from.q];
        let (face, origin, ends) = (from.face, from.at, [from, to]);
        Self { face, relief, radii, origin, slope, inverse, q, ends, t: [0.0; 2] }
    }

    /// With its ends as gaps are to be computed there, and the ray's parameters.
    #[inline(always)]
    fn between(self, ends: [Over; 2], t: [f64; 2]) -> Self {
        Self { ends, t, ..self }
    }
}

/// Where a segment crosses the surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    pub s: f64,
    pub cell: [u32; 2],
    /// Whether the ray comes from outside.
    pub outside: bool,
}

impl Segment<'_> {
    /// Where the segment crosses a line of the lattice; infinite, nearly, for one along it.
    #[inline(always)]
    pub fn crosses(&self, axis: usize, line: f64) -> f64 {
        (line - self.origin[axis]) * self.inverse[axis]
    }

    #[inline(always)]
    pub fn q(&self, s: f64) -> f64 {
        self.q[0] + s * self.q[1]
    }

    /// The square of the distance from the centre is this over `q^2`: constant, linear and quadratic
    /// coefficient in s.
    #[inline(always)]
    pub fn square(&self) -> [f64; 3] {
        let n = f64::from(self.radii.cells);
        let [a, b] = [0, 1].map(|k| 2.0 * self.origin[k] - n);
        let [da, db] = [0, 1].map(|k| 2.0 * self.slope[k]);
        [n * n + (a * a + b * b), 2.0 * (a * da + b * db), da * da + db * db]
    }

    /// The ray's parameter at s, from the start of its part.
    #[inline(always)]
    pub fn t_at(&self, s: f64) -> f64 {
        let [from, to] = self.t;
        let fraction = s * (self.q[0] + self.q[1]) / self.q(s);
        from + fraction * (to - from)
    }

    /// s at a parameter of the ray, kept in [0, 1].
    #[inline(always)]
    pub fn s_at(&self, t: f64) -> f64 {
        let [from, to] = self.t;
        if t <= from {
            return 0.0;
        }
        if t >= to {
            return 1.0;
        }
        let fraction = (t - from) / (to - from);
        let (near, far) = (fraction * self.q[0], (1.0 - fraction) * (self.q[0] + self.q[1]));
        near / (near + far)
    }

    /// Where the ray's part has got when the segment begins.
    #[inline(always)]
    pub fn begins(&self) -> f64 {
        self.t[0]
    }

    /// Local coordinate in cell `i` at s, not set by a line.
    #[inline(always)]
    fn local(&self, axis: usize, i: u32, s: f64) -> f64 {
        ((self.origin[axis] - f64::from(i)) + s * self.slope[axis]).clamp(0.0, 1.0)
    }

    /// The gap at one of the ends.
    #[inline(always)]
    fn gap_at(&self, end: usize) -> f64 {
        gap_at(self.relief, self.radii, &self.ends[end])
    }

    /// q at the corners of a cell.
    #[inline(always)]
    fn corners(&self, cell: [u32; 2]) -> [f64; 4] {
        self.radii.corners(cell, raw_corners(self.relief, self.face, cell))
    }

    /// The first root in a cell.
    #[inline(always)]
    pub fn meet(&self, cell: [u32; 2]) -> Option<Root> {
        let (mut near, mut far, mut ahead) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        for k in 0..2 {
            let lines = [0.0, 1.0].map(|side| self.crosses(k, f64::from(cell[k]) + side));
            let forward = self.slope[k] > 0.0;
            (near[k], far[k]) = if forward { (lines[0], lines[1]) } else { (lines[1], lines[0]) };
            ahead[k] = if forward { 1.0 } else { 0.0 };
        }
        let s0 = near[0].max(near[1]).max(0.0);
        let s1 = far[0].min(far[1]).min(1.0);
        if s0 >= s1 {
            return None;
        }
        let (mut a, mut b) = ([0.0; 2], [0.0; 2]);
        for k in 0..2 {
            a[k] = if near[k] >= s0 { 1.0 - ahead[k] } else { self.local(k, cell[k], s0) };
            b[k] = if far[k] <= s1 { ahead[k] } else { self.local(k, cell[k], s1) };
        }
        let corners = self.corners(cell);
        let (qa, qb) = (self.q(s0), self.q(s1));
        let across = bilinear(&corners, [a[0], b[1]]) + bilinear(&corners, [b[0], a[1]]);
        let gap = Gap {
            b0: if s0 == 0.0 { self.gap_at(0) } else { bilinear(&corners, a) - qa },
            b1: 0.5 * (across - (qa + qb)),
            b2: if s1 == 1.0 { self.gap_at(1) } else { bilinear(&corners, b) - qb },
        };
        let (at, outside) = gap.first_root()?;
        Some(Root { s: (s0 + at * (s1 - s0)).min(s1), cell, outside })
    }

    /// Local coordinates of a root in its cell, and the gap there relative to q.
    #[inline(always)]
    pub fn place(&self, root: &Root) -> ([f64; 2], f64) {
        let local = [0, 1].map(|k| self.local(k, root.cell[k], root.s));
        let corners = self.corners(root.cell);
        let (surface, ray) = (bilinear(&corners, local), self.q(root.s));
        (local, (surface / ray - 1.0).abs())
    }
}
