//! [`ReliefFace`]: a displaced parallelogram.
//!
//! `S(u, v) = c0 + u (c1 - c0) + v (c3 - c0) + offset(u, v) N` with the unit normal `N` along
//! `(c1 - c0) x (c3 - c0)` and `offset = scale (H(u tile + shift) - zero)`. The map from world to
//! lattice space is affine, so a ray stays a ray and keeps its parameter: one height map, pyramid
//! and distance map serve every face, whatever its size, depth and orientation.

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use crate::accel::Aabb;
use crate::hit::Hit;
use crate::map::{DistanceKind, Lattice, Wrap};
use crate::probe::Probe;
use crate::ray::{Part, Ray, Wall};

use super::Relief;
use super::leaf::{self, Crossings};
use super::map_ray::{ExactRay, MapRay, Window};
use super::method::Method;
use super::shading::ShadingNormals;
use super::trace::{self, Crossing, Place};

/// How a height map is laid on a face: `offset(u, v) = scale * (H(u * tile + shift) - zero)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// Scene units per unit of height; may be negative, not 0.
    pub scale: f64,
    /// The height that stays on the face.
    pub zero: f64,
    /// Repetitions of the map along u and v; positive.
    pub tile: [f64; 2],
    /// Added to the map parameters after tiling.
    pub shift: [f64; 2],
}

impl Default for Displacement {
    fn default() -> Self {
        Self { scale: 1.0, zero: 0.0, tile: [1.0; 2], shift: [0.0; 2] }
    }
}

/// Everything about a face but its corners and its map.
#[derive(Clone, Debug, Default)]
pub struct FaceOptions {
    /// How the map is laid on the face.
    pub displacement: Displacement,
    /// How rays are walked.
    pub method: Method,
    /// Which normals to shade with.
    pub normals: ShadingNormals,
    /// Whether walls go down from the border to offset 0.
    pub closed: bool,
    /// Whether rays from behind pass through.
    pub one_sided: bool,
}

/// Why a face was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FaceError {
    /// The fourth corner does not complete a parallelogram.
    #[error("the corners are not a parallelogram: c2 is {found}, c1 + c3 - c0 is {expected}")]
    NotParallelogram {
        /// Corner c2 as given.
        found: DVec3,
        /// Corner c2 of the parallelogram.
        expected: DVec3,
    },
    /// The corners are not finite or lie on one line.
    #[error("the corners span no area")]
    Degenerate,
    /// A number of the displacement is out of its range.
    #[error("displacement {key} is {value}; {allowed}")]
    Displacement {
        /// The key at fault.
        key: &'static str,
        /// The value found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Tiling unfolds the map to more cells than indices can count exactly.
    #[error("tile and shift unfold the map to lattice coordinates up to {found}; at most 4194304")]
    TooManyCells {
        /// Largest lattice coordinate.
        found: f64,
    },
    /// The method needs a distance map that the relief does not have.
    #[error("method {method} needs a {kind:?} distance map")]
    NoDistanceMap {
        /// The method asked for.
        method: Method,
        /// The kind of map it needs.
        kind: DistanceKind,
    },
}

/// Largest magnitude of a lattice coordinate.
const MAX_COORDINATE: f64 = (1u32 << 22) as f64;

/// A displaced parallelogram, ready to be traced. Cheap to copy around: the relief is shared.
#[derive(Clone, Debug)]
pub struct ReliefFace {
    pub(crate) corner: DVec3,
    pub(crate) edge_u: DVec3,
    pub(crate) edge_v: DVec3,
    pub(crate) normal: DVec3,
    /// (u, v, distance along the normal) from a world vector.
    uvw_from_world: DMat3,
    pub(crate) relief: Arc<Relief>,
    pub(crate) options: FaceOptions,
    pub(crate) window: Window,
    /// Raw height that lies on the face.
    pub(crate) raw_zero: f64,
    /// Raw heights per scene unit along the normal.
    raw_per_length: f64,
    bounds: Aabb,
}

