//! [`Action`]: everything a user can change, and [`Change`], what must be made anew for it.

use rilievo::map::Layout;
use rilievo::relief::Method;
use rilievo_render::film::tonemap::View;
use rilievo_render::{Aov, CameraParts, Integrator};

use super::preset::Preset;
use super::sun::Sun;

/// An edit.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Scene units per unit of height of the selected shape.
    Depth(f64),
    /// The height that stays on the base.
    Zero(f64),
    /// Repetitions along u and v.
    Tile([f64; 2]),
    /// By how much the selected terrain is higher than in nature.
    Exaggeration(f64),
    /// The roughness of its material.
    Roughness(f64),
    /// The first sun, added if there is none.
    Sun(Sun),
    /// Where the camera is.
    Camera(CameraParts),
    /// How all reliefs are walked.
    Method(Method),
    /// How the bounds of all maps are stored.
    Layout(Layout),
    /// What is estimated.
    Integrator(Integrator),
    /// Camera rays a pixel.
    Samples(u32),
    /// Stops.
    Exposure(f64),
    /// How the picture shows light beyond white.
    View(View),
    /// What of the film is shown; no part of the scene.
    Look(Look),
    /// What a bare map is shown on.
    Preset(Preset),
}

/// What of a film is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Look {
    /// The colour.
    #[default]
    Colour,
    /// A layer in false colours; of steps the heat map.
    Layer(Aov),
}

impl Look {
    /// What the window calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Colour => "colour",
            Self::Layer(aov) => aov.name(),
        }
    }
}

/// What has to be done to show a change; the larger includes the smaller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Change {
    /// Nothing.
    #[default]
    None,
    /// The film is shown otherwise.
    Shown,
    /// The same surfaces are rendered again, by another camera or as another layer.
    Rendered,
    /// The scene is made anew of its text.
    Scene,
}
