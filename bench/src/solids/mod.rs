//! `solids`: displaced spheres and meshes beside Embree's triangles at texel density.
//!
//! Both get the same rays, one a call, on one thread. `rilievo` answers with a crossing, as for the faces of
//! `kernels`: parameter, triangle, cell, place in it and side, in `f64`; `rilievo-hit` with a whole hit, position and
//! both normals, smoothed, as well; Embree with parameter, normal and barycentric coordinates. Embree's
//! scene is robust, its build medium: that is the configuration without holes.

mod body;
mod rays;
mod refinement;
mod tessellation;

use std::collections::BTreeMap;

use rilievo::map::HeightMap;
use serde::{Deserialize, Serialize};

use crate::args::SolidArgs;
use crate::clock::Watch;
#[cfg(feature = "embree")]
use crate::embree::{Ray1, Scene};
use crate::measure::interleaved;
use crate::one_thread;
use crate::rays::{Ray32, widened};
use crate::report::{object, print, say};
use crate::tally::Tally;
pub use body::Body;
use body::Displaced;
pub use rays::SolidFamily;
pub use refinement::run as refinement;

/// One contender on one body, map, thickness and family.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SolidRecord {
    /// Always `solids`.
    pub bench: String,
    pub body: String,
    pub map: String,
    /// Samples a side.
    pub size: u32,
    /// Share of the body's size between the lowest and the highest offset.
    pub thickness: f64,
    pub family: SolidFamily,
    pub contender: String,
    /// Million rays a second of one thread's processor time, the median pass.
    pub mrays_per_s: f64,
    /// (slowest - fastest) / median pass.
    pub spread: f64,
    pub rays: u64,
    pub hits: u64,
    pub mean_t: Option<f64>,
    pub build_seconds: f64,
    /// Bytes held beyond the 16-bit heights.
    pub bytes: u64,
    /// Versions and flags.
    pub against: BTreeMap<String, String>,
}

/// A contender that is ready to trace.
struct Contender<'a> {
    name: &'static str,
    build_seconds: f64,
    bytes: u64,
    against: BTreeMap<String, String>,
    tracer: Tracer<'a>,
}

enum Tracer<'a> {
    Rilievo(&'a Displaced, Answer),
    #[cfg(feature = "embree")]
    Embree(Scene),
}

/// What rilievo is asked for.
#[derive(Clone, Copy, PartialEq)]
enum Answer {
    Crossing,
    Hit,
}

/// Measures what was asked for.
///
/// # Errors
/// A map or mesh that cannot be read, a contender that refuses, an output that cannot be written.
pub fn run(args: &SolidArgs) -> Result<(), String> {
    for &body in &args.bodies {
        for &map in &args.maps {
            let heights = map.load(args.size)?;
            let deep = |thickness| map.depth(args.size, thickness);
            measure_map(args, (body, map.name()), &heights, deep)?;
        }
        for map in &args.map_files {
            measure_map(args, (body, &map.name), &map.load(args.size)?, |thickness| thickness)?;
        }
    }
    Ok(())
}

/// Measures a body under a map; `deep` turns what was asked for into the thickness it is given.
fn measure_map(
    args: &SolidArgs,
    (body, map): (Body, &str),
    heights: &HeightMap,
    deep: impl Fn(f64) -> f64,
) -> Result<(), String> {
    for &thickness in &args.thickness {
        say(format_args!("{} {map} {thickness}", body.name()));
        let deep = deep(thickness);
        let watch = Watch::start();
        let displaced = one_thread(|| body.displaced(heights, deep))?;
        let took = watch.took().cpu;
        measure(args, (body, map, thickness), &displaced, took)?;
    }
    Ok(())
}

