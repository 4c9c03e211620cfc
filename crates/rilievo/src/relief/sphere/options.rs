//! What a user says about a displaced sphere besides its place and its map, and why it is refused.

use glam::DVec3;

use super::CubeRelief;
use crate::map::{CubeFace, DistanceKind};
use crate::mesh::COORDINATE_LIMIT;
use crate::relief::method::Method;
use crate::relief::options::{Displacement, ShadingNormals};
use crate::simd::SimdLevel;

/// Everything about a displaced sphere but its place and its map.
#[derive(Clone, Debug, Default)]
pub struct SphereOptions {
    /// How the map is laid on the sphere; `tile` and `shift` must be those that the relief was
    /// resampled with.
    pub displacement: Displacement,
    /// How rays are walked: an exact method; those by distance need the relief's distance maps.
    pub method: Method,
    /// Which normals to shade with; those of the paper are for faces only.
    pub normals: ShadingNormals,
    /// Vector instructions of the walk; no answer depends on it.
    pub simd: SimdLevel,
}

/// Why a displaced sphere was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReliefSphereError {
    /// The centre is NaN, infinite or too large.
    #[error("the centre is not finite or larger than 1e100")]
    Center,
    /// The radius is not usable.
    #[error("the radius is {0}, not a number from 1e-100 to 1e100")]
    Radius(f64),
    /// A number of the displacement is out of its range.
    #[error("displacement {key} is {value}; {allowed}")]
    Displacement {
        /// The key at fault.
        key: &'static str,
        /// The value found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The displacement reaches the centre.
    #[error(
        "the surface lies {lowest} to {highest} from the centre; radius + offset must stay above 0 and below 1e100"
    )]
    Inverted {
        /// The smallest radius plus offset.
        lowest: f64,
        /// The largest.
        highest: f64,
    },
    /// The method is approximate, for faces only.
    #[error("method {0} is for faces only; spheres are walked by the exact methods")]
    Method(Method),
    /// The method needs distance maps that the relief does not have.
    #[error("method {method} needs {kind:?} distance maps")]
    NoDistanceMap {
        /// The method.
        method: Method,
        /// The kind that is missing.
        kind: DistanceKind,
    },
    /// The normals are for faces only.
    #[error(
        "the normals of the paper's figures are for faces; spheres have smooth, exact or those of a map"
    )]
    Normals,
}

/// Checks everything but the radii that the displacement leads to.
pub(super) fn check(
    center: DVec3,
    radius: f64,
    relief: &CubeRelief,
    options: &SphereOptions,
) -> Result<(), ReliefSphereError> {
    if !center.abs().cmple(DVec3::splat(COORDINATE_LIMIT)).all() {
        return Err(ReliefSphereError::Center);
    }
    if !(1.0 / COORDINATE_LIMIT..=COORDINATE_LIMIT).contains(&radius) {
        return Err(ReliefSphereError::Radius(radius));
    }
    let refuse = |key, value, allowed| Err(ReliefSphereError::Displacement { key, value, allowed });
    let Displacement { tile, shift, .. } = options.displacement;
    let tiling = relief.tiling();
    if let Some((key @ ("scale" | "zero"), value, allowed)) = options.displacement.fault() {
        return refuse(key, value, allowed);
    }
    for (value, own) in tile.into_iter().zip(tiling.tile) {
        if value != own {
            return refuse("tile", value, "that with which the map was resampled");
        }
    }
    for (value, own) in shift.into_iter().zip(tiling.shift) {
        if value != own {
            return refuse("shift", value, "that with which the map was resampled");
        }
    }
    let method = options.method;
    if !method.is_exact() {
        return Err(ReliefSphereError::Method(method));
    }
    if let Some(kind) = method.distance_kind()
        && relief.face(CubeFace::PosX).distance(kind).is_none()
    {
        return Err(ReliefSphereError::NoDistanceMap { method, kind });
    }
    if matches!(options.normals, ShadingNormals::Published | ShadingNormals::WrongMetric) {
        return Err(ReliefSphereError::Normals);
    }
    Ok(())
}
