//! `kernels`: rays a second of one thread, memory and build time, rilievo beside Embree.

mod record;
mod table;

use rilievo::relief::Relief;

use crate::args::KernelArgs;
use crate::contender::{Built, Contender, Task};
use crate::map::MapName;
use crate::measure::interleaved;
use crate::rays::{Row, Scene};
use crate::report::{object, say};

pub use record::Record;
#[cfg(test)]
pub use record::tests::example;

/// Pixels a side of the images that make the rays.
const SIDE: u32 = 1024;

/// The same with `--quick`.
const QUICK_SIDE: u32 = 256;

/// Measures what was asked for; one record as soon as it is there, or one table a map and size.
///
/// # Errors
/// A map that cannot be read, a contender that refuses, or an output that cannot be written.
pub fn run(args: &KernelArgs) -> Result<(), String> {
    let contenders = compiled(&args.contenders);
    for &map in &args.maps {
        for &size in &args.sizes {
            let records = one_map(args, &contenders, map, size)?;
            if !args.output.json {
                table::print_table(&records)?;
            }
        }
    }
    Ok(())
}

/// Those of `asked` that this build holds; the others are named once.
fn compiled(asked: &[Contender]) -> Vec<Contender> {
    let (here, missing): (Vec<_>, Vec<_>) = asked.iter().partition(|c| c.is_compiled());
    if !missing.is_empty() {
        let names: Vec<_> = missing.iter().map(|c: &Contender| c.name()).collect();
        say(format_args!(
            "skipped: {}; built without the feature embree, this run knows rilievo only",
            names.join(", ")
        ));
    }
    here
}

fn one_map(
    args: &KernelArgs,
    contenders: &[Contender],
    map: MapName,
    size: u32,
) -> Result<Vec<Record>, String> {
    say(format_args!("{} {size}: map, rays and contenders", map.name()));
    let depth = map.depth(size, args.depth);
    let heights = map.load(size)?;
    let side = if args.quick { QUICK_SIDE } else { SIDE };
    let scene = Scene::new(Relief::new(heights.clone()), depth, side)?;
    let task = Task {
        heights: &heights,
        depth,
        simd: args.simd.unwrap_or_default(),
        #[cfg(feature = "embree")]
        embree_config: &args.embree_config,
    };
    let built = build_all(contenders, &task, (map, size), args.max_memory)?;
    let mut records = Vec::new();
    for row in Row::ALL.into_iter().filter(|row| args.families.contains(&row.family())) {
        let batch = scene.batch(row);
        let calls: Vec<_> = built
            .iter()
            .flat_map(|built| batch_widths(built, &batch))
            .map(|(built, width)| (built, width, built.load(&batch, width)))
            .collect();
        let works: Vec<_> = calls.iter().map(|(_, _, loaded)| || loaded.trace()).collect();
        let measured = interleaved(&works, args.passes.into());
        for ((built, width, loaded), (tally, passes)) in calls.iter().zip(measured) {
            let mut facts = built.facts.clone();
            facts.insert("call", loaded.call().to_owned());
            let record = Record {
                bench: "kernels".to_owned(),
                map: map.name().to_owned(),
                size,
                depth,
                family: row.family(),
                packet: row.packet() > 1,
                rays_a_call: *width,
                contender: built.contender.name().to_owned(),
                mrays_per_s: batch.rays.len() as f64 / passes.median * 1e-6,
                spread: passes.spread(),
                passes: args.passes.into(),
                rays: batch.rays.len() as u64,
                hits: tally.hits,
                mean_t: tally.mean_t(),
                build_seconds: built.took.cpu,
                build_wall_seconds: built.took.wall,
                bytes_per_texel: per_texel(built.bytes.0, size),
                peak_bytes_per_texel: per_texel(built.bytes.1, size),
                against: facts.into_iter().map(|(k, v)| (k.to_owned(), v)).collect(),
            };
            if args.output.json {
                object(&record)?;
            }
            records.push(record);
        }
    }
    Ok(records)
}

fn batch_widths<'a>(built: &'a Built, batch: &crate::rays::Batch) -> Vec<(&'a Built, usize)> {
    built.widths(batch).into_iter().map(|width| (built, width)).collect()
}

fn per_texel(bytes: u64, size: u32) -> f64 {
    bytes as f64 / (f64::from(size) * f64::from(size))
}

/// Builds the contenders one after the other; those that would not fit into `max_memory` beside
/// what is already held are skipped, and said to be.
fn build_all(
    contenders: &[Contender],
    task: &Task<'_>,
    (map, size): (MapName, u32),
    max_memory: u64,
) -> Result<Vec<Built>, String> {
    let mut built: Vec<Built> = Vec::new();
    let cells = u64::from(size - 1) * u64::from(size - 1);
    for &contender in contenders {
        let held: u64 = built.iter().map(|b| b.bytes.0).sum();
        let needed = contender.peak_bytes(cells);
        if held + needed > max_memory {
            say(format_args!(
                "skipped: {} on {} {size}: {needed} bytes beside {held} held, at most {max_memory} \
                 allowed (--max-memory)",
                contender.name(),
                map.name()
            ));
            continue;
        }
        built.push(contender.build(task)?);
    }
    Ok(built)
}
