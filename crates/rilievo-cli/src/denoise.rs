//! [`Denoiser`]: which filter takes the noise off a picture.

mod oidn;

use clap::ValueEnum;
use rilievo_render::Film;

use crate::outcome::Failure;

/// What takes the noise off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Denoiser {
    /// Non-local means of this program.
    Own,
    /// Intel Open Image Denoise, where the program was built with it and its library is there.
    Oidn,
}

impl Denoiser {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Oidn => "oidn",
        }
    }

    /// Says so before rendering if the filter is not there.
    ///
    /// # Errors
    /// [`Failure::Refused`].
    pub fn check(self) -> Result<(), Failure> {
        match self {
            Self::Own => Ok(()),
            Self::Oidn => oidn::check(),
        }
    }

    /// The radiance of a film with less noise, on `threads` threads, 0 for one a processor.
    ///
    /// # Errors
    /// [`Failure::Refused`] with the reason.
    pub fn run(self, film: &Film, threads: usize) -> Result<Vec<[f32; 3]>, Failure> {
        match self {
            Self::Own => {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                let pool = pool.map_err(Failure::refused)?;
                pool.install(|| rilievo_render::denoise::denoise(film)).map_err(Failure::refused)
            }
            Self::Oidn => oidn::run(film),
        }
    }
}
