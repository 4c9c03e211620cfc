//! [`Preset`]: what a bare map is shown on.

use std::path::Path;

use glam::DVec3;
use toml_edit::{InlineTable, Item, Table, Value, value};

use super::document::{Document, array};
use super::sun::Sun;

/// What a bare map, or a texture set, is shown on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preset {
    /// A quad, one repetition wide.
    #[default]
    Plane,
    /// A sphere of radius 0.5.
    Sphere,
    /// Six closed quads of side 1, each with the map.
    Cube,
    /// The mesh that the program was given.
    Mesh,
}

impl Preset {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Plane, Self::Sphere, Self::Cube, Self::Mesh];

    /// What the window calls it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plane => "plane",
            Self::Sphere => "sphere",
            Self::Cube => "cube",
            Self::Mesh => "mesh",
        }
    }
}

/// Puts the shapes and the camera of a preset into a document that presents a map; the displacement of
/// its first displaced shape is laid on them. `mesh` is a model file; without one there is nothing to
/// show a map on, and `false` is given back.
pub fn show(document: &mut Document, preset: Preset, mesh: Option<&Path>) -> bool {
    let Some(&(index, ..)) = document.displaced().first() else { return false };
    let Some(displacement) = document.displacement(index) else { return false };
    let material = document.material(index);
    let shapes = match (preset, mesh) {
        (Preset::Plane, _) => vec![quad(SQUARE, &displacement, false)],
        (Preset::Sphere, _) => vec![sphere(&displacement)],
        (Preset::Cube, _) => cube(&displacement),
        (Preset::Mesh, Some(mesh)) => vec![model(mesh, &displacement)],
        (Preset::Mesh, None) => return false,
    };
    document.set_shapes(shapes.into_iter().map(|mut shape| {
        if let Some(name) = &material {
            shape.insert("material", value(name));
        }
        shape
    }));
    let (position, look_at) = match preset {
        Preset::Plane => (DVec3::new(0.5, -0.45, 0.85), DVec3::new(0.5, 0.46, 0.0)),
        Preset::Sphere => (DVec3::new(0.0, -1.75, 0.75), DVec3::ZERO),
        Preset::Cube | Preset::Mesh => (DVec3::new(1.3, -2.1, 1.35), DVec3::ZERO),
    };
    for (key, point) in [("position", position), ("look_at", look_at), ("up", DVec3::Z)] {
        document.set("camera", key, array(point.to_array()));
    }
    true
}

/// Makes the scene that presents a map one for the viewer: a sun that can be turned in place of the
/// lamp, and a material of its own.
pub fn prepare(document: &mut Document) {
    let displaced = document.displaced();
    let Some(&(index, ref kind, _)) = displaced.first() else { return };
    if kind == "terrain" {
        return;
    }
    let shape = document.displacement(index);
    let corners = document.corners(index);
    document.remove("materials", Some("lamp"));
    let (Some(displacement), Some(corners)) = (shape, corners) else { return };
    document.set_shapes([quad(corners, &displacement, false)]);
    document.set("render", "background", array([0.45, 0.5, 0.56]));
    document.set_sun(&Sun::default());
}

/// The unit square on the ground.
const SQUARE: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];

fn quad(corners: [DVec3; 4], displacement: &InlineTable, closed: bool) -> Table {
    let corners = corners.map(|c| array(c.to_array()));
    let mut table = Table::new();
    table.insert("type", value("quad"));
    table.insert("corners", value(corners.into_iter().collect::<toml_edit::Array>()));
    table.insert("displacement", displaced(displacement, [1.0, 1.0]));
    if closed {
        table.insert("closed", value(true));
    }
    table
}

fn sphere(displacement: &InlineTable) -> Table {
    let mut table = Table::new();
    table.insert("type", value("sphere"));
    table.insert("center", Item::Value(array([0.0; 3])));
    table.insert("radius", value(0.5));
    table.insert("displacement", displaced(displacement, [2.0, 1.0]));
    table
}

fn cube(displacement: &InlineTable) -> Vec<Table> {
    let side = |normal: DVec3, right: DVec3| {
        let up = normal.cross(right);
        let corners = [-right - up, right - up, right + up, up - right];
        quad(corners.map(|c| 0.5 * (normal + c)), displacement, true)
    };
    let [x, y, z] = DVec3::AXES;
    vec![side(z, x), side(-z, x), side(-y, x), side(y, -x), side(x, y), side(-x, -y)]
}

fn model(mesh: &Path, displacement: &InlineTable) -> Table {
    let mut table = Table::new();
    table.insert("type", value("mesh"));
    table.insert("file", value(mesh.to_string_lossy().as_ref()));
    table.insert("displacement", displaced(displacement, [1.0, 1.0]));
    table
}

/// The displacement with these repetitions; of one that has a depth it stays.
fn displaced(written: &InlineTable, tile: [f64; 2]) -> Item {
    let mut table = written.clone();
    table.insert("tile", array(tile));
    table.remove("shift");
    table.fmt();
    Item::Value(Value::InlineTable(table))
}
