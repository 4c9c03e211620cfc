//! [`Denoiser`]: which filter takes the noise off a picture.

use clap::ValueEnum;
use rilievo_render::Film;

use crate::outcome::Failure;

/// What takes the noise off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Denoiser {
    /// Non-local means of this program.
    Own,
    /// Intel Open Image Denoise, where the program was built with it.
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

#[cfg(feature = "oidn")]
mod oidn {
    //! The library, linked at build time.

    use oidn::{Device, Error, RayTracing};
    use rilievo_render::{Aov, Film};

    use crate::outcome::Failure;

    fn told(error: &Error) -> Failure {
        let (kind, message) = (error.kind().as_str(), error.message());
        Failure::Refused(format!("Intel Open Image Denoise: {kind}: {message}"))
    }

    pub fn check() -> Result<(), Failure> {
        Device::new().map(drop).map_err(|e| told(&e))
    }

    pub fn run(film: &Film) -> Result<Vec<[f32; 3]>, Failure> {
        let device = Device::new().map_err(|e| told(&e))?;
        let [width, height] = film.resolution().map(|n| n as usize);
        let guide = |aov| film.layer(aov).map_or(&[][..], |layer| layer.values());
        let mut out = vec![[0.0; 3]; film.radiance().len()];
        let mut filter = RayTracing::try_new(&device).map_err(|e| told(&e))?;
        filter
            .hdr(true)
            .image_dimensions(width, height)
            .albedo_normal(guide(Aov::Albedo), guide(Aov::Ns))
            .filter(film.radiance().as_flattened(), out.as_flattened_mut())
            .map_err(|e| told(&e))?;
        for ((out, noisy), done) in out.iter_mut().zip(film.radiance()).zip(film.finished()) {
            if !done {
                *out = *noisy;
            }
        }
        Ok(out)
    }
}

#[cfg(not(feature = "oidn"))]
mod oidn {
    //! What is said where the library is not part of the program.

    use rilievo_render::Film;

    use crate::outcome::Failure;

    const NOT_THERE: &str = "this program was built without Intel Open Image Denoise; take \
        --denoise alone, or build with `--features oidn` and OIDN_DIR naming the library's folder";

    pub fn check() -> Result<(), Failure> {
        Err(Failure::Refused(NOT_THERE.to_owned()))
    }

    pub fn run(_: &Film) -> Result<Vec<[f32; 3]>, Failure> {
        Err(Failure::Refused(NOT_THERE.to_owned()))
    }
}
