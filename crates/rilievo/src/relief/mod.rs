//! Relief surfaces: a base surface, a height map, and a method that walks rays through the shell
//! between the lowest and the highest offset.
//!
//! **The surface.** `S(u, v) = P(u, v) + offset(u, v) N` with
//! `offset = scale (H(u tile + shift) - zero)` and H bilinear between samples. Exact means: a
//! method reports the hit of the brute force over every cell, for every ray. What follows is about
//! parallelograms; [`ReliefSphere`] has a base of its own (`sphere`).
//!
//! | method | looks at | needs | exact |
//! |---|---|---|---|
//! | [`Method::Dda`] | every cell under the ray | nothing | yes |
//! | [`Method::Pyramid`] | blocks whose bounds the ray meets | min-max pyramid | yes |
//! | [`Method::Distance`] | cells where no safe step leads on | box distance map | yes |
//! | [`Method::DistanceCorrected`] | the same | exact node distances | yes |
//! | [`Method::DistancePublished`] | points a distance apart | texel-point distances | no |
//! | [`Method::March`] | points a fixed step apart | nothing | no |
//!
//! **One arithmetic.** The path of a ray: world (`f64`) -> lattice space (`f64`, `placement`,
//! `shell`) -> forward frame (`f32`, `map_ray`) -> tiles (`tile`, `trace`) -> a method's walk (`walk`,
//! `cell_walk`, `distance_walk`) -> the leaf (`leaf`) -> refined root (`f64`, `refine`) -> hit. Only
//! the walk differs between exact methods; the leaf is a function of ray and cell alone. So they
//! agree bit for bit as soon as each shows the leaf every cell in which it would report a root, in
//! order: the proofs stand at the heads of the walks.

mod approximate;
mod batch;
mod cell_walk;
mod corridor;
mod distance_walk;
mod face;
mod kernels;
mod lattice_frame;
mod leaf;
mod map_ray;
mod mesh;
mod method;
mod options;
mod packet;
mod placement;
mod refine;
mod shading;
mod shell;
mod sphere;
mod tile;
mod together;
mod trace;
mod walk;
mod walls;

use std::ops::Range;

use crate::map::{
    DistanceKind, DistanceMap, HeightMap, HeightMapError, Layout, LostSlopes, MipLevel, Pyramid,
    RowMut, Samples,
};

pub(crate) use batch::{BATCH, BatchOf};

pub use approximate::{MARCH_STEPS, PUBLISHED_EPSILON, PUBLISHED_STEPS};
pub use face::{FaceError, ReliefFace};
pub use lattice_frame::LatticeFrame;
pub use mesh::{
    Edges, MeshBeside, MeshCrossing, MeshFrame, MeshOptions, MeshPart, MeshPrism, MeshReport,
    MeshWall, PrismFrame, ReliefMesh, ReliefMeshError, SeamSteps,
};
pub use method::{Method, UnknownMethod};
pub use options::{Displacement, FaceOptions, ShadingNormals};
pub use sphere::{
    CubeRelief, ReliefSphere, ReliefSphereError, SphereCrossing, SphereFrame, SphereOptions,
};
pub use trace::Crossing;

/// A height map with what was derived from it; one relief serves any number of faces.
#[derive(Clone, Debug)]
pub struct Relief {
    heights: HeightMap,
    pyramid: Pyramid,
    /// At most one of each kind.
    distances: Vec<DistanceMap>,
}

/// Why a derived map was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReliefError {
    /// The distance map was made from a height map of another shape.
    #[error("the distance map is for {found:?} cells, the height map has {expected:?}")]
    WrongCells {
        /// Stored cells the distance map was made for.
        found: [u32; 2],
        /// Stored cells of the height map.
        expected: [u32; 2],
    },
    /// The distance map was made for another range of heights.
    #[error("the distance map is for heights {found:?}, the height map has {expected:?}")]
    WrongRange {
        /// Raw range the distance map was made for.
        found: (f32, f32),
        /// Raw range of the height map.
        expected: (f32, f32),
    },
}

impl Relief {
    /// Builds the pyramid of a height map in the default layout.
    pub fn new(heights: HeightMap) -> Self {
        Self::with_layout(heights, Layout::Default)
    }

    /// Builds the pyramid of a height map in a layout.
    pub fn with_layout(heights: HeightMap, layout: Layout) -> Self {
        let pyramid = Pyramid::build_as(&heights, layout);
        Self { heights, pyramid, distances: Vec::new() }
    }

