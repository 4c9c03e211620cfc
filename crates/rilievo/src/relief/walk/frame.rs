//! [`TileFrame`]: a tile of a face in mirrored cells, as the descent counts them.

use crate::map::Run;
use crate::simd::Mirror;

use super::super::map_ray::{MapRay, larger, smaller};
use super::super::tile::Tile;

/// A tile as one ray's descent sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileFrame {
    /// Mirrored cell of forward cell 0.
    pub origin: [i32; 2],
    /// What stored cells are combined with to give mirrored cells: 0, or -1 where they fall.
    pub turn: [i32; 2],
    /// Near and far lines of the tile inside the window, forward.
    pub lo: [f32; 2],
    pub hi: [f32; 2],
    /// Parameters at which the ray enters and leaves, not before 0 nor after 1.
    pub enter: f32,
    pub leave: f32,
}

impl TileFrame {
    /// The frame of a tile.
    #[inline(always)]
    pub fn of(ray: &MapRay, tile: &Tile) -> Self {
        let [x, y] = &tile.axes;
        Self {
            origin: [x.mirrored_origin(), y.mirrored_origin()],
            turn: [x.mirror(), y.mirror()],
            lo: [larger(x.from as f32, ray.lo[0]), larger(y.from as f32, ray.lo[1])],
            hi: [smaller(x.to as f32, ray.hi[0]), smaller(y.to as f32, ray.hi[1])],
            enter: tile.enter,
            leave: tile.leave,
        }
    }

    /// The frame of a window that lies in one run of each axis; the ray enters and leaves it at
    /// `span`.
    #[inline(always)]
    pub fn of_window(ray: &MapRay, [x, y]: [Unfolding; 2], span: (f32, f32)) -> Self {
        let x = x.mirrored(ray.base[0], ray.backward[0]);
        let y = y.mirrored(ray.base[1], ray.backward[1]);
        Self {
            origin: [x.0, y.0],
            turn: [x.1, y.1],
            lo: ray.lo,
            hi: ray.hi,
            enter: span.0,
            leave: span.1,
        }
    }

    /// Which axes stored blocks are mirrored along.
    #[inline(always)]
    pub fn mirror(&self) -> Mirror {
        Mirror::of(self.turn)
    }
}

/// How unfolded cells show the stored cells of one run, in either direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Unfolding {
    /// The stored cell that unfolded cell 0 shows, or would.
    zero: i32,
    /// -1 where stored cells fall as unfolded cells rise, else 0.
    turn: i32,
}

impl Unfolding {
    /// That of a run.
    pub fn of(run: &Run) -> Self {
        Self { zero: run.stored(0), turn: -i32::from(run.flipped) }
    }

    /// The stored cell that an unfolded cell of the run shows.
    #[inline(always)]
    pub fn stored(self, cell: i32) -> i32 {
        self.zero + (cell ^ self.turn) - self.turn
    }

    /// Whether stored cells fall as unfolded cells rise.
    #[inline(always)]
    pub fn falls(self) -> bool {
        self.turn != 0
    }

    /// Mirrored cell of the forward cell 0 of a ray counted from `base`, and the turn.
    #[inline(always)]
    pub fn mirrored(self, base: i32, backward: bool) -> (i32, i32) {
        let backward = -i32::from(backward);
        let shown = self.stored(base + backward);
        let turn = self.turn ^ backward;
        (shown ^ turn, turn)
    }
}
