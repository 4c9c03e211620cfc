//! Displaced spheres.

use rilievo::map::Layout;
use rilievo::relief::Method;
use rilievo::surface::{Surface, World};
use rilievo::{Ray, SimdLevel};
use rilievo_gpu::GpuWorld;
use rilievo_tests::random::Random;
use rilievo_tests::sphere::{self, Family};

use crate::pair::{Pair, Tally, asked, gpu};

#[test]
fn hits_on_displaced_spheres_are_those_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let mut tally = Tally::default();
    let count = asked("RILIEVO_RAYS", 180);
    let scenes = sphere::scenes();
    for (index, scene) in (0..).zip(&scenes).step_by(asked("RILIEVO_STEP", 1) as usize) {
        let layout = if index % 2 == 0 { Layout::Default } else { Layout::Tiny };
        let sphere = scene.sphere(Method::Pyramid, layout, SimdLevel::detect());
        let world = World::new(vec![Surface::from(sphere)]);
        let on_gpu = GpuWorld::new(&gpu, &world).expect("a displaced sphere can be traced");
        let name = scene.name.clone();
        let [_, size] = scene.radii();
        let pair = Pair { name, world: &world, on_gpu, centre: scene.center, size };
        let family = |k: u64| Family::ALL[(k % Family::ALL.len() as u64) as usize];
        let ray = |k: u64| scene.ray(family(k), &mut Random::new(&[3, index, k]));
        let rays: Vec<Ray> = (0..count).map(ray).collect();
        pair.judge(&rays, &mut Random::new(&[4, index]), &mut tally);
    }
    tally.report("displaced spheres");
}
