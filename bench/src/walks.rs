//! `walks`: what the exact methods pay for a ray: nodes, leaves, steps, and nanoseconds of one
//! thread.
//!
//! The rays are those of `kernels`, the methods take turns within one run, and all find the same
//! hits. `cells` counts what is handed to the leaf: a single cell of `dda` and `distance`, a block
//! of 4 x 4 of `pyramid`. The distance map is as wide and deep as asked for, in the face's own
//! metric.

use std::sync::Arc;

use rilievo::map::{DistanceKind, DistanceMap, DistanceOptions, HeightMap, Metric};
use rilievo::{Counters, Probe, Ray};

use rilievo::relief::{Displacement, FaceOptions, Method, Relief, ReliefFace};
use serde::{Deserialize, Serialize};

use crate::args::WalkArgs;
use crate::map::MapName;
use crate::measure::interleaved;
use crate::rays::{CORNERS, Row, Scene, widened};
use crate::report::{object, print, say};
use crate::tally::Tally;

/// Pixels a side of the images that make the rays.
const SIDE: u32 = 256;

/// One line of `walks --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Always `walks`.
    pub bench: String,
    pub map: String,
    /// Samples a side.
    pub size: u32,
    pub depth: f64,
    pub family: String,
    pub method: String,
    /// Voxels along x, y and z of the distance map; none for other methods.
    pub voxels: Option<[u32; 3]>,
    /// Bytes a sample held beyond the heights for this method.
    pub bytes_per_texel: f64,
    pub nodes_per_ray: f64,
    pub cells_per_ray: f64,
    pub steps_per_ray: f64,
    /// Processor time of one thread, the median pass.
    pub ns_per_ray: f64,
    /// (slowest - fastest) / median pass.
    pub spread: f64,
    pub rays: u64,
    pub hits: u64,
}

/// A method with the relief it walks.
struct Walker {
    method: Method,
    voxels: Option<[u32; 3]>,
    bytes: u64,
    face: ReliefFace,
}

/// Measures every map, size and family, the methods in turn.
///
/// # Errors
/// A map that cannot be read, a size that is refused, or an output that cannot be written.
pub fn run(args: &WalkArgs) -> Result<(), String> {
    for &map in &args.maps {
        for &size in &args.sizes {
            say(format_args!("{} {size}: map, rays and distance maps", map.name()));
            for record in one_map(args, map, size)? {
                if args.output.json {
                    object(&record)?;
                    continue;
                }
                let voxels = record.voxels.map_or(String::new(), |[x, _, z]| format!("{x}x{z}"));
                print(&format!(
                    "{:14} {size:5} {:8} {:9}{voxels:8} {:6.2} B/texel {:6.2} nodes {:7.2} cells \
                     {:6.2} steps {:8.1} ns +-{:.0} %",
                    record.map,
                    record.family,
                    record.method,
                    record.bytes_per_texel,
                    record.nodes_per_ray,
                    record.cells_per_ray,
                    record.steps_per_ray,
                    record.ns_per_ray,
                    record.spread * 50.0
                ))?;
            }
        }
    }
    Ok(())
}

fn one_map(args: &WalkArgs, map: MapName, size: u32) -> Result<Vec<Record>, String> {
    let depth = map.depth(size, args.depth);
    let heights = map.load(size)?;
    let scene = Scene::new(Relief::new(heights.clone()), depth, SIDE)?;
    let walkers = walkers(args, &heights, depth)?;
    let mut records = Vec::new();
    for &family in &args.families {
        let batch = scene.batch(Row::Single(family));
        let rays: Vec<Ray> = batch.rays.iter().map(widened).collect();
        let any_hit = batch.row.is_any_hit();
        let works: Vec<_> =
            walkers.iter().map(|walker| || trace(walker, &rays, any_hit, &mut ())).collect();
        let measured = interleaved(&works, args.passes.into());
        for (walker, (tally, passes)) in walkers.iter().zip(measured) {
            let mut counters = Counters::default();
            trace(walker, &rays, any_hit, &mut counters);
            let per_ray = |count: u64| count as f64 / rays.len() as f64;
            records.push(Record {
                bench: "walks".to_owned(),
                map: map.name().to_owned(),
                size,
                depth,
                family: family.name().to_owned(),
                method: walker.method.name().to_owned(),
                voxels: walker.voxels,
                bytes_per_texel: walker.bytes as f64 / (f64::from(size) * f64::from(size)),
                nodes_per_ray: per_ray(counters.nodes),
                cells_per_ray: per_ray(counters.cells),
                steps_per_ray: per_ray(counters.steps),
                ns_per_ray: passes.median * 1e9 / rays.len() as f64,
                spread: passes.spread(),
                rays: rays.len() as u64,
                hits: tally.hits,
            });
        }
    }
    Ok(records)
}

