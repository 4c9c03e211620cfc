//! [`RenderSettings`]: how a scene asks to be rendered.

use crate::film::filter::Filter;
use crate::integrator::Integrator;
use crate::sampler::SamplerKind;

/// How a scene asks to be rendered. [`super::Scene`] holds a checked copy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// What is estimated.
    pub integrator: Integrator,
    /// Camera rays per pixel, 1 to [`Self::MAX_SAMPLES`].
    pub samples: u32,
    /// Shadow rays per light and hit, 1 to [`Self::MAX_SPLIT`].
    pub shadow_samples: u32,
    /// Reflection rays at a glossy first hit, 1 to [`Self::MAX_SPLIT`].
    pub glossy_samples: u32,
    /// Bounce rays at a diffuse first hit, at most [`Self::MAX_SPLIT`]; 0 leaves diffuse
    /// interreflection out.
    pub diffuse_samples: u32,
    /// Bounces after the first hit, at most [`Self::MAX_DEPTH`]; 0 is emission and direct light.
    pub max_depth: u32,
    /// Largest channel of the radiance that one path of the path integrator may bring from beyond its
    /// direct light; 0 leaves it alone. A number above 0 takes bright specks away, and energy with them.
    pub clamp: f64,
    /// Width of what a camera ray stands for, in pixels, at most [`Self::MAX_LOD`]: reliefs whose cells are
    /// smaller there are traced at a coarser level of their maps. 0 traces the full maps everywhere.
    pub lod: f64,
    /// Seed of every random choice.
    pub seed: u64,
    /// Where the numbers of paths come from; the distributed integrator always takes its strata.
    pub sampler: SamplerKind,
    /// Pixel filter.
    pub filter: Filter,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Why settings were refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{setting} is {found}; {min} to {max} are allowed")]
pub struct SettingsError {
    /// The name of the setting.
    pub setting: &'static str,
    /// The value found.
    pub found: f64,
    /// The smallest value allowed.
    pub min: f64,
    /// The largest value allowed.
    pub max: f64,
}

impl RenderSettings {
    /// What holds where nothing is asked for.
    pub const DEFAULT: Self = Self {
        integrator: Integrator::Distributed,
        samples: 16,
        shadow_samples: 4,
        glossy_samples: 4,
        diffuse_samples: 0,
        max_depth: 5,
        clamp: 0.0,
        lod: 0.0,
        seed: 0,
        sampler: SamplerKind::Sobol,
        filter: Filter::BOX,
    };
    /// Most camera rays per pixel.
    pub const MAX_SAMPLES: u32 = 1 << 20;
    /// Most shadow, reflection or bounce rays per hit.
    pub const MAX_SPLIT: u32 = 1 << 12;
    /// Most bounces: the recursion must fit a thread's stack.
    pub const MAX_DEPTH: u32 = 256;

    /// Widest camera ray, in pixels.
    pub const MAX_LOD: f64 = 64.0;

    /// Checks every count.
    ///
    /// # Errors
    /// [`SettingsError`] names the first count that is out of range.
    pub fn check(&self) -> Result<(), SettingsError> {
        let within = |setting, found: u32, min: u32, max: u32| {
            let [found, min, max] = [found, min, max].map(f64::from);
            if (min..=max).contains(&found) {
                Ok(())
            } else {
                Err(SettingsError { setting, found, min, max })
            }
        };
        within("samples", self.samples, 1, Self::MAX_SAMPLES)?;
        within("shadow_samples", self.shadow_samples, 1, Self::MAX_SPLIT)?;
        within("glossy_samples", self.glossy_samples, 1, Self::MAX_SPLIT)?;
        within("diffuse_samples", self.diffuse_samples, 0, Self::MAX_SPLIT)?;
        within("max_depth", self.max_depth, 0, Self::MAX_DEPTH)?;
        let (found, max) = (self.lod, Self::MAX_LOD);
        if !(0.0..=max).contains(&found) {
            return Err(SettingsError { setting: "lod", found, min: 0.0, max });
        }
        let (found, max) = (self.filter.radius, Filter::MAX_RADIUS);
        if found > 0.0 && found <= max {
            Ok(())
        } else {
            Err(SettingsError { setting: "filter_radius", found, min: 0.0, max })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_out_of_range_are_named() {
        assert_eq!(RenderSettings::default().check(), Ok(()));
        let none = RenderSettings { samples: 0, ..RenderSettings::default() };
        assert_eq!(none.check().unwrap_err().setting, "samples");
        for lod in [-1.0, f64::NAN, 65.0] {
            let settings = RenderSettings { lod, ..RenderSettings::default() };
            assert_eq!(settings.check().unwrap_err().setting, "lod");
        }
        let deep = RenderSettings { max_depth: 257, ..RenderSettings::default() };
        let message = deep.check().unwrap_err().to_string();
        assert_eq!(message, "max_depth is 257; 0 to 256 are allowed");
        for radius in [0.0, -1.0, f64::NAN, 33.0] {
            let wide = Filter { radius, ..Filter::BOX };
            let settings = RenderSettings { filter: wide, ..RenderSettings::default() };
            assert_eq!(settings.check().unwrap_err().setting, "filter_radius");
        }
    }
}
