//! Rays of every kind of camera against what they should be.

use super::*;
use crate::sampler::chi_square::independent_points;

fn parts() -> CameraParts {
    CameraParts {
        position: DVec3::new(1.0, -2.0, 3.0),
        look_at: DVec3::new(1.0, 8.0, 3.0),
        up: DVec3::Z,
        fov: 90.0,
        resolution: [400, 200],
    }
}

fn near(a: DVec3, b: DVec3) -> bool {
    (a - b).length() < 1e-12
}

#[test]
fn corner_rays_span_the_field_of_view() {
    let camera = Camera::new(parts()).unwrap();
    // Looking along +y with +z up, the right hand is +x; half height 1, half width 2.
    assert!(near(camera.ray(200.0, 100.0).direction, DVec3::Y));
    assert!(near(camera.ray(0.0, 0.0).direction, DVec3::new(-2.0, 1.0, 1.0)));
    assert!(near(camera.ray(400.0, 0.0).direction, DVec3::new(2.0, 1.0, 1.0)));
    assert!(near(camera.ray(0.0, 200.0).direction, DVec3::new(-2.0, 1.0, -1.0)));
    assert!(near(camera.ray(400.0, 200.0).direction, DVec3::new(2.0, 1.0, -1.0)));
    assert_eq!(camera.ray(3.0, 4.0).origin, DVec3::new(1.0, -2.0, 3.0));
}

#[test]
fn tilted_up_only_turns_the_horizon() {
    let tilted = CameraParts { up: DVec3::new(0.0, 5.0, 2.0), ..parts() };
    let (a, b) = (Camera::new(parts()).unwrap(), Camera::new(tilted).unwrap());
    assert!(near(a.ray(17.0, 150.0).direction, b.ray(17.0, 150.0).direction));
}

#[test]
fn rays_through_a_lens_meet_where_it_is_in_focus() {
    let lens = Lens { radius: 0.3, focus_distance: 4.0, blades: 6, rotation: 0.1 };
    let pinhole = Camera::new(parts()).unwrap();
    let camera = pinhole.with_lens(lens).unwrap();
    assert!(camera.has_lens() && !pinhole.has_lens());
    let sharp = pinhole.ray(37.0, 180.0).at(4.0);
    let mut widest: f64 = 0.0;
    for u in independent_points(1000) {
        let ray = camera.sample(37.0, 180.0, u, 0.5);
        assert!(near(ray.at(4.0), sharp));
        assert!((ray.direction.y - 1.0).abs() < 1e-12, "t is the depth");
        widest = widest.max((ray.origin - parts().position).length());
    }
    assert!((0.29..=0.3).contains(&widest), "{widest}");
    let shut = Lens { radius: 0.0, ..lens };
    assert_eq!(pinhole.with_lens(shut).unwrap(), pinhole);
}

#[test]
fn orthographic_rays_are_parallel() {
    let camera = Camera::new(parts()).unwrap();
    let camera = camera.with_projection(Projection::Orthographic { height: 3.0 }).unwrap();
    let ray = camera.ray(400.0, 0.0);
    assert!(near(ray.direction, DVec3::Y) && near(ray.origin, DVec3::new(4.0, -2.0, 4.5)));
    assert!(near(camera.ray(200.0, 100.0).origin, parts().position));
}

#[test]
fn a_panorama_looks_everywhere_once() {
    let camera = Camera::new(parts()).unwrap().with_projection(Projection::Panoramic).unwrap();
    let looks = |x, y| camera.ray(x, y).direction;
    assert!(near(looks(200.0, 100.0), DVec3::Y) && near(looks(300.0, 100.0), DVec3::X));
    assert!(near(looks(100.0, 100.0), -DVec3::X) && near(looks(0.0, 100.0), -DVec3::Y));
    assert!(near(looks(70.0, 0.0), DVec3::Z) && near(looks(70.0, 200.0), -DVec3::Z));
    assert!((looks(33.0, 61.0).length() - 1.0).abs() < 1e-12);
}

#[test]
fn a_moving_camera_keeps_what_it_follows_in_the_middle() {
    let still = Camera::new(parts()).unwrap();
    let end = Pose {
        position: DVec3::new(3.0, -2.0, 5.0),
        look_at: DVec3::new(1.0, 8.0, 3.0),
        up: DVec3::new(0.2, 0.0, 1.0),
    };
    let camera = still.with_motion(end, [0.5, 1.0]).unwrap();
    assert!(camera.moves() && !still.moves());
    for (time, along) in [(0.0, 0.5), (0.5, 0.75), (1.0, 1.0)] {
        let ray = camera.sample(200.0, 100.0, DVec2::splat(0.5), time);
        assert!(near(ray.origin, parts().position.lerp(end.position, along)));
        let seen = ray.direction.cross(end.look_at - ray.origin);
        assert!(seen.length() < 1e-9);
    }
    let opened = camera.ray(7.0, 9.0);
    let there = Camera::new(CameraParts {
        position: parts().position.lerp(end.position, 0.5),
        up: parts().up.lerp(end.up, 0.5),
        ..parts()
    });
    assert!(near(opened.direction, there.unwrap().ray(7.0, 9.0).direction));
    // With other pixels it is the same camera.
    let other = camera.with_resolution([40, 20]).unwrap();
    assert!(near(other.ray(0.7, 0.9).direction, opened.direction));
}

