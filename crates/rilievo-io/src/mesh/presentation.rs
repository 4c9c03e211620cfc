//! The scene that shows a model: framed as a whole, or seen by its own first camera, with its own
//! lights, or a key light and a bright sky if it has none.

use std::fmt::Write;
use std::path::Path;

use rilievo::glam::DVec3;

use super::model::{Model, ModelCamera};
use crate::scene::quoted;

/// Where a camera stands that the file does not have: in front, a little to the right and above.
const VIEW: DVec3 = DVec3::new(0.5, 0.3, 1.0);

impl Model {
    /// The text of a scene that shows the model, read from `file`, beside which the scene is.
    /// None for a model without triangles.
    pub fn presentation(&self, file: &Path) -> Option<String> {
        let corners = self.mesh.triangles.iter().flat_map(|t| t.positions);
        let mut corners = corners.map(|i| self.mesh.positions[i as usize]).peekable();
        let first = *corners.peek()?;
        let (low, high) = corners.fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
        let (middle, size) = (0.5 * (low + high), (high - low).length().max(1e-9));
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let mut text = String::new();
        let camera = self.cameras.first().cloned();
        let camera = camera.unwrap_or_else(|| framed(middle, size));
        // Writing to a string cannot fail.
        let _ = write_camera(&mut text, &camera);
        let _ = write_lights(&mut text, self, middle, size);
        let _ = write!(text, "\n[[shapes]]\ntype = \"mesh\"\nfile = {}\n", quoted(&name));
        Some(text)
    }
}

/// A camera that sees everything within half of `size` around `middle`.
fn framed(middle: DVec3, size: f64) -> ModelCamera {
    let (fov, away) = (35f64, VIEW.normalize());
    let distance = 0.5 * size / (0.5 * fov.to_radians()).sin();
    ModelCamera {
        name: String::new(),
        position: middle + distance * away,
        forward: -away,
        up: DVec3::Y,
        fov,
        aspect: None,
    }
}

fn point(p: DVec3) -> String {
    format!("[{}, {}, {}]", p.x, p.y, p.z)
}

fn write_camera(text: &mut String, camera: &ModelCamera) -> std::fmt::Result {
    let aspect = camera.aspect.unwrap_or(4.0 / 3.0).clamp(0.1, 10.0);
    let size = match aspect >= 1.0 {
        true => [768.0, 768.0 / aspect],
        false => [768.0 * aspect, 768.0],
    };
    let ahead = camera.position + camera.forward * camera.position.length().max(1.0);
    writeln!(text, "[camera]\nposition = {}\nlook_at = {}", point(camera.position), point(ahead))?;
    writeln!(text, "up = {}\nfov = {}", point(camera.up), camera.fov)?;
    writeln!(text, "resolution = [{:.0}, {:.0}]\n", size[0], size[1])
}

fn write_lights(text: &mut String, model: &Model, middle: DVec3, size: f64) -> std::fmt::Result {
    let emits = model.materials.iter().any(|m| m.emitted != DVec3::ZERO);
    writeln!(text, "[render]\nsamples = 16\nmax_depth = 4")?;
    // Its own lights come with the model.
    if emits || !model.lights.is_empty() {
        return Ok(());
    }
    writeln!(text, "background = [0.5, 0.55, 0.6]\nambient = [0.22, 0.24, 0.27]")?;
    writeln!(text, "[materials.key]\ndiffuse = [0, 0, 0]\nemitted = [13, 12.4, 11.2]")?;
    // A square that faces the model, at the upper left of the camera's side.
    let towards = DVec3::new(-0.9, 1.2, 0.9).normalize();
    let across = towards.cross(DVec3::Y).normalize() * 0.5 * size;
    let along = across.cross(towards).normalize() * 0.5 * size;
    let at = middle + 1.8 * size * towards;
    let corners =
        [at - across - along, at + across - along, at + across + along, at - across + along];
    let corners = corners.map(point).join(", ");
    writeln!(text, "[[shapes]]\ntype = \"quad\"\ncorners = [{corners}]")?;
    writeln!(text, "material = \"key\"\none_sided = true")
}
