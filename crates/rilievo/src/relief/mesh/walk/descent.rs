//! [`Descent`]: the walk through the pyramid under one prism.

use glam::DVec3;

use crate::map::Run;
use crate::probe::Probe;
use crate::simd::{Lanes, WIDTH};

use super::super::footprint::MARGIN;
use super::super::frame::Path;
use super::cells::Cells;
use super::forward::Forward;
use super::square::{self, Square};

/// Errors above this share of a child call for a new frame.
const LARGE: f64 = 0.4;

/// A new frame has to have less than this share of the old one's error, and be about a region
/// that is smaller by as much.
const WORTH: f64 = 0.7;

/// Spans of children are wider by this share of their parent's.
const SPARE: f64 = 1.0 / (1 << 22) as f64;

/// The number of the prism's frame; smaller ones are levels of nodes that have their own. Nodes of higher
/// levels make none: they are larger than any prism but of maps repeated thousands of times.
const OWN: usize = 4;

/// Nodes kept without memory of their own.
const NEAR: usize = 12;

/// A node or block that waits.
#[derive(Clone, Copy)]
struct Node {
    span: [f64; 2],
    /// Its place among nodes or blocks of its level, forward.
    place: [i32; 2],
    /// Lowest and highest height over the level.
    heights: [f32; 2],
    /// Level of the pyramid; -1 for a block of 4 x 4 cells.
    level: i32,
    /// The frame it was found in.
    frame: u32,
}

impl Node {
    #[inline(always)]
    fn side(&self) -> i32 {
        4 << (2 * (self.level + 1))
    }
}

/// A path, and how large a region its frame was made for: cells times heights.
#[derive(Clone, Copy)]
struct Framed {
    path: Path,
    size: f64,
}

/// Sixteen equal parts of a square, and where they come from.
struct Parts<L> {
    /// Level of a part.
    level: i32,
    /// Place of the first of them.
    first: [i32; 2],
    frame: usize,
    span: [f64; 2],
    low: L,
    high: L,
    /// Whether these heights are each part's own.
    own_heights: bool,
}

/// The walk through the pyramid under one prism.
pub(super) struct Descent<'a, P, L: Lanes> {
    pub cells: Cells<'a, P, L::Quad>,
}

/// What a walk through one tile holds.
struct Walk {
    forward: Forward,
    /// The prism's.
    own: Framed,
    /// Those of nodes, by level. Options, so that nothing is written before there is one.
    made: [Option<Framed>; OWN],
    waiting: Waiting,
}

/// Nodes that wait, the next one last.
struct Waiting {
    /// Options, so that nothing is written before there is one.
    near: [Option<Node>; NEAR],
    len: usize,
    /// Those that come after all in `near`.
    rest: Vec<Node>,
}

impl Waiting {
    #[inline(always)]
    fn push(&mut self, node: Node) {
        if self.len == NEAR {
            self.rest.extend(self.near.iter().flatten());
            self.len = 0;
        }
        self.near[self.len % NEAR] = Some(node);
        self.len += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Node> {
        match self.len.checked_sub(1) {
            Some(last) => {
                self.len = last;
                self.near[last % NEAR]
            }
            None => self.rest.pop(),
        }
    }
}

impl Walk {
    #[inline(always)]
    fn framed(&self, number: usize) -> &Framed {
        match self.made.get(number) {
            Some(Some(made)) => made,
            _ => &self.own,
        }
    }
}

impl<P: Probe, L: Lanes> Descent<'_, P, L> {
    /// Walks one tile; says whether the search is over.
    #[inline(always)]
    pub fn tile(
        &mut self,
        runs: [&Run; 2],
        cells: [[i32; 2]; 2],
        (path, span): (&Path, [f64; 2]),
    ) -> bool {
        let forward = Forward::new(runs, cells, path.speed);
        let path = forward.path(path);
        let part = forward.touched::<L::Quad>(&path, span);
        if part[0][0] >= part[0][1] || part[1][0] >= part[1][1] {
            return false;
        }
        // The smallest level of which 4 x 4 nodes, or blocks, hold the part.
        let (mut level, mut bits) = (-1, 2);
        while (0..2).any(|k| ((part[k][1] - 1) >> bits) - (part[k][0] >> bits) > 3) {
            (level, bits) = (level + 1, bits + 2);
        }
        let first = [part[0][0] >> bits, part[1][0] >> bits];
        let single = (0..2).all(|k| (part[k][1] - 1) >> bits == first[k]);
        let prism = self.cells.prism;
        let own = Framed { path, size: prism.extent() * (prism.range()[1] - prism.range()[0]) };
        let heights = prism.heights;
        let mut walk = Walk {
            forward,
            own,
            made: [const { None }; OWN],
            waiting: Waiting { near: [const { None }; NEAR], len: 0, rest: Vec::new() },
        };
        if single {
            let node = Node { span, place: first, heights, level, frame: OWN as u32 };
            self.offer(&mut walk, node);
        } else {
            let (low, high) = (L::splat(heights[0]), L::splat(heights[1]));
            self.cells.probe.node();
            let parts = Parts { level, first, frame: OWN, span, low, high, own_heights: false };
            self.parts(&mut walk, &parts);
        }
        while let Some(node) = walk.waiting.pop() {
            if self.enter(&mut walk, node) {
                return true;
            }
        }
        false
    }

