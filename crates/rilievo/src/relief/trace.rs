//! The walk over the tiles of a face: what all methods share around their own walk.

use crate::map::{DistanceKind, HeightMap, Lattice, Wrap};
use crate::probe::Probe;
use crate::ray::{Ray, Wall};
use crate::simd::Lanes;

use super::Relief;
use super::approximate::{ApproximateHit, Segment, cell_in};
use super::cell_walk::walk_cells;
use super::distance_walk::walk_distance;
use super::kernels::Tiles;
use super::leaf::{Crossings, LeafHit};
use super::map_ray::{ExactRay, MapRay, Window, larger, smaller};
use super::method::Method;
use super::options::FaceOptions;
use super::placement::Placement;
use super::refine::{self, Root};
use super::tile::Tile;
use super::walk::{TileFrame, walk_pyramid};
use super::walls::{entry_wall, exit_wall, seam_wall};

/// A crossing of a face, in lattice space: what a walk ends in, before the work of shading.
/// [`super::ReliefFace::complete`] makes a [`crate::Hit`] of it.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// World parameter.
    pub t: f64,
    /// Unfolded lattice coordinates.
    pub lattice: [f64; 2],
    /// Raw height of the point.
    pub raw: f64,
    /// Bound on the raw height between the point and the ray.
    pub(crate) error: f64,
    /// Whether the ray came from the front.
    pub front: bool,
    pub(crate) place: Place,
}

/// What was crossed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    /// An unfolded cell, and where in it.
    Cell { cell: [i32; 2], local: [f64; 2] },
    /// An upright wall.
    Wall(Wall),
}

/// What an exact walk meets, still in the walk's frame.
pub(super) enum Met {
    Surface(LeafHit),
    /// A wall at parameter `s`, crossed from above the raw surface or from below.
    Wall {
        wall: Wall,
        s: f32,
        from_above: bool,
    },
}

impl Crossing {
    /// That of a refined root, unless it lies past the ray's end.
    #[inline(always)]
    pub(super) fn of_surface(ray: &ExactRay, t_max: f64, root: &Root, front: bool) -> Option<Self> {
        let t = ray.t_start + root.s * ray.t_length;
        // Decided before the crossing is put together: it is large.
        (t <= t_max).then(|| Self {
            t,
            lattice: [
                f64::from(root.cell[0]) + root.local[0],
                f64::from(root.cell[1]) + root.local[1],
            ],
            raw: root.raw,
            error: root.error,
            front,
            place: Place::Cell { cell: root.cell, local: root.local },
        })
    }
}

/// The crossing near a parameter whose root leads out of its cell.
#[cold]
#[inline(never)]
pub(super) fn refined_across(
    ray: &ExactRay,
    t_max: f64,
    (heights, window): (&HeightMap, &Window),
    (cell, s0, front): ([i32; 2], f64, bool),
) -> Option<Crossing> {
    let root = refine::across(ray, heights, window, cell, s0);
    Crossing::of_surface(ray, t_max, &root, front)
}

/// A face as its rays see it.
#[derive(Clone, Copy)]
pub(crate) struct Trace<'a> {
    pub placement: &'a Placement,
    pub relief: &'a Relief,
    pub options: &'a FaceOptions,
}

