//! [`GpuBytes`]: what was brought to a GPU.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::device::Gpu;

/// Bytes that were brought to a GPU since it was opened, but for rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GpuBytes {
    /// Of maps: heights, distances, bounds that are not made there.
    pub maps: u64,
    /// Of surfaces, trees, materials and lights.
    pub scenes: u64,
}

/// Counts them.
#[derive(Default)]
pub(crate) struct Traffic {
    maps: AtomicU64,
    scenes: AtomicU64,
}

impl Traffic {
    pub fn add_maps(&self, bytes: usize) {
        self.maps.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    pub fn add_scene(&self, bytes: usize) {
        self.scenes.fetch_add(bytes as u64, Ordering::Relaxed);
    }
}

impl Gpu {
    /// What was brought over so far.
    pub fn bytes_brought(&self) -> GpuBytes {
        let Traffic { maps, scenes } = &self.traffic;
        GpuBytes { maps: maps.load(Ordering::Relaxed), scenes: scenes.load(Ordering::Relaxed) }
    }
}
