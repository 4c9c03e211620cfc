//! Sixteen lanes of `f32`, and four of `f64`, at three levels: AVX-512, AVX2 and portable.
//!
//! A kernel is written once against [`Lanes`] and compiled for each level; [`run`] enters the copy
//! of a [`SimdLevel`] at the outermost call, so that nothing inside asks again. No operation fuses
//! a multiplication with an addition, and minimum and maximum are defined to the last bit (see
//! [`Lanes::larger`]), so every level gives the same bits.
//!
//! **Unsafe code** of the crate is in this folder alone. Two facts make it sound:
//! * A [`SimdLevel`] above portable exists only where the processor was asked and has it.
//! * A value of an AVX type is made and used only inside of [`run`] for its level: the types are
//!   private to the crate, and only a [`Kernel`] names them, through its type parameter.
//!
//! **Measured**: docs/performance.md has the rays a second of each level.

#![expect(unsafe_code, reason = "vector instructions; see above")]

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "x86_64")]
mod avx_quad;
mod level;
#[cfg(target_arch = "x86_64")]
mod orders;
mod portable;
mod quad;

pub use level::{SimdLevel, UnknownSimdLevel};
pub(crate) use quad::{PortableQuad, Quad};

/// Number of lanes.
pub(crate) const WIDTH: usize = 16;

/// Which axes of a 4 x 4 square of lanes are mirrored, lane `4 y + x`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mirror {
    pub x: bool,
    pub y: bool,
}

impl Mirror {
    /// That of stored cells which are combined with these numbers, 0 or -1, by exclusive or.
    #[inline(always)]
    pub fn of([x, y]: [i32; 2]) -> Self {
        Self { x: x != 0, y: y != 0 }
    }

    /// The lane that holds what lane `lane` shows after mirroring.
    #[inline(always)]
    pub const fn source(self, lane: usize) -> usize {
        lane ^ (if self.x { 3 } else { 0 }) ^ (if self.y { 12 } else { 0 })
    }

    /// 0 to 3.
    #[inline(always)]
    pub const fn index(self) -> usize {
        self.x as usize + 2 * self.y as usize
    }

    /// All four, by index.
    pub const ALL: [Self; 4] = [
        Self { x: false, y: false },
        Self { x: true, y: false },
        Self { x: false, y: true },
        Self { x: true, y: true },
    ];
}

/// Sixteen numbers, none of them NaN, and what a kernel does with them.
pub(crate) trait Lanes: Copy {
    /// Sixteen truth values.
    type Mask: Copy;
    /// Four `f64` at this level.
    type Quad: Quad;

    /// Runs a kernel at this level as a call of its own: what several kernels do is compiled once.
    fn call<K: Kernel>(kernel: K) -> K::Output;

    /// The same number in all lanes.
    fn splat(x: f32) -> Self;
    /// Lane `k` from element `k`.
    fn load(from: &[f32; WIDTH]) -> Self;
    /// Element `k` from lane `k`.
    fn store(self) -> [f32; WIDTH];

    /// Sums.
    fn plus(self, other: Self) -> Self;
    /// Differences.
    fn minus(self, other: Self) -> Self;
    /// Products.
    fn times(self, other: Self) -> Self;
    /// Quotients.
    fn over(self, other: Self) -> Self;
    /// Square roots.
    fn root(self) -> Self;
    /// `if self > other { self } else { other }`, also for zeros of different sign.
    fn larger(self, other: Self) -> Self;
    /// `if self < other { self } else { other }`.
    fn smaller(self, other: Self) -> Self;
    /// `self < other`.
    fn below(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn at_most(self, other: Self) -> Self::Mask;
    /// `self` where the mask is set, else `other`.
    fn where_else(self, mask: Self::Mask, other: Self) -> Self;
    /// The sign turned where `by` is negative or -0.
    fn turned_by(self, by: Self) -> Self;

    /// The same truth value in all lanes.
    fn all(set: bool) -> Self::Mask;
    /// Both.
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Either.
    fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Bit `k` from lane `k`.
    fn bits(mask: Self::Mask) -> u16;

    /// Asks for memory that will be read soon. Nothing else follows from it.
    fn fetch<T>(what: &T);

    /// The least of all lanes.
    fn least(self) -> f32;
    /// The greatest of all lanes.
    fn greatest(self) -> f32;

    /// `base + steps`, whole numbers, rounded once.
    fn wholes(base: i32, steps: &[i32; WIDTH]) -> Self;

    /// The numbers of a 4 x 4 square of codes, mirrored.
    fn from_u16(codes: &[u16; WIDTH], mirror: Mirror) -> Self;
    /// The numbers of a 4 x 4 square of codes, mirrored.
    fn from_u8(codes: &[u8; WIDTH], mirror: Mirror) -> Self;

    /// Corners h00, h10, h01, h11 of 4 x 4 cells from five rows of samples, of which the first five
    /// count. Rows come in the order of the cells; `backward` turns the order within each row.
    fn corners_u16(rows: [&[u16; 8]; 5], backward: bool) -> [Self; 4];
    /// See [`Lanes::corners_u16`].
    fn corners_f32(rows: [&[f32; 8]; 5], backward: bool) -> [Self; 4];
}

/// Work that is compiled once for each level. `run` must be `#[inline(always)]`, as must everything
/// in it that handles lanes: only then is it compiled with the level's instructions.
pub(crate) trait Kernel {
    /// What the work ends in.
    type Output;
    /// Does the work.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Runs a kernel at a level.
#[inline]
pub(crate) fn run<K: Kernel>(level: SimdLevel, kernel: K) -> K::Output {
    level.enter(kernel)
}

/// Runs a kernel at the portable level, of which alone it is compiled then: for work that is counted,
/// where compiling is dearer than running. All levels give the same bits and take the same steps.
#[inline]
pub(crate) fn run_portable<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<portable::Portable>()
}

#[cfg(test)]
mod tests;
