//! The scene file as a whole.

use super::kind::Form;
use super::{Key, Optional, Required, Section};

pub const CAMERA: Key<Form, Required> =
    Key::new("camera", Form("table"), Required(""), "what sees the scene");
pub const RENDER: Key<Form, Optional> =
    Key::new("render", Form("table"), Optional("`{}`"), "how it is rendered");
pub const MAPS: Key<Form, Optional> =
    Key::new("maps", Form("table of tables"), Optional("none"), "by names of your choice");
pub const MATERIALS: Key<Form, Optional> =
    Key::new("materials", Form("table of tables"), Optional("none"), "by names of your choice");
pub const SHAPES: Key<Form, Optional> =
    Key::new("shapes", Form("array of tables"), Optional("none"), "any number");
pub const LIGHTS: Key<Form, Optional> =
    Key::new("lights", Form("array of tables"), Optional("none"), "any number");
pub const ENVIRONMENT: Key<Form, Optional> =
    Key::new("environment", Form("table"), Optional("none"), "light from all around");

/// The top level.
pub const SCENE: Section = Section {
    name: "scene",
    table: "",
    keys: &[&CAMERA, &RENDER, &LIGHTS, &ENVIRONMENT, &MAPS, &MATERIALS, &SHAPES],
};
