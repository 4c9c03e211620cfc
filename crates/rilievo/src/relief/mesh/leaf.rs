//! The leaf: where a ray first meets a patch, by Krawczyk's operator in `f64`.
//!
//! **Method** \[Krawczyk1969, Moore1977\]. Over a box of parameters with middle `m` and half sizes
//! `r`, Taylor's theorem gives `f(x) = f(m) + G (x - m) + w`, `|w| <= R`. With any `Y`, here the
//! computed inverse of `G`, every root in the box lies within
//!
//! ```text
//! rho = |Y| (R + delta) + |1 - Y G| r          of          m - Y f(m)
//! ```
//!
//! where `delta` bounds the rounding of `f(m)`. It is not optional: without it a converged enclosure
//! may fail to meet its own box, and roots are lost that no comparison of methods with one leaf can show.
//! The box is cut down to the enclosure and the step repeated, which converges quadratically
//! where the root is simple; where a step does not shrink the box enough it is cut in two, and both
//! halves are searched. A box is given up only when `|f| > |G| r + R + delta` in a coordinate, when
//! the enclosure misses it, or when all of it lies beyond what is asked for. So **every root is
//! enclosed**, and every root is reported.
//!
//! **Closed patches.** What is reported is the middle of an enclosure, with its half sizes as its
//! error, and only if the enclosure touches the closed cell and the closed triangle. A ray through
//! a line between two cells or triangles meets, in exact arithmetic, the closed patches on both
//! sides in one point; each encloses it and reports it. Nothing can slip between them, and no
//! tolerance is chosen: errors are computed.
//!
//! **What we changed**: the depth is bounded along with the rest, so that of several roots the
//! nearest is found first and halves that lie behind it are not searched. This also ends the search
//! where a ray lies in a flat patch, which has a line of roots: it is met where the ray comes in.
//!
//! **Measured** (docs/METHODS.md): about two evaluations a call; a quintic in the height, solved
//! apart, finds the same roots (`tests/tests/mesh_oracle.rs`).

use glam::DVec2;

use crate::simd::Quad;

use super::line::MeshRay;
use super::patch::{Local, Patch};

/// Half size of an enclosure that is small enough, in parameters, but for rounding.
const FINE: f64 = 1.0 / (1u64 << 42) as f64;

/// Larger enclosures are no roots yet, whatever the rounding.
const COARSE: f64 = 1.0 / (1 << 24) as f64;

/// A step that leaves more of a side is followed by a cut.
const SHRINK: f64 = 0.45;

/// Cuts after which a box is taken for a root: it is 2^-30 of a cell then.
const DEPTH: u32 = 60;

/// Evaluations after which what is left is taken for roots, nearest first.
const EVALUATIONS: u32 = 20_000;

/// Where a ray meets a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Root {
    /// Parameter of the mesh ray.
    pub t: f64,
    /// Parameters of the patch.
    pub at: DVec2,
    /// Twice the signed area that the patch's axes span across the ray: negative where they turn
    /// counter-clockwise as the ray sees them.
    pub turn: f64,
}

/// What roots are asked for.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    /// Largest parameter.
    pub t_max: f64,
    /// Only roots whose turn has this sign, if it is not 0.
    pub turn: f64,
}

#[derive(Clone, Copy)]
struct Part {
    low: DVec2,
    high: DVec2,
    depth: u32,
}

/// The nearest root with `0 <= t <= t_max`.
#[inline(always)]
pub(super) fn first_root(patch: &impl Patch, ray: &MeshRay, wanted: Wanted) -> Option<Root> {
    let [middle, half] = patch.whole();
    let mut search = Search { ray, wanted, best: None, evaluations: 0 };
    let mut waiting = Vec::new();
    let mut next = Some(Part { low: middle - half, high: middle + half, depth: 0 });
    while let Some(part) = next {
        // The far half waits; nothing is allocated unless there are two.
        next = search.narrow(patch, part).map(|[near, far]| {
            waiting.push(far);
            near
        });
        if next.is_none() {
            next = waiting.pop();
        }
    }
    search.best
}

struct Search<'a> {
    ray: &'a MeshRay,
    wanted: Wanted,
    best: Option<Root>,
    evaluations: u32,
}

