//! Pyramids made on a device beside those of the CPU, word for word. Without an adapter nothing is tried; the suites
//! in `tests` say so.

use rilievo::map::{Lattice, RowMut, Wrap};
use rilievo::relief::{Method, Relief};
use rilievo::surface::World;
use rilievo_tests::random::Random;
use rilievo_tests::rays::Family;
use rilievo_tests::{kernel, scenes};

use super::*;
use crate::GpuWorld;
use crate::device::OTHER_BUFFERS;

fn gpu() -> Option<Gpu> {
    Gpu::open().ok()
}

/// All words that lie on a device.
fn read(gpu: &Gpu, paged: &Paged, words: u64) -> Vec<u32> {
    let mut all = Vec::new();
    for buffer in paged.buffers() {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let read = gpu.allocate("words", buffer.size(), usage).unwrap();
        let mut commands = gpu.device.create_command_encoder(&Default::default());
        commands.copy_buffer_to_buffer(buffer, 0, &read, 0, buffer.size());
        gpu.queue.submit([commands.finish()]);
        let bytes = gpu.read(&read, buffer.size()).unwrap();
        all.extend(bytemuck::pod_collect_to_vec::<u8, u32>(&bytes));
    }
    all.truncate(words as usize);
    all
}

/// What the CPU makes of a plan: words of heights and of bounds.
fn expected(plan: &MapPlan<'_>) -> [Vec<u32>; 2] {
    let (mut heights, mut bounds) = (Vec::new(), Vec::new());
    for PlannedMap { relief, shape } in &plan.maps {
        let mut bytes: Vec<u8> = match relief.heights().samples() {
            Samples::U16(codes) => bytemuck::cast_slice(codes).to_vec(),
            Samples::F32(all) => bytemuck::cast_slice(all).to_vec(),
        };
        bytes.resize(bytes.len().div_ceil(4) * 4, 0);
        heights.extend(bytemuck::pod_collect_to_vec::<u8, u32>(&bytes));
        let pyramid = Pyramid::build_as(relief.heights(), Layout::Default);
        assert!(bounds::write_bounds(&mut bounds, shape.place.bounds, &pyramid));
    }
    [heights, bounds]
}

fn assert_same(gpu: &Gpu, maps: &Maps, plan: &MapPlan<'_>, what: &str) {
    let [heights, bounds] = expected(plan);
    assert!(read(gpu, &maps.heights, plan.heights) == heights, "heights of {what}");
    let found = read(gpu, &maps.bounds, plan.bounds);
    assert_eq!(found.len(), bounds.len(), "{what}");
    let wrong = found.iter().zip(&bounds).position(|(a, b)| a != b);
    let told = wrong.map(|at| format!("word {at}: {:#x} for {:#x}", found[at], bounds[at]));
    assert_eq!(told, None, "{what}");
}

fn samples(random: &mut Random, count: u32, kind: u32) -> Samples {
    let mut unit = || random.range(0.0, 1.0);
    let floats = |mut h: Box<dyn FnMut() -> f64 + '_>| {
        Samples::F32((0..count).map(|_| h() as f32).collect())
    };
    match kind {
        0 => Samples::U16((0..count).map(|_| (unit() * 65535.0) as u16).collect()),
        1 => floats(Box::new(|| unit() * 3.0 - 1.0)),
        // So close that codes stand for the same heights.
        2 => floats(Box::new(|| 3e6 + (unit() * 4.0).floor() * 0.25)),
        // On codes exactly, zeros of both signs among them.
        3 => {
            floats(Box::new(|| ((unit() * 5.0).floor() - 2.0) * 0.0 + (unit() * 3.0).floor() - 1.0))
        }
        4 => floats(Box::new(|| -7.25)),
        // What a device may take for zero.
        5 => floats(Box::new(|| unit() * 1e-40)),
        _ => floats(Box::new(|| if unit() < 0.5 { 1e-40 } else { unit() })),
    }
}

const SIZES: [[u32; 2]; 8] =
    [[2, 2], [5, 3], [17, 16], [16, 65], [33, 129], [64, 64], [257, 70], [300, 1030]];

fn unfoldings() -> impl Iterator<Item = (Lattice, Wrap)> {
    let wraps = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror];
    wraps.into_iter().flat_map(|wrap| [Lattice::Vertex, Lattice::Texel].map(|l| (l, wrap)))
}

#[test]
fn pyramids_are_those_of_the_cpu_bit_for_bit() {
    let Some(gpu) = gpu() else { return };
    let mut random = Random::new(&[3]);
    for kind in 0..7 {
        let mut reliefs = Vec::new();
        for [width, height] in SIZES {
            for (lattice, wrap) in unfoldings() {
                let samples = samples(&mut random, width * height, kind);
                let map = HeightMap::new(width, height, samples, lattice, wrap).unwrap();
                let layout = Layout::ALL[reliefs.len() % 2];
                reliefs.push(Relief::with_layout(map, layout));
            }
        }
        let mut plan = MapPlan::default();
        reliefs.iter().chain(&reliefs[..2]).for_each(|relief| {
            plan.place(relief);
        });
        assert_eq!(plan.maps.len(), reliefs.len());
        let maps = Maps::new(&gpu, &plan).unwrap();
        assert_same(&gpu, &maps, &plan, &format!("heights of kind {kind}"));
    }
}

