//! Sixteen lanes in plain arrays, four groups of four: what any compiler turns into its own
//! vectors.

use super::{Kernel, Lanes, Mirror, PortableQuad, WIDTH};

/// Lanes `4 y + x` as `[y][x]`.
#[derive(Clone, Copy)]
pub(crate) struct Portable([[f32; 4]; 4]);

/// All bits of an element set, or none.
type Mask = [[u32; 4]; 4];

/// The bit of each lane.
const BITS: Mask =
    [[1, 2, 4, 8], [16, 32, 64, 128], [256, 512, 1024, 2048], [4096, 8192, 16384, 32768]];

#[inline(always)]
fn zip<A: Copy, B: Copy, C: Copy + Default>(
    a: &[[A; 4]; 4],
    b: &[[B; 4]; 4],
    f: impl Fn(A, B) -> C,
) -> [[C; 4]; 4] {
    let mut out = [[C::default(); 4]; 4];
    for y in 0..4 {
        for x in 0..4 {
            out[y][x] = f(a[y][x], b[y][x]);
        }
    }
    out
}

#[inline(always)]
fn full(set: bool) -> u32 {
    if set { u32::MAX } else { 0 }
}

impl Lanes for Portable {
    type Mask = Mask;
    type Quad = PortableQuad;

    #[inline(never)]
    fn call<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<Self>()
    }

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([[x; 4]; 4])
    }

    #[inline(always)]
    fn load(from: &[f32; WIDTH]) -> Self {
        let mut out = [[0.0; 4]; 4];
        for y in 0..4 {
            for x in 0..4 {
                out[y][x] = from[4 * y + x];
            }
        }
        Self(out)
    }

    #[inline(always)]
    fn store(self) -> [f32; WIDTH] {
        let mut out = [0.0; WIDTH];
        for y in 0..4 {
            for x in 0..4 {
                out[4 * y + x] = self.0[y][x];
            }
        }
        out
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(zip(&self.0, &other.0, |a, b| a + b))
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(zip(&self.0, &other.0, |a, b| a - b))
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        Self(zip(&self.0, &other.0, |a, b| a * b))
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        Self(zip(&self.0, &other.0, |a, b| a / b))
    }

    #[inline(always)]
    fn root(self) -> Self {
        Self(zip(&self.0, &self.0, |a, _| a.sqrt()))
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(zip(&self.0, &other.0, |a, b| if a > b { a } else { b }))
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        Self(zip(&self.0, &other.0, |a, b| if a < b { a } else { b }))
    }

    #[inline(always)]
    fn below(self, other: Self) -> Mask {
        zip(&self.0, &other.0, |a, b| full(a < b))
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Mask {
        zip(&self.0, &other.0, |a, b| full(a <= b))
    }

    #[inline(always)]
    fn where_else(self, mask: Mask, other: Self) -> Self {
        let kept = zip(&self.0, &mask, |a, m| a.to_bits() & m);
        let rest = zip(&other.0, &mask, |b, m| b.to_bits() & !m);
        Self(zip(&kept, &rest, |a, b| f32::from_bits(a | b)))
    }

    #[inline(always)]
    fn turned_by(self, by: Self) -> Self {
        Self(zip(&self.0, &by.0, |a, b| f32::from_bits(a.to_bits() ^ (b.to_bits() & 1 << 31))))
    }

    #[inline(always)]
    fn all(set: bool) -> Mask {
        [[full(set); 4]; 4]
    }

    #[inline(always)]
    fn and(a: Mask, b: Mask) -> Mask {
        zip(&a, &b, |a, b| a & b)
    }

    #[inline(always)]
    fn or(a: Mask, b: Mask) -> Mask {
        zip(&a, &b, |a, b| a | b)
    }

    #[inline(always)]
    fn bits(mask: Mask) -> u16 {
        let [a, b, c, d] = zip(&mask, &BITS, |mask, bit| mask & bit);
        let mut all = 0;
        for x in 0..4 {
            all |= a[x] | b[x] | c[x] | d[x];
        }
        all as u16
    }

    #[inline(always)]
    fn fetch<T>(_: &T) {}

    #[inline(always)]
    fn least(self) -> f32 {
        reduced(self, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn greatest(self) -> f32 {
        reduced(self, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn wholes(base: i32, steps: &[i32; WIDTH]) -> Self {
        let mut out = [[0.0; 4]; 4];
        for y in 0..4 {
            for x in 0..4 {
                out[y][x] = (base + steps[4 * y + x]) as f32;
            }
        }
        Self(out)
    }

    #[inline(always)]
    fn from_u16(codes: &[u16; WIDTH], mirror: Mirror) -> Self {
        mirrored(codes, mirror)
    }

    #[inline(always)]
    fn from_u8(codes: &[u8; WIDTH], mirror: Mirror) -> Self {
        mirrored(codes, mirror)
    }

    #[inline(always)]
    fn corners_u16(rows: [&[u16; 8]; 5], backward: bool) -> [Self; 4] {
        corners(rows, backward)
    }

    #[inline(always)]
    fn corners_f32(rows: [&[f32; 8]; 5], backward: bool) -> [Self; 4] {
        corners(rows, backward)
    }
}

/// One number of all, halves joined with halves.
#[inline(always)]
fn reduced(of: Portable, join: impl Fn(f32, f32) -> f32) -> f32 {
    let mut rest = of.store();
    for half in [8, 4, 2, 1] {
        for k in 0..half {
            rest[k] = join(rest[k], rest[k + half]);
        }
    }
    rest[0]
}

/// The numbers of a square of codes, mirrored.
#[inline(always)]
fn mirrored<T: Copy + Into<f32>>(codes: &[T; WIDTH], mirror: Mirror) -> Portable {
    let mut out = [[0.0; 4]; 4];
    for (y, row) in out.iter_mut().enumerate() {
        for (x, number) in row.iter_mut().enumerate() {
            *number = codes[mirror.source(4 * y + x)].into();
        }
    }
    Portable(out)
}

/// Corners of 4 x 4 cells from five rows of samples.
#[inline(always)]
fn corners<T: Copy + Into<f32>>(rows: [&[T; 8]; 5], backward: bool) -> [Portable; 4] {
    let mut out = [[[0.0; 4]; 4]; 4];
    let mut samples = [[0.0f32; 5]; 5];
    for (row, to) in rows.iter().zip(&mut samples) {
        for (x, sample) in to.iter_mut().enumerate() {
            *sample = row[if backward { 4 - x } else { x }].into();
        }
    }
    for y in 0..4 {
        for x in 0..4 {
            out[0][y][x] = samples[y][x];
            out[1][y][x] = samples[y][x + 1];
            out[2][y][x] = samples[y + 1][x];
            out[3][y][x] = samples[y + 1][x + 1];
        }
    }
    out.map(Portable)
}
