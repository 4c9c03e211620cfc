//! Ways to move a camera. Angles in radian, distances in scene units.

use glam::{DQuat, DVec2, DVec3};
use rilievo_render::CameraParts;

/// How near the view axis may come to the upright, radian.
const LEAST_TILT: f64 = 0.02;

/// Turns the camera around what it looks at: `turn.x` about the upright, `turn.y` towards the top. It
/// stays at its distance and never goes over the top.
#[must_use]
pub fn orbit(camera: CameraParts, turn: DVec2) -> CameraParts {
    let arm = camera.position - camera.look_at;
    CameraParts { position: camera.look_at + turned(arm, camera.up, turn), ..camera }
}

/// Turns the camera where it stands: `turn.x` about the upright, `turn.y` upwards.
#[must_use]
pub fn look(camera: CameraParts, turn: DVec2) -> CameraParts {
    let ahead = camera.look_at - camera.position;
    CameraParts { look_at: camera.position + turned(ahead, camera.up, turn), ..camera }
}

/// Moves the camera and what it looks at across the view, in heights of the picture at the distance of
/// what it looks at: to the right and up.
#[must_use]
pub fn pan(camera: CameraParts, by: DVec2) -> CameraParts {
    let [right, up, _] = axes(&camera);
    let distance = (camera.look_at - camera.position).length();
    let height = 2.0 * distance * (0.5 * camera.fov.to_radians()).tan();
    moved(camera, (by.x * right + by.y * up) * height)
}

/// Brings the camera nearer to what it looks at (`factor` below 1) or farther from it.
#[must_use]
pub fn zoom(camera: CameraParts, factor: f64) -> CameraParts {
    let arm = (camera.position - camera.look_at) * factor.clamp(0.1, 10.0);
    if !(1e-9..=1e12).contains(&arm.length()) {
        return camera;
    }
    CameraParts { position: camera.look_at + arm, ..camera }
}

/// Moves the camera and what it looks at to the right, up and ahead.
#[must_use]
pub fn fly(camera: CameraParts, by: DVec3) -> CameraParts {
    let [right, up, ahead] = axes(&camera);
    moved(camera, by.x * right + by.y * up + by.z * ahead)
}

/// Looks from the same side at what lies around `center` within `radius`.
#[must_use]
pub fn frame(camera: CameraParts, center: DVec3, radius: f64) -> CameraParts {
    let [.., ahead] = axes(&camera);
    let [width, height] = camera.resolution.map(f64::from);
    let half = (0.5 * camera.fov.to_radians()).tan() * (width / height).min(1.0);
    let distance = (radius.max(1e-9) / half.atan().sin()).min(1e12);
    CameraParts { position: center - distance * ahead, look_at: center, ..camera }
}

/// Right, up and ahead of the image, unit length.
fn axes(camera: &CameraParts) -> [DVec3; 3] {
    let ahead = (camera.look_at - camera.position).normalize_or(DVec3::Y);
    let right = ahead.cross(camera.up).normalize_or(ahead.any_orthonormal_vector());
    [right, right.cross(ahead), ahead]
}

fn moved(camera: CameraParts, by: DVec3) -> CameraParts {
    CameraParts { position: camera.position + by, look_at: camera.look_at + by, ..camera }
}

