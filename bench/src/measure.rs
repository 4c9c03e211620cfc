//! Interleaved passes: A B C A B C ..., so that a slow minute of the machine meets everyone.

use serde::{Deserialize, Serialize};

use crate::clock::timed;

/// Processor seconds of one contender's passes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Passes {
    pub median: f64,
    pub least: f64,
    pub most: f64,
}

impl Passes {
    /// Of seconds in any order; at least one.
    ///
    /// # Panics
    /// Without seconds.
    pub fn of(mut seconds: Vec<f64>) -> Self {
        seconds.sort_by(f64::total_cmp);
        let n = seconds.len();
        let median = 0.5 * (seconds[(n - 1) / 2] + seconds[n / 2]);
        Self { median, least: seconds[0], most: seconds[n - 1] }
    }

    /// How far the passes lie apart, as a share of their median.
    pub fn spread(&self) -> f64 {
        if self.median > 0.0 { (self.most - self.least) / self.median } else { 0.0 }
    }
}

/// Runs each of `works` once to warm up, then `passes` times in turn; what the first run of each
/// gave, and its passes.
pub fn interleaved<T>(works: &[impl Fn() -> T], passes: usize) -> Vec<(T, Passes)> {
    let first: Vec<T> = works.iter().map(|work| work()).collect();
    let mut seconds = vec![Vec::with_capacity(passes); works.len()];
    for _ in 0..passes.max(1) {
        for (work, seconds) in works.iter().zip(&mut seconds) {
            seconds.push(timed(work).1);
        }
    }
    first.into_iter().zip(seconds.into_iter().map(Passes::of)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn passes_take_turns_after_one_round_to_warm_up() {
        let order = RefCell::new(Vec::new());
        let work = |name: char| {
            let order = &order;
            move || {
                order.borrow_mut().push(name);
                name
            }
        };
        let results = interleaved(&[work('a'), work('b')], 2);
        assert_eq!(order.borrow().iter().collect::<String>(), "ababab");
        assert_eq!((results[0].0, results[1].0), ('a', 'b'));
    }

    #[test]
    fn medians_lie_in_the_middle() {
        assert_eq!(Passes::of(vec![3.0, 1.0, 2.0]).median, 2.0);
        let even = Passes::of(vec![4.0, 1.0, 2.0, 3.0]);
        assert_eq!((even.median, even.spread()), (2.5, 1.2));
    }
}