    /// Tests the sixteen parts of a node; says whether the search is over.
    #[inline(always)]
    fn enter(&mut self, walk: &mut Walk, mut node: Node) -> bool {
        let limit = self.cells.limit();
        if limit < node.span[1] {
            node.span[1] = limit;
        }
        if node.span[0] > node.span[1] {
            return false;
        }
        self.cells.probe.node();
        if node.level < 0 {
            return self.block(walk, &node);
        }
        let (mut frame, level, side) = (node.frame as usize, node.level as usize, node.side());
        let framed = walk.framed(frame);
        if is_coarse(&framed.path, 0.25 * f64::from(side))
            && level < OWN
            && let Some(better) = self.better_frame(walk, &node, framed)
        {
            walk.made[level] = Some(better);
            frame = level;
        }
        let mesh = self.cells.mesh;
        let turn = walk.forward.turn;
        let [low, high] = square::child_heights::<L>(mesh, node.level as u32, node.place, turn);
        let first = node.place.map(|x| 4 * x);
        let (span, level) = (node.span, node.level - 1);
        self.parts(walk, &Parts { level, first, frame, span, low, high, own_heights: true });
        false
    }

    /// Lets a node wait that was found without its own heights, if the ray may meet those.
    #[inline(always)]
    fn offer(&mut self, walk: &mut Walk, mut node: Node) {
        let (mesh, turn) = (self.cells.mesh, walk.forward.turn);
        if node.level < 0 {
            square::fetch_block::<L>(mesh, node.place, turn);
        }
        if let Some(heights) = square::heights_of(mesh, node.level, node.place, turn) {
            if passes(&walk.framed(node.frame as usize).path, node.span, heights, mesh.height_slack)
            {
                return;
            }
            node.heights = heights;
        }
        walk.waiting.push(node);
    }

    /// A frame about a node, if it is much better than the one it was found in.
    #[inline(never)]
    fn better_frame(&self, walk: &Walk, node: &Node, old: &Framed) -> Option<Framed> {
        let Cells { mesh, prism, .. } = self.cells;
        let Walk { forward, own, .. } = walk;
        let side = node.side();
        let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
        for k in 0..2 {
            // The node, cut to the cells of the footprint.
            low[k] = f64::from((node.place[k] * side).max(forward.first[k])) - MARGIN;
            high[k] = f64::from(((node.place[k] + 1) * side).min(forward.end[k])) + MARGIN;
        }
        let slack = mesh.height_slack;
        let heights = node.heights.map(f64::from);
        (low.z, high.z) = (heights[0] - slack, heights[1] + slack);
        let extent = high - low;
        let size = extent.x.max(extent.y) * extent.z;
        if size > WORTH * old.size || prism.frame.is_blind() {
            return None;
        }
        let path = forward.bent(&prism.frame, prism.centre()).about(&own.path, low, high);
        let error = path.error.x.max(path.error.y);
        let better = error < WORTH * old.path.error.x.max(old.path.error.y);
        (better && error < f64::from(8 * side)).then_some(Framed { path, size })
    }

