//! `[camera]`.

use std::ops::Range;

use rilievo::glam::DVec3;
use rilievo_render::{Camera, CameraError, CameraParts, Lens, Pose, Projection};

use super::super::syntax::{Table, Value};
use super::view::point;
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
    /// Where `look_at` and `up`, or the table, stand.
    look_at: Range<usize>,
    up: Range<usize>,
}

/// Where the camera goes.
#[derive(Clone, Debug)]
struct Motion {
    end: Pose,
    shutter: [f64; 2],
    at: Range<usize>,
}

impl CameraEntry {
    pub fn read(table: &Table<'_>) -> Result<Self> {
        let position = table.require("position")?;
        let look_at = table.require("look_at")?;
        let (up, fov) = (table.get("up"), table.get("fov"));
        let resolution = table.get("resolution");
        let projection = read_projection(table)?;
        let mut parts = CameraParts {
            position: point(&position)?,
            look_at: point(&look_at)?,
            up: DVec3::Z,
            fov: 40.0,
            resolution: [512, 512],
        };
        if let Some(up) = &up {
            parts.up = point(up)?;
        }
        if let Some(fov) = fov {
            let allowed = "a number above 0 and below 180 (degrees)";
            parts.fov = fov.number_in(f64::MIN_POSITIVE..180.0, allowed)?;
        }
        if let Some(resolution) = resolution {
            parts.resolution = resolution.integers(1..=Camera::MAX_RESOLUTION)?;
        }
        let lens = read_lens(table, &parts, projection)?;
        let motion = read_motion(table, &parts)?;
        table.finish()?;
        let up = up.map_or_else(|| table.at(), |up| up.at());
        Ok(Self { parts, projection, lens, motion, look_at: look_at.at(), up })
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
            .map_err(posed)?;
        if let Some(lens) = self.lens {
            camera = camera.with_lens(lens).map_err(posed)?;
        }
        if let Some(Motion { end, shutter, at }) = &self.motion {
            let allowed = "poses with a direction all the way";
            let motion = camera.with_motion(*end, *shutter);
            camera = motion.map_err(|e| (e, at, ["camera.motion", allowed]))?;
        }
        Ok(camera)
    }
}

fn read_projection(table: &Table<'_>) -> Result<Projection> {
    let (kind, height) = (table.get("projection"), table.get("height"));
    let names = [("perspective", 0), ("orthographic", 1), ("panoramic", 2)];
    let kind = kind.map_or(Ok(0), |kind| kind.choice(&names))?;
    match (kind, height) {
        (1, None) => {
            let found = "the key `height` is missing";
            Err(table.invalid("camera", found, "`height` of an orthographic image"))
        }
        (1, Some(height)) => {
            let allowed = "a number above 0 (scene units)";
            let height = height.number_in(f64::MIN_POSITIVE.., allowed)?;
            Ok(Projection::Orthographic { height })
        }
        (_, Some(height)) => Err(height.invalid("nothing: only orthographic images have a height")),
        (0, None) => Ok(Projection::Perspective),
        (_, None) => Ok(Projection::Panoramic),
    }
}

/// A number above 0.
fn positive(value: &Value<'_>) -> Result<f64> {
    value.number_in(f64::MIN_POSITIVE.., "a number above 0")
}

fn read_lens(
    table: &Table<'_>,
    parts: &CameraParts,
    projection: Projection,
) -> Result<Option<Lens>> {
    let (aperture, f_stop) = (table.get("aperture"), table.get("f_stop"));
    let focus = table.get("focus_distance");
    let (blades, rotation) = (table.get("blades"), table.get("blade_rotation"));
    let first = [&aperture, &f_stop, &focus, &blades, &rotation].into_iter().flatten().next();
    if let (Projection::Panoramic, Some(value)) = (projection, first) {
        return Err(value.invalid("nothing: a panorama has no lens"));
    }
    let focus_distance = match focus {
        Some(value) => positive(&value)?,
        None => (parts.look_at - parts.position).length().max(f64::MIN_POSITIVE),
    };
    let allowed = "0 (round) or 3 to 64";
    let blades = match blades {
        Some(value) => match value.integer(0..=Lens::MAX_BLADES)? {
            1 | 2 => return Err(value.invalid(allowed)),
            blades => blades,
        },
        None => 0,
    };
    let rotation = rotation.map_or(Ok(0.0), |value| value.number())?.to_radians();
    let diameter = match (aperture, f_stop) {
        (None, None) => return Ok(None),
        (Some(_), Some(value)) => return Err(value.invalid("nothing: the lens has an `aperture`")),
        (Some(value), None) => value.number_in(0.0.., "a number of at least 0 (scene units)")?,
        (None, Some(value)) => {
            let focal = 0.5 * FILM_HEIGHT / (0.5 * parts.fov.to_radians()).tan();
            focal / positive(&value)?
        }
    };
    Ok(Some(Lens { radius: 0.5 * diameter, focus_distance, blades, rotation }))
}

fn read_motion(table: &Table<'_>, parts: &CameraParts) -> Result<Option<Motion>> {
    let (motion, shutter) = (table.get("motion"), table.get("shutter"));
    let allowed = "two numbers from 0 to 1: when it opens and, not before, when it closes";
    let shutter = match &shutter {
        Some(value) => {
            let times = value.numbers::<2>(allowed)?;
            let sound = 0.0 <= times[0] && times[0] <= times[1] && times[1] <= 1.0;
            if sound { times } else { return Err(value.invalid(allowed)) }
        }
        None => [0.0, 1.0],
    };
    let Some(value) = motion else { return Ok(None) };
    let table = value.table()?;
    let (position, look_at) = (table.get("position"), table.get("look_at"));
    let up = table.get("up");
    table.finish()?;
    let or = |value: Option<Value<'_>>, still| value.map_or(Ok(still), |value| point(&value));
    let end = Pose {
        position: or(position, parts.position)?,
        look_at: or(look_at, parts.look_at)?,
        up: or(up, parts.up)?,
    };
    Ok(Some(Motion { end, shutter, at: value.at() }))
}
