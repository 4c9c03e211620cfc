//! [`FirstHits`]: what traces camera rays in place of [`World`](rilievo::surface::World): a GPU, for instance.
//!
//! The rays of many tiles go out at a time, the same that a render without it traces; what comes back is turned
//! into colour and layers by the same code, which traces all further rays in the world. So two pictures differ
//! only where first hits do.

use rilievo::{Hit, Ray};

/// The nearest hits of many rays, one answer a ray, in order; or why there are none. Asked by one thread at a time.
pub type FirstHits<'a> = dyn Fn(&[Ray]) -> Result<Vec<Traced>, String> + Sync + 'a;

/// Rays that go out at a time, unless a tile has more.
pub(crate) const RAYS: u64 = 1 << 19;

/// The answer to one ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traced {
    /// The nearest hit.
    pub hit: Option<Hit>,
    /// Nodes and blocks of cells looked at.
    pub work: u64,
}
