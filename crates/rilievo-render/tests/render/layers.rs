//! What the AOV layers hold.

use crate::scenes::{Builder, camera, diffuse};
use glam::DVec3;
use rilievo_render::{Aov, Integrator, Material, RenderOptions, RenderSettings, Rgb, render};

#[test]
fn pixel_centers_of_a_wall() {
    // The wall y = 1, |x|, |z| <= 1, seen from the origin under 126.87 degrees: the image plane at
    // distance 1 is 4 x 4, so a pixel of 8 x 8 is 1/2 wide and its centre ray is known.
    let wall = [DVec3::new(-1.0, 1.0, -1.0), DVec3::X * 2.0, DVec3::Z * 2.0];
    let fov = 2.0 * 2f64.atan().to_degrees();
    let paint = Material { reflective: Rgb::new(0.25, 0.0, 0.0), ..diffuse(0.5) };
    let settings = RenderSettings { integrator: Integrator::Aov, ..RenderSettings::default() };
    let scene = Builder::default()
        .quad(wall, paint)
        .scene(camera([0.0; 3], [0.0, 1.0, 0.0], fov, [8, 8]), settings);
    let options =
        RenderOptions { pixel_centers: true, aovs: &Aov::ALL, ..RenderOptions::default() };
    let (film, stats) = render(&scene, &options).unwrap();
    assert_eq!((stats.rays.camera, stats.rays.total()), (64, 64));
    for i in 0..64 {
        let (x, z) = ((i % 8) as f32 * 0.5 - 1.75, 1.75 - (i / 8) as f32 * 0.5);
        let at = |aov: Aov| {
            let layer = film.layer(aov).unwrap();
            &layer.values()[i * layer.channels()..(i + 1) * layer.channels()]
        };
        let near = |aov: Aov, expected: &[f32]| {
            let found = at(aov);
            let close = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6);
            assert!(close && found.len() == expected.len(), "{aov} {i}: {found:?}");
        };
        if x.abs() < 1.0 && z.abs() < 1.0 {
            near(Aov::P, &[x, 1.0, z]);
            // X cross Z is -Y: the front looks at the camera.
            near(Aov::N, &[0.0, -1.0, 0.0]);
            near(Aov::Ns, &[0.0, -1.0, 0.0]);
            near(Aov::Uv, &[0.5 + 0.5 * x, 0.5 + 0.5 * z]);
            near(Aov::Height, &[0.0]);
            near(Aov::Z, &[1.0]);
            near(Aov::Albedo, &[0.75, 0.5, 0.5]);
            let cosine = 1.0 / (1.0 + x * x + z * z).sqrt();
            assert!((film.radiance()[i][0] - 0.75 * cosine).abs() < 1e-6);
        } else {
            assert!(at(Aov::P).iter().all(|c| c.is_nan()));
            assert_eq!(at(Aov::Z), [f32::INFINITY]);
            near(Aov::N, &[0.0; 3]);
            near(Aov::Albedo, &[0.0; 3]);
            assert_eq!(film.radiance()[i], [0.0; 3]);
        }
    }
}
