//! FNV-1a over 64-bit words.

/// A checksum under way. Every piece but the last must be a multiple of eight bytes long.
#[derive(Clone, Debug)]
pub(super) struct Checksum {
    state: u64,
    length: u64,
}

impl Default for Checksum {
    fn default() -> Self {
        Self { state: 0xcbf2_9ce4_8422_2325, length: 0 }
    }
}

impl Checksum {
    fn word(&mut self, word: u64) {
        self.state = (self.state ^ word).wrapping_mul(0x0000_0100_0000_01b3);
    }

    /// Adds a piece.
    pub(super) fn add(&mut self, bytes: &[u8]) {
        debug_assert_eq!(self.length % 8, 0, "only the last piece may end within a word");
        let (words, rest) = bytes.as_chunks();
        for word in words {
            self.word(u64::from_le_bytes(*word));
        }
        if !rest.is_empty() {
            let mut last = [0; 8];
            last[..rest.len()].copy_from_slice(rest);
            self.word(u64::from_le_bytes(last));
        }
        self.length += bytes.len() as u64;
    }

    /// The checksum of everything added.
    pub(super) fn finish(mut self) -> u64 {
        let length = self.length;
        self.word(length);
        self.state
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(pieces: &[&[u8]]) -> u64 {
        let mut sum = Checksum::default();
        pieces.iter().for_each(|piece| sum.add(piece));
        sum.finish()
    }

    #[test]
    fn pieces_do_not_matter_and_every_bit_does() {
        let bytes: Vec<u8> = (0..43).collect();
        let whole = sum(&[&bytes]);
        assert_eq!(sum(&[&bytes[..16], &bytes[16..40], &bytes[40..]]), whole);
        for bit in 0..bytes.len() * 8 {
            let mut other = bytes.clone();
            other[bit / 8] ^= 1 << (bit % 8);
            assert_ne!(sum(&[&other]), whole);
        }
        assert_ne!(sum(&[&[1, 0]]), sum(&[&[1]]));
        assert_ne!(sum(&[]), sum(&[&[0]]));
    }
}
