//! `[render]`.

use rilievo::glam::DVec3;
use rilievo::relief::Method;
use rilievo_render::film::tonemap::{ToneMap, View};
use rilievo_render::{Filter, FilterKind, Integrator, RenderSettings, SamplerKind};

use super::kind::{Choice, Colour, Integer, Number};
use super::{Fallback, Key, Optional, Section};

/// What the renderer takes by itself.
const DEFAULT: RenderSettings = RenderSettings::DEFAULT;

/// How rays walk a displaced surface.
const METHODS: Choice<Method> = Choice(|| Method::ALL.map(|m| (m.name(), m)).into());

pub const INTEGRATOR: Key<Choice<Integrator>, Fallback<Integrator>> = Key::new(
    "integrator",
    Choice(|| Integrator::ALL.map(|i| (i.name(), i)).into()),
    Fallback(DEFAULT.integrator),
    "what is estimated, see below",
);
pub const SAMPLES: Key<Integer<u32>, Fallback<u32>> = Key::new(
    "samples",
    Integer::within(1, RenderSettings::MAX_SAMPLES),
    Fallback(DEFAULT.samples),
    "camera rays a pixel",
);
pub const SHADOW_SAMPLES: Key<Integer<u32>, Fallback<u32>> = Key::new(
    "shadow_samples",
    Integer::within(1, RenderSettings::MAX_SPLIT),
    Fallback(DEFAULT.shadow_samples),
    "a light and hit",
);
pub const GLOSSY_SAMPLES: Key<Integer<u32>, Fallback<u32>> = Key::new(
    "glossy_samples",
    Integer::within(1, RenderSettings::MAX_SPLIT),
    Fallback(DEFAULT.glossy_samples),
    "a glossy hit",
);
pub const DIFFUSE_SAMPLES: Key<Integer<u32>, Fallback<u32>> = Key::new(
    "diffuse_samples",
    Integer::within(0, RenderSettings::MAX_SPLIT),
    Fallback(DEFAULT.diffuse_samples),
    "a diffuse hit; 0: no diffuse interreflection",
);
pub const MAX_DEPTH: Key<Integer<u32>, Fallback<u32>> = Key::new(
    "max_depth",
    Integer::within(0, RenderSettings::MAX_DEPTH),
    Fallback(DEFAULT.max_depth),
    "bounces after the first hit; 0 is emission and direct light",
);
pub const CLAMP: Key<Number, Fallback<f64>> = Key::new(
    "clamp",
    Number::AtLeast(0.0),
    Fallback(DEFAULT.clamp),
    "of `path`; 0: nothing is clamped",
)
.unit("W/(sr m^2)");
pub const LOD: Key<Number, Fallback<f64>> = Key::new(
    "lod",
    Number::Within(0.0, RenderSettings::MAX_LOD),
    Fallback(DEFAULT.lod),
    "level of detail: what a camera ray stands for, 1 is a pixel; 0: full maps everywhere; see below",
)
.unit("pixels");
pub const SEED: Key<Integer<u64>, Fallback<u64>> =
    Key::new("seed", Integer::SEED, Fallback(DEFAULT.seed), "of every random choice");
pub const SAMPLER: Key<Choice<SamplerKind>, Fallback<SamplerKind>> = Key::new(
    "sampler",
    Choice(|| SamplerKind::ALL.map(|s| (s.name(), s)).into()),
    Fallback(DEFAULT.sampler),
    "of the integrator `path`; `distributed` takes strata",
);
pub const FILTER: Key<Choice<FilterKind>, Fallback<FilterKind>> = Key::new(
    "filter",
    Choice(|| FilterKind::ALL.map(|f| (f.name(), f)).into()),
    Fallback(DEFAULT.filter.kind),
    "of the pixels",
);
pub const FILTER_RADIUS: Key<Number, Optional> = Key::new(
    "filter_radius",
    Number::AboveUpTo(0.0, Filter::MAX_RADIUS),
    Optional("0.5, 1, 1.5, 2, 1.5 by `filter`"),
    "the filter is stretched to it",
)
.unit("pixels");
pub const BACKGROUND: Key<Colour, Fallback<DVec3>> =
    Key::new("background", Colour::Any, Fallback(DVec3::ZERO), "what rays see that meet nothing")
        .unit("W/(sr m^2)");
pub const AMBIENT: Key<Colour, Fallback<DVec3>> =
    Key::new("ambient", Colour::Any, Fallback(DVec3::ZERO), "times the diffuse reflectance")
        .unit("W/(sr m^2)");
pub const EXPOSURE: Key<Number, Fallback<f64>> = Key::new(
    "exposure",
    Number::Within(-ToneMap::MAX_STOPS, ToneMap::MAX_STOPS),
    Fallback(0.0),
    "in PNG only",
)
.unit("stops");
pub const VIEW: Key<Choice<View>, Fallback<View>> = Key::new(
    "view",
    Choice(|| View::ALL.map(|v| (v.name(), v)).into()),
    Fallback(View::Srgb),
    "in PNG only; `\"srgb\"`: as it is, cut off at white; the others: see below",
);
pub const METHOD: Key<Choice<Method>, Fallback<Method>> =
    Key::new("method", METHODS, Fallback(Method::Pyramid), "for every displaced shape, see below");
pub const TEXTURE_MEMORY: Key<Integer<u64>, Optional> = Key::new(
    "texture_memory",
    Integer::within(1, 1 << 30),
    Optional("no limit"),
    "of textures; those that do not fit lie in a temporary file, and the picture is the same",
)
.unit("MiB");

/// `[render]`.
pub const RENDER: Section = Section {
    name: "render",
    table: "render",
    keys: &[
        &INTEGRATOR,
        &SAMPLES,
        &SHADOW_SAMPLES,
        &GLOSSY_SAMPLES,
        &DIFFUSE_SAMPLES,
        &MAX_DEPTH,
        &CLAMP,
        &LOD,
        &SEED,
        &SAMPLER,
        &FILTER,
        &FILTER_RADIUS,
        &BACKGROUND,
        &AMBIENT,
        &EXPOSURE,
        &VIEW,
        &METHOD,
        &TEXTURE_MEMORY,
    ],
};

/// `method` of a shape.
pub const METHOD_OF_SHAPE: Key<Choice<Method>, Optional> =
    Key::new("method", METHODS, Optional("that of `[render]`"), "of a displaced shape; see there");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_in_words_are_the_filters_own() {
        let radii = FilterKind::ALL.map(|kind| Filter::from(kind).radius.to_string()).join(", ");
        assert_eq!(FILTER_RADIUS.missing.0, format!("{radii} by `filter`"));
        assert_eq!(Method::default(), METHOD.missing.0);
        let tone_map = ToneMap { exposure: EXPOSURE.missing.0, view: VIEW.missing.0 };
        assert_eq!(tone_map, ToneMap::default());
    }
}
