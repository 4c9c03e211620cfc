//! `[[lights]]` and `[environment]`.

use rilievo_render::light::{EnvironmentPlacement, Light, LightError, PointLight, SunLight};

use super::super::keys::light::{self as keys, LightKind};
use super::super::syntax::{Located, Table};
use crate::error::Result;

/// One of `[[lights]]`.
pub(super) fn light(table: &Table<'_>) -> Result<Light> {
    let kind = keys::TYPE.of(table)?;
    let refused = |e: LightError| table.invalid("light", e.to_string(), "");
    let point = || {
        let light = PointLight::new(keys::POSITION.of(table)?, keys::INTENSITY.of(table)?);
        light.map_err(refused)
    };
    let light = match kind {
        LightKind::Sun => {
            let (along, irradiance) = (keys::DIRECTION.of(table)?, keys::IRRADIANCE.of(table)?);
            let sun = SunLight::new(along, irradiance, keys::ANGLE.of(table)?);
            Light::Sun(sun.map_err(refused)?)
        }
        LightKind::Point => Light::Point(point()?),
        LightKind::Spot => {
            let (point, axis) = (point()?, keys::DIRECTION.of(table)?);
            let inner = keys::INNER_ANGLE.of(table)?;
            let outer = keys::OUTER_ANGLE.of(table)?;
            if let Some(value) = table.get(&keys::INNER_ANGLE).filter(|_| inner >= outer) {
                return Err(value.invalid("a number of degrees from 0, below `outer_angle`"));
            }
            Light::Point(point.spot(axis, [inner, outer]).map_err(refused)?)
        }
    };
    table.finish()?;
    Ok(light)
}

/// What `[environment]` says.
#[derive(Clone, Debug)]
pub(in super::super) struct EnvironmentEntry {
    pub file: Located<String>,
    pub placement: EnvironmentPlacement,
}

impl EnvironmentEntry {
    pub fn read(table: &Table<'_>) -> Result<Self> {
        let file = keys::FILE.of(table)?;
        let placement = EnvironmentPlacement {
            scale: keys::SCALE.of(table)?,
            rotate: keys::ROTATE.of(table)?,
            up: keys::UP.of(table)?,
        };
        table.finish()?;
        Ok(Self { file, placement })
    }
}
