//! How the samples of a map sit on the unit interval, and how the map unfolds beyond it.
//!
//! One axis of a map with `n` samples is a [`Axis`]: it turns a parameter `u` into a *lattice
//! coordinate* `x`, in which sample `i` sits at `x = i` and cell `i` is the interval `[i, i + 1]`.
//!
//! | lattice | sample `i` sits at | `x(u)` |
//! |---|---|---|
//! | [`Lattice::Vertex`] | `u = i / (n - 1)` | `u (n - 1)` |
//! | [`Lattice::Texel`] | `u = (i + 0.5) / n` | `u n - 0.5` |
//!
//! The cells a map really has are its *stored cells*, numbered from 0. Every *unfolded* cell, any
//! `i` from minus to plus infinity, shows one stored cell, perhaps flipped; [`Axis::run`] cuts the
//! unfolded axis into maximal runs over which that relation is a shift or a flip. Everything that
//! walks a map walks run by run, so wrapping costs nothing per cell.
//!
//! | lattice, wrap | stored cells | what stored cell `c` joins |
//! |---|---|---|
//! | vertex, repeat or mirror | `n - 1` | samples `c`, `c + 1` |
//! | texel, repeat | `n` | samples `c`, `(c + 1) mod n` |
//! | texel mirror; any clamp | `n + 1` | samples `max(c - 1, 0)`, `min(c, n - 1)` |
//!
//! A vertex lattice that repeats shows every tile whole: where its last sample differs from its
//! first the surface jumps, and the walk closes the jump with a wall. All other unfoldings are
//! continuous.

/// Where the samples of a map sit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lattice {
    /// The first and the last sample sit on the border: `u = i / (n - 1)`.
    Vertex,
    /// Samples are pixel centres: `u = (i + 0.5) / n`.
    Texel,
}

/// What a map shows outside its own extent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The map again.
    Repeat,
    /// The border sample for ever.
    Clamp,
    /// The map reflected, then the map again.
    Mirror,
}

/// One axis of a map: sample count, lattice and wrap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Axis {
    samples: u32,
    lattice: Lattice,
    wrap: Wrap,
    /// Lattice coordinate at which stored cell 0 begins, 0 or -1: follows from those above, as all below.
    first: i32,
    /// Number of stored cells.
    cells: u32,
    /// One past the last unfolded cell of the map itself.
    end: i32,
}

/// A run of unfolded cells that shows stored cells in order: cell `start + k` shows
/// `first + k`, or `first - k` if the run is flipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// First unfolded cell of the run.
    pub start: i32,
    /// Number of cells, at least 1.
    pub len: i32,
    /// The stored cell shown by `start`.
    pub first: i32,
    /// Whether stored cells go down as unfolded cells go up.
    pub flipped: bool,
}

impl Run {
    /// The stored cell shown by unfolded cell `i`, which must lie in the run.
    #[inline]
    pub fn stored(&self, i: i32) -> i32 {
        if self.flipped { self.first - (i - self.start) } else { self.first + (i - self.start) }
    }

    /// One past the last unfolded cell.
    #[inline]
    pub fn end(&self) -> i32 {
        self.start + self.len
    }
}

impl Axis {
    /// An axis with `samples` samples.
    ///
    /// # Panics
    /// If `samples < 2` or `samples > 2^24`.
    pub fn new(samples: u32, lattice: Lattice, wrap: Wrap) -> Self {
        assert!((2..=1 << 24).contains(&samples), "an axis has 2 to 2^24 samples, not {samples}");
        let first = match (lattice, wrap) {
            (_, Wrap::Clamp) | (Lattice::Texel, Wrap::Mirror) => -1,
            _ => 0,
        };
        let cells = match (lattice, wrap) {
            (_, Wrap::Clamp) | (Lattice::Texel, Wrap::Mirror) => samples + 1,
            (Lattice::Texel, Wrap::Repeat) => samples,
            (Lattice::Vertex, _) => samples - 1,
        };
        // The last stored cell of mirrored texels belongs to the reflected map.
        let mirrored = (lattice, wrap) == (Lattice::Texel, Wrap::Mirror);
        let end = first + cells as i32 - i32::from(mirrored);
        Self { samples, lattice, wrap, first, cells, end }
    }

    /// Number of samples.
    #[inline]
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// The lattice.
    #[inline]
    pub fn lattice(&self) -> Lattice {
        self.lattice
    }

    /// The wrap mode.
    #[inline]
    pub fn wrap(&self) -> Wrap {
        self.wrap
    }

    /// Cells per unit of `u`; also the length of one repetition in cells.
    #[inline]
    pub fn period(&self) -> u32 {
        match self.lattice {
            Lattice::Vertex => self.samples - 1,
            Lattice::Texel => self.samples,
        }
    }

    /// Lattice coordinate of parameter `u`.
    #[inline]
    pub fn coordinate(&self, u: f64) -> f64 {
        match self.lattice {
            Lattice::Vertex => u * f64::from(self.samples - 1),
            Lattice::Texel => u * f64::from(self.samples) - 0.5,
        }
    }

