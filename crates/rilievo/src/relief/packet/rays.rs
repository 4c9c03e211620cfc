//! [`PacketRays`]: the rays of a packet, side by side.
//!
//! One array a number, one element a ray. The rays are clipped and rounded by the functions of the
//! ray alone, in loops over the arrays without a branch, which compilers turn into vectors: the bits
//! stay those of the ray alone.

use glam::DVec3;

use crate::ray::{Part, Ray};
use crate::simd::WIDTH;

use super::super::map_ray::{MapRay, larger, smaller};
use super::super::placement::Placement;
use super::super::shell::{ClippedRay, LatticeRay};
use super::super::walk::{TileFrame, Unfolding};
use super::PACKET;
use super::lanes::RayLanes;

/// Rays that run through one window in the same mirrored directions. Lanes without a ray repeat the
/// first one that has one.
pub(crate) struct PacketRays<'a> {
    pub(super) placement: &'a Placement,
    pub(super) clipped: ClippedRays,
    pub(super) lanes: RayLanes,
    /// The first ray that is live.
    first: usize,
    /// Largest magnitude of a raw height of the map.
    pub(super) size: f32,
    /// Lanes that hold a ray.
    pub(crate) live: u16,
    /// Rays that must be traced alone: they go another way than the first, or leave a wall.
    pub(crate) alone: u16,
}

/// Rays in `f64`.
pub(super) struct ClippedRays {
    pub start: [[f64; PACKET]; 3],
    pub direction: [[f64; PACKET]; 3],
    pub t_start: [f64; PACKET],
    pub t_length: [f64; PACKET],
    cull: [[f64; PACKET]; 2],
    end: [f64; PACKET],
    lift: [f64; PACKET],
}

/// Numbers of all rays, none yet.
const NONE: [f64; PACKET] = [0.0; PACKET];

impl<'a> PacketRays<'a> {
    /// No rays yet. Filled in place: the arrays are large to move.
    #[inline(always)]
    pub fn new(placement: &'a Placement) -> Self {
        let clipped = ClippedRays {
            start: [NONE; 3],
            direction: [NONE; 3],
            t_start: NONE,
            t_length: NONE,
            cull: [NONE; 2],
            end: NONE,
            lift: NONE,
        };
        Self { placement, clipped, lanes: RayLanes::new(), first: 0, size: 0.0, live: 0, alone: 0 }
    }

    /// At most [`PACKET`] rays against a face that shows its map in one run and has no walls.
    #[inline(always)]
    pub fn fill(&mut self, unfolding: [Unfolding; 2], rays: &[Ray]) {
        let valid = self.clip(rays);
        let worth = valid & self.round(unfolding);
        self.first = worth.trailing_zeros() as usize % PACKET;
        let mut others = 0;
        for k in 0..PACKET {
            others |= u16::from(!self.lanes.go_together(self.first, k)) << k;
        }
        self.live = worth & !others;
        self.lanes.repeat(self.first, self.live);
        self.size = self.clipped.rounded(self.placement, self.first).size;
        self.alone |= worth & others;
    }

    /// Clips the rays to the face's box; one bit for each that meets it.
    #[inline(always)]
    fn clip(&mut self, rays: &[Ray]) -> u16 {
        let mut world = [[NONE; 3]; 2];
        // Lanes without a ray end before they start.
        let mut t_max = [-1.0; PACKET];
        for (k, ray) in rays.iter().take(PACKET).enumerate() {
            let [origin, direction] = &mut world;
            for axis in 0..3 {
                origin[axis][k] = ray.origin[axis];
                direction[axis][k] = ray.direction[axis];
            }
            t_max[k] = ray.t_max;
            if let Some(from) = ray.from {
                self.clipped.lift[k] = self.placement.lift(from.front);
                if matches!(from.part, Part::Wall(_)) {
                    self.alone |= 1 << k;
                    t_max[k] = -1.0;
                }
            }
        }
        let shell = self.placement.shell(false);
        let to = &mut self.clipped;
        let mut valid = [0u64; PACKET];
        for k in 0..PACKET {
            let at = |of: &[[f64; PACKET]; 3]| DVec3::new(of[0][k], of[1][k], of[2][k]);
            let (origin, direction) =
                self.placement.lattice_from_world(at(&world[0]), at(&world[1]));
            let ray = LatticeRay { origin, direction, lift: to.lift[k], t_max: t_max[k] };
            let clipped = shell.clip(&ray);
            to.set(k, &clipped);
            valid[k] = u64::from(clipped.valid);
        }
        let mut bits = 0;
        for (k, valid) in valid.into_iter().enumerate() {
            bits |= (valid as u16) << k;
        }
        bits
    }

