//! `refinement`: Embree's triangles come ever closer to rilievo's surface.
//!
//! The same displaced body is cut into ever more triangles, whose corners lie on the surface, and the
//! same rays meet both. What they differ by is the tessellation's own error: it has to fall as triangles
//! shrink. Nothing of rilievo takes part in Embree's answer but the corners, so this judges walk
//! and leaf from outside.
//!
//! Meshes are compared without the walls that close their seams, which a tessellation does not
//! have. Embree computes in `f32`: differences below some 10^-7 of the size are its rounding.

use super::body::{Body, Displaced};
use super::rays::{SolidFamily, rays};
use crate::args::RefinementArgs;
#[cfg(feature = "embree")]
use crate::embree::{Ray1, Scene};
use crate::rays::{Ray32, widened};
use crate::report::{print, say};

/// Hits farther apart than this share of the body's size count as different.
const APART: f64 = 1e-3;

/// What one tessellation differs by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Difference {
    /// Rays that hit on both sides, at about the same place.
    common: u64,
    /// Rays that hit one side only, or elsewhere.
    apart: u64,
    /// Distances between hits, as shares of the size: mean and 99th percentile.
    mean: f64,
    most: f64,
}

/// Prints a table for each body and family.
///
/// # Errors
/// A map or mesh that cannot be read, a contender that refuses, an output that cannot be written.
pub fn run(args: &RefinementArgs) -> Result<(), String> {
    print("| body | rays | triangles a texel | triangles | rays apart | mean | 99 % below |")?;
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: |")?;
    let heights = args.map.load(args.size)?;
    let deep = args.map.depth(args.size, args.thickness);
    for &body in &args.bodies {
        let displaced = body.without_walls(&heights, deep)?;
        let families = rays(&displaced, args.side);
        for density in args.densities.iter().copied() {
            say(format_args!("{} {density}", body.name()));
            let triangles = displaced.tessellate(density);
            let count = triangles.indices.len();
            for (family, rays) in &families {
                if !args.families.contains(family) {
                    continue;
                }
                let peer = trace(args, &triangles.positions, &triangles.indices, rays)?;
                let difference = compare(&displaced, rays, &peer);
                print(&line(body, *family, (density, count), &difference))?;
            }
        }
    }
    Ok(())
}

fn line(
    body: Body,
    family: SolidFamily,
    (density, triangles): (u32, usize),
    difference: &Difference,
) -> String {
    let Difference { common, apart, mean, most } = difference;
    format!(
        "| {} | {} | {} | {:.2} M | {apart} of {} | {mean:.1e} | {most:.1e} |",
        body.name(),
        family.name(),
        2 * density * density,
        triangles as f64 * 1e-6,
        common + apart
    )
}

/// Compares rilievo's hits with a peer's parameters.
fn compare(body: &Displaced, rays: &[Ray32], peer: &[Option<f64>]) -> Difference {
    let mut difference = Difference::default();
    let mut distances = Vec::new();
    for (ray, peer) in rays.iter().zip(peer) {
        let ray = widened(ray);
        match (body.surface.closest(&ray, &mut ()), peer) {
            (Some(hit), &Some(t)) => {
                let off = (hit.t - t).abs() * ray.direction.length() / body.size;
                if off > APART {
                    difference.apart += 1;
                } else {
                    distances.push(off);
                }
            }
            (None, None) => {}
            _ => difference.apart += 1,
        }
    }
    distances.sort_by(f64::total_cmp);
    difference.common = distances.len() as u64;
    if let Some(last) = distances.len().checked_sub(1) {
        difference.mean = distances.iter().sum::<f64>() / distances.len() as f64;
        difference.most = distances[last * 99 / 100];
    }
    difference
}

/// Embree's parameters of the nearest hits.
#[cfg(feature = "embree")]
fn trace(
    args: &RefinementArgs,
    positions: &[[f32; 3]],
    indices: &[[u32; 3]],
    rays: &[Ray32],
) -> Result<Vec<Option<f64>>, String> {
    let scene = Scene::of_triangles(&args.embree_config, positions, indices)?;
    let rays: Vec<_> = rays.iter().map(Ray1::from).collect();
    let mut all = Vec::with_capacity(rays.len());
    scene.each_closest(&rays, false, |t| all.push(t.map(f64::from)));
    Ok(all)
}

#[cfg(not(feature = "embree"))]
fn trace(
    _: &RefinementArgs,
    _: &[[f32; 3]],
    _: &[[u32; 3]],
    _: &[Ray32],
) -> Result<Vec<Option<f64>>, String> {
    Err("refinement needs Embree: build with --features embree".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapName;

    #[test]
    fn a_body_does_not_differ_from_itself_and_a_moved_peer_does() {
        let map = MapName::Gaussian.load(33).unwrap();
        let body = Body::Sphere.without_walls(&map, 0.02).unwrap();
        let (_, rays) = rays(&body, 24).pop().unwrap();
        let of = |moved: f64| -> Vec<_> {
            let hit = |ray| body.surface.closest(&widened(ray), &mut ()).map(|hit| hit.t + moved);
            rays.iter().map(hit).collect()
        };
        let same = compare(&body, &rays, &of(0.0));
        assert!(same.common > 100 && (same.apart, same.mean, same.most) == (0, 0.0, 0.0));
        let near = compare(&body, &rays, &of(1e-5));
        assert!(near.apart == 0 && (near.mean - 1e-5).abs() < 1e-9, "{near:?}");
        let far = compare(&body, &rays, &of(0.1));
        assert_eq!((far.common, far.apart), (0, same.common));
    }
}
