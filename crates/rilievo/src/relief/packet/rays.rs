//! [`PacketRays`]: the rays of a packet, side by side.

use crate::simd::{Lanes, WIDTH};

use super::super::map_ray::{MapRay, larger, smaller};
use super::super::walk::{LaneRay, TileFrame};

/// Rays that run through one window in the same mirrored directions. Lanes without a ray repeat the
/// first, and are not live.
pub(crate) struct PacketRays {
    rays: [MapRay; WIDTH],
    frames: [TileFrame; WIDTH],
    pub(super) lanes: RayLanes,
    live: u16,
}

/// Numbers of the rays, one array a number.
pub(super) struct RayLanes {
    pub o: [[f32; WIDTH]; 2],
    pub d: [[f32; WIDTH]; 2],
    pub inv: [[f32; WIDTH]; 2],
    pub lo: [[f32; WIDTH]; 2],
    pub hi: [[f32; WIDTH]; 2],
    pub oz: [f32; WIDTH],
    pub dz: [f32; WIDTH],
    pub cull: [[f32; WIDTH]; 2],
    /// The part worth walking.
    pub part: [[f32; WIDTH]; 2],
    /// Added to forward cells of the first ray's frame to give those of each ray's own; integers.
    pub shift: [[f32; WIDTH]; 2],
}

impl PacketRays {
    /// A packet of which `ray` is lane `lane`.
    #[inline(always)]
    pub fn new(lane: usize, ray: &MapRay, frame: &TileFrame) -> Self {
        let pair = |[a, b]: [f32; 2]| [[a; WIDTH], [b; WIDTH]];
        let lanes = RayLanes {
            o: pair(ray.o),
            d: pair(ray.d),
            inv: pair(ray.inv),
            lo: pair(frame.lo),
            hi: pair(frame.hi),
            oz: [ray.oz; WIDTH],
            dz: [ray.dz; WIDTH],
            cull: pair(ray.cull),
            part: pair(part(ray, frame)),
            shift: [[0.0; WIDTH]; 2],
        };
        Self { rays: [*ray; WIDTH], frames: [*frame; WIDTH], lanes, live: 1 << lane }
    }

    /// Takes one more ray into a lane; not if it goes another way than the first.
    #[inline(always)]
    #[must_use]
    pub fn take(&mut self, lane: usize, ray: &MapRay, frame: &TileFrame) -> bool {
        let first = self.frame();
        // Farther apart than this, differences of cells are not exact any more.
        let near = |axis: usize| {
            (i64::from(first.origin[axis]) - i64::from(frame.origin[axis])).abs() < 1 << 22
        };
        if frame.turn != first.turn || !near(0) || !near(1) {
            return false;
        }
        let to = &mut self.lanes;
        let [enter, leave] = part(ray, frame);
        for axis in 0..2 {
            to.o[axis][lane] = ray.o[axis];
            to.d[axis][lane] = ray.d[axis];
            to.inv[axis][lane] = ray.inv[axis];
            to.lo[axis][lane] = frame.lo[axis];
            to.hi[axis][lane] = frame.hi[axis];
            to.cull[axis][lane] = ray.cull[axis];
            to.shift[axis][lane] = (self.frames[0].origin[axis] - frame.origin[axis]) as f32;
        }
        (to.part[0][lane], to.part[1][lane]) = (enter, leave);
        (to.oz[lane], to.dz[lane]) = (ray.oz, ray.dz);
        self.rays[lane] = *ray;
        self.frames[lane] = *frame;
        self.live |= 1 << lane;
        true
    }

    /// The frame in which the packet counts cells: its first ray's.
    #[inline(always)]
    pub fn frame(&self) -> &TileFrame {
        &self.frames[0]
    }

    /// Lanes that hold a ray.
    #[inline(always)]
    pub fn live(&self) -> u16 {
        self.live
    }

    /// Whether any ray may start below the surface.
    #[inline(always)]
    pub fn any_may_be_below(&self) -> bool {
        self.rays.iter().any(|ray| !ray.above)
    }

    /// The ray of a lane.
    #[inline(always)]
    pub fn ray(&self, lane: usize) -> (&MapRay, &TileFrame) {
        (&self.rays[lane], &self.frames[lane])
    }
}

impl RayLanes {
    /// The rays in lanes, as the leaf wants them.
    #[inline(always)]
    pub fn load<L: Lanes>(&self) -> LaneRay<L> {
        LaneRay {
            o: pair(&self.o),
            d: pair(&self.d),
            inv: pair(&self.inv),
            lo: pair(&self.lo),
            hi: pair(&self.hi),
            oz: L::load(&self.oz),
            dz: L::load(&self.dz),
            cull: pair(&self.cull),
        }
    }
}

/// Two numbers of every ray.
#[inline(always)]
pub(super) fn pair<L: Lanes>(from: &[[f32; WIDTH]; 2]) -> [L; 2] {
    [L::load(&from[0]), L::load(&from[1])]
}

/// The part of a ray worth walking.
#[inline(always)]
fn part(ray: &MapRay, frame: &TileFrame) -> [f32; 2] {
    [larger(frame.enter, ray.cull[0]), smaller(frame.leave, ray.cull[1])]
}
