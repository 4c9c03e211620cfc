//! Equal heights at seams, baked into the map: what `edges = "matched"` asks for.
//!
//! Where two charts of an atlas meet, each shows its own texels, and a wall closes what lies between
//! (`wall`). Here the map is changed so that there is little left to close. Nothing else changes: the
//! baked map is an ordinary map, traced as any other, walls included.
//!
//! **System.** Along every seam edge both sides are sampled at common places, twice as dense as the finer
//! lattice. The heights there are bilinear, so that they agree is one linear equation in the changes of
//! at most eight texels. We ask for the *least change*, in the sense of squares, of all that bring
//! the sides as close as they can be: damped a little, by conjugate gradients on the normal equations
//! \[Paige1982\], which begin at no change. Sides then meet near the mean of what they showed. Lattices that cross an edge at
//! different angles or densities cannot agree everywhere; what is left is the walls'.
//!
//! **Softening.** Texels beyond those of the equations follow: ring by ring they take the mean change of
//! their neighbours of the rings before, less and less, up to a distance of so many texels.
//!
//! **Bounds.** Heights stay within the range of the map, so that the shell grows nowhere; codes are rounded.
//! Every texel has one change, whatever charts show it: where charts share texels, all follow.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::ReliefMesh;
use super::wall::{Side, Wall};
use crate::map::{HeightMap, RowMut};

/// How much a change counts beside a step of the same size at one sample.
const DAMPING: f64 = 0.02;

/// Steps of the solver at most.
const STEPS: usize = 200;

/// The solver stops when the gradient has fallen to this share.
const CONVERGED: f64 = 1e-10;

/// Samples of all seams at most; more are spread out.
const MOST_SAMPLES: f64 = (1 << 22) as f64;

/// How far sides of seams are apart, in heights (1 is the full range of codes).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeamSteps {
    /// The mean over all samples.
    pub mean: f64,
    /// The largest.
    pub largest: f64,
}

/// Where the two sides of a seam show their heights, and how much each texel counts: the sides agree
/// where the sum is 0.
struct Equation {
    unknowns: [u32; 8],
    weights: [f64; 8],
}

impl ReliefMesh {
    /// The map of the mesh, changed as little as brings the two sides of its seams together, and softly up
    /// to `within` texels from them. Make a relief of it and lay it on the same mesh.
    pub fn matched_heights(&self, within: u32) -> HeightMap {
        let mut heights = self.relief.heights().clone();
        let mut system = System::default();
        self.each_sample(|[a, b]| system.add(&heights, [a, b]));
        let mut changes = system.solve(&heights);
        soften(&mut changes, &heights, within);
        let (low, high) = heights.raw_range();
        let width = heights.width();
        let all = [0..width, 0..heights.height()];
        let changed = heights.edit(all, |j, row| {
            let first = u64::from(j) * u64::from(width);
            let row_changes = changes.range(first..first + u64::from(width));
            let at = row_changes.map(|(texel, change)| ((texel - first) as usize, *change));
            match row {
                RowMut::U16(row) => at.for_each(|(i, change)| {
                    let raw = (f64::from(row[i]) + change).clamp(f64::from(low), f64::from(high));
                    row[i] = raw.round() as u16;
                }),
                RowMut::F32(row) => at.for_each(|(i, change)| {
                    let raw = (f64::from(row[i]) + change).clamp(f64::from(low), f64::from(high));
                    row[i] = raw as f32;
                }),
            }
        });
        debug_assert!(changed.is_ok(), "clamped heights are heights");
        heights
    }

    /// How far the two sides of the mesh's seams are apart.
    pub fn seam_steps(&self) -> SeamSteps {
        let heights = self.relief.heights();
        let (mut steps, mut count) = (SeamSteps::default(), 0u64);
        self.each_sample(|sides| {
            let [a, b] = sides.map(|side| side.height(heights));
            let step = (a - b).abs() * heights.unit();
            steps.mean += step;
            steps.largest = steps.largest.max(step);
            count += 1;
        });
        if count > 0 {
            steps.mean /= count as f64;
        }
        steps
    }

    /// Calls `see` for all samples along seams, in order.
    fn each_sample(&self, mut see: impl FnMut([Bilinear; 2])) {
        let own = || self.walls.iter().filter(|wall| wall.neighbour.is_none());
        let seams = || own().filter_map(|wall| Some((wall, wall.second.as_ref()?)));
        let wanted = |(wall, second): (&Wall, &Side)| {
            let cells = wall.first.cells().max(second.cells());
            (2.0 * cells).ceil().max(1.0)
        };
        let total: f64 = seams().map(wanted).sum();
        let spread = (total / MOST_SAMPLES).max(1.0);
        for (wall, second) in seams() {
            let count = (wanted((wall, second)) / spread).ceil() as u32;
            for k in 0..=count {
                let s = f64::from(k) / f64::from(count);
                see([&wall.first, second].map(|side| Bilinear::new(self, side, s)));
            }
        }
    }
}

impl Side {
    /// Cells that it crosses, about.
    fn cells(&self) -> f64 {
        let [a, b] = self.ends;
        (b[0] - a[0]).abs().max((b[1] - a[1]).abs())
    }
}

/// A height between four texels.
struct Bilinear {
    texels: [[u32; 2]; 4],
    weights: [f64; 4],
}

