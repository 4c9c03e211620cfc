//! Reading a film, line by line into the place where it stays: the sums are never held twice.

use std::path::Path;

use rilievo_render::film::{Counts, Film, Tile};
use rilievo_render::{Aov, RenderSettings};

use super::digits::{COUNTS, DIGITS, share, sum_names};
use super::{FilmFile, Header, OWN};
use crate::error::{Error, Place, Result};
use crate::guard::guarded;
use crate::image::{Attribute, ExrLines, ImageFormat, Line, Source};
use crate::limits::Limits;

impl Header {
    /// Reads what an EXR says of itself.
    ///
    /// # Errors
    /// Of the file. `None` if it is an image of another format.
    pub fn read(path: &Path, limits: &Limits) -> Result<Option<Self>> {
        guarded(path, || {
            let lines = open(path, limits)?;
            Ok(lines.map(|ExrLines { width, height, attributes, .. }| Self {
                size: [width, height],
                attributes,
            }))
        })
    }

    /// The attribute called `name`.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, value)| value)
    }
}

impl FilmFile {
    /// Reads a film from a picture. `None` if the picture says nothing of a film: a finished one, or
    /// of another program.
    ///
    /// # Errors
    /// Of the file; [`Error::Invalid`] where what it says of a film does not add up.
    pub fn read(path: &Path, limits: &Limits) -> Result<Option<Self>> {
        guarded(path, || {
            let Some(lines) = open(path, limits)? else { return Ok(None) };
            let reader = Reader { path, lines: &lines };
            if reader.attribute(OWN[0]).is_none() {
                return Ok(None);
            }
            let (blank, image) = reader.blank(limits)?;
            let fingerprint = reader.text(OWN[0])?.to_owned();
            let others = lines.attributes.iter();
            let others = others.filter(|(name, _)| !OWN.contains(&name.as_str())).cloned();
            let (attributes, colour) = (others.collect(), reader.has("R"));
            let parts = Parts::of(&reader, &blank)?;
            let film = parts.fill(path, lines, blank)?;
            Ok(Some(Self { film, image, fingerprint, attributes, colour }))
        })
    }
}

/// None for an image of another format.
fn open<'a>(path: &'a Path, limits: &'a Limits) -> Result<Option<ExrLines<'a>>> {
    let mut source = Source::open(path, limits)?;
    match source.format()? {
        ImageFormat::Exr => ExrLines::open(source).map(Some),
        _ => Ok(None),
    }
}

fn damaged(path: &Path) -> Error {
    let found = "numbers that no samples add up to".to_owned();
    Error::invalid(path, Place::Header, "sums", found, "those written")
}

/// What the head of a picture says of a film.
struct Reader<'a> {
    path: &'a Path,
    lines: &'a ExrLines<'a>,
}