impl Trace<'_> {
    /// Which crossings of the raw surface are hits.
    pub(super) fn admitted(&self) -> Crossings {
        match (self.options.one_sided, self.options.displacement.scale > 0.0) {
            (false, _) => Crossings::Both,
            (true, true) => Crossings::Downward,
            (true, false) => Crossings::Upward,
        }
    }

    /// Whether the surface may jump where two tiles meet.
    fn has_seams(&self) -> bool {
        let x = self.relief.heights().x();
        (x.lattice(), x.wrap()) == (Lattice::Vertex, Wrap::Repeat)
    }

    /// The first crossing along a ray up to its end.
    #[inline(always)]
    pub fn first_crossing<L: Lanes, P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Crossing> {
        let map_ray = self.placement.map_ray(ray, self.options.closed)?;
        if !self.options.method.is_exact() {
            let hit = first_approximate(self, &map_ray, ray.from.is_some(), probe)?;
            let crossing = approximate_crossing(self, &map_ray, hit);
            return (crossing.t <= ray.t_max).then_some(crossing);
        }
        let met = first_met::<L, P>(self, &map_ray, probe)?;
        self.refined(&map_ray, ray.t_max, met)
    }

    /// Whether there is a crossing up to the ray's end, for exact methods: without the refinement
    /// where that cannot matter.
    #[inline(always)]
    pub fn is_crossed<L: Lanes, P: Probe>(&self, ray: &Ray, probe: &mut P) -> bool {
        let Some(map_ray) = self.placement.map_ray(ray, self.options.closed) else { return false };
        let Some(met) = first_met::<L, P>(self, &map_ray, probe) else { return false };
        self.ends_after(&map_ray, ray.t_max, met)
    }

    /// Whether the ray ends after what was met.
    #[inline(always)]
    pub(super) fn ends_after(&self, ray: &MapRay, t_max: f64, met: Met) -> bool {
        let (Met::Surface(LeafHit { s, .. }) | Met::Wall { s, .. }) = met;
        // Refinement moves a crossing into a neighbour of the neighbouring cell at most.
        let cells = 3.0 * smaller(ray.inv[0], ray.inv[1]);
        s + cells <= ray.end || self.refined(ray, t_max, met).is_some()
    }

    /// The crossing of what was met, in `f64`, unless it lies past the ray's end.
    #[inline(always)]
    fn refined(&self, ray: &MapRay, t_max: f64, met: Met) -> Option<Crossing> {
        let rising = self.options.displacement.scale > 0.0;
        let heights = self.relief.heights();
        let exact = &ray.exact;
        let t = |s: f64| exact.t_start + s * exact.t_length;
        match met {
            Met::Surface(LeafHit { s, cell, from_above }) => {
                let cell = [ray.unfolded(0, cell[0]), ray.unfolded(1, cell[1])];
                let (s0, front) = (f64::from(s), from_above == rising);
                let h = self.placement.corners(heights, cell);
                let (root, inside) = refine::inside(exact, &self.placement.window, (cell, h), s0);
                if inside {
                    Crossing::of_surface(exact, t_max, &root, front)
                } else {
                    refined_across(
                        exact,
                        t_max,
                        (heights, &self.placement.window),
                        (cell, s0, front),
                    )
                }
            }
            Met::Wall { wall, s, from_above } => {
                let (axis, line) = self.placement.wall_line(wall);
                let towards = line - exact.origin[axis];
                let refined = towards / exact.direction[axis];
                let s = if refined.is_finite() { refined.max(0.0) } else { f64::from(s) };
                let at = |k: usize| exact.origin[k] + s * exact.direction[k];
                let mut lattice = [at(0), at(1)];
                lattice[axis] = line;
                let t = t(s);
                (t <= t_max).then(|| Crossing {
                    t,
                    lattice,
                    raw: at(2),
                    error: 0.0,
                    front: from_above == rising,
                    place: Place::Wall(wall),
                })
            }
        }
    }
}

/// Walks the tiles front to back; inside each the face's method finds the first crossing.
#[inline(always)]
fn first_met<L: Lanes, P: Probe>(face: &Trace<'_>, ray: &MapRay, probe: &mut P) -> Option<Met> {
    let heights = face.relief.heights();
    let (enter, leave) = ray.window_span();
    if enter >= leave {
        return None;
    }
    if face.options.closed
        && enter > 0.0
        && let Some(wall) = entry_wall(face, ray, enter)
    {
        return Some(wall);
    }
    let start = larger(enter, ray.cull[0]);
    let stop = smaller(leave, ray.cull[1]);
    if start < stop {
        let met = match face.placement.unfolding {
            Some(unfolding) if face.options.method == Method::Pyramid => {
                let frame = TileFrame::of_window(ray, unfolding, (enter, leave));
                let maps = (heights, face.relief.pyramid());
                walk_pyramid::<L, P>(maps, ray, &frame, face.admitted(), probe).map(Met::Surface)
            }
            _ => L::call(Tiles { face, ray, part: [start, stop], probe }),
        };
        if met.is_some() {
            return met;
        }
    }
    if face.options.closed && leave < 1.0 { exit_wall(face, ray, leave) } else { None }
}