impl ReliefFace {
    /// A face with corners c0, c1, c2, c3; u runs from c0 to c1, v from c0 to c3.
    ///
    /// # Errors
    /// [`FaceError`] if the corners are not a parallelogram (to 1e-9 of its size), a number of the
    /// displacement is out of range, or the method lacks its distance map.
    pub fn new(
        corners: [DVec3; 4],
        relief: Arc<Relief>,
        options: FaceOptions,
    ) -> Result<Self, FaceError> {
        let [c0, c1, c2, c3] = corners;
        let (edge_u, edge_v) = (c1 - c0, c3 - c0);
        let area = edge_u.cross(edge_v);
        let extent = edge_u.length().max(edge_v.length());
        if !(area.length() > 1e-12 * extent * extent && area.is_finite()) {
            return Err(FaceError::Degenerate);
        }
        let expected = c1 + edge_v;
        let reach = extent + c0.length() * 1e-6;
        if !((c2 - expected).length() <= 1e-9 * reach) {
            return Err(FaceError::NotParallelogram { found: c2, expected });
        }
        check_displacement(&options.displacement)?;
        if let Some(kind) = distance_kind(options.method)
            && relief.distance(kind).is_none()
        {
            return Err(FaceError::NoDistanceMap { method: options.method, kind });
        }
        let heights = relief.heights();
        let Displacement { scale, zero, tile, shift } = options.displacement;
        let line = |u: f64, k: usize| {
            let axis = if k == 0 { heights.x() } else { heights.y() };
            axis.coordinate(u * tile[k] + shift[k])
        };
        let window = Window { lo: [line(0.0, 0), line(0.0, 1)], hi: [line(1.0, 0), line(1.0, 1)] };
        let farthest = window.lo.iter().chain(&window.hi).fold(0.0f64, |far, x| far.max(x.abs()));
        if farthest > MAX_COORDINATE {
            return Err(FaceError::TooManyCells { found: farthest });
        }
        let normal = area.normalize();
        let unit = heights.unit();
        let mut face = Self {
            corner: c0,
            edge_u,
            edge_v,
            normal,
            uvw_from_world: DMat3::from_cols(edge_u, edge_v, normal).inverse(),
            raw_zero: zero / unit,
            raw_per_length: 1.0 / (scale * unit),
            window,
            bounds: Aabb::EMPTY,
            relief,
            options,
        };
        face.bounds = face.compute_bounds();
        Ok(face)
    }

    /// The box that holds the displaced face and its walls, a rounding margin included.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The shared relief.
    pub fn relief(&self) -> &Arc<Relief> {
        &self.relief
    }

    /// The options the face was made with.
    pub fn options(&self) -> &FaceOptions {
        &self.options
    }

    /// The base point, edges and unit normal: `[c0, c1 - c0, c3 - c0, N]`.
    pub fn frame(&self) -> [DVec3; 4] {
        [self.corner, self.edge_u, self.edge_v, self.normal]
    }

    /// The nearest hit with `0 <= t <= ray.t_max`. `hit.surface` is 0.
    pub fn closest<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Hit> {
        let crossing = self.first_crossing(ray, probe)?;
        Some(self.hit(ray, &crossing))
    }

    /// Whether the ray meets the face at some `0 <= t <= ray.t_max`.
    pub fn occludes<P: Probe>(&self, ray: &Ray, probe: &mut P) -> bool {
        self.first_crossing(ray, probe).is_some()
    }

    fn first_crossing<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Crossing> {
        let map_ray = self.map_ray(ray)?;
        let crossing = trace::first_crossing(self, &map_ray, ray.from.is_some(), probe)?;
        (crossing.t <= ray.t_max).then_some(crossing)
    }

    /// Which crossings of the raw surface are hits.
    pub(crate) fn admitted(&self) -> Crossings {
        match (self.options.one_sided, self.options.displacement.scale > 0.0) {
            (false, _) => Crossings::Both,
            (true, true) => Crossings::Downward,
            (true, false) => Crossings::Upward,
        }
    }

    /// Whether the surface may jump where two tiles meet.
    pub(crate) fn has_seams(&self) -> bool {
        let x = self.relief.heights().x();
        (x.lattice(), x.wrap()) == (Lattice::Vertex, Wrap::Repeat)
    }

