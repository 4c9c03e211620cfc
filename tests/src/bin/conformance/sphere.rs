//! Displaced spheres: every method against the walk over every cell, and against the judge.

use rilievo_tests::conformance::same_bits;
use rilievo_tests::random::Random;
use rilievo_tests::sphere::oracle::SphereOracle;
use rilievo_tests::sphere::{Contender, Family, SphereScene, scenes};

use super::Job;
use super::record::Record;
use super::tally::Tally;

/// One job a map; its rays go by turns to all spheres under it.
pub fn jobs() -> Vec<Job> {
    let all = scenes();
    let map = |scene: &SphereScene| scene.name.split(',').next().unwrap_or(&scene.name).to_owned();
    let jobs = all.chunk_by(|a, b| map(a) == map(b)).enumerate();
    let job = |(number, scenes): (usize, &[SphereScene])| {
        let (name, scenes) = (format!("sphere {}", map(&scenes[0])), scenes.to_vec());
        Job { name, run: Box::new(move |record| run(number as u64, &scenes, record)) }
    };
    jobs.map(job).collect()
}

fn run(number: u64, scenes: &[SphereScene], record: &mut Record) -> std::io::Result<()> {
    let spheres: Vec<(&SphereScene, Vec<Contender>, SphereOracle)> =
        scenes.iter().map(|scene| (scene, scene.contenders(), scene.oracle())).collect();
    record.judge(|k| {
        let (scene, contenders, oracle) = &spheres[k as usize % spheres.len()];
        let mut random = Random::new(&[65, number, k]);
        let family = Family::ALL[random.integer(0, Family::ALL.len() as i32 - 1) as usize];
        let ray = scene.ray(family, &mut random);
        let hit = contenders[0].1.closest(&ray, &mut ());
        let mut tally =
            Tally { rays: 1, judged: 1, hits: u64::from(hit.is_some()), ..Tally::default() };
        let mut fault = None;
        let unlike = contenders[1..].iter().find(|(_, sphere)| {
            !same_bits(&hit, &sphere.closest(&ray, &mut ()))
                || sphere.occludes(&ray, &mut ()) != hit.is_some()
        });
        if let Some((name, _)) = unlike {
            tally.bits = 1;
            fault = Some(format!("{}, {name} does not say {hit:?}: {ray:?}", scene.name));
        }
        if !oracle.agrees(&hit, &ray) {
            let excused = oracle.excuses(&hit, &ray);
            (tally.excused, tally.wrong) = (u64::from(excused), u64::from(!excused));
            if !excused {
                let judge = oracle.closest(&ray, -1e-300);
                fault =
                    Some(format!("{}, the judge says {judge:?}, not {hit:?}: {ray:?}", scene.name));
            }
        }
        (tally, fault)
    })
}
