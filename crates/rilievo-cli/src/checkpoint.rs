//! [`Checkpoints`]: the picture so far, saved now and then; and going on from it.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use rilievo_io::Limits;
use rilievo_io::film_file::{FilmFile, Header, Remainder};
use rilievo_io::image::Attribute;
use rilievo_render::Film;

use crate::args::value::{PictureFormat, PicturePath};
use crate::args::{RenderArgs, Talk};
use crate::denoise::Denoiser;
use crate::job::RenderJob;
use crate::outcome::Failure;
use crate::picture::Finished;

/// Writes a film as often as asked for.
pub struct Checkpoints<'a> {
    job: &'a RenderJob,
    output: &'a PicturePath,
    talk: Talk,
    /// None: never.
    every: Option<Duration>,
    state: Mutex<State>,
}

struct State {
    /// When the last one was written, or the render begun.
    last: Instant,
    /// One could not be written, and it was said.
    failed: bool,
}

impl<'a> Checkpoints<'a> {
    pub fn new(args: &'a RenderArgs, job: &'a RenderJob) -> Self {
        let every = args.part.checkpoint;
        let asked = args.output.format == PictureFormat::Exr && !every.is_zero();
        Self {
            job,
            output: &args.output,
            talk: args.talk,
            every: asked.then_some(every),
            state: Mutex::new(State { last: Instant::now(), failed: false }),
        }
    }

    /// Writes the film if it is time. The last picture stays where one cannot be written; rendering
    /// goes on all the same.
    pub fn watch(&self, film: &Film) {
        let (Some(every), Ok(mut state)) = (self.every, self.state.try_lock()) else { return };
        if state.failed || state.last.elapsed() < every || film.is_complete() {
            return;
        }
        if let Err(why) = write(film, self.job, None, self.output) {
            self.talk.line(format_args!("warning: no checkpoint was written: {why}"));
            state.failed = true;
        }
        // Writing counts as no time, so that it never takes more than its share.
        state.last = Instant::now();
    }
}

/// Writes a film, with what is needed to go on with it unless it is all of a picture.
///
/// # Errors
/// Of the file.
pub fn write(
    film: &Film,
    job: &RenderJob,
    denoised: Option<(&[[f32; 3]], Denoiser)>,
    output: &PicturePath,
) -> Result<(), rilievo_io::Error> {
    let image = job.scene.camera().resolution();
    let whole = film.is_complete() && !job.is_part();
    let rest = (output.format == PictureFormat::Exr && !whole)
        .then(|| Remainder::of(film, image, &job.fingerprint.to_string(), &job.flags));
    let finished = Finished {
        film,
        kind: &job.kind,
        tone_map: job.tone_map,
        denoised,
        stored: job.stored,
        blocks: job.blocks,
        about: job.about(),
        remainder: rest.as_ref(),
    };
    finished.write(output)
}

/// The flags with those of the render that is gone on with, if it is.
///
/// # Errors
/// Of the file; [`Failure::Refused`] for flags that it was not begun with.
pub fn with_flags_before(args: &RenderArgs) -> Result<RenderArgs, Failure> {
    let (args, path) = (args.clone(), &args.output.path);
    if !args.part.resume || !path.exists() {
        return Ok(args);
    }
    let before = Header::read(path, &Limits::default())?;
    match before.as_ref().and_then(|header| header.attribute(Remainder::FLAGS)) {
        Some(Attribute::Text(flags)) => args
            .with_kept(flags)
            .map_err(|why| Failure::Refused(format!("{}: {why}", path.display()))),
        _ => Ok(args),
    }
}

/// What there is to go on from.
pub enum Before {
    /// Nothing: the render begins.
    Nothing,
    /// A part of the film.
    Film(Film),
    /// The whole picture.
    Picture,
}

/// Looks for an unfinished picture of this render under the name of the output.
///
/// # Errors
/// Of the file; [`Failure::Refused`] for a picture of another render.
pub fn before(args: &RenderArgs, job: &RenderJob) -> Result<Before, Failure> {
    let path = &args.output.path;
    if !args.part.resume || !path.exists() {
        return Ok(Before::Nothing);
    }
    let refuse =
        |why: &str| Err(Failure::Refused(format!("{}: {why}; write another file", path.display())));
    let limits = Limits::default();
    let asked = rilievo_render::check(&job.scene, &job.options()).map_err(Failure::refused)?;
    let Some(file) = FilmFile::read(path, &limits)? else {
        let picture = Header::read(path, &limits)?;
        let about = job.about().attributes(true, args.denoise);
        let same = picture.is_some_and(|picture| {
            about.iter().all(|(name, value)| picture.attribute(name) == Some(value))
                && picture.size == asked.0.size
        });
        return match same && !job.is_part() {
            true => Ok(Before::Picture),
            false => refuse("no unfinished picture of this render"),
        };
    };
    if file.fingerprint != job.fingerprint.to_string() {
        return refuse("a picture of another scene, or with other settings or another seed");
    }
    if (file.film.window(), file.film.samples()) != asked {
        return refuse("another part of this render");
    }
    Ok(Before::Film(file.film))
}
