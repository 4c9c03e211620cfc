//! Longitude and latitude on a sphere with poles on the z axis.
//!
//! u is the longitude over 360 degrees, from +x towards +y, in [0, 1), 0 at the poles; v is 0 at the
//! south pole (-z) and 1 at the north pole, and linear in latitude.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

/// Parameters of the point in direction `outward` from the centre.
pub(crate) fn uv(outward: DVec3) -> DVec2 {
    let turns = outward.y.atan2(outward.x) / TAU;
    let u = if turns < 0.0 { turns + 1.0 } else { turns };
    // Just below the date line the sum rounds to 1; at the poles atan2 may be pi for x = -0.
    let on_axis = outward.x == 0.0 && outward.y == 0.0;
    let u = if u >= 1.0 || on_axis { 0.0 } else { u };
    let latitude = outward.z.atan2(outward.x.hypot(outward.y));
    DVec2::new(u, (0.5 + latitude / PI).clamp(0.0, 1.0))
}

/// Derivatives (dP/du, dP/dv) in direction `outward`, a unit vector; at the poles dP/du vanishes.
pub(crate) fn tangents(radius: f64, outward: DVec3) -> [DVec3; 2] {
    let parallel = DVec2::new(outward.x, outward.y);
    let meridian = parallel.try_normalize().unwrap_or(DVec2::X);
    [
        TAU * radius * DVec3::new(-outward.y, outward.x, 0.0),
        PI * radius * (-outward.z * meridian).extend(parallel.length()),
    ]
}
