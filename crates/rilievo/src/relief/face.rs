//! [`ReliefFace`]: a displaced parallelogram.
//!
//! `S(u, v) = c0 + u (c1 - c0) + v (c3 - c0) + offset(u, v) N` with the unit normal `N` along
//! `(c1 - c0) x (c3 - c0)` and `offset = scale (H(u tile + shift) - zero)`. One height map, pyramid
//! and distance map serve every face, whatever its size, depth and orientation.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::accel::Aabb;
use crate::hit::Hit;
use crate::map::DistanceKind;
use crate::probe::{Counters, Probe};
use crate::ray::{Coherence, Part, Ray, Wall};
use crate::simd;

use super::Relief;
use super::batch::{BATCH, BatchOf};
use super::kernels::{AreCrossed, FirstCrossing, FirstCrossings, IsCrossed};
use super::method::Method;
use super::options::{Displacement, FaceOptions};
use super::placement::Placement;
use super::shading::{MapAxes, Shading};
use super::trace::{Crossing, Place, Trace};

/// Why a face was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FaceError {
    /// The fourth corner does not complete a parallelogram.
    #[error("the corners are not a parallelogram: c2 is {found}, c1 + c3 - c0 is {expected}")]
    NotParallelogram {
        /// Corner c2 as given.
        found: DVec3,
        /// Corner c2 of the parallelogram.
        expected: DVec3,
    },
    /// The corners are not finite or lie on one line.
    #[error("the corners span no area")]
    Degenerate,
    /// A number of the displacement is out of its range.
    #[error("displacement {key} is {value}; {allowed}")]
    Displacement {
        /// The key at fault.
        key: &'static str,
        /// The value found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Tiling unfolds the map to more cells than indices can count exactly.
    #[error("tile and shift unfold the map to lattice coordinates up to {found}; at most 4194304")]
    TooManyCells {
        /// Largest lattice coordinate.
        found: f64,
    },
    /// The method needs a distance map that the relief does not have.
    #[error("method {method} needs a {kind:?} distance map")]
    NoDistanceMap {
        /// The method asked for.
        method: Method,
        /// The kind of map it needs.
        kind: DistanceKind,
    },
}

/// Largest magnitude of a lattice coordinate.
const MAX_COORDINATE: f64 = (1u32 << 22) as f64;

/// A displaced parallelogram, ready to be traced. Cheap to copy around: the relief is shared.
#[derive(Clone, Debug)]
pub struct ReliefFace {
    placement: Placement,
    relief: Arc<Relief>,
    options: FaceOptions,
    axes: MapAxes,
    /// Bound on the coordinates of the base, for rounding errors.
    reach: f64,
    bounds: Aabb,
}

impl ReliefFace {
    /// A face with corners c0, c1, c2, c3; u runs from c0 to c1, v from c0 to c3.
    ///
    /// # Errors
    /// [`FaceError`] if the corners are not a parallelogram (to 1e-9 of its size), a number of the
    /// displacement is out of range, or the method lacks its distance map.
    pub fn new(
        corners: [DVec3; 4],
        relief: Arc<Relief>,
        options: FaceOptions,
    ) -> Result<Self, FaceError> {
        let [c0, c1, c2, c3] = corners;
        let (edge_u, edge_v) = (c1 - c0, c3 - c0);
        let area = edge_u.cross(edge_v);
        let extent = edge_u.length().max(edge_v.length());
        if !area.is_finite() || area.length() <= 1e-12 * extent * extent {
            return Err(FaceError::Degenerate);
        }
        let expected = c1 + edge_v;
        let reach = extent + c0.length() * 1e-6;
        let off = (c2 - expected).length();
        if off.is_nan() || off > 1e-9 * reach {
            return Err(FaceError::NotParallelogram { found: c2, expected });
        }
        Self::placed([c0, edge_u, edge_v], relief, options)
    }

    /// The same face under another displacement: depth, zero, tile and shift cost nothing, the
    /// relief is shared.
    ///
    /// # Errors
    /// As [`ReliefFace::new`], for numbers of the displacement.
    pub fn with_displacement(&self, displacement: Displacement) -> Result<Self, FaceError> {
        let options = FaceOptions { displacement, ..self.options.clone() };
        self.remade(Arc::clone(&self.relief), options)
    }

    /// The same face over another relief, an edited one for instance.
    ///
    /// # Errors
    /// As [`ReliefFace::new`], for a distance map that is missing or too many cells.
    pub fn with_relief(&self, relief: Arc<Relief>) -> Result<Self, FaceError> {
        self.remade(relief, self.options.clone())
    }