    /// The ray in the frame of the walk, if it comes near the face at all.
    fn map_ray(&self, ray: &Ray) -> Option<MapRay> {
        let heights = self.relief.heights();
        let start = self.uvw_from_world * (ray.origin - self.corner);
        let along = self.uvw_from_world * ray.direction;
        let Displacement { tile, shift, .. } = self.options.displacement;
        let (px, py) = (f64::from(heights.x().period()), f64::from(heights.y().period()));
        let mut origin = [
            heights.x().coordinate(start.x * tile[0] + shift[0]),
            heights.y().coordinate(start.y * tile[1] + shift[1]),
            self.raw_zero + start.z * self.raw_per_length,
        ];
        let direction =
            [along.x * tile[0] * px, along.y * tile[1] * py, along.z * self.raw_per_length];
        if !origin.iter().chain(&direction).all(|x| x.is_finite()) {
            return None;
        }
        let (low, high) = heights.raw_range();
        let size = f64::from(low.abs().max(high.abs()));
        let pad = 64.0 * f64::from(leaf::slack(size as f32));
        let mut lift = 0.0;
        if let Some(from) = ray.from {
            match from.part {
                Part::Wall(wall) => self.leave_wall(wall, &mut origin, direction)?,
                _ => lift = self.lift(size, from.front),
            }
        }
        let (low, high) = (f64::from(low) - pad, f64::from(high) + pad);
        let (mut floor, mut roof) = (low, high);
        if self.options.closed {
            (floor, roof) = (low.min(self.raw_zero - pad), high.max(self.raw_zero + pad));
        }
        let Window { lo, hi } = self.window;
        let (t_in, t_out) = clip(
            (origin, direction),
            [lo[0] - 1.0, lo[1] - 1.0, floor - pad - lift.abs()],
            [hi[0] + 1.0, hi[1] + 1.0, roof + pad + lift.abs()],
        )?;
        let length = t_out - t_in;
        if t_in > ray.t_max || !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let exact = ExactRay {
            origin: [0, 1, 2].map(|k| origin[k] + t_in * direction[k]),
            direction: direction.map(|d| d * length),
            t_start: t_in,
            t_length: length,
        };
        // The part within the height range and before the ray's own end, a little widened.
        let (z, dz) = (exact.origin[2] + lift, exact.direction[2]);
        let mut cull = [0.0, ((ray.t_max - t_in) / length * (1.0 + 1e-9) + 1e-9).min(1.0)];
        if dz == 0.0 {
            if z < low || z > high {
                cull = [1.0, 0.0];
            }
        } else {
            let (a, b) = ((low - z) / dz, (high - z) / dz);
            cull = [a.min(b).clamp(0.0, 1.0), cull[1].min(a.max(b)).max(0.0)];
        }
        Some(MapRay::new(exact, &self.window, lift, cull))
    }

    /// How far a spawned ray starts above the raw surface; see the proof in `leaf`. A map of zeros
    /// gets a lift of 2^-28 of the face's size.
    fn lift(&self, size: f64, front: bool) -> f64 {
        let extent = self.edge_u.length().max(self.edge_v.length());
        let least = (extent * self.raw_per_length.abs()) as f32 * 2.0f32.powi(-10);
        let lift = f64::from(leaf::lift((size as f32).max(least)));
        if front == (self.options.displacement.scale > 0.0) { lift } else { -lift }
    }

    /// Puts a ray that starts on a wall exactly on the wall's line. None if it leaves the face for
    /// good: a straight line crosses the border's line only once.
    fn leave_wall(&self, wall: Wall, origin: &mut [f64; 3], direction: [f64; 3]) -> Option<()> {
        let Window { lo, hi } = self.window;
        let (axis, line, outward) = match wall {
            Wall::LowU => (0, lo[0], -1.0),
            Wall::HighU => (0, hi[0], 1.0),
            Wall::LowV => (1, lo[1], -1.0),
            Wall::HighV => (1, hi[1], 1.0),
            Wall::SeamU(line) => (0, f64::from(line), 0.0),
            Wall::SeamV(line) => (1, f64::from(line), 0.0),
        };
        if outward != 0.0 && direction[axis] * outward >= 0.0 {
            return None;
        }
        origin[axis] = line;
        Some(())
    }

