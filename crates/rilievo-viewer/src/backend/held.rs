//! [`HeldMap`]: which maps lie on a GPU. They are the same maps as long as they are the same in memory.

use std::sync::Arc;

use rilievo::relief::{CubeRelief, Relief};
use rilievo::surface::Surface;
use rilievo_io::scene::KeptMap;

/// Heights that lie on a GPU.
pub(super) enum HeldMap {
    Map(Arc<Relief>),
    /// While it may be painted.
    Named(KeptMap),
    Cube(Arc<CubeRelief>),
}

impl HeldMap {
    /// Where it lies; nothing else does while it is held.
    fn address(&self) -> Option<usize> {
        match self {
            Self::Map(relief) => Some(Arc::as_ptr(relief).addr()),
            Self::Cube(cube) => Some(Arc::as_ptr(cube).addr()),
            Self::Named(_) => None,
        }
    }

    /// Whether both are one, and it is known which.
    pub fn is(&self, other: &Self) -> bool {
        self.address().is_some() && self.address() == other.address()
    }
}

/// The maps of surfaces, in their order, each once.
pub(super) fn maps_of(surfaces: &[Surface]) -> Vec<HeldMap> {
    let mut found: Vec<HeldMap> = Vec::new();
    for map in surfaces.iter().filter_map(map_of) {
        if !found.iter().any(|known| known.is(&map)) {
            found.push(map);
        }
    }
    found
}

fn map_of(surface: &Surface) -> Option<HeldMap> {
    match surface {
        Surface::Face(face) => Some(HeldMap::Map(Arc::clone(face.relief()))),
        Surface::ReliefMesh(mesh) => Some(HeldMap::Map(Arc::clone(mesh.relief()))),
        Surface::ReliefSphere(sphere) => Some(HeldMap::Cube(Arc::clone(sphere.relief()))),
        Surface::Instance(instance) => map_of(instance.prototype()),
        Surface::Moving(moving) => map_of(moving.prototype()),
        Surface::Quad(_) | Surface::Sphere(_) | Surface::Mesh(_) => None,
    }
}
