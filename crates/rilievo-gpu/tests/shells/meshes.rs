//! Displaced meshes.

use std::sync::Arc;

use rilievo::Ray;
use rilievo::glam::{DAffine3, DVec3};
use rilievo::map::{Lattice, Layout, Wrap};
use rilievo::relief::{MeshOptions, Method, Relief, ReliefMesh};
use rilievo::surface::{Instance, Surface, World};
use rilievo_gpu::GpuWorld;
use rilievo_tests::maps::Shape;
use rilievo_tests::mesh_cases::{Case, case, cases, places, ray_towards};
use rilievo_tests::random::Random;

use crate::pair::{Pair, Tally, asked, gpu};

/// The cases of the CPU's suite, and one whose pyramid has more levels.
fn all_cases() -> Vec<Case> {
    let map = Shape::Fbm(18).codes([512, 512], Lattice::Texel, Wrap::Repeat);
    let quad = case("quad");
    let large = Case { name: "large", map, tile: [1.0; 2], ..quad };
    cases().into_iter().chain([large]).collect()
}

/// Its mesh over a pyramid of a layout; one case is one-sided.
fn mesh(case: &Case, place: DAffine3, layout: Layout) -> ReliefMesh {
    let mesh = case.mesh(Method::Pyramid, place);
    let relief = Relief::with_layout(case.map.clone(), layout);
    let options = MeshOptions { one_sided: case.name == "inward", ..mesh.options().clone() };
    mesh.with_relief(Arc::new(relief), options).expect(case.name)
}

#[test]
fn hits_on_displaced_meshes_are_those_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let mut tally = Tally::default();
    let count = asked("RILIEVO_RAYS", 120);
    let chosen = std::env::var("RILIEVO_CASE").ok();
    for (index, case) in (0..).zip(all_cases()).step_by(asked("RILIEVO_STEP", 1) as usize) {
        if chosen.as_ref().is_some_and(|name| name != case.name) {
            continue;
        }
        let place = places()[index as usize % 4];
        let layout = if index % 2 == 0 { Layout::Default } else { Layout::Tiny };
        let mesh = Surface::from(mesh(&case, place, layout));
        // Every third in a place of its own, mirrored and stretched.
        let surface = if index % 3 == 2 {
            let place = DAffine3::from_scale(DVec3::new(-1.0, 1.5, 1.2))
                * DAffine3::from_translation(0.3 * (mesh.bounds().max - mesh.bounds().min));
            Surface::from(Instance::new(Arc::new(mesh), place).expect("it can be undone"))
        } else {
            mesh
        };
        let bounds = surface.bounds();
        let (centre, half) = (bounds.centre(), 0.5 * (bounds.max - bounds.min));
        let world = World::new(vec![surface]);
        let on_gpu = GpuWorld::new(&gpu, &world).expect("a displaced mesh can be traced");
        let name = case.name.to_owned();
        let pair = Pair { name, world: &world, on_gpu, centre, size: 2.0 * half.length() };
        let rays: Vec<Ray> =
            (0..count).map(|k| ray_towards(bounds, &mut Random::new(&[5, index, k]))).collect();
        pair.judge(&rays, &mut Random::new(&[6, index]), &mut tally);
    }
    tally.report("displaced meshes");
}