    /// Lets the parts of a square wait that the ray may meet.
    #[inline(always)]
    fn parts(&mut self, walk: &mut Walk, parts: &Parts<L>) {
        let Parts { level, first, frame, span, low, high, own_heights } = *parts;
        let side = 4 << (2 * (level + 1));
        let path = &walk.framed(frame).path;
        let (mut hits, mut spans) = (u16::MAX, None);
        if !path.is_blind() {
            let corner = first.map(|x| f64::from(x * side));
            let square = Square::new::<L::Quad>(path, span, corner, (4 * side, self.cells.mesh));
            let met = square.parts::<L>(low, high);
            hits = met.bits;
            spans = Some([met.near.store(), met.far.store()]);
        }
        if hits == 0 {
            return;
        }
        let (low, high) = (low.store(), high.store());
        let length = span[1] - span[0];
        let Forward { first: begin, end, .. } = walk.forward;
        while hits != 0 {
            let lane = 15 - hits.leading_zeros() as usize;
            hits &= !(1 << lane);
            let place = [first[0] + (lane as i32 & 3), first[1] + (lane as i32 >> 2)];
            if (0..2).any(|k| (place[k] * side >= end[k]) | ((place[k] + 1) * side <= begin[k])) {
                continue;
            }
            let mut part = span;
            if let Some([near, far]) = &spans {
                // A little wider than lanes can round.
                let enter = span[0] + (f64::from(near[lane]) - SPARE) * length;
                let leave = span[0] + (f64::from(far[lane]) + SPARE) * length;
                part[0] = if enter > span[0] { enter } else { span[0] };
                part[1] = if leave < span[1] { leave } else { span[1] };
            }
            let heights = [low[lane], high[lane]];
            let node = Node { span: part, place, heights, level, frame: frame as u32 };
            if !own_heights {
                self.offer(walk, node);
                continue;
            }
            if level < 0 {
                square::fetch_block::<L>(self.cells.mesh, place, walk.forward.turn);
            }
            walk.waiting.push(node);
        }
    }

    /// Shows the cells of a block that the ray may meet to the leaf; says whether the search is over.
    #[inline(always)]
    fn block(&mut self, walk: &Walk, node: &Node) -> bool {
        let (mesh, forward) = (self.cells.mesh, &walk.forward);
        let framed = walk.framed(node.frame as usize);
        let stored = square::cell_corners::<L>(mesh, node.place, forward.turn);
        let level = L::splat(mesh.offsets.level);
        let [h00, h10, h01, h11] = stored;
        let (h00, h10) = (h00.minus(level), h10.minus(level));
        let (h01, h11) = (h01.minus(level), h11.minus(level));
        let low = h00.smaller(h10).smaller(h01.smaller(h11));
        let high = h00.larger(h10).larger(h01.larger(h11));
        let mut path = framed.path;
        if is_coarse(&path, 1.0) {
            // Its own heights bound it better than its parent's.
            let heights = [low.least(), high.greatest()];
            if passes(&path, node.span, heights, mesh.height_slack) {
                return false;
            }
            if let Some(better) = self.better_frame(walk, &Node { heights, ..*node }, framed) {
                path = better.path;
            }
        }
        let (mut hits, mut near) = (u16::MAX, None);
        if !path.is_blind() {
            let corner = node.place.map(|x| f64::from(4 * x));
            let square = Square::new::<L::Quad>(&path, node.span, corner, (4, mesh));
            let met = square.cells::<L>([h00, h10, h01, h11], [low, high]);
            hits = met.bits;
            near = Some(met.near.store());
        }
        if hits == 0 {
            return false;
        }
        let length = node.span[1] - node.span[0];
        let [h00, h10, h01, h11] = stored;
        let (h00, h10, h01, h11) = (h00.store(), h10.store(), h01.store(), h11.store());
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize % WIDTH;
            hits &= hits - 1;
            let cell =
                [4 * node.place[0] + (lane as i32 & 3), 4 * node.place[1] + (lane as i32 >> 2)];
            if (0..2).any(|k| (cell[k] >= forward.end[k]) | (cell[k] < forward.first[k])) {
                continue;
            }
            let cell = forward.unfolded(cell);
            match &near {
                Some(near) => {
                    let entry = node.span[0] + (f64::from(near[lane]) - SPARE) * length;
                    if entry > self.cells.limit() {
                        continue;
                    }
                }
                None => {
                    let low = cell.map(f64::from);
                    if self.cells.prism.footprint().misses(low, low.map(|x| x + 1.0)) {
                        continue;
                    }
                }
            }
            let corners = forward.unfolded_corners([h00[lane], h10[lane], h01[lane], h11[lane]]);
            if self.cells.leaf(cell, corners) {
                return true;
            }
        }
        false
    }
}

/// Whether the error of a path is large beside a part of a node.
#[inline(always)]
fn is_coarse(path: &Path, part: f64) -> bool {
    let error = if path.error.x > path.error.y { path.error.x } else { path.error.y };
    error > LARGE * part
}

/// Whether a path is above or below all of a range of heights.
#[inline(always)]
fn passes(path: &Path, [from, to]: [f64; 2], [low, high]: [f32; 2], slack: f64) -> bool {
    if path.is_blind() {
        return false;
    }
    let (a, b) = (path.at(from).z, path.at(to).z);
    let room = path.error.z + slack;
    let (low, high) = (f64::from(low) - room, f64::from(high) + room);
    ((a < low) & (b < low)) | ((a > high) & (b > high))
}
