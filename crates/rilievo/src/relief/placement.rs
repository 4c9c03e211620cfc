//! [`Placement`]: where a height map lies in the world, and how a ray gets from the one to the
//! other.
//!
//! `S(u, v) = corner + u edge_u + v edge_v + offset N`. World space and lattice space are joined by
//! an affine map, so a ray stays a ray and keeps its parameter.

use glam::{DMat3, DVec3};

use crate::map::HeightMap;
use crate::ray::{Origin, Part, Ray, Wall};

use super::leaf;
use super::map_ray::{ExactRay, MapRay, Window};
use super::options::Displacement;

/// A height map laid on a parallelogram.
#[derive(Clone, Debug)]
pub(crate) struct Placement {
    pub corner: DVec3,
    pub edge_u: DVec3,
    pub edge_v: DVec3,
    /// Unit, along `edge_u x edge_v`.
    pub normal: DVec3,
    /// (u, v, distance along the normal) from a world vector.
    uvw_from_world: DMat3,
    pub displacement: Displacement,
    /// The face's border in lattice space.
    pub window: Window,
    /// Raw height that lies on the face.
    pub raw_zero: f64,
    /// Raw heights per scene unit along the normal.
    pub raw_per_length: f64,
    /// Largest magnitude of a raw height of the map.
    size: f64,
    /// Raw range of the map.
    range: [f64; 2],
}

impl Placement {
    /// Lays a map on the parallelogram at `corner` with edges that span an area.
    pub fn new(
        [corner, edge_u, edge_v]: [DVec3; 3],
        heights: &HeightMap,
        displacement: Displacement,
    ) -> Self {
        let Displacement { scale, zero, tile, shift } = displacement;
        let line = |u: f64, k: usize| {
            let axis = if k == 0 { heights.x() } else { heights.y() };
            axis.coordinate(u * tile[k] + shift[k])
        };
        let normal = edge_u.cross(edge_v).normalize();
        let (low, high) = heights.raw_range();
        Self {
            corner,
            edge_u,
            edge_v,
            normal,
            uvw_from_world: DMat3::from_cols(edge_u, edge_v, normal).inverse(),
            displacement,
            window: Window { lo: [line(0.0, 0), line(0.0, 1)], hi: [line(1.0, 0), line(1.0, 1)] },
            raw_zero: zero / heights.unit(),
            raw_per_length: 1.0 / (scale * heights.unit()),
            size: f64::from(low.abs().max(high.abs())),
            range: [f64::from(low), f64::from(high)],
        }
    }

    /// The point of the base face at (u, v).
    pub fn base_point(&self, u: f64, v: f64) -> DVec3 {
        self.corner + u * self.edge_u + v * self.edge_v
    }

    /// Offset along the normal of a raw height, scene units.
    pub fn offset(&self, raw: f64) -> f64 {
        (raw - self.raw_zero) / self.raw_per_length
    }

    /// Face parameters of a lattice point, in [0, 1].
    pub fn uv(&self, heights: &HeightMap, [x, y]: [f64; 2]) -> [f64; 2] {
        let Displacement { tile, shift, .. } = self.displacement;
        [
            ((heights.x().parameter(x) - shift[0]) / tile[0]).clamp(0.0, 1.0),
            ((heights.y().parameter(y) - shift[1]) / tile[1]).clamp(0.0, 1.0),
        ]
    }

    /// Origin and direction of a world ray in lattice space, if they are finite.
    fn lattice_ray(&self, heights: &HeightMap, ray: &Ray) -> Option<([f64; 3], [f64; 3])> {
        let start = self.uvw_from_world * (ray.origin - self.corner);
        let along = self.uvw_from_world * ray.direction;
        let Displacement { tile, shift, .. } = self.displacement;
        let (px, py) = (f64::from(heights.x().period()), f64::from(heights.y().period()));
        let origin = [
            heights.x().coordinate(start.x * tile[0] + shift[0]),
            heights.y().coordinate(start.y * tile[1] + shift[1]),
            self.raw_zero + start.z * self.raw_per_length,
        ];
        let direction =
            [along.x * tile[0] * px, along.y * tile[1] * py, along.z * self.raw_per_length];
        origin.iter().chain(&direction).all(|x| x.is_finite()).then_some((origin, direction))
    }

    /// The ray in the frame of the walk; none if it passes by the face's box. `closed` includes the
    /// walls down to offset 0 in the box.
    pub fn map_ray(&self, heights: &HeightMap, ray: &Ray, closed: bool) -> Option<MapRay> {
        let (mut origin, direction) = self.lattice_ray(heights, ray)?;
        let mut lift = 0.0;
        if let Some(Origin { part, front, .. }) = ray.from {
            match part {
                Part::Wall(wall) => self.leave_wall(wall, &mut origin, direction)?,
                _ => lift = self.lift(front),
            }
        }
        let pad = 64.0 * f64::from(leaf::slack(self.size as f32));
        let [low, high] = [self.range[0] - pad, self.range[1] + pad];
        let (mut floor, mut roof) = (low, high);
        if closed {
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
        // The ray's own end, a little widened, and the part within the height range.
        let end = ((ray.t_max - t_in) / length * (1.0 + 1e-6) + 1e-9).min(1.0);
        let (z, dz) = (exact.origin[2] + lift, exact.direction[2]);
        let cull = if dz == 0.0 {
            if z < low || z > high { [1.0, 0.0] } else { [0.0, end] }
        } else {
            let (a, b) = ((low - z) / dz, (high - z) / dz);
            [a.min(b).clamp(0.0, 1.0), a.max(b).clamp(0.0, end)]
        };
        Some(MapRay::new(exact, &self.window, (lift, self.range), cull))
    }

    /// How far a spawned ray starts above the raw surface; see the proof in `leaf`. A map of zeros
    /// gets a lift of 2^-28 of the face's size.
    fn lift(&self, front: bool) -> f64 {
        let extent = self.edge_u.length().max(self.edge_v.length());
        let least = (extent * self.raw_per_length.abs()) as f32 * 2.0f32.powi(-10);
        let lift = f64::from(leaf::lift((self.size as f32).max(least)));
        if front == (self.displacement.scale > 0.0) { lift } else { -lift }
    }

    /// Puts a ray that starts on a wall exactly on the wall's line. None if it leaves the face for
    /// good: a straight line crosses the border's line only once.
    fn leave_wall(&self, wall: Wall, origin: &mut [f64; 3], direction: [f64; 3]) -> Option<()> {
        let (axis, line) = self.wall_line(wall);
        let outward = match wall {
            Wall::LowU | Wall::LowV => -1.0,
            Wall::HighU | Wall::HighV => 1.0,
            Wall::SeamU(_) | Wall::SeamV(_) => 0.0,
        };
        if outward != 0.0 && direction[axis] * outward >= 0.0 {
            return None;
        }
        origin[axis] = line;
        Some(())
    }

    /// Axis and lattice coordinate of a wall's line.
    pub fn wall_line(&self, wall: Wall) -> (usize, f64) {
        let Window { lo, hi } = self.window;
        match wall {
            Wall::LowU => (0, lo[0]),
            Wall::HighU => (0, hi[0]),
            Wall::LowV => (1, lo[1]),
            Wall::HighV => (1, hi[1]),
            Wall::SeamU(line) => (0, f64::from(line)),
            Wall::SeamV(line) => (1, f64::from(line)),
        }
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
