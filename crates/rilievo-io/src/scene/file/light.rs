//! `[[lights]]` and `[environment]`.

use rilievo::glam::DVec3;
use rilievo_render::light::{EnvironmentPlacement, Light, LightError, PointLight, SunLight, Up};

use super::super::syntax::{Located, Table, Value};
use super::view::{colour, point};
use crate::error::Result;

/// Full angle of a spot, degrees from its axis, if the file does not say.
const OUTER: f64 = 45.0;

/// The kinds of `[[lights]]`.
#[derive(Clone, Copy)]
enum Kind {
    Point,
    Spot,
    Sun,
}

/// One of `[[lights]]`.
pub(super) fn light(table: &Table<'_>) -> Result<Light> {
    let kind = [("point", Kind::Point), ("spot", Kind::Spot), ("sun", Kind::Sun)];
    let kind = table.require("type")?.choice(&kind)?;
    let number = |value: Option<Value<'_>>, allowed: &str, range, default| {
        value.map_or(Ok(default), |value: Value<'_>| value.number_in(range, allowed))
    };
    let refused = |e: LightError| table.invalid("light", e.to_string(), "");
    let direction = |value: &Value<'_>| match point(value)? {
        DVec3::ZERO => Err(value.invalid("a direction other than zero")),
        direction => Ok(direction),
    };
    match kind {
        Kind::Sun => {
            let (along, irradiance) = (table.require("direction")?, table.require("irradiance")?);
            let angle = table.get("angle");
            table.finish()?;
            let angle = number(angle, "a number of degrees from 0 to 180", 0.0..=180.0, 0.0)?;
            let sun = SunLight::new(direction(&along)?, colour(&irradiance)?, angle);
            Ok(Light::Sun(sun.map_err(refused)?))
        }
        Kind::Point => {
            let (position, intensity) = (table.require("position")?, table.require("intensity")?);
            table.finish()?;
            let light = PointLight::new(point(&position)?, colour(&intensity)?);
            Ok(Light::Point(light.map_err(refused)?))
        }
        Kind::Spot => {
            let (position, intensity) = (table.require("position")?, table.require("intensity")?);
            let axis = table.require("direction")?;
            let (inner, outer) = (table.get("inner_angle"), table.get("outer_angle"));
            table.finish()?;
            let allowed = "a number of degrees above 0, up to 90";
            let outer = number(outer, allowed, f64::MIN_POSITIVE..=90.0, OUTER)?;
            let allowed = "a number of degrees from 0, below `outer_angle`";
            let inner = number(inner, allowed, 0.0..=outer.next_down(), 0.0)?;
            let axis = direction(&axis)?;
            let light = PointLight::new(point(&position)?, colour(&intensity)?)
                .and_then(|light| light.spot(axis, [inner, outer]));
            Ok(Light::Point(light.map_err(refused)?))
        }
    }
}

/// What `[environment]` says.
#[derive(Clone, Debug)]
pub(in super::super) struct EnvironmentEntry {
    pub file: Located<String>,
    pub placement: EnvironmentPlacement,
}

impl EnvironmentEntry {
    pub fn read(table: &Table<'_>) -> Result<Self> {
        let file = table.require("file")?;
        let (scale, rotate, up) = (table.get("scale"), table.get("rotate"), table.get("up"));
        table.finish()?;
        let mut placement = EnvironmentPlacement::default();
        if let Some(scale) = scale {
            placement.scale = match scale.number() {
                Ok(_) => DVec3::splat(scale.number_in(0.0.., "a number of at least 0, or three")?),
                Err(_) => colour(&scale)?,
            };
        }
        if let Some(rotate) = rotate {
            placement.rotate = rotate.number()?;
        }
        if let Some(up) = up {
            placement.up = up.choice(&[("z", Up::Z), ("y", Up::Y)])?;
        }
        Ok(Self { file: file.name()?, placement })
    }
}
