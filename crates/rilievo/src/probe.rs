//! [`Probe`]: counters that stand beside the code they count, and cost nothing when off.

/// Told of every unit of work that tracing a ray takes.
pub trait Probe {
    /// Nodes of a min-max pyramid or BVH whose children were tested.
    fn node(&mut self) {}
    /// Cells handed to the exact leaf.
    fn cell(&mut self) {}
    /// Steps taken through a distance map, or fixed marching steps.
    fn step(&mut self) {}
}

/// Counts nothing; every call compiles to nothing.
impl Probe for () {}

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
