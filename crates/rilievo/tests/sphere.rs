//! Displaced spheres as users hold them: refusals, poles, worlds.

use std::sync::Arc;

use rilievo::glam::DVec3;
use rilievo::map::{
    CubeFace, HeightMap, Lattice, NormalConvention, NormalMap, NormalTexels, Procedural, Tiling,
    Wrap,
};
use rilievo::relief::{
    CubeRelief, Displacement, Method, ReliefSphere, ReliefSphereError, ShadingNormals,
    SphereOptions,
};
use rilievo::surface::{Quad, Sphere, Surface, World};
use rilievo::{Hit, Part, Ray};

fn map(shape: Procedural) -> HeightMap {
    shape.height_map([64, 32], Lattice::Texel, Wrap::Repeat).unwrap()
}

fn relief(shape: Procedural) -> Arc<CubeRelief> {
    CubeRelief::new(&map(shape), Tiling::default()).unwrap()
}

fn displaced(scale: f64, zero: f64) -> SphereOptions {
    let displacement = Displacement { scale, zero, ..Displacement::default() };
    SphereOptions { displacement, ..SphereOptions::default() }
}

/// Directions all over the sphere.
fn directions(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |k| {
        let z = 2.0 * (f64::from(k) + 0.5) / f64::from(count) - 1.0;
        let (sin, cos) = (2.399_963 * f64::from(k)).sin_cos();
        DVec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z
    })
}

#[test]
fn a_constant_map_is_a_sphere_but_for_its_flat_cells() {
    let relief = relief(Procedural::Flat { value: 0.5 });
    let n = f64::from(relief.cells());
    let center = DVec3::new(1.0, -2.0, 0.5);
    let sphere = ReliefSphere::new(center, 2.0, relief, displaced(0.4, 0.0)).unwrap();
    let plain = Sphere::new(center, 2.2).unwrap();
    for direction in directions(5000) {
        let ray = Ray::new(center + 9.0 * direction, -direction);
        let (hit, want) = (sphere.closest(&ray, &mut ()).unwrap(), plain.closest(&ray).unwrap());
        let sunk = want.position.distance(hit.position);
        assert!(sunk <= 2.2 / (n * n) && hit.t >= want.t - 1e-14, "{sunk}");
        assert!(hit.geometric_normal.dot(direction) > 1.0 - 2.0 / (n * n));
        assert!((hit.uv - want.uv).length() < 1e-12 && hit.front && hit.height <= 0.5 + 1e-12);
        // The derivatives are those of the sphere that is displaced.
        assert!((hit.tangents[1] - want.tangents[1] * (2.0 / 2.2)).length() < 1e-9);
        assert!(hit.shading_normal.dot(direction) > 1.0 - 2.0 / (n * n));
    }
}

#[test]
fn a_hit_names_its_cell_and_its_height() {
    let sphere = ReliefSphere::new(
        DVec3::ZERO,
        1.0,
        relief(Procedural::Fbm { octaves: 3, seed: 1 }),
        displaced(0.2, 0.0),
    );
    let sphere = sphere.unwrap();
    let hit = sphere.closest(&Ray::new(5.0 * DVec3::Y, -DVec3::Y), &mut ()).unwrap();
    let half = sphere.relief().cells() / 2;
    let Part::CubeCell(face, i, j) = hit.part else { panic!("{:?}", hit.part) };
    assert_eq!(face, CubeFace::PosY);
    assert!([half - 1, half].contains(&i) && [half - 1, half].contains(&j));
    let heights = sphere.relief().face(face).heights();
    let sample = f64::from(heights.raw(half, half)) * heights.unit();
    assert!((hit.height - sample).abs() < 1e-12);
    assert!((hit.position - DVec3::Y * (1.0 + 0.2 * sample)).length() < 1e-14);
}