/// `arm` turned about `up` by `turn.x` and towards it by `turn.y`, but not beyond it.
fn turned(arm: DVec3, up: DVec3, turn: DVec2) -> DVec3 {
    let up = up.normalize_or(DVec3::Z);
    let across = up.cross(arm).normalize_or(up.any_orthonormal_vector());
    let tilt = up.angle_between(arm);
    let wanted = (tilt - turn.y).clamp(LEAST_TILT, std::f64::consts::PI - LEAST_TILT);
    let lifted = DQuat::from_axis_angle(across, wanted - tilt) * arm;
    DQuat::from_axis_angle(up, turn.x) * lifted
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(position: DVec3, look_at: DVec3) -> CameraParts {
        CameraParts { position, look_at, up: DVec3::Z, fov: 40.0, resolution: [40, 30] }
    }

    fn cameras() -> Vec<CameraParts> {
        let mut all = Vec::new();
        for x in [-3.0, 0.1, 2.0] {
            for z in [-4.0, 0.0, 0.7] {
                all.push(camera(DVec3::new(x, 1.5 * x, z), DVec3::new(0.5, 0.25, -0.1)));
            }
        }
        all
    }

    fn arm(camera: &CameraParts) -> DVec3 {
        camera.position - camera.look_at
    }

    #[test]
    fn an_orbit_keeps_its_distance_and_can_be_taken_back() {
        for start in cameras() {
            for turn in [DVec2::new(0.3, 0.0), DVec2::new(-2.0, 0.1), DVec2::new(0.0, -0.2)] {
                let there = orbit(start, turn);
                assert_eq!(there.look_at, start.look_at);
                assert!((arm(&there).length() - arm(&start).length()).abs() < 1e-12);
                let tilt = arm(&start).angle_between(DVec3::Z);
                if !(0.3..2.8).contains(&tilt) {
                    continue;
                }
                let back = orbit(there, -turn);
                assert!((back.position - start.position).length() < 1e-9, "{start:?} {turn}");
            }
        }
    }

    #[test]
    fn no_orbit_goes_over_the_top() {
        for start in cameras() {
            for turn in [-100.0, -1.0, 1.0, 100.0] {
                let there = orbit(start, DVec2::new(0.0, turn));
                let tilt = arm(&there).angle_between(DVec3::Z);
                let allowed = LEAST_TILT - 1e-9..=std::f64::consts::PI - LEAST_TILT + 1e-9;
                assert!(allowed.contains(&tilt), "{tilt}");
                assert!(rilievo_render::Camera::new(there).is_ok());
            }
        }
    }

    #[test]
    fn upwards_is_up_and_ahead_is_nearer() {
        for start in cameras() {
            assert!(orbit(start, DVec2::new(0.0, 0.1)).position.z > start.position.z);
            assert!(look(start, DVec2::new(0.0, 0.1)).look_at.z > start.look_at.z);
            assert!(arm(&zoom(start, 0.5)).length() < arm(&start).length());
            let flown = fly(start, DVec3::new(0.0, 0.0, 0.5));
            let way = flown.position - start.position;
            assert!((way + 0.5 * arm(&start).normalize()).length() < 1e-12);
            assert!((arm(&flown) - arm(&start)).length() < 1e-12);
        }
    }

    #[test]
    fn a_pan_by_one_moves_the_picture_by_its_height() {
        let start = camera(DVec3::new(0.0, -2.0, 0.0), DVec3::ZERO);
        let there = pan(start, DVec2::new(0.0, 1.0));
        let height = 4.0 * 20f64.to_radians().tan();
        assert!((there.position - start.position - height * DVec3::Z).length() < 1e-12);
        let right = pan(start, DVec2::new(1.0, 0.0));
        assert!((right.look_at - height * DVec3::X).length() < 1e-12);
    }

    #[test]
    fn a_framed_ball_fits_the_picture() {
        for start in cameras() {
            let (center, radius) = (DVec3::new(3.0, -1.0, 2.0), 0.7);
            let framed = frame(start, center, radius);
            let half = 20f64.to_radians().tan();
            let distance = arm(&framed).length();
            // The ball touches the cone through the upper border.
            assert!((radius / distance - half.atan().sin()).abs() < 1e-12);
            let aside = arm(&framed).angle_between(arm(&start));
            assert!(aside < 1e-6);
        }
    }

    #[test]
    fn zoom_stops_where_numbers_end() {
        let mut near = camera(DVec3::X, DVec3::ZERO);
        for _ in 0..1000 {
            near = zoom(near, 0.5);
        }
        assert!(arm(&near).length() > 0.0);
        assert!(rilievo_render::Camera::new(near).is_ok());
    }
}
