//! [`Batch`]: up to sixteen rays made ready for the walk, and answered, side by side.
//!
//! What comes before a walk (into lattice space, cut to the face's box, rounded) and what comes after
//! it (the root in `f64`) is straight-line arithmetic, a third of a ray's time when it is alone: a
//! chain of dependent steps, quotients and a root among them. Here it is done for all rays in loops
//! over arrays, one array a number, one element a ray, which compilers turn into vectors. The
//! functions are those of the ray alone, so the bits are, too.
//!
//! In between, the rays are walked one after the other, or, if they start close together and go about
//! the same way, as a `packet`.

mod answer;
mod clipped;
mod lanes;

use crate::map::{HeightMap, Pyramid};
use crate::probe::Probe;
use crate::ray::{Origin, Part, Ray};
use crate::simd::{Lanes, WIDTH};

use super::leaf::{Crossings, LeafHit};
use super::map_ray::{AxisRay, MapRay, Window, larger, rounded_cull, smaller, surely_above};
use super::placement::Placement;
use super::shell::LatticeRay;
use super::walk::{TileFrame, Unfolding, walk_pyramid};
use clipped::ClippedRays;

pub(super) use lanes::{RayLanes, pair};

/// Most rays of a batch.
pub(crate) const BATCH: usize = WIDTH;

/// At most [`BATCH`] rays, and those of them that a face is to trace.
#[derive(Clone, Copy)]
pub(crate) struct BatchOf<'a> {
    pub rays: &'a [Ray],
    /// One bit a ray; others are left alone.
    pub set: u16,
    /// Index of the face in the world of the rays, by which it knows rays that leave it; none if
    /// there is no other surface.
    pub surface: Option<u32>,
}

impl<'a> BatchOf<'a> {
    /// Rays that know no other surface, all of them.
    pub fn all(rays: &'a [Ray]) -> Self {
        Self { rays, set: u16::MAX, surface: None }
    }

    /// Where a ray leaves the face, if it does.
    #[inline(always)]
    fn origin(&self, ray: &Ray) -> Option<Origin> {
        ray.from.filter(|from| self.surface.is_none_or(|surface| surface == from.surface))
    }

    /// The rays that are to be traced, as the face sees them, and their numbers.
    #[inline(always)]
    pub fn each(self, set: u16) -> impl Iterator<Item = (usize, Ray)> {
        let chosen = lanes_of(self.set & set).take_while(move |&k| k < self.rays.len());
        chosen.map(move |k| (k, Ray { from: self.origin(&self.rays[k]), ..self.rays[k] }))
    }
}

/// Rays against a face that shows its map in one run and has no walls.
pub(crate) struct Batch<'a> {
    pub(super) placement: &'a Placement,
    clipped: ClippedRays,
    pub(super) lanes: RayLanes,
    /// Rays that run over the map within its heights. The lanes of others mean nothing.
    pub worth: u16,
    /// Rays that leave a wall, whose starts are put on it one by one: not in the batch.
    pub from_walls: u16,
}

/// What the rays of a batch met: one element a ray.
#[derive(Default)]
pub(crate) struct BatchHits {
    pub(super) s: [f32; BATCH],
    /// Forward cells, each in its own ray's frame.
    pub(super) cell: [[i32; 2]; BATCH],
    /// Rays that met the surface, and those of them that came from above.
    pub(super) any: u16,
    pub(super) from_above: u16,
}

impl BatchHits {
    #[inline(always)]
    pub(super) fn put(&mut self, lane: usize, hit: &LeafHit) {
        self.s[lane] = hit.s;
        self.cell[lane] = hit.cell;
        self.any |= 1 << lane;
        self.from_above |= u16::from(hit.from_above) << lane;
    }
}

impl<'a> Batch<'a> {
    /// No rays yet. Filled in place: the arrays are large to move.
    #[inline(always)]
    pub fn new(placement: &'a Placement) -> Self {
        let (clipped, lanes) = (ClippedRays::new(), RayLanes::new());
        Self { placement, clipped, lanes, worth: 0, from_walls: 0 }
    }

    /// Takes in rays.
    #[inline(always)]
    pub fn fill(&mut self, unfolding: [Unfolding; 2], of: &BatchOf<'_>) {
        let valid = self.clip(of);
        self.worth = valid & self.round(unfolding);
    }

