//! [`CubeRelief`]: heights and bounds of the six faces around a sphere.

use std::sync::Arc;

use crate::map::{CubeFace, CubeHeights, CubeHeightsError, HeightMap, Layout, Pyramid};
use crate::relief::Relief;

/// A map resampled onto the faces around a sphere, with its bounds; one serves any number of spheres.
#[derive(Clone, Debug)]
pub struct CubeRelief {
    cells: u32,
    faces: [Relief; 6],
}

impl CubeRelief {
    /// Resamples an equirectangular map as [`CubeHeights::resample`] does and builds the pyramids
    /// in the default layout.
    ///
    /// # Errors
    /// [`CubeHeightsError`] if the map is too large.
    pub fn new(map: &HeightMap) -> Result<Arc<Self>, CubeHeightsError> {
        Ok(Arc::new(Self::with_layout(CubeHeights::resample(map)?, Layout::Default)))
    }

    /// Builds the pyramids of resampled heights in a layout.
    pub fn with_layout(heights: CubeHeights, layout: Layout) -> Self {
        let cells = heights.cells();
        let faces = heights.into_faces().map(|face| Relief::with_layout(face, layout));
        Self { cells, faces }
    }

    /// Cells along a side of a face.
    #[inline]
    pub fn cells(&self) -> u32 {
        self.cells
    }

    /// Heights and bounds of a face.
    #[inline]
    pub fn face(&self, face: CubeFace) -> &Relief {
        &self.faces[face.index()]
    }

    /// Lowest and highest raw sample of all faces.
    pub fn raw_range(&self) -> (f32, f32) {
        let ranges = self.faces.iter().map(|face| face.heights().raw_range());
        ranges.fold((f32::INFINITY, f32::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// Height of one raw unit.
    #[inline]
    pub fn unit(&self) -> f64 {
        self.faces[0].heights().unit()
    }

    /// Bytes held by the heights and by their bounds.
    pub fn bytes(&self) -> (u64, u64) {
        let bytes = self.faces.iter().map(Relief::bytes);
        bytes.fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1))
    }

    /// Bytes that heights and bounds of a map take in a layout.
    pub fn predicted_bytes(map: &HeightMap, layout: Layout) -> (u64, u64) {
        let cells = CubeHeights::least_cells(map);
        (CubeHeights::predicted_bytes(map), 6 * Pyramid::predicted_bytes([cells; 2], layout))
    }
}
