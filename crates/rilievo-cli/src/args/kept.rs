//! The flags of a render that its picture depends on: an unfinished picture keeps those it was begun
//! with, so that `--resume` need not repeat them.

use std::fmt::Display;
use std::str::FromStr;

use clap::ValueEnum;
use rilievo_io::image::Stored;

use super::render::RenderArgs;
use super::value;

/// A flag as text: as it was given, if it was, and how it is given.
struct Kept {
    name: &'static str,
    get: fn(&RenderArgs) -> Option<String>,
    set: fn(&mut RenderArgs, &str) -> Option<()>,
}

const KEPT: [Kept; 18] = [
    Kept {
        name: "samples",
        get: |a| shown(a.samples),
        set: |a, text| put(&mut a.samples, value::samples(text).ok()),
    },
    Kept {
        name: "resolution",
        get: |a| a.resolution.map(|[width, height]| format!("{width}x{height}")),
        set: |a, text| put(&mut a.resolution, value::resolution(text).ok()),
    },
    Kept {
        name: "integrator",
        get: |a| shown(a.integrator),
        set: |a, text| put(&mut a.integrator, read(text)),
    },
    Kept {
        name: "sampler",
        get: |a| shown(a.sampler),
        set: |a, text| put(&mut a.sampler, read(text)),
    },
    Kept {
        name: "clamp",
        get: |a| shown(a.clamp),
        set: |a, text| put(&mut a.clamp, value::clamp(text).ok()),
    },
    Kept {
        name: "lod",
        get: |a| shown(a.lod),
        set: |a, text| put(&mut a.lod, value::lod(text).ok()),
    },
    Kept {
        name: "method",
        get: |a| shown(a.method),
        set: |a, text| put(&mut a.method, read(text)),
    },
    Kept { name: "seed", get: |a| shown(a.seed), set: |a, text| put(&mut a.seed, read(text)) },
    Kept {
        name: "filter",
        get: |a| shown(a.filter),
        set: |a, text| put(&mut a.filter, read(text)),
    },
    Kept {
        name: "filter-radius",
        get: |a| shown(a.filter_radius),
        set: |a, text| put(&mut a.filter_radius, value::filter_radius(text).ok()),
    },
    Kept {
        name: "aov",
        get: |a| {
            let names: Vec<_> = a.aov.iter().map(|aov| aov.name()).collect();
            (!names.is_empty()).then(|| names.join(","))
        },
        set: |a, text| {
            a.aov = text.split(',').map(|name| name.parse().ok()).collect::<Option<_>>()?;
            Some(())
        },
    },
    Kept {
        name: "exr",
        get: |a| {
            a.exr.map(|stored| match stored {
                Stored::Half => "half".to_owned(),
                Stored::Float => "float".to_owned(),
            })
        },
        set: |a, text| {
            let stored = match text {
                "half" => Some(Stored::Half),
                "float" => Some(Stored::Float),
                _ => None,
            };
            put(&mut a.exr, stored)
        },
    },
    Kept {
        name: "tiles",
        get: |a| shown(a.tiles),
        set: |a, text| put(&mut a.tiles, value::tiles(text).ok()),
    },
    Kept {
        name: "denoise",
        get: |a| a.denoise.map(|denoiser| denoiser.name().to_owned()),
        set: |a, text| put(&mut a.denoise, ValueEnum::from_str(text, false).ok()),
    },
    Kept {
        name: "pixel-centers",
        get: |a| a.pixel_centers.then(String::new),
        set: |a, _| {
            a.pixel_centers = true;
            Some(())
        },
    },
    Kept {
        name: "sample-range",
        get: |a| a.part.sample_range.map(|[first, end]| format!("{first}..{end}")),
        set: |a, text| put(&mut a.part.sample_range, value::sample_range(text).ok()),
    },
    Kept {
        name: "crop",
        get: |a| {
            a.part.crop.map(|crop| {
                let ([x, y], [x1, y1]) = (crop.corner, crop.end());
                format!("{x},{y},{x1},{y1}")
            })
        },
        set: |a, text| put(&mut a.part.crop, value::crop(text).ok()),
    },
    Kept {
        name: "max-error",
        get: |a| shown(a.part.max_error),
        set: |a, text| put(&mut a.part.max_error, value::max_error(text).ok()),
    },
];

fn shown<T: Display>(value: Option<T>) -> Option<String> {
    value.map(|value| value.to_string())
}

fn read<T: FromStr>(text: &str) -> Option<T> {
    text.parse().ok()
}

fn put<T>(to: &mut Option<T>, value: Option<T>) -> Option<()> {
    *to = Some(value?);
    Some(())
}

impl RenderArgs {
    /// The flags given that the picture depends on, as `samples=64 aov=P,N`.
    pub fn kept(&self) -> String {
        let given = KEPT
            .iter()
            .filter_map(|flag| (flag.get)(self).map(|value| format!("{}={value}", flag.name)));
        given.collect::<Vec<_>>().join(" ")
    }

    /// The same with flags of a render begun before, where they are not given here.
    ///
    /// # Errors
    /// Says which flag was given another value, or is none.
    pub fn with_kept(mut self, before: &str) -> Result<Self, String> {
        for word in before.split_whitespace() {
            let unknown =
                || format!("it was begun with {word:?}, which is no flag of this program");
            let (name, value) = word.split_once('=').ok_or_else(unknown)?;
            let flag = KEPT.iter().find(|flag| flag.name == name).ok_or_else(unknown)?;
            match (flag.get)(&self) {
                None => (flag.set)(&mut self, value).ok_or_else(unknown)?,
                Some(given) if given == value => {}
                Some(given) => {
                    return Err(format!(
                        "it was begun with --{name} {value}, and --{name} {given} is asked for; \
                         leave the flag out"
                    ));
                }
            }
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::super::{Arguments, Command};
    use super::*;

    fn parsed(flags: &str) -> RenderArgs {
        let line = format!("rilievo render s.toml -o a.exr {flags}");
        match Arguments::try_parse_from(line.split_whitespace()).unwrap().command {
            Command::Render(args) => args,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn every_kept_flag_comes_back() {
        let flags = "--samples 64 --resolution 40x30 --integrator path --sampler jittered \
            --clamp 2.5 --lod=2 --method dda --seed 18446744073709551615 --filter tent \
            --filter-radius 0.75 --aov P,Steps --exr half --tiles 32 --denoise=oidn \
            --pixel-centers --sample-range 3..9 --crop 1,2,30,20 --max-error 0.02";
        let kept = parsed(flags).kept();
        assert_eq!(kept.split(' ').count(), KEPT.len(), "{kept}");
        let again = parsed("").with_kept(&kept).unwrap();
        assert_eq!(again.kept(), kept);
        // Given again they are no contradiction.
        assert_eq!(parsed(flags).with_kept(&kept).unwrap().kept(), kept);
        assert_eq!(parsed("").kept(), "");
        assert!(parsed("").with_kept("").is_ok());
    }

    #[test]
    fn other_values_and_words_that_are_no_flags_are_named() {
        let error = |flags, before| parsed(flags).with_kept(before).unwrap_err();
        assert_eq!(
            error("--samples 8", "samples=4"),
            "it was begun with --samples 4, and --samples 8 is asked for; leave the flag out"
        );
        for before in ["samples", "output=/etc", "samples=many", "aov=P,Q"] {
            assert!(error("", before).contains("no flag"), "{before}");
        }
    }
}
