//! [`FilmFile`]: a film that is not done, inside a picture: an EXR that any viewer shows, with
//! further channels from which a render goes on, or is joined with others, bit for bit.
//!
//! | channels | |
//! |---|---|
//! | `rilievo.finished` | 1 where a pixel has all its samples |
//! | `rilievo.count.taken`, `.refused`, `.weight`, `.seen`, `.hits` | whole numbers: [`Counts`] |
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

mod fingerprint;

use std::path::Path;

use rilievo_render::film::{Counts, Film, Sums, Tile};
use rilievo_render::{Aov, RenderSettings};

pub use fingerprint::Fingerprint;

use crate::error::{Error, Place, Result};
use crate::image::{Attribute, ChannelImage, Picture, Stored};
use crate::limits::Limits;

/// Digits of a sum.
const DIGITS: usize = 5;

/// Bits of a digit.
const DIGIT_BITS: u32 = 24;

/// Attributes that only a film file has.
const OWN: [&str; 5] =
    ["rilievo/fingerprint", "rilievo/image", "rilievo/window", "rilievo/samples", "rilievo/layers"];

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

/// What a picture of an unfinished film holds beside the picture.
#[derive(Clone, Debug)]
pub struct Remainder {
    planes: Vec<(String, Vec<f32>)>,
    attributes: Vec<(String, Attribute)>,
}

impl Remainder {
    /// Of a film of an image of `image` pixels.
    pub fn of(film: &Film, image: [u32; 2], fingerprint: &str) -> Self {
        let pixels = film.finished().len();
        let finished = film.finished().iter().map(|&done| f32::from(u8::from(done))).collect();
        let mut planes = vec![("rilievo.finished".to_owned(), finished)];
        if let Some(sums) = film.sums() {
            for (name, count) in COUNTS {
                let values = sums.counts().iter().map(|counts| count(counts) as f32).collect();
                planes.push((format!("rilievo.count.{name}"), values));
            }
            let stride = sums.stride();
            for (at, name) in sum_names(film).iter().enumerate() {
                let mut digits = [const { Vec::new() }; DIGITS];
                digits.iter_mut().for_each(|plane| plane.reserve_exact(pixels));
                for &sum in sums.values().iter().skip(at).step_by(stride) {
                    for (plane, digit) in digits.iter_mut().zip(split(sum)) {
                        plane.push(digit);
                    }
                }
                for (k, plane) in digits.into_iter().enumerate() {
                    planes.push((format!("rilievo.sum.{name}.{k}"), plane));
                }
            }
        }
        let list =
            |numbers: &[u32]| numbers.iter().map(u32::to_string).collect::<Vec<_>>().join(" ");
        let Tile { corner, size } = film.window();
        let layers: Vec<_> = film.layers().iter().map(|layer| layer.aov().name()).collect();
        let values = [
            fingerprint.to_owned(),
            list(&image),
            list(&[corner, size].concat()),
            list(&film.samples()),
            layers.join(" "),
        ];
        let names = OWN.iter().map(|name| (*name).to_owned());
        let attributes = names.zip(values.map(Attribute::Text)).collect();
        Self { planes, attributes }
    }

    /// Adds its channels and attributes to a picture of the film.
    pub fn add_to<'a>(&'a self, picture: &mut Picture<'a>) {
        for (name, values) in &self.planes {
            picture.push_interleaved(&[name], values, Stored::Float);
        }
        picture.attributes.extend(self.attributes.iter().cloned());
    }

    /// Bytes that writing the rest of a film takes a pixel.
    pub fn bytes_per_pixel(aovs: &[Aov], sums: bool) -> u64 {
        let channels: usize = aovs.iter().map(|aov| aov.channels().len()).sum();
        let planes = if sums { COUNTS.len() + DIGITS * (4 + channels) } else { 0 };
        4 * (1 + planes as u64)
    }
}