    fn remade(&self, relief: Arc<Relief>, options: FaceOptions) -> Result<Self, FaceError> {
        let Placement { corner, edge_u, edge_v, .. } = self.placement;
        Self::placed([corner, edge_u, edge_v], relief, options)
    }

    /// A face by its first corner and its edges along u and v.
    fn placed(
        frame: [DVec3; 3],
        relief: Arc<Relief>,
        options: FaceOptions,
    ) -> Result<Self, FaceError> {
        if let Some((key, value, allowed)) = options.displacement.fault() {
            return Err(FaceError::Displacement { key, value, allowed });
        }
        if let Some(kind) = options.method.distance_kind()
            && relief.distance(kind).is_none()
        {
            return Err(FaceError::NoDistanceMap { method: options.method, kind });
        }
        let placement = Placement::new(frame, relief.heights(), options.displacement);
        let farthest = placement.window.farthest();
        if farthest > MAX_COORDINATE {
            return Err(FaceError::TooManyCells { found: farthest });
        }
        let bounds = bounds(&placement, &relief, options.closed);
        let axes = MapAxes::new(&placement, relief.heights());
        let Placement { corner, edge_u, edge_v, .. } = &placement;
        let reach = corner.abs().max_element() + edge_u.length() + edge_v.length();
        Ok(Self { placement, relief, options, axes, reach, bounds })
    }

    /// The box that holds the displaced face and its walls, a rounding margin included.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The shared relief.
    pub fn relief(&self) -> &Arc<Relief> {
        &self.relief
    }

    /// Where its map lies in the world.
    pub(super) fn placement(&self) -> &Placement {
        &self.placement
    }

    /// The options the face was made with.
    pub fn options(&self) -> &FaceOptions {
        &self.options
    }

    /// The base point, edges and unit normal: `[c0, c1 - c0, c3 - c0, N]`.
    pub fn frame(&self) -> [DVec3; 4] {
        let Placement { corner, edge_u, edge_v, normal, .. } = self.placement;
        [corner, edge_u, edge_v, normal]
    }

    /// The nearest hit with `0 <= t <= ray.t_max`. `hit.surface` is 0.
    pub fn closest<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Hit> {
        let crossing = self.first_crossing(ray, probe)?;
        Some(self.complete(ray, &crossing))
    }

    /// Whether the ray meets the face at some `0 <= t <= ray.t_max`.
    #[inline]
    pub fn occludes<P: Probe>(&self, ray: &Ray, probe: &mut P) -> bool {
        if self.options.method.is_exact() {
            self.is_crossed(ray, probe.counters())
        } else {
            self.first_crossing(ray, probe).is_some()
        }
    }

    /// The nearest crossing with `0 <= t <= ray.t_max`: what [`ReliefFace::closest`] finds, without
    /// normals and position. Cheaper where several surfaces compete, or only `t` counts.
    #[inline]
    pub fn first_crossing<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Crossing> {
        self.crossing(ray, probe.counters())
    }