    /// What stands for it where less is seen, finest first, with what each leaves out. No level has distance
    /// maps.
    pub fn levels(&self) -> Vec<(Self, LostSlopes)> {
        let layout = self.pyramid.layout();
        MipLevel::chain(&self.heights)
            .into_iter()
            .map(MipLevel::into_parts)
            .map(|(heights, lost)| (Self::with_layout(heights, layout), lost))
            .collect()
    }

    /// Adds a distance map, in place of any other of its kind.
    ///
    /// # Errors
    /// [`ReliefError`] if the map was made for other cells or another range of heights.
    pub fn with_distance(self, map: DistanceMap) -> Result<Self, ReliefError> {
        let expected = self.pyramid.cells();
        if map.cells() != expected {
            return Err(ReliefError::WrongCells { found: map.cells(), expected });
        }
        let expected = self.heights.raw_range();
        if map.raw_range() != expected {
            return Err(ReliefError::WrongRange { found: map.raw_range(), expected });
        }
        Ok(self.with_own_distance(map))
    }

    /// Adds a distance map that was made from these heights.
    fn with_own_distance(mut self, map: DistanceMap) -> Self {
        self.distances.retain(|m| m.kind() != map.kind());
        self.distances.push(map.laid_on(&self.heights));
        self
    }

    /// Changes the samples of columns `x` and rows `y` as [`HeightMap::edit`] does, and follows with
    /// the pyramid, of which only what lies above the rectangle is made anew: it equals that of a
    /// new relief, and so do all hits. Float heights whose range changes cost a full build.
    /// Distance maps are dropped: no part of one can be kept.
    ///
    /// Faces share their relief and hold bounds that depend on its range, so an edit needs a relief
    /// that no face holds. A live edit goes in three steps: take what the faces were made of (their
    /// options) and drop them, edit through [`Arc::get_mut`](std::sync::Arc::get_mut), make the
    /// faces again, which costs nothing to speak of.
    /// [`Arc::make_mut`](std::sync::Arc::make_mut) works while faces are in use, for instance by a
    /// render that is under way, but copies heights and pyramid first;
    /// [`ReliefFace::with_relief`] then moves a face to the edited relief.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use rilievo::map::{HeightMap, Lattice, RowMut, Samples, Wrap};
    /// use rilievo::relief::Relief;
    ///
    /// let samples = Samples::U16(vec![0; 256 * 256]);
    /// let map = HeightMap::new(256, 256, samples, Lattice::Texel, Wrap::Repeat)?;
    /// let mut relief = Arc::new(Relief::new(map));
    /// let mine = Arc::get_mut(&mut relief).expect("no face holds it");
    /// mine.edit([100..164, 10..74], |_row, samples| {
    ///     if let RowMut::U16(codes) = samples {
    ///         codes.fill(40_000);
    ///     }
    /// })?;
    /// assert_eq!(relief.heights().raw_range(), (0.0, 40_000.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`HeightMap::edit`]; the relief is then as it was.
    pub fn edit(
        &mut self,
        [x, y]: [Range<u32>; 2],
        change: impl FnMut(u32, RowMut<'_>),
    ) -> Result<(), HeightMapError> {
        let loose = self.heights.edit_samples([x.clone(), y.clone()], change)?;
        let codes = matches!(self.heights.samples(), Samples::U16(_));
        if loose && !codes {
            self.heights.search_range();
        }
        self.pyramid.update(&self.heights, [x, y]);
        if loose && codes {
            // Codes of `u16` heights are the heights.
            let [low, high] = self.pyramid.code_range();
            self.heights.set_range((f32::from(low), f32::from(high)));
        }
        self.distances.clear();
        Ok(())
    }

    /// The height map.
    #[inline]
    pub fn heights(&self) -> &HeightMap {
        &self.heights
    }

    /// The min-max pyramid.
    #[inline]
    pub fn pyramid(&self) -> &Pyramid {
        &self.pyramid
    }

    /// The distance map of a kind, if it was added.
    #[inline]
    pub fn distance(&self, kind: DistanceKind) -> Option<&DistanceMap> {
        self.distances.iter().find(|m| m.kind() == kind)
    }

    /// The distance map that a method walks, if it was added.
    #[inline]
    fn walked_by(&self, method: Method) -> Option<&DistanceMap> {
        self.distance(method.distance_kind()?)
    }

    /// Bytes held by the heights and by what was derived from them.
    pub fn bytes(&self) -> (u64, u64) {
        let distances: u64 = self.distances.iter().map(DistanceMap::bytes).sum();
        (self.heights.bytes(), self.pyramid.bytes() + distances)
    }
}
