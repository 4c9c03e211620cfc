//! Displaced faces against closed forms: where rays meet planes, walls and seams.

use std::sync::Arc;

use rilievo::glam::DVec3;
use rilievo::map::{HeightMap, Lattice, Layout, Procedural, Samples, Wrap};
use rilievo::relief::{
    Displacement, FaceError, FaceOptions, Method, Relief, ReliefFace, ShadingNormals,
};
use rilievo::{Hit, Part, Ray, Wall};

const UNIT: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];

fn floats(width: u32, height: u32, values: &[f32], lattice: Lattice) -> Arc<Relief> {
    let samples = Samples::F32(values.to_vec());
    Arc::new(Relief::new(HeightMap::new(width, height, samples, lattice, Wrap::Repeat).unwrap()))
}

/// A flat map at height 1.
fn flat() -> Arc<Relief> {
    floats(3, 3, &[1.0; 9], Lattice::Vertex)
}

fn face(relief: &Arc<Relief>, options: FaceOptions) -> ReliefFace {
    ReliefFace::new(UNIT, relief.clone(), options).unwrap()
}

fn scaled(scale: f64) -> FaceOptions {
    let displacement = Displacement { scale, ..Displacement::default() };
    FaceOptions { displacement, ..FaceOptions::default() }
}

fn shoot(face: &ReliefFace, origin: [f64; 3], direction: [f64; 3]) -> Option<Hit> {
    face.closest(&Ray::new(origin.into(), direction.into()), &mut ())
}

#[test]
fn a_flat_map_is_a_lifted_plane() {
    let face = face(&flat(), scaled(0.25));
    let hit = shoot(&face, [0.3, 0.2, 2.0], [0.1, 0.2, -1.0]).unwrap();
    assert!((hit.t - 1.75).abs() < 1e-12);
    assert!((hit.position - DVec3::new(0.475, 0.55, 0.25)).length() < 1e-12);
    assert!((hit.uv.x - 0.475).abs() < 1e-12 && (hit.uv.y - 0.55).abs() < 1e-12);
    assert_eq!((hit.height, hit.front), (1.0, true));
    assert!((hit.geometric_normal - DVec3::Z).length() < 1e-12);
    let below = shoot(&face, [0.3, 0.2, 0.1], [0.1, 0.2, 1.0]).unwrap();
    assert!(!below.front && (below.t - 0.15).abs() < 1e-12);
    assert!(shoot(&face, [0.3, 0.2, 0.1], [0.1, 0.2, -1.0]).is_none());
}

#[test]
fn a_ramp_has_the_normal_of_its_plane_under_any_metric() {
    let relief = floats(2, 2, &[0.0, 1.0, 0.0, 1.0], Lattice::Vertex);
    let corners = [
        DVec3::ZERO,
        DVec3::new(4.0, 0.0, 0.0),
        DVec3::new(4.0, 0.0, -2.0),
        DVec3::new(0.0, 0.0, -2.0),
    ];
    for normals in [ShadingNormals::Exact, ShadingNormals::Smooth, ShadingNormals::Published] {
        let options = FaceOptions { normals, ..scaled(3.0) };
        let face = ReliefFace::new(corners, relief.clone(), options).unwrap();
        // The face lies in y = 0 with normal +y and rises by 3 over its 4 units of u.
        let hit = shoot(&face, [1.0, 9.0, -1.0], [0.0, -1.0, 0.0]).unwrap();
        assert!((hit.position.y - 0.75).abs() < 1e-12);
        let want = DVec3::new(-0.6, 0.8, 0.0);
        assert!((hit.geometric_normal - want).length() < 1e-12, "{}", hit.geometric_normal);
        assert!((hit.shading_normal - want).length() < 1e-12, "{}", hit.shading_normal);
    }
}

#[test]
fn negative_scale_turns_the_relief_over_but_not_its_front() {
    let face = face(&flat(), scaled(-0.25));
    let hit = shoot(&face, [0.5, 0.5, 1.0], [0.0, 0.0, -1.0]).unwrap();
    assert!((hit.position.z + 0.25).abs() < 1e-12 && hit.front);
    assert!(hit.geometric_normal.z > 0.99);
}

