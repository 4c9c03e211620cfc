//! Which edges of a mesh need walls.

use std::collections::HashMap;
use std::sync::Arc;

use crate::map::{Axis, HeightMap, Lattice, Samples, Wrap};

use super::vertices::Offsets;
use super::wall::{Side, Wall};
use super::{Displacement, Relief};

/// Lattice coordinates nearer than this show the same place of the map.
pub(super) const SAME: f64 = 1e-9;

/// Walls of a part, and counts of them.
#[derive(Default)]
pub(super) struct Seams {
    pub walls: Vec<Wall>,
    pub between: usize,
    pub borders: usize,
    pub open: usize,
    /// Whether a wall shows the map of another part.
    pub beside: bool,
}

/// What a part shows.
#[derive(Clone, Copy)]
pub(super) struct Shown<'a> {
    pub relief: &'a Arc<Relief>,
    pub offsets: &'a Offsets,
    /// Lattice coordinates of the corners of all triangles.
    pub lattice: &'a [[[f64; 2]; 3]],
}

/// A part as its edges see it.
pub(super) struct SeamSide<'a> {
    /// For each triangle, the places of its corners.
    pub places: &'a [[u32; 3]],
    /// Nothing if it is not displaced.
    pub shown: Option<Shown<'a>>,
    /// For each triangle, the vertices of its corners.
    pub corners: &'a [[u32; 3]],
    pub displacement: Displacement,
    /// Whether walls stand on open borders as well.
    pub closed: bool,
}

/// A triangle and which of its edges.
#[derive(Clone, Copy)]
struct Use {
    part: usize,
    triangle: u32,
    edge: usize,
}

impl SeamSide<'_> {
    /// What an edge shows, from its first place to its second or the other way; nothing if the part is not displaced.
    fn side(&self, of: &Use, turned: bool) -> Option<Side> {
        let lattice = self.shown?.lattice[of.triangle as usize];
        let (p, q) = (lattice[of.edge], lattice[(of.edge + 1) % 3]);
        let third = lattice[(of.edge + 2) % 3];
        let inside = [0, 1].map(|k| third[k] - 0.5 * (p[k] + q[k]));
        Some(Side { ends: if turned { [q, p] } else { [p, q] }, inside })
    }

    /// Whether another part shows the same map in the same way.
    fn shows_as(&self, other: &Self) -> bool {
        match (&self.shown, &other.shown) {
            (Some(a), Some(b)) => {
                Arc::ptr_eq(a.relief, b.relief) && self.displacement == other.displacement
            }
            _ => false,
        }
    }

    /// The offset in the middle of an edge.
    fn middle(&self, of: &Use) -> f64 {
        let (Some(shown), Some(side)) = (self.shown, self.side(of, false)) else {
            return 0.0;
        };
        let Shown { relief, offsets, .. } = shown;
        offsets.offset(side.height(relief.heights(), offsets.level, 0.5))
    }
}

