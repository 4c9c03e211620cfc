//! `type = "terrain"`: a height map on the ground it was measured on.

use std::ops::Range;

use rilievo::glam::DVec3;
use rilievo::relief::Displacement;

use super::super::syntax::{Located, Table};
use super::material::PAIR;
use super::shape::{DisplacementEntry, Normals, QuadEntry};
use super::view::{method, point};
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
    let map = table.require("map")?.name()?;
    let positive = |key| match table.get(key) {
        Some(value) => value.number_in(f64::MIN_POSITIVE.., "a number above 0"),
        None => Ok(1.0),
    };
    let cell = match table.get("cell") {
        Some(value) => {
            let mut cell = [0.0; 2];
            for (slot, value) in cell.iter_mut().zip(value.array::<2>(PAIR)?) {
                *slot = value.number_in(f64::MIN_POSITIVE.., "a number of metres above 0")?;
            }
            Some(cell)
        }
        None => None,
    };
    let ground = GroundEntry {
        center: table.get("center").map_or(Ok(DVec3::ZERO), |v| point(&v))?,
        unit: positive("unit")?,
        exaggeration: positive("exaggeration")?,
        cell,
        zero: table.get("zero").map(|v| v.number()).transpose()?,
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
        method: table.get("method").map(|v| method(&v)).transpose()?,
        closed: table.get("closed").map_or(Ok(false), |v| v.boolean())?,
        one_sided: false,
        ground: Some(Box::new(ground)),
    })
}
