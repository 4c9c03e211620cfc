//! What a user says about a face besides its corners and its map.

use std::sync::Arc;

use crate::map::NormalMap;
use crate::simd::SimdLevel;

use super::method::Method;

/// How a height map is laid on a face: `offset(u, v) = scale * (H(u * tile + shift) - zero)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// Scene units per unit of height; may be negative, not 0.
    pub scale: f64,
    /// The height that stays on the face.
    pub zero: f64,
    /// Repetitions of the map along u and v; positive.
    pub tile: [f64; 2],
    /// Added to the map parameters after tiling.
    pub shift: [f64; 2],
}

impl Default for Displacement {
    fn default() -> Self {
        Self { scale: 1.0, zero: 0.0, tile: [1.0; 2], shift: [0.0; 2] }
    }
}

impl Displacement {
    /// The first number out of its range: its key, the number, what is allowed.
    pub(super) fn fault(&self) -> Option<(&'static str, f64, &'static str)> {
        if !self.scale.is_finite() || self.scale == 0.0 {
            return Some(("scale", self.scale, "finite and not 0"));
        }
        if !self.zero.is_finite() {
            return Some(("zero", self.zero, "finite"));
        }
        let bad = |value: &f64| !(value.is_finite() && *value > 0.0);
        if let Some(value) = self.tile.into_iter().find(bad) {
            return Some(("tile", value, "finite and above 0"));
        }
        let value = self.shift.into_iter().find(|value| !value.is_finite())?;
        Some(("shift", value, "finite"))
    }
}

/// Which normals a relief is shaded with.
#[derive(Clone, Debug, Default)]
pub enum ShadingNormals {
    /// The surface's own: breaks between cells are visible.
    Exact,
    /// Central differences, interpolated: smooth over cells. The default.
    #[default]
    Smooth,
    /// The paper's one-sided cross product, interpolated \[Book2007, section 3.3\].
    Published,
    /// The paper's figure 1: normals of the map on a unit square of depth 1, whatever the face's
    /// size and depth. Wrong on purpose.
    WrongMetric,
    /// A normal map laid on the face like the height map.
    Map(Arc<NormalMap>),
}

/// Everything about a face but its corners and its map.
#[derive(Clone, Debug, Default)]
pub struct FaceOptions {
    /// How the map is laid on the face.
    pub displacement: Displacement,
    /// How rays are walked.
    pub method: Method,
    /// Which normals to shade with.
    pub normals: ShadingNormals,
    /// Whether walls go down from the border to offset 0.
    pub closed: bool,
    /// Whether rays from behind pass through.
    pub one_sided: bool,
    /// Vector instructions of the walk; the fastest there are, unless asked otherwise. No answer
    /// depends on it.
    pub simd: SimdLevel,
}