fn measure(
    args: &SolidArgs,
    (body, map, thickness): (Body, &str, f64),
    displaced: &Displaced,
    took: f64,
) -> Result<(), String> {
    let ours = |(name, answer)| Contender {
        name,
        build_seconds: took,
        bytes: displaced.bytes,
        against: BTreeMap::from([("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned())]),
        tracer: Tracer::Rilievo(displaced, answer),
    };
    let answers = [("rilievo", Answer::Crossing), ("rilievo-hit", Answer::Hit)];
    let mut contenders: Vec<_> = answers.map(ours).into();
    contenders.extend(peer(args, displaced)?);
    for (family, rays) in rays::rays(displaced, args.side) {
        if !args.families.contains(&family) {
            continue;
        }
        let loads: Vec<_> = contenders.iter().map(|c| c.load(&rays)).collect();
        let any = family.is_any_hit();
        let works: Vec<_> = (contenders.iter().zip(&loads))
            .map(|(contender, load)| || contender.trace(load, any))
            .collect();
        let measured = interleaved(&works, args.passes.into());
        for (contender, (tally, passes)) in contenders.iter().zip(&measured) {
            let record = SolidRecord {
                bench: "solids".to_owned(),
                body: body.name().to_owned(),
                map: map.to_owned(),
                size: args.size,
                thickness,
                family,
                contender: contender.name.to_owned(),
                mrays_per_s: rays.len() as f64 / passes.median * 1e-6,
                spread: passes.spread(),
                rays: rays.len() as u64,
                hits: tally.hits,
                mean_t: tally.mean_t(),
                build_seconds: contender.build_seconds,
                bytes: contender.bytes,
                against: contender.against.clone(),
            };
            if args.output.json {
                object(&record)?;
            } else {
                print(&line(&record))?;
            }
        }
    }
    Ok(())
}

fn line(record: &SolidRecord) -> String {
    format!(
        "{:7} {:14} {:5} {:8} {:12} {:8.3} Mrays/s +-{:.0} %, {:.2} % hit, build {:.3} s, {:.1} MB",
        record.body,
        record.map,
        record.thickness,
        record.family.name(),
        record.contender,
        record.mrays_per_s,
        record.spread * 50.0,
        100.0 * record.hits as f64 / record.rays as f64,
        record.build_seconds,
        record.bytes as f64 * 1e-6
    )
}

/// Embree's triangles, where they are part of this build.
#[cfg(feature = "embree")]
fn peer<'a>(args: &SolidArgs, displaced: &Displaced) -> Result<Option<Contender<'a>>, String> {
    let triangles = displaced.tessellate(1);
    let watch = Watch::start();
    let scene = Scene::of_triangles(&args.embree_config, &triangles.positions, &triangles.indices)?;
    let took = watch.took().cpu;
    let against = BTreeMap::from([
        ("version".to_owned(), scene.version()),
        ("config".to_owned(), args.embree_config.clone()),
        ("geometry".to_owned(), "quality medium, scene flags robust".to_owned()),
        ("triangles".to_owned(), triangles.indices.len().to_string()),
    ]);
    Ok(Some(Contender {
        name: "embree-tri",
        build_seconds: took,
        bytes: scene.bytes().0,
        against,
        tracer: Tracer::Embree(scene),
    }))
}

#[cfg(not(feature = "embree"))]
fn peer<'a>(_: &SolidArgs, displaced: &Displaced) -> Result<Option<Contender<'a>>, String> {
    let triangles = displaced.tessellate(1).indices.len();
    say(format_args!("skipped: embree-tri with {triangles} triangles; built without embree"));
    Ok(None)
}

/// Rays in a contender's own format.
enum Load {
    Rilievo(Vec<rilievo::Ray>),
    #[cfg(feature = "embree")]
    Embree(Vec<Ray1>),
}

impl Contender<'_> {
    fn load(&self, rays: &[Ray32]) -> Load {
        match &self.tracer {
            Tracer::Rilievo(..) => Load::Rilievo(rays.iter().map(widened).collect()),
            #[cfg(feature = "embree")]
            Tracer::Embree(_) => Load::Embree(rays.iter().map(Ray1::from).collect()),
        }
    }

    fn trace(&self, load: &Load, any: bool) -> Tally {
        match (&self.tracer, load) {
            (Tracer::Rilievo(body, answer), Load::Rilievo(rays)) => {
                let mut tally = Tally::default();
                for ray in rays {
                    let t = match (any, answer) {
                        (true, _) => body.surface.occludes(ray, &mut ()).then_some(0.0),
                        (false, Answer::Hit) => body.surface.closest(ray, &mut ()).map(|hit| hit.t),
                        (false, Answer::Crossing) => body.first_crossing(ray),
                    };
                    if let Some(t) = t {
                        tally.hit(t);
                    }
                }
                tally
            }
            #[cfg(feature = "embree")]
            (Tracer::Embree(scene), Load::Embree(rays)) => {
                if any {
                    scene.occluded(rays, false)
                } else {
                    scene.closest(rays, false)
                }
            }
            #[cfg(feature = "embree")]
            _ => Tally::default(),
        }
    }
}
