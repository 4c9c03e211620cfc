//! [`Level`]: the stored bounds of one level, in either layout.
//!
//! **Tiny.** A node keeps the lowest and the highest code of its lanes, `range = [lo, hi]`, and 16
//! maxima and minima `q` of 8 bits that stand for the code `lo + q step` with
//! `step = max(1, ceil((hi - lo) / 255))`; `q` is rounded up for maxima and down for minima, the
//! tightest there is. `hi <= lo + 255 step`, so 8 bits suffice; a code may lie above 65535, and all
//! of this is exact in `f32`. Since `lo` and `hi` themselves are kept, the level above is made from
//! exact codes, not from rounded ones, and can be made again from stored nodes after an edit.
//!
//! **Rounding.** For whole numbers, `floor(a / step)` is the whole number nearest to
//! `(a - (step - 1) / 2) / step`, and `ceil` that of the same with a plus. Neither comes nearer to
//! the middle between two whole numbers than `1 / (2 step) >= 1/514`; computed in `f32` from the
//! rounded `1 / step` both are below 257 and off by less than `257 * 2^-23`. So the nearest is right.

use std::ops::Range;

use super::code::whole;
use super::layout::Layout;

/// Children a node has, and blocks along one side of a node.
pub(crate) const LANES: usize = 16;

/// Sixteen `u16` bounds of one node, lane `4 y + x`.
pub(super) type Wide = [u16; LANES];

/// One level of a [`Pyramid`](super::Pyramid).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Level {
    /// Nodes along x and y.
    pub nodes: [u32; 2],
    /// Their bounds.
    pub bounds: LevelBounds,
}

/// The bounds of a level: nodes row-major, sixteen lanes each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LevelBounds {
    /// [`Layout::Default`].
    Wide {
        /// Upper bounds.
        max: Vec<[u16; LANES]>,
        /// Lower bounds.
        min: Vec<[u16; LANES]>,
    },
    /// [`Layout::Tiny`].
    Tiny {
        /// Upper bounds, in steps above the low end of the node's range.
        max: Vec<[u8; LANES]>,
        /// Lower bounds, likewise.
        min: Vec<[u8; LANES]>,
        /// Lowest and highest code of each node.
        range: Vec<[u16; 2]>,
    },
}

/// The bounds of one node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NodeBounds<'a> {
    /// Codes.
    Wide {
        /// Upper bounds.
        max: &'a [u16; LANES],
        /// Lower bounds.
        min: &'a [u16; LANES],
    },
    /// Stands for the codes `base + q * step`, exact in `f32` and perhaps above 65535.
    Tiny {
        /// Upper bounds.
        max: &'a [u8; LANES],
        /// Lower bounds.
        min: &'a [u8; LANES],
        /// Code of `q = 0`.
        base: f32,
        /// Codes for one `q`, at least 1.
        step: f32,
    },
}

impl NodeBounds<'_> {
    /// Upper and lower bounds as codes.
    #[inline]
    pub fn codes(&self) -> [[f32; LANES]; 2] {
        match *self {
            Self::Wide { max, min } => [max.map(f32::from), min.map(f32::from)],
            Self::Tiny { max, min, base, step } => {
                let code = |q: u8| base + f32::from(q) * step;
                [max.map(code), min.map(code)]
            }
        }
    }
}

