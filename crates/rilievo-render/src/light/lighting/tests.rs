//! Lights of every plain kind: their densities are those of their samples.

use std::cell::Cell;
use std::f64::consts::TAU;

use rilievo::Ray;
use rilievo::mesh::{Mesh, MeshData, Triangle};
use rilievo::surface::{Quad, Sphere};

use super::*;
use crate::light::EnvironmentPlacement;
use crate::sampler::chi_square::{chi_square_z, independent_points};
use crate::texture::{ColourImage, Texels};

/// Lights of every kind that has a size, none before another as seen from the origin.
fn world() -> World {
    let quad = |corners: [[f64; 3]; 4]| {
        Surface::Quad(Quad::new(corners.map(DVec3::from_array), false).unwrap())
    };
    let positions = [[-2.0, 1.0, -1.0], [-2.0, -1.0, -1.0], [-2.0, -1.0, 1.0], [-2.0, 1.0, 1.2]];
    let triangle = |positions| Triangle { positions, normals: None, uvs: None };
    let data = MeshData {
        positions: positions.map(DVec3::from_array).to_vec(),
        triangles: vec![triangle([0, 2, 1]), triangle([0, 3, 2])],
        ..MeshData::default()
    };
    World::new(vec![
        // A rectangle, near and large; a parallelogram; any quad; a mesh; a ball.
        quad([[-1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0]]),
        quad([[-1.0, -1.0, -2.0], [1.0, -1.0, -2.0], [1.5, 1.0, -2.0], [-0.5, 1.0, -2.0]]),
        quad([[3.0, -1.0, -1.0], [3.0, -1.5, 1.0], [3.0, 1.0, 1.2], [3.0, 1.0, -1.0]]),
        Surface::Mesh(Mesh::new(data).unwrap()),
        Surface::Sphere(Sphere::new(DVec3::new(0.0, 4.0, 0.0), 2.0).unwrap()),
    ])
}

#[test]
fn directions_follow_the_density_that_is_told() {
    const CELLS: usize = 20;
    const FINE: usize = 40;
    const SAMPLES: u32 = 200_000;
    let world = world();
    let texels = (0..8 * 4).map(|k| [0.1 + (k % 5) as f32; 3]).collect();
    let sky = ColourImage::new(8, 4, Texels::Linear(texels)).unwrap();
    let sky = Environment::new(&sky, EnvironmentPlacement::default()).unwrap();
    let sun = SunLight::new(DVec3::Y, Rgb::ONE, 60.0).unwrap();
    let materials: Vec<Material> = (0..5)
        .map(|k| Material { emitted: Rgb::splat(1.0 + f64::from(k)), ..Material::default() })
        .collect();
    let material = |surface: u32| &materials[surface as usize];
    let lamps = [Light::Sun(sun)];
    let all = Lighting::new(&world, material, &lamps, Some(Arc::new(sky)));
    assert_eq!((all.infinite(), all.tree.len()), (2, 7));
    let at = Receiver { position: DVec3::ZERO, normal: None, both_sides: false, time: 0.0 };

    let cell = |d: DVec3| {
        let turn = (d.y.atan2(d.x) / TAU).rem_euclid(1.0);
        let place = |x: f64| ((x * CELLS as f64) as usize).min(CELLS - 1);
        place(0.5 + 0.5 * d.z) * CELLS + place(turn)
    };
    let mut observed = vec![0.0; CELLS * CELLS];
    let points: Vec<DVec2> = independent_points(2 * SAMPLES).collect();
    for pair in points.chunks_exact(2) {
        let Some(Drawn::Point(sample, _)) = all.sample(&world, &at, pair[0].x, pair[1]) else {
            panic!("all are seen")
        };
        assert!(sample.pdf > 0.0 && sample.weight.min_element() > 0.0);
        observed[cell(sample.direction)] += 1.0;
    }
    let mut expected = vec![0.0; CELLS * CELLS];
    let n = CELLS * FINE;
    for k in 0..n * n {
        let z = -1.0 + 2.0 * ((k / n) as f64 + 0.5) / n as f64;
        let (sin, cos) = (TAU * ((k % n) as f64 + 0.5) / n as f64).sin_cos();
        let level = (1.0 - z * z).sqrt();
        let d = DVec3::new(level * cos, level * sin, z);
        let density = Cell::new(0.0);
        all.escaped(d, |pdf| {
            density.set(density.get() + pdf);
            1.0
        });
        if let Some(hit) = world.closest(&Ray::new(DVec3::ZERO, d), &mut ()) {
            assert!(hit.front, "{d}");
            density.set(density.get() + all.pdf_of_hit(&world, &at, d, &hit));
        }
        expected[cell(d)] += density.get() * 2.0 * TAU / (n * n) as f64 * f64::from(SAMPLES);
    }
    let total = expected.iter().sum::<f64>() / f64::from(SAMPLES);
    assert!((total - 1.0).abs() < 2e-3, "the density integrates to {total}");
    let z = chi_square_z(&observed, &expected);
    assert!(z < 4.0, "chi-square is {z} deviations too large");
}
