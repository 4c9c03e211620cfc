//! Intel Open Image Denoise, in a program of its own: `rilievo-oidn`, built with the feature `oidn`.
//!
//! A program that is linked against a library does not begin without it, and what the system then says
//! helps nobody. So `rilievo` itself is not linked against it: it asks the program beside it, and says
//! what is missing where that does not answer. Numbers go through pipes as the machine holds them:
//! width and height (u32), then radiance, albedo and normals (f32, three a pixel); back comes radiance.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use rilievo_render::{Aov, Film};

use crate::outcome::Failure;

const NOT_BUILT: &str = "this program was built without Intel Open Image Denoise; take --denoise \
    alone, or build with `--features oidn` and OIDN_DIR naming the library's folder";

const NOT_FOUND: &str = "the library of Intel Open Image Denoise is not found; put its folder into \
    LD_LIBRARY_PATH (PATH on Windows, DYLD_LIBRARY_PATH on macOS), or take --denoise alone";

/// Says so before rendering if the filter is not there.
pub fn check() -> Result<(), Failure> {
    ask(&program()?, &["--check"], Vec::new()).map(drop)
}

/// The radiance of a film with less noise.
pub fn run(film: &Film) -> Result<Vec<[f32; 3]>, Failure> {
    let mut bytes: Vec<u8> = film.resolution().iter().flat_map(|n| n.to_le_bytes()).collect();
    let guide = |aov| film.layer(aov).map_or(&[][..], |layer| layer.values());
    let planes = [film.radiance().as_flattened(), guide(Aov::Albedo), guide(Aov::Ns)];
    bytes.extend(planes.iter().copied().flatten().flat_map(|value| value.to_le_bytes()));
    let told = ask(&program()?, &[], bytes)?;
    let values = told.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
    let values: Vec<f32> = values.collect();
    let (pixels, rest) = values.as_chunks::<3>();
    if pixels.len() != film.radiance().len() || !rest.is_empty() {
        return Err(Failure::Refused("Intel Open Image Denoise gave no picture".to_owned()));
    }
    let mut out = pixels.to_vec();
    for ((out, noisy), done) in out.iter_mut().zip(film.radiance()).zip(film.finished()) {
        if !done {
            *out = *noisy;
        }
    }
    Ok(out)
}

/// The program, beside this one.
fn program() -> Result<PathBuf, Failure> {
    let own = std::env::current_exe().map_err(Failure::refused)?;
    let path = own.with_file_name(format!("rilievo-oidn{}", std::env::consts::EXE_SUFFIX));
    if path.exists() { Ok(path) } else { Err(Failure::Refused(NOT_BUILT.to_owned())) }
}

/// What a program answers to `input`.
fn ask(program: &Path, flags: &[&str], input: Vec<u8>) -> Result<Vec<u8>, Failure> {
    let started = Command::new(program)
        .args(flags)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let failed = |why: std::io::Error| Failure::Refused(format!("{}: {why}", program.display()));
    let mut child = started.map_err(failed)?;
    // It reads all before it answers. If it ends before that, its status tells why.
    if let Some(mut pipe) = child.stdin.take() {
        let _ = pipe.write_all(&input);
    }
    judged(child.wait_with_output().map_err(failed)?)
}

/// The answer of a program that has ended. A linked program whose library is missing never begins: it
/// ends with a status that it cannot give itself.
fn judged(output: Output) -> Result<Vec<u8>, Failure> {
    let said = String::from_utf8_lossy(&output.stderr);
    match output.status.code() {
        Some(0) => Ok(output.stdout),
        Some(1) => Err(Failure::Refused(format!("Intel Open Image Denoise: {}", said.trim()))),
        _ => Err(Failure::Refused(NOT_FOUND.to_owned())),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_is_said_in_own_words() {
        let run = |script: &str, input: &[u8]| {
            ask(Path::new("/bin/sh"), &["-c", script], input.to_vec()).map_err(|e| e.to_string())
        };
        assert_eq!(run("cat", b"1234"), Ok(b"1234".to_vec()));
        let loader = "echo error while loading shared libraries: libOpen >&2; exit 127";
        let missing = run(loader, &[0; 1 << 20]).unwrap_err();
        assert!(missing.contains("LD_LIBRARY_PATH") && !missing.contains("loading"), "{missing}");
        let refused = run("echo no device >&2; exit 1", b"").unwrap_err();
        assert!(refused.contains("Intel Open Image Denoise: no device"), "{refused}");
        assert!(ask(Path::new("/no/such"), &[], Vec::new()).is_err());
    }
}
