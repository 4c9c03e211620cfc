//! How rough a level is in place of its relief: variances of slopes in the scene.
//!
//! With `L` the variances that were lost of `dH/du` and `dH/dv` (their covariance is not kept) and `G` the metric of
//! the base, `G_uv = P_u . P_v`, slopes of the offset `scale H(u tile + shift)` have the variance
//! `scale^2 tile^2 L` per unit of u and v; its trace in scene units, `s = sx^2 + sy^2`, is that times the inverse of `G`:
//! `scale^2 (tile_u^2 L_u G_vv + tile_v^2 L_v G_uu) / det G`.
//!
//! LEAN mapping adds the covariance of slopes to that of the facets, `alpha^2 / 2` along each axis for Beckmann's
//! distribution \[Olano2010\]. Our lobes are round and GGX, so each axis takes half of the trace:
//! `alpha'^2 = alpha^2 + 2 (s / 2) = alpha^2 + s`, as \[Tokuyoshi2019\] does for GGX.
//!
//! Diffusers are dulled too. Oren's and Nayar's facets are tilted by angles of standard deviation sigma, whose
//! tangent squared is `s`; the roughness of our form of it \[Portsmouth2025\] is the ratio of the two terms of theirs,
//! `B / A` with `A = 1 - 0.5 sigma^2 / (sigma^2 + 0.33)` and `B = 0.45 sigma^2 / (sigma^2 + 0.09)` \[Oren1994\]. It
//! stands for the shadows and the light that facets throw on each other, which a flat level has not.

use glam::DVec3;
use rilievo::map::CubeFace;
use rilievo::surface::Surface;
use rilievo::{Hit, Part};

use super::{Level, Lost};

impl Level {
    /// The trace `s` at a hit; 0 on walls and where nothing is lost.
    pub fn lost_slopes(&self, hit: &Hit) -> f64 {
        let Some(Some(lost)) = self.lost.get(hit.surface as usize) else { return 0.0 };
        match (lost, hit.part) {
            (
                Lost::Map(slopes, displacement),
                Part::Cell(i, j) | Part::TriangleCell { cell: [i, j], .. },
            ) => {
                let scaled = |k: usize| displacement.scale * displacement.tile[k];
                let [u, v] = slopes.at([i, j]);
                let [u, v] = [u * scaled(0).powi(2), v * scaled(1).powi(2)];
                trace([u, v], self.local_tangents(hit))
            }
            (Lost::Cube { slopes, cells, radius, scale }, Part::CubeCell(face, i, j)) => {
                let variances = slopes[face.index()].at([i as i32, j as i32]);
                let variances = variances.map(|variance| variance * scale * scale);
                trace(variances, cube_tangents(face, *cells, *radius, [i, j]))
            }
            _ => 0.0,
        }
    }

    /// The tangents of a hit in the frame in which the surface was displaced.
    fn local_tangents(&self, hit: &Hit) -> [DVec3; 2] {
        let world_from_local = match &self.world.surfaces()[hit.surface as usize] {
            Surface::Instance(instance) => *instance.world_from_local(),
            Surface::Moving(moving) => moving.world_from_local(hit.time),
            _ => return hit.tangents,
        };
        let local_from_world = world_from_local.matrix3.inverse();
        hit.tangents.map(|tangent| local_from_world * tangent)
    }
}

/// The trace of slopes in scene units, of variances along u and v with these tangents.
fn trace([variance_u, variance_v]: [f64; 2], [u, v]: [DVec3; 2]) -> f64 {
    let (uu, uv, vv) = (u.length_squared(), u.dot(v), v.length_squared());
    let trace = (variance_u * vv + variance_v * uu) / (uu * vv - uv * uv);
    // Where uv do not span an area there are no slopes.
    if trace.is_finite() { trace.max(0.0) } else { 0.0 }
}

/// Tangents of a sphere at the middle of a cell, u and v from 0 to 1 across the face.
fn cube_tangents(face: CubeFace, cells: u32, radius: f64, cell: [u32; 2]) -> [DVec3; 2] {
    let [x, y] = cell.map(|k| (2.0 * f64::from(k) + 1.0) / f64::from(cells) - 1.0);
    let at = face.from_frame([x, y, 1.0]);
    let length = at.length();
    let outward = at / length;
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|along| {
        let along = face.from_frame(along);
        2.0 * radius / length * (along - outward.dot(along) * outward)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_do_not_depend_on_how_uv_lie() {
        let trace_of = |u: DVec3, v: DVec3| trace([4.0, 4.0], [u, v]);
        // A square of side 2, straight and turned; twice as far per unit of u is half as steep.
        assert!((trace_of(2.0 * DVec3::X, 2.0 * DVec3::Y) - 2.0).abs() < 1e-12);
        let turned =
            [DVec3::new(2.0, 0.0, 2.0), DVec3::new(-2.0, 0.0, 2.0)].map(|t| t / 2f64.sqrt());
        assert!((trace_of(turned[0], turned[1]) - 2.0).abs() < 1e-12);
        assert!((trace([4.0, 0.0], [4.0 * DVec3::X, DVec3::Y]) - 0.25).abs() < 1e-12);
        assert_eq!(trace_of(DVec3::X, DVec3::X), 0.0);
        assert_eq!(trace_of(DVec3::ZERO, DVec3::ZERO), 0.0);
    }

    #[test]
    fn tangents_of_a_sphere_reach_as_far_as_its_cells() {
        let point = |x: f64, y: f64| 3.0 * CubeFace::NegY.from_frame([x, y, 1.0]).normalize();
        let [i, j] = [5, 1];
        let at = |k: u32| (2.0 * f64::from(k) + 1.0) / 8.0 - 1.0;
        let (x, y, h) = (at(i), at(j), 1e-6);
        let found = cube_tangents(CubeFace::NegY, 8, 3.0, [i, j]);
        let u = (point(x + h, y) - point(x - h, y)) / h;
        let v = (point(x, y + h) - point(x, y - h)) / h;
        assert!((found[0] - u).length() < 1e-8 && (found[1] - v).length() < 1e-8);
    }
}