impl Reader<'_> {
    fn invalid(&self, what: &str, found: &str, allowed: &str) -> Error {
        Error::invalid(self.path, Place::Header, what, found.to_owned(), allowed)
    }

    fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.lines.attributes.iter().find(|(n, _)| n == name).map(|(_, value)| value)
    }

    fn text(&self, name: &str) -> Result<&str> {
        match self.attribute(name) {
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

    fn has(&self, name: &str) -> bool {
        self.lines.names.iter().any(|n| n == name)
    }

    fn has_sums(&self) -> bool {
        self.has("rilievo.count.taken")
    }

    /// The film of which nothing is done, without sums, and the pixels of the whole image.
    fn blank(&self, limits: &Limits) -> Result<(Film, [u32; 2])> {
        let unknown = |name: &str| self.invalid("rilievo/layers", name, "names of layers");
        let names = self.text("rilievo/layers")?.split_whitespace();
        let layers: Vec<Aov> =
            names.map(|name| name.parse().map_err(|_| unknown(name))).collect::<Result<_>>()?;
        let [x, y, width, height] = self.numbers("rilievo/window")?;
        let image = self.numbers("rilievo/image")?;
        let window = Tile { corner: [x, y], size: [width, height] };
        if window.size != [self.lines.width, self.lines.height] || !window.lies_in(image) {
            let found = format!("{width} x {height} at ({x}, {y})");
            return Err(self.invalid("rilievo/window", &found, "the pixels of the file"));
        }
        let samples: [u32; 2] = self.numbers("rilievo/samples")?;
        if samples[0] >= samples[1] || samples[1] > RenderSettings::MAX_SAMPLES {
            let found = format!("{} {}", samples[0], samples[1]);
            return Err(self.invalid("rilievo/samples", &found, "the first below the end"));
        }
        let bytes = Film::predicted_bytes(window.size, &layers, self.has_sums());
        limits.check(self.path, Place::Header, "the film", &[bytes])?;
        let film = Film::of_window(window, samples, &layers, false)
            .map_err(|e| self.invalid("size", &e.to_string(), "what fits the memory"))?;
        Ok((film, image))
    }
}

/// Where the samples of a channel go.
#[derive(Clone, Copy)]
enum Target {
    Nothing,
    Finished,
    /// One of [`COUNTS`].
    Count(usize),
    /// Digit `k` of the sum at a place of a pixel.
    Digit {
        place: usize,
        k: usize,
    },
    Colour(usize),
    /// A channel of a layer.
    Layer {
        layer: usize,
        channel: usize,
    },
}

/// What a film is put together from.
struct Parts {
    /// By channel of the file.
    targets: Vec<Target>,
    /// Numbers of a pixel's sum; 0 for a film without sums.
    stride: usize,
    finished: Vec<bool>,
    values: Vec<i128>,
    counts: Vec<Counts>,
    radiance: Option<Vec<f32>>,
    layers: Vec<Vec<f32>>,
}

impl Parts {
    /// Room for what a film of the shape of `blank` asks for; whoever has sums has the picture in them.
    fn of(reader: &Reader<'_>, blank: &Film) -> Result<Self> {
        let names = &reader.lines.names;
        let mut targets = vec![Target::Nothing; names.len()];
        let mut take = |name: &str, target: Target| match names.iter().position(|n| n == name) {
            Some(at) => {
                targets[at] = target;
                Ok(())
            }
            None => Err(reader.invalid("channels", &format!("no {name}"), "those of a film")),
        };
        take("rilievo.finished", Target::Finished)?;
        let (mut stride, mut colour) = (0, false);
        let mut layers = Vec::new();
        if reader.has_sums() {
            let sums = sum_names(blank);
            stride = sums.len();
            for (place, name) in sums.iter().enumerate() {
                for k in 0..DIGITS {
                    take(&format!("rilievo.sum.{name}.{k}"), Target::Digit { place, k })?;
                }
            }
            for (at, count) in COUNTS.iter().enumerate() {
                take(&format!("rilievo.count.{}", count.name), Target::Count(at))?;
            }
        } else {
            colour = reader.has("R");
            for (channel, name) in ["R", "G", "B"].iter().enumerate().filter(|_| colour) {
                take(name, Target::Colour(channel))?;
            }
            for (layer, of) in blank.layers().iter().enumerate() {
                for (channel, name) in of.aov().channels().iter().enumerate() {
                    take(name, Target::Layer { layer, channel })?;
                }
                layers.push(vec![0.0; of.values().len()]);
            }
        }
        let pixels = blank.finished().len();
        let counted = if stride > 0 { pixels } else { 0 };
        Ok(Self {
            targets,
            stride,
            finished: vec![false; pixels],
            values: vec![0; counted * stride],
            counts: vec![Counts::default(); counted],
            radiance: colour.then(|| vec![0.0; 3 * pixels]),
            layers,
        })
    }

    /// Takes all lines of a file and gives them to a blank film.
    fn fill(mut self, path: &Path, lines: ExrLines<'_>, blank: Film) -> Result<Film> {
        let [width, height] = blank.resolution().map(|side| side as usize);
        let stride: Vec<usize> = blank.layers().iter().map(|layer| layer.channels()).collect();
        lines.each(&mut |line| {
            let first = line.y * width + line.x;
            // The size of the file is that of the film.
            let inside = line.y < height;
            let taken = if inside { self.take(&line, first, &stride) } else { None };
            taken.ok_or_else(|| damaged(path))
        })?;
        let sums = (self.stride > 0).then_some((self.values, self.counts));
        let film = blank.restored(self.finished, sums, self.radiance, self.layers);
        film.ok_or_else(|| damaged(path))
    }

    /// Takes a line that begins at pixel `first`; `None` if one of its numbers cannot be.
    fn take(&mut self, line: &Line<'_>, first: usize, channels: &[usize]) -> Option<()> {
        let target = self.targets[line.channel];
        for (at, &sample) in (first..).zip(line.samples) {
            match target {
                Target::Nothing => break,
                Target::Finished => self.finished[at] = sample == 1.0,
                Target::Count(k) => (COUNTS[k].set)(&mut self.counts[at], sample as i32)?,
                Target::Digit { place, k } => {
                    self.values[at * self.stride + place] += share(sample, k)?;
                }
                Target::Colour(channel) => self.radiance.as_mut()?[3 * at + channel] = sample,
                Target::Layer { layer, channel } => {
                    self.layers[layer][at * channels[layer] + channel] = sample;
                }
            }
        }
        Some(())
    }
}
