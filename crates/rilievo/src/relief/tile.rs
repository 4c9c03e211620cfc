//! [`Tile`]: the part of a face over which unfolded cells show stored cells by a shift or a flip.
//!
//! A map unfolds into runs along each axis (see `map::lattice`); a tile is a run along x times a
//! run along y, cut to the face's window. A walk goes from tile to tile along the ray and inside
//! each tile sees only stored cells, so that repeating, mirroring and clamping cost nothing per
//! cell. All lines are integers, so the tiles' intervals tile the ray as the cells' do.
//!
//! Between two tiles the surface may jump: a vertex lattice that repeats, and a face's border when
//! it is closed. There an upright wall joins the two heights. With the gaps the leaf computes at
//! the common line, the test is a comparison of two signs: the ray hits the wall if it is above the
//! one side and below the other. The same numbers decide in the leaf, so no ray slips through
//! between a wall and the surface it ends on.

use crate::map::HeightMap;

use super::leaf::{self, Crossings, LeafHit, Span};
use super::map_ray::{MapRay, larger, smaller};
use super::refine;

/// One axis of a tile: forward cells and the stored cells they show.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TileAxis {
    /// First forward cell, not before the window's first.
    pub from: i32,
    /// One past the last forward cell, not past the window's last.
    pub to: i32,
    /// Stored cell of forward cell 0.
    offset: i32,
    /// Whether stored cells go down as forward cells go up.
    pub down: bool,
}

impl TileAxis {
    #[inline(always)]
    fn new(map: &HeightMap, ray: &MapRay, axis: usize, f: i32) -> Self {
        let i = ray.unfolded(axis, f);
        let run = if axis == 0 { map.x().run(i) } else { map.y().run(i) };
        let base = ray.base[axis];
        let (from, to) = if ray.backward[axis] {
            (base - run.end(), base - run.start)
        } else {
            (run.start - base, run.end() - base)
        };
        let down = ray.backward[axis] != run.flipped;
        let shown = run.stored(i);
        Self {
            from: from.max(ray.first_cell(axis)),
            to: to.min(ray.end_cell(axis)),
            offset: if down { shown + f } else { shown - f },
            down,
        }
    }

    /// The stored cell that forward cell `f` shows.
    #[inline]
    pub fn stored(&self, f: i32) -> i32 {
        if self.down { self.offset - f } else { self.offset + f }
    }

    /// What stored cells are combined with to give mirrored cells: 0, or -1 if they go down.
    #[inline]
    pub fn mirror(&self) -> i32 {
        -i32::from(self.down)
    }

    /// Mirrored cell of forward cell 0; forward cell `f` is mirrored cell `mirrored_origin + f`.
    #[inline]
    pub fn mirrored_origin(&self) -> i32 {
        self.offset ^ self.mirror()
    }
}

/// A tile as one ray sees it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tile {
    pub axes: [TileAxis; 2],
    /// Parameters at which the ray enters and leaves, not before 0 nor after 1.
    pub enter: f32,
    pub leave: f32,
}

impl Tile {
    /// The tile that holds forward cell (fx, fy).
    #[inline(always)]
    pub fn new(map: &HeightMap, ray: &MapRay, cell: [i32; 2]) -> Self {
        let x = TileAxis::new(map, ray, 0, cell[0]);
        let y = TileAxis::new(map, ray, 1, cell[1]);
        let enter = larger(larger(ray.t_near(0, x.from), ray.t_near(1, y.from)), 0.0);
        let leave = smaller(smaller(ray.t_far(0, x.to - 1), ray.t_far(1, y.to - 1)), 1.0);
        Self { axes: [x, y], enter, leave }
    }

    /// Corner heights of a forward cell in forward order `[h00, h10, h01, h11]`.
    #[inline]
    pub fn corners(&self, map: &HeightMap, cell: [i32; 2]) -> [f32; 4] {
        let c = [0, 1].map(|axis| self.axes[axis].stored(cell[axis]) as u32);
        let [a, b, c, d] = map.stored_corners(c[0], c[1]);
        match (self.axes[0].down, self.axes[1].down) {
            (false, false) => [a, b, c, d],
            (true, false) => [b, a, d, c],
            (false, true) => [c, d, a, b],
            (true, true) => [d, c, b, a],
        }
    }

    /// Shows a forward cell of this tile, over the ray's part in it, to the leaf.
    #[inline]
    pub fn intersect(
        &self,
        map: &HeightMap,
        ray: &MapRay,
        (cell, span): ([i32; 2], &Span),
        admit: Crossings,
    ) -> Option<LeafHit> {
        let hit = span.intersect(ray, cell, &self.corners(map, cell), admit)?;
        confirms(map, ray, (span.t0, &hit), admit).then_some(hit)
    }

    /// The forward cell of this tile in which the ray is at `s`.
    pub fn cell_at(&self, ray: &MapRay, s: f32) -> [i32; 2] {
        [0, 1].map(|axis| ray.cell_at(axis, s).clamp(self.axes[axis].from, self.axes[axis].to - 1))
    }

    /// Gap above the surface where the ray enters, as the leaf of the first cell computes it.
    pub fn gap_at_enter(&self, map: &HeightMap, ray: &MapRay) -> f32 {
        let cell = self.cell_at(ray, self.enter);
        leaf::gap_entering(ray, cell, &self.corners(map, cell), self.enter)
    }

    /// Gap above the surface where the ray leaves, as the leaf of the last cell computes it.
    pub fn gap_at_leave(&self, map: &HeightMap, ray: &MapRay) -> f32 {
        let cell = [0, 1].map(|axis| {
            let TileAxis { from, to, .. } = self.axes[axis];
            ray.cell_before(axis, self.leave).clamp(from, to - 1)
        });
        leaf::gap_leaving(ray, cell, &self.corners(map, cell), self.leave)
    }

    /// Whether the ray leaves across the far line of an axis.
    #[inline]
    pub fn leaves_across(&self, ray: &MapRay, axis: usize) -> bool {
        ray.t_far(axis, self.axes[axis].to - 1) <= self.leave
    }
}

/// Whether the unrounded ray bears out what the leaf found in a span that begins at `t0`.
#[inline]
pub(crate) fn confirms(
    map: &HeightMap,
    ray: &MapRay,
    (t0, hit): (f32, &LeafHit),
    admit: Crossings,
) -> bool {
    let root = (f64::from(hit.s), hit.from_above);
    if t0 == 0.0 {
        let unfolded = [ray.unfolded(0, hit.cell[0]), ray.unfolded(1, hit.cell[1])];
        if refine::starts_beyond(&ray.exact, map, unfolded, root) {
            return false;
        }
    }
    admit == Crossings::Both || refine::crosses(&ray.exact, map, root.0, root.1)
}
