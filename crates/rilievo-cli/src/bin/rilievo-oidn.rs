//! `rilievo-oidn`: what `rilievo --denoise=oidn` asks to take the noise off a picture with Intel Open
//! Image Denoise. It alone is linked against that library; see `denoise/oidn.rs` for what goes through
//! its pipes. Exit codes: 0 done, 1 refused, with the reason on standard error.

#![forbid(unsafe_code)]

use std::io::{Read, Write};
use std::process::ExitCode;

use oidn::{Device, Error, RayTracing};

fn main() -> ExitCode {
    let checks = std::env::args().nth(1).is_some_and(|flag| flag == "--check");
    match if checks { device().map(drop) } else { run() } {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            let _ = writeln!(std::io::stderr(), "{why}");
            ExitCode::FAILURE
        }
    }
}

fn told(error: &Error) -> String {
    format!("{}: {}", error.kind().as_str(), error.message())
}

fn device() -> Result<Device, String> {
    Device::new().map_err(|e| told(&e))
}

fn run() -> Result<(), String> {
    let mut bytes = Vec::new();
    std::io::stdin().read_to_end(&mut bytes).map_err(|e| e.to_string())?;
    let (words, _) = bytes.as_chunks::<4>();
    let [width, height, samples @ ..] = words else { return Err("no picture".to_owned()) };
    let [width, height] = [width, height].map(|word| u32::from_le_bytes(*word) as usize);
    let samples: Vec<f32> = samples.iter().map(|word| f32::from_le_bytes(*word)).collect();
    let plane = width.checked_mul(height).and_then(|pixels| pixels.checked_mul(3));
    let Some(plane) = plane.filter(|plane| plane.checked_mul(3) == Some(samples.len())) else {
        return Err(format!("{} numbers of {width} x {height} pixels", samples.len()));
    };
    let (radiance, guides) = samples.split_at(plane);
    let (albedo, normals) = guides.split_at(plane);
    let mut out = vec![0.0_f32; plane];
    let device = device()?;
    let mut filter = RayTracing::try_new(&device).map_err(|e| told(&e))?;
    filter
        .hdr(true)
        .image_dimensions(width, height)
        .albedo_normal(albedo, normals)
        .filter(radiance, &mut out)
        .map_err(|e| told(&e))?;
    let bytes: Vec<u8> = out.iter().flat_map(|value| value.to_le_bytes()).collect();
    std::io::stdout().write_all(&bytes).map_err(|e| e.to_string())
}
