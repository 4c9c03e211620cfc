//! [`Pair`]: the channels that two pictures share, and how far they are apart.

use rilievo_io::image::{Channel, ChannelImage};

/// Channels to compare, side by side. Both pictures have the same size.
pub struct Pair<'a> {
    channels: Vec<(&'a Channel, &'a Channel)>,
    width: usize,
    pixels: usize,
}

/// How far two pictures are apart.
///
/// A value is *matched* where both pictures hold a finite number, both the same infinity or both
/// NaN. Largest, mean and RMSE are over matched values.
#[derive(Debug)]
pub struct Difference<'a> {
    /// Largest difference of a value.
    pub max: f64,
    /// Mean difference of a value.
    pub mean: f64,
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Pixels with a value that differs by more than the tolerance.
    pub pixels: u64,
    /// Pixels with a value that is not matched.
    pub unmatched: u64,
    /// For each pixel, the largest difference of its values above the tolerance, or 0; infinite
    /// where unmatched.
    pub of_pixel: Vec<f32>,
    /// Where the largest difference is.
    pub worst: Option<Worst<'a>>,
}

/// A value that differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Worst<'a> {
    pub pixel: [usize; 2],
    pub channel: &'a str,
    pub values: [f32; 2],
}

impl<'a> Pair<'a> {
    /// Pairs the channels of `layer`, or all of them.
    ///
    /// # Errors
    /// Says why the pictures cannot be compared.
    pub fn new(
        a: &'a ChannelImage,
        b: &'a ChannelImage,
        layer: Option<&str>,
    ) -> Result<Self, String> {
        if (a.width, a.height) != (b.width, b.height) {
            let (a, b) = ([a.width, a.height], [b.width, b.height]);
            return Err(format!("{} x {} pixels against {} x {}", a[0], a[1], b[0], b[1]));
        }
        let of_layer = |image: &'a ChannelImage| {
            let mut found: Vec<_> =
                image.channels.iter().filter(|c| layer.is_none_or(|l| is_of(l, &c.name))).collect();
            found.sort_by(|a, b| a.name.cmp(&b.name));
            found
        };
        let (of_a, of_b) = (of_layer(a), of_layer(b));
        let names = |channels: &[&Channel]| -> Vec<String> {
            channels.iter().map(|c| c.name.clone()).collect()
        };
        if names(&of_a) != names(&of_b) {
            let (of_a, of_b) = (names(&of_a).join(" "), names(&of_b).join(" "));
            let hint = "; --layer chooses one";
            return Err(format!("channels [{of_a}] against [{of_b}]{hint}"));
        }
        if of_a.is_empty() {
            let all = names(&a.channels.iter().collect::<Vec<_>>()).join(" ");
            return Err(format!("no layer {:?} among channels [{all}]", layer.unwrap_or("")));
        }
        let channels = of_a.into_iter().zip(of_b).collect();
        Ok(Self { channels, width: a.width as usize, pixels: a.width as usize * a.height as usize })
    }

    /// Names of the channels compared.
    pub fn channels(&self) -> impl Iterator<Item = &'a str> {
        self.channels.iter().map(|pair| pair.0.name.as_str())
    }

    /// Compares them. A difference of a value of at most `tolerance` does not make its pixel differ.
    pub fn difference(&self, tolerance: f64) -> Difference<'a> {
        let mut found = Difference {
            max: 0.0,
            mean: 0.0,
            rmse: 0.0,
            pixels: 0,
            unmatched: 0,
            of_pixel: vec![0.0; self.pixels],
            worst: None,
        };
        let (mut sum, mut squares, mut matched) = (0.0, 0.0, 0u64);
        for (a, b) in &self.channels {
            let values = a.samples.iter().zip(&b.samples).enumerate();
            for (at, (&va, &vb)) in values {
                let Some(d) = apart(va, vb) else {
                    found.of_pixel[at] = f32::INFINITY;
                    continue;
                };
                (sum, squares, matched) = (sum + d, squares + d * d, matched + 1);
                // A difference of two f32 may be below the smallest f32 and is still one.
                let shown = if d > tolerance { (d as f32).max(f32::MIN_POSITIVE) } else { 0.0 };
                found.of_pixel[at] = found.of_pixel[at].max(shown);
                if d > found.max {
                    found.max = d;
                    let pixel = [at % self.width, at / self.width];
                    let channel = a.name.as_str();
                    found.worst = Some(Worst { pixel, channel, values: [va, vb] });
                }
            }
        }
        if matched > 0 {
            found.mean = sum / matched as f64;
            found.rmse = (squares / matched as f64).sqrt();
        }
        found.pixels = found.of_pixel.iter().filter(|&&d| d > 0.0).count() as u64;
        found.unmatched = found.of_pixel.iter().filter(|d| d.is_infinite()).count() as u64;
        found
    }
}

