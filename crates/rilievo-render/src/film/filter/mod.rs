//! [`Filter`]: pixel filters, by filter importance sampling.
//!
//! A camera ray belongs to one pixel only and its place is drawn from the filter \[Ernst2006\], so
//! samples have equal weights, pixels stay independent, and an image does not depend on the order
//! in which tiles are done.
//!
//! Mitchell's filter is negative in places \[Mitchell1988\]. Places are then drawn from its positive
//! or from its negative part, and a sample of the negative part is subtracted. With a share `q` of
//! the filter's absolute mass negative, the first `n` samples hold `round(n q)` negative ones,
//! spread evenly over the absolute sample indices, and the pixel is the sum over the sum of
//! weights. So a constant stays the same constant, no pixel divides by zero, and runs of samples
//! done apart add up to one run. What is not exact: of `n` samples the negative share is off by at
//! most `1 / (2 n)`, which goes away with `n` as noise does, but faster. Choosing the part at random,
//! as \[Pharr2023\], shows as noise even on a constant.

mod cubic;
mod window;

use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

use glam::DVec2;

/// The shape of a filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FilterKind {
    /// 1 over a square; of radius 1/2, the pixel's own.
    Box,
    /// A product of two hats; radius 1.
    Tent,
    /// A round Gaussian of a standard deviation of a third of its radius, 3/2, where it is cut.
    Gaussian,
    /// Mitchell's and Netravali's cubic with B = C = 1/3, in x times in y; radius 2.
    Mitchell,
    /// The Blackman-Harris window of four terms \[Harris1978\], in x times in y; radius 3/2.
    BlackmanHarris,
}

impl FilterKind {
    /// All kinds.
    pub const ALL: [Self; 5] =
        [Self::Box, Self::Tent, Self::Gaussian, Self::Mitchell, Self::BlackmanHarris];

    /// The name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Tent => "tent",
            Self::Gaussian => "gaussian",
            Self::Mitchell => "mitchell",
            Self::BlackmanHarris => "blackman-harris",
        }
    }

    /// The usual radius, pixels.
    pub const fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian | Self::BlackmanHarris => 1.5,
            Self::Mitchell => 2.0,
        }
    }
}

/// The response of a pixel to the light around its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filter {
    /// The shape.
    pub kind: FilterKind,
    /// Largest distance from the pixel's centre along an axis, pixels; above 0, at most
    /// [`Self::MAX_RADIUS`].
    pub radius: f64,
}

/// A place to look at, and what is seen there counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSample {
    /// From the pixel's centre, pixels.
    pub offset: DVec2,
    /// 1, or -1 where the filter is negative.
    pub weight: f64,
}

impl From<FilterKind> for Filter {
    /// With its usual radius.
    fn from(kind: FilterKind) -> Self {
        Self { kind, radius: kind.radius() }
    }
}

impl Filter {
    /// The pixel's own square.
    pub const BOX: Self = Self { kind: FilterKind::Box, radius: FilterKind::Box.radius() };

    /// Largest radius, pixels.
    pub const MAX_RADIUS: f64 = 32.0;

    /// The weight of the sample of absolute index `index`: 1 or -1.
    pub fn weight(&self, index: u64) -> f64 {
        match self.kind {
            FilterKind::Mitchell => {
                let negative = |n: u64| (n as f64 * cubic::NEGATIVE + 0.5).floor();
                if negative(index + 1) > negative(index) { -1.0 } else { 1.0 }
            }
            _ => 1.0,
        }
    }

    /// The place of the sample of absolute index `index`, distributed as the part of the filter that
    /// its weight says, for `u` uniform in `[0, 1)^2`.
    pub fn sample(&self, index: u64, u: DVec2) -> FilterSample {
        let (weight, r) = (self.weight(index), self.radius);
        let offset = match self.kind {
            FilterKind::Box => (2.0 * u - 1.0) * r,
            FilterKind::Tent => DVec2::new(hat(u.x), hat(u.y)) * r,
            FilterKind::Gaussian => {
                let distance = r / 3.0 * (-2.0 * (1.0 - u.x * KEPT).ln()).sqrt();
                let (sin, cos) = (TAU * u.y).sin_cos();
                distance * DVec2::new(cos, sin)
            }
            FilterKind::Mitchell => cubic::sample(weight < 0.0, u) * (0.5 * r),
            FilterKind::BlackmanHarris => DVec2::new(window::sample(u.x), window::sample(u.y)) * r,
        };
        FilterSample { offset, weight }
    }

    /// The response at an offset from the pixel's centre, per square pixel; its integral is 1.
    pub fn value(&self, offset: DVec2) -> f64 {
        let (r, x) = (self.radius, offset / self.radius);
        let unit = match self.kind {
            FilterKind::Box => f64::from(x.abs().max_element() <= 1.0) / 4.0,
            FilterKind::Tent => {
                let hats = (1.0 - x.abs()).max(DVec2::ZERO);
                hats.x * hats.y
            }
            FilterKind::Gaussian => {
                let inside = f64::from(x.length_squared() <= 1.0);
                inside * (-4.5 * x.length_squared()).exp() * 9.0 / (TAU * KEPT)
            }
            FilterKind::Mitchell => 4.0 * cubic::value(2.0 * x.x) * cubic::value(2.0 * x.y),
            FilterKind::BlackmanHarris => window::value(x.x) * window::value(x.y),
        };
        unit / (r * r)
    }
}

/// Mass of a Gaussian within three standard deviations in the plane: `1 - exp(-9/2)`.
const KEPT: f64 = 0.988_891_003_461_757_7;

/// Inverse of the cumulative hat on `[-1, 1]`.
fn hat(u: f64) -> f64 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 - 2.0 * u).sqrt() }
}

