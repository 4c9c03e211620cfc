//! The judge is judged: closed forms, and rows of cells against all cells.

use rayon::prelude::*;
use rilievo::Wall;
use rilievo::map::{Lattice, Samples, Wrap};

use super::*;
use crate::maps::Shape;
use crate::random::Random;
use crate::rays::Family;
use crate::scenes::{self, unit_face};

fn ray(o: [f64; 3], d: [f64; 3]) -> Ray {
    Ray::new(DVec3::from_array(o), DVec3::from_array(d))
}

#[test]
fn a_flat_relief_is_a_plane() {
    let map = Shape::Flat(1.0).codes([4, 4], Lattice::Texel, Wrap::Repeat);
    let oracle = Oracle::new(&map, unit_face(0.25));
    let hit = oracle.closest(&ray([0.1, 0.2, 2.25], [0.2, 0.1, -1.0])).unwrap();
    assert!((hit.t - 2.0).abs() < 1e-14 && hit.front);
    assert!(hit.position.distance(DVec3::new(0.5, 0.4, 0.25)) < 1e-14);
    let hit = oracle.closest(&ray([0.5, 0.5, 0.0], [0.0, 0.0, 1.0])).unwrap();
    assert!((hit.t - 0.25).abs() < 1e-15 && !hit.front);
    assert!(oracle.closest(&ray([1.1, 0.5, 2.0], [0.0, 0.0, -1.0])).is_none());
    assert!(oracle.closest(&ray([0.5, 0.5, 0.2], [1.0, 0.0, 0.0])).is_none());
}

#[test]
fn a_ramp_is_met_where_its_plane_is() {
    let map = Shape::Ramp(0.5, 0.25).floats([9, 5], Lattice::Vertex, Wrap::Clamp);
    let oracle = Oracle::new(&map, unit_face(1.0));
    let mut random = Random::new(&[1]);
    let mut hits = 0;
    for _ in 0..2000 {
        let o = random.direction() * 2.0;
        let aim = DVec3::new(random.unit(), random.unit(), random.unit());
        let d = (aim - o) * random.range(0.3, 3.0);
        let t = (0.5 * o.x + 0.25 * o.y - o.z) / (d.z - 0.5 * d.x - 0.25 * d.y);
        let p = o + t * d;
        let inside = t >= 0.0 && (0.0..=1.0).contains(&p.x) && (0.0..=1.0).contains(&p.y);
        let hit = oracle.closest(&Ray::new(o, d));
        assert_eq!(hit.is_some(), inside, "{o} {d}");
        if let Some(hit) = hit {
            assert!((hit.t - t).abs() < 1e-12 && hit.front == (o.z > 0.5 * o.x + 0.25 * o.y));
            hits += 1;
        }
    }
    assert!(hits > 500);
}

#[test]
fn a_saddle_seen_along_its_diagonal_is_met_twice() {
    let samples = Samples::F32(vec![0.0, 0.0, 0.0, 1.0]);
    let map = HeightMap::new(2, 2, samples, Lattice::Vertex, Wrap::Repeat).unwrap();
    let face = unit_face(1.0);
    let along = ray([-1.0, 2.0, 0.1875], [1.0, -1.0, 0.0]);
    let hit = Oracle::new(&map, face.clone()).closest(&along).unwrap();
    assert!((hit.t - 1.25).abs() < 1e-14 && hit.front && hit.part == Part::Cell(0, 0));
    let one_sided = Placement { one_sided: true, ..face };
    let inside = ray([0.5, 0.5, 0.1875], [1.0, -1.0, 0.0]);
    assert!(Oracle::new(&map, one_sided.clone()).closest(&inside).is_none());
    let two_sided = Placement { one_sided: false, ..one_sided };
    let hit = Oracle::new(&map, two_sided).closest(&inside).unwrap();
    assert!((hit.t - 0.25).abs() < 1e-14 && !hit.front);
}

#[test]
fn walls_stand_on_the_border_and_face_the_air() {
    let map = Shape::Flat(1.0).codes([3, 3], Lattice::Vertex, Wrap::Clamp);
    let low = ray([-1.0, 0.5, 0.1], [1.0, 0.0, 0.0]);
    assert!(Oracle::new(&map, unit_face(0.25)).closest(&low).is_none());
    let closed = Placement { closed: true, ..unit_face(0.25) };
    let hit = Oracle::new(&map, closed.clone()).closest(&low).unwrap();
    assert_eq!((hit.t, hit.front, hit.part), (1.0, true, Part::Wall(Wall::LowU)));
    let from_within = ray([0.5, 0.5, 0.1], [0.0, 1.0, 0.0]);
    let hit = Oracle::new(&map, closed.clone()).closest(&from_within).unwrap();
    assert_eq!((hit.t, hit.front, hit.part), (0.5, false, Part::Wall(Wall::HighV)));
    // Sunken, the same walls face the pit.
    let pit = Placement { scale: -0.25, ..closed };
    let hit = Oracle::new(&map, pit).closest(&ray([0.5, 0.5, -0.1], [0.0, 1.0, 0.0])).unwrap();
    assert_eq!((hit.t, hit.front, hit.part), (0.5, true, Part::Wall(Wall::HighV)));
}

