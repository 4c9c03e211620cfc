//! `shells`: displaced meshes beside their tessellation in Embree, one thread, the same rays in
//! the same run.
//!
//! The tessellation has two triangles a texel: each base triangle is cut into n x n, n the root of
//! twice its area in texels; the scene is robust and of medium quality. Thickness is the depth of the relief as
//! a share of the base's diagonal.

mod base;
mod rays;

use std::sync::Arc;

use glam::DVec3;
use rilievo::relief::{Displacement, MeshOptions, Relief, ReliefMesh};
use rilievo::{Counters, Probe, Ray};
use serde::{Deserialize, Serialize};

use crate::args::ShellArgs;
#[cfg(feature = "embree")]
use crate::embree;
use crate::map::MapName;
use crate::measure::interleaved;
use crate::rays::{Ray32, widened};
use crate::report::{object, print, say};
use crate::tally::Tally;

pub use base::Base;
pub use rays::ShellFamily;

/// One line of `shells --json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Always `shells`.
    pub bench: String,
    pub base: String,
    pub map: String,
    /// Samples a side.
    pub size: u32,
    pub thickness: f64,
    pub family: String,
    pub nodes_per_ray: f64,
    pub cells_per_ray: f64,
    /// Processor time of one thread, the median pass.
    pub ns_per_ray: f64,
    /// The same of Embree, if it was measured.
    pub embree_ns_per_ray: Option<f64>,
    /// Bytes beyond the heights: the mesh, its prisms and trees, and the map's bounds.
    pub bytes: u64,
    pub embree_bytes: Option<u64>,
    pub build_seconds: f64,
    pub rays: u64,
    pub hits: u64,
    pub embree_hits: Option<u64>,
}

/// Measures every base, map, thickness and family.
///
/// # Errors
/// A map or mesh that cannot be read or displaced, what Embree refuses, or an output that cannot be
/// written.
pub fn run(args: &ShellArgs) -> Result<(), String> {
    for &base in &args.bases {
        for &map in &args.maps {
            for &thickness in &args.thicknesses {
                for record in one_shell(args, (base, map), thickness)? {
                    tell(args, &record)?;
                }
            }
        }
    }
    Ok(())
}

fn tell(args: &ShellArgs, record: &Record) -> Result<(), String> {
    if args.output.json {
        return object(record);
    }
    let beside = match record.embree_ns_per_ray {
        Some(ns) => format!("embree {ns:7.1} ns, ratio {:4.2}", ns / record.ns_per_ray),
        None => String::new(),
    };
    print(&format!(
        "{:6} {:10} {:6.3} {:8} {:7.1} ns {:6.2} nodes {:6.2} cells {beside}",
        record.base,
        record.map,
        record.thickness,
        record.family,
        record.ns_per_ray,
        record.nodes_per_ray,
        record.cells_per_ray,
    ))
}