/// `dda`, `pyramid`, and `distance` with a map of each size asked for.
fn walkers(args: &WalkArgs, heights: &HeightMap, depth: f64) -> Result<Vec<Walker>, String> {
    let displacement = Displacement { scale: depth, ..Displacement::default() };
    let walker = |method: Method, map: Option<DistanceMap>| {
        let relief = Relief::new(heights.clone());
        let (voxels, bytes) = match &map {
            Some(map) => (Some(map.size()), map.bytes()),
            None if method == Method::Pyramid => (None, relief.bytes().1),
            None => (None, 0),
        };
        let relief = match map {
            Some(map) => relief.with_distance(map).map_err(|e| e.to_string())?,
            None => relief,
        };
        let options = FaceOptions { displacement, method, ..FaceOptions::default() };
        let face = ReliefFace::new(CORNERS, Arc::new(relief), options);
        Ok::<_, String>(Walker { method, voxels, bytes, face: face.map_err(|e| e.to_string())? })
    };
    let mut walkers = vec![walker(Method::Dda, None)?, walker(Method::Pyramid, None)?];
    let metric = Metric::of_face(heights, [1.0, 1.0], depth);
    let kind = DistanceKind::Boxes;
    let default = DistanceOptions::by_default(heights, kind, metric);
    let mut sizes: Vec<[u32; 3]> = args.grids.iter().map(|grid| grid.voxels()).collect();
    if sizes.is_empty() {
        sizes.push(default.size);
    }
    for size in sizes {
        let options = DistanceOptions { size, ..default };
        let map = DistanceMap::from_height(heights, kind, &options).map_err(|e| e.to_string())?;
        walkers.push(walker(Method::Distance, Some(map))?);
    }
    Ok(walkers)
}

fn trace<P: Probe>(walker: &Walker, rays: &[Ray], any_hit: bool, probe: &mut P) -> Tally {
    let mut tally = Tally::default();
    for ray in rays {
        if any_hit {
            if walker.face.occludes(ray, probe) {
                tally.hit(0.0);
            }
        } else if let Some(hit) = walker.face.first_crossing(ray, probe) {
            tally.hit(hit.t);
        }
    }
    tally
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::Family;
    use crate::transforms::Grid;

    #[test]
    fn all_methods_hit_alike_and_count_their_own_work() {
        let args = WalkArgs {
            maps: vec![MapName::Studded],
            sizes: vec![129],
            families: vec![Family::Primary, Family::Shadow],
            grids: vec![Grid { side: 32, depth: 8 }, Grid { side: 128, depth: 16 }],
            depth: 0.1,
            passes: 1,
            output: crate::args::Output { json: true },
        };
        let records = one_map(&args, MapName::Studded, 129).unwrap();
        assert_eq!(records.len(), 2 * 4);
        for family in records.chunks(4) {
            let [dda, pyramid, coarse, fine] = family else { panic!("{family:?}") };
            assert!(family.iter().all(|r| r.hits == dda.hits && r.rays == dda.rays));
            assert!(dda.hits > 0 && dda.cells_per_ray > pyramid.cells_per_ray);
            assert!(pyramid.nodes_per_ray > 0.0 && pyramid.steps_per_ray == 0.0);
            assert_eq!((coarse.voxels, fine.voxels), (Some([32, 32, 8]), Some([128, 128, 16])));
            assert!(fine.steps_per_ray > 0.0 && fine.cells_per_ray < coarse.cells_per_ray);
            // A coarse map shows a cell once for each column it borders, so only the fine one saves.
            assert!(fine.cells_per_ray < dda.cells_per_ray);
        }
    }
}
