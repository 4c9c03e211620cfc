//! [`LiveView`]: the picture in the viewer tev while it is rendered.
//!
//! Rendering does not wait for the viewer: a thread of its own sends what has changed, and while it
//! does, newer states of the picture are passed over. A viewer that is not there or goes away is said
//! once, and rendering goes on.

use std::sync::Mutex;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rilievo_io::tev::TevImage;
use rilievo_render::Film;

use crate::args::Talk;

/// Time between two states that are shown.
const EVERY: Duration = Duration::from_millis(250);

type Pixels = Vec<[f32; 3]>;

/// A picture open in a viewer, or not.
pub struct LiveView(Option<Open>);

struct Open {
    sender: SyncSender<Pixels>,
    sending: JoinHandle<()>,
    /// When the last state was taken.
    last: Mutex<Instant>,
}

impl LiveView {
    /// Opens an image of so many pixels in the viewer at `address`, if there is an address.
    pub fn open(address: Option<&str>, name: &str, size: [u32; 2], talk: Talk) -> Self {
        let Some(address) = address else { return Self(None) };
        let mut image = match TevImage::open(address, name, size) {
            Ok(image) => image,
            Err(error) => {
                talk.line(format_args!(
                    "note: no viewer at {address} ({error}); start tev there to watch"
                ));
                return Self(None);
            }
        };
        let address = address.to_owned();
        // One state waits while another is sent.
        let (sender, states) = sync_channel::<Pixels>(1);
        let sending = std::thread::spawn(move || {
            for pixels in states {
                if let Err(error) = image.update(&pixels) {
                    talk.line(format_args!("note: the viewer at {address} has gone ({error})"));
                    return;
                }
            }
        });
        Self(Some(Open { sender, sending, last: Mutex::new(Instant::now()) }))
    }

    /// Shows a film on its way, unless one was shown a moment ago.
    pub fn watch(&self, film: &Film) {
        let Some(open) = &self.0 else { return };
        // Whoever finds the lock taken has nothing newer to show.
        let Ok(mut last) = open.last.try_lock() else { return };
        if last.elapsed() >= EVERY {
            *last = Instant::now();
            // A viewer still at the last but one state passes this one over.
            let _ = open.sender.try_send(film.radiance().to_vec());
        }
    }

    /// Shows the picture as it is kept, and waits until it is.
    pub fn close(self, pixels: &[[f32; 3]]) {
        let Some(Open { sender, sending, .. }) = self.0 else { return };
        // If the viewer has gone, that was said.
        let _ = sender.send(pixels.to_vec());
        drop(sender);
        let _ = sending.join();
    }
}
