//! What a face does at a SIMD level, each compiled once: see [`crate::simd`].

use crate::probe::Probe;
use crate::ray::{Coherence, Ray};
use crate::simd::{Kernel, Lanes};

use super::batch::BatchOf;
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

/// A batch of rays against one face.
pub(super) struct FirstCrossings<'a, P> {
    pub trace: Trace<'a>,
    pub of: BatchOf<'a>,
    pub coherence: Coherence,
    pub found: &'a mut [Option<Crossing>],
    pub probe: &'a mut P,
}

impl<P: Probe> Kernel for FirstCrossings<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { trace, of, coherence, found, probe } = self;
        trace.first_crossings::<L, P>((of, coherence), found, probe);
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

/// Which rays of a batch a face stops, for exact methods.
pub(super) struct AreCrossed<'a, P> {
    pub trace: Trace<'a>,
    pub of: BatchOf<'a>,
    pub probe: &'a mut P,
}

impl<P: Probe> Kernel for AreCrossed<'_, P> {
    type Output = u16;

    #[inline(always)]
    fn run<L: Lanes>(self) -> u16 {
        self.trace.are_crossed::<L, P>(self.of, self.probe)
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