#[test]
fn smooth_normals_have_no_seam_at_the_edges_of_the_cube() {
    let relief = relief(Procedural::Fbm { octaves: 4, seed: 7 });
    let sphere = ReliefSphere::new(DVec3::ZERO, 1.0, relief, displaced(0.3, 0.0)).unwrap();
    let normal =
        |to: DVec3| sphere.closest(&Ray::new(3.0 * to, -to), &mut ()).unwrap().shading_normal;
    for direction in directions(4000) {
        // Onto an edge of the cube, and a little to both sides of it.
        let face = CubeFace::towards(direction);
        let [x, _, z] = face.to_frame(direction);
        let edge = face.from_frame([x, z, z]);
        let across = 1e-9 * face.from_frame([0.0, 1.0, 0.0]);
        let sides = [edge - across, edge + across].map(|to| normal(to.normalize()));
        assert!(sides[0].distance(sides[1]) < 1e-6, "{sides:?}");
    }
}

#[test]
fn a_normal_map_lies_on_the_sphere_like_the_heights() {
    // Leans to the east by 45 degrees, everywhere.
    let texels = NormalTexels::U16(vec![[56_000, 32_768, 56_000]; 4]);
    let lattice = (Lattice::Texel, Wrap::Repeat);
    let leaning = NormalMap::from_texels([2, 2], &texels, NormalConvention::OpenGl, lattice);
    let options = SphereOptions {
        normals: ShadingNormals::Map(Arc::new(leaning.unwrap())),
        ..displaced(0.1, 0.0)
    };
    let flat = relief(Procedural::Flat { value: 0.5 });
    let sphere = ReliefSphere::new(DVec3::ZERO, 1.0, flat, options).unwrap();
    for direction in directions(500) {
        let hit = sphere.closest(&Ray::new(3.0 * direction, -direction), &mut ()).unwrap();
        let east = hit.tangents[0].normalize();
        let want = (east + direction).normalize();
        assert!(hit.shading_normal.distance(want) < 1e-3, "{}", hit.shading_normal);
    }
}

#[test]
fn rays_of_any_size_end() {
    let shape = Procedural::Fbm { octaves: 3, seed: 2 };
    for method in [Method::Dda, Method::Pyramid] {
        let options = SphereOptions { method, ..displaced(0.3, 0.0) };
        let center = DVec3::new(5.0, -1.0, 2.0);
        let sphere = ReliefSphere::new(center, 1.0, relief(shape), options).unwrap();
        let sizes = [0.0, 1e-300, 1e-150, 1e-17, 1.0, 1e17, 1e150, 1e300];
        for (size, origin) in sizes.into_iter().flat_map(|a| sizes.map(|b| (a, b))) {
            for direction in directions(40) {
                let ray = Ray::new(
                    center + origin * direction.any_orthonormal_vector(),
                    size * direction,
                );
                let hit = sphere.closest(&ray, &mut ());
                assert!(hit.is_none_or(|hit| hit.t >= 0.0 && hit.position.is_finite()));
                assert_eq!(sphere.occludes(&ray, &mut ()), hit.is_some());
                assert!(hit.is_some() || size == 0.0 || origin >= 1.0, "{ray:?}");
            }
        }
    }
}

#[test]
fn tiles_repeat_around_the_sphere() {
    let studs = map(Procedural::Studded { studs: [2, 2] });
    let tiling = Tiling { tile: [4.0, 2.0], shift: [0.125, 0.5] };
    let relief = CubeRelief::new(&studs, tiling).unwrap();
    assert_eq!(relief.cells(), 84);
    let Tiling { tile, shift } = tiling;
    let displacement = Displacement { scale: 0.1, tile, shift, ..Displacement::default() };
    let options = SphereOptions { displacement, ..SphereOptions::default() };
    let sphere = ReliefSphere::new(DVec3::ZERO, 1.0, relief, options).unwrap();
    let mut near = 0;
    for direction in directions(2000) {
        let hit = sphere.closest(&Ray::new(3.0 * direction, -direction), &mut ()).unwrap();
        let want = studs.height_at(hit.uv.x * 4.0 + 0.125, hit.uv.y * 2.0 + 0.5);
        near += u32::from((hit.height - want).abs() < 0.02);
    }
    // All but those on the flanks, a cell wide here and there.
    assert!(near > 1500, "{near}");
}