    /// [`ReliefFace::first_crossing`] of many rays, bit for bit the same; `found` takes one answer a
    /// ray. Quicker than one call a ray, most of all in runs of 16 rays that are coherent.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn first_crossings<P: Probe>(
        &self,
        (rays, coherence): (&[Ray], Coherence),
        found: &mut [Option<Crossing>],
        probe: &mut P,
    ) {
        assert_eq!(rays.len(), found.len(), "one answer a ray");
        for (rays, found) in rays.chunks(BATCH).zip(found.chunks_mut(BATCH)) {
            self.crossings((BatchOf::all(rays), coherence), found, probe.counters());
        }
    }

    /// [`ReliefFace::occludes`] of many rays; `occluded` takes one answer a ray.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn occludes_each<P: Probe>(&self, rays: &[Ray], occluded: &mut [bool], probe: &mut P) {
        assert_eq!(rays.len(), occluded.len(), "one answer a ray");
        for (rays, occluded) in rays.chunks(BATCH).zip(occluded.chunks_mut(BATCH)) {
            let stopped = self.stopped(BatchOf::all(rays), probe);
            for (k, occluded) in occluded.iter_mut().enumerate() {
                *occluded = stopped >> k & 1 == 1;
            }
        }
    }

    /// The face as its rays see it.
    fn trace(&self) -> Trace<'_> {
        let Self { placement, relief, options, .. } = self;
        Trace { placement, relief, options }
    }

    fn is_crossed(&self, ray: &Ray, counters: Option<&mut Counters>) -> bool {
        let trace = self.trace();
        match counters {
            None => simd::run(self.options.simd, IsCrossed { trace, ray, probe: &mut () }),
            Some(probe) => simd::run_portable(IsCrossed { trace, ray, probe }),
        }
    }

    fn crossing(&self, ray: &Ray, counters: Option<&mut Counters>) -> Option<Crossing> {
        let trace = self.trace();
        match counters {
            None => simd::run(self.options.simd, FirstCrossing { trace, ray, probe: &mut () }),
            Some(probe) => simd::run_portable(FirstCrossing { trace, ray, probe }),
        }
    }

    /// The first crossings of the rays of a batch.
    pub(crate) fn crossings(
        &self,
        (of, coherence): (BatchOf<'_>, Coherence),
        found: &mut [Option<Crossing>],
        counters: Option<&mut Counters>,
    ) {
        let trace = self.trace();
        match counters {
            None => {
                let probe = &mut ();
                simd::run(self.options.simd, FirstCrossings { trace, of, coherence, found, probe });
            }
            Some(probe) => {
                simd::run_portable(FirstCrossings { trace, of, coherence, found, probe });
            }
        }
    }

    /// Which rays of a batch meet the face before they end: one bit a ray.
    pub(crate) fn stopped<P: Probe>(&self, of: BatchOf<'_>, probe: &mut P) -> u16 {
        if !self.options.method.is_exact() {
            return of.each(u16::MAX).fold(0, |stopped, (k, ray)| {
                stopped | u16::from(self.first_crossing(&ray, probe).is_some()) << k
            });
        }
        let trace = self.trace();
        match probe.counters() {
            None => simd::run(self.options.simd, AreCrossed { trace, of, probe: &mut () }),
            Some(probe) => simd::run_portable(AreCrossed { trace, of, probe }),
        }
    }

    /// The hit of a crossing that [`ReliefFace::first_crossing`] found for this ray. `hit.surface`
    /// is 0.
    pub fn complete(&self, ray: &Ray, crossing: &Crossing) -> Hit {
        let Placement { edge_u, edge_v, normal, .. } = self.placement;
        let heights = self.relief.heights();
        let [u, v] = self.placement.uv(heights, crossing.lattice);
        let offset = self.placement.offset(crossing.raw);
        let (part, geometric_normal, shading_normal) = match crossing.place {
            Place::Cell { cell, local } => {
                let at = Shading { axes: &self.axes, heights, cell, local };
                let geometric = at.geometric_normal();
                let shading = at.shading_normal(&self.options.normals, geometric);
                (Part::Cell(cell[0], cell[1]), geometric, shading)
            }
            Place::Wall(wall) => {
                let normal = self.wall_normal(wall, ray.direction, crossing.front);
                (Part::Wall(wall), normal, normal)
            }
        };
        let size = self.reach + offset.abs();
        let off_ray = (crossing.error / self.placement.raw_per_length).abs();
        Hit {
            t: crossing.t,
            position: self.placement.base_point(u, v) + offset * normal,
            position_error: size * 16.0 * f64::EPSILON + off_ray,
            geometric_normal,
            shading_normal,
            tangents: [edge_u, edge_v],
            uv: DVec2::new(u, v),
            height: crossing.raw * heights.unit(),
            front: crossing.front,
            surface: 0,
            part,
            time: ray.time,
        }
    }

    /// Unit normal of a wall, towards the side that is clear of the solid below the surface.
    fn wall_normal(&self, wall: Wall, direction: DVec3, front: bool) -> DVec3 {
        let along = match wall {
            Wall::LowU | Wall::HighU | Wall::SeamU(_) => self.placement.edge_v,
            Wall::LowV | Wall::HighV | Wall::SeamV(_) => self.placement.edge_u,
        };
        let normal = along.cross(self.placement.normal).normalize();
        if (normal.dot(direction) < 0.0) == front { normal } else { -normal }
    }
}

/// The box of the surface between its lowest and highest height, and of its walls.
fn bounds(placement: &Placement, relief: &Relief, closed: bool) -> Aabb {
    let (low, high) = relief.heights().raw_range();
    let mut raws = vec![f64::from(low), f64::from(high)];
    if closed {
        raws.push(placement.raw_zero);
    }
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
    let points = raws.iter().flat_map(|&raw| {
        let offset = placement.offset(raw) * placement.normal;
        corners.map(|(u, v)| placement.base_point(u, v) + offset)
    });
    let bounds = Aabb::around(points);
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
    let extent = (bounds.max - bounds.min).max_element();
    bounds.grown(extent * 1e-6 + reach * 1e-12)
}
