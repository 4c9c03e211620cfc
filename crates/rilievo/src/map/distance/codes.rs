//! Distances as stored: unsigned codes times a quantum, rounded down.

use super::domain::Domain;

/// How many bits a stored distance has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DistanceBits {
    /// One byte.
    U8,
    /// Two bytes.
    U16,
}

impl DistanceBits {
    /// The largest code.
    pub fn max_code(self) -> u32 {
        match self {
            Self::U8 => u32::from(u8::MAX),
            Self::U16 => u32::from(u16::MAX),
        }
    }

    /// Bytes a code takes.
    pub fn bytes(self) -> u64 {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
        }
    }
}

/// The codes of a distance map: x fastest, then y, then z.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Codes {
    /// 8-bit codes.
    U8(Vec<u8>),
    /// 16-bit codes.
    U16(Vec<u16>),
}

impl Codes {
    /// Number of codes.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(v) => v.len(),
            Self::U16(v) => v.len(),
        }
    }

    /// Whether there is no code.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Code `at`.
    ///
    /// # Panics
    /// If there is no such code.
    #[inline]
    pub fn get(&self, at: usize) -> u32 {
        match self {
            Self::U8(v) => u32::from(v[at]),
            Self::U16(v) => u32::from(v[at]),
        }
    }

    /// The width of a code.
    pub fn bits(&self) -> DistanceBits {
        match self {
            Self::U8(_) => DistanceBits::U8,
            Self::U16(_) => DistanceBits::U16,
        }
    }
}

/// A code's storage type.
pub(super) trait Code: Copy + Default + Send {
    /// The storage of `code`, which fits.
    fn store(code: u32) -> Self;
}

impl Code for u8 {
    fn store(code: u32) -> Self {
        code as u8
    }
}

impl Code for u16 {
    fn store(code: u32) -> Self {
        code as u16
    }
}

/// Turns a distance into the largest code that is still safe.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quantiser {
    quantum: f64,
    /// Its reciprocal.
    per_quantum: f64,
    margin: f64,
    max: u32,
}

impl Quantiser {
    pub fn new(domain: &Domain, quantum: f64, bits: DistanceBits) -> Self {
        let max = bits.max_code();
        Self { quantum, per_quantum: 1.0 / quantum, margin: domain.margin(), max }
    }

    /// Largest code whose value is not above `distance` less the margin; 0 if there is none.
    #[inline(always)]
    pub fn code(&self, distance: f64) -> u32 {
        let steps = (distance - self.margin) * self.per_quantum;
        let steps = if steps > 0.0 { steps } else { 0.0 };
        let steps = if steps < f64::from(self.max) { steps } else { f64::from(self.max) };
        // Below 2^16: the cast is the floor.
        steps as i32 as u32
    }

    /// A distance that certainly gets `code` or a higher one, little above the least that does.
    pub fn clear_distance(&self, code: u32) -> f64 {
        (f64::from(code.min(self.max)) * self.quantum + self.margin) * (1.0 + 1e-9)
    }
}

/// The quantum with which the deepest possible distance gets the highest code, so that nothing is
/// ever clamped. A map of one height stores zeros only; its quantum is 1.
pub(super) fn quantum(domain: &Domain, bits: DistanceBits) -> f64 {
    let quantum = domain.depth() / f64::from(bits.max_code());
    if quantum > 0.0 { quantum } else { 1.0 }
}
