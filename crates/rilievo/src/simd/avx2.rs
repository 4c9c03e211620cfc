//! Sixteen lanes in two AVX2 registers.

use std::arch::x86_64::{
    __m128i, __m256, __m256i, _CMP_LE_OQ, _CMP_LT_OQ, _mm_cvtss_f32, _mm_loadu_ps, _mm_loadu_si128,
    _mm_max_ps, _mm_max_ss, _mm_min_ps, _mm_min_ss, _mm_movehl_ps, _mm_shuffle_epi8,
    _mm_shuffle_ps, _mm_srli_si128, _mm256_add_epi32, _mm256_add_ps, _mm256_and_ps,
    _mm256_blendv_ps, _mm256_castps128_ps256, _mm256_castps256_ps128, _mm256_castsi128_si256,
    _mm256_castsi256_ps, _mm256_castsi256_si128, _mm256_cmp_ps, _mm256_cvtepi32_ps,
    _mm256_cvtepu8_epi32, _mm256_cvtepu16_epi32, _mm256_div_ps, _mm256_extractf128_ps,
    _mm256_extracti128_si256, _mm256_insertf128_ps, _mm256_inserti128_si256, _mm256_loadu_ps,
    _mm256_loadu_si256, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
    _mm256_or_ps, _mm256_permute_ps, _mm256_permute4x64_epi64, _mm256_set1_epi32, _mm256_set1_ps,
    _mm256_shuffle_epi8, _mm256_sqrt_ps, _mm256_storeu_ps, _mm256_sub_ps, _mm256_xor_ps,
};

use super::avx_quad::AvxQuad;
use super::orders::{BYTES, WIDEN};
use super::{Kernel, Lanes, Mirror, WIDTH};

/// Lanes 0 to 7 and 8 to 15.
#[derive(Clone, Copy)]
pub(crate) struct Avx2([__m256; 2]);

/// Compiles a kernel with this level's instructions.
#[inline(never)]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn enter<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx2>()
}

/// Bytes that turn the four words of each half of 16 bytes around.
const TURN_WORDS: [u8; 32] = [
    6, 7, 4, 5, 2, 3, 0, 1, 14, 15, 12, 13, 10, 11, 8, 9, //
    6, 7, 4, 5, 2, 3, 0, 1, 14, 15, 12, 13, 10, 11, 8, 9,
];

/// Applies an operation of eight lanes to both halves.
macro_rules! halves {
    ($op:ident, $a:expr, $b:expr) => {
        // SAFETY: see the implementation's head.
        unsafe { [$op($a[0], $b[0]), $op($a[1], $b[1])] }
    };
}

// Every block of this implementation: SAFETY: values of this type exist only inside of `enter`,
// whose caller has made sure of the instructions; loads and stores go through references to
// arrays of the full width.
impl Lanes for Avx2 {
    type Mask = [__m256; 2];
    type Quad = AvxQuad;