#[test]
fn a_camera_at_rest_does_not_ask_for_lens_and_time() {
    let camera = Camera::new(parts()).unwrap();
    for u in independent_points(100) {
        let (x, y) = (400.0 * u.x, 200.0 * u.y);
        assert_eq!(camera.sample(x, y, u, u.x), Ray { time: u.x, ..camera.ray(x, y) });
    }
}

#[test]
fn the_matrix_of_the_image_is_that_of_the_rays() {
    let perspective = Camera::new(parts()).unwrap();
    let flat = perspective.with_projection(Projection::Orthographic { height: 3.0 }).unwrap();
    for camera in [perspective, flat] {
        let image_from_world = camera.image_from_world().unwrap();
        for u in independent_points(50) {
            let place = camera.ray(400.0 * u.x, 200.0 * u.y).at(0.3 + 5.0 * u.y);
            let image = image_from_world * place.extend(1.0);
            assert!(
                (image.x / image.w - u.x).abs() < 1e-9 && (image.y / image.w - u.y).abs() < 1e-9
            );
            let depth = -(camera.camera_from_world() * place.extend(1.0)).z;
            assert!((depth - (0.3 + 5.0 * u.y)).abs() < 1e-9);
        }
    }
    let panorama = perspective.with_projection(Projection::Panoramic).unwrap();
    assert_eq!(panorama.image_from_world(), None);
}

#[test]
fn degenerate_parts_are_refused() {
    let refused = |parts| Camera::new(parts).unwrap_err();
    let up = |up| refused(CameraParts { up, ..parts() });
    assert_eq!(up(DVec3::Y), CameraError::UpIsParallel);
    assert_eq!(up(-DVec3::Y), CameraError::UpIsParallel);
    assert_eq!(up(DVec3::ZERO), CameraError::UpIsParallel);
    assert_eq!(up(DVec3::NAN), CameraError::NotFinite);
    let here = CameraParts { look_at: parts().position, ..parts() };
    assert_eq!(refused(here), CameraError::NoDirection);
    for fov in [0.0, 180.0, -3.0, f64::NAN] {
        let error = refused(CameraParts { fov, ..parts() });
        assert!(matches!(error, CameraError::FieldOfView { .. }));
    }
    for resolution in [[0, 4], [4, 0], [70_000, 4]] {
        let error = refused(CameraParts { resolution, ..parts() });
        assert_eq!(error, CameraError::Resolution { found: resolution });
    }
}

#[test]
fn lenses_heights_and_ways_that_cannot_be_are_refused() {
    let camera = Camera::new(parts()).unwrap();
    let lens = Lens { radius: 0.1, focus_distance: 1.0, blades: 0, rotation: 0.0 };
    for bad in [
        Lens { radius: -1.0, ..lens },
        Lens { radius: f64::NAN, ..lens },
        Lens { focus_distance: 0.0, ..lens },
        Lens { rotation: f64::INFINITY, ..lens },
    ] {
        assert_eq!(camera.with_lens(bad), Err(CameraError::Lens));
    }
    for blades in [1, 2, 65] {
        let error = camera.with_lens(Lens { blades, ..lens }).unwrap_err();
        assert_eq!(error, CameraError::Blades { found: blades });
    }
    for height in [0.0, -1.0, f64::INFINITY] {
        assert!(camera.with_projection(Projection::Orthographic { height }).is_err());
    }
    let pose = Pose { position: DVec3::ZERO, look_at: DVec3::Y, up: DVec3::Z };
    assert!(camera.with_motion(pose, [0.0, 1.0]).is_ok());
    let open = camera.with_shutter([0.25, 0.75]).unwrap();
    assert_eq!([0.0, 0.5].map(|u| open.sample(0.0, 0.0, DVec2::ZERO, u).time), [0.25, 0.5]);
    for shutter in [[0.6, 0.5], [-0.1, 1.0], [0.0, 1.1], [f64::NAN, 1.0]] {
        assert!(matches!(camera.with_motion(pose, shutter), Err(CameraError::Shutter { .. })));
        assert!(camera.with_shutter(shutter).is_err());
    }
    // Half way it would look at where it is.
    let past = Pose { position: parts().look_at, look_at: parts().position, up: DVec3::Z };
    assert_eq!(camera.with_motion(past, [0.0, 1.0]), Err(CameraError::Motion));
    let nowhere = Pose { up: DVec3::NAN, ..pose };
    assert_eq!(camera.with_motion(nowhere, [0.0, 1.0]), Err(CameraError::NotFinite));
}