#[test]
fn a_one_sided_face_lets_rays_from_behind_through_to_the_next_front() {
    // A tent: from behind the near slope, out, and into the far slope's front? A ray from below
    // leaves through the near slope and comes down on nothing: only a valley can catch it.
    let valley = floats(3, 2, &[1.0, 0.0, 1.0, 1.0, 0.0, 1.0], Lattice::Vertex);
    let options = FaceOptions { one_sided: true, ..scaled(1.0) };
    let one_sided = face(&valley, options);
    let ray = ([-0.5, 0.5, 0.5], [1.0, 0.0, 0.0]);
    let hit = shoot(&one_sided, ray.0, ray.1).unwrap();
    assert!(hit.front && (hit.position.x - 0.75).abs() < 1e-12);
    let two_sided = face(&valley, scaled(1.0));
    let hit = shoot(&two_sided, ray.0, ray.1).unwrap();
    assert!(!hit.front && (hit.position.x - 0.25).abs() < 1e-12);
}

#[test]
fn closed_borders_have_walls_down_to_the_face() {
    let open = face(&flat(), scaled(0.5));
    let closed = face(&flat(), FaceOptions { closed: true, ..scaled(0.5) });
    for (origin, direction, wall, normal) in [
        ([-1.0, 0.4, 0.2], [1.0, 0.0, 0.0], Wall::LowU, DVec3::NEG_X),
        ([2.0, 0.4, 0.2], [-1.0, 0.0, 0.0], Wall::HighU, DVec3::X),
        ([0.4, -1.0, 0.2], [0.0, 1.0, 0.0], Wall::LowV, DVec3::NEG_Y),
        ([0.4, 2.0, 0.2], [0.0, -1.0, 0.0], Wall::HighV, DVec3::Y),
    ] {
        assert!(shoot(&open, origin, direction).is_none());
        let hit = shoot(&closed, origin, direction).unwrap();
        assert_eq!((hit.part, hit.front), (Part::Wall(wall), true));
        assert!((hit.t - 1.0).abs() < 1e-12 && (hit.geometric_normal - normal).length() < 1e-12);
        let over = [origin[0], origin[1], 0.6];
        assert!(shoot(&closed, over, direction).is_none());
        // From inside, the far wall is met from behind; from the wall outward, nothing is.
        let inside = shoot(&closed, [0.5, 0.5, 0.2], direction.map(|d| -d)).unwrap();
        assert_eq!((inside.part, inside.front), (Part::Wall(wall), false));
        assert!(closed.closest(&hit.spawn(normal), &mut ()).is_none());
        let inward = closed.closest(&hit.spawn(-normal), &mut ()).unwrap();
        assert!((inward.t - 1.0).abs() < 1e-12 && !inward.front);
    }
}

#[test]
fn a_jump_between_tiles_is_closed_by_a_wall() {
    // Rises from 0 to 1 over each tile; falls back at every seam.
    let saw = floats(2, 2, &[0.0, 1.0, 0.0, 1.0], Lattice::Vertex);
    let mut options = scaled(1.0);
    options.displacement.tile = [4.0, 1.0];
    let face = face(&saw, options);
    let hit = shoot(&face, [1.5, 0.5, 0.5], [-1.0, 0.0, 0.0]).unwrap();
    assert_eq!(hit.part, Part::Cell(3, 0));
    assert!((hit.position.x - 0.875).abs() < 1e-12 && !hit.front);
    let hit = face.closest(&hit.spawn(DVec3::NEG_X), &mut ()).unwrap();
    assert_eq!((hit.part, hit.front), (Part::Wall(Wall::SeamU(3)), true));
    assert!((hit.position.x - 0.75).abs() < 1e-12);
    assert!((hit.geometric_normal - DVec3::X).length() < 1e-12);
}

#[test]
fn hits_past_the_end_of_the_ray_do_not_count() {
    let face = face(&flat(), scaled(0.25));
    let ray = Ray { t_max: 1.74, ..Ray::new(DVec3::new(0.5, 0.5, 2.0), DVec3::NEG_Z) };
    assert!(!face.occludes(&ray, &mut ()));
    assert!(face.occludes(&Ray { t_max: 1.76, ..ray }, &mut ()));
}

#[test]
fn tiny_far_and_huge_faces_keep_their_digits() {
    let bump = Procedural::Gaussian.height_map([65, 65], Lattice::Vertex, Wrap::Repeat).unwrap();
    let relief = Arc::new(Relief::new(bump));
    let at_home = face(&relief, scaled(0.3));
    let ray = Ray::new(DVec3::new(-1.0, 0.3, 0.9), DVec3::new(1.0, 0.1, -0.5));
    let want = at_home.closest(&ray, &mut ()).unwrap();
    for size in [1e-3, 1.0, 1e6] {
        for corner in [DVec3::ZERO, DVec3::new(148_376.0, 1234.0, -223_423.0)] {
            let moved = ReliefFace::new(
                UNIT.map(|c| corner + size * c),
                relief.clone(),
                scaled(0.3 * size),
            )
            .unwrap();
            let ray = Ray::new(corner + size * ray.origin, size * ray.direction);
            let hit = moved.closest(&ray, &mut ()).unwrap();
            let digits = 1e-9 + corner.length() / size * 1e-14;
            assert!((hit.t - want.t).abs() < digits, "size {size}: {} {}", hit.t, want.t);
            assert_eq!(hit.part, want.part);
        }
    }
}

