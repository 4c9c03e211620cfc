//! The window: panels at the left, the picture beside them, a line of text below.

mod canvas;
mod hand;
mod panels;
mod picture;
mod saving;
mod state;

use std::io::Write;
use std::path::Path;
use std::thread::JoinHandle;
use std::time::Instant;

use eframe::egui;
use rilievo_io::scene::SceneFile;
use rilievo_viewer::studio::Studio;

use crate::args::Arguments;
use crate::journal::Journal;
use state::Viewer;

/// What can be shown, before there is a window.
pub struct Opened {
    pub studio: Studio,
    pub file: SceneFile,
    /// Whether it presents a map, a folder or a model.
    pub bare: bool,
    /// What it is compared with.
    pub other: Option<(SceneFile, bool)>,
}

/// Reads everything once: what is wrong is found now, and the window finds it in the cache.
fn open(arguments: &Arguments) -> rilievo_io::Result<Opened> {
    let studio = Studio::default();
    let (file, bare) = studio.open(&arguments.scene)?;
    let shown = studio.load(&file, None)?;
    for note in &shown.notes {
        let _ = writeln!(std::io::stderr(), "note: {note}");
    }
    let read = |path: &Path| {
        let (file, bare) = studio.open(path)?;
        studio.load(&file, None)?;
        Ok::<_, rilievo_io::Error>((file, bare))
    };
    let other = arguments.compare.as_deref().map(read).transpose()?;
    Ok(Opened { studio, file, bare, other })
}

/// Shows the window until it is closed; or says why there is none.
pub fn run(arguments: Arguments, started: Instant) -> Result<(), String> {
    let [width, height] = arguments.window.map(|n| n as f32);
    let title = format!("{} - rilievo", arguments.scene.display());
    let options = eframe::NativeOptions {
        viewport: egui::ViewportBuilder::default().with_inner_size([width, height]),
        ..eframe::NativeOptions::default()
    };
    let what = arguments.scene.clone();
    let reading: JoinHandle<_> = std::thread::spawn(move || {
        let opened = open(&arguments);
        (arguments, opened)
    });
    // Joined where the window needs it, or here if there never was one.
    let slot = std::sync::Arc::new(std::sync::Mutex::new(Some(reading)));
    let theirs = std::sync::Arc::clone(&slot);
    let take = |slot: &std::sync::Mutex<Option<JoinHandle<_>>>| {
        let handle = slot.lock().ok().and_then(|mut slot| slot.take());
        handle.and_then(|handle: JoinHandle<(Arguments, rilievo_io::Result<Opened>)>| {
            handle.join().ok()
        })
    };
    let result = eframe::run_native(
        &title,
        options,
        Box::new(move |creation| {
            let gone = || format!("{}: could not be read", what.display());
            let (arguments, opened) = take(&theirs).ok_or_else(gone)?;
            let opened = opened.map_err(|e| Refused(e.to_string()))?;
            let journal = Journal::new(arguments.journal, started);
            Ok(Box::new(Viewer::new(&creation.egui_ctx, arguments, opened, journal)))
        }),
    );
    let Err(error) = result else { return Ok(()) };
    if let eframe::Error::AppCreation(why) = &error
        && let Some(Refused(why)) = why.downcast_ref()
    {
        return Err(why.clone());
    }
    // No window, but the input may be wrong too: that comes first.
    if let Some((_, Err(e))) = take(&slot) {
        return Err(e.to_string());
    }
    Err(format!(
        "no window can be opened: {error}\n\
         a display is needed (on Linux an X server, named by DISPLAY) and Vulkan, Metal or Direct3D 12 \
         (Mesa's llvmpipe is enough); `rilievo render` needs neither"
    ))
}

/// What was to be shown cannot be.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Refused(String);
