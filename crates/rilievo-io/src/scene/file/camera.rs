//! `[camera]`.

use std::ops::Range;

use rilievo_render::{Camera, CameraError, CameraParts, Lens, Pose, Projection};

use super::super::keys::camera::{self as keys, ProjectionKind};
use super::super::syntax::{Table, Value};
use crate::error::Result;

/// Height of the film behind a lens whose opening is told in f-stops, scene units: that of a 35 mm
/// camera where a unit is a metre.
const FILM_HEIGHT: f64 = 0.024;

/// What `[camera]` says.
#[derive(Clone, Debug)]
pub(in super::super) struct CameraEntry {
    pub parts: CameraParts,
    projection: Projection,
    lens: Option<Lens>,
    motion: Option<Motion>,
    shutter: [f64; 2],
    /// Where `look_at` and `up`, or the table, stand.
    look_at: Range<usize>,
    up: Range<usize>,
}

/// Where the camera goes.
#[derive(Clone, Debug)]
struct Motion {
    end: Pose,
    at: Range<usize>,
}

impl CameraEntry {
    pub fn read(table: &Table<'_>) -> Result<Self> {
        let position = keys::POSITION.of(table)?;
        let look_at = table.require(&keys::LOOK_AT)?;
        let up = keys::UP.located(table)?;
        let parts = CameraParts {
            position,
            look_at: keys::LOOK_AT.read(&look_at)?,
            up: up.value,
            fov: keys::FOV.of(table)?,
            resolution: keys::RESOLUTION.of(table)?,
        };
        let projection = read_projection(table)?;
        let lens = read_lens(table, &parts, projection)?;
        let motion = read_motion(table, &parts)?;
        let shutter = keys::SHUTTER.of(table)?;
        table.finish()?;
        let (look_at, up) = (look_at.at(), up.at);
        Ok(Self { parts, projection, lens, motion, shutter, look_at, up })
    }

    /// The camera, or what is wrong with it, where, and what is allowed.
    pub fn build(
        &self,
    ) -> std::result::Result<Camera, (CameraError, &Range<usize>, [&'static str; 2])> {
        let posed = |e| match e {
            CameraError::NoDirection => {
                (e, &self.look_at, ["camera.look_at", "a point other than `position`"])
            }
            _ => (e, &self.up, ["camera.up", "a direction that is not that of the view"]),
        };
        let mut camera = Camera::new(self.parts)
            .and_then(|camera| camera.with_projection(self.projection))
            .and_then(|camera| camera.with_shutter(self.shutter))
            .map_err(posed)?;
        if let Some(lens) = self.lens {
            camera = camera.with_lens(lens).map_err(posed)?;
        }
        if let Some(Motion { end, at }) = &self.motion {
            let allowed = "poses with a direction all the way";
            let motion = camera.with_motion(*end, self.shutter);
            camera = motion.map_err(|e| (e, at, ["camera.motion", allowed]))?;
        }
        Ok(camera)
    }
}

fn read_projection(table: &Table<'_>) -> Result<Projection> {
    let (kind, height) = (keys::PROJECTION.of(table)?, table.get(&keys::HEIGHT));
    match (kind, height) {
        (ProjectionKind::Orthographic, None) => {
            let found = "the key `height` is missing";
            Err(table.invalid("camera", found, "`height` of an orthographic image"))
        }
        (ProjectionKind::Orthographic, Some(height)) => {
            Ok(Projection::Orthographic { height: keys::HEIGHT.read(&height)? })
        }
        (_, Some(height)) => Err(height.invalid("nothing: only orthographic images have a height")),
        (ProjectionKind::Perspective, None) => Ok(Projection::Perspective),
        (ProjectionKind::Panoramic, None) => Ok(Projection::Panoramic),
    }
}

fn read_lens(
    table: &Table<'_>,
    parts: &CameraParts,
    projection: Projection,
) -> Result<Option<Lens>> {
    let written: [Option<Value<'_>>; 5] = [
        table.get(&keys::APERTURE),
        table.get(&keys::F_STOP),
        table.get(&keys::FOCUS_DISTANCE),
        table.get(&keys::BLADES),
        table.get(&keys::BLADE_ROTATION),
    ];
    if let (Projection::Panoramic, Some(value)) = (projection, written.iter().flatten().next()) {
        return Err(value.invalid("nothing: a panorama has no lens"));
    }
    if let [Some(_), Some(f_stop), ..] = &written {
        return Err(f_stop.invalid("nothing: the lens has an `aperture`"));
    }
    let focus_distance = match keys::FOCUS_DISTANCE.of(table)? {
        Some(distance) => distance,
        None => (parts.look_at - parts.position).length().max(f64::MIN_POSITIVE),
    };
    let blades = keys::BLADES.of(table)?;
    let rotation = keys::BLADE_ROTATION.of(table)?.to_radians();
    let diameter = match (keys::APERTURE.of(table)?, keys::F_STOP.of(table)?) {
        (Some(diameter), _) => diameter,
        (None, Some(f_stop)) => 0.5 * FILM_HEIGHT / (0.5 * parts.fov.to_radians()).tan() / f_stop,
        (None, None) => return Ok(None),
    };
    Ok(Some(Lens { radius: 0.5 * diameter, focus_distance, blades, rotation }))
}

fn read_motion(table: &Table<'_>, parts: &CameraParts) -> Result<Option<Motion>> {
    let Some(value) = table.get(&keys::MOTION_TABLE) else { return Ok(None) };
    let table = value.table()?;
    let end = Pose {
        position: keys::END_POSITION.of(&table)?.unwrap_or(parts.position),
        look_at: keys::END_LOOK_AT.of(&table)?.unwrap_or(parts.look_at),
        up: keys::END_UP.of(&table)?.unwrap_or(parts.up),
    };
    table.finish()?;
    Ok(Some(Motion { end, at: value.at() }))
}
