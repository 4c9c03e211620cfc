//! What the mouse holds, and what is compared.

use rilievo::relief::Method;
use rilievo_viewer::brush::Tool;
use rilievo_viewer::session::Document;

/// What the left button does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hand {
    Move,
    Pick,
    Paint,
}

impl Hand {
    pub const ALL: [Self; 3] = [Self::Move, Self::Pick, Self::Paint];

    pub fn name(self) -> &'static str {
        match self {
            Self::Move => "Move",
            Self::Pick => "Pick",
            Self::Paint => "Paint",
        }
    }
}

/// What is beyond the wipe.
pub enum Other {
    Nothing,
    /// The same scene, walked otherwise.
    Method(Method),
    /// Another scene.
    Scene(Box<Document>),
}

/// The brush.
pub struct Brush {
    pub tool: Tool,
    /// In samples of the map.
    pub radius: f64,
    /// Share of the map's range a dab.
    pub strength: f64,
    /// The number of the stroke.
    pub stroke: u32,
    /// Whether it is on the surface now.
    pub down: bool,
}

impl Default for Brush {
    fn default() -> Self {
        Self { tool: Tool::Raise, radius: 24.0, strength: 0.02, stroke: 0, down: false }
    }
}
