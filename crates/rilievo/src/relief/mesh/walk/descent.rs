//! [`Descent`]: the walk through the pyramid under one prism.

use glam::DVec3;

use crate::map::Run;
use crate::probe::Probe;
use crate::simd::Lanes;

use super::super::footprint::{Area, MARGIN};
use super::super::frame::Path;
use super::cells::Cells;
use super::forward::Forward;
use super::shown;
use super::square::{self, Square};

/// Errors above this share of a child call for a new frame.
const LARGE: f64 = 0.4;

/// A new frame has to have less than this share of the old one's error.
const WORTH: f64 = 0.7;

/// Parts of a footprint of at most this many cells begin with blocks.
const FEW_CELLS: i32 = 8;

/// A node or block that waits.
#[derive(Clone, Copy)]
struct Node {
    /// Level of the pyramid; -1 for a block of 4 x 4 cells.
    level: i32,
    /// Its place among nodes or blocks, forward.
    place: [i32; 2],
    span: [f64; 2],
    /// Depth from 1: the frame it may make is kept there, until a node beside it makes its own.
    depth: usize,
    /// The frame it was found in.
    frame: usize,
    /// Lowest and highest height over the level.
    heights: [f64; 2],
    /// Whether the span has to be cut by its own box.
    loose: bool,
}

impl Node {
    #[inline(always)]
    fn side(&self) -> i32 {
        4 << (2 * (self.level + 1))
    }
}

/// What a path knows about its frame.
#[derive(Clone, Copy)]
struct Framed {
    path: Path,
    blind: bool,
    /// Size of the region the frame was made for: cells times heights.
    size: f64,
}

/// The walk through the pyramid under one prism.
pub(super) struct Descent<'a, P> {
    pub cells: Cells<'a, P>,
    pub area: Area,
    pub scratch: &'a mut Scratch,
}