#[test]
fn after_any_edit_all_words_are_those_of_a_full_build() {
    let Some(gpu) = gpu() else { return };
    let mut random = Random::new(&[4]);
    let whole = |random: &mut Random, end: u32| (random.range(0.0, f64::from(end))) as u32;
    for kind in [0, 0, 1, 3, 5, 6] {
        for (lattice, wrap) in unfoldings() {
            let mut reliefs: Vec<Relief> = (0..2)
                .map(|_| {
                    let [width, height] = [2 + whole(&mut random, 300), 2 + whole(&mut random, 90)];
                    let samples = samples(&mut random, width * height, kind);
                    Relief::new(HeightMap::new(width, height, samples, lattice, wrap).unwrap())
                })
                .collect();
            let mut first = MapPlan::default();
            reliefs.iter().for_each(|relief| {
                first.place(relief);
            });
            let mut maps = Maps::new(&gpu, &first).unwrap();
            for edit in 0..6 {
                let number = edit % 2;
                let map = reliefs[number].heights();
                let rect = [map.width(), map.height()].map(|end| {
                    let [a, b] = [0, 1].map(|_| whole(&mut random, end + 1));
                    // Often at a border, where maps wrap.
                    let start = if random.range(0.0, 1.0) < 0.3 { 0 } else { a.min(b) };
                    start..(start + 1 + a.abs_diff(b) / 2).min(end)
                });
                // Every third widens the range, or takes its end away.
                let [low, high] = if edit % 3 == 2 { [0.0, 4.0] } else { [0.3, 0.6] };
                reliefs[number]
                    .edit(rect.clone(), |_, row| match row {
                        RowMut::U16(row) => {
                            row.iter_mut()
                                .for_each(|h| *h = (random.range(low, high) * 16e3) as u16);
                        }
                        RowMut::F32(row) => {
                            row.iter_mut().for_each(|h| *h = random.range(low, high) as f32);
                        }
                    })
                    .unwrap();
                let mut plan = MapPlan::default();
                reliefs.iter().for_each(|relief| {
                    plan.place(relief);
                });
                assert!(maps.fits(&plan));
                maps.edit(&gpu, &plan, &[(number, rect.clone())]).unwrap();
                let what = format!("{lattice:?} {wrap:?}, kind {kind}, edit {edit} of {rect:?}");
                assert_same(&gpu, &maps, &plan, &what);
            }
        }
    }
}

#[test]
fn maps_are_split_across_buffers_and_refused_past_what_a_shader_binds() {
    let Some(gpu) = gpu() else { return };
    let pages = gpu.device.limits().max_storage_buffers_per_shader_stage.min(20) - 6;
    let gpu = gpu.with_largest_binding(4096);
    let mut random = Random::new(&[5]);
    let mut relief = |side: u32, kind| {
        let samples = samples(&mut random, side * side, kind);
        Relief::new(HeightMap::new(side, side, samples, Lattice::Texel, Wrap::Repeat).unwrap())
    };
    if pages >= 4 {
        let mut reliefs = [relief(45, 1), relief(7, 0)];
        let mut plan = MapPlan::default();
        reliefs.iter().for_each(|relief| {
            plan.place(relief);
        });
        let mut maps = Maps::new(&gpu, &plan).unwrap();
        assert_eq!(maps.pages()[0].count, 3);
        assert_same(&gpu, &maps, &plan, "three pages");
        let rect = [3..40, 20..30];
        reliefs[0]
            .edit(rect.clone(), |_, row| {
                if let RowMut::F32(row) = row {
                    row.fill(0.25);
                }
            })
            .unwrap();
        let mut plan = MapPlan::default();
        reliefs.iter().for_each(|relief| {
            plan.place(relief);
        });
        maps.edit(&gpu, &plan, &[(0, rect)]).unwrap();
        assert_same(&gpu, &maps, &plan, "three pages after an edit");
    }
    let huge = relief(2000, 0);
    let mut plan = MapPlan::default();
    plan.place(&huge);
    let error = Maps::new(&gpu, &plan).err().expect("too many pages").to_string();
    assert!(error.contains("height maps need") && error.contains("smaller maps"), "{error}");
}

#[test]
fn rays_through_maps_on_several_pages_hit_what_the_cpu_hits() {
    let Some(gpu) = gpu() else { return };
    if gpu.device.limits().max_storage_buffers_per_shader_stage < OTHER_BUFFERS + 5 {
        return;
    }
    let gpu = gpu.with_largest_binding(40_000);
    let scene = scenes::named("fbm 256");
    let face = kernel::face(&scene, Method::Pyramid);
    let world = World::new(vec![face.clone().into()]);
    let on_gpu = GpuWorld::new(&gpu, &world).unwrap();
    assert_eq!(on_gpu.maps().pages()[0].count, 4);
    let (oracle, mut random) = (scene.oracle(), Random::new(&[6]));
    let rays: Vec<_> = (0..400).map(|_| Family::ALL[0].ray(&oracle, &mut random)).collect();
    let mut hits = 0;
    for (ray, traced) in rays.iter().zip(on_gpu.closest(&rays).unwrap()) {
        let cpu = face.closest(ray, &mut ());
        let apart = cpu.zip(traced.hit).map(|(a, b)| a.position.distance(b.position));
        assert!(apart.unwrap_or(0.0) < 1e-6 && cpu.is_some() == traced.hit.is_some(), "{ray:?}");
        hits += u32::from(cpu.is_some());
    }
    assert!(hits > 100, "{hits}");
}
