//! [`Quad`]: four `f64` side by side, for vectors of space; in one AVX register or in an array.

/// Four numbers, none of them NaN. As with [`super::Lanes`], nothing is fused, so every level gives
/// the same bits, and what handles them must be `#[inline(always)]`.
pub(crate) trait Quad: Copy {
    /// The same number four times.
    fn splat(x: f64) -> Self;
    /// Element by element.
    fn of(from: [f64; 4]) -> Self;
    /// Element by element.
    fn array(self) -> [f64; 4];

    /// Sums.
    fn plus(self, other: Self) -> Self;
    /// Differences.
    fn minus(self, other: Self) -> Self;
    /// Products.
    fn times(self, other: Self) -> Self;
    /// Quotients.
    fn over(self, other: Self) -> Self;
    /// Without signs.
    fn size(self) -> Self;
    /// `if self > other { self } else { other }`.
    fn larger(self, other: Self) -> Self;
    /// `if self < other { self } else { other }`.
    fn smaller(self, other: Self) -> Self;

    /// The sign turned where `by` is negative or -0.
    fn turned_by(self, by: Self) -> Self;
    /// Rounded to `f32`.
    fn rounded(self) -> [f32; 4];
    /// The whole numbers at or below, all of them in `i32`.
    fn floors(self) -> [i32; 4];

    /// Products with one number.
    #[inline(always)]
    fn scaled(self, by: f64) -> Self {
        self.times(Self::splat(by))
    }
}

/// Four numbers in an array.
#[derive(Clone, Copy)]
pub(crate) struct PortableQuad([f64; 4]);

#[inline(always)]
fn zip(a: [f64; 4], b: [f64; 4], f: impl Fn(f64, f64) -> f64) -> PortableQuad {
    PortableQuad([f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])])
}

impl Quad for PortableQuad {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([x; 4])
    }

    #[inline(always)]
    fn of(from: [f64; 4]) -> Self {
        Self(from)
    }

    #[inline(always)]
    fn array(self) -> [f64; 4] {
        self.0
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        zip(self.0, other.0, |a, b| a + b)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        zip(self.0, other.0, |a, b| a - b)
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        zip(self.0, other.0, |a, b| a * b)
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        zip(self.0, other.0, |a, b| a / b)
    }

    #[inline(always)]
    fn size(self) -> Self {
        zip(self.0, self.0, |a, _| a.abs())
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        zip(self.0, other.0, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        zip(self.0, other.0, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn turned_by(self, by: Self) -> Self {
        zip(self.0, by.0, |a, b| if b.is_sign_negative() { -a } else { a })
    }

    #[inline(always)]
    fn rounded(self) -> [f32; 4] {
        self.0.map(|x| x as f32)
    }

    #[inline(always)]
    fn floors(self) -> [i32; 4] {
        self.0.map(|x| x.floor() as i32)
    }
}
