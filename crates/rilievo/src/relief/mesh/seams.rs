//! Which edges of a mesh need walls.

use std::collections::HashMap;

use crate::map::{Axis, HeightMap, Lattice, Samples, Wrap};
use crate::mesh::MeshData;

use super::prism::Prism;
use super::vertices::Vertices;
use super::wall::{Side, Wall};

/// Lattice coordinates nearer than this show the same place of the map.
const SAME: f64 = 1e-9;

/// Walls of a mesh, and counts of them.
#[derive(Default)]
pub(super) struct Seams {
    pub walls: Vec<Wall>,
    pub between: usize,
    pub borders: usize,
    pub open: usize,
}

/// A triangle and which of its edges.
#[derive(Clone, Copy)]
struct Use {
    triangle: u32,
    edge: usize,
}

impl Seams {
    /// `closed` puts walls on open borders as well.
    pub fn find(
        data: &MeshData,
        vertices: &Vertices,
        prisms: &[Prism],
        heights: &HeightMap,
        closed: bool,
    ) -> Self {
        let mut uses: HashMap<[u32; 2], Vec<Use>> = HashMap::with_capacity(2 * prisms.len());
        let mut order = Vec::new();
        for triangle in 0..data.triangles.len() as u32 {
            let places = vertices.places[triangle as usize];
            for edge in 0..3 {
                let (a, b) = (places[edge], places[(edge + 1) % 3]);
                if a != b {
                    let key = [a.min(b), a.max(b)];
                    let all = uses.entry(key).or_insert_with(|| {
                        order.push(key);
                        Vec::new()
                    });
                    all.push(Use { triangle, edge });
                }
            }
        }
        let jumps = [(heights.x(), true), (heights.y(), false)]
            .map(|(axis, along_x)| jumps(heights, axis, along_x));
        let mut seams = Self::default();
        for key in order {
            let differ = |a: &Side, b: &Side| !same(a, b, heights, jumps);
            seams.edge(&uses[&key], (vertices, prisms), closed, differ);
        }
        seams
    }

    /// Adds the walls of one edge, where sides differ.
    fn edge(
        &mut self,
        uses: &[Use],
        (vertices, prisms): (&Vertices, &[Prism]),
        closed: bool,
        differ: impl Fn(&Side, &Side) -> bool,
    ) {
        let Some((&first, others)) = uses.split_first() else { return };
        let side = |of: &Use, turned: bool| {
            let lattice = prisms[of.triangle as usize].lattice;
            let (p, q) = (lattice[of.edge], lattice[(of.edge + 1) % 3]);
            let third = lattice[(of.edge + 2) % 3];
            let inside = [0, 1].map(|k| third[k] - 0.5 * (p[k] + q[k]));
            Side { ends: if turned { [q, p] } else { [p, q] }, inside }
        };
        let place = |of: &Use| vertices.places[of.triangle as usize][of.edge];
        let corners = vertices.corners[first.triangle as usize];
        let ends = [corners[first.edge], corners[(first.edge + 1) % 3]];
        let own = side(&first, false);
        if others.is_empty() {
            self.open += 1;
            if closed {
                self.borders += 1;
                let wall = Wall { ends, triangle: first.triangle, first: own, second: None };
                self.walls.push(wall);
            }
        }
        for other in others {
            let theirs = side(other, place(other) != place(&first));
            if differ(&own, &theirs) {
                self.between += 1;
                let second = Some(theirs);
                self.walls.push(Wall { ends, triangle: first.triangle, first: own, second });
            }
        }
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
fn jumps(heights: &HeightMap, axis: &Axis, along_x: bool) -> bool {
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