/// Memory of a walk, kept from prism to prism.
#[derive(Default)]
pub(in super::super) struct Scratch {
    /// By depth: 0 is the prism's own.
    frames: Vec<Framed>,
    waiting: Vec<Node>,
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
        let blind = self.cells.prism.frame.is_blind();
        let forward = Forward::new(runs, cells, if blind { DVec3::ONE } else { path.speed });
        let path = forward.path(path);
        let cells = |k: usize| shown(&path, k, span, [forward.first[k], forward.end[k]], blind);
        let part = [cells(0), cells(1)];
        let size = (part[0][1] - part[0][0]).max(part[1][1] - part[1][0]);
        if part[0][0] >= part[0][1] || part[1][0] >= part[1][1] {
            return false;
        }
        let mut level = -1;
        if size > FEW_CELLS {
            level = 0;
            while size > 16 << (2 * level) {
                level += 1;
            }
        }
        let bits = 2 * (level + 1) + 2;
        let prism = self.cells.prism;
        let extent = self.area.extent();
        let framed = Framed { path, blind, size: extent * (prism.range[1] - prism.range[0]) };
        self.scratch.frames.clear();
        self.scratch.frames.push(framed);
        for y in ((part[1][0] >> bits)..=((part[1][1] - 1) >> bits)).rev() {
            for x in ((part[0][0] >> bits)..=((part[0][1] - 1) >> bits)).rev() {
                let node = Node {
                    level,
                    place: [x, y],
                    span,
                    depth: 1,
                    frame: 0,
                    heights: prism.range,
                    loose: true,
                };
                self.scratch.waiting.push(node);
            }
        }
        while let Some(node) = self.scratch.waiting.pop() {
            if self.enter::<L>(&forward, node) {
                self.scratch.waiting.clear();
                return true;
            }
        }
        false
    }

    /// Tests the sixteen parts of a node; says whether the search is over.
    #[inline(always)]
    fn enter<L: Lanes>(&mut self, forward: &Forward, mut node: Node) -> bool {
        node.span[1] = node.span[1].min(self.cells.limit());
        if node.span[0] > node.span[1] {
            return false;
        }
        let side = node.side();
        let mut framed = self.scratch.frames[node.frame];
        let error = framed.path.error.x.max(framed.path.error.y);
        let coarse = framed.blind || error > LARGE * 0.25 * f64::from(side);
        if coarse && let Some(better) = self.better_frame(forward, &node, &framed) {
            self.scratch.frames.truncate(node.depth + 1);
            while self.scratch.frames.len() <= node.depth {
                self.scratch.frames.push(better);
            }
            self.scratch.frames[node.depth] = better;
            node.frame = node.depth;
            node.loose = true;
            framed = better;
        }

        self.cells.probe.node();
        if !framed.blind && node.loose {
            let path = &framed.path;
            for k in 0..2 {
                let low = f64::from(node.place[k] * side);
                let ends = [low - MARGIN, low + f64::from(side) + MARGIN];
                node.span = path.within(node.span, k, ends);
            }
            let slack = self.cells.mesh.height_slack;
            let [low, high] = node.heights;
            node.span = path.within(node.span, 2, [low - slack, high + slack]);
            if node.span[0] > node.span[1] {
                return false;
            }
        }
        if node.level < 0 {
            self.block::<L>(forward, &node, &framed)
        } else {
            self.children::<L>(forward, &node, &framed);
            false
        }
    }

    /// A frame about a node, if it is much better than the one it was found in.
    #[inline(never)]
    fn better_frame(&self, forward: &Forward, node: &Node, old: &Framed) -> Option<Framed> {
        let Cells { mesh, prism, ray, .. } = self.cells;
        let side = node.side();
        let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
        for k in 0..2 {
            // The node, cut to the box of the footprint.
            let first = f64::from((node.place[k] * side).max(forward.first[k]));
            let end = f64::from(((node.place[k] + 1) * side).min(forward.end[k]));
            let (sign, shift) = (f64::from(forward.sign[k]), f64::from(forward.shift[k]));
            let ends = [self.area.low[k], self.area.high[k]].map(|x| sign * x + shift);
            low[k] = first.max(ends[0].min(ends[1])) - MARGIN;
            high[k] = end.min(ends[0].max(ends[1])) + MARGIN;
            if low[k] > high[k] {
                return None;
            }
        }
        let slack = mesh.height_slack;
        (low.z, high.z) = (node.heights[0] - slack, node.heights[1] + slack);
        let extent = high - low;
        let size = extent.x.max(extent.y) * extent.z;
        if size > WORTH * old.size {
            return None;
        }
        let frame =
            forward.reframed(&prism.sheet(&mesh.vertices), [low, high], prism.rounding(mesh.reach));
        if frame.is_blind() {
            return None;
        }
        let path = forward.path(&frame.path(ray.origin, ray.direction));
        let error = path.error.x.max(path.error.y);
        let limit = f64::from(8 * side);
        let better = old.blind || error < WORTH * old.path.error.x.max(old.path.error.y);
        (better && error < limit).then_some(Framed { path, blind: false, size })
    }

    /// Puts the children of a node that the ray may meet on the stack.
    #[inline(always)]
    fn children<L: Lanes>(&mut self, forward: &Forward, node: &Node, framed: &Framed) {
        let (mesh, side) = (self.cells.mesh, node.side());
        let part = side / 4;
        let heights = square::child_heights::<L>(mesh, node.level as u32, node.place, forward.turn);
        let [low, high] = heights;
        let (mut hits, mut spans) = (u16::MAX, None);
        if !framed.blind {
            let [x, y] = node.place;
            let corner = [f64::from(x * side), f64::from(y * side)];
            let square = Square::new(&framed.path, node.span, corner, (side, mesh));
            let met = square.parts::<L>(low, high);
            hits = met.bits;
            spans = Some([met.near.store(), met.far.store()]);
        }
        if hits == 0 {
            return;
        }
        let (low, high) = (low.store(), high.store());
        let length = node.span[1] - node.span[0];
        while hits != 0 {
            let lane = 15 - hits.leading_zeros() as usize;
            hits &= !(1 << lane);
            let place =
                [4 * node.place[0] + (lane as i32 & 3), 4 * node.place[1] + (lane as i32 >> 2)];
            if (0..2).any(|k| {
                place[k] * part >= forward.end[k] || (place[k] + 1) * part <= forward.first[k]
            }) {
                continue;
            }
            let span = match &spans {
                // A little wider than lanes can round.
                Some([near, far]) => [
                    (node.span[0] + (f64::from(near[lane]) - SPARE) * length).max(node.span[0]),
                    (node.span[0] + (f64::from(far[lane]) + SPARE) * length).min(node.span[1]),
                ],
                None => node.span,
            };
            self.scratch.waiting.push(Node {
                level: node.level - 1,
                place,
                span,
                depth: node.depth + 1,
                frame: node.frame,
                heights: [f64::from(low[lane]), f64::from(high[lane])],
                loose: false,
            });
        }
    }

    /// Shows the cells of a block that the ray may meet to the leaf; says whether the search is over.
    #[inline(always)]
    fn block<L: Lanes>(&mut self, forward: &Forward, node: &Node, framed: &Framed) -> bool {
        let mesh = self.cells.mesh;
        let mut hits = u16::MAX;
        if !framed.blind {
            let [x, y] = node.place;
            let corner = [f64::from(4 * x), f64::from(4 * y)];
            let square = Square::new(&framed.path, node.span, corner, (4, mesh));
            let corners = square::cell_corners::<L>(mesh, node.place, forward.turn);
            hits = square.cells::<L>(corners);
        }
        while hits != 0 {
            let lane = hits.trailing_zeros() as i32;
            hits &= hits - 1;
            let cell = [4 * node.place[0] + (lane & 3), 4 * node.place[1] + (lane >> 2)];
            if (0..2).any(|k| cell[k] >= forward.end[k] || cell[k] < forward.first[k]) {
                continue;
            }
            let cell = forward.unfolded(cell);
            if framed.blind {
                let low = cell.map(f64::from);
                if self.cells.prism.footprint().misses(low, low.map(|x| x + 1.0)) {
                    continue;
                }
            }
            if self.cells.leaf(cell) {
                return true;
            }
        }
        false
    }
}

/// Spans of children are wider by this share of their parent's.
const SPARE: f64 = 1.0 / (1 << 22) as f64;
