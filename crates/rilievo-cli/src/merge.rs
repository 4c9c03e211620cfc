//! `rilievo merge`: parts of a render into the picture of one run.

use std::path::Path;

use rilievo_io::Limits;
use rilievo_io::film_file::{FilmFile, Remainder};
use rilievo_io::image::{Attribute, Blocks, Stored};
use rilievo_render::denoise;
use rilievo_render::film::{Film, JoinError, Tile, join};
use serde::Serialize;

use crate::args::MergeArgs;
use crate::denoise::Denoiser;
use crate::outcome::{Failure, Outcome};
use crate::picture::{DENOISER, NOISY, denoiser_attribute, exr};

/// The JSON object.
#[derive(Serialize)]
struct Report {
    parts: usize,
    width: u32,
    height: u32,
    /// Absolute indices of the samples: the first and the first beyond.
    samples: [u32; 2],
    /// Whether it is all of the render.
    complete: bool,
    output: String,
}

pub fn run(args: &MergeArgs) -> Result<Outcome, Failure> {
    let mut files = Vec::with_capacity(args.parts.len());
    for path in &args.parts {
        files.push(read(path)?);
    }
    let first = files.first().ok_or_else(|| Failure::Usage("no parts".to_owned()))?;
    for (file, path) in files.iter().zip(&args.parts) {
        if (&file.fingerprint, file.image) != (&first.fingerprint, first.image) {
            return Err(Failure::Refused(format!(
                "{} and {} are of different renders: scene, files, settings or seed are not the same",
                args.parts[0].display(),
                path.display()
            )));
        }
    }
    let (image, fingerprint, colour) = (first.image, first.fingerprint.clone(), first.colour);
    let mut attributes = first.attributes.clone();
    let film = join(files.into_iter().map(|file| file.film).collect())
        .map_err(|why| refused(&why, &args.parts))?;
    let samples = attributes.iter().find(|(name, _)| name == "samplesPerPixel");
    let complete = film.window() == Tile::whole(image)
        && samples.is_some_and(|(_, count)| match count {
            Attribute::Integer(count) => film.samples() == [0, count.unsigned_abs()],
            _ => false,
        });
    let denoised = match args.denoise {
        Some(denoiser) => Some((denoise(&film, colour, denoiser)?, denoiser)),
        None => None,
    };
    attributes.retain(|(name, _)| name != DENOISER);
    attributes.extend(denoised.as_ref().map(|(_, by)| denoiser_attribute(*by)));
    attributes.sort_by(|a, b| a.0.cmp(&b.0));
    let rest = (!complete).then(|| Remainder::of(&film, image, &fingerprint, ""));
    let radiance = denoised.as_ref().map_or(film.radiance(), |(radiance, _)| radiance);
    let stored = if complete { args.exr } else { Stored::Float };
    let mut picture = exr(&film, colour.then_some(radiance), stored, image);
    if denoised.is_some() {
        picture.push_interleaved(&NOISY, film.radiance().as_flattened(), stored);
    }
    picture.blocks = args.tiles.map_or(Blocks::Lines, Blocks::Tiles);
    picture.attributes = attributes;
    if let Some(rest) = &rest {
        rest.add_to(&mut picture);
    }
    picture.write_exr(&args.output.0)?;
    let [width, height] = film.resolution();
    let report = Report {
        parts: args.parts.len(),
        width,
        height,
        samples: film.samples(),
        complete,
        output: args.output.0.display().to_string(),
    };
    let what = if complete { "all of the render" } else { "a part of the render" };
    let [from, to] = report.samples;
    args.talk.line(format_args!(
        "{width} x {height} pixels, samples {from} to {to}: {what}; wrote {}",
        report.output
    ));
    args.talk.object(&report)?;
    Ok(Outcome::Done)
}

/// The radiance of a film with less noise.
fn denoise(film: &Film, colour: bool, denoiser: Denoiser) -> Result<Vec<[f32; 3]>, Failure> {
    denoiser.check()?;
    if !colour {
        return Err(Failure::Refused("parts of layers alone have no noise to take off".into()));
    }
    if let Some(lacking) = denoise::GUIDES.iter().find(|guide| film.layer(**guide).is_none()) {
        return Err(Failure::Refused(format!(
            "--denoise needs the layer {lacking}, which the parts lack; render them with --denoise \
             or --aov Albedo,Ns"
        )));
    }
    denoiser.run(film, 0)
}

fn read(path: &Path) -> Result<FilmFile, Failure> {
    FilmFile::read(path, &Limits::default())?.ok_or_else(|| {
        Failure::Refused(format!(
            "{}: no part of a render; render --sample-range and render --crop write parts",
            path.display()
        ))
    })
}

/// Names the files that do not fit.
fn refused(why: &JoinError, parts: &[std::path::PathBuf]) -> Failure {
    let name = |at: usize| parts[at].display();
    Failure::Refused(match why {
        JoinError::Unfinished { film } => {
            format!("{}: unfinished; go on with it by render --resume first", name(*film))
        }
        JoinError::Layers { films: [a, b] } => {
            format!("{} and {} do not hold the same layers", name(*a), name(*b))
        }
        JoinError::Overlap { films: [a, b], pixel: [x, y], sample } => format!(
            "{} and {} overlap: both have sample {sample} of pixel ({x}, {y})",
            name(*a),
            name(*b)
        ),
        JoinError::Gap { pixel: [x, y], sample } => {
            format!("the parts leave a gap: none has sample {sample} of pixel ({x}, {y})")
        }
        JoinError::None | JoinError::Film(_) => why.to_string(),
    })
}
