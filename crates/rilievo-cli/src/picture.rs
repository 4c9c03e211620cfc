//! [`PictureKind`]: what of a film goes into the file, and how.

use rilievo_io::film_file::Remainder;
use rilievo_io::image::{Attribute, Blocks, Crop, Picture, Stored, write_png_rgb8};
use rilievo_io::{Error, Result};
use rilievo_render::film::Tile;
use rilievo_render::film::false_colour::false_colour;
use rilievo_render::film::tonemap::ToneMap;
use rilievo_render::{Aov, Camera, Film, Integrator, RenderSettings};

use crate::args::value::{PictureFormat, PicturePath};
use crate::denoise::Denoiser;

/// What a picture shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PictureKind {
    /// EXR: colour, perhaps, and layers.
    Channels {
        /// Whether R, G and B are stored.
        colour: bool,
        /// The layers.
        layers: Vec<Aov>,
    },
    /// PNG: the colour.
    Colour,
    /// PNG: a layer in false colours.
    Layer(Aov),
}

impl PictureKind {
    /// What `rilievo render` stores.
    ///
    /// # Errors
    /// Says why the flags do not fit together.
    pub fn new(
        format: PictureFormat,
        integrator: Integrator,
        asked: &[Aov],
    ) -> std::result::Result<Self, &'static str> {
        let all = || Aov::ALL.to_vec();
        match (format, integrator, asked) {
            (PictureFormat::Exr, Integrator::Aov, []) => {
                Ok(Self::Channels { colour: false, layers: all() })
            }
            (PictureFormat::Exr, integrator, layers) => Ok(Self::Channels {
                colour: integrator != Integrator::Aov,
                layers: layers.to_vec(),
            }),
            (PictureFormat::Png, _, []) => Ok(Self::Colour),
            (PictureFormat::Png, Integrator::Aov, [first, ..]) => Ok(Self::Layer(*first)),
            (PictureFormat::Png, ..) => Err(
                "a PNG holds no layers beside the colour; write an EXR, or take --integrator aov",
            ),
        }
    }

    /// The layers to render.
    pub fn layers(&self) -> &[Aov] {
        match self {
            Self::Channels { layers, .. } => layers,
            Self::Colour => &[],
            Self::Layer(aov) => std::slice::from_ref(aov),
        }
    }

    /// Whether it shows the colour.
    pub fn has_colour(&self) -> bool {
        matches!(self, Self::Colour | Self::Channels { colour: true, .. })
    }

    /// Bytes that writing so many pixels takes beside the film, at most: some blocks of an EXR, with
    /// so many channels more than the picture's, or the codes of a PNG.
    pub fn writing_bytes(&self, size: [u32; 2], blocks: Blocks, more: usize) -> u64 {
        match self {
            Self::Channels { colour, layers } => {
                let channels: usize = layers.iter().map(|aov| aov.channels().len()).sum();
                let channels = channels + if *colour { 3 } else { 0 } + more;
                Picture::predicted_bytes(size, blocks, channels)
            }
            // The codes, their filtered copy and the compressed bytes.
            Self::Colour | Self::Layer(_) => 9 * u64::from(size[0]) * u64::from(size[1]),
        }
    }
}

/// The channels of the colour with its noise, beside one without.
pub const NOISY: [&str; 3] = ["Noisy.R", "Noisy.G", "Noisy.B"];

/// The attribute that names what took the noise off.
pub const DENOISER: &str = "rilievo/denoiser";

/// Names what took the noise off.
pub fn denoiser_attribute(denoiser: Denoiser) -> (String, Attribute) {
    (DENOISER.to_owned(), Attribute::Text(denoiser.name().to_owned()))
}

/// What made a film.
#[derive(Clone, Copy)]
pub struct About<'a> {
    pub camera: &'a Camera,
    pub settings: &'a RenderSettings,
    /// Camera rays per pixel.
    pub samples: u32,
}

/// A film that is to be stored.
pub struct Finished<'a> {
    pub film: &'a Film,
    pub kind: &'a PictureKind,
    /// How a PNG shows the colour.
    pub tone_map: ToneMap,
    /// The colour without noise, and what took it off.
    pub denoised: Option<(&'a [[f32; 3]], Denoiser)>,
    /// How an EXR keeps samples.
    pub stored: Stored,
    /// How an EXR is cut up.
    pub blocks: Blocks,
    /// What an EXR says of the render.
    pub about: About<'a>,
    /// What an EXR of a part of a render holds beside the picture.
    pub remainder: Option<&'a Remainder<'a>>,
}

