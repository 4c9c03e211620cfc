//! How a scene is loaded, and what its loading tells on the way.

use rilievo::SimdLevel;
use rilievo::map::{
    DistanceKind, DistanceMap, DistanceMapError, DistanceOptions, HeightMap, Layout,
};
use rilievo::relief::Method;
use rilievo_render::Integrator;

use super::cache::Cache;
use crate::limits::Limits;

/// How a scene is loaded.
#[derive(Clone, Copy)]
pub struct LoadOptions<'a> {
    /// What each file may need.
    pub limits: Limits,
    /// Walks every relief, whatever the scene says.
    pub method: Option<Method>,
    /// Stores the bounds of every map so, whatever the scene says.
    pub layout: Option<Layout>,
    /// Renders so, whatever the scene says: some files are only read for some integrators.
    pub integrator: Option<Integrator>,
    /// Bytes that textures may take, whatever the scene says; what does not fit lies in a temporary
    /// file, and the picture is the same.
    pub texture_memory: Option<u64>,
    /// Vector instructions of the walk.
    pub simd: SimdLevel,
    /// Measures how far the maps of spheres are off after resampling; takes about as long as that.
    pub resampling_error: bool,
    /// What earlier loadings left, and what this one leaves.
    pub cache: Option<&'a Cache>,
    /// Told of every distance map before it is built: that may take a while.
    pub building: &'a dyn Fn(&DistanceBuild<'_>),
    /// Builds the distance maps of faces and meshes: what [`DistanceMap::from_height`] builds, however it does so.
    pub build_distances: &'a BuildDistances<'a>,
}

/// The distance map of some heights.
pub type BuildDistances<'a> = dyn Fn(&HeightMap, DistanceKind, &DistanceOptions) -> Result<DistanceMap, DistanceMapError>
    + 'a;

impl Default for LoadOptions<'_> {
    /// The scene's own methods and layouts, default limits, the fastest
    /// instructions, nobody told, distance maps built by the CPU.
    fn default() -> Self {
        Self {
            limits: Limits::default(),
            method: None,
            layout: None,
            integrator: None,
            texture_memory: None,
            simd: SimdLevel::detect(),
            resampling_error: false,
            cache: None,
            building: &|_| {},
            build_distances: &DistanceMap::from_height,
        }
    }
}

/// A distance map that is about to be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceBuild<'a> {
    /// The name of its height map in the scene.
    pub map: &'a str,
    /// Its kind.
    pub kind: DistanceKind,
    /// Voxels or nodes along x, y and z.
    pub size: [u32; 3],
    /// Stored cells of the height map along x and y.
    pub cells: [u32; 2],
}