impl Bilinear {
    fn new(mesh: &ReliefMesh, side: &Side, s: f64) -> Self {
        let heights = mesh.relief.heights();
        let (cell, [x, y]) = side.place(s);
        let (i0, i1) = heights.x().unfolded_corners(cell[0]);
        let (j0, j1) = heights.y().unfolded_corners(cell[1]);
        Self {
            texels: [[i0, j0], [i1, j0], [i0, j1], [i1, j1]],
            weights: [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y],
        }
    }

    /// Raw.
    fn height(&self, heights: &HeightMap) -> f64 {
        let all = self.texels.iter().zip(self.weights);
        all.map(|(&[i, j], weight)| weight * f64::from(heights.raw(i, j))).sum()
    }
}

/// All equations, and the texels in them.
#[derive(Default)]
struct System {
    equations: Vec<Equation>,
    /// What is wanted of each sum: what the step changes by.
    wanted: Vec<f64>,
    unknown_of: HashMap<u64, u32>,
    texels: Vec<u64>,
}

impl System {
    fn add(&mut self, heights: &HeightMap, [a, b]: [Bilinear; 2]) {
        self.wanted.push(b.height(heights) - a.height(heights));
        let width = u64::from(heights.width());
        let mut equation = Equation { unknowns: [0; 8], weights: [0.0; 8] };
        for (side, sign, first) in [(&a, 1.0, 0), (&b, -1.0, 4)] {
            for k in 0..4 {
                let [i, j] = side.texels[k];
                let texel = u64::from(j) * width + u64::from(i);
                let unknown = *self.unknown_of.entry(texel).or_insert_with(|| {
                    self.texels.push(texel);
                    self.texels.len() as u32 - 1
                });
                equation.unknowns[first + k] = unknown;
                equation.weights[first + k] = sign * side.weights[k];
            }
        }
        self.equations.push(equation);
    }

    /// The sums for changes of the texels.
    fn sums(&self, changes: &[f64]) -> Vec<f64> {
        let sum = |equation: &Equation| {
            let terms = equation.unknowns.iter().zip(equation.weights);
            terms.map(|(&unknown, weight)| weight * changes[unknown as usize]).sum()
        };
        self.equations.iter().map(sum).collect()
    }

    /// The transpose: what each texel has in all equations.
    fn shares(&self, of: &[f64]) -> Vec<f64> {
        let mut shares = vec![0.0; self.texels.len()];
        for (equation, value) in self.equations.iter().zip(of) {
            for (&unknown, weight) in equation.unknowns.iter().zip(equation.weights) {
                shares[unknown as usize] += weight * value;
            }
        }
        shares
    }

    /// The changes of texels, row-major places, in order.
    fn solve(&self, heights: &HeightMap) -> BTreeMap<u64, f64> {
        let damping = DAMPING * DAMPING;
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut changes = vec![0.0; self.texels.len()];
        let mut left = self.wanted.clone();
        let mut gradient = self.shares(&left);
        let mut direction = gradient.clone();
        let begun = dot(&gradient, &gradient);
        let mut size = begun;
        for _ in 0..STEPS {
            if size <= CONVERGED * CONVERGED * begun {
                break;
            }
            let sums = self.sums(&direction);
            let step = size / (dot(&sums, &sums) + damping * dot(&direction, &direction));
            for (change, along) in changes.iter_mut().zip(&direction) {
                *change += step * along;
            }
            for (left, sum) in left.iter_mut().zip(&sums) {
                *left -= step * sum;
            }
            gradient = self.shares(&left);
            for (slope, change) in gradient.iter_mut().zip(&changes) {
                *slope -= damping * change;
            }
            let next = dot(&gradient, &gradient);
            for (along, slope) in direction.iter_mut().zip(&gradient) {
                *along = slope + next / size * *along;
            }
            size = next;
        }
        let range = heights.raw_range();
        let range = f64::from(range.1) - f64::from(range.0);
        let kept = changes.into_iter().map(|change| change.clamp(-range, range));
        self.texels.iter().copied().zip(kept).collect()
    }
}

/// Lets the texels around follow, ring by ring, up to `within` texels away.
fn soften(changes: &mut BTreeMap<u64, f64>, heights: &HeightMap, within: u32) {
    let (width, height) = (u64::from(heights.width()), u64::from(heights.height()));
    // Undamped changes, from which the next ring's are made.
    let mut full = changes.clone();
    let mut border: Vec<u64> = changes.keys().copied().collect();
    for ring in 1..=within {
        let next: BTreeSet<u64> = (border.iter())
            .flat_map(|&texel| around(texel, [width, height]))
            .filter(|texel| !full.contains_key(texel))
            .collect();
        let means: Vec<(u64, f64)> = (next.iter())
            .map(|&texel| {
                let known: Vec<f64> = around(texel, [width, height])
                    .filter_map(|near| full.get(&near).copied())
                    .collect();
                (texel, known.iter().sum::<f64>() / known.len() as f64)
            })
            .collect();
        let share = 1.0 - f64::from(ring) / f64::from(within + 1);
        for (texel, mean) in means {
            full.insert(texel, mean);
            changes.insert(texel, share * mean);
        }
        border = next.into_iter().collect();
    }
}

/// The up to eight texels around one; maps end at their borders here.
fn around(texel: u64, [width, height]: [u64; 2]) -> impl Iterator<Item = u64> {
    let (i, j) = (texel % width, texel / width);
    let rows = j.saturating_sub(1)..(j + 2).min(height);
    rows.flat_map(move |y| {
        let columns = i.saturating_sub(1)..(i + 2).min(width);
        columns.map(move |x| y * width + x)
    })
    .filter(move |&near| near != texel)
}
