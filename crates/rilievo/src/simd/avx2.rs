//! Sixteen lanes in two AVX2 registers.

use std::arch::x86_64::{
    __m128i, __m256, __m256i, _CMP_LE_OQ, _CMP_LT_OQ, _mm_loadu_ps, _mm_loadu_si128,
    _mm_shuffle_epi8, _mm_srli_si128, _mm256_add_ps, _mm256_and_ps, _mm256_blendv_ps,
    _mm256_castps128_ps256, _mm256_castsi128_si256, _mm256_castsi256_ps, _mm256_castsi256_si128,
    _mm256_cmp_ps, _mm256_cvtepi32_ps, _mm256_cvtepu8_epi32, _mm256_cvtepu16_epi32,
    _mm256_extracti128_si256, _mm256_insertf128_ps, _mm256_inserti128_si256, _mm256_loadu_ps,
    _mm256_loadu_si256, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
    _mm256_or_ps, _mm256_permute_ps, _mm256_permute4x64_epi64, _mm256_set1_epi32, _mm256_set1_ps,
    _mm256_shuffle_epi8, _mm256_storeu_ps, _mm256_sub_ps, _mm256_xor_ps,
};

use super::orders::{BYTES, WIDEN};
use super::{Kernel, Lanes, Mirror, WIDTH};

/// Lanes 0 to 7 and 8 to 15.
#[derive(Clone, Copy)]
pub(crate) struct Avx2([__m256; 2]);

/// Compiles a kernel with this level's instructions.
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
            let halves = [_mm256_castsi256_si128(codes), _mm256_extracti128_si256::<1>(codes)];
            Self(halves.map(|half| _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(half))))
        }
    }

    #[inline(always)]
    fn from_u8(codes: &[u8; WIDTH], mirror: Mirror) -> Self {
        // SAFETY: see above; 16 bytes.
        unsafe {
            let codes = _mm_loadu_si128(codes.as_ptr().cast::<__m128i>());
            let order = _mm_loadu_si128(BYTES[mirror.index()].as_ptr().cast::<__m128i>());
            let codes = _mm_shuffle_epi8(codes, order);
            let halves = [codes, _mm_srli_si128::<8>(codes)];
            Self(halves.map(|half| _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(half))))
        }
    }

    #[inline(always)]
    fn corners_u16(rows: [&[u16; 8]; 5], backward: bool) -> [Self; 4] {
        // SAFETY: see above; a row is 16 bytes, half a table 32.
        unsafe {
            let row = |k: usize| _mm_loadu_si128(rows[k].as_ptr().cast::<__m128i>());
            let pair = |k: usize| {
                _mm256_inserti128_si256::<1>(_mm256_castsi128_si256(row(k)), row(k + 1))
            };
            let order = |shift: usize| {
                let bytes = &WIDEN[usize::from(backward)][shift];
                _mm256_loadu_si256(bytes.as_ptr().cast::<__m256i>())
            };
            let pairs = [pair(0), pair(1), pair(2), pair(3)];
            let (low, high) = (order(0), order(1));
            let corner = |k: usize, order: __m256i| {
                Self([pairs[k], pairs[k + 2]].map(|v| {
                    _mm256_cvtepi32_ps(_mm256_shuffle_epi8(v, order))
                }))
            };
            [corner(0, low), corner(0, high), corner(1, low), corner(1, high)]
        }
    }

    #[inline(always)]
    fn corners_f32(rows: [&[f32; 8]; 5], backward: bool) -> [Self; 4] {
        // SAFETY: see above; four floats from element 0 or 1 of eight.
        unsafe {
            let part = |k: usize, shift: usize| _mm_loadu_ps(rows[k][shift..].as_ptr());
            let pair = |k: usize, shift: usize| {
                let v = _mm256_castps128_ps256(part(k, shift));
                let v = _mm256_insertf128_ps::<1>(v, part(k + 1, shift));
                if backward { _mm256_permute_ps::<0b00_01_10_11>(v) } else { v }
            };
            let near = usize::from(backward);
            [(0, near), (0, 1 - near), (1, near), (1, 1 - near)]
                .map(|(k, shift)| Self([pair(k, shift), pair(k + 2, shift)]))
        }
    }
}
