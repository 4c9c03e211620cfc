//! Rays that are traced together, as packets or not, get the bits of the ray alone: on every scene, layout and
//! SIMD level.

use rilievo::glam::DVec3;
use rilievo::map::Layout;
use rilievo::relief::{Crossing, Method, ReliefFace};
use rilievo::{Coherence, Ray, SimdLevel};
use rilievo_tests::kernel;
use rilievo_tests::random::Random;
use rilievo_tests::rays::Family;
use rilievo_tests::scenes;

/// Rays of a packet, and a few more, so that a second one is begun.
const RAYS: usize = 21;

/// Rays that go about the same way as `ray`: directions turned by up to `spread`, starts moved by up
/// to `spread` times the length of the direction.
fn neighbours(ray: &Ray, spread: f64, random: &mut Random) -> Vec<Ray> {
    let reach = spread * ray.direction.length();
    let mut jitter = || {
        let mut unit = || 2.0 * random.unit() - 1.0;
        reach * DVec3::new(unit(), unit(), unit())
    };
    (0..RAYS)
        .map(|k| {
            let direction = ray.direction + jitter();
            let moved = if k % 3 == 0 && ray.from.is_none() { jitter() } else { DVec3::ZERO };
            Ray { origin: ray.origin + moved, direction, ..*ray }
        })
        .collect()
}

fn bits(crossing: &Option<Crossing>) -> Option<[u64; 4]> {
    let c = crossing.as_ref()?;
    Some([
        c.t.to_bits(),
        c.lattice[0].to_bits(),
        c.lattice[1].to_bits(),
        c.raw.to_bits() ^ u64::from(c.front),
    ])
}

/// Number of rays that hit, after comparing rays together with single rays.
fn compare(face: &ReliefFace, rays: &[Ray], what: &str) -> usize {
    let alone: Vec<_> = rays.iter().map(|ray| face.first_crossing(ray, &mut ())).collect();
    for coherence in [Coherence::Coherent, Coherence::Incoherent] {
        // What stands there before is to be overwritten.
        let mut together = vec![alone.iter().flatten().next().copied(); rays.len()];
        face.first_crossings((rays, coherence), &mut together, &mut ());
        for ((ray, alone), together) in rays.iter().zip(&alone).zip(&together) {
            assert_eq!(bits(alone), bits(together), "{what}, {coherence:?}: {ray:?}");
        }
    }
    let mut occluded = vec![false; rays.len()];
    face.occludes_each(rays, &mut occluded, &mut ());
    for ((ray, alone), occluded) in rays.iter().zip(&alone).zip(occluded) {
        assert_eq!(alone.is_some(), occluded, "{what}: {ray:?}");
    }
    alone.iter().flatten().count()
}

#[test]
fn packets_give_the_bits_of_single_rays() {
    let (mut hits, mut rays) = (0, 0);
    for (index, scene) in scenes::all().iter().enumerate() {
        let oracle = scene.oracle();
        for layout in Layout::ALL {
            for &level in SimdLevel::available() {
                let face = kernel::face_as(scene, Method::Pyramid, layout, level);
                for k in 0..60 {
                    let mut random = Random::new(&[17, index as u64, k]);
                    let family = Family::ALL[k as usize % Family::ALL.len()];
                    let ray = family.ray(&oracle, &mut random);
                    let spread = [1e-5, 1e-3, 0.03, 0.7][k as usize % 4];
                    let packet = neighbours(&ray, spread, &mut random);
                    let what = format!("{}, {layout}, {level}", scene.name);
                    hits += compare(&face, &packet, &what);
                    rays += packet.len();
                }
            }
        }
    }
    assert!(hits * 5 > rays, "too few hits to mean anything: {hits} of {rays}");
}

#[test]
fn a_packet_may_be_any_rays_at_all() {
    let scene = scenes::named("studs 64");
    let oracle = scene.oracle();
    let face = kernel::face(&scene, Method::Pyramid);
    for k in 0..500 {
        let mut random = Random::new(&[29, k]);
        let family = |n: u64| Family::ALL[(n % Family::ALL.len() as u64) as usize];
        let rays: Vec<Ray> = (0..k % 40).map(|n| family(n).ray(&oracle, &mut random)).collect();
        compare(&face, &rays, "mixed");
    }
}