#[test]
fn bad_faces_are_refused_with_a_reason() {
    let new = |corners, options| ReliefFace::new(corners, flat(), options).unwrap_err();
    let mut corners = UNIT;
    corners[2].z = 0.1;
    assert!(matches!(new(corners, scaled(1.0)), FaceError::NotParallelogram { .. }));
    assert_eq!(new([DVec3::ZERO; 4], scaled(1.0)), FaceError::Degenerate);
    assert_eq!(new([DVec3::NAN; 4], scaled(1.0)), FaceError::Degenerate);
    assert!(matches!(new(UNIT, scaled(0.0)), FaceError::Displacement { key: "scale", .. }));
    let mut options = scaled(1.0);
    options.displacement.tile = [1.0, f64::INFINITY];
    assert!(matches!(new(UNIT, options.clone()), FaceError::Displacement { key: "tile", .. }));
    options.displacement.tile = [1e9, 1.0];
    assert!(matches!(new(UNIT, options), FaceError::TooManyCells { .. }));
    let options = FaceOptions { method: Method::Distance, ..scaled(1.0) };
    assert!(matches!(new(UNIT, options), FaceError::NoDistanceMap { .. }));
}

#[test]
fn rays_without_a_direction_or_with_broken_numbers_hit_nothing() {
    let face = face(&flat(), scaled(0.25));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(shoot(&face, [bad, 0.5, 1.0], [0.0, 0.0, -1.0]).is_none());
        assert!(shoot(&face, [0.5, 0.5, 1.0], [0.0, bad, -1.0]).is_none());
    }
    assert!(shoot(&face, [0.5, 0.5, 0.1], [0.0; 3]).is_none());
    assert!(shoot(&face, [0.5, 0.5, 1e300], [0.0, 0.0, -1e-300]).is_none());
}

/// Heights so far from 0 that the slack of the bounds is wider than their range: a ray that left over
/// the border was led to a node that is not there.
#[test]
fn rays_leave_a_float_map_far_from_zero() {
    for (size, layout) in [70, 100, 300].into_iter().flat_map(|n| Layout::ALL.map(|l| (n, l))) {
        for step in [0.0, 0.25] {
            let heights = (0..size * size).map(|k| 3e6 + step * (k % 7) as f32).collect();
            let samples = Samples::F32(heights);
            let map = HeightMap::new(size, size, samples, Lattice::Vertex, Wrap::Clamp).unwrap();
            let relief = Arc::new(Relief::with_layout(map, layout));
            let displacement = Displacement { zero: 3e6, ..Displacement::default() };
            let options = FaceOptions { displacement, ..FaceOptions::default() };
            let face = ReliefFace::new(UNIT, relief, options).unwrap();
            for k in 0..2000 {
                let share = |p: u32| f64::from(k * p % 1999) / 1999.0;
                let above = 6.0 * f64::from(step) + 0.3 + share(7);
                let from = DVec3::new(share(11), share(13), above);
                let level = DVec3::new(share(17) - 0.5, share(19) - 0.5, 0.0);
                assert!(face.closest(&Ray::new(from, level), &mut ()).is_none(), "{from} {level}");
            }
        }
    }
}

/// The same for codes: a ray just above the lowest height meets the empty maximum of a lane beyond the
/// map, which is that height.
#[test]
fn rays_leave_a_map_of_codes_just_above_its_lowest_height() {
    for (size, layout) in [70, 100, 300].into_iter().flat_map(|n| Layout::ALL.map(|l| (n, l))) {
        let samples = Samples::U16(vec![0; (size * size) as usize]);
        let map = HeightMap::new(size, size, samples, Lattice::Vertex, Wrap::Clamp).unwrap();
        let relief = Arc::new(Relief::with_layout(map, layout));
        let face = ReliefFace::new(UNIT, relief, FaceOptions::default()).unwrap();
        for k in 0..2000 {
            let share = |p: u32| f64::from(k * p % 1999) / 1999.0;
            let from = DVec3::new(share(11), share(13), 1e-9 + 1e-6 * share(7));
            let level = DVec3::new(share(17) - 0.5, share(19) - 0.5, 0.0);
            assert!(face.closest(&Ray::new(from, level), &mut ()).is_none(), "{from} {level}");
        }
    }
}
