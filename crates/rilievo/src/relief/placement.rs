//! [`Placement`]: where a height map lies in the world, and how a ray gets from the one to the
//! other.
//!
//! `S(u, v) = corner + u edge_u + v edge_v + offset N`. World space and lattice space are joined by
//! an affine map, so a ray stays a ray and keeps its parameter.

use glam::{DMat3, DVec3};

use crate::map::{Axis, HeightMap};
use crate::ray::{Origin, Part, Ray, Wall};

use super::leaf;
use super::map_ray::{ExactRay, MapRay, Window};
use super::options::Displacement;
use super::shell::{ClippedRay, LatticeRay, Shell};
use super::walk::Unfolding;

/// A height map laid on a parallelogram.
#[derive(Clone, Debug)]
pub(crate) struct Placement {
    pub corner: DVec3,
    pub edge_u: DVec3,
    pub edge_v: DVec3,
    /// Unit, along `edge_u x edge_v`.
    pub normal: DVec3,
    /// Lattice space from a world vector: unfolded cells along u and v, raw heights.
    lattice_from_world: DMat3,
    /// The face's corner in lattice space.
    lattice_corner: DVec3,
    pub displacement: Displacement,
    /// The face's border in lattice space.
    pub window: Window,
    /// How the window shows the map, if it lies in one run of each axis.
    pub unfolding: Option<[Unfolding; 2]>,
    /// Raw height that lies on the face.
    pub raw_zero: f64,
    /// Raw heights per scene unit along the normal.
    pub raw_per_length: f64,
    /// Raw range of the map.
    range: [f64; 2],
    /// Largest magnitude of a raw height of the map.
    size: f32,
    /// The range within which rays are walked: wider by 64 slacks of the leaf.
    culled: [f64; 2],
    /// How far above the raw surface a ray starts that is spawned towards larger heights; see the
    /// proof in `leaf`. A map of zeros gets a lift of 2^-28 of the face's size.
    lift: f64,
    /// Whether larger raw heights lie farther along the normal.
    rises: bool,
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
        let size = low.abs().max(high.abs());
        let raw_per_length = 1.0 / (scale * heights.unit());
        let extent = edge_u.length().max(edge_v.length());
        let least = (extent * raw_per_length.abs()) as f32 * 2.0f32.powi(-10);
        let pad = 64.0 * f64::from(leaf::slack(size.max(least)));
        let raw_zero = zero / heights.unit();
        let per_uvw = DVec3::new(
            tile[0] * f64::from(heights.x().period()),
            tile[1] * f64::from(heights.y().period()),
            raw_per_length,
        );
        let window = Window { lo: [line(0.0, 0), line(0.0, 1)], hi: [line(1.0, 0), line(1.0, 1)] };
        let uvw_from_world = DMat3::from_cols(edge_u, edge_v, normal).inverse();
        Self {
            corner,
            edge_u,
            edge_v,
            normal,
            lattice_from_world: DMat3::from_diagonal(per_uvw) * uvw_from_world,
            lattice_corner: DVec3::new(window.lo[0], window.lo[1], raw_zero),
            displacement,
            unfolding: whole_runs(heights, &window),
            window,
            raw_zero,
            raw_per_length,
            range: [f64::from(low), f64::from(high)],
            size,
            culled: [f64::from(low) - pad, f64::from(high) + pad],
            lift: f64::from(leaf::lift(size.max(least))),
            rises: scale > 0.0,
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

    /// The ray in the frame of the walk; none if it passes by the face's box. `closed` includes the
    /// walls down to offset 0 in the box.
    #[inline(always)]
    pub fn map_ray(&self, ray: &Ray, closed: bool) -> Option<MapRay> {
        let shell = self.shell(closed);
        let (origin, direction) = self.lattice_from_world(ray.origin, ray.direction);
        let mut start = LatticeRay { origin, direction, lift: 0.0, t_max: ray.t_max };
        if let Some(Origin { part, front, .. }) = ray.from {
            match part {
                Part::Wall(wall) => {
                    self.leave_wall(wall, &mut start.origin, start.direction)?;
                }
                _ => start.lift = self.lift(front),
            }
        }
        let clipped = shell.clip(&start);
        clipped.valid.then(|| self.rounded(&clipped, start.lift))
    }

    /// Start and direction of a ray in lattice space.
    #[inline(always)]
    pub fn lattice_from_world(&self, origin: DVec3, direction: DVec3) -> (DVec3, DVec3) {
        (
            self.lattice_from_world * (origin - self.corner) + self.lattice_corner,
            self.lattice_from_world * direction,
        )
    }

    /// What is added to the height of a ray that starts on the surface and leaves towards a side.
    #[inline(always)]
    pub fn lift(&self, front: bool) -> f64 {
        if front == self.rises { self.lift } else { -self.lift }
    }

    /// The box in which rays are walked.
    #[inline(always)]
    pub fn shell(&self, closed: bool) -> Shell {
        let [low, high] = self.culled;
        let pad = high - self.range[1];
        let (mut floor, mut roof) = (low, high);
        if closed {
            (floor, roof) = (low.min(self.raw_zero - pad), high.max(self.raw_zero + pad));
        }
        let beyond = pad + self.lift;
        let Window { lo, hi } = self.window;
        Shell {
            low: DVec3::new(lo[0] - 1.0, lo[1] - 1.0, floor - beyond),
            high: DVec3::new(hi[0] + 1.0, hi[1] + 1.0, roof + beyond),
            culled: self.culled,
        }
    }

    /// Raw range of the map.
    #[inline(always)]
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// Largest magnitude of a raw height of the map.
    #[inline(always)]
    pub fn size(&self) -> f32 {
        self.size
    }

    /// A clipped ray, rounded for the walk.
    #[inline(always)]
    pub fn rounded(&self, ray: &ClippedRay, lift: f64) -> MapRay {
        let exact = ExactRay {
            origin: ray.start.to_array(),
            direction: ray.direction.to_array(),
            t_start: ray.t_start,
            t_length: ray.t_length,
        };
        MapRay::new(exact, &self.window, (lift, self.range), (ray.cull, ray.end))
    }

    /// Puts a ray that starts on a wall exactly on the wall's line. None if it leaves the face for
    /// good: a straight line crosses the border's line only once.
    #[cold]
    fn leave_wall(&self, wall: Wall, origin: &mut DVec3, direction: DVec3) -> Option<()> {
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

    /// Corner heights of an unfolded cell of the window, `[h00, h10, h01, h11]`.
    #[inline(always)]
    pub fn corners(&self, heights: &HeightMap, cell: [i32; 2]) -> [f32; 4] {
        match self.unfolding {
            Some([x, y]) => {
                let [a, b, c, d] =
                    heights.stored_corners(x.stored(cell[0]) as u32, y.stored(cell[1]) as u32);
                let [a, b, c, d] = if x.falls() { [b, a, d, c] } else { [a, b, c, d] };
                if y.falls() { [c, d, a, b] } else { [a, b, c, d] }
            }
            None => heights.unfolded_corners(cell[0], cell[1]),
        }
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

/// The runs of both axes that hold the whole window, if one of each does.
fn whole_runs(heights: &HeightMap, window: &Window) -> Option<[Unfolding; 2]> {
    let whole = |axis: &Axis, k: usize| {
        let (lo, hi) = (window.lo[k].floor(), window.hi[k].ceil());
        // Cells are counted in `i32`; a larger window is refused later.
        let countable = lo.abs().max(hi.abs()) < f64::from(1 << 24);
        let run = countable.then(|| axis.run(lo as i32))?;
        (run.end() >= hi as i32).then(|| Unfolding::of(&run))
    };
    Some([whole(heights.x(), 0)?, whole(heights.y(), 1)?])
}
