//! [`FilmFile`]: a film that is not done, inside a picture: an EXR that any viewer shows, with
//! further channels from which a render goes on, or is joined with others, bit for bit.
//!
//! | channels | |
//! |---|---|
//! | `rilievo.finished` | 1 where a pixel has all its samples |
//! | `rilievo.count.taken`, `.refused`, `.weight`, `.seen`, `.hits` | whole numbers: [`Counts`](rilievo_render::film::Counts) |
//! | `rilievo.sum.R.0` to `.4`, and of `G`, `B`, `square` and each channel of a layer | digits of a sum |
//!
//! A sum is an integer of at most 120 bits ([`rilievo_render::film::sums`]): four digits of 24 bits
//! from the least, and the rest with the sign. All are whole numbers of at most 2^24, which f32 holds
//! exactly and every program reads. Films of integrators that take all samples of a pixel at once
//! have `rilievo.finished` only.
//!
//! | attributes | |
//! |---|---|
//! | `rilievo/fingerprint` | [`Fingerprint`] of the scene and all settings |
//! | `rilievo/image` | `WIDTH HEIGHT` of the whole image |
//! | `rilievo/window` | `X Y WIDTH HEIGHT` of the pixels here |
//! | `rilievo/samples` | `FIRST END`: absolute indices |
//! | `rilievo/layers` | names of the layers, parted by spaces |
//! | `rilievo/flags` | flags the render was begun with, in the words of whoever wrote it |

mod digits;
mod fingerprint;
mod read;
mod remainder;

use rilievo_render::film::Film;

pub use fingerprint::Fingerprint;
pub use remainder::Remainder;

use crate::image::Attribute;

/// Attributes that only a film file has.
const OWN: [&str; 6] = [
    "rilievo/fingerprint",
    "rilievo/image",
    "rilievo/window",
    "rilievo/samples",
    "rilievo/layers",
    Remainder::FLAGS,
];

/// A film and what it is a part of.
#[derive(Clone, Debug)]
pub struct FilmFile {
    /// The film.
    pub film: Film,
    /// Pixels of the whole image.
    pub image: [u32; 2],
    /// Of the render, as [`Fingerprint`] is displayed.
    pub fingerprint: String,
    /// What else the file says, by name.
    pub attributes: Vec<(String, Attribute)>,
    /// Whether the colour is among the channels of the picture.
    pub colour: bool,
}

/// What an EXR says of itself, its samples left aside.
#[derive(Clone, Debug)]
pub struct Header {
    /// Pixels along x and y.
    pub size: [u32; 2],
    /// Its attributes, by name.
    pub attributes: Vec<(String, Attribute)>,
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use rilievo_render::Aov;
    use rilievo_render::film::{Counts, Tile};

    use super::*;
    use crate::image::{Picture, Stored, Values};
    use crate::limits::Limits;

    const IMAGE: [u32; 2] = [40, 30];

    /// A film of a window, with sums that some samples might have.
    fn film() -> Film {
        let window = Tile { corner: [7, 9], size: [5, 4] };
        let blank = Film::of_window(window, [2, 5], &[Aov::P, Aov::Steps], false).unwrap();
        let stride = 4 + 3 + 1;
        let counts: Vec<_> = (0..20)
            .map(|k| Counts {
                taken: k % 4,
                refused: k % 4 / 3,
                weight: 0,
                seen: k % 3 / 2,
                hits: 0,
            })
            .map(|c| Counts {
                weight: (c.taken - c.refused) as i32,
                seen: c.seen.min(c.taken),
                ..c
            })
            .collect();
        let values = (0..20 * stride as i128)
            .map(|k| match counts[k as usize / stride].taken {
                0 => 0,
                _ => (k - 77) * 0x1234_5678_9abc_def0_1234,
            })
            .collect();
        let finished = (0..20).map(|k| k % 4 == 3).collect();
        blank.restored(finished, Some((values, counts)), None, Vec::new()).unwrap()
    }

