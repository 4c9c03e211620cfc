//! `motion` of shapes and of their places.

use rilievo::glam::DVec3;
use rilievo::surface::Motion;

use super::super::keys::motion as keys;
use super::super::syntax::{Located, Table, Value};
use crate::error::Result;

/// The motion of a shape.
pub(super) fn read_motion(table: &Table<'_>) -> Result<Option<Located<Motion>>> {
    let Some(value) = table.get(&keys::OF_SHAPE) else { return Ok(None) };
    let table = value.table()?;
    let pivot = keys::PIVOT.of(&table)?;
    finish(&value, &table, pivot).map(Some)
}

/// The motion of a place whose own frame begins at `origin`.
pub(super) fn read_place_motion(
    table: &Table<'_>,
    origin: DVec3,
) -> Result<Option<Located<Motion>>> {
    let Some(value) = table.get(&keys::OF_PLACE) else { return Ok(None) };
    let table = value.table()?;
    let pivot = keys::PLACE_PIVOT.of(&table)?.unwrap_or(origin);
    finish(&value, &table, pivot).map(Some)
}

fn finish(value: &Value<'_>, table: &Table<'_>, pivot: DVec3) -> Result<Located<Motion>> {
    let motion = Motion {
        translation: keys::TRANSLATE.of(table)?,
        pivot,
        axis: keys::AXIS.of(table)?,
        angle: keys::ANGLE.of(table)?.to_radians(),
    };
    table.finish()?;
    Ok(Located { value: motion, at: value.at() })
}
