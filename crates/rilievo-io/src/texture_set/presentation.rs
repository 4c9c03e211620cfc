//! The scene that shows a texture set, or a height map: its relief on a quad in low light.
//!
//! One repetition lies on the ground, a unit wide, and is seen from in front and above. A warm
//! lamp stands low on the left, the sky fills the shadows. What the set means, and how deep it is,
//! is left to the folder itself: the scene names it as `./`.

use super::TextureSet;
use crate::error::Result;

impl TextureSet {
    /// The text of a scene that shows the set, to be read as a file in the set's folder.
    ///
    /// # Errors
    /// Of [`TextureSet::displacement`].
    pub fn presentation(&self) -> Result<String> {
        let image = self.displacement()?.image;
        let depth = f64::from(image.height) / f64::from(image.width);
        Ok(ground(depth, "displacement = { map = \"./\" }"))
    }
}

/// A scene with a ground of 1 x `depth`: a quad with the keys `shape`, or a terrain, if they say
/// where its centre is.
pub(crate) fn ground(depth: f64, shape: &str) -> String {
    // The near edge fills the width, the middle of the ground the middle of the picture.
    let (middle, back) = (0.5 * depth, 0.48 + 0.4 * depth);
    let kind = match shape.starts_with("center") {
        true => "type = \"terrain\"".to_owned(),
        false => format!(
            "type = \"quad\"\ncorners = [[0, 0, 0], [1, 0, 0], [1, {depth}, 0], [0, {depth}, 0]]"
        ),
    };
    format!(
        r#"[camera]
position = [0.5, {:.6}, {:.6}]
look_at  = [0.5, {:.6}, 0]
fov      = 40
resolution = [768, 576]

[render]
samples        = 16
shadow_samples = 4
max_depth      = 2
background     = [0.45, 0.5, 0.56]
ambient        = [0.2, 0.22, 0.25]

[materials.lamp]
diffuse = [0, 0, 0]
emitted = [84, 78, 67]

[[shapes]]
{kind}
{shape}

[[shapes]]
type = "quad"
corners = [[-1.9, {:.6}, 1.1], [-1.9, {:.6}, 1.1], [-1.5, {:.6}, 1.7], [-1.5, {:.6}, 1.7]]
material = "lamp"
one_sided = true
"#,
        middle - back,
        back,
        middle - 0.04,
        middle - 0.3,
        middle + 0.4,
        middle + 0.4,
        middle - 0.3,
    )
}
