//! [`Descent`]: the walk through the pyramid under one prism.

use glam::DVec3;

use crate::map::Run;
use crate::probe::Probe;
use crate::simd::Lanes;

use super::super::footprint::MARGIN;
use super::super::frame::Path;
use super::cells::Cells;
use super::forward::Forward;
use super::shown;
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
}

/// The walk through the pyramid under one prism.
pub(super) struct Descent<'a, P> {
    pub cells: Cells<'a, P>,
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

impl<P: Probe> Descent<'_, P> {
    /// Walks one tile; says whether the search is over.
    #[inline(always)]
    pub fn tile<L: Lanes>(
        &mut self,
        runs: [&Run; 2],
        cells: [[i32; 2]; 2],
        (path, span): (&Path, [f64; 2]),
    ) -> bool {
        let forward = Forward::new(runs, cells, path.speed);
        let path = forward.path(path);
        let cells = |k: usize| shown(&path, k, span, [forward.first[k], forward.end[k]]);
        let part = [cells(0), cells(1)];
        if part[0][0] >= part[0][1] || part[1][0] >= part[1][1] {
            return false;
        }
        // The smallest level of which 4 x 4 nodes, or blocks, hold the part.
        let (mut level, mut bits) = (-1, 2);
        while (0..2).any(|k| ((part[k][1] - 1) >> bits) - (part[k][0] >> bits) > 3) {
            (level, bits) = (level + 1, bits + 2);
        }
        let first = [part[0][0] >> bits, part[1][0] >> bits];
        if level < 0 {
            square::fetch_block::<L>(self.cells.mesh, first, forward.turn);
        }
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
            walk.waiting.push(node);
        } else {
            let (low, high) = (L::splat(heights[0]), L::splat(heights[1]));
            self.cells.probe.node();
            self.parts(&mut walk, &Parts { level, first, frame: OWN, span, low, high });
        }
        while let Some(node) = walk.waiting.pop() {
            if self.enter::<L>(&mut walk, node) {
                return true;
            }
        }
        false
    }

    /// Tests the sixteen parts of a node; says whether the search is over.
    #[inline(always)]
    fn enter<L: Lanes>(&mut self, walk: &mut Walk, mut node: Node) -> bool {
        node.span[1] = node.span[1].min(self.cells.limit());
        if node.span[0] > node.span[1] {
            return false;
        }
        self.cells.probe.node();
        if node.level < 0 {
            return self.block::<L>(walk, &node);
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
        let span = node.span;
        self.parts(walk, &Parts { level: node.level - 1, first, frame, span, low, high });
        false
    }

    /// A frame about a node, if it is much better than the one it was found in.
    #[inline(never)]
    fn better_frame(&self, walk: &Walk, node: &Node, old: &Framed) -> Option<Framed> {
        let Cells { mesh, prism, .. } = self.cells;
        let Walk { forward, own, .. } = walk;
        let (side, area) = (node.side(), prism.area());
        let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
        for k in 0..2 {
            // The node, cut to the box of the footprint.
            let first = f64::from((node.place[k] * side).max(forward.first[k]));
            let end = f64::from(((node.place[k] + 1) * side).min(forward.end[k]));
            let (sign, shift) = (f64::from(forward.sign[k]), f64::from(forward.shift[k]));
            let ends = [area.low[k], area.high[k]].map(|x| sign * x + shift);
            low[k] = first.max(ends[0].min(ends[1])) - MARGIN;
            high[k] = end.min(ends[0].max(ends[1])) + MARGIN;
            if low[k] > high[k] {
                return None;
            }
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
    fn parts<L: Lanes>(&mut self, walk: &mut Walk, parts: &Parts<L>) {
        let Parts { level, first, frame, span, low, high } = *parts;
        let part = 4 << (2 * (level + 1));
        let path = &walk.framed(frame).path;
        let (mut hits, mut spans) = (u16::MAX, None);
        if !path.is_blind() {
            let corner = first.map(|x| f64::from(x * part));
            let square = Square::new(path, span, corner, (4 * part, self.cells.mesh));
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
            if (0..2).any(|k| place[k] * part >= end[k] || (place[k] + 1) * part <= begin[k]) {
                continue;
            }
            let span = match &spans {
                // A little wider than lanes can round.
                Some([near, far]) => [
                    (span[0] + (f64::from(near[lane]) - SPARE) * length).max(span[0]),
                    (span[0] + (f64::from(far[lane]) + SPARE) * length).min(span[1]),
                ],
                None => span,
            };
            if level < 0 {
                square::fetch_block::<L>(self.cells.mesh, place, walk.forward.turn);
            }
            let heights = [low[lane], high[lane]];
            walk.waiting.push(Node { span, place, heights, level, frame: frame as u32 });
        }
    }

    /// Shows the cells of a block that the ray may meet to the leaf; says whether the search is over.
    #[inline(always)]
    fn block<L: Lanes>(&mut self, walk: &Walk, node: &Node) -> bool {
        let (mesh, forward) = (self.cells.mesh, &walk.forward);
        let framed = walk.framed(node.frame as usize);
        let corners = square::cell_corners::<L>(mesh, node.place, forward.turn);
        let [h00, h10, h01, h11] = corners;
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
            let square = Square::new(&path, node.span, corner, (4, mesh));
            let met = square.cells::<L>(corners, [low, high]);
            hits = met.bits;
            near = Some(met.near.store());
        }
        let length = node.span[1] - node.span[0];
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            let cell =
                [4 * node.place[0] + (lane as i32 & 3), 4 * node.place[1] + (lane as i32 >> 2)];
            if (0..2).any(|k| cell[k] >= forward.end[k] || cell[k] < forward.first[k]) {
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
            if self.cells.leaf(cell) {
                return true;
            }
        }
        false
    }
}

/// Whether the error of a path is large beside a part of a node.
#[inline(always)]
fn is_coarse(path: &Path, part: f64) -> bool {
    path.error.x.max(path.error.y) > LARGE * part
}

/// Whether a path is above or below all of a range of heights.
#[inline(always)]
fn passes(path: &Path, [from, to]: [f64; 2], [low, high]: [f32; 2], slack: f64) -> bool {
    if path.is_blind() {
        return false;
    }
    let (a, b) = (path.at(from).z, path.at(to).z);
    let room = path.error.z + slack;
    a.max(b) < f64::from(low) - room || a.min(b) > f64::from(high) + room
}
