//! Displaced meshes whose parts show maps of their own, or none: walls go down to the neighbour's map.

use std::sync::Arc;

use rilievo::glam::{DAffine3, DVec3};
use rilievo::surface::{Instance, Surface, World};
use rilievo_gpu::GpuWorld;
use rilievo_tests::joined::{self, Joined};
use rilievo_tests::mesh_cases::ray_towards;
use rilievo_tests::random::Random;

use crate::pair::{Pair, Tally, asked, gpu};

/// The same parts, each in a place that is the same for all.
fn placed(world: &World, place: DAffine3) -> World {
    let shown = |surface: &Surface| {
        Instance::new(Arc::new(surface.clone()), place).expect("it can be undone").into()
    };
    World::new(world.surfaces().iter().map(shown).collect())
}

#[test]
fn hits_on_joined_meshes_are_those_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let mut tally = Tally::default();
    let count = asked("RILIEVO_RAYS", 150);
    for (index, Joined { base, world }) in (0..).zip(joined::all()) {
        let bounds = world.bounds();
        let (centre, half) = (bounds.centre(), 0.5 * (bounds.max - bounds.min));
        let place = DAffine3::from_scale(DVec3::new(-1.0, 1.5, 1.2));
        let placed = placed(&world, place);
        for (world, place) in [(&world, DAffine3::IDENTITY), (&placed, place)] {
            let on_gpu = GpuWorld::new(&gpu, world).expect("joined meshes can be traced");
            let size = 2.0 * half.length();
            let pair = Pair { name: format!("joined {index}"), world, on_gpu, centre, size };
            let mut rays: Vec<_> =
                (0..count).map(|k| ray_towards(bounds, &mut Random::new(&[8, index, k]))).collect();
            pair.judge(&rays, &mut Random::new(&[9, index]), &mut tally);
            // From the middle nothing escapes between the parts, as corners and edges would let it.
            let middle = DVec3::new(0.01, -0.02, 0.03);
            rays.clear();
            rays.extend((0..4 * count).map(|k| joined::ray(&base, middle, k)));
            for ray in &mut rays {
                ray.origin = place.transform_point3(ray.origin);
                ray.direction = place.transform_vector3(ray.direction);
            }
            let found = pair.on_gpu.closest(&rays).expect("traced");
            let escaped = found.iter().filter(|traced| traced.hit.is_none()).count();
            assert_eq!(escaped, 0, "{} of {}", pair.name, rays.len());
        }
    }
    tally.report("joined meshes");
}
