//! `rilievo diff`: two pictures, value by value.

mod compare;

use rilievo_io::Limits;
use rilievo_io::image::{ChannelImage, write_png_rgb8};
use rilievo_render::film::false_colour::heat;
use serde::Serialize;

use crate::args::DiffArgs;
use crate::outcome::{Failure, Outcome};
use crate::report;
use compare::{Difference, Pair};

/// Where the heat ramp begins for pixels that differ.
const LEAST_HEAT: f64 = 0.35;

/// The JSON object.
#[derive(Serialize)]
struct Report<'a> {
    width: u32,
    height: u32,
    channels: Vec<&'a str>,
    max: f64,
    mean: f64,
    rmse: f64,
    /// Pixels that differ.
    pixels: u64,
    /// Of these, pixels with a number in one picture only.
    unmatched_pixels: u64,
    total_pixels: u64,
    /// Names of the thresholds that were exceeded.
    exceeded: Vec<&'static str>,
    equal: bool,
}

pub fn run(args: &DiffArgs) -> Result<Outcome, Failure> {
    let limits = Limits::default();
    let a = ChannelImage::read(&args.a, &limits)?;
    let b = ChannelImage::read(&args.b, &limits)?;
    let pair = Pair::new(&a, &b, args.layer.as_deref()).map_err(|why| {
        Failure::Refused(format!("{} and {}: {why}", args.a.display(), args.b.display()))
    })?;
    let difference = pair.difference(args.tolerance.unwrap_or(0.0));
    if let Some(output) = &args.output {
        write_png_rgb8(&output.0, [a.width, a.height], &heat_picture(&difference))?;
    }
    let exceeded = exceeded(args, &difference);
    let total = u64::from(a.width) * u64::from(a.height);
    let Difference { max, mean, rmse, pixels, unmatched, .. } = difference;
    let talk = args.talk;
    talk.line(format_args!(
        "{pixels} of {} pixels differ, {unmatched} of them with a number in one picture only",
        report::count(total)
    ));
    let shown = [max, mean, rmse].map(report::number);
    talk.line(format_args!("max {}, mean {}, RMSE {}", shown[0], shown[1], shown[2]));
    if let Some(worst) = &difference.worst {
        let [x, y] = worst.pixel;
        let (channel, [va, vb]) = (worst.channel, worst.values);
        talk.line(format_args!("largest at pixel ({x}, {y}), {channel}: {va} against {vb}"));
    }
    if !exceeded.is_empty() {
        talk.line(format_args!("exceeded: {}", exceeded.join(", ")));
    }
    talk.object(&Report {
        width: a.width,
        height: a.height,
        channels: pair.channels().collect(),
        max,
        mean,
        rmse,
        pixels,
        unmatched_pixels: unmatched,
        total_pixels: total,
        equal: pixels == 0,
        exceeded: exceeded.clone(),
    })?;
    Ok(if exceeded.is_empty() { Outcome::Done } else { Outcome::Unequal })
}

/// The thresholds that `found` exceeds. Without any, no pixel may differ.
fn exceeded(args: &DiffArgs, found: &Difference<'_>) -> Vec<&'static str> {
    let none = args.max.is_none() && args.mean.is_none() && args.rmse.is_none();
    let pixels = args.pixels.or(none.then_some(0));
    let above = |threshold: Option<f64>, value: f64| threshold.is_some_and(|t| value > t);
    let tests = [
        ("max", above(args.max, found.max)),
        ("mean", above(args.mean, found.mean)),
        ("rmse", above(args.rmse, found.rmse)),
        ("pixels", pixels.is_some_and(|most| found.pixels > most)),
        ("unmatched", pixels.is_none() && found.unmatched > 0),
    ];
    tests.iter().filter(|test| test.1).map(|test| test.0).collect()
}

/// Dark where the pictures agree, bright at the largest difference and at unmatched pixels. No pixel
/// that differs is dark, however little.
fn heat_picture(difference: &Difference<'_>) -> Vec<[u8; 3]> {
    let most = if difference.max > 0.0 { difference.max } else { 1.0 };
    let colour =
        |d: f64| heat(if d > 0.0 { LEAST_HEAT + (1.0 - LEAST_HEAT) * d / most } else { 0.0 });
    difference.of_pixel.iter().map(|&d| colour(f64::from(d))).collect()
}
