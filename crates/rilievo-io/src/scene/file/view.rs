//! `[render]`, and what many tables hold: points and colours.

use rilievo::glam::DVec3;
use rilievo::relief::Method;
use rilievo_render::film::tonemap::{ToneMap, View};
use rilievo_render::{Filter, FilterKind, Integrator, RenderSettings, SamplerKind};

use super::super::syntax::{Table, Value};
use crate::error::Result;

/// Three numbers, in words.
pub(super) const POINT: &str = "three numbers: [x, y, z]";
/// Three channels, in words.
const COLOUR: &str = "three numbers of at least 0: [red, green, blue]";

/// A point or a direction.
pub(super) fn point(value: &Value<'_>) -> Result<DVec3> {
    Ok(DVec3::from_array(value.numbers(POINT)?))
}

/// A linear colour.
pub(super) fn colour(value: &Value<'_>) -> Result<DVec3> {
    let mut rgb = [0.0; 3];
    for (slot, channel) in rgb.iter_mut().zip(value.array::<3>(COLOUR)?) {
        *slot = channel.number_in(0.0.., "a number of at least 0")?;
    }
    Ok(DVec3::from_array(rgb))
}

/// What `[render]` says.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct RenderEntry {
    pub settings: RenderSettings,
    pub background: DVec3,
    pub ambient: DVec3,
    pub tone_map: ToneMap,
    pub method: Method,
    /// Bytes that textures may take.
    pub texture_memory: Option<u64>,
}

impl RenderEntry {
    pub fn read(table: &Table<'_>) -> Result<Self> {
        let mut entry = Self::default();
        let settings = &mut entry.settings;
        if let Some(value) = table.get("integrator") {
            settings.integrator = value.choice(&Integrator::ALL.map(|i| (i.name(), i)))?;
        }
        let (samples, split) = (RenderSettings::MAX_SAMPLES, RenderSettings::MAX_SPLIT);
        for (key, count, range) in [
            ("samples", &mut settings.samples, 1..=samples),
            ("shadow_samples", &mut settings.shadow_samples, 1..=split),
            ("glossy_samples", &mut settings.glossy_samples, 1..=split),
            ("diffuse_samples", &mut settings.diffuse_samples, 0..=split),
            ("max_depth", &mut settings.max_depth, 0..=RenderSettings::MAX_DEPTH),
        ] {
            if let Some(value) = table.get(key) {
                *count = value.integer(range)?;
            }
        }
        if let Some(value) = table.get("clamp") {
            settings.clamp = value.number_in(0.0.., "a number of at least 0")?;
        }
        if let Some(value) = table.get("seed") {
            // TOML's own integers end at 2^63 - 1.
            settings.seed = value.integer(0..=i64::MAX as u64)?;
        }
        if let Some(value) = table.get("sampler") {
            settings.sampler = value.choice(&SamplerKind::ALL.map(|s| (s.name(), s)))?;
        }
        if let Some(value) = table.get("filter") {
            settings.filter = value.choice(&FilterKind::ALL.map(|f| (f.name(), f)))?.into();
        }
        if let Some(value) = table.get("filter_radius") {
            let allowed = "a number of pixels above 0, at most 32";
            settings.filter.radius =
                value.number_in(f64::MIN_POSITIVE..=Filter::MAX_RADIUS, allowed)?;
        }
        if let Some(value) = table.get("background") {
            entry.background = colour(&value)?;
        }
        if let Some(value) = table.get("ambient") {
            entry.ambient = colour(&value)?;
        }
        if let Some(value) = table.get("exposure") {
            let allowed = "a number of stops from -100 to 100";
            entry.tone_map.exposure =
                value.number_in(-ToneMap::MAX_STOPS..=ToneMap::MAX_STOPS, allowed)?;
        }
        if let Some(value) = table.get("view") {
            entry.tone_map.view = value.choice(&View::ALL.map(|v| (v.name(), v)))?;
        }
        if let Some(value) = table.get("method") {
            entry.method = method(&value)?;
        }
        if let Some(value) = table.get("texture_memory") {
            entry.texture_memory = Some(value.integer(1..=1_u64 << 30)? << 20);
        }
        table.finish()?;
        Ok(entry)
    }
}

/// A method, by name.
pub(super) fn method(value: &Value<'_>) -> Result<Method> {
    value.choice(&Method::ALL.map(|m| (m.name(), m)))
}