    fn write(film: &Film, path: &Path, change: impl FnOnce(&mut Picture<'_>)) {
        let [width, height] = film.resolution();
        let mut picture = Picture { width, height, ..Picture::default() };
        picture.push_interleaved(&["R", "G", "B"], film.radiance().as_flattened(), Stored::Float);
        for layer in film.layers() {
            picture.push_interleaved(layer.aov().channels(), layer.values(), Stored::Float);
        }
        picture.attributes.push(("samplesPerPixel".into(), Attribute::Integer(5)));
        Remainder::of(film, IMAGE, "0123", "").add_to(&mut picture);
        change(&mut picture);
        picture.write_exr(path).unwrap();
    }

    #[test]
    fn films_come_back_bit_for_bit() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        let film = film();
        write(&film, &path, |_| {});
        let back = FilmFile::read(&path, &Limits::default()).unwrap().unwrap();
        assert_eq!(back.film.sums(), film.sums());
        assert_eq!(back.film.finished(), film.finished());
        assert_eq!((back.film.window(), back.film.samples()), (film.window(), [2, 5]));
        let bits = |film: &Film| -> Vec<u32> {
            let layers = film.layers().iter().flat_map(|layer| layer.values());
            film.radiance().iter().flatten().chain(layers).map(|v| v.to_bits()).collect()
        };
        assert_eq!(bits(&back.film), bits(&film));
        assert_eq!((back.image, back.fingerprint.as_str(), back.colour), (IMAGE, "0123", true));
        assert_eq!(back.attributes, [("samplesPerPixel".into(), Attribute::Integer(5))]);
        // A film without sums is the picture.
        let blank = Film::of_window(film.window(), [0, 3], &[Aov::Z], false).unwrap();
        let colour = (0..60).map(|k| k as f32).collect();
        let layer = vec![(0..20).map(|k| k as f32 / 3.0).collect()];
        let plain = blank.restored(vec![true; 20], None, Some(colour), layer).unwrap();
        write(&plain, &path, |_| {});
        assert_eq!(FilmFile::read(&path, &Limits::default()).unwrap().unwrap().film, plain);
    }

    #[test]
    fn what_does_not_add_up_is_an_error() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        let film = film();
        let attribute = |name: &'static str, value: &'static str| {
            move |picture: &mut Picture<'_>| {
                for (own, text) in &mut picture.attributes {
                    if own == name {
                        *text = Attribute::Text(value.to_owned());
                    }
                }
            }
        };
        for (name, value) in [
            ("rilievo/window", "7 9 5"),
            ("rilievo/window", "7 9 4 5"),
            ("rilievo/window", "36 9 5 4"),
            ("rilievo/window", "4294967295 9 5 4"),
            ("rilievo/image", "40 -30"),
            ("rilievo/samples", "2"),
            ("rilievo/samples", "5 2"),
            ("rilievo/layers", "P Colour"),
            ("rilievo/layers", "P Z"),
        ] {
            write(&film, &path, attribute(name, value));
            let error = FilmFile::read(&path, &Limits::default()).unwrap_err().to_string();
            assert!(error.contains("allowed: "), "{name}: {error}");
        }
        for (plane, value) in [
            ("rilievo.count.taken", 3e9),
            ("rilievo.count.hits", 4.0),
            ("rilievo.count.weight", f32::NAN),
            ("rilievo.sum.G.0", 0.5),
            ("rilievo.sum.G.4", 8e6),
        ] {
            write(&film, &path, |picture| {
                let mut channels = picture.channels.iter_mut();
                let channel = channels.find(|channel| channel.name == plane).unwrap();
                let Values::Made(sound) = channel.values.clone() else { panic!("{channel:?}") };
                let changed = move |at: usize| if at == 1 { value } else { sound(at) };
                channel.values = Values::Made(Arc::new(changed));
            });
            let error = FilmFile::read(&path, &Limits::default()).map(|file| file.is_some());
            // A weight that is no number counts as 0, which some samples have.
            assert!(error.is_err() || plane.ends_with("weight"), "{plane}");
        }
        write(&film, &path, |picture| {
            picture.channels.pop();
        });
        let error = FilmFile::read(&path, &Limits::default()).unwrap_err().to_string();
        assert!(error.contains("no rilievo.sum.Steps.Y.4"), "{error}");
    }
}