    /// Parameter of lattice coordinate `x`; inverse of [`Axis::coordinate`].
    #[inline]
    pub fn parameter(&self, x: f64) -> f64 {
        match self.lattice {
            Lattice::Vertex => x / f64::from(self.samples - 1),
            Lattice::Texel => (x + 0.5) / f64::from(self.samples),
        }
    }

    /// Number of stored cells.
    #[inline]
    pub fn cells(&self) -> u32 {
        self.cells
    }

    /// Lattice coordinate at which stored cell 0 begins in the unfolded axis: 0 or -1.
    #[inline]
    pub fn first_cell(&self) -> i32 {
        self.first
    }

    /// The two samples that stored cell `c` joins, near one first.
    #[inline(always)]
    pub fn corners(&self, c: u32) -> (u32, u32) {
        debug_assert!(c < self.cells());
        if self.first_cell() < 0 {
            (c.saturating_sub(1), c.min(self.samples - 1))
        } else if c + 1 < self.samples {
            (c, c + 1)
        } else {
            (c, 0)
        }
    }

    /// The run that holds unfolded cell `i`.
    #[inline(always)]
    pub fn run(&self, i: i32) -> Run {
        // The map itself, without a division.
        if i >= self.first && i < self.end {
            let len = self.end - self.first;
            return Run { start: self.first, len, first: 0, flipped: false };
        }
        self.outer_run(i)
    }

    /// The run that holds unfolded cell `i`, in any repetition.
    #[inline(never)]
    fn outer_run(&self, i: i32) -> Run {
        let n = self.samples as i32;
        match (self.lattice, self.wrap) {
            (_, Wrap::Clamp) => {
                if i < -1 {
                    Run { start: i, len: 1, first: 0, flipped: false }
                } else if i > n - 1 {
                    Run { start: i, len: 1, first: n, flipped: false }
                } else {
                    Run { start: -1, len: n + 1, first: 0, flipped: false }
                }
            }
            (_, Wrap::Repeat) => {
                let p = self.period() as i32;
                Run { start: i.div_euclid(p) * p, len: p, first: 0, flipped: false }
            }
            (Lattice::Vertex, Wrap::Mirror) => {
                let p = n - 1;
                let k = i.div_euclid(p);
                let flipped = k.rem_euclid(2) == 1;
                Run { start: k * p, len: p, first: if flipped { p - 1 } else { 0 }, flipped }
            }
            (Lattice::Texel, Wrap::Mirror) => {
                let k = (i + 1).div_euclid(n);
                let flipped = k.rem_euclid(2) == 1;
                Run { start: k * n - 1, len: n, first: if flipped { n } else { 0 }, flipped }
            }
        }
    }

    /// The samples that unfolded cell `i` joins, the one at the smaller coordinate first.
    #[inline(always)]
    pub fn unfolded_corners(&self, i: i32) -> (u32, u32) {
        let run = self.run(i);
        let (a, b) = self.corners(run.stored(i) as u32);
        if run.flipped { (b, a) } else { (a, b) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sample an infinite map shows at integer coordinate `i`, from the definition.
    fn sample(axis: &Axis, i: i32) -> u32 {
        let n = axis.samples() as i32;
        (match (axis.lattice(), axis.wrap()) {
            (_, Wrap::Clamp) => i.clamp(0, n - 1),
            (Lattice::Texel, Wrap::Repeat) => i.rem_euclid(n),
            (Lattice::Vertex, Wrap::Repeat) => i.rem_euclid(n - 1),
            (Lattice::Texel, Wrap::Mirror) => {
                let m = i.rem_euclid(2 * n);
                m.min(2 * n - 1 - m)
            }
            (Lattice::Vertex, Wrap::Mirror) => {
                let m = i.rem_euclid(2 * (n - 1));
                m.min(2 * (n - 1) - m)
            }
        }) as u32
    }

    #[test]
    fn unfolded_cells_join_the_samples_the_definition_names() {
        for lattice in [Lattice::Vertex, Lattice::Texel] {
            for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
                for n in 2..7 {
                    let axis = Axis::new(n, lattice, wrap);
                    for i in -30..30 {
                        let (a, b) = axis.unfolded_corners(i);
                        let jump = lattice == Lattice::Vertex && wrap == Wrap::Repeat;
                        assert_eq!(a, sample(&axis, i), "{axis:?} cell {i}");
                        let want = sample(&axis, i + 1);
                        let last = axis.samples() - 1;
                        // A repeated vertex lattice ends its tile on its own last sample.
                        assert!(
                            b == want || (jump && want == 0 && b == last),
                            "{axis:?} cell {i}: {b} against {want}"
                        );
                        let run = axis.run(i);
                        assert!(run.start <= i && i < run.end());
                        assert!((0..axis.cells() as i32).contains(&run.stored(i)));
                    }
                }
            }
        }
    }

    #[test]
    fn coordinate_and_parameter_are_inverse() {
        for lattice in [Lattice::Vertex, Lattice::Texel] {
            let axis = Axis::new(9, lattice, Wrap::Repeat);
            for k in -8..24 {
                let u = f64::from(k) / 16.0;
                assert!((axis.parameter(axis.coordinate(u)) - u).abs() < 1e-15);
            }
        }
    }
}