    #[inline(always)]
    fn call<K: Kernel>(kernel: K) -> K::Output {
        // SAFETY: see above.
        unsafe { enter(kernel) }
    }

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: see above.
        Self([unsafe { _mm256_set1_ps(x) }; 2])
    }

    #[inline(always)]
    fn load(from: &[f32; WIDTH]) -> Self {
        let (low, high) = from.split_at(8);
        // SAFETY: see above; both halves are eight long.
        Self(unsafe { [_mm256_loadu_ps(low.as_ptr()), _mm256_loadu_ps(high.as_ptr())] })
    }

    #[inline(always)]
    fn store(self) -> [f32; WIDTH] {
        let mut out = [0.0; WIDTH];
        let (low, high) = out.split_at_mut(8);
        // SAFETY: see above; both halves are eight long.
        unsafe {
            _mm256_storeu_ps(low.as_mut_ptr(), self.0[0]);
            _mm256_storeu_ps(high.as_mut_ptr(), self.0[1]);
        }
        out
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(halves!(_mm256_add_ps, self.0, other.0))
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(halves!(_mm256_sub_ps, self.0, other.0))
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        Self(halves!(_mm256_mul_ps, self.0, other.0))
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        Self(halves!(_mm256_div_ps, self.0, other.0))
    }

    #[inline(always)]
    fn root(self) -> Self {
        // SAFETY: see above.
        Self(unsafe { [_mm256_sqrt_ps(self.0[0]), _mm256_sqrt_ps(self.0[1])] })
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(halves!(_mm256_max_ps, self.0, other.0))
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        Self(halves!(_mm256_min_ps, self.0, other.0))
    }

    #[inline(always)]
    fn below(self, other: Self) -> Self::Mask {
        #[inline(always)]
        unsafe fn op(a: __m256, b: __m256) -> __m256 {
            // SAFETY: called through `halves!` only.
            unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(a, b) }
        }
        halves!(op, self.0, other.0)
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Self::Mask {
        #[inline(always)]
        unsafe fn op(a: __m256, b: __m256) -> __m256 {
            // SAFETY: called through `halves!` only.
            unsafe { _mm256_cmp_ps::<_CMP_LE_OQ>(a, b) }
        }
        halves!(op, self.0, other.0)
    }

    #[inline(always)]
    fn where_else(self, mask: Self::Mask, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        // SAFETY: see above.
        Self(unsafe {
            [_mm256_blendv_ps(b[0], a[0], mask[0]), _mm256_blendv_ps(b[1], a[1], mask[1])]
        })
    }

    #[inline(always)]
    fn turned_by(self, by: Self) -> Self {
        let sign = Self::splat(-0.0).0;
        let signs = halves!(_mm256_and_ps, by.0, sign);
        Self(halves!(_mm256_xor_ps, self.0, signs))
    }

    #[inline(always)]
    fn all(set: bool) -> Self::Mask {
        // SAFETY: see above.
        [unsafe { _mm256_castsi256_ps(_mm256_set1_epi32(-i32::from(set))) }; 2]
    }

    #[inline(always)]
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        halves!(_mm256_and_ps, a, b)
    }

    #[inline(always)]
    fn or(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        halves!(_mm256_or_ps, a, b)
    }

    #[inline(always)]
    fn bits(mask: Self::Mask) -> u16 {
        // SAFETY: see above.
        let (low, high) = unsafe { (_mm256_movemask_ps(mask[0]), _mm256_movemask_ps(mask[1])) };
        (low | high << 8) as u16
    }

    #[inline(always)]
    fn fetch<T>(what: &T) {
        super::orders::fetch(what);
    }

    #[inline(always)]
    fn least(self) -> f32 {
        // SAFETY: see above.
        unsafe { least(_mm256_min_ps(self.0[0], self.0[1])) }
    }

    #[inline(always)]
    fn greatest(self) -> f32 {
        // SAFETY: see above.
        unsafe { greatest(_mm256_max_ps(self.0[0], self.0[1])) }
    }

    #[inline(always)]
    fn wholes(base: i32, steps: &[i32; WIDTH]) -> Self {
        let (low, high) = steps.split_at(8);
        // SAFETY: see above; both halves are eight long.
        unsafe {
            let base = _mm256_set1_epi32(base);
            let low = _mm256_loadu_si256(low.as_ptr().cast::<__m256i>());
            let high = _mm256_loadu_si256(high.as_ptr().cast::<__m256i>());
            Self([
                _mm256_cvtepi32_ps(_mm256_add_epi32(base, low)),
                _mm256_cvtepi32_ps(_mm256_add_epi32(base, high)),
            ])
        }
    }

    #[inline(always)]
    fn from_u16(codes: &[u16; WIDTH], mirror: Mirror) -> Self {
        // SAFETY: see above; 16 words are 32 bytes.
        unsafe {
            let mut codes = _mm256_loadu_si256(codes.as_ptr().cast::<__m256i>());
            if mirror.x {
                let order = _mm256_loadu_si256(TURN_WORDS.as_ptr().cast::<__m256i>());
                codes = _mm256_shuffle_epi8(codes, order);
            }
            if mirror.y {
                codes = _mm256_permute4x64_epi64::<0b00_01_10_11>(codes);
            }
            let (low, high) = (_mm256_castsi256_si128(codes), _mm256_extracti128_si256::<1>(codes));
            Self([
                _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(low)),
                _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(high)),
            ])
        }
    }

    #[inline(always)]
    fn from_u8(codes: &[u8; WIDTH], mirror: Mirror) -> Self {
        // SAFETY: see above; 16 bytes.
        unsafe {
            let codes = _mm_loadu_si128(codes.as_ptr().cast::<__m128i>());
            let order = _mm_loadu_si128(BYTES[mirror.index()].as_ptr().cast::<__m128i>());
            let codes = _mm_shuffle_epi8(codes, order);
            Self([
                _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(codes)),
                _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_srli_si128::<8>(codes))),
            ])
        }
    }

    #[inline(always)]
    fn corners_u16(rows: [&[u16; 8]; 5], backward: bool) -> [Self; 4] {
        // SAFETY: see above; a row is 16 bytes, half a table 32.
        unsafe {
            let [r0, r1, r2, r3, r4] = rows;
            let [low, high] = &WIDEN[usize::from(backward)];
            let low = _mm256_loadu_si256(low.as_ptr().cast::<__m256i>());
            let high = _mm256_loadu_si256(high.as_ptr().cast::<__m256i>());
            let near = [words(r0, r1), words(r2, r3)];
            let far = [words(r1, r2), words(r3, r4)];
            [widened(near, low), widened(near, high), widened(far, low), widened(far, high)]
        }
    }

    #[inline(always)]
    fn corners_f32(rows: [&[f32; 8]; 5], backward: bool) -> [Self; 4] {
        // SAFETY: see above; four floats from element 0 or 1 of eight.
        unsafe {
            let [r0, r1, r2, r3, r4] = rows;
            if backward {
                [
                    turned([floats::<1>(r0, r1), floats::<1>(r2, r3)]),
                    turned([floats::<0>(r0, r1), floats::<0>(r2, r3)]),
                    turned([floats::<1>(r1, r2), floats::<1>(r3, r4)]),
                    turned([floats::<0>(r1, r2), floats::<0>(r3, r4)]),
                ]
            } else {
                [
                    Self([floats::<0>(r0, r1), floats::<0>(r2, r3)]),
                    Self([floats::<1>(r0, r1), floats::<1>(r2, r3)]),
                    Self([floats::<0>(r1, r2), floats::<0>(r3, r4)]),
                    Self([floats::<1>(r1, r2), floats::<1>(r3, r4)]),
                ]
            }
        }
    }
}

