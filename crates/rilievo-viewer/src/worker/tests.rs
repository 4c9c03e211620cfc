//! The thread, without a window.

use std::path::Path;

use super::*;
use crate::brush::{Dab, Tool};
use crate::passes::Content;
use crate::session::Look;
use crate::studio::Touch;
use rilievo::relief::Method;
use rilievo_gpu::Backend;
use rilievo_io::scene::SceneFile;

const SCENE: &str = "[camera]\nposition = [0.5, -0.7, 0.9]\nlook_at = [0.5, 0.5, 0]\n\
     [render]\nsamples = 2\nambient = [0.2, 0.2, 0.2]\n\
     [maps.m]\nprocedural = \"studded\"\nsize = [64, 64]\nstuds = [3, 3]\n\
     [[lights]]\ntype = \"sun\"\ndirection = [1, 0.5, -0.6]\nirradiance = [3, 3, 3]\n\
     [[shapes]]\ntype = \"quad\"\ncorners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]\n\
     displacement = { map = \"m\", scale = 0.1 }\n";

fn job(serial: u64, text: &str, change: Change) -> Job {
    let file = SceneFile::parse(text, Path::new("scene.toml")).unwrap();
    Job {
        serial,
        sides: [Some(Side { file, method: None, change }), None],
        look: Look::Colour,
        size: [64, 48],
        shape: 0,
        paintings: Vec::new(),
        backend: Backend::Cpu,
    }
}

/// Waits until a job is done; all events until then.
fn wait(worker: &Worker, serial: u64) -> Vec<Event> {
    let mut all = Vec::new();
    for _ in 0..3000 {
        all.extend(worker.poll().1);
        let ends = |e: &Event| match e {
            Event::Done { serial: of, .. } => *of == serial,
            _ => false,
        };
        if all.iter().any(ends) {
            return all;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("not done in 30 s: {all:?}");
}

fn start() -> Worker {
    Worker::start(Studio::default(), 1, || {})
}

#[test]
fn the_last_picture_is_that_of_a_render() {
    let worker = start();
    worker.post(job(1, SCENE, Change::Scene));
    let events = wait(&worker, 1);
    let factors: Vec<_> = events
        .iter()
        .filter_map(|e| match e {
            Event::Pass { factor, .. } => Some(*factor),
            _ => None,
        })
        .collect();
    assert_eq!(factors, [2, 1, 1]);
    let ([Some(frame), None], _) = worker.poll() else { panic!("one side") };
    assert!(frame.complete);
    let shown = Studio::default()
        .load(&SceneFile::parse(SCENE, Path::new("scene.toml")).unwrap(), None)
        .unwrap();
    let camera = shown.scene.camera().with_resolution([64, 48]).unwrap();
    let scene = shown.scene.with_camera(camera);
    let (film, _) = rilievo_render::render(&scene, &Default::default()).unwrap();
    assert!(frame.content == Content::Radiance(film.radiance().to_vec()));
}

#[test]
fn a_new_job_goes_before_an_endless_one() {
    let worker = start();
    let endless = SCENE.replace("samples = 2", "samples = 1000000");
    worker.post(job(1, &endless, Change::Scene));
    while worker.poll().0[0].is_none() {
        std::thread::sleep(Duration::from_millis(5));
    }
    worker.post(job(2, SCENE, Change::Scene));
    wait(&worker, 2);
    assert!(worker.poll().0[0].as_ref().is_some_and(|frame| frame.complete));
    // One that is going on does not keep the thread from ending.
    worker.post(job(3, &endless, Change::Scene));
}

#[test]
fn two_sides_differ_where_a_method_misses() {
    let worker = start();
    let mut both = job(1, SCENE, Change::Scene);
    let mut other = both.sides[0].clone().unwrap();
    other.method = Some(Method::Dda);
    both.sides[1] = Some(other.clone());
    worker.post(both.clone());
    wait(&worker, 1);
    let ([Some(a), Some(b)], _) = worker.poll() else { panic!("two sides") };
    assert!(a == b);
    other.method = Some(Method::March);
    both.serial = 2;
    both.sides[1] = Some(other);
    worker.post(both);
    wait(&worker, 2);
    let ([Some(a), Some(b)], _) = worker.poll() else { panic!("two sides") };
    assert!(a != b);
}

#[test]
fn strokes_are_painted_before_the_picture_and_none_is_lost() {
    let worker = start();
    worker.post(job(1, SCENE, Change::Scene));
    wait(&worker, 1);
    let before = worker.poll().0[0].clone().unwrap();
    let at = DVec2::splat(0.5);
    let picked = worker.pick(at).expect("the ground");
    let (map, _) = picked.map.unwrap();
    let dab = Dab { tool: Tool::Raise, at: map, radius: 9.0, strength: 0.3 };
    let touch = Painting::Touch(Touch { stroke: 1, surface: 0, dab });
    // Posted faster than they are done.
    for serial in 2..8 {
        let paintings = vec![touch];
        worker.post(Job { paintings, ..job(serial, SCENE, Change::Rendered) });
    }
    let events = wait(&worker, 7);
    assert!(!events.iter().any(|e| matches!(e, Event::Failed(_))), "{events:?}");
    assert!(worker.poll().0[0].clone().unwrap() != before);
    let now = worker.with_shown(|shown| shown.relief(0).unwrap().heights().raw_range());
    let mut studio = Studio::default();
    let file = SceneFile::parse(SCENE, Path::new("scene.toml")).unwrap();
    let shown = studio.load(&file, None).unwrap();
    studio.paint(Some(shown), &[touch; 6], &mut Vec::new()).unwrap();
    let expected = studio.load(&file, None).unwrap().relief(0).unwrap().heights().raw_range();
    assert_eq!(now, Some(expected));
    worker.post(Job { paintings: vec![Painting::Swap(1)], ..job(8, SCENE, Change::Rendered) });
    wait(&worker, 8);
    assert!(worker.poll().0[0].clone().unwrap() == before);
}

#[test]
fn what_cannot_be_loaded_is_told_and_what_was_there_stays() {
    let worker = start();
    worker.post(job(1, SCENE, Change::Scene));
    wait(&worker, 1);
    worker.post(job(2, &SCENE.replace("map = \"m\"", "map = \"n\""), Change::Scene));
    let events = wait(&worker, 2);
    let told = events.iter().find_map(|e| match e {
        Event::Failed(why) => Some(why.clone()),
        _ => None,
    });
    assert!(told.is_some_and(|why| why.contains("scene.toml:")));
    assert!(worker.pick(DVec2::splat(0.5)).is_some());
}