fn one_shell(
    args: &ShellArgs,
    (base, map): (Base, MapName),
    thickness: f64,
) -> Result<Vec<Record>, String> {
    say(format_args!("{} {} {thickness}", base.name(), map.name()));
    let mesh = base.mesh()?;
    let heights = map.load(args.size)?;
    let bounds = mesh.bounds();
    let size = (bounds.max - bounds.min).length();
    let repeats = map.depth(args.size, 1.0);
    let displacement =
        Displacement { scale: thickness * size * repeats, zero: 0.5, ..Displacement::default() };
    let relief = Arc::new(Relief::new(heights));
    let options = MeshOptions { displacement, ..MeshOptions::default() };
    let watch = crate::clock::Watch::start();
    let shell = ReliefMesh::new(&mesh, Arc::clone(&relief), options).map_err(|e| e.to_string())?;
    let build_seconds = watch.took().cpu;
    let count = if args.quick { 64 } else { 256 };
    #[cfg(feature = "embree")]
    let peer = match args.alone {
        true => None,
        false => {
            let (positions, triangles) = tessellated(&shell);
            Some(embree::Scene::of_triangles("threads=1", &positions, &triangles)?)
        }
    };
    let mut records = Vec::new();
    for &family in &args.families {
        let rays32 = rays::rays(&shell, family, count);
        let rays: Vec<Ray> = rays32.iter().map(widened).collect();
        let any = family.is_any_hit();
        let ours = || trace(&shell, &rays, any, &mut ());
        #[cfg(feature = "embree")]
        let theirs = || {
            let rays: Vec<_> = rays32.iter().map(embree::Ray1::from).collect();
            peer.as_ref().map(|scene| match any {
                true => scene.occluded(&rays, false),
                false => scene.closest(&rays, false),
            })
        };
        #[cfg(not(feature = "embree"))]
        let theirs = || None::<Tally>;
        let works: [&dyn Fn() -> Option<Tally>; 2] = [&|| Some(ours()), &theirs];
        let [(tally, passes), (peer_tally, peer_passes)] =
            interleaved(&works, args.passes.into()).try_into().map_err(|_| "two contenders")?;
        let mut counters = Counters::default();
        trace(&shell, &rays, any, &mut counters);
        let per_ray = |x: f64| x / rays.len() as f64;
        #[cfg(feature = "embree")]
        let embree_bytes = peer.as_ref().map(|scene| scene.bytes().0);
        #[cfg(not(feature = "embree"))]
        let embree_bytes = None;
        records.push(Record {
            bench: "shells".to_owned(),
            base: base.name().to_owned(),
            map: map.name().to_owned(),
            size: args.size,
            thickness,
            family: family.name().to_owned(),
            nodes_per_ray: per_ray(counters.nodes as f64),
            cells_per_ray: per_ray(counters.cells as f64),
            ns_per_ray: per_ray(passes.median * 1e9),
            embree_ns_per_ray: peer_tally.map(|_| per_ray(peer_passes.median * 1e9)),
            bytes: shell.bytes() + relief.bytes().1,
            embree_bytes,
            build_seconds,
            rays: rays.len() as u64,
            hits: tally.map_or(0, |tally| tally.hits),
            embree_hits: peer_tally.map(|tally| tally.hits),
        });
    }
    Ok(records)
}

fn trace<P: Probe>(shell: &ReliefMesh, rays: &[Ray], any: bool, probe: &mut P) -> Tally {
    let mut tally = Tally::default();
    for ray in rays {
        if any {
            if shell.occludes(ray, probe) {
                tally.hit(0.0);
            }
        } else if let Some(hit) = shell.first_crossing(ray, probe) {
            tally.hit(hit.t);
        }
    }
    tally
}

/// The displaced surface as triangles, two a texel.
#[cfg(feature = "embree")]
fn tessellated(shell: &ReliefMesh) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for base in 0..shell.data().triangles.len() as u32 {
        let n = (2.0 * shell.cells_under(base)).sqrt().ceil().max(1.0) as u32;
        let first = positions.len() as u32;
        // Row j has n - j + 1 points.
        let at = |i: u32, j: u32| first + j * (n + 1) - j * j.saturating_sub(1) / 2 + i;
        for j in 0..=n {
            for i in 0..=n - j {
                let [v, w] = [i, j].map(|k| f64::from(k) / f64::from(n));
                let p: DVec3 = shell.point(base, [1.0 - v - w, v, w]);
                positions.push(p.to_array().map(|x| x as f32));
            }
        }
        for j in 0..n {
            for i in 0..n - j {
                triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < n {
                    triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    (positions, triangles)
}

/// A ray of `f32` numbers.
fn rounded(origin: DVec3, direction: DVec3, t_max: f64) -> Ray32 {
    let single = |v: DVec3| v.to_array().map(|x| x as f32);
    Ray32 { origin: single(origin), direction: single(direction), t_max: t_max as f32 }
}
