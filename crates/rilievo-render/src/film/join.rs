//! [`join`]: films that were rendered apart become the film of one run.
//!
//! Films of one window whose sample ranges follow on each other become one range: their sums are
//! added. Films of one range whose windows lie side by side become one window. What comes out is
//! what one run of the joined range and window gives, bit for bit: see [`super::sums`].

use super::{Aov, Film, FilmError, Layer, Tile};

/// Why films do not fit together. Films are named by their place in the list.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum JoinError {
    /// There is nothing to join.
    #[error("no film")]
    None,
    /// A film has pixels or samples left to do.
    #[error("film {film} is not finished")]
    Unfinished {
        /// Which.
        film: usize,
    },
    /// Films hold other layers, or one keeps sums and one does not.
    #[error("films {films:?} do not hold the same layers")]
    Layers {
        /// Which two.
        films: [usize; 2],
    },
    /// Both films have a sample.
    #[error("films {films:?} both have sample {sample} of pixel {pixel:?}")]
    Overlap {
        /// Which two.
        films: [usize; 2],
        /// A pixel of both.
        pixel: [u32; 2],
        /// A sample of both.
        sample: u32,
    },
    /// No film has a sample.
    #[error("no film has sample {sample} of pixel {pixel:?}")]
    Gap {
        /// The first such pixel.
        pixel: [u32; 2],
        /// Its first such sample.
        sample: u32,
    },
    /// The joined film does not fit the memory.
    #[error(transparent)]
    Film(#[from] FilmError),
}

/// Joins films of the same render.
///
/// # Errors
/// [`JoinError`] where films are unfinished, overlap, leave gaps or hold other layers.
pub fn join(films: Vec<Film>) -> Result<Film, JoinError> {
    let layers = |film: &Film| film.layers.iter().map(Layer::aov).collect::<Vec<Aov>>();
    let first = films.first().ok_or(JoinError::None)?;
    let kind = (layers(first), first.sums.is_some());
    for (at, film) in films.iter().enumerate() {
        if (layers(film), film.sums.is_some()) != kind {
            return Err(JoinError::Layers { films: [0, at] });
        }
        if !film.is_complete() {
            return Err(JoinError::Unfinished { film: at });
        }
    }
    let mut films: Vec<(usize, Film)> = films.into_iter().enumerate().collect();
    let place = |film: &Film| (film.corner[1], film.corner[0], film.resolution);
    films.sort_by_key(|(_, film)| (place(film), film.samples));
    let mut windows: Vec<(usize, Film)> = Vec::new();
    for (at, film) in films {
        match windows.last_mut() {
            Some((before, sum)) if place(sum) == place(&film) => {
                append([*before, at], sum, &film)?;
                *before = at;
            }
            _ => windows.push((at, film)),
        }
    }
    for (_, film) in &mut windows {
        film.store_sums();
    }
    side_by_side(windows, &kind.0)
}

/// Adds the samples of a film that follow on those of `sum`.
fn append(films: [usize; 2], sum: &mut Film, film: &Film) -> Result<(), JoinError> {
    let (end, start, pixel) = (sum.samples[1], film.samples[0], sum.corner);
    if start < end {
        return Err(JoinError::Overlap { films, pixel, sample: start });
    }
    if start > end {
        return Err(JoinError::Gap { pixel, sample: end });
    }
    if let (Some(sum), Some(more)) = (&mut sum.sums, &film.sums) {
        sum.add(more);
    }
    sum.samples[1] = film.samples[1];
    Ok(())
}