impl Finished<'_> {
    /// Writes the picture, whole or not at all.
    ///
    /// # Errors
    /// Of the file.
    pub fn write(&self, output: &PicturePath) -> Result<()> {
        let (film, path) = (self.film, &output.path);
        match self.kind {
            PictureKind::Colour => {
                write_png_rgb8(path, film.resolution(), &self.tone_map.image8(self.colour()))
            }
            PictureKind::Layer(aov) => {
                let pixels = film.layer(*aov).map(false_colour).unwrap_or_default();
                write_png_rgb8(path, film.resolution(), &pixels)
            }
            PictureKind::Channels { colour, .. } => self.write_channels(path, *colour),
        }
    }

    /// The colour to show.
    pub fn colour(&self) -> &[[f32; 3]] {
        self.denoised.map_or(self.film.radiance(), |(colour, _)| colour)
    }

    fn write_channels(
        &self,
        path: &std::path::Path,
        colour: bool,
    ) -> std::result::Result<(), Error> {
        // Of what is gone on with no bit may be lost.
        let part = self.remainder.is_some();
        let stored = if part { Stored::Float } else { self.stored };
        let shown = colour.then(|| self.colour());
        let mut picture = exr(self.film, shown, stored, self.about.camera.resolution());
        picture.blocks = self.blocks;
        let denoiser = self.denoised.map(|(_, by)| by);
        picture.attributes = self.about.attributes(self.film.is_complete(), denoiser);
        if colour && self.denoised.is_some() {
            picture.push_interleaved(&NOISY, self.film.radiance().as_flattened(), stored);
        }
        if let Some(remainder) = self.remainder {
            remainder.add_to(&mut picture);
        }
        picture.write_exr(path)
    }
}

impl About<'_> {
    /// What the file says about itself: the same for the same picture, so neither time nor threads.
    pub fn attributes(
        &self,
        complete: bool,
        denoiser: Option<Denoiser>,
    ) -> Vec<(String, Attribute)> {
        let text = |name: &str, value: String| (name.to_owned(), Attribute::Text(value));
        let integer = |name: &str, value: u32| {
            let value = i32::try_from(value).unwrap_or(i32::MAX);
            (name.to_owned(), Attribute::Integer(value))
        };
        // Transforms are for row vectors: the columns of ours are the rows of theirs.
        let matrix = |name: &str, columns: [[f64; 4]; 4]| {
            let rows = columns.map(|column| column.map(|x| x as f32));
            (name.to_owned(), Attribute::Matrix(rows))
        };
        let settings = self.settings;
        let image_from_world = self.camera.image_from_world();
        let ndc = image_from_world.map(|m| matrix("worldToNDC", m.to_cols_array_2d()));
        let camera = self.camera.camera_from_world().to_cols_array_2d();
        let own = vec![
            text("software", format!("rilievo {}", env!("CARGO_PKG_VERSION"))),
            integer("samplesPerPixel", self.samples),
            text("rilievo/integrator", settings.integrator.to_string()),
            integer("rilievo/shadowSamples", settings.shadow_samples),
            integer("rilievo/glossySamples", settings.glossy_samples),
            integer("rilievo/diffuseSamples", settings.diffuse_samples),
            integer("rilievo/maxDepth", settings.max_depth),
            text("rilievo/sampler", settings.sampler.to_string()),
            text("rilievo/seed", settings.seed.to_string()),
            integer("rilievo/complete", u32::from(complete)),
            text("rilievo/filter", settings.filter.kind.to_string()),
            matrix("worldToCamera", camera),
        ];
        let denoiser = denoiser.map(denoiser_attribute);
        let mut all: Vec<_> = own.into_iter().chain(ndc).chain(denoiser).collect();
        // As they are read back, so that joined parts write the same file.
        all.sort_by(|a, b| a.0.cmp(&b.0));
        all
    }
}

/// The channels of a film of an image of `image` pixels: a colour, if it is shown, and the layers.
/// Of what is stored as halves, only colours and directions are: eleven bits are enough for those.
pub fn exr<'a>(
    film: &'a Film,
    colour: Option<&'a [[f32; 3]]>,
    stored: Stored,
    image: [u32; 2],
) -> Picture<'a> {
    let [width, height] = film.resolution();
    let crop = Crop { corner: film.window().corner, full: image };
    let crop = (film.window() != Tile::whole(image)).then_some(crop);
    let mut picture = Picture { width, height, crop, ..Picture::default() };
    if let Some(colour) = colour {
        picture.push_interleaved(&["R", "G", "B"], colour.as_flattened(), stored);
    }
    for layer in film.layers() {
        let stored = match layer.aov() {
            Aov::N | Aov::Ns | Aov::Albedo => stored,
            Aov::P | Aov::Uv | Aov::Height | Aov::Steps | Aov::Z => Stored::Float,
        };
        picture.push_interleaved(layer.aov().channels(), layer.values(), stored);
    }
    picture
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_choose_what_is_stored() {
        use {Integrator::Aov as First, Integrator::Distributed, PictureFormat::*};
        let channels =
            |colour, layers: &[Aov]| Ok(PictureKind::Channels { colour, layers: layers.to_vec() });
        let new = PictureKind::new;
        assert_eq!(new(Exr, Distributed, &[]), channels(true, &[]));
        assert_eq!(new(Exr, Distributed, &[Aov::P]), channels(true, &[Aov::P]));
        assert_eq!(new(Exr, First, &[Aov::P]), channels(false, &[Aov::P]));
        assert_eq!(new(Exr, First, &[]), channels(false, &Aov::ALL));
        assert_eq!(new(Png, Distributed, &[]), Ok(PictureKind::Colour));
        assert_eq!(new(Png, First, &[]), Ok(PictureKind::Colour));
        assert_eq!(new(Png, First, &[Aov::Steps, Aov::P]), Ok(PictureKind::Layer(Aov::Steps)));
        assert!(new(Png, Distributed, &[Aov::P]).is_err());
    }
}
