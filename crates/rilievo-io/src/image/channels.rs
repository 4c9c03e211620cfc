//! [`ChannelImage`]: a picture as named channels of f32, the common ground of rendered EXR files
//! and of comparing two images. Names are OpenEXR's `layer.channel`: `R G B` for radiance,
//! `P.X P.Y P.Z` for positions.

/// A picture: named channels of one size, top row first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChannelImage {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The channels; no two have the same name.
    pub channels: Vec<Channel>,
    /// What else the file says, by name.
    pub attributes: Vec<(String, Attribute)>,
}

/// One channel of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its name, such as `R` or `P.X`.
    pub name: String,
    /// `width * height` values, row-major, top row first.
    pub samples: Vec<f32>,
}

/// A piece of metadata.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// Text; EXR keeps Latin-1 only, other characters are written as `?`.
    Text(String),
    /// An integer.
    Integer(i32),
    /// A number.
    Number(f32),
    /// A matrix by its rows, made for row vectors, as EXR keeps transforms: `p M`.
    Matrix([[f32; 4]; 4]),
}

impl ChannelImage {
    /// The channel called `name`.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|c| c.name == name)
    }

    /// The attribute called `name`.
    pub fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|(n, _)| n == name).map(|(_, value)| value)
    }
}