#[test]
fn a_repeated_tile_that_jumps_has_a_wall_at_its_seam() {
    let map = Shape::Ramp(1.0, 0.0).floats([5, 5], Lattice::Vertex, Wrap::Repeat);
    let place = Placement { tile: [2.0, 1.0], ..unit_face(0.5) };
    let oracle = Oracle::new(&map, place.clone());
    let hit = oracle.closest(&ray([0.9, 0.6, 0.1], [-1.0, 0.0, 0.0]));
    // The second tile rises to the right: the ray leaves it at 0.6 and meets the seam at 0.5.
    assert_eq!(hit.unwrap().part, Part::Cell(4, 2));
    let hit = oracle.closest(&ray([0.55, 0.6, 0.4], [-1.0, 0.0, 0.0])).unwrap();
    assert_eq!((hit.front, hit.part), (true, Part::Wall(Wall::SeamU(4))));
    assert!((hit.t - 0.05).abs() < 1e-15);
    let mirrored = map.with_lattice(Lattice::Vertex, Wrap::Mirror);
    let none = Oracle::new(&mirrored, place).closest(&ray([0.55, 0.6, 0.4], [-1.0, 0.0, 0.0]));
    assert_eq!(none.unwrap().part, Part::Cell(3, 2));
}

#[test]
fn a_half_cell_lies_beyond_the_border_of_a_texel_lattice() {
    // Samples 0 and 1 at u = 1/4 and 3/4; repeated, the ramp comes down again over the border.
    let samples = Samples::F32(vec![0.0, 1.0, 0.0, 1.0]);
    let map = HeightMap::new(2, 2, samples, Lattice::Texel, Wrap::Repeat).unwrap();
    let oracle = Oracle::new(&map, unit_face(1.0));
    let height = |u: f64| 3.0 - oracle.closest(&ray([u, 0.4, 3.0], [0.0, 0.0, -1.0])).unwrap().t;
    for (u, want) in [(0.25, 0.0), (0.5, 0.5), (0.75, 1.0), (0.875, 0.75), (0.125, 0.25)] {
        assert!((height(u) - want).abs() < 1e-14, "{u}: {}", height(u));
    }
    assert!(oracle.closest(&ray([1.01, 0.4, 3.0], [0.0, 0.0, -1.0])).is_none());
}

#[test]
fn rows_of_cells_find_what_all_cells_find() {
    let small: Vec<_> = scenes::all()
        .into_iter()
        .filter(|scene| scene.map.width() * scene.map.height() <= 31 * 31)
        .collect();
    assert!(small.len() >= 20);
    let rays = 110_000 / small.len() as u64;
    small.par_iter().enumerate().for_each(|(index, scene)| {
        let oracle = scene.oracle();
        let mut hits = 0;
        for k in 0..rays {
            let family = Family::ALL[k as usize % Family::ALL.len()];
            let ray = family.ray(&oracle, &mut Random::new(&[9, index as u64, k]));
            let (rows, all) = (oracle.closest(&ray), oracle.closest_of_all_cells(&ray));
            hits += u32::from(all.is_some());
            let same = match (rows, all) {
                (Some(a), Some(b)) => a.position.distance(b.position) <= 1e-7 * oracle.size(),
                (None, None) => true,
                _ => false,
            };
            assert!(same, "{}: {ray:?}\n{rows:?}\n{all:?}", scene.name);
        }
        assert!(hits > 100, "{}: {hits} hits", scene.name);
    });
}

#[test]
fn a_start_on_a_convex_bump_leaves_it_and_in_a_bowl_meets_the_other_side() {
    let samples = Samples::F32(vec![0.0, 0.0, 0.0, 1.0]);
    let map = HeightMap::new(2, 2, samples, Lattice::Vertex, Wrap::Clamp).unwrap();
    let oracle = Oracle::new(&map, unit_face(1.0));
    let start = oracle.start(Part::Cell(0, 0), DVec3::new(0.25, 0.25, 0.07));
    assert!(oracle.start_point(&start).distance(DVec3::new(0.25, 0.25, 0.0625)) < 1e-15);
    // Along x = y the patch is t^2, a bowl: the chord to (0.75, 0.75) meets it again there.
    let hit = oracle.closest_from(&start, DVec3::new(0.5, 0.5, 0.5)).unwrap();
    assert!((hit.t - 1.0).abs() < 1e-14 && hit.front);
    assert!(oracle.closest_from(&start, DVec3::new(0.1, 0.1, 1.0)).is_none());
    // Across it is x (1/2 - x), a hump: a ray below the tangent goes in and comes out.
    let hit = oracle.closest_from(&start, DVec3::new(0.1, -0.1, -0.002)).unwrap();
    assert!((hit.t - 0.2).abs() < 1e-13 && !hit.front);
}
