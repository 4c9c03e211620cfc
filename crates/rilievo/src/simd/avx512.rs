//! Sixteen lanes in one AVX-512 register.

use std::arch::x86_64::{
    __m128i, __m256, __m256i, __m512, __m512i, __mmask16, _CMP_LE_OQ, _CMP_LT_OQ, _mm_loadu_ps,
    _mm_loadu_si128, _mm_shuffle_epi8, _mm256_loadu_si256, _mm256_max_ps, _mm256_min_ps,
    _mm256_permutexvar_epi16, _mm512_add_epi32, _mm512_add_ps, _mm512_castps_si512,
    _mm512_castps128_ps512, _mm512_castps512_ps256, _mm512_castsi128_si512, _mm512_castsi512_ps,
    _mm512_cmp_ps_mask, _mm512_cvtepi32_ps, _mm512_cvtepu8_epi32, _mm512_cvtepu16_epi32,
    _mm512_div_ps, _mm512_extractf32x8_ps, _mm512_insertf32x4, _mm512_inserti32x4, _mm512_loadu_ps,
    _mm512_loadu_si512, _mm512_mask_blend_ps, _mm512_max_ps, _mm512_min_ps, _mm512_mul_ps,
    _mm512_permute_ps, _mm512_set1_epi32, _mm512_set1_ps, _mm512_shuffle_epi8, _mm512_sqrt_ps,
    _mm512_storeu_ps, _mm512_sub_ps, _mm512_ternarylogic_epi32,
};

use super::avx_quad::AvxQuad;
use super::avx2::{greatest, least};
use super::orders::{BYTES, WIDEN, WORDS};
use super::{Kernel, Lanes, Mirror, WIDTH};

/// Lane `k` is element `k`.
#[derive(Clone, Copy)]
pub(crate) struct Avx512(__m512);

/// Compiles a kernel with this level's instructions.
#[inline(never)]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn enter<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Avx512>()
}

// Every block of this implementation: SAFETY: values of this type exist only inside of `enter`,
// whose caller has made sure of the instructions; loads and stores go through references to
// arrays of the full width.
impl Lanes for Avx512 {
    type Mask = __mmask16;
    type Quad = AvxQuad;

