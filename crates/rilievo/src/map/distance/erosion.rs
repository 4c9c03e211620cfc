//! The transform of eight lines at once, without branches: parabolic erosion by taps.
//!
//! `out(q) = min_v w max(|q - v| - 1, 0)^2 + f(v)` is a minimum over moves of `m = |q - v|` places
//! that cost `w (m - 1)^2 = 0 + w + 3 w + ... + (2 m - 3) w`. So it is what a row of *stages*
//! leaves, of which stage `s` replaces every value by the least of itself and its two neighbours
//! plus `c_s`, with `c_0 = 0, c_s = (2 s - 1) w`: a path from `v` to `q` moves in `m` of the stages,
//! and the cheapest `m` are the first. \[Huang1994\] take the parabola of the Euclidean transform
//! apart in this way; the stage that costs nothing, for the kernel of boxes, is ours.
//!
//! **When to stop.** Costs never fall. If stage `s` changes nothing, no value is above a neighbour
//! by more than `c_s`, and no later stage can change anything.
//!
//! **Ends.** Places beyond the line start at infinity. A path through them comes back to a place
//! that a shorter one reaches for less, so they need no test.
//!
//! **No rounding.** The numbers are the integers of [`transform`](super::transform), below its
//! bounds; a stage adds at most `2 n w`. The result is that of the envelope, bit for bit.
//!
//! **Cost.** A stage is three operations on eight lanes; eight stages go over the line in one sweep,
//! in registers. As many stages run as the farthest column is away that matters to any place of the
//! eight lines: 5 to 40 where voxels are about cubes. Lines that are not done after [`SWEEPS`]
//! sweeps go to the [`Envelope`], which is linear whatever the reach, and so do the next [`REST`].

use super::transform::Envelope;

/// Lines that are transformed together.
pub(super) const LINES: usize = 8;

/// Stages in a sweep.
const STAGES: usize = 8;

/// Sweeps after which the envelope is the faster way.
const SWEEPS: u32 = 16;

/// How many times the envelope is taken at once after lines that were not done in [`SWEEPS`]: the
/// next lines are alike.
const REST: u32 = 15;

/// One place of eight lines.
pub(super) type Place = [f64; LINES];

/// Working memory for lines up to some length.
#[derive(Debug)]
pub(super) struct Erosion {
    /// The lines as they were given.
    given: Vec<Place>,
    line: Vec<f64>,
    envelope: Envelope,
    /// How many of the next transforms take the envelope at once.
    rest: u32,
}

impl Erosion {
    /// For lines of at most `longest` places.
    pub fn new(longest: usize) -> Self {
        Self {
            given: vec![[0.0; LINES]; longest],
            line: vec![0.0; longest],
            envelope: Envelope::new(longest),
            rest: 0,
        }
    }

    /// Replaces the eight lines by their transforms; `weight` and values as for
    /// [`Envelope::transform`].
    #[inline(always)]
    pub fn transform(&mut self, weight: f64, lines: &mut [Place]) {
        let given = &mut self.given[..lines.len()];
        given.copy_from_slice(lines);
        if self.rest == 0 {
            for number in 0..SWEEPS {
                if !sweep(lines, costs(number, weight)) {
                    return;
                }
            }
            self.rest = REST;
        } else {
            self.rest -= 1;
        }
        let line = &mut self.line[..lines.len()];
        for lane in 0..LINES {
            for (to, from) in line.iter_mut().zip(&*given) {
                *to = from[lane];
            }
            self.envelope.transform(weight, line);
            for (to, from) in lines.iter_mut().zip(&*line) {
                to[lane] = *from;
            }
        }
    }
}

/// What a move costs in each stage of sweep `number`.
#[inline(always)]
fn costs(number: u32, weight: f64) -> [f64; STAGES] {
    let first = 2.0 * STAGES as f64 * f64::from(number) - 1.0;
    std::array::from_fn(|s| weight * larger(first + 2.0 * s as f64, 0.0))
}

