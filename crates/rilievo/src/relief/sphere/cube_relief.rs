//! [`CubeRelief`]: heights and bounds of the six faces around a sphere.

use std::sync::Arc;

use crate::map::{
    CubeFace, CubeHeights, CubeHeightsError, CubeMipLevel, DistanceKind, DistanceMap,
    DistanceMapError, DistanceOptions, HeightMap, Layout, LostSlopes, Metric, Pyramid, Tiling,
};
use crate::relief::Relief;

/// A map resampled onto the faces around a sphere, with its bounds; one serves any number of spheres.
#[derive(Clone, Debug)]
pub struct CubeRelief {
    cells: u32,
    tiling: Tiling,
    faces: [Relief; 6],
}

impl CubeRelief {
    /// Resamples an equirectangular map as [`CubeHeights::resample`] does and builds the pyramids
    /// in the default layout.
    ///
    /// # Errors
    /// [`CubeHeightsError`] if the map is too large or its tiling does not close.
    pub fn new(map: &HeightMap, tiling: Tiling) -> Result<Arc<Self>, CubeHeightsError> {
        Ok(Arc::new(Self::with_layout(CubeHeights::resample(map, tiling)?, Layout::Default)))
    }

    /// Builds the pyramids of resampled heights in a layout.
    pub fn with_layout(heights: CubeHeights, layout: Layout) -> Self {
        let (cells, tiling) = (heights.cells(), heights.tiling());
        let faces = heights.into_faces().map(|face| Relief::with_layout(face, layout));
        Self { cells, tiling, faces }
    }

    /// What stands for it where less is seen, finest first, with what each leaves out.
    pub fn levels(&self) -> Vec<(Self, [LostSlopes; 6])> {
        let layout = self.faces[0].pyramid().layout();
        let faces = CubeFace::ALL.map(|face| self.face(face).heights());
        CubeMipLevel::chain(faces, self.tiling)
            .into_iter()
            .map(|CubeMipLevel { heights, lost }| (Self::with_layout(heights, layout), lost))
            .collect()
    }

    /// Adds a distance map for each face, in place of any other of its kind. Each knows the cells of
    /// its own face only: a ray asks face by face.
    ///
    /// # Errors
    /// [`DistanceMapError`] for a size or a metric that cannot be used.
    pub fn with_distances(
        mut self,
        kind: DistanceKind,
        options: &DistanceOptions,
    ) -> Result<Self, DistanceMapError> {
        let [a, b, c, d, e, f] = self.faces.map(|face| {
            let map = DistanceMap::from_height(face.heights(), kind, options)?;
            Ok(face.with_own_distance(map))
        });
        self.faces = [a?, b?, c?, d?, e?, f?];
        Ok(self)
    }

    /// The metric in which distance maps serve a sphere of this radius best: that of the middle of a
    /// face. `scale` is the displacement of height 1, in the same unit.
    pub fn metric(&self, radius: f64, scale: f64) -> Metric {
        let cell = 2.0 * radius / f64::from(self.cells);
        Metric { x: cell, y: cell, z: (scale * self.unit()).abs() }
    }

    /// Cells along a side of a face.
    #[inline]
    pub fn cells(&self) -> u32 {
        self.cells
    }

    /// How the map lies on a sphere.
    #[inline]
    pub fn tiling(&self) -> Tiling {
        self.tiling
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
    pub fn predicted_bytes(map: &HeightMap, tiling: Tiling, layout: Layout) -> (u64, u64) {
        let cells = CubeHeights::least_cells(map, tiling);
        (
            CubeHeights::predicted_bytes(map, tiling),
            6 * Pyramid::predicted_bytes([cells; 2], layout),
        )
    }
}
