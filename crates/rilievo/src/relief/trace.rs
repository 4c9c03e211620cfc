//! The walk over the tiles of a face: what all methods share around their own walk.

use crate::map::{DistanceKind, Lattice, Wrap};
use crate::probe::Probe;
use crate::ray::{Ray, Wall};
use crate::simd::Lanes;

use super::Relief;
use super::approximate::{ApproximateHit, Segment};
use super::cell_walk::walk_cells;
use super::distance_walk::walk_distance;
use super::leaf::{Crossings, LeafHit};
use super::map_ray::{MapRay, larger, smaller};
use super::method::Method;
use super::options::FaceOptions;
use super::packet::{PacketRays, walk_packet};
use super::placement::Placement;
use super::refine::refine;
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

/// What of a face lies on a ray's way.
enum Framed {
    /// One run of the map, without walls: the ray can go in a packet.
    Window(TileFrame),
    /// Several tiles, walls, or another method than the pyramid's.
    Tiles,
    /// Nothing.
    Nothing,
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

    /// The first crossing along a ray. `spawned` rays start on this very surself.
    #[inline(always)]
    pub fn first_crossing<L: Lanes, P: Probe>(
        &self,
        ray: &MapRay,
        spawned: bool,
        probe: &mut P,
    ) -> Option<Crossing> {
        if !self.options.method.is_exact() {
            let hit = first_approximate(self, ray, spawned, probe)?;
            return Some(approximate_crossing(self, ray, hit));
        }
        let met = first_met::<L, P>(self, ray, probe)?;
        Some(self.refined(ray, met))
    }

    /// The first crossing of each of at most [`super::packet::PACKET`] rays within its own end.
    #[inline(always)]
    pub fn first_crossings<L: Lanes, P: Probe>(
        &self,
        rays: &[Ray],
        found: &mut [Option<Crossing>],
        probe: &mut P,
    ) {
        let mut packet: Option<PacketRays> = None;
        for (lane, (ray, found)) in rays.iter().zip(found.iter_mut()).enumerate() {
            *found = None;
            let Some(map_ray) = self.placement.map_ray(ray, self.options.closed) else { continue };
            let taken = match self.frame(&map_ray) {
                Framed::Nothing => continue,
                Framed::Tiles => false,
                Framed::Window(frame) => match &mut packet {
                    Some(packet) => packet.take(lane, &map_ray, &frame),
                    None => {
                        packet = Some(PacketRays::new(lane, &map_ray, &frame));
                        true
                    }
                },
            };
            if !taken {
                *found = self.first_crossing::<L, P>(&map_ray, ray.from.is_some(), probe);
            }
        }
        if let Some(packet) = &packet {
            let maps = (self.relief.heights(), self.relief.pyramid());
            let hits = walk_packet::<L, P>(maps, packet, self.admitted(), probe);
            for (lane, (hit, found)) in hits.into_iter().zip(found.iter_mut()).enumerate() {
                if let Some(hit) = hit {
                    *found = Some(self.refined(packet.ray(lane).0, Met::Surface(hit)));
                }
            }
        }
        for (ray, found) in rays.iter().zip(found) {
            if found.as_ref().is_some_and(|crossing| crossing.t > ray.t_max) {
                *found = None;
            }
        }
    }

    /// How a ray may be walked in a packet.
    #[inline(always)]
    fn frame(&self, ray: &MapRay) -> Framed {
        let Some(unfolding) = self.placement.unfolding else { return Framed::Tiles };
        if self.options.method != Method::Pyramid || self.options.closed {
            return Framed::Tiles;
        }
        let Some((enter, leave)) = ray.window_span() else { return Framed::Nothing };
        if larger(enter, ray.cull[0]) < smaller(leave, ray.cull[1]) {
            Framed::Window(TileFrame::of_window(ray, unfolding, (enter, leave)))
        } else {
            Framed::Nothing
        }
    }

    /// Whether there is a crossing up to the ray's end, for exact methods: without the refinement
    /// where that cannot matter.
    #[inline(always)]
    pub fn is_crossed<L: Lanes, P: Probe>(
        &self,
        (ray, t_max): (&MapRay, f64),
        probe: &mut P,
    ) -> bool {
        let Some(met) = first_met::<L, P>(self, ray, probe) else { return false };
        let (Met::Surface(LeafHit { s, .. }) | Met::Wall { s, .. }) = met;
        // Refinement moves a crossing into a neighbour of the neighbouring cell at most.
        let cells = 3.0 * smaller(ray.inv[0], ray.inv[1]);
        s + cells <= ray.end || self.refined(ray, met).t <= t_max
    }

    /// The crossing of what was met, in `f64`.
    #[inline(always)]
    fn refined(&self, ray: &MapRay, met: Met) -> Crossing {
        let rising = self.options.displacement.scale > 0.0;
        let heights = self.relief.heights();
        let exact = &ray.exact;
        match met {
            Met::Surface(LeafHit { s, cell, from_above }) => {
                let cell = [ray.unfolded(0, cell[0]), ray.unfolded(1, cell[1])];
                let root = refine(exact, heights, &self.placement.window, cell, f64::from(s));
                Crossing {
                    t: exact.t_start + root.s * exact.t_length,
                    lattice: [0, 1].map(|k| f64::from(root.cell[k]) + root.local[k]),
                    raw: root.raw,
                    error: root.error,
                    front: from_above == rising,
                    place: Place::Cell { cell: root.cell, local: root.local },
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
                Crossing {
                    t: exact.t_start + s * exact.t_length,
                    lattice,
                    raw: at(2),
                    error: 0.0,
                    front: from_above == rising,
                    place: Place::Wall(wall),
                }
            }
        }
    }
}

/// Walks the tiles front to back; inside each the face's method finds the first crossing.
#[inline(always)]
fn first_met<L: Lanes, P: Probe>(face: &Trace<'_>, ray: &MapRay, probe: &mut P) -> Option<Met> {
    let heights = face.relief.heights();
    let (enter, leave) = ray.window_span()?;
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
            _ => walk_tiles::<L, P>(face, ray, [start, stop], probe),
        };
        if met.is_some() {
            return met;
        }
    }
    if face.options.closed && leave < 1.0 { exit_wall(face, ray, leave) } else { None }
}

/// Walks tile after tile between two parameters.
#[inline(always)]
fn walk_tiles<L: Lanes, P: Probe>(
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
    let (x, y) = (at(0), at(1));
    let cell = [x.floor(), y.floor()];
    Crossing {
        t: exact.t_start + hit.s * exact.t_length,
        lattice: [x, y],
        raw: at(2),
        error: 0.0,
        front: hit.from_above == (face.options.displacement.scale > 0.0),
        place: Place::Cell {
            cell: [cell[0] as i32, cell[1] as i32],
            local: [x - cell[0], y - cell[1]],
        },
    }
}