/// Whether a channel belongs to a layer: `P.X` to `P`, `Z` to `Z`, `R` to `RGB`, `u` to `UV`.
fn is_of(layer: &str, channel: &str) -> bool {
    let colour = layer == "RGB" && ["R", "G", "B"].contains(&channel);
    let parameters = layer == "UV" && ["u", "v"].contains(&channel);
    let inside = channel.strip_prefix(layer).is_some_and(|rest| rest.starts_with('.'));
    colour || parameters || inside || channel == layer
}

/// How far two values are apart; none where they are not matched.
fn apart(a: f32, b: f32) -> Option<f64> {
    if a == b || (a.is_nan() && b.is_nan()) {
        return Some(0.0);
    }
    let d = (f64::from(a) - f64::from(b)).abs();
    d.is_finite().then_some(d)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(channels: &[(&str, [f32; 4])]) -> ChannelImage {
        let channels = channels
            .iter()
            .map(|(name, v)| Channel { name: (*name).to_owned(), samples: v.to_vec() })
            .collect();
        ChannelImage { width: 2, height: 2, channels, attributes: Vec::new() }
    }

    #[test]
    fn statistics_of_known_differences() {
        let a = image(&[("R", [0.0, 1.0, 2.0, 3.0]), ("G", [0.0; 4])]);
        let b = image(&[("G", [0.0, 0.0, 0.0, 0.5]), ("R", [0.0, 1.0, 1.0, 3.0])]);
        let pair = Pair::new(&a, &b, None).unwrap();
        assert_eq!(pair.channels().collect::<Vec<_>>(), ["G", "R"]);
        let d = pair.difference(0.0);
        assert_eq!((d.max, d.mean, d.pixels, d.unmatched), (1.0, 1.5 / 8.0, 2, 0));
        assert!((d.rmse - (1.25f64 / 8.0).sqrt()).abs() < 1e-15);
        assert_eq!(d.of_pixel, [0.0, 0.0, 1.0, 0.5]);
        let worst = Worst { pixel: [0, 1], channel: "R", values: [2.0, 1.0] };
        assert_eq!(d.worst, Some(worst));
    }

    #[test]
    fn nan_equals_nan_and_differs_from_every_number() {
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        let a = image(&[("Z", [nan, nan, inf, inf])]);
        let b = image(&[("Z", [nan, 1.0, inf, -inf])]);
        let pair = Pair::new(&a, &b, None).unwrap();
        let d = pair.difference(0.0);
        assert_eq!((d.max, d.pixels, d.unmatched), (0.0, 2, 2));
        assert_eq!(d.of_pixel, [0.0, inf, 0.0, inf]);
    }

    #[test]
    fn a_tolerance_forgives_pixels_and_no_statistics() {
        let a = image(&[("R", [0.0, 0.5, 0.25, f32::NAN]), ("G", [0.0, 0.25, 0.0, 0.0])]);
        let b = image(&[("R", [0.0; 4]), ("G", [0.0; 4])]);
        let pair = Pair::new(&a, &b, None).unwrap();
        let (exact, tolerant) = (pair.difference(0.0), pair.difference(0.25));
        assert_eq!((exact.pixels, tolerant.pixels, tolerant.unmatched), (3, 2, 1));
        assert_eq!(tolerant.of_pixel, [0.0, 0.5, 0.0, f32::INFINITY]);
        assert_eq!(
            (exact.max, exact.mean, exact.rmse),
            (tolerant.max, tolerant.mean, tolerant.rmse)
        );
    }

    #[test]
    fn a_difference_below_every_f32_counts() {
        let a = image(&[("Y", [f32::from_bits(1), 0.0, 0.0, 0.0])]);
        let b = image(&[("Y", [0.0; 4])]);
        assert_eq!(Pair::new(&a, &b, None).unwrap().difference(0.0).pixels, 1);
    }

    #[test]
    fn layers_choose_channels() {
        let a = image(&[("R", [0.0; 4]), ("P.X", [0.0; 4]), ("P.Y", [0.0; 4])]);
        let b = image(&[("R", [1.0; 4]), ("P.X", [0.0; 4]), ("P.Y", [0.0; 4]), ("Z", [0.0; 4])]);
        assert!(Pair::new(&a, &b, None).is_err_and(|why| why.contains("--layer")));
        assert!(Pair::new(&a, &b, Some("N")).is_err_and(|why| why.contains("no layer")));
        let of = |layer| Pair::new(&a, &b, Some(layer)).unwrap().difference(0.0).pixels;
        assert_eq!((of("P"), of("RGB"), of("P.X")), (0, 4, 0));
    }
}