/// Two rows of eight words, side by side.
///
/// # Safety
/// Only inside of [`enter`].
#[inline(always)]
unsafe fn words(a: &[u16; 8], b: &[u16; 8]) -> __m256i {
    // SAFETY: the caller's word; a row is 16 bytes.
    unsafe {
        let v = _mm256_castsi128_si256(_mm_loadu_si128(a.as_ptr().cast::<__m128i>()));
        _mm256_inserti128_si256::<1>(v, _mm_loadu_si128(b.as_ptr().cast::<__m128i>()))
    }
}

/// Words widened to floats by an order of bytes.
///
/// # Safety
/// Only inside of [`enter`].
#[inline(always)]
unsafe fn widened(words: [__m256i; 2], order: __m256i) -> Avx2 {
    // SAFETY: the caller's word.
    unsafe {
        Avx2([
            _mm256_cvtepi32_ps(_mm256_shuffle_epi8(words[0], order)),
            _mm256_cvtepi32_ps(_mm256_shuffle_epi8(words[1], order)),
        ])
    }
}

/// Elements `SHIFT..SHIFT + 4` of two rows, side by side; `SHIFT` at most 4.
///
/// # Safety
/// Only inside of [`enter`].
#[inline(always)]
unsafe fn floats<const SHIFT: usize>(a: &[f32; 8], b: &[f32; 8]) -> __m256 {
    // SAFETY: the caller's word; four floats from element SHIFT of eight.
    unsafe {
        let v = _mm256_castps128_ps256(_mm_loadu_ps(a.as_ptr().add(SHIFT)));
        _mm256_insertf128_ps::<1>(v, _mm_loadu_ps(b.as_ptr().add(SHIFT)))
    }
}

/// Groups of four lanes turned around.
///
/// # Safety
/// Only inside of [`enter`].
#[inline(always)]
unsafe fn turned(v: [__m256; 2]) -> Avx2 {
    // SAFETY: the caller's word.
    unsafe {
        Avx2([_mm256_permute_ps::<0b00_01_10_11>(v[0]), _mm256_permute_ps::<0b00_01_10_11>(v[1])])
    }
}

/// The least of eight lanes.
///
/// # Safety
/// Only where AVX2 is.
#[inline(always)]
pub(super) unsafe fn least(of: __m256) -> f32 {
    // SAFETY: the caller's word.
    unsafe {
        let four = _mm_min_ps(_mm256_castps256_ps128(of), _mm256_extractf128_ps::<1>(of));
        let two = _mm_min_ps(four, _mm_movehl_ps(four, four));
        _mm_cvtss_f32(_mm_min_ss(two, _mm_shuffle_ps::<1>(two, two)))
    }
}

/// The greatest of eight lanes.
///
/// # Safety
/// Only where AVX2 is.
#[inline(always)]
pub(super) unsafe fn greatest(of: __m256) -> f32 {
    // SAFETY: the caller's word.
    unsafe {
        let four = _mm_max_ps(_mm256_castps256_ps128(of), _mm256_extractf128_ps::<1>(of));
        let two = _mm_max_ps(four, _mm_movehl_ps(four, four));
        _mm_cvtss_f32(_mm_max_ss(two, _mm_shuffle_ps::<1>(two, two)))
    }
}
