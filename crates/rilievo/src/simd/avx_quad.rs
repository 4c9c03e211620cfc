//! Four `f64` in one AVX register.

use std::arch::x86_64::{
    __m128i, __m256d, _mm_storeu_ps, _mm_storeu_si128, _mm256_add_pd, _mm256_and_pd,
    _mm256_andnot_pd, _mm256_cvtpd_ps, _mm256_cvttpd_epi32, _mm256_div_pd, _mm256_floor_pd,
    _mm256_loadu_pd, _mm256_max_pd, _mm256_min_pd, _mm256_mul_pd, _mm256_set1_pd, _mm256_storeu_pd,
    _mm256_sub_pd, _mm256_xor_pd,
};

use super::quad::Quad;

/// Element `k` is element `k`.
#[derive(Clone, Copy)]
pub(crate) struct AvxQuad(__m256d);

// Every block of this implementation: SAFETY: values of this type exist only at a level above
// portable, whose caller has made sure of the instructions; loads and stores go through arrays of the
// full width.
impl Quad for AvxQuad {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_set1_pd(x) })
    }

    #[inline(always)]
    fn of(from: [f64; 4]) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_loadu_pd(from.as_ptr()) })
    }

    #[inline(always)]
    fn array(self) -> [f64; 4] {
        let mut out = [0.0; 4];
        // SAFETY: see above.
        unsafe { _mm256_storeu_pd(out.as_mut_ptr(), self.0) };
        out
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_add_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_sub_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_mul_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_div_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn size(self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_min_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn turned_by(self, by: Self) -> Self {
        // SAFETY: see above.
        Self(unsafe { _mm256_xor_pd(self.0, _mm256_and_pd(by.0, _mm256_set1_pd(-0.0))) })
    }

    #[inline(always)]
    fn rounded(self) -> [f32; 4] {
        let mut out = [0.0; 4];
        // SAFETY: see above.
        unsafe { _mm_storeu_ps(out.as_mut_ptr(), _mm256_cvtpd_ps(self.0)) };
        out
    }

    #[inline(always)]
    fn floors(self) -> [i32; 4] {
        let mut out = [0; 4];
        // SAFETY: see above; four words of 32 bits are 16 bytes.
        unsafe {
            let whole = _mm256_cvttpd_epi32(_mm256_floor_pd(self.0));
            _mm_storeu_si128(out.as_mut_ptr().cast::<__m128i>(), whole);
        }
        out
    }
}