impl FilmFile {
    /// Reads a film from a picture. `None` if the picture says nothing of a film: a finished one, or
    /// of another program.
    ///
    /// # Errors
    /// Of the file; [`Error::Invalid`] where what it says of a film does not add up.
    pub fn read(path: &Path, limits: &Limits) -> Result<Option<Self>> {
        let image = ChannelImage::read(path, limits)?;
        if image.attribute(OWN[0]).is_none() {
            return Ok(None);
        }
        let reader = Reader { path, image: &image };
        let unknown = |name: &str| reader.invalid("rilievo/layers", name, "names of layers");
        let names = reader.text("rilievo/layers")?.split_whitespace();
        let layers: Vec<Aov> =
            names.map(|name| name.parse().map_err(|_| unknown(name))).collect::<Result<_>>()?;
        let [x, y, width, height] = reader.numbers("rilievo/window")?;
        let whole = reader.numbers("rilievo/image")?;
        let window = Tile { corner: [x, y], size: [width, height] };
        if [width, height] != [image.width, image.height] || !window.lies_in(whole) {
            let found = format!("{width} x {height} at ({x}, {y})");
            return Err(reader.invalid("rilievo/window", &found, "the pixels of the file"));
        }
        let samples: [u32; 2] = reader.numbers("rilievo/samples")?;
        if samples[0] >= samples[1] || samples[1] > RenderSettings::MAX_SAMPLES {
            let found = format!("{} {}", samples[0], samples[1]);
            return Err(reader.invalid("rilievo/samples", &found, "the first below the end"));
        }
        let blank = Film::of_window(window, samples, &layers, reader.has_sums())
            .map_err(|e| reader.invalid("size", &e.to_string(), "what fits the memory"))?;
        let film = reader.film(blank)?;
        let fingerprint = reader.text(OWN[0])?.to_owned();
        let attributes =
            image.attributes.iter().filter(|(name, _)| !OWN.contains(&name.as_str())).cloned();
        let attributes = attributes.collect();
        let colour = image.channel("R").is_some();
        Ok(Some(Self { film, image: whole, fingerprint, attributes, colour }))
    }
}

/// A count of a pixel.
type Count = fn(&Counts) -> i32;

/// The counts, by name: none is above 2^20.
const COUNTS: [(&str, Count); 5] = [
    ("taken", |c| c.taken as i32),
    ("refused", |c| c.refused as i32),
    ("weight", |c| c.weight),
    ("seen", |c| c.seen as i32),
    ("hits", |c| c.hits as i32),
];

/// The names of a film's sums, in the order in which a pixel keeps them.
fn sum_names(film: &Film) -> Vec<&'static str> {
    let layers = film.layers().iter().flat_map(|layer| layer.aov().channels());
    ["R", "G", "B", "square"].into_iter().chain(layers.copied()).collect()
}

/// The digits of a sum.
fn split(sum: i128) -> [f32; DIGITS] {
    let mask = (1 << DIGIT_BITS) - 1;
    std::array::from_fn(|k| {
        let rest = sum >> (DIGIT_BITS * k as u32);
        (if k + 1 < DIGITS { rest & mask } else { rest }) as f32
    })
}

/// The sum of some digits; `None` if one is no whole number or too large.
fn whole(digits: [f32; DIGITS]) -> Option<i128> {
    let mut sum = 0;
    for (k, digit) in digits.into_iter().enumerate() {
        let (least, most) =
            if k + 1 < DIGITS { (0.0, 16_777_215.0) } else { (-8_388_608.0, 8_388_607.0) };
        if !(least..=most).contains(&digit) || digit.fract() != 0.0 {
            return None;
        }
        sum += i128::from(digit as i32) << (DIGIT_BITS * k as u32);
    }
    Some(sum)
}

/// What a picture says of a film.
struct Reader<'a> {
    path: &'a Path,
    image: &'a ChannelImage,
}