    /// World-space account of a crossing.
    fn hit(&self, ray: &Ray, crossing: &Crossing) -> Hit {
        let heights = self.relief.heights();
        let Displacement { scale, zero, tile, shift } = self.options.displacement;
        let [x, y] = crossing.lattice;
        let uv = DVec2::new(
            ((heights.x().parameter(x) - shift[0]) / tile[0]).clamp(0.0, 1.0),
            ((heights.y().parameter(y) - shift[1]) / tile[1]).clamp(0.0, 1.0),
        );
        let height = crossing.raw * heights.unit();
        let offset = scale * (height - zero);
        let base = self.corner + uv.x * self.edge_u + uv.y * self.edge_v;
        let (part, geometric_normal, shading_normal) = match crossing.place {
            Place::Cell { cell, local } => {
                let geometric = self.geometric_normal(cell, local);
                let shading = self.shading_normal(cell, local, geometric);
                (Part::Cell(cell[0], cell[1]), geometric, shading)
            }
            Place::Wall(wall) => {
                let normal = self.wall_normal(wall, ray.direction, crossing.front);
                (Part::Wall(wall), normal, normal)
            }
        };
        let size = self.corner.abs().max_element()
            + self.edge_u.length()
            + self.edge_v.length()
            + offset.abs();
        Hit {
            t: crossing.t,
            position: base + offset * self.normal,
            position_error: size * 16.0 * f64::EPSILON,
            geometric_normal,
            shading_normal,
            tangents: [self.edge_u, self.edge_v],
            uv,
            height,
            front: crossing.front,
            surface: 0,
            part,
        }
    }

    /// Unit normal of a wall, towards the side that is clear of the solid below the surface.
    fn wall_normal(&self, wall: Wall, direction: DVec3, front: bool) -> DVec3 {
        let along = match wall {
            Wall::LowU | Wall::HighU | Wall::SeamU(_) => self.edge_v,
            Wall::LowV | Wall::HighV | Wall::SeamV(_) => self.edge_u,
        };
        let normal = along.cross(self.normal).normalize();
        if (normal.dot(direction) < 0.0) == front { normal } else { -normal }
    }

    fn compute_bounds(&self) -> Aabb {
        let (low, high) = self.relief.heights().raw_range();
        let mut offsets = vec![f64::from(low), f64::from(high)];
        if self.options.closed {
            offsets.push(self.raw_zero);
        }
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        let points = offsets.iter().flat_map(|raw| {
            let offset = (raw - self.raw_zero) / self.raw_per_length * self.normal;
            corners.map(|(u, v)| self.corner + u * self.edge_u + v * self.edge_v + offset)
        });
        let bounds = Aabb::around(points);
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        let extent = (bounds.max - bounds.min).max_element();
        bounds.grown(extent * 1e-6 + reach * 1e-12)
    }
}

fn check_displacement(d: &Displacement) -> Result<(), FaceError> {
    let refuse = |key, value, allowed| Err(FaceError::Displacement { key, value, allowed });
    if !d.scale.is_finite() || d.scale == 0.0 {
        return refuse("scale", d.scale, "finite and not 0");
    }
    if !d.zero.is_finite() {
        return refuse("zero", d.zero, "finite");
    }
    for value in d.tile {
        if !(value.is_finite() && value > 0.0) {
            return refuse("tile", value, "finite and above 0");
        }
    }
    for value in d.shift {
        if !value.is_finite() {
            return refuse("shift", value, "finite");
        }
    }
    Ok(())
}

/// The kind of distance map a method walks, if it walks one.
pub(crate) fn distance_kind(method: Method) -> Option<DistanceKind> {
    match method {
        Method::Distance => Some(DistanceKind::Boxes),
        Method::DistanceCorrected => Some(DistanceKind::Corrected),
        Method::DistancePublished => Some(DistanceKind::Published),
        Method::Dda | Method::Pyramid | Method::March => None,
    }
}

/// Parameters at which a line is inside a box, not before 0.
fn clip(
    (origin, direction): ([f64; 3], [f64; 3]),
    low: [f64; 3],
    high: [f64; 3],
) -> Option<(f64, f64)> {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for k in 0..3 {
        if direction[k] == 0.0 {
            if origin[k] < low[k] || origin[k] > high[k] {
                return None;
            }
            continue;
        }
        let (a, b) = ((low[k] - origin[k]) / direction[k], (high[k] - origin[k]) / direction[k]);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter < leave).then_some((enter, leave))
}
