//! [`Tally`]: what is kept of a batch, so that contenders can be compared and no work is dropped.

/// Hits, and the sum of their ray parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tally {
    pub hits: u64,
    pub t: f64,
}

impl Tally {
    /// Counts a hit at `t`; 0 where only its existence is known.
    #[inline]
    pub fn hit(&mut self, t: f64) {
        self.hits += 1;
        self.t += t;
    }

    /// Mean ray parameter of the hits; none without hits.
    pub fn mean_t(&self) -> Option<f64> {
        (self.hits > 0).then(|| self.t / self.hits as f64)
    }
}