impl Seams {
    /// The walls of each part. What is not here has edges of its own.
    pub fn find(parts: &[Option<SeamSide<'_>>]) -> Vec<Self> {
        let triangles: usize = parts.iter().flatten().map(|part| part.places.len()).sum();
        let mut uses: HashMap<[u32; 2], Vec<Use>> = HashMap::with_capacity(2 * triangles);
        let mut order = Vec::new();
        let here = || parts.iter().enumerate().filter_map(|(k, part)| Some((k, part.as_ref()?)));
        for (part, side) in here() {
            for (triangle, places) in (0..).zip(side.places) {
                for edge in 0..3 {
                    let (a, b) = (places[edge], places[(edge + 1) % 3]);
                    if a != b {
                        let key = [a.min(b), a.max(b)];
                        let all = uses.entry(key).or_insert_with(|| {
                            order.push(key);
                            Vec::new()
                        });
                        all.push(Use { part, triangle, edge });
                    }
                }
            }
        }
        let jumps: Vec<[bool; 2]> = (parts.iter())
            .map(|part| match part.as_ref().and_then(|part| part.shown) {
                Some(shown) => {
                    let heights = shown.relief.heights();
                    [(heights.x(), true), (heights.y(), false)]
                        .map(|(axis, along_x)| jumps(heights, axis, along_x))
                }
                None => [false; 2],
            })
            .collect();
        let mut seams: Vec<Self> = parts.iter().map(|_| Self::default()).collect();
        for key in order {
            edge(&mut seams, &uses[&key], parts, &jumps);
        }
        seams
    }

    /// A wall over an edge of a part, down to another side of it or to offset 0.
    fn raise(&mut self, own: &SeamSide<'_>, of: &Use, second: Option<Side>, part: Option<u32>) {
        let Some(first) = own.side(of, false) else { return };
        let corners = own.corners[of.triangle as usize];
        let ends = [corners[of.edge], corners[(of.edge + 1) % 3]];
        let wall = Wall { ends, triangle: of.triangle, first, second, neighbour: part };
        self.walls.push(wall);
        self.beside |= part.is_some();
    }
}

/// Adds the walls of one edge, where sides differ.
fn edge(seams: &mut [Seams], uses: &[Use], parts: &[Option<SeamSide<'_>>], jumps: &[[bool; 2]]) {
    let displaced = |of: &&Use| parts[of.part].as_ref().is_some_and(|part| part.shown.is_some());
    let Some(first) = uses.iter().find(displaced) else { return };
    let part = |of: &Use| parts[of.part].as_ref();
    let Some(own) = part(first) else { return };
    let seam = &mut seams[first.part];
    if uses.len() == 1 {
        seam.open += 1;
        if own.closed {
            seam.borders += 1;
            seam.raise(own, first, None, None);
        }
        return;
    }
    // Beside what is not displaced, down to it.
    if uses.iter().any(|of| !displaced(&of)) {
        seam.between += 1;
        seam.raise(own, first, None, None);
    }
    let place = |of: &Use| part(of).map(|side| side.places[of.triangle as usize][of.edge]);
    let others = uses.iter().filter(displaced).skip(1);
    for (other, theirs) in others.filter_map(|other| Some((other, part(other)?))) {
        let turned = place(other) != place(first);
        if own.shows_as(theirs) {
            let (Some(shown), Some(a), Some(b)) =
                (own.shown, own.side(first, false), theirs.side(other, turned))
            else {
                continue;
            };
            if !same(&a, &b, shown.relief.heights(), jumps[first.part]) {
                seams[first.part].between += 1;
                seams[first.part].raise(own, first, Some(b), None);
            }
            continue;
        }
        // The wall of the higher side.
        let (high, low) =
            if own.middle(first) >= theirs.middle(other) { (first, other) } else { (other, first) };
        let (Some(above), Some(below)) = (part(high), part(low)) else { continue };
        seams[high.part].between += 1;
        seams[high.part].raise(above, high, below.side(low, turned), Some(low.part as u32));
    }
}

/// Whether both sides show the same heights all along.
fn same(a: &Side, b: &Side, heights: &HeightMap, jumps: [bool; 2]) -> bool {
    [heights.x(), heights.y()].iter().enumerate().all(|(k, axis)| {
        let off = [0, 1].map(|end| b.ends[end][k] - a.ends[end][k]);
        let period = match axis.wrap() {
            Wrap::Repeat => f64::from(axis.period()),
            Wrap::Mirror => 2.0 * f64::from(axis.period()),
            Wrap::Clamp => f64::INFINITY,
        };
        let whole = (off[0] / period).round();
        let shift = if period.is_finite() { whole * period } else { 0.0 };
        let near = off.iter().all(|off| (off - shift).abs() <= SAME);
        // A line between tiles that do not join shows another tile to each side.
        let line = a.ends[0][k];
        let along = (a.ends[1][k] - line).abs() <= SAME;
        let tiles = f64::from(axis.period());
        let between = along && ((line / tiles).round() * tiles - line).abs() <= SAME;
        near && !(jumps[k] && (between || whole != 0.0))
    })
}

/// Whether the surface jumps between tiles along an axis.
pub(super) fn jumps(heights: &HeightMap, axis: &Axis, along_x: bool) -> bool {
    if (axis.lattice(), axis.wrap()) != (Lattice::Vertex, Wrap::Repeat) {
        return false;
    }
    let (width, height) = (heights.width() as usize, heights.height() as usize);
    let differ = |first: usize, last: usize| match heights.samples() {
        Samples::U16(v) => v[first] != v[last],
        Samples::F32(v) => v[first] != v[last],
    };
    if along_x {
        (0..height).any(|j| differ(j * width, (j + 1) * width - 1))
    } else {
        (0..width).any(|i| differ(i, (height - 1) * width + i))
    }
}
