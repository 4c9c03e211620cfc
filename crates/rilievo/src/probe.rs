//! [`Probe`]: counters that stand beside the code they count, and cost nothing when off.
//!
//! There are two: `()`, which counts nothing, and [`Counters`]. What traces a surface is compiled once
//! for each, in this crate, behind functions without type parameters that take
//! `Option<&mut Counters>`, and counted at the portable level only: all levels give the same bits and
//! take the same steps. A client's generic code would otherwise compile the walks of all methods
//! and SIMD levels again, in each of its crates.

/// Told of every unit of work that tracing a ray takes. Sealed: see the head of the module.
pub trait Probe: sealed::Sealed {
    /// The counters, if this is more than `()`.
    fn counters(&mut self) -> Option<&mut Counters>;
    /// Nodes of a min-max pyramid or BVH whose children were tested.
    fn node(&mut self) {}
    /// Cells handed to the exact leaf.
    fn cell(&mut self) {}
    /// Steps taken through a distance map, or fixed marching steps.
    fn step(&mut self) {}
}

/// Counts nothing; every call compiles to nothing.
impl Probe for () {
    #[inline]
    fn counters(&mut self) -> Option<&mut Counters> {
        None
    }
}

mod sealed {
    /// Keeps the probes to those of this crate.
    pub trait Sealed {}
    impl Sealed for () {}
    impl Sealed for super::Counters {}
}

/// Work done for one ray or many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// See [`Probe::node`].
    pub nodes: u64,
    /// See [`Probe::cell`].
    pub cells: u64,
    /// See [`Probe::step`].
    pub steps: u64,
}

impl Counters {
    /// All work: nodes, cells and steps together.
    pub fn total(&self) -> u64 {
        self.nodes + self.cells + self.steps
    }
}

impl Probe for Counters {
    #[inline]
    fn counters(&mut self) -> Option<&mut Counters> {
        Some(self)
    }
    fn node(&mut self) {
        self.nodes += 1;
    }
    fn cell(&mut self) {
        self.cells += 1;
    }
    fn step(&mut self) {
        self.steps += 1;
    }
}