/// Puts windows of one range together.
fn side_by_side(mut windows: Vec<(usize, Film)>, aovs: &[Aov]) -> Result<Film, JoinError> {
    if windows.len() == 1
        && let Some((_, film)) = windows.pop()
    {
        return Ok(film);
    }
    let fold = |pick: fn(u32, u32) -> u32, side: fn(Tile) -> [u32; 2]| {
        let sides = windows.iter().map(|(_, film)| side(film.window()));
        sides.reduce(|a, b| [pick(a[0], b[0]), pick(a[1], b[1])]).unwrap_or_default()
    };
    let corner = fold(u32::min, |tile| tile.corner);
    let end = fold(u32::max, Tile::end);
    let window = Tile { corner, size: [end[0] - corner[0], end[1] - corner[1]] };
    let samples = windows[0].1.samples;
    for (at, (k, film)) in windows.iter().enumerate() {
        if film.samples != samples {
            let sample = if film.samples[0] == samples[0] {
                film.samples[1].min(samples[1])
            } else {
                film.samples[0].min(samples[0])
            };
            let lacking = if film.samples[0] <= sample && sample < film.samples[1] {
                windows[0].1.corner
            } else {
                film.corner
            };
            return Err(JoinError::Gap { pixel: lacking, sample });
        }
        for (before, other) in &windows[..at] {
            let (a, b) = (film.window(), other.window());
            let pixel = [0, 1].map(|axis| a.corner[axis].max(b.corner[axis]));
            if (0..2).all(|axis| pixel[axis] < a.end()[axis].min(b.end()[axis])) {
                let films = [*before, *k];
                return Err(JoinError::Overlap { films, pixel, sample: samples[0] });
            }
        }
    }
    let sums = windows[0].1.sums.is_some();
    let mut all = Film::of_window(window, samples, aovs, sums)?;
    for (_, film) in &windows {
        let corner = [0, 1].map(|axis| film.corner[axis] - corner[axis]);
        all.insert(Tile { corner, size: film.resolution }, film);
    }
    if let Some(at) = all.finished.iter().position(|&done| !done) {
        let width = all.resolution[0] as usize;
        let pixel = [corner[0] + (at % width) as u32, corner[1] + (at / width) as u32];
        return Err(JoinError::Gap { pixel, sample: samples[0] });
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::Rgb;

    /// A finished film; every sample of every pixel is a number of its own.
    fn film(corner: [u32; 2], end: [u32; 2], samples: [u32; 2]) -> Film {
        let window = Tile { corner, size: [end[0] - corner[0], end[1] - corner[1]] };
        let mut film = Film::of_window(window, samples, &[Aov::Z], true).unwrap();
        let sums = film.sums.as_mut().unwrap();
        for y in corner[1]..end[1] {
            for x in corner[0]..end[0] {
                for sample in samples[0]..samples[1] {
                    let value = f64::from(1 + x + 10 * y + 100 * sample).sqrt();
                    let mut pixel = sums.pixel_mut(x - corner[0], y - corner[1]);
                    pixel.add(Rgb::splat(value), 1.0);
                    pixel.add_layers(true, |_| Some(Rgb::splat(value)));
                }
            }
        }
        film.store_sums();
        film.set_finished(true);
        film
    }

    #[test]
    fn ranges_and_windows_become_the_film_of_one_run() {
        let whole = film([0, 0], [7, 5], [0, 9]);
        let ranges = vec![
            film([0, 0], [7, 5], [6, 9]),
            film([0, 0], [7, 5], [0, 2]),
            film([0, 0], [7, 5], [2, 6]),
        ];
        assert_eq!(join(ranges).unwrap(), whole);
        let windows = vec![
            film([3, 0], [7, 2], [0, 9]),
            film([0, 0], [3, 5], [0, 9]),
            film([3, 2], [7, 5], [0, 9]),
        ];
        assert_eq!(join(windows.clone()).unwrap(), whole);
        let mut both = windows;
        both[1] = film([0, 0], [3, 5], [4, 9]);
        both.push(film([0, 0], [3, 5], [0, 4]));
        assert_eq!(join(both).unwrap(), whole);
        assert_eq!(join(vec![whole.clone()]).unwrap(), whole);
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let a = film([0, 0], [4, 4], [0, 4]);
        let error = |films: Vec<Film>| join(films).unwrap_err();
        assert_eq!(error(vec![]), JoinError::None);
        let overlap = |pixel, sample| JoinError::Overlap { films: [0, 1], pixel, sample };
        assert_eq!(error(vec![a.clone(), film([0, 0], [4, 4], [3, 6])]), overlap([0, 0], 3));
        assert_eq!(error(vec![a.clone(), film([3, 2], [5, 5], [0, 4])]), overlap([3, 2], 0));
        let gap = |pixel, sample| JoinError::Gap { pixel, sample };
        assert_eq!(error(vec![a.clone(), film([0, 0], [4, 4], [5, 6])]), gap([0, 0], 4));
        assert_eq!(error(vec![a.clone(), film([5, 0], [6, 4], [0, 4])]), gap([4, 0], 0));
        assert_eq!(error(vec![a.clone(), film([4, 0], [6, 4], [0, 3])]), gap([4, 0], 3));
        let mut unfinished = film([4, 0], [6, 4], [0, 4]);
        unfinished.set_finished(false);
        assert_eq!(error(vec![a.clone(), unfinished]), JoinError::Unfinished { film: 1 });
        let mut plain = Film::of_window(a.window(), [4, 5], &[Aov::Z], false).unwrap();
        plain.set_finished(true);
        assert_eq!(error(vec![a, plain]), JoinError::Layers { films: [0, 1] });
    }
}