/// The upper or the lower bounds of one node.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SideBounds<'a> {
    /// Codes.
    Wide(&'a [u16; LANES]),
    /// Stands for the codes `base + q * step`.
    Tiny { steps: &'a [u8; LANES], base: f32, step: f32 },
}

/// Codes for one step of a tiny node.
#[inline]
fn tiny_step([lo, hi]: [u16; 2]) -> u32 {
    (u32::from(hi - lo.min(hi)).div_ceil(255)).max(1)
}

/// The range of the lanes of a node; empty lanes do not count.
#[inline]
fn range(max: &Wide, min: &Wide) -> [u16; 2] {
    [min.iter().fold(u16::MAX, |a, &b| a.min(b)), max.iter().fold(0, |a, &b| a.max(b))]
}

/// The tiny form of a node. Lanes beyond the map become maximum 0 and minimum 255.
#[inline]
fn tiny(max: &Wide, min: &Wide, range: [u16; 2]) -> [[u8; LANES]; 2] {
    let step = tiny_step(range) as f32;
    let (half, inverse) = ((step - 1.0) / 2.0, 1.0 / step);
    let (above, below) = (f32::from(range[0]) - half, f32::from(range[0]) + half);
    let mut out = [[0; LANES], [255; LANES]];
    for lane in 0..LANES {
        let up = whole((f32::from(max[lane]) - above) * inverse);
        let down = whole((f32::from(min[lane]) - below) * inverse);
        let occupied = min[lane] <= max[lane];
        out[0][lane] = if occupied { up as u8 } else { 0 };
        out[1][lane] = if occupied { down as u8 } else { 255 };
    }
    out
}

impl LevelBounds {
    /// A level with no node written yet.
    pub(super) fn new(layout: Layout, nodes: usize) -> Self {
        match layout {
            Layout::Default => {
                Self::Wide { max: vec![[0; LANES]; nodes], min: vec![[0; LANES]; nodes] }
            }
            Layout::Tiny => Self::Tiny {
                max: vec![[0; LANES]; nodes],
                min: vec![[0; LANES]; nodes],
                range: vec![[0; 2]; nodes],
            },
        }
    }

    /// How the bounds are stored.
    pub fn layout(&self) -> Layout {
        match self {
            Self::Wide { .. } => Layout::Default,
            Self::Tiny { .. } => Layout::Tiny,
        }
    }

    /// Whether this holds as many nodes as that, in the same layout.
    pub(super) fn fits(&self, nodes: usize, layout: Layout) -> bool {
        let lengths = match self {
            Self::Wide { max, min } => [max.len(), min.len(), min.len()],
            Self::Tiny { max, min, range } => [max.len(), min.len(), range.len()],
        };
        self.layout() == layout && lengths == [nodes; 3]
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        let nodes = match self {
            Self::Wide { max, .. } => max.len(),
            Self::Tiny { max, .. } => max.len(),
        };
        nodes as u64 * self.layout().node_bytes()
    }

    /// The bounds of a node.
    #[inline(always)]
    pub(crate) fn node(&self, index: usize) -> NodeBounds<'_> {
        match self {
            Self::Wide { max, min } => NodeBounds::Wide { max: &max[index], min: &min[index] },
            Self::Tiny { max, min, range } => NodeBounds::Tiny {
                max: &max[index],
                min: &min[index],
                base: f32::from(range[index][0]),
                step: tiny_step(range[index]) as f32,
            },
        }
    }

    /// The upper or the lower bounds of a node.
    #[inline(always)]
    pub(crate) fn side(&self, index: usize, upper: bool) -> SideBounds<'_> {
        match self {
            Self::Wide { max, min } => {
                SideBounds::Wide(if upper { &max[index] } else { &min[index] })
            }
            Self::Tiny { max, min, range } => SideBounds::Tiny {
                steps: if upper { &max[index] } else { &min[index] },
                base: f32::from(range[index][0]),
                step: tiny_step(range[index]) as f32,
            },
        }
    }

    /// Lowest and highest code of a node, exact in both layouts.
    #[inline]
    pub(super) fn range(&self, index: usize) -> [u16; 2] {
        match self {
            Self::Wide { max, min } => range(&max[index], &min[index]),
            Self::Tiny { range, .. } => range[index],
        }
    }
}

impl LevelBounds {
    /// A run of nodes to write to.
    pub(super) fn run_mut(&mut self, run: Range<usize>) -> NodesMut<'_> {
        match self {
            Self::Wide { max, min } => {
                NodesMut::Wide { max: &mut max[run.clone()], min: &mut min[run] }
            }
            Self::Tiny { max, min, range } => NodesMut::Tiny {
                max: &mut max[run.clone()],
                min: &mut min[run.clone()],
                range: &mut range[run],
            },
        }
    }
}

/// A run of nodes to write to.
pub(super) enum NodesMut<'a> {
    /// [`Layout::Default`].
    Wide {
        /// Upper bounds.
        max: &'a mut [Wide],
        /// Lower bounds.
        min: &'a mut [Wide],
    },
    /// [`Layout::Tiny`].
    Tiny {
        /// Upper bounds.
        max: &'a mut [[u8; LANES]],
        /// Lower bounds.
        min: &'a mut [[u8; LANES]],
        /// Lowest and highest code of each node.
        range: &'a mut [[u16; 2]],
    },
}

impl NodesMut<'_> {
    /// Writes the nodes: `fill` sets all lanes of maxima and minima that it is given.
    pub fn fill(self, fill: impl FnOnce(&mut [Wide], &mut [Wide])) {
        match self {
            Self::Wide { max, min } => fill(max, min),
            Self::Tiny { max, min, range: ranges } => {
                let mut wide_max = vec![[0; LANES]; max.len()];
                let mut wide_min = vec![[0; LANES]; max.len()];
                fill(&mut wide_max, &mut wide_min);
                let wide = wide_max.iter().zip(&wide_min);
                for (((max, min), ranges), wide) in max.iter_mut().zip(min).zip(ranges).zip(wide) {
                    *ranges = range(wide.0, wide.1);
                    [*max, *min] = tiny(wide.0, wide.1, *ranges);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every q of every range, by whole numbers.
    #[test]
    fn tiny_codes_are_the_tightest_that_enclose() {
        for range in
            [[0, 0], [0, 65535], [65535, 65535], [17, 271], [17, 272], [17, 273], [9, 60000]]
        {
            let [lo, hi] = range.map(u32::from);
            let step = tiny_step(range);
            for code in (lo..=hi).step_by(1 + (hi - lo) as usize / 3000) {
                let node = [code as u16; LANES];
                let [max, min] = tiny(&node, &node, range).map(|q| lo + u32::from(q[3]) * step);
                assert!(min <= code && code < min + step, "{range:?} {code}: {min}");
                assert!(max >= code && max < code + step, "{range:?} {code}: {max}");
            }
        }
    }

    #[test]
    fn lanes_beyond_the_map_stay_empty() {
        let (mut max, mut min) = ([0; LANES], [u16::MAX; LANES]);
        (max[0], min[0]) = (65535, 65535);
        let [q_max, q_min] = tiny(&max, &min, range(&max, &min));
        assert_eq!((q_max[0], q_min[0], q_max[1], q_min[1]), (0, 0, 0, 255));
    }
}