    /// Clips the rays to the face's box; one bit for each that meets it.
    #[inline(always)]
    fn clip(&mut self, of: &BatchOf<'_>) -> u16 {
        let mut world = [[[0.0; BATCH]; 3]; 2];
        // Lanes without a ray end before they start.
        let mut t_max = [-1.0; BATCH];
        for (k, ray) in of.rays.iter().take(BATCH).enumerate() {
            let [origin, direction] = &mut world;
            for axis in 0..3 {
                origin[axis][k] = ray.origin[axis];
                direction[axis][k] = ray.direction[axis];
            }
            t_max[k] = if of.set >> k & 1 == 1 { ray.t_max } else { -1.0 };
            if let Some(from) = of.origin(ray) {
                self.clipped.lift[k] = self.placement.lift(from.front);
                if matches!(from.part, Part::Wall(_)) {
                    self.from_walls |= 1 << k;
                    t_max[k] = -1.0;
                }
            }
        }
        self.from_walls &= of.set;
        let shell = self.placement.shell(false);
        let to = &mut self.clipped;
        let mut valid = [0u64; BATCH];
        for k in 0..BATCH {
            let [origin, direction] = &world;
            let (origin, direction) = self
                .placement
                .lattice_from_world(clipped::at(origin, k), clipped::at(direction, k));
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
        // Not a loop: the compiler must see that the arrays of an axis are apart.
        let x = self.round_axis(0, unfolding[0]);
        let y = self.round_axis(1, unfolding[1]);
        let (from, to, range) = (&self.clipped, &mut self.lanes, self.placement.range());
        let mut meets = [0u32; BATCH];
        for k in 0..BATCH {
            let enter = larger(larger(x[0][k], y[0][k]), 0.0);
            let leave = smaller(smaller(x[1][k], y[1][k]), 1.0);
            let cull = rounded_cull([from.cull[0][k], from.cull[1][k]]);
            let (first, last) = (larger(enter, cull[0]), smaller(leave, cull[1]));
            (to.cull[0][k], to.cull[1][k]) = (cull[0], cull[1]);
            (to.part[0][k], to.part[1][k]) = (first, last);
            to.oz[k] = (from.start[2][k] + from.lift[k]) as f32;
            to.dz[k] = from.direction[2][k] as f32;
            to.below[k] = u32::from(!surely_above(from.start[2][k], from.lift[k], range));
            meets[k] = u32::from((enter < leave) & (first < last));
        }
        let mut bits = 0;
        for (k, meets) in meets.into_iter().enumerate() {
            bits |= (meets as u16) << k;
        }
        bits
    }

    /// Rounds one axis; the parameters at which the rays enter and leave the window along it.
    #[inline(always)]
    fn round_axis(&mut self, axis: usize, unfolding: Unfolding) -> [[f32; BATCH]; 2] {
        let Window { lo, hi } = self.placement.window;
        let (start, direction) = (&self.clipped.start[axis], &self.clipped.direction[axis]);
        let to = &mut self.lanes;
        let mut spans = [[0.0; BATCH]; 2];
        for k in 0..BATCH {
            let ray = AxisRay::new(start[k], direction[k], [lo[axis], hi[axis]]);
            let (origin, turn) = unfolding.mirrored(ray.base, ray.backward);
            to.o[axis][k] = ray.o;
            to.d[axis][k] = ray.d;
            to.inv[axis][k] = ray.inv;
            to.lo[axis][k] = ray.lo;
            to.hi[axis][k] = ray.hi;
            to.origin[axis][k] = origin;
            to.turn[axis][k] = turn;
            to.base[axis][k] = ray.base;
            to.backward[axis][k] = -i32::from(ray.backward);
            [spans[0][k], spans[1][k]] = ray.span();
        }
        spans
    }

    /// Largest magnitude of a raw height of the map.
    #[inline(always)]
    pub fn size(&self) -> f32 {
        self.placement.size()
    }

    /// A ray, and its frame.
    #[inline(always)]
    pub fn ray(&self, k: usize) -> (MapRay, TileFrame) {
        let (lanes, two) = (&self.lanes, |of: &[[f32; BATCH]; 2]| [of[0][k], of[1][k]]);
        let whole = |of: &[[i32; BATCH]; 2]| [of[0][k], of[1][k]];
        let ray = MapRay {
            o: two(&lanes.o),
            d: two(&lanes.d),
            inv: two(&lanes.inv),
            oz: lanes.oz[k],
            dz: lanes.dz[k],
            base: whole(&lanes.base),
            backward: [lanes.backward[0][k] != 0, lanes.backward[1][k] != 0],
            lo: two(&lanes.lo),
            hi: two(&lanes.hi),
            cull: two(&lanes.cull),
            end: self.clipped.end[k] as f32,
            size: self.size(),
            above: lanes.below[k] == 0,
            exact: self.clipped.exact(k),
        };
        let frame = TileFrame {
            origin: whole(&lanes.origin),
            turn: whole(&lanes.turn),
            lo: ray.lo,
            hi: ray.hi,
            enter: lanes.part[0][k],
            leave: lanes.part[1][k],
        };
        (ray, frame)
    }

    /// Finds the first admitted crossing of each ray of a set, one after the other.
    #[inline(always)]
    pub fn walk_each<L: Lanes, P: Probe>(
        &self,
        (map, pyramid): (&HeightMap, &Pyramid),
        set: u16,
        (admit, hits): (Crossings, &mut BatchHits),
        probe: &mut P,
    ) {
        for k in lanes_of(self.worth & set) {
            let (ray, frame) = self.ray(k);
            if let Some(hit) = walk_pyramid::<L, P>((map, pyramid), &ray, &frame, admit, probe) {
                hits.put(k, &hit);
            }
        }
    }
}

/// The lanes whose bits are set, in order.
#[inline(always)]
pub(super) fn lanes_of(mut bits: u16) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = bits.trailing_zeros() as usize;
        (bits != 0).then(|| {
            bits &= bits - 1;
            lane % BATCH
        })
    })
}
