//! [`RayLanes`]: the rays of a batch as the walk sees them, one array a number.

use crate::simd::{Lanes, WIDTH};

use super::super::walk::LaneRay;

/// Rays as the walk sees them.
pub(in super::super) struct RayLanes {
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
    /// Mirrored cell of each ray's forward cell 0.
    pub origin: [[i32; WIDTH]; 2],
    pub turn: [[i32; WIDTH]; 2],
    /// Unfolded cell of forward cell 0, and -1 where cells are counted backward, else 0.
    pub base: [[i32; WIDTH]; 2],
    pub backward: [[i32; WIDTH]; 2],
    /// 1 where the ray may start below the surface.
    pub below: [u32; WIDTH],
}

impl RayLanes {
    /// No rays yet.
    #[inline(always)]
    pub fn new() -> Self {
        let none = [0.0; WIDTH];
        Self {
            o: [none; 2],
            d: [none; 2],
            inv: [none; 2],
            lo: [none; 2],
            hi: [none; 2],
            oz: none,
            dz: none,
            cull: [none; 2],
            part: [none; 2],
            origin: [[0; WIDTH]; 2],
            turn: [[0; WIDTH]; 2],
            base: [[0; WIDTH]; 2],
            backward: [[0; WIDTH]; 2],
            below: [0; WIDTH],
        }
    }

    /// Whether two rays go the same way, and their cells lie close enough for exact differences.
    #[inline(always)]
    pub fn go_together(&self, first: usize, k: usize) -> bool {
        let same = |axis: usize| self.turn[axis][first] == self.turn[axis][k];
        let near = |axis: usize| {
            let apart = i64::from(self.origin[axis][first]) - i64::from(self.origin[axis][k]);
            apart.abs() < 1 << 22
        };
        same(0) & same(1) & near(0) & near(1)
    }

    /// Fills the lanes that are not live with ray `first`.
    #[inline(always)]
    pub fn repeat(&mut self, first: usize, live: u16) {
        if live == u16::MAX {
            return;
        }
        let live: [bool; WIDTH] = std::array::from_fn(|k| live >> k & 1 == 1);
        for axis in 0..2 {
            repeat(&mut self.o[axis], first, &live);
            repeat(&mut self.d[axis], first, &live);
            repeat(&mut self.inv[axis], first, &live);
            repeat(&mut self.lo[axis], first, &live);
            repeat(&mut self.hi[axis], first, &live);
            repeat(&mut self.cull[axis], first, &live);
            repeat(&mut self.part[axis], first, &live);
            repeat(&mut self.origin[axis], first, &live);
        }
        repeat(&mut self.oz, first, &live);
        repeat(&mut self.dz, first, &live);
        repeat(&mut self.below, first, &live);
    }

    /// The unfolded cell behind a forward cell of a ray.
    #[inline(always)]
    pub fn unfolded(&self, k: usize, cell: [i32; 2]) -> [i32; 2] {
        let at = |axis: usize| self.base[axis][k] + (cell[axis] ^ self.backward[axis][k]);
        [at(0), at(1)]
    }

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

    /// One ray in all lanes.
    #[inline(always)]
    pub fn alone<L: Lanes>(&self, k: usize) -> LaneRay<L> {
        LaneRay {
            o: splat_pair(&self.o, k),
            d: splat_pair(&self.d, k),
            inv: splat_pair(&self.inv, k),
            lo: splat_pair(&self.lo, k),
            hi: splat_pair(&self.hi, k),
            oz: L::splat(self.oz[k]),
            dz: L::splat(self.dz[k]),
            cull: splat_pair(&self.cull, k),
        }
    }
}

/// Two numbers of every ray.
#[inline(always)]
pub(in super::super) fn pair<L: Lanes>(from: &[[f32; WIDTH]; 2]) -> [L; 2] {
    [L::load(&from[0]), L::load(&from[1])]
}

/// Two numbers of one ray.
#[inline(always)]
fn splat_pair<L: Lanes>(from: &[[f32; WIDTH]; 2], k: usize) -> [L; 2] {
    [L::splat(from[0][k]), L::splat(from[1][k])]
}

/// Fills the lanes that are not live with that of ray `first`.
#[inline(always)]
fn repeat<T: Copy>(of: &mut [T; WIDTH], first: usize, live: &[bool; WIDTH]) {
    let value = of[first];
    for k in 0..WIDTH {
        of[k] = if live[k] { of[k] } else { value };
    }
}
