//! Orders in which bytes and words are fetched: the operands of shuffles; and what asks for memory.

use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};

use super::{Mirror, WIDTH};

/// Words to fetch for each mirror.
pub(super) const WORDS: [[u16; WIDTH]; 4] = {
    let mut table = [[0; WIDTH]; 4];
    let mut k = 0;
    while k < 4 * WIDTH {
        table[k / WIDTH][k % WIDTH] = Mirror::ALL[k / WIDTH].source(k % WIDTH) as u16;
        k += 1;
    }
    table
};

/// Bytes to fetch for each mirror.
pub(super) const BYTES: [[u8; WIDTH]; 4] = {
    let mut table = [[0; WIDTH]; 4];
    let mut k = 0;
    while k < 4 * WIDTH {
        table[k / WIDTH][k % WIDTH] = WORDS[k / WIDTH][k % WIDTH] as u8;
        k += 1;
    }
    table
};

/// Bytes that widen four words of a row of samples to 32 bits: `[backward][shift]`, the words
/// `shift..shift + 4` or, backward, `4 - shift` downwards.
pub(super) const WIDEN: [[[u8; 64]; 2]; 2] = {
    let mut table = [[[0x80; 64]; 2]; 2];
    let mut k = 0;
    while k < 2 * 2 * WIDTH {
        let (backward, shift, lane) = (k / 32, k / 16 % 2, k % 16);
        let word = if backward == 1 { 4 - (lane % 4 + shift) } else { lane % 4 + shift };
        table[backward][shift][4 * lane] = 2 * word as u8;
        table[backward][shift][4 * lane + 1] = 2 * word as u8 + 1;
        k += 1;
    }
    table
};

/// Asks for all lines of memory that something covers.
#[inline(always)]
pub(super) fn fetch<T>(what: &T) {
    let start = std::ptr::from_ref(what).cast::<i8>();
    let mut at = 0;
    while at < size_of::<T>() {
        // SAFETY: every x86-64 processor has the instruction, which never faults.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(at)) };
        at += 64;
    }
}
