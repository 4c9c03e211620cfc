//! Rays from inside of closed displaced meshes and of displaced spheres: none escapes.

use glam::DVec3;
use rilievo::map::Layout;
use rilievo::relief::{Method, ReliefMesh};
use rilievo::{Ray, SimdLevel};
use rilievo_tests::mesh_cases::{Case, all_cases, places, point_near, reach, target};
use rilievo_tests::mesh_oracle::MeshOracle;
use rilievo_tests::random::Random;
use rilievo_tests::sphere::{Family, SphereScene, scenes};

use super::Job;
use super::record::Record;
use super::tally::Tally;

/// One line in so many is followed to its end.
const FOLLOWED: u64 = 8;

/// Points inside of each mesh that rays start at.
const ORIGINS: usize = 40;

/// One job a closed mesh, and one for all spheres.
pub fn jobs() -> Vec<Job> {
    let job = |(number, case): (usize, Case)| Job {
        name: format!("inside {}", case.name),
        run: Box::new(move |record| run(number as u64, &case, record)),
    };
    let closed = all_cases().into_iter().enumerate().filter(|(_, case)| case.is_closed());
    let mut jobs: Vec<Job> = closed.map(job).collect();
    jobs.push(Job { name: "inside spheres".to_owned(), run: Box::new(run_spheres) });
    jobs
}

fn run(number: u64, case: &Case, record: &mut Record) -> std::io::Result<()> {
    let placed = places().map(|place| {
        let mesh = case.mesh(Method::Pyramid, place);
        let origins = origins(&mesh, &case.oracle(place));
        (mesh, origins)
    });
    record.judge(|k| {
        let at = k as usize % placed.len();
        let (mesh, origins) = &placed[at];
        let mut random = Random::new(&[62, number, k]);
        let origin = origins[random.integer(0, origins.len() as i32 - 1) as usize];
        let direction = match random.integer(0, 2) {
            0 => reach(mesh) * random.direction(),
            // At a vertex or a point of an edge, displaced somewhere.
            _ => target(mesh, &mut random) - origin,
        };
        let ray = Ray::new(origin, direction);
        let hit = mesh.closest(&ray, &mut ());
        let mut tally = Tally { rays: 1, hits: u64::from(hit.is_some()), ..Tally::default() };
        let Some(hit) = hit else {
            tally.escaped = 1;
            return (tally, Some(format!("place {at}, escapes: {ray:?}")));
        };
        let mut fault = None;
        if (k / placed.len() as u64).is_multiple_of(FOLLOWED) {
            tally.lines = 1;
            let mut crossed = vec![hit.front];
            let mut next = mesh.closest(&hit.spawn(direction), &mut ());
            while let Some(hit) = next
                && crossed.len() < 1000
            {
                crossed.push(hit.front);
                next = mesh.closest(&hit.spawn(direction), &mut ());
            }
            if crossed.len() % 2 == 0 {
                tally.odd = 1;
                fault = Some(format!("place {at}, not by turns, {crossed:?}: {ray:?}"));
            }
        }
        (tally, fault)
    })
}

/// Points inside, if lines in three directions cross the surface an odd number of times.
fn origins(mesh: &ReliefMesh, oracle: &MeshOracle<'_>) -> Vec<DVec3> {
    let mut random = Random::new(&[63]);
    let mut origins = Vec::new();
    for _ in 0..100 * ORIGINS {
        let point = point_near(mesh, &mut random);
        let inside = (0..3).all(|_| {
            let crossings = oracle.crossings(&Ray::new(point, reach(mesh) * random.direction()));
            crossings.iter().filter(|&&t| t >= 0.0).count() % 2 == 1
        });
        if inside && origins.len() < ORIGINS {
            origins.push(point);
        }
    }
    origins
}

fn run_spheres(record: &mut Record) -> std::io::Result<()> {
    let sphere = |scene: SphereScene| {
        let sphere = scene.sphere(Method::Pyramid, Layout::Default, SimdLevel::detect());
        (scene, sphere)
    };
    let spheres: Vec<_> = scenes().into_iter().map(sphere).collect();
    record.judge(|k| {
        let (scene, sphere) = &spheres[k as usize % spheres.len()];
        let mut random = Random::new(&[64, k]);
        let family = if random.one_in(2) { Family::Inside } else { Family::AimedInside };
        let ray = scene.ray(family, &mut random);
        let left = sphere.closest(&ray, &mut ()).is_some_and(|hit| !hit.front);
        let (hits, escaped) = (u64::from(left), u64::from(!left));
        let fault = (!left).then(|| format!("{}, escapes: {ray:?}", scene.name));
        (Tally { rays: 1, hits, escaped, ..Tally::default() }, fault)
    })
}
