//! What a face does at a SIMD level, each compiled once: see [`crate::simd`].

use crate::probe::Probe;
use crate::ray::Ray;
use crate::simd::{Kernel, Lanes};

use super::map_ray::MapRay;
use super::trace::{Crossing, Met, Trace, walk_tiles};

/// One ray against one face.
pub(super) struct FirstCrossing<'a, P> {
    pub trace: Trace<'a>,
    pub ray: &'a Ray,
    pub probe: &'a mut P,
}

impl<P: Probe> Kernel for FirstCrossing<'_, P> {
    type Output = Option<Crossing>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Option<Crossing> {
        self.trace.first_crossing::<L, P>(self.ray, self.probe)
    }
}

/// At most [`super::packet::PACKET`] rays against one face.
pub(super) struct FirstCrossings<'a, P> {
    pub trace: Trace<'a>,
    pub rays: &'a [Ray],
    pub found: &'a mut [Option<Crossing>],
    pub probe: &'a mut P,
}

impl<P: Probe> Kernel for FirstCrossings<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.trace.first_crossings::<L, P>(self.rays, self.found, self.probe);
    }
}

/// Whether a face stops a ray, for exact methods.
pub(super) struct IsCrossed<'a, P> {
    pub trace: Trace<'a>,
    pub ray: &'a Ray,
    pub probe: &'a mut P,
}

impl<P: Probe> Kernel for IsCrossed<'_, P> {
    type Output = bool;

    #[inline(always)]
    fn run<L: Lanes>(self) -> bool {
        self.trace.is_crossed::<L, P>(self.ray, self.probe)
    }
}

/// [`walk_tiles`] as a call of its own: whole windows go without it, and it is large.
pub(super) struct Tiles<'a, P> {
    pub face: &'a Trace<'a>,
    pub ray: &'a MapRay,
    pub part: [f32; 2],
    pub probe: &'a mut P,
}

impl<P: Probe> Kernel for Tiles<'_, P> {
    type Output = Option<Met>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Option<Met> {
        walk_tiles::<L, P>(self.face, self.ray, self.part, self.probe)
    }
}