    /// Rounds the rays for the walk; one bit for each that meets the window.
    #[inline(always)]
    fn round(&mut self, unfolding: [Unfolding; 2]) -> u16 {
        let to = &mut self.lanes;
        let mut meets = [0u32; WIDTH];
        for (k, meets) in meets.iter_mut().enumerate() {
            let ray = self.clipped.rounded(self.placement, k);
            let (enter, leave) = ray.window_span();
            let frame = TileFrame::of_window(&ray, unfolding, (enter, leave));
            let (first, last) = (larger(enter, ray.cull[0]), smaller(leave, ray.cull[1]));
            for axis in 0..2 {
                to.o[axis][k] = ray.o[axis];
                to.d[axis][k] = ray.d[axis];
                to.inv[axis][k] = ray.inv[axis];
                to.lo[axis][k] = frame.lo[axis];
                to.hi[axis][k] = frame.hi[axis];
                to.cull[axis][k] = ray.cull[axis];
                to.origin[axis][k] = frame.origin[axis];
                to.turn[axis][k] = frame.turn[axis];
                to.base[axis][k] = ray.base[axis];
                to.backward[axis][k] = -i32::from(ray.backward[axis]);
            }
            (to.part[0][k], to.part[1][k]) = (first, last);
            (to.oz[k], to.dz[k]) = (ray.oz, ray.dz);
            to.below[k] = u32::from(!ray.above);
            *meets = u32::from((enter < leave) & (first < last));
        }
        let mut bits = 0;
        for (k, meets) in meets.into_iter().enumerate() {
            bits |= (meets as u16) << k;
        }
        bits
    }

    /// Mirrored cell of the first ray's forward cell 0: the packet counts cells from there.
    #[inline(always)]
    pub fn origin(&self) -> [i32; 2] {
        [self.lanes.origin[0][self.first], self.lanes.origin[1][self.first]]
    }

    /// What stored cells are combined with to give mirrored cells; see [`TileFrame`].
    #[inline(always)]
    pub fn turn(&self) -> [i32; 2] {
        [self.lanes.turn[0][self.first], self.lanes.turn[1][self.first]]
    }

    /// Whether any ray may start below the surface.
    #[inline(always)]
    pub fn any_may_be_below(&self) -> bool {
        self.lanes.below.iter().fold(0, |any, below| any | below) != 0
    }

    /// The ray of a lane.
    #[inline(always)]
    pub fn ray(&self, lane: usize) -> MapRay {
        self.clipped.rounded(self.placement, lane)
    }
}

impl ClippedRays {
    #[inline(always)]
    fn set(&mut self, k: usize, ray: &ClippedRay) {
        for axis in 0..3 {
            self.start[axis][k] = ray.start[axis];
            self.direction[axis][k] = ray.direction[axis];
        }
        (self.t_start[k], self.t_length[k]) = (ray.t_start, ray.t_length);
        (self.cull[0][k], self.cull[1][k]) = (ray.cull[0], ray.cull[1]);
        self.end[k] = ray.end;
    }

    /// A ray, rounded for the walk.
    #[inline(always)]
    fn rounded(&self, placement: &Placement, k: usize) -> MapRay {
        let at = |of: &[[f64; PACKET]; 3]| DVec3::new(of[0][k], of[1][k], of[2][k]);
        let ray = ClippedRay {
            start: at(&self.start),
            direction: at(&self.direction),
            t_start: self.t_start[k],
            t_length: self.t_length[k],
            cull: [self.cull[0][k], self.cull[1][k]],
            end: self.end[k],
            valid: true,
        };
        placement.rounded(&ray, self.lift[k])
    }
}