impl Reader<'_> {
    fn invalid(&self, what: &str, found: &str, allowed: &str) -> Error {
        Error::invalid(self.path, Place::Header, what, found.to_owned(), allowed)
    }

    fn text(&self, name: &str) -> Result<&str> {
        match self.image.attribute(name) {
            Some(Attribute::Text(text)) => Ok(text),
            other => Err(self.invalid(name, &format!("{other:?}"), "text")),
        }
    }

    fn numbers<const N: usize>(&self, name: &str) -> Result<[u32; N]> {
        let text = self.text(name)?;
        let numbers: Option<Vec<u32>> = text.split(' ').map(|n| n.parse().ok()).collect();
        let found = numbers.and_then(|numbers| numbers.try_into().ok());
        found.ok_or_else(|| self.invalid(name, text, &format!("{N} whole numbers")))
    }

    fn channel(&self, name: &str) -> Result<&[f32]> {
        match self.image.channel(name) {
            Some(channel) => Ok(&channel.samples),
            None => Err(self.invalid("channels", &format!("no {name}"), "those of a film")),
        }
    }

    fn has_sums(&self) -> bool {
        self.image.channel("rilievo.count.taken").is_some()
    }

    /// The film, from one without anything.
    fn film(&self, blank: Film) -> Result<Film> {
        let finished = self.channel("rilievo.finished")?.iter().map(|&done| done == 1.0).collect();
        let damaged = || self.invalid("sums", "numbers that no samples add up to", "those written");
        let sums = match blank.sums() {
            Some(sums) => Some(self.sums(&blank, sums)?.ok_or_else(damaged)?),
            None => None,
        };
        let interleaved = |names: &[&str]| -> Result<Vec<f32>> {
            let channels =
                names.iter().map(|name| self.channel(name)).collect::<Result<Vec<_>>>()?;
            let pixels = 0..self.channel("rilievo.finished")?.len();
            Ok(pixels.flat_map(|at| channels.iter().map(move |channel| channel[at])).collect())
        };
        // Whoever has sums has the picture in them.
        let (mut radiance, mut layers) = (None, Vec::new());
        if sums.is_none() {
            if self.image.channel("R").is_some() {
                radiance = Some(interleaved(&["R", "G", "B"])?);
            }
            for layer in blank.layers() {
                layers.push(interleaved(layer.aov().channels())?);
            }
        }
        blank.restored(finished, sums, radiance, layers).ok_or_else(damaged)
    }

    fn sums(&self, blank: &Film, sums: &Sums) -> Result<Option<Sums>> {
        let names = sum_names(blank);
        let mut planes = Vec::with_capacity(names.len() * DIGITS);
        for name in &names {
            for k in 0..DIGITS {
                planes.push(self.channel(&format!("rilievo.sum.{name}.{k}"))?);
            }
        }
        let mut counts = Vec::with_capacity(COUNTS.len());
        for (name, _) in COUNTS {
            counts.push(self.channel(&format!("rilievo.count.{name}"))?);
        }
        let pixels = sums.counts().len();
        let values: Option<Vec<i128>> = (0..pixels)
            .flat_map(|at| {
                let digits = planes.chunks_exact(DIGITS);
                digits.map(move |digits| whole(std::array::from_fn(|k| digits[k][at])))
            })
            .collect();
        let counted = (0..pixels).map(|at| {
            let numbers: Vec<i32> = counts.iter().map(|plane| plane[at] as i32).collect();
            let count = |k: usize| u32::try_from(numbers[k]).ok();
            Some(Counts {
                taken: count(0)?,
                refused: count(1)?,
                weight: numbers[2],
                seen: count(3)?,
                hits: count(4)?,
            })
        });
        let counted: Option<Vec<Counts>> = counted.collect();
        Ok(values.zip(counted).and_then(|(values, counts)| sums.restored(values, counts)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IMAGE: [u32; 2] = [40, 30];

    /// A film of a window, with sums that some samples might have.
    fn film() -> Film {
        let window = Tile { corner: [7, 9], size: [5, 4] };
        let blank = Film::of_window(window, [2, 5], &[Aov::P, Aov::Steps], true).unwrap();
        let sums = blank.sums().unwrap();
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
        let values = (0..20 * sums.stride() as i128)
            .map(|k| match counts[k as usize / sums.stride()].taken {
                0 => 0,
                _ => (k - 77) * 0x1234_5678_9abc_def0_1234,
            })
            .collect();
        let sums = sums.restored(values, counts).unwrap();
        let finished = (0..20).map(|k| k % 4 == 3).collect();
        blank.restored(finished, Some(sums), None, Vec::new()).unwrap()
    }

    fn write(film: &Film, path: &Path, change: impl FnOnce(&mut Remainder)) {
        let mut rest = Remainder::of(film, IMAGE, "0123");
        change(&mut rest);
        let [width, height] = film.resolution();
        let mut picture = Picture { width, height, ..Picture::default() };
        picture.push_interleaved(&["R", "G", "B"], film.radiance().as_flattened(), Stored::Float);
        for layer in film.layers() {
            picture.push_interleaved(layer.aov().channels(), layer.values(), Stored::Float);
        }
        picture.attributes.push(("samplesPerPixel".into(), Attribute::Integer(5)));
        rest.add_to(&mut picture);
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
            move |rest: &mut Remainder| {
                for (own, text) in &mut rest.attributes {
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
            write(&film, &path, |rest| {
                let plane = rest.planes.iter_mut().find(|(name, _)| name == plane).unwrap();
                plane.1[1] = value;
            });
            let error = FilmFile::read(&path, &Limits::default()).map(|file| file.is_some());
            // A weight that is no number counts as 0, which some samples have.
            assert!(error.is_err() || plane.ends_with("weight"), "{plane}");
        }
        write(&film, &path, |rest| {
            rest.planes.pop();
        });
        let error = FilmFile::read(&path, &Limits::default()).unwrap_err().to_string();
        assert!(error.contains("no rilievo.sum.Steps.Y.4"), "{error}");
    }

    #[test]
    fn sums_are_their_digits() {
        let edge = 1_i128 << 119;
        for sum in [0, 1, -1, 1 << 24, -(1 << 24), (1 << 96) - 1, -(1 << 96), edge - 1, -edge] {
            assert_eq!(whole(split(sum)), Some(sum), "{sum}");
        }
        let mut sum = 1_i128;
        for _ in 0..300 {
            sum = sum.wrapping_mul(0x1e37_79b9_7f4a_7c15_6a09_e667_f3bc_c909);
            let sum = sum >> 8;
            assert_eq!(whole(split(sum)), Some(sum));
        }
        for digits in [[0.5, 0.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0, 0.0]] {
            assert_eq!(whole(digits), None);
        }
        assert_eq!(whole([f32::NAN; DIGITS]), None);
        assert_eq!(whole([0.0, 0.0, 0.0, 0.0, 1e9]), None);
    }
}