/// Walks tile after tile between two parameters.
#[inline(always)]
pub(super) fn walk_tiles<L: Lanes, P: Probe>(
    face: &Trace<'_>,
    ray: &MapRay,
    [start, stop]: [f32; 2],
    probe: &mut P,
) -> Option<Met> {
    let heights = face.relief.heights();
    let mut cell = [ray.cell_at(0, start), ray.cell_at(1, start)];
    loop {
        let tile = Tile::new(heights, ray, cell);
        let part = [larger(start, tile.enter), smaller(stop, tile.leave)];
        if let Some(hit) = walk_tile::<L, P>(face, ray, &tile, part, probe) {
            return Some(Met::Surface(hit));
        }
        if tile.leave >= stop {
            return None;
        }
        let crossed = [tile.leaves_across(ray, 0), tile.leaves_across(ray, 1)];
        for axis in 0..2 {
            let at = &tile.axes[axis];
            cell[axis] = if crossed[axis] {
                at.to
            } else {
                ray.cell_at(axis, tile.leave).clamp(at.from, at.to - 1)
            };
        }
        if cell[0] >= ray.end_cell(0) || cell[1] >= ray.end_cell(1) {
            return None;
        }
        if face.has_seams()
            && let Some(wall) = seam_wall(face, ray, &tile, (cell, crossed))
        {
            return Some(wall);
        }
    }
}

/// The face's method on one tile.
#[inline(always)]
fn walk_tile<L: Lanes, P: Probe>(
    face: &Trace<'_>,
    ray: &MapRay,
    tile: &Tile,
    part: [f32; 2],
    probe: &mut P,
) -> Option<LeafHit> {
    let relief = &face.relief;
    let (heights, admit) = (relief.heights(), face.admitted());
    let with = |kind: DistanceKind| relief.distance(kind);
    let distances = match face.options.method {
        Method::Distance => with(DistanceKind::Boxes),
        Method::DistanceCorrected => with(DistanceKind::Corrected),
        _ => None,
    };
    match (face.options.method, distances) {
        (Method::Dda, _) => walk_cells(heights, ray, tile, part, (admit, probe)),
        (_, Some(map)) => walk_distance((heights, map), ray, tile, part, (admit, probe)),
        _ => {
            let frame = TileFrame::of(ray, tile);
            walk_pyramid::<L, P>((heights, relief.pyramid()), ray, &frame, admit, probe)
        }
    }
}

/// The two approximate methods.
fn first_approximate<P: Probe>(
    face: &Trace<'_>,
    ray: &MapRay,
    spawned: bool,
    probe: &mut P,
) -> Option<ApproximateHit> {
    let segment = Segment::new(
        face.relief.heights(),
        &ray.exact,
        &face.placement.window,
        f64::from(ray.cull[1]),
    )?;
    let segment = segment.spawned(spawned);
    let hit = match face.relief.distance(DistanceKind::Published) {
        Some(map) if face.options.method == Method::DistancePublished => {
            segment.published(map, probe)
        }
        _ => segment.march(probe),
    }?;
    face.admitted().admits(hit.from_above).then_some(hit)
}

fn approximate_crossing(face: &Trace<'_>, ray: &MapRay, hit: ApproximateHit) -> Crossing {
    let exact = &ray.exact;
    let at = |k: usize| exact.origin[k] + hit.s * exact.direction[k];
    let lattice = [at(0), at(1)];
    let (cell, local) = cell_in(&face.placement.window, lattice);
    Crossing {
        t: exact.t_start + hit.s * exact.t_length,
        lattice,
        raw: at(2),
        error: 0.0,
        front: hit.from_above == (face.options.displacement.scale > 0.0),
        place: Place::Cell { cell, local },
    }
}
