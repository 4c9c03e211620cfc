//! [`Journal`]: what happens, a JSON object a line on standard output, for scripts and measurements.

use std::collections::HashMap;
use std::io::Write;
use std::time::{Duration, Instant};

use eframe::egui::Rect;
use rilievo_viewer::worker::Event;

/// Tells or is silent.
pub struct Journal {
    tells: bool,
    started: Instant,
    widgets: HashMap<&'static str, [i32; 4]>,
}

impl Journal {
    pub fn new(tells: bool, started: Instant) -> Self {
        Self { tells, started, widgets: HashMap::new() }
    }

    fn line(&self, event: &str, rest: std::fmt::Arguments<'_>) {
        if self.tells {
            let at = millis(self.started.elapsed());
            let mut out = std::io::stdout().lock();
            // A reader that went away is no reason to stop.
            let _ = writeln!(out, "{{\"event\":\"{event}\",\"at_ms\":{at}{rest}}}");
            let _ = out.flush();
        }
    }

    /// The window was drawn for the first time.
    pub fn opened(&self) {
        self.line("opened", format_args!(""));
    }

    /// What the worker did.
    pub fn event(&self, event: &Event) {
        match event {
            Event::Loaded { serial, side, took, .. } => {
                let took = millis(*took);
                self.line(
                    "loaded",
                    format_args!(",\"serial\":{serial},\"side\":{side},\"took_ms\":{took}"),
                );
            }
            Event::Pass { serial, side, factor, since } => {
                let since = millis(*since);
                self.line(
                    "pass",
                    format_args!(
                        ",\"serial\":{serial},\"side\":{side},\"factor\":{factor},\"since_ms\":{since}"
                    ),
                );
            }
            Event::Done { serial, since } => {
                let since = millis(*since);
                self.line("done", format_args!(",\"serial\":{serial},\"since_ms\":{since}"));
            }
            Event::Backend { name, why } => {
                let why = why.as_ref().map_or("", |why| &why.text);
                self.line("backend", format_args!(",\"name\":{name:?},\"why\":{why:?}"));
            }
            Event::Failed(_) => self.line("failed", format_args!("")),
            Event::Heights(_) => {}
        }
    }

    /// Something was changed by hand.
    pub fn changed(&self, what: &str, value: f64) {
        self.line("changed", format_args!(",\"what\":\"{what}\",\"value\":{value}"));
    }

    /// A picture was drawn.
    pub fn drawn(&self, serial: u64) {
        self.line("drawn", format_args!(",\"serial\":{serial}"));
    }

    /// Where something is in the window, in its pixels.
    pub fn widget(&mut self, name: &'static str, rect: Rect, pixels_per_point: f32) {
        if !self.tells {
            return;
        }
        let all = [rect.min.x, rect.min.y, rect.width(), rect.height()];
        let now = all.map(|x| (x * pixels_per_point).round() as i32);
        if self.widgets.insert(name, now) != Some(now) {
            let [x, y, width, height] = now;
            self.line(
                "widget",
                format_args!(
                    ",\"name\":\"{name}\",\"x\":{x},\"y\":{y},\"width\":{width},\"height\":{height}"
                ),
            );
        }
    }
}

fn millis(time: Duration) -> u128 {
    time.as_millis()
}
