//! The filter on films whose truth is known.

use std::f32::consts::TAU;

use super::*;
use crate::colour::Rgb;
use crate::film::Tile;

const SIZE: [u32; 2] = [96, 64];

/// A number in `[0, 1)` by place.
fn unit(x: u32, y: u32, what: u32) -> f32 {
    let mut z = u64::from(x) << 40 ^ u64::from(y) << 20 ^ u64::from(what);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ z >> 31) >> 40) as f32 / (1 << 24) as f32
}

/// A normal deviate by place.
fn deviate(x: u32, y: u32, what: u32) -> f32 {
    let (a, b) = (unit(x, y, 2 * what), unit(x, y, 2 * what + 1));
    (-2.0 * (1.0 - a).ln()).sqrt() * (TAU * b).cos()
}

/// A film of a scene given by colour, albedo and normal, finished.
fn film(pixel: impl Fn(u32, u32) -> ([f32; 3], [f32; 3], [f32; 3])) -> Film {
    let mut film = Film::new(SIZE, &GUIDES).unwrap();
    for (x, y) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))) {
        let (radiance, albedo, normal) = pixel(x, y);
        let mut to = film.pixel_mut(x, y);
        *to.radiance = radiance;
        for (aov, channels) in to.layers() {
            channels.copy_from_slice(if aov == Aov::Albedo { &albedo } else { &normal });
        }
    }
    film.set_finished(true);
    film
}

/// A film that knows the samples of each pixel: sixteen.
fn sampled(pixel: impl Fn(u32, u32, u32) -> ([f32; 3], [f32; 3], [f32; 3])) -> Film {
    let mut film = Film::of_window(Tile::whole(SIZE), [0, 16], &GUIDES, true).unwrap();
    for (x, y) in (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))) {
        let mut sums = film.pixel_sums(x, y).unwrap();
        for sample in 0..16 {
            let [radiance, albedo, normal] = {
                let (radiance, albedo, normal) = pixel(x, y, sample);
                [radiance, albedo, normal].map(|v| Rgb::from_array(v.map(f64::from)))
            };
            sums.add(radiance, 1.0);
            sums.add_layers(true, |aov| Some(if aov == Aov::Albedo { albedo } else { normal }));
        }
    }
    film.store_sums();
    film.set_finished(true);
    film
}

/// Two walls under a light that falls off, one of them with fine stripes, and a shadow that no
/// feature shows.
fn room(x: u32, y: u32) -> ([f32; 3], [f32; 3], [f32; 3]) {
    let left = x < SIZE[0] / 2;
    let stripe = if left && (y / 2).is_multiple_of(2) { 0.3 } else { 0.8 };
    let albedo = [stripe, 0.5 * stripe + 0.2, 0.4];
    let shadow = if !left && y > 40 { 0.15 } else { 1.0 };
    let falloff = 1.0 + 0.5 * (x as f32 * 0.05).sin();
    let normal = if left { [1.0, 0.0, 0.0] } else { [0.0, 0.0, 1.0] };
    (albedo.map(|a| a * shadow * falloff), albedo, normal)
}

/// The same with noise: a share of the light, alike in all channels.
fn noisy(share: f32) -> impl Fn(u32, u32) -> ([f32; 3], [f32; 3], [f32; 3]) {
    move |x, y| {
        let (radiance, albedo, normal) = room(x, y);
        (radiance.map(|c| c * (1.0 + share * deviate(x, y, 0))), albedo, normal)
    }
}

fn rmse(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let squares =
        a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| f64::from(a - b).powi(2));
    (squares.sum::<f64>() / (3 * a.len()) as f64).sqrt()
}

#[test]
fn noise_falls_to_a_fraction() {
    let clean = film(room);
    for (share, factor) in [(0.05, 3.0), (0.2, 3.5), (0.5, 3.5)] {
        let noisy = film(noisy(share));
        let before = rmse(noisy.radiance(), clean.radiance());
        let after = rmse(&denoise(&noisy).unwrap(), clean.radiance());
        assert!(after * factor < before, "{share}: {before} to {after}");
    }
}

#[test]
fn variances_of_samples_take_more_off_than_guesses() {
    let clean = film(room);
    // In the shadow there is four times as much noise, for its light.
    let known = sampled(|x, y, sample| {
        let (radiance, albedo, normal) = room(x, y);
        let share = if y > 40 { 2.0 } else { 0.5 };
        (radiance.map(|c| c * (1.0 + share * deviate(x, y, sample))), albedo, normal)
    });
    let at = |x: u32, y: u32| (y * SIZE[0] + x) as usize;
    let guessed = film(|x, y| {
        let (_, albedo, normal) = room(x, y);
        (known.radiance()[at(x, y)], albedo, normal)
    });
    let error = |film: &Film| rmse(&denoise(film).unwrap(), clean.radiance());
    let (before, better, worse) =
        (rmse(known.radiance(), clean.radiance()), error(&known), error(&guessed));
    assert!(better * 3.5 < before && better < worse, "{before} {better} {worse}");
}

#[test]
fn edges_stay() {
    let filtered = denoise(&film(noisy(0.2))).unwrap();
    let mean = |columns: std::ops::Range<u32>, rows: std::ops::Range<u32>| {
        let count = (columns.len() * rows.len()) as f32;
        let at = |x: u32, y: u32| filtered[(y * SIZE[0] + x) as usize][0];
        let all = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
        all.map(|(x, y)| at(x, y)).sum::<f32>() / count
    };
    let right = |rows: std::ops::Range<u32>| mean(50..90, rows);
    // The shadow's border lies between rows 40 and 41, and no feature shows it.
    assert!(right(41..42) < 0.3 * right(40..41), "{} {}", right(41..42), right(40..41));
    // Stripes of the albedo keep their contrast: rows 0, 1 against 2, 3 and so on.
    let (dark, light) = (mean(10..38, 20..22), mean(10..38, 22..24));
    assert!((dark / light - 0.375).abs() < 0.02, "{dark} {light}");
}

#[test]
fn a_constant_is_left_alone_to_the_bit() {
    let flat = film(|_, _| ([0.3, 0.7, 0.11], [0.37; 3], [0.0, 0.0, 1.0]));
    assert_eq!(denoise(&flat).unwrap(), flat.radiance());
    let dark = film(|_, _| ([0.0; 3], [0.0; 3], [0.0; 3]));
    assert_eq!(denoise(&dark).unwrap(), dark.radiance());
}

#[test]
fn threads_do_not_show() {
    let noisy = film(noisy(0.3));
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| denoise(&noisy).unwrap())
    };
    let one = run(1);
    assert_eq!(run(2), one);
    assert_eq!(run(5), one);
}

#[test]
fn what_is_no_number_spoils_nothing_else() {
    let film = film(|x, y| {
        let (radiance, albedo, normal) = noisy(0.2)(x, y);
        (if (x, y) == (20, 20) { [f32::NAN; 3] } else { radiance }, albedo, normal)
    });
    let filtered = denoise(&film).unwrap();
    let bad = filtered.iter().filter(|rgb| rgb.iter().any(|c| !c.is_finite())).count();
    assert_eq!(bad, 1);
}

#[test]
fn a_film_without_guides_is_refused() {
    let film = Film::new(SIZE, &[Aov::Ns]).unwrap();
    assert_eq!(denoise(&film), Err(DenoiseError::NoGuide(Aov::Albedo)));
}
