//! Any image into a [`ChannelImage`]. One of codes (PNG, JPEG, TIFF) becomes channels `Y`, `Y A`,
//! `R G B` or `R G B A` with values from 0 to 1, as stored: no transfer curve is undone.

use std::path::Path;

use super::channels::{Channel, ChannelImage};
use super::source::{Context, Flow, ImageInfo, Row, SampleKind, Sink, Source};
use super::{ImageFormat, decode, exr};
use crate::error::Result;
use crate::guard::guarded;
use crate::limits::Limits;

/// Names of the channels of an image of codes, by their number.
const NAMES: [&[&str]; 4] = [&["Y"], &["Y", "A"], &["R", "G", "B"], &["R", "G", "B", "A"]];

impl ChannelImage {
    /// Reads an image of any format.
    ///
    /// # Errors
    /// Of the file, its format or its size. Of a file with several layers only the first is read.
    pub fn read(path: &Path, limits: &Limits) -> Result<Self> {
        Self::from_source(Source::open(path, limits)?)
    }

    /// Reads an image of any format from bytes; `name` is what errors call it.
    ///
    /// # Errors
    /// As [`ChannelImage::read`].
    pub fn read_bytes(bytes: &[u8], name: &Path, limits: &Limits) -> Result<Self> {
        Self::from_source(Source::from_bytes(bytes, name, limits))
    }

    fn from_source(mut source: Source<'_>) -> Result<Self> {
        if source.format()? == ImageFormat::Exr {
            let Source { context, input } = source;
            return guarded(context.path, move || exr::channels(context, input));
        }
        let mut picture = Picture { context: source.context, image: Self::default() };
        decode(source, &mut picture)?;
        Ok(picture.image)
    }
}

/// Spreads interleaved rows over channels.
struct Picture<'a> {
    context: Context<'a>,
    image: ChannelImage,
}

impl Sink for Picture<'_> {
    fn begin(&mut self, info: &ImageInfo) -> Result<Flow> {
        self.context.check(&ImageInfo { sample: SampleKind::F32, ..*info })?;
        let count = info.width as usize * info.height as usize;
        let names = NAMES[(info.channels as usize - 1).min(3)];
        let channel = |name: &&str| Channel { name: (*name).to_owned(), samples: vec![0.0; count] };
        self.image.channels = names.iter().map(channel).collect();
        (self.image.width, self.image.height) = (info.width, info.height);
        Ok(Flow::Decode)
    }

    fn row(&mut self, y: u32, row: Row<'_>) {
        let (width, count) = (self.image.width as usize, self.image.channels.len());
        let range = y as usize * width..(y as usize + 1) * width;
        for (c, channel) in self.image.channels.iter_mut().enumerate() {
            for (x, to) in channel.samples[range.clone()].iter_mut().enumerate() {
                let at = x * count + c;
                *to = match row {
                    Row::U8(v) => f32::from(v[at]) / 255.0,
                    Row::U16(v) => f32::from(v[at]) / 65535.0,
                    Row::F32(v) => v[at],
                };
            }
        }
    }
}