/// The place in `[low, high]` where a rising function takes a value, by Newton's steps from the
/// chord, halving where one leaves what is left of the interval. `curve` gives value and slope.
fn solve(curve: impl Fn(f64) -> (f64, f64), [mut low, mut high]: [f64; 2], value: f64) -> f64 {
    let mut x = 0.5 * (low + high);
    for _ in 0..60 {
        let (y, slope) = curve(x);
        if y < value {
            low = x;
        } else {
            high = x;
        }
        let next = x - (y - value) / slope;
        // Not a number where the slope is 0: halve.
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - x).abs() < 1e-12 {
            return next;
        }
        x = next;
    }
    x
}

impl fmt::Display for FilterKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that no filter has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "no filter is called \"{0}\"; there are \"box\", \"tent\", \"gaussian\", \"mitchell\" and \"blackman-harris\""
)]
pub struct UnknownFilter(pub String);

impl FromStr for FilterKind {
    type Err = UnknownFilter;

    fn from_str(name: &str) -> Result<Self, UnknownFilter> {
        let found = Self::ALL.into_iter().find(|filter| filter.name() == name);
        found.ok_or_else(|| UnknownFilter(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::chi_square::{chi_square_z, independent_points};

    /// Sums over cells of a square of side `2 radius`: of a function, and of its absolute value.
    fn masses(filter: &Filter, cells: usize, part: impl Fn(f64) -> f64) -> Vec<f64> {
        const FINE: usize = 32;
        let n = cells * FINE;
        let step = 2.0 * filter.radius / n as f64;
        let mut sums = vec![0.0; cells * cells];
        for at in 0..n * n {
            let p = DVec2::new((at % n) as f64 + 0.5, (at / n) as f64 + 0.5) * step - filter.radius;
            let cell = at / n / FINE * cells + at % n / FINE;
            sums[cell] += part(filter.value(p)) * step * step;
        }
        sums
    }

    fn filters() -> impl Iterator<Item = Filter> {
        let wider = FilterKind::ALL.map(|kind| Filter { kind, radius: 1.25 * kind.radius() });
        FilterKind::ALL.map(Filter::from).into_iter().chain(wider)
    }

    #[test]
    fn responses_add_up_to_one() {
        for filter in filters() {
            let sum: f64 = masses(&filter, 20, |value| value).iter().sum();
            assert!((sum - 1.0).abs() < 1e-3, "{filter:?}: {sum}");
        }
    }

    #[test]
    fn samples_follow_the_part_they_stand_for() {
        const CELLS: usize = 20;
        const SAMPLES: u32 = 200_000;
        for filter in filters() {
            for sign in [1.0, -1.0] {
                let index = (0..100).find(|&i| filter.weight(i) == sign);
                let Some(index) = index else { continue };
                let mut observed = vec![0.0; CELLS * CELLS];
                for u in independent_points(SAMPLES) {
                    let sample = filter.sample(index, u);
                    assert_eq!(sample.weight, sign);
                    assert!(sample.weight * filter.value(sample.offset) >= -1e-12);
                    let place = (sample.offset / filter.radius + 1.0) * 0.5 * CELLS as f64;
                    let [x, y] = place.to_array().map(|x| (x as usize).min(CELLS - 1));
                    observed[y * CELLS + x] += 1.0;
                }
                let mut expected = masses(&filter, CELLS, |value| (sign * value).max(0.0));
                let total: f64 = expected.iter().sum();
                expected.iter_mut().for_each(|cell| *cell *= f64::from(SAMPLES) / total);
                let z = chi_square_z(&observed, &expected);
                assert!(z < 4.0, "{filter:?} {sign}: {z}");
            }
        }
    }

    #[test]
    fn negative_samples_come_in_the_filters_own_share() {
        let filter = Filter::from(FilterKind::Mitchell);
        let absolute: f64 = masses(&filter, 20, f64::abs).iter().sum();
        let share = 0.5 * (1.0 - 1.0 / absolute);
        let mut sum = 0.0;
        for n in 1..5000_u32 {
            sum += filter.weight(u64::from(n) - 1);
            let negative = 0.5 * (f64::from(n) - sum);
            assert!((negative - f64::from(n) * share).abs() < 0.51 && sum > 0.0, "{n}");
        }
        for kind in FilterKind::ALL.into_iter().filter(|&kind| kind != FilterKind::Mitchell) {
            assert!((0..1000).all(|index| Filter::from(kind).weight(index) == 1.0));
        }
    }

    #[test]
    fn a_slope_is_seen_as_it_is_and_a_curve_as_by_the_response() {
        // Means of x and x^2 over many samples against the moments of the response.
        for filter in filters() {
            let (mut first, mut second, mut sum) = (0.0, 0.0, 0.0);
            for (index, u) in independent_points(400_000).enumerate() {
                let FilterSample { offset, weight } = filter.sample(index as u64, u);
                first += weight * offset.x;
                second += weight * offset.x * offset.x;
                sum += weight;
            }
            let cells = 40;
            let moments = masses(&filter, cells, |value| value);
            let centre = |at: usize| {
                ((at % cells) as f64 + 0.5) / cells as f64 * 2.0 * filter.radius - filter.radius
            };
            let want: f64 = moments.iter().enumerate().map(|(k, m)| m * centre(k).powi(2)).sum();
            assert!((first / sum).abs() < 0.01 * filter.radius, "{filter:?}");
            assert!((second / sum - want).abs() < 0.01 * filter.radius.powi(2), "{filter:?}");
        }
    }

    #[test]
    fn names_are_read_back() {
        for kind in FilterKind::ALL {
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
        assert!("sinc".parse::<FilterKind>().is_err());
    }
}
