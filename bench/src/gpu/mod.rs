//! `gpu`: rays a second, builds and edits on any adapter, beside triangles under a tree in a compute shader.
//!
//! Rays are made once, on the CPU, and stay on the device; what is timed is the passes alone, contenders in turn.

mod peer;
mod record;
mod scene;

use rilievo::Ray;
use rilievo::map::DistanceKind;
use rilievo::relief::Method;
use rilievo::surface::World;
use rilievo_gpu::{Gpu, GpuMaps, GpuRays, GpuWorld, MapEdit};

use crate::args::GpuArgs;
use crate::clock::Watch;
use crate::measure::Passes;
use crate::random::unit;
use crate::rays::{Ray32, widened};
use crate::report::{object, print, say};
use peer::{Peer, PeerRays};
use record::{Answers, Record};
use scene::{Family, Scene};

/// Samples a side of an edit.
const EDITED: u32 = 64;

/// Measures everything.
///
/// # Errors
/// No adapter, a map that cannot be read, a device that fails, or an output that cannot be written.
pub fn run(args: &GpuArgs) -> Result<(), String> {
    let gpu = Gpu::open().map_err(|e| e.to_string())?;
    let sizes = Sizes::new(args, gpu.is_software());
    let timed = if gpu.has_timestamps() { "its own clock" } else { "the clock on the wall" };
    let software = if gpu.is_software() {
        ", a program on the CPU: no figure says anything of a GPU"
    } else {
        ""
    };
    say(format_args!("{} by {timed}{software}", gpu.name()));
    let bench = Bench { gpu: &gpu, args, sizes };
    bench.rays()?;
    bench.edit()
}

/// How large everything is: as asked for, or by the kind of adapter.
#[derive(Clone, Copy, Debug)]
struct Sizes {
    map: u32,
    edited_map: u32,
    image: [u32; 2],
    peer: u32,
}

impl Sizes {
    fn new(args: &GpuArgs, software: bool) -> Self {
        let by_default = |given: Option<u32>, fast: u32, slow: u32| {
            given.unwrap_or(if software { slow } else { fast })
        };
        let map = by_default(args.size, 4096, 256);
        Self {
            map,
            edited_map: by_default(args.edit_size, 8192, 512),
            image: [by_default(args.width, 1920, 240), by_default(args.height, 1080, 135)],
            peer: by_default(args.peer_size, map, map),
        }
    }
}

struct Bench<'a> {
    gpu: &'a Gpu,
    args: &'a GpuArgs,
    sizes: Sizes,
}

/// Who traces.
enum Contender<'a> {
    Relief { method: Method, slices: u32, world: Box<GpuWorld<'a>>, bytes: u64 },
    Triangles(Peer),
}