impl Search<'_> {
    /// Narrows a part until it is given up, taken, or cut in two: the nearer half first.
    #[inline(always)]
    fn narrow(&mut self, patch: &impl Patch, mut part: Part) -> Option<[Part; 2]> {
        let delta = patch.rounding();
        let (root, error) = loop {
            let middle = 0.5 * (part.low + part.high);
            let half = 0.5 * (part.high - part.low);
            let local = patch.local(middle, half);
            self.evaluations += 1;
            if self.is_hopeless(&local, half, delta) {
                return None;
            }
            let Local { value, along: [fx, fy], bend } = local;
            let [fx_x, fx_y, ..] = fx.array();
            let [fy_x, fy_y, ..] = fy.array();
            let turn = fx_x * fy_y - fx_y * fy_x;
            let exhausted = part.depth >= DEPTH || self.evaluations >= EVALUATIONS;
            let inverse = 1.0 / turn;
            if inverse.is_finite() {
                let y = [
                    DVec2::new(fy_y * inverse, -fy_x * inverse),
                    DVec2::new(-fx_y * inverse, fx_x * inverse),
                ];
                let ([f_x, f_y, ..], [w_x, w_y, ..]) = (value.array(), bend.array());
                let (f, w) = (DVec2::new(f_x, f_y), DVec2::new(w_x, w_y) + delta);
                let spread = |row: DVec2| {
                    let row = row.abs();
                    let unit = row.x * (fx_x.abs() * half.x + fy_x.abs() * half.y)
                        + row.y * (fx_y.abs() * half.x + fy_y.abs() * half.y);
                    row.dot(w) + 8.0 * f64::EPSILON * (unit + 1.0)
                };
                let root = middle - DVec2::new(y[0].dot(f), y[1].dot(f));
                let error = DVec2::new(spread(y[0]), spread(y[1]));
                if root.is_finite() && error.is_finite() {
                    let (low, high) = (part.low.max(root - error), part.high.min(root + error));
                    if low.x > high.x || low.y > high.y {
                        return None;
                    }
                    let noise = DVec2::new(y[0].abs().element_sum(), y[1].abs().element_sum());
                    let fine = (FINE + 4.0 * delta * noise).min(DVec2::splat(COARSE));
                    let error = error.min(high - low);
                    if error.x <= fine.x && error.y <= fine.y {
                        break (root.clamp(low, high), error);
                    }
                    let shrunk = (high - low).cmple(SHRINK * (part.high - part.low)).all();
                    (part.low, part.high) = (low, high);
                    if shrunk && !exhausted {
                        continue;
                    }
                }
            }
            if exhausted {
                let (low, high) = (part.low, part.high);
                break (0.5 * (low + high), 0.5 * (high - low));
            }
            return Some(self.halves(part, [fx.array(), fy.array()]));
        };
        self.take(patch, root, error);
        None
    }

    /// Whether nothing in a part is wanted.
    #[inline(always)]
    fn is_hopeless(&self, local: &Local<impl Quad>, half: DVec2, delta: f64) -> bool {
        let Local { value, along: [fx, fy], bend } = local;
        let room = fx.size().scaled(half.x).plus(fy.size().scaled(half.y)).plus(*bend);
        let ([x, y, z, _], [room_x, room_y, room_z, _]) = (value.array(), room.array());
        if x.abs() > room_x + delta || y.abs() > room_y + delta {
            return true;
        }
        // `delta` is many times what these parameters are rounded by.
        let room_z = room_z + delta;
        let ends = [self.ray.t_about(z - room_z), self.ray.t_about(z + room_z)];
        let limit = self.best.map_or(self.wanted.t_max, |best| best.t);
        (ends[0] < 0.0 && ends[1] < 0.0) || (ends[0] > limit && ends[1] > limit)
    }

    /// Takes an enclosed root if it is wanted.
    #[inline(always)]
    fn take(&mut self, patch: &impl Patch, at: DVec2, error: DVec2) {
        if !patch.holds(at, error) {
            return;
        }
        let Local { value, along: [fx, fy], .. } = patch.local(at, DVec2::ZERO);
        let ([_, _, depth, _], [fx_x, fx_y, ..], [fy_x, fy_y, ..]) =
            (value.array(), fx.array(), fy.array());
        let t = self.ray.t(depth);
        let turn = fx_x * fy_y - fx_y * fy_x;
        let limit = self.best.map_or(self.wanted.t_max, |best| best.t);
        let nearer = self.best.is_none() && t <= limit || t < limit;
        if t >= 0.0 && nearer && self.wanted.turn * turn >= 0.0 {
            self.best = Some(Root { t, at, turn });
        }
    }

    /// A part cut across the side along which the patch moves more, the half the ray meets first in
    /// front. `along` is the patch's.
    #[cold]
    #[inline(never)]
    fn halves(&self, part: Part, along: [[f64; 4]; 2]) -> [Part; 2] {
        let size = part.high - part.low;
        let moves = |k: usize| {
            let [x, y, ..] = along[k];
            x.abs().max(y.abs()) * size[k]
        };
        let moves = [moves(0), moves(1)];
        // Where the ray sees neither side move, the longer one.
        let side = match moves {
            [x, y] if x == y => usize::from(size.y > size.x),
            [x, y] => usize::from(y > x),
        };
        let middle = 0.5 * (part.low[side] + part.high[side]);
        let (mut low, mut high) = (part, part);
        low.high[side] = middle;
        high.low[side] = middle;
        low.depth += 1;
        high.depth += 1;
        if self.ray.t(along[side][2]) < 0.0 { [high, low] } else { [low, high] }
    }
}
