//! Displaced meshes: every method against every cell, and against the judge.

use glam::DAffine3;
use rilievo::relief::{Method, ReliefMesh};
use rilievo::{Hit, Ray};
use rilievo_tests::mesh_cases::{Case, all_cases, places, ray, reach};
use rilievo_tests::mesh_oracle::{MeshOracle, Verdict};
use rilievo_tests::random::Random;

use super::Job;
use super::record::Record;
use super::tally::Tally;

/// One job a case; its rays go by turns to all places.
pub fn jobs() -> Vec<Job> {
    let job = |(number, case): (usize, Case)| Job {
        name: format!("mesh {}", case.name),
        run: Box::new(move |record| run(number as u64, &case, record)),
    };
    all_cases().into_iter().enumerate().map(job).collect()
}

/// A case in a place.
struct Placed<'a> {
    reference: ReliefMesh,
    contenders: Vec<(String, ReliefMesh)>,
    oracle: MeshOracle<'a>,
    /// Distances that count as equal.
    near: f64,
}

impl<'a> Placed<'a> {
    fn new(case: &'a Case, place: DAffine3) -> Self {
        let reference = case.mesh(Method::Dda, place);
        let oracle = case.oracle(place);
        let contenders = case.contenders(place);
        let near = 1e-9 * reach(&reference) + 1e-15 * place.translation.length();
        Self { reference, contenders, oracle, near }
    }

    /// Names the methods whose answers are not `expected`.
    fn unlike(&self, ray: &Ray, expected: Option<Hit>) -> Vec<String> {
        let unlike = self.contenders.iter().filter(|(_, mesh)| {
            mesh.closest(ray, &mut ()) != expected
                || mesh.occludes(ray, &mut ()) != expected.is_some()
        });
        unlike.map(|(name, _)| name.clone()).collect()
    }
}

fn run(number: u64, case: &Case, record: &mut Record) -> std::io::Result<()> {
    let placed = places().map(|place| Placed::new(case, place));
    record.judge(|k| {
        let at = k as usize % placed.len();
        let Placed { reference, oracle, near, .. } = &placed[at];
        let mut random = Random::new(&[61, number, k]);
        let first = ray(reference, &mut random);
        let cells = oracle.cells_near(&first);
        let hit = reference.closest_among(&first, |_| cells.clone());
        let verdict = oracle.judge(&first, &cells, hit.as_ref(), *near);
        let mut tally = Tally { judged: 1, ..Tally::default() };
        tally.excused = u64::from(verdict == Verdict::Excused);
        tally.wrong = u64::from(verdict == Verdict::Wrong);
        let mut fault = None;
        if verdict == Verdict::Wrong {
            let judge = oracle.first(&first);
            fault = Some(format!("place {at}, the judge says {judge:?}, not {hit:?}: {first:?}"));
        }
        let spawned = hit.filter(|_| random.one_in(4)).map(|hit| {
            let ray = hit.spawn(random.direction() * reach(reference));
            let hit = reference.closest_among(&ray, |ray| oracle.cells_near(ray));
            (ray, hit)
        });
        for (ray, expected) in std::iter::once((first, hit)).chain(spawned) {
            tally.rays += 1;
            tally.hits += u64::from(expected.is_some());
            let unlike = placed[at].unlike(&ray, expected);
            if !unlike.is_empty() {
                tally.bits += 1;
                let every = reference.closest(&ray, &mut ()) == expected;
                fault = Some(format!(
                    "place {at}, {unlike:?} do not say {expected:?} (every cell: {every}): {ray:?}"
                ));
            }
        }
        (tally, fault)
    })
}