impl Bench<'_> {
    /// Rays of both families by all contenders.
    fn rays(&self) -> Result<(), String> {
        let Sizes { map: size, image, .. } = self.sizes;
        let map = self.args.map;
        say(format_args!("{} {size}, rays of {} x {}", map.name(), image[0], image[1]));
        let depth = map.depth(size, self.args.depth);
        let scene = Scene::new(map.load(size)?, depth, image)?;
        let worlds = self.worlds(&scene)?;
        let mut contenders = Vec::new();
        for (method, slices, world, bytes) in &worlds {
            let world = Box::new(GpuWorld::new(self.gpu, world).map_err(|e| e.to_string())?);
            contenders.push(Contender::Relief {
                method: *method,
                slices: *slices,
                world,
                bytes: *bytes,
            });
        }
        if self.sizes.peer > 0 {
            let watch = Watch::start();
            let peer = Peer::new(self.gpu, scene.heights(), depth, self.sizes.peer);
            let peer = peer.map_err(|e| e.to_string())?;
            say(format_args!(
                "tree over {0} x {0} samples: {1:.1} s",
                peer.side,
                watch.took().wall
            ));
            contenders.push(Contender::Triangles(peer));
        }
        for family in Family::ALL {
            self.family(&scene, family, &contenders)?;
        }
        if let Some(Contender::Relief { world, .. }) = contenders.first() {
            self.build(world)?;
        }
        Ok(())
    }

    /// A world for each method that is measured, with the slices of its distance map and the bytes that it holds
    /// beside the heights.
    fn worlds(&self, scene: &Scene) -> Result<Vec<(Method, u32, World, u64)>, String> {
        let (pyramid, bytes) = scene.world(Method::Pyramid, None)?;
        let mut worlds = vec![(Method::Pyramid, 0, pyramid, bytes)];
        for &slices in &self.args.slices {
            for kind in [DistanceKind::Boxes, DistanceKind::Published] {
                let method = if kind == DistanceKind::Boxes {
                    Method::Distance
                } else {
                    Method::DistancePublished
                };
                let (world, bytes) = scene.world(method, Some((kind, self.args.grid, slices)))?;
                worlds.push((method, slices, world, bytes));
            }
        }
        Ok(worlds)
    }

    fn family(
        &self,
        scene: &Scene,
        family: Family,
        contenders: &[Contender<'_>],
    ) -> Result<(), String> {
        let rays = scene.rays(family);
        let wide: Vec<Ray> = rays.iter().map(widened).collect();
        let held: Vec<HeldRays> = contenders
            .iter()
            .map(|contender| self.hold(contender, (&rays, &wide)))
            .collect::<Result<_, _>>()?;
        let mut seconds = vec![Vec::new(); contenders.len()];
        // The first pass warms up.
        for pass in 0..=self.args.passes {
            for ((contender, rays), seconds) in contenders.iter().zip(&held).zip(&mut seconds) {
                let taken = self.pass(contender, rays)?;
                if pass > 0 {
                    seconds.push(taken);
                }
            }
        }
        let mut reference = None;
        for ((contender, held), seconds) in contenders.iter().zip(&held).zip(seconds) {
            let (found, steps) = self.answers(contender, held, &wide)?;
            let reference = reference.get_or_insert_with(|| found.clone());
            let answers = Answers::new(reference, &found);
            let mut record = self.record(family.name(), &Passes::of(seconds));
            match contender {
                Contender::Relief { method, slices, bytes, .. } => {
                    let kind = method.distance_kind();
                    record.grid = kind.map_or(0, |kind| scene.side(kind, self.args.grid));
                    record.contender = method.name().to_owned();
                    record.slices = *slices;
                    record.bytes = *bytes;
                }
                Contender::Triangles(peer) => {
                    record.contender = "triangles".to_owned();
                    record.bytes = peer.bytes();
                    record.peer_size = peer.side;
                }
            }
            record.rays = wide.len() as u64;
            record.mrays_per_s = wide.len() as f64 * 1e-6 / record.seconds;
            record.answers = Some(answers);
            record.steps_a_ray = steps.map(|steps| steps as f64 / wide.len() as f64);
            self.report(&record)?;
        }
        Ok(())
    }

    fn hold(
        &self,
        contender: &Contender<'_>,
        (rays, wide): (&[Ray32], &[Ray]),
    ) -> Result<HeldRays, String> {
        match contender {
            Contender::Relief { world, .. } => {
                world.hold(wide).map(HeldRays::Relief).map_err(|e| e.to_string())
            }
            Contender::Triangles(peer) => Ok(HeldRays::Triangles(peer.hold(self.gpu, rays))),
        }
    }

    fn pass(&self, contender: &Contender<'_>, rays: &HeldRays) -> Result<f64, String> {
        let seconds = match (contender, rays) {
            (Contender::Relief { world, .. }, HeldRays::Relief(rays)) => world.time_closest(rays),
            (Contender::Triangles(peer), HeldRays::Triangles(rays)) => peer.time(self.gpu, rays),
            _ => return Err("rays of another contender".to_owned()),
        };
        seconds.map_err(|e| e.to_string())
    }

    /// Parameters of the hits, and all steps where they are counted.
    fn answers(
        &self,
        contender: &Contender<'_>,
        held: &HeldRays,
        wide: &[Ray],
    ) -> Result<(Vec<Option<f64>>, Option<u64>), String> {
        match (contender, held) {
            (Contender::Triangles(peer), HeldRays::Triangles(rays)) => {
                peer.hits(self.gpu, rays).map(|found| (found, None)).map_err(|e| e.to_string())
            }
            (Contender::Relief { world, .. }, _) => {
                let found = world.closest(wide).map_err(|e| e.to_string())?;
                let steps = found.iter().map(|traced| traced.work).sum();
                Ok((found.iter().map(|traced| traced.hit.map(|hit| hit.t)).collect(), Some(steps)))
            }
            _ => Err("rays of another contender".to_owned()),
        }
    }

    /// Pyramids made from heights on the device.
    fn build(&self, world: &GpuWorld<'_>) -> Result<(), String> {
        let mut seconds = Vec::new();
        for pass in 0..=self.args.passes {
            let taken = world.time_build().map_err(|e| e.to_string())?;
            if pass > 0 {
                seconds.push(taken);
            }
        }
        let mut record = self.record("build", &Passes::of(seconds));
        record.contender = Method::Pyramid.name().to_owned();
        self.report(&record)
    }

    /// Edits of a large map, each followed by a frame: everything from the first changed sample to the last hit on
    /// the device, by the clock on the wall.
    fn edit(&self) -> Result<(), String> {
        let Sizes { edited_map: size, image, .. } = self.sizes;
        say(format_args!("edits of {size}, frames of {} x {}", image[0], image[1]));
        let map = self.args.map;
        let mut scene = Scene::new(map.load(size)?, map.depth(size, self.args.depth), image)?;
        let rays: Vec<Ray> = scene.rays(Family::Primary).iter().map(widened).collect();
        let (world, _) = scene.world(Method::Pyramid, None)?;
        let on_gpu = GpuWorld::new(self.gpu, &world).map_err(|e| e.to_string())?;
        let held = on_gpu.hold(&rays).map_err(|e| e.to_string())?;
        let mut maps = on_gpu.into_maps();
        drop(world);
        let mut seconds = [Vec::new(), Vec::new()];
        for pass in 0..=u64::from(self.args.passes) {
            let side = EDITED.min(size);
            let most = f64::from(size - side + 1);
            let [x, y] = [0, 1].map(|draw| (unit(pass, draw) * most) as u32);
            let rect = [x..x + side, y..y + side];
            let watch = Watch::start();
            scene.edit(rect.clone())?;
            let (world, _) = scene.world(Method::Pyramid, None)?;
            let edit = MapEdit { relief: scene.relief(), samples: rect };
            let (after, edited) = self.edited(&world, (maps, &held), &edit, &watch)?;
            let whole = watch.took().wall;
            maps = after;
            if pass > 0 {
                seconds[0].push(edited);
                seconds[1].push(whole);
            }
        }
        for (what, seconds) in ["edit", "edit and frame"].into_iter().zip(seconds) {
            let mut record = self.record(what, &Passes::of(seconds));
            record.contender = Method::Pyramid.name().to_owned();
            record.size = size;
            record.rays = if what == "edit" { 0 } else { rays.len() as u64 };
            record.clock = "wall".to_owned();
            self.report(&record)?;
        }
        Ok(())
    }

    /// Follows an edit on the device and traces a frame; the maps again, and when the edit was submitted.
    fn edited(
        &self,
        world: &World,
        (maps, rays): (GpuMaps, &GpuRays),
        edit: &MapEdit<'_>,
        watch: &Watch,
    ) -> Result<(GpuMaps, f64), String> {
        let on_gpu = GpuWorld::edited(self.gpu, world, maps, std::slice::from_ref(edit));
        let on_gpu = on_gpu.map_err(|e| e.to_string())?;
        let edited = watch.took().wall;
        on_gpu.time_closest(rays).map_err(|e| e.to_string())?;
        Ok((on_gpu.into_maps(), edited))
    }

    fn record(&self, what: &str, passes: &Passes) -> Record {
        Record {
            bench: "gpu".to_owned(),
            adapter: self.gpu.name().to_owned(),
            software: self.gpu.is_software(),
            clock: if self.gpu.has_timestamps() { "device" } else { "wall" }.to_owned(),
            what: what.to_owned(),
            map: self.args.map.name().to_owned(),
            size: self.sizes.map,
            depth: self.args.depth,
            image: self.sizes.image,
            seconds: passes.median,
            spread: passes.spread(),
            passes: self.args.passes.into(),
            ..Record::default()
        }
    }

    fn report(&self, record: &Record) -> Result<(), String> {
        if self.args.output.json { object(record) } else { print(&record.line()) }
    }
}

/// Rays on the device in a contender's own format.
enum HeldRays {
    Relief(GpuRays),
    Triangles(PeerRays),
}
