//! The keys that go with `model = "..."` of a material.

use rilievo_render::bsdf::GlassTable;

use super::kind::{Choice, Colour, Each, Flag, Form, Input, Number, Text};
use super::{Fallback, Key, Optional, Required, Section};
use crate::texture_set::MapRole;

/// An input of a material, with what it is where nothing is said.
pub type InputKey = Key<Input, Fallback<f64>>;

const fn input(name: &'static str, role: MapRole, default: f64, meaning: &'static str) -> InputKey {
    Key::new(name, Input(role), Fallback(default), meaning)
}

/// `eta` and `k` of a metal's index for red, green and blue light.
pub type Index = [[f64; 3]; 2];

pub const METAL: Key<Choice<Index>, Optional> = Key::new(
    "metal",
    Choice(|| {
        vec![
            ("aluminium", [[1.3456, 0.9649, 0.6172], [7.4746, 6.3995, 5.3031]]),
            ("chromium", [[4.3696, 2.9167, 1.6547], [5.2064, 4.2313, 3.7549]]),
            ("copper", [[0.2004, 0.9240, 1.1022], [3.9129, 2.4528, 2.1421]]),
            ("gold", [[0.1431, 0.3749, 1.4424], [3.9831, 2.3857, 1.6032]]),
            ("iron", [[2.9114, 2.9497, 2.5845], [3.0893, 2.9318, 2.7670]]),
            ("silver", [[0.1552, 0.1166, 0.1382], [4.8284, 3.1222, 2.1470]]),
        ]
    }),
    Optional("or `colour`"),
    "of `\"conductor\"`",
);
pub const ETA: Key<Colour, Optional> = Key::new(
    "eta",
    Colour::Any,
    Optional("or `colour`"),
    "of `\"conductor\"`, with `k`, in place of `metal`: complex index for red, green, blue",
);
pub const K: Key<Colour, Required> = Key::new(
    "k",
    Colour::Any,
    Required("with `eta`"),
    "of `\"conductor\"`, with `eta`: its imaginary part",
);
pub const DIFFUSE_COLOUR: InputKey =
    input("colour", MapRole::Albedo, 0.5, "of `\"diffuse\"`: share of light that comes back");
pub const DIFFUSE_ROUGHNESS: InputKey = input(
    "roughness",
    MapRole::Roughness,
    0.0,
    "of `\"diffuse\"`: 0 is Lambert's; Oren and Nayar's, energy-preserving (EON)",
);
pub const METAL_COLOUR: InputKey = input(
    "colour",
    MapRole::Albedo,
    0.9,
    "of `\"conductor\"`, in place of `metal`: reflectance straight on",
);
pub const EDGE: InputKey = input(
    "edge",
    MapRole::Specular,
    1.0,
    "of `\"conductor\"`, with `colour`: at 82 degrees, as a factor on Schlick's value",
);
pub const METAL_ROUGHNESS: InputKey =
    input("roughness", MapRole::Roughness, 0.3, "of `\"conductor\"`");
pub const COMPENSATE: Key<Flag, Fallback<bool>> = Key::new(
    "compensate",
    Flag,
    Fallback(true),
    "of `\"conductor\"` and `\"glass\"`; \
     `false`: what meets several facets is lost, as in many renderers",
);
/// Index of refraction.
pub const IOR: Key<Number, Fallback<f64>> = Key::new(
    "ior",
    Number::Within(*GlassTable::IORS.start(), *GlassTable::IORS.end()),
    Fallback(1.5),
    "of glass and gloss: index of what is behind the front over that of what is before it",
);
pub const GLASS_COLOUR: InputKey = input(
    "colour",
    MapRole::Albedo,
    1.0,
    "of `\"glass\"` and `\"thin-glass\"`: factor on what goes through",
);
pub const GLASS_ROUGHNESS: InputKey = input(
    "roughness",
    MapRole::Roughness,
    0.0,
    "of `\"glass\"` and `\"thin-glass\"`; through thin glass light goes straight on",
);
pub const MIXED: Key<Each<Text, 2>, Required> = Key::new(
    "materials",
    Each { each: Text("name"), form: "[first, second]" },
    Required("of `\"mix\"`"),
    "in `[materials]`, each with its own `normals`; what they emit is not used",
);
pub const SHARE: InputKey = input("share", MapRole::Opacity, 0.5, "of `\"mix\"`: of the second");

/// The models other than the paper's and `"principled"`.
pub const MODELS: Section = Section {
    name: "models",
    table: "materials.NAME",
    keys: &[
        &DIFFUSE_COLOUR,
        &DIFFUSE_ROUGHNESS,
        &METAL,
        &ETA,
        &K,
        &METAL_COLOUR,
        &EDGE,
        &METAL_ROUGHNESS,
        &COMPENSATE,
        &IOR,
        &GLASS_COLOUR,
        &GLASS_ROUGHNESS,
        &MIXED,
        &SHARE,
    ],
};

pub const BASE_COLOUR: InputKey =
    input("base_colour", MapRole::Albedo, 0.5, "of the diffuser, the metal, and what goes through");
pub const SPECULAR_COLOUR: InputKey =
    input("specular_colour", MapRole::Specular, 1.0, "tint of the gloss straight on");
pub const SHEEN: InputKey =
    input("sheen", MapRole::Albedo, 0.0, "colour of fibres that show at grazing angles");
pub const METALLIC: InputKey = input("metallic", MapRole::Metalness, 0.0, "share of metal");
pub const ROUGHNESS: InputKey =
    input("roughness", MapRole::Roughness, 0.5, "of gloss, metal and glass");
pub const BASE_ROUGHNESS: InputKey =
    input("diffuse_roughness", MapRole::Roughness, 0.0, "of the diffuser");
pub const SPECULAR: InputKey = input("specular", MapRole::Specular, 1.0, "factor on the gloss");
pub const TRANSMISSION: InputKey =
    input("transmission", MapRole::Opacity, 0.0, "share of what is no metal that is glass");
pub const OPACITY: InputKey =
    input("opacity", MapRole::Opacity, 1.0, "share of the surface that is there");
pub const COAT: InputKey =
    input("coat", MapRole::Specular, 0.0, "weight of a clear coat of index 1.5");
pub const COAT_ROUGHNESS: InputKey =
    input("coat_roughness", MapRole::Roughness, 0.0, "of the coat");
pub const SHEEN_ROUGHNESS: InputKey =
    input("sheen_roughness", MapRole::Roughness, 0.5, "of the fibres");
pub const THIN: Key<Flag, Fallback<bool>> =
    Key::new("thin", Flag, Fallback(false), "`true`: glass is a sheet");
pub const SET: Key<Form, Optional> = Key::new(
    "set",
    Form("folder, or image"),
    Optional("none"),
    "a [texture set](ASSETS.md) that fills in what is not written, its normals included; \
     `normals = false` leaves those out",
);

/// `model = "principled"`.
pub const PRINCIPLED: Section = Section {
    name: "principled",
    table: "materials.NAME",
    keys: &[
        &BASE_COLOUR,
        &METALLIC,
        &ROUGHNESS,
        &BASE_ROUGHNESS,
        &SPECULAR,
        &SPECULAR_COLOUR,
        &IOR,
        &TRANSMISSION,
        &THIN,
        &OPACITY,
        &COAT,
        &COAT_ROUGHNESS,
        &SHEEN,
        &SHEEN_ROUGHNESS,
        &SET,
    ],
};
