//! `[render]`.

use rilievo::glam::DVec3;
use rilievo::relief::Method;
use rilievo_render::film::tonemap::ToneMap;
use rilievo_render::{Filter, RenderSettings};

use super::super::keys::render as keys;
use super::super::syntax::Table;
use crate::error::Result;

/// What `[render]` says.
#[derive(Clone, Copy, Debug)]
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
        let settings = RenderSettings {
            integrator: keys::INTEGRATOR.of(table)?,
            samples: keys::SAMPLES.of(table)?,
            shadow_samples: keys::SHADOW_SAMPLES.of(table)?,
            glossy_samples: keys::GLOSSY_SAMPLES.of(table)?,
            diffuse_samples: keys::DIFFUSE_SAMPLES.of(table)?,
            max_depth: keys::MAX_DEPTH.of(table)?,
            clamp: keys::CLAMP.of(table)?,
            lod: keys::LOD.of(table)?,
            seed: keys::SEED.of(table)?,
            sampler: keys::SAMPLER.of(table)?,
            filter: read_filter(table)?,
        };
        let entry = Self {
            settings,
            background: keys::BACKGROUND.of(table)?,
            ambient: keys::AMBIENT.of(table)?,
            tone_map: ToneMap { exposure: keys::EXPOSURE.of(table)?, view: keys::VIEW.of(table)? },
            method: keys::METHOD.of(table)?,
            texture_memory: keys::TEXTURE_MEMORY.of(table)?.map(|mebibytes| mebibytes << 20),
        };
        table.finish()?;
        Ok(entry)
    }
}

fn read_filter(table: &Table<'_>) -> Result<Filter> {
    let mut filter = Filter::from(keys::FILTER.of(table)?);
    if let Some(radius) = keys::FILTER_RADIUS.of(table)? {
        filter.radius = radius;
    }
    Ok(filter)
}