    #[inline(always)]
    fn call<K: Kernel>(kernel: K) -> K::Output {
        // SAFETY: see above.
        unsafe { enter(kernel) }
    }

    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_set1_ps(x) })
    }

    #[inline(always)]
    fn load(from: &[f32; WIDTH]) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_loadu_ps(from.as_ptr()) })
    }

    #[inline(always)]
    fn store(self) -> [f32; WIDTH] {
        let mut out = [0.0; WIDTH];
        // SAFETY: see above.
        unsafe { _mm512_storeu_ps(out.as_mut_ptr(), self.0) };
        out
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_add_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_sub_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_mul_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_div_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn root(self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_sqrt_ps(self.0) })
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_max_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_min_ps(self.0, other.0) })
    }

    #[inline(always)]
    fn below(self, other: Self) -> __mmask16 {
        // SAFETY: see above.
        unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> __mmask16 {
        // SAFETY: see above.
        unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn where_else(self, mask: __mmask16, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm512_mask_blend_ps(mask, other.0, self.0) })
    }

    #[inline(always)]
    fn turned_by(self, by: Self) -> Self {
        // SAFETY: see above.
        unsafe {
            let sign = _mm512_set1_epi32(i32::MIN);
            let (a, b) = (_mm512_castps_si512(self.0), _mm512_castps_si512(by.0));
            // a ^ (b & sign)
            Self(_mm512_castsi512_ps(_mm512_ternarylogic_epi32::<0x78>(a, b, sign)))
        }
    }

    #[inline(always)]
    fn all(set: bool) -> __mmask16 {
        if set { __mmask16::MAX } else { 0 }
    }

    #[inline(always)]
    fn and(a: __mmask16, b: __mmask16) -> __mmask16 {
        a & b
    }

    #[inline(always)]
    fn or(a: __mmask16, b: __mmask16) -> __mmask16 {
        a | b
    }

    #[inline(always)]
    fn bits(mask: __mmask16) -> u16 {
        mask
    }

    #[inline(always)]
    fn fetch<T>(what: &T) {
        super::orders::fetch(what);
    }

    #[inline(always)]
    fn least(self) -> f32 {
        // SAFETY: see above.
        unsafe {
            let (low, high) = halves(self.0);
            least(_mm256_min_ps(low, high))
        }
    }

    #[inline(always)]
    fn greatest(self) -> f32 {
        // SAFETY: see above.
        unsafe {
            let (low, high) = halves(self.0);
            greatest(_mm256_max_ps(low, high))
        }
    }

    #[inline(always)]
    fn wholes(base: i32, steps: &[i32; WIDTH]) -> Self {
        // SAFETY: see above.
        unsafe {
            let steps = _mm512_loadu_si512(steps.as_ptr().cast::<__m512i>());
            Self(_mm512_cvtepi32_ps(_mm512_add_epi32(_mm512_set1_epi32(base), steps)))
        }
    }

    #[inline(always)]
    fn from_u16(codes: &[u16; WIDTH], mirror: Mirror) -> Self {
        // SAFETY: see above; 16 words are 32 bytes.
        unsafe {
            let codes = _mm256_loadu_si256(codes.as_ptr().cast::<__m256i>());
            let order = _mm256_loadu_si256(WORDS[mirror.index()].as_ptr().cast::<__m256i>());
            let codes = _mm256_permutexvar_epi16(order, codes);
            Self(_mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(codes)))
        }
    }

    #[inline(always)]
    fn from_u8(codes: &[u8; WIDTH], mirror: Mirror) -> Self {
        // SAFETY: see above; 16 bytes.
        unsafe {
            let codes = _mm_loadu_si128(codes.as_ptr().cast::<__m128i>());
            let order = _mm_loadu_si128(BYTES[mirror.index()].as_ptr().cast::<__m128i>());
            let codes = _mm_shuffle_epi8(codes, order);
            Self(_mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(codes)))
        }
    }

    #[inline(always)]
    fn corners_u16(rows: [&[u16; 8]; 5], backward: bool) -> [Self; 4] {
        // SAFETY: see above; a row is 16 bytes, a table 64.
        unsafe {
            let [r0, r1, r2, r3, r4] = rows;
            let (near, far) = (words([r0, r1, r2, r3]), words([r1, r2, r3, r4]));
            let [low, high] = &WIDEN[usize::from(backward)];
            let low = _mm512_loadu_si512(low.as_ptr().cast::<__m512i>());
            let high = _mm512_loadu_si512(high.as_ptr().cast::<__m512i>());
            [
                Self(_mm512_cvtepi32_ps(_mm512_shuffle_epi8(near, low))),
                Self(_mm512_cvtepi32_ps(_mm512_shuffle_epi8(near, high))),
                Self(_mm512_cvtepi32_ps(_mm512_shuffle_epi8(far, low))),
                Self(_mm512_cvtepi32_ps(_mm512_shuffle_epi8(far, high))),
            ]
        }
    }

    #[inline(always)]
    fn corners_f32(rows: [&[f32; 8]; 5], backward: bool) -> [Self; 4] {
        // SAFETY: see above; four floats from element 0 or 1 of eight.
        unsafe {
            let [r0, r1, r2, r3, r4] = rows;
            let (near, far) = ([r0, r1, r2, r3], [r1, r2, r3, r4]);
            if backward {
                [
                    Self(_mm512_permute_ps::<0b00_01_10_11>(floats::<1>(near))),
                    Self(_mm512_permute_ps::<0b00_01_10_11>(floats::<0>(near))),
                    Self(_mm512_permute_ps::<0b00_01_10_11>(floats::<1>(far))),
                    Self(_mm512_permute_ps::<0b00_01_10_11>(floats::<0>(far))),
                ]
            } else {
                [
                    Self(floats::<0>(near)),
                    Self(floats::<1>(near)),
                    Self(floats::<0>(far)),
                    Self(floats::<1>(far)),
                ]
            }
        }
    }
}

/// Lanes 0 to 7 and 8 to 15.
///
/// # Safety
/// Only inside of [`enter`].
#[inline(always)]
unsafe fn halves(all: __m512) -> (__m256, __m256) {
    // SAFETY: the caller's word.
    unsafe { (_mm512_castps512_ps256(all), _mm512_extractf32x8_ps::<1>(all)) }
}

/// Four rows of eight words, side by side.
///
/// # Safety
/// Only inside of [`enter`].
#[inline(always)]
unsafe fn words(rows: [&[u16; 8]; 4]) -> __m512i {
    // SAFETY: the caller's word; a row is 16 bytes.
    unsafe {
        let v = _mm512_castsi128_si512(_mm_loadu_si128(rows[0].as_ptr().cast::<__m128i>()));
        let v = _mm512_inserti32x4::<1>(v, _mm_loadu_si128(rows[1].as_ptr().cast::<__m128i>()));
        let v = _mm512_inserti32x4::<2>(v, _mm_loadu_si128(rows[2].as_ptr().cast::<__m128i>()));
        _mm512_inserti32x4::<3>(v, _mm_loadu_si128(rows[3].as_ptr().cast::<__m128i>()))
    }
}

/// Elements `SHIFT..SHIFT + 4` of four rows, side by side; `SHIFT` at most 4.
///
/// # Safety
/// Only inside of [`enter`].
#[inline(always)]
unsafe fn floats<const SHIFT: usize>(rows: [&[f32; 8]; 4]) -> __m512 {
    // SAFETY: the caller's word; four floats from element SHIFT of eight.
    unsafe {
        let v = _mm512_castps128_ps512(_mm_loadu_ps(rows[0].as_ptr().add(SHIFT)));
        let v = _mm512_insertf32x4::<1>(v, _mm_loadu_ps(rows[1].as_ptr().add(SHIFT)));
        let v = _mm512_insertf32x4::<2>(v, _mm_loadu_ps(rows[2].as_ptr().add(SHIFT)));
        _mm512_insertf32x4::<3>(v, _mm_loadu_ps(rows[3].as_ptr().add(SHIFT)))
    }
}
