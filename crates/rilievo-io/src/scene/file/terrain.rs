//! `type = "terrain"`: a height map on the ground it was measured on.

use std::ops::Range;

use rilievo::glam::DVec3;
use rilievo::relief::Displacement;

use super::super::keys::render::METHOD_OF_SHAPE;
use super::super::keys::shape as keys;
use super::super::syntax::{Located, Table};
use super::shape::{DisplacementEntry, Normals, QuadEntry};
use crate::error::Result;

/// How a map lies on the ground.
#[derive(Clone, Debug)]
pub(in super::super) struct GroundEntry {
    /// Where the middle of the map is, at height `zero`.
    pub center: DVec3,
    /// Metres of a scene unit.
    pub unit: f64,
    pub exaggeration: f64,
    /// Metres from one sample to the next; of the file, if it is not written.
    pub cell: Option<[f64; 2]>,
    /// The height that is put at `center`, metres; the lowest, if it is not written.
    pub zero: Option<f64>,
    pub at: Range<usize>,
}

/// Reads a terrain as a quad whose corners are not known yet.
pub(super) fn read_terrain(table: &Table<'_>) -> Result<QuadEntry> {
    let map = keys::TERRAIN_MAP.of(table)?;
    let ground = GroundEntry {
        center: keys::TERRAIN_CENTER.of(table)?,
        unit: keys::UNIT.of(table)?,
        exaggeration: keys::EXAGGERATION.of(table)?,
        cell: keys::CELL.of(table)?,
        zero: keys::TERRAIN_ZERO.of(table)?,
        at: table.at(),
    };
    let displacement = DisplacementEntry {
        map,
        displacement: Displacement::default(),
        scale_written: true,
        zero_written: true,
        normals: Normals::Smooth,
        at: table.at(),
    };
    Ok(QuadEntry {
        corners: Located { value: [DVec3::ZERO; 4], at: table.at() },
        displacement: Some(displacement),
        method: METHOD_OF_SHAPE.of(table)?,
        closed: keys::TERRAIN_CLOSED.of(table)?,
        one_sided: false,
        ground: Some(Box::new(ground)),
    })
}
