//! `[materials.NAME]`: what every model has, images, and the paper's model.

use rilievo::glam::DVec3;
use rilievo::map::{NormalConvention, Wrap};
use rilievo_render::texture::Channel;

use super::kind::{Choice, Colour, Each, Flag, Form, Number, OneOrTwo, Text, along_uv};
use super::map::WRAPS;
use super::{Fallback, Key, Optional, Required, Section};

/// The models of `[materials.NAME]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    Paper,
    Diffuse,
    Conductor,
    Glass,
    ThinGlass,
    Principled,
    Mix,
}

pub const MODEL: Key<Choice<Model>, Fallback<Model>> = Key::new(
    "model",
    Choice(|| {
        vec![
            ("paper", Model::Paper),
            ("diffuse", Model::Diffuse),
            ("conductor", Model::Conductor),
            ("glass", Model::Glass),
            ("thin-glass", Model::ThinGlass),
            ("principled", Model::Principled),
            ("mix", Model::Mix),
        ]
    }),
    Fallback(Model::Paper),
    "how light is scattered",
);
pub const EMITTED: Key<Colour, Fallback<DVec3>> =
    Key::new("emitted", Colour::Any, Fallback(DVec3::ZERO), "radiance from the front")
        .unit("W/(sr m^2)");
pub const EMISSION: Key<Form, Optional> = Key::new(
    "emission",
    Form("image"),
    Optional("none"),
    "factor on `emitted`; no light of `distributed`",
);
pub const NORMALS_TABLE: Key<Form, Optional> = Key::new(
    "normals",
    Form("table, or `false`"),
    Optional("none"),
    "normals on top of the surface's own: an image with `convention` and `strength`, see below",
);

/// `[materials.NAME]`.
pub const MATERIALS: Section = Section {
    name: "materials",
    table: "materials.NAME",
    keys: &[&MODEL, &EMITTED, &EMISSION, &NORMALS_TABLE],
};

pub const DIFFUSE: Key<Colour, Fallback<DVec3>> = Key::new(
    "diffuse",
    Colour::Any,
    Fallback(DVec3::splat(0.5)),
    "reflectance; not with `texture`",
);
pub const TEXTURE: Key<Form, Optional> =
    Key::new("texture", Form("image"), Optional("none"), "in place of `diffuse`");
pub const REFLECTIVE: Key<Colour, Fallback<DVec3>> =
    Key::new("reflective", Colour::Any, Fallback(DVec3::ZERO), "reflectance");
pub const ROUGHNESS: Key<Number, Fallback<f64>> =
    Key::new("roughness", Number::Within(0.0, 1.0), Fallback(0.0), "0: a mirror");

/// `model = "paper"`.
pub const PAPER: Section = Section {
    name: "paper",
    table: "materials.NAME",
    keys: &[&DIFFUSE, &TEXTURE, &REFLECTIVE, &ROUGHNESS],
};

/// Two numbers along u and v.
type Pair = Key<Each<Number, 2>, Fallback<[f64; 2]>>;

pub const FILE: Key<Text, Required> = Key::new(
    "file",
    Text("path"),
    Required(""),
    "PNG, TIFF, JPEG: of colours sRGB codes, of numbers linear ones; \
     OpenEXR, PFM, Radiance, float TIFF: linear",
);
pub const TILE: Pair =
    Key::new("tile", along_uv(Number::Finite), Fallback([1.0; 2]), "repetitions along u and v");
pub const ROTATE: Key<Number, Fallback<f64>> =
    Key::new("rotate", Number::Finite, Fallback(0.0), "from u to v").unit("degrees");
pub const SHIFT: Pair =
    Key::new("shift", along_uv(Number::Finite), Fallback([0.0; 2]), "along u and v")
        .unit("repetitions");
pub const WRAP: Key<OneOrTwo<Wrap>, Fallback<[Wrap; 2]>> =
    Key::new("wrap", OneOrTwo(WRAPS), Fallback([Wrap::Repeat; 2]), "two: along u, along v");
pub const FACTOR: Key<Number, Fallback<f64>> =
    Key::new("factor", Number::Within(0.0, 1.0), Fallback(1.0), "of inputs that are numbers");
pub const TINT: Key<Colour, Fallback<DVec3>> =
    Key::new("factor", Colour::Share, Fallback(DVec3::ONE), "of inputs that are colours");
pub const CHANNEL: Key<Choice<Channel>, Fallback<Channel>> = Key::new(
    "channel",
    Choice(|| vec![("red", Channel::Red), ("green", Channel::Green), ("blue", Channel::Blue)]),
    Fallback(Channel::Red),
    "of inputs that are numbers",
);
pub const INVERT: Key<Flag, Fallback<bool>> = Key::new(
    "invert",
    Flag,
    Fallback(false),
    "of inputs that are numbers; `true`: 1 less the texel",
);

/// An image of a material.
pub const IMAGE: Section = Section {
    name: "image",
    table: "materials.NAME.IMAGE",
    keys: &[&FILE, &TILE, &ROTATE, &SHIFT, &WRAP, &FACTOR, &TINT, &CHANNEL, &INVERT],
};

/// Which way green is.
pub const CONVENTIONS: Choice<NormalConvention> =
    Choice(|| vec![("opengl", NormalConvention::OpenGl), ("directx", NormalConvention::DirectX)]);

/// Required of an image; of a texture set the parser does without.
pub const CONVENTION: Key<Choice<NormalConvention>, Required> = Key::new(
    "convention",
    CONVENTIONS,
    Required("; of a texture set measured"),
    "`\"opengl\"`: green up; `\"directx\"`: green down",
);
pub const STRENGTH: Key<Number, Fallback<f64>> =
    Key::new("strength", Number::Within(0.0, 10.0), Fallback(1.0), "factor on the slope");

/// `normals` of a material.
pub const NORMALS: Section = Section {
    name: "material normals",
    table: "materials.NAME.normals",
    keys: &[&FILE, &TILE, &ROTATE, &SHIFT, &WRAP, &CONVENTION, &STRENGTH],
};
