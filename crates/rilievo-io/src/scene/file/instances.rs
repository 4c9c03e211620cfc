//! `instances` and `scatter` of `[[shapes]]`: where a shape stands, if not once where it is.

use std::f64::consts::TAU;
use std::ops::Range;

use rilievo::glam::{DAffine3, DMat3};
use rilievo::relief::Displacement;
use rilievo::surface::Motion;

use super::super::keys::motion::OF_PLACE;
use super::super::keys::place as keys;
use super::super::syntax::{Located, Table, Value};
use super::motion::read_place_motion;
use super::shape::transform;
use crate::error::Result;

/// A place of a shape.
#[derive(Clone, Debug)]
pub(in super::super) struct InstanceEntry {
    pub world_from_shape: DAffine3,
    /// What differs from the shape's own displacement.
    pub displacement: Option<Box<Located<Changes>>>,
    /// Where this place goes, in the world.
    pub motion: Option<Box<Located<Motion>>>,
    pub at: Range<usize>,
}

/// Numbers of a displacement that an instance has for itself.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct Changes {
    scale: Option<f64>,
    zero: Option<f64>,
    tile: Option<[f64; 2]>,
    shift: Option<[f64; 2]>,
}

impl Changes {
    /// A displacement with these numbers in it.
    pub fn of(&self, base: Displacement) -> Displacement {
        Displacement {
            scale: self.scale.unwrap_or(base.scale),
            zero: self.zero.unwrap_or(base.zero),
            tile: self.tile.unwrap_or(base.tile),
            shift: self.shift.unwrap_or(base.shift),
        }
    }
}

/// The places that a shape, which moves or not, names; none if it stands where it is.
pub(super) fn read_instances(table: &Table<'_>, moves: bool) -> Result<Option<Vec<InstanceEntry>>> {
    let (listed, scattered) = (table.get(&keys::INSTANCES), table.get(&keys::SCATTER_TABLE));
    match (listed, scattered) {
        (None, None) => Ok(None),
        (Some(_), Some(value)) => Err(value.invalid("nothing: the shape has `instances`")),
        (Some(value), None) => {
            let items = value.items("an array of tables: [{ translate = [x, y, z] }, ...]")?;
            items.iter().map(|item| read_instance(item, moves)).collect::<Result<_>>().map(Some)
        }
        (None, Some(value)) => scatter(&value).map(Some),
    }
}

fn read_instance(value: &Value<'_>, moves: bool) -> Result<InstanceEntry> {
    let table = value.table()?;
    let displacement = table.get(&keys::CHANGES);
    let world_from_shape = transform(&table)?;
    if let (true, Some(value)) = (moves, table.get(&OF_PLACE)) {
        return Err(value.invalid("nothing: the shape has a `motion`, in each place"));
    }
    let motion = read_place_motion(&table, world_from_shape.translation)?.map(Box::new);
    table.finish()?;
    let displacement = match displacement {
        Some(value) => Some(Box::new(Located { value: read_changes(&value)?, at: value.at() })),
        None => None,
    };
    Ok(InstanceEntry { world_from_shape, displacement, motion, at: value.at() })
}

fn read_changes(value: &Value<'_>) -> Result<Changes> {
    let table = value.table()?;
    let changes = Changes {
        scale: keys::CHANGED_SCALE.of(&table)?,
        zero: keys::CHANGED_ZERO.of(&table)?,
        tile: keys::CHANGED_TILE.of(&table)?,
        shift: keys::CHANGED_SHIFT.of(&table)?,
    };
    table.finish()?;
    Ok(changes)
}

/// Places strewn over a parallelogram, one in each cell of a grid, each turned about the normal.
fn scatter(value: &Value<'_>) -> Result<Vec<InstanceEntry>> {
    let table = value.table()?;
    let count = keys::COUNT.of(&table)?;
    let over = table.require(&keys::OVER)?;
    let [corner, u, v] = keys::OVER.read(&over)?;
    let scale = keys::SIZES.of(&table)?;
    let turn = keys::TURN.of(&table)?;
    let seed = keys::SEED.of(&table)?;
    table.finish()?;
    let Some(up) = u.cross(v).try_normalize() else {
        return Err(over.invalid("two edges that span an area"));
    };
    // Cells about as long as wide, in rows; the last row may be short.
    let columns = ((count as f64 * u.length() / v.length()).sqrt().round() as u64).clamp(1, count);
    let rows = count.div_ceil(columns);
    let place = |k: u64| {
        let draw = |what: u64| unit(seed, 4 * k + what);
        let [i, j] = [k % columns, k / columns].map(|k| k as f64);
        let (x, y) = ((i + draw(0)) / columns as f64, (j + draw(1)) / rows as f64);
        let size = scale[0] + (scale[1] - scale[0]) * draw(2);
        let angle = TAU * turn / 360.0 * draw(3);
        let linear = DMat3::from_axis_angle(up, angle) * size;
        InstanceEntry {
            world_from_shape: DAffine3::from_mat3_translation(linear, corner + x * u + y * v),
            displacement: None,
            motion: None,
            at: value.at(),
        }
    };
    Ok((0..count).map(place).collect())
}

/// A number in `[0, 1)` by place: the finaliser of SplitMix64 \[Steele2014\].
fn unit(seed: u64, index: u64) -> f64 {
    let mut z = seed.wrapping_add(index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ z >> 31) >> 11) as f64 / (1u64 << 53) as f64
}