/// Eight stages; whether the last of them changed anything.
#[inline(always)]
fn sweep(lines: &mut [Place], costs: [f64; STAGES]) -> bool {
    let n = lines.len();
    let mut pipe = Pipe { before: [BEYOND; STAGES], here: [BEYOND; STAGES], costs };
    let mut changed = [0.0; LINES];
    for &place in lines.iter().take(STAGES) {
        pipe.push(place);
    }
    for _ in n..STAGES {
        pipe.push(BEYOND);
    }
    for j in STAGES..n {
        let (old, new) = pipe.push(lines[j]);
        lines[j - STAGES] = new;
        note(&mut changed, &old, &new);
    }
    let rest = n - n.min(STAGES);
    for place in &mut lines[rest..] {
        let (old, new) = pipe.push(BEYOND);
        *place = new;
        note(&mut changed, &old, &new);
    }
    changed.iter().any(|&by| by > 0.0)
}

/// A place beyond the ends.
const BEYOND: Place = [f64::INFINITY; LINES];

/// The stages of a sweep, each one place behind the one before it.
struct Pipe {
    /// What the stage was given two steps ago.
    before: [Place; STAGES],
    /// What it was given in the last step.
    here: [Place; STAGES],
    costs: [f64; STAGES],
}

impl Pipe {
    /// Gives the next place to the first stage; the last stage's value before and after, of the
    /// place eight before it.
    #[inline(always)]
    fn push(&mut self, place: Place) -> (Place, Place) {
        let mut next = place;
        let mut old = place;
        for s in 0..STAGES {
            old = self.here[s];
            let mut new = BEYOND;
            for k in 0..LINES {
                let aside = smaller(self.before[s][k], next[k]) + self.costs[s];
                new[k] = smaller(old[k], aside);
            }
            self.before[s] = old;
            self.here[s] = next;
            next = new;
        }
        (old, next)
    }
}

/// Notes by how much places changed.
#[inline(always)]
fn note(changed: &mut Place, old: &Place, new: &Place) {
    for k in 0..LINES {
        changed[k] = larger(changed[k], old[k] - new[k]);
    }
}

/// The smaller of two numbers, neither NaN: one instruction.
#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger of two numbers, neither NaN: one instruction.
#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Eight lines from one: each its own shift of the values.
    fn lines_of(f: &[u64], shift: u32) -> Vec<Place> {
        let n = f.len();
        let value = |j: usize, k: usize| (f[(j + 7 * k) % n] >> shift) as f64;
        (0..n).map(|j| std::array::from_fn(|k| value(j, k))).collect()
    }

    fn by_envelope(weight: f64, lines: &[Place]) -> Vec<Place> {
        let mut out = lines.to_vec();
        for k in 0..LINES {
            let mut line: Vec<f64> = lines.iter().map(|place| place[k]).collect();
            Envelope::new(line.len()).transform(weight, &mut line);
            for (place, &value) in out.iter_mut().zip(&line) {
                place[k] = value;
            }
        }
        out
    }

    proptest! {
        #[test]
        fn the_erosion_is_the_envelope_bit_for_bit(
            f in prop::collection::vec(0u64..1 << 50, 1..60),
            shift in 0u32..50,
            weight_bits in 0u32..38,
        ) {
            let weight = (1u64 << weight_bits) as f64 - 1.0;
            let mut lines = lines_of(&f, shift);
            let want = by_envelope(weight, &lines);
            Erosion::new(60).transform(weight, &mut lines);
            prop_assert_eq!(lines, want);
        }
    }

    #[test]
    fn a_reach_beyond_all_sweeps_is_left_to_the_envelope() {
        // One site at the end of a line that is longer than the stages of all sweeps.
        let n = 2 * STAGES * SWEEPS as usize;
        let mut erosion = Erosion::new(n);
        // The second one is left to it at once.
        for weight in [0.0, 3.0, 2.0] {
            let mut lines = vec![[1e14; LINES]; n];
            lines[n - 1][5] = 0.0;
            let want = by_envelope(weight, &lines);
            assert_eq!(want[0][5], weight * (n as f64 - 2.0).powi(2));
            erosion.transform(weight, &mut lines);
            assert_eq!(lines, want);
        }
    }
}