#[test]
fn bad_spheres_are_refused_with_a_reason() {
    let relief = relief(Procedural::Fbm { octaves: 2, seed: 4 });
    let make = |radius: f64, options: SphereOptions| {
        ReliefSphere::new(DVec3::ZERO, radius, Arc::clone(&relief), options).map(|_| ())
    };
    assert_eq!(make(0.0, displaced(0.1, 0.0)), Err(ReliefSphereError::Radius(0.0)));
    for options in [displaced(0.0, 0.0), displaced(f64::NAN, 0.0), displaced(1.0, f64::INFINITY)] {
        assert!(matches!(make(1.0, options), Err(ReliefSphereError::Displacement { .. })));
    }
    for displacement in [
        Displacement { tile: [2.0, 1.0], scale: 0.1, ..Displacement::default() },
        Displacement { shift: [0.0, 0.1], scale: 0.1, ..Displacement::default() },
    ] {
        let options = SphereOptions { displacement, ..SphereOptions::default() };
        let error = make(1.0, options).unwrap_err().to_string();
        assert!(error.contains("with which the map was resampled"), "{error}");
    }
    let inverted = make(1.0, displaced(1.0, 1.5)).unwrap_err();
    assert!(matches!(inverted, ReliefSphereError::Inverted { lowest, .. } if lowest < 0.0));
    let method = SphereOptions { method: Method::March, ..displaced(0.1, 0.0) };
    assert_eq!(make(1.0, method), Err(ReliefSphereError::Method(Method::March)));
    let normals = SphereOptions { normals: ShadingNormals::Published, ..displaced(0.1, 0.0) };
    assert_eq!(make(1.0, normals), Err(ReliefSphereError::Normals));
    let nowhere = ReliefSphere::new(DVec3::NAN, 1.0, relief, displaced(0.1, 0.0));
    assert_eq!(nowhere.map(|_| ()), Err(ReliefSphereError::Center));
}

#[test]
fn a_world_of_spheres_and_floors_is_every_surface_tried_in_turn() {
    let relief = relief(Procedural::Fbm { octaves: 4, seed: 9 });
    let mut surfaces = Vec::<Surface>::new();
    for k in 0..5 {
        let center = DVec3::new(1.5 * f64::from(k), 0.3 * f64::from(k % 2), 0.8);
        let options = displaced(0.2 * if k % 2 == 0 { 1.0 } else { -1.0 }, 0.2);
        let sphere = ReliefSphere::new(center, 0.6, Arc::clone(&relief), options).unwrap();
        surfaces.push(sphere.into());
    }
    let corners = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]];
    let corners = corners.map(|[x, y]| DVec3::new(x, y, 0.0));
    surfaces.push(Quad::new(corners, false).unwrap().into());
    for count in [6, 3, 1] {
        let world = World::new(surfaces[6 - count..].to_vec());
        let boxes = world.surfaces().iter().map(Surface::bounds);
        assert!(boxes.into_iter().all(|bounds| world.bounds().contains(&bounds)));
        let mut start = None::<Hit>;
        for (k, direction) in directions(6000).enumerate() {
            let mut ray = Ray::new(DVec3::new(3.0, -2.0, 1.0), direction);
            if let Some(hit) = start.filter(|_| k % 2 == 1) {
                ray = hit.spawn(direction);
            }
            if k % 3 == 0 {
                ray.t_max = 2.0;
            }
            let hit = world.closest(&ray, &mut ());
            let each = world.surfaces().iter().enumerate().filter_map(|(index, surface)| {
                let from = ray.from.filter(|from| from.surface == index as u32);
                let hit = surface.closest(&Ray { from, ..ray }, &mut ())?;
                Some(Hit { surface: index as u32, ..hit })
            });
            assert_eq!(hit, each.min_by(|a, b| a.t.total_cmp(&b.t)));
            assert_eq!(hit.is_some(), world.occluded(&ray, &mut ()));
            start = hit.or(start);
        }
    }
}
