//! [`Document`]: the scene that is shown, as the text of a scene file.
//!
//! Whatever is changed is changed in the text, key by key; comments and order of what was written stay.
//! So what is shown, what is saved and what `rilievo render` reads are one thing.

use std::path::{Path, PathBuf};

use glam::DVec3;
use rilievo_io::scene::SceneFile;
use rilievo_render::CameraParts;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value};

mod paths;
mod sun;

/// The name of a material that is made here.
const OWN: &str = "surface";

/// A key of a displacement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DisplacementKey {
    /// Scene units per unit of height.
    Scale,
    /// The height that stays on the base.
    Zero,
    /// Repetitions along u and v.
    Tile,
}

impl DisplacementKey {
    fn name(self) -> &'static str {
        match self {
            Self::Scale => "scale",
            Self::Zero => "zero",
            Self::Tile => "tile",
        }
    }
}

/// The text of a scene and the file that relative paths start from.
#[derive(Clone, Debug)]
pub struct Document {
    toml: DocumentMut,
    path: PathBuf,
}

impl Document {
    /// The text of a file that was read.
    pub fn of(file: &SceneFile) -> Self {
        Self::new(file.text(), file.path())
    }

    /// A text; what is not TOML counts as empty, and is refused when it is loaded.
    pub fn new(text: &str, path: &Path) -> Self {
        Self { toml: text.parse().unwrap_or_default(), path: path.to_owned() }
    }

    /// The text.
    pub fn text(&self) -> String {
        self.toml.to_string()
    }

    /// The file; a name in the folder of the map where there is no scene file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Parsed and checked.
    ///
    /// # Errors
    /// As [`SceneFile::parse`].
    pub fn parse(&self) -> rilievo_io::Result<SceneFile> {
        SceneFile::parse(&self.text(), &self.path)
    }

    /// The displaced shapes: their place in the file, their type and the map they name.
    pub fn displaced(&self) -> Vec<(usize, String, String)> {
        let text = |table: &dyn TableLike, key: &str| {
            table.get(key).and_then(Item::as_str).unwrap_or_default().to_owned()
        };
        let found = self.shapes().into_iter().enumerate().filter_map(|(index, shape)| {
            let kind = text(shape, "type");
            if kind == "terrain" {
                return Some((index, kind, text(shape, "map")));
            }
            let displacement = shape.get("displacement")?.as_table_like()?;
            Some((index, kind, text(displacement, "map")))
        });
        found.collect()
    }

    fn shapes(&self) -> Vec<&dyn TableLike> {
        self.list("shapes")
    }

    fn shape_mut(&mut self, index: usize) -> Option<&mut dyn TableLike> {
        self.entry_mut("shapes", index)
    }

    /// The entries of a list of tables, however it is written.
    fn list(&self, name: &str) -> Vec<&dyn TableLike> {
        match self.toml.get(name) {
            Some(Item::ArrayOfTables(all)) => all.iter().map(|t| t as &dyn TableLike).collect(),
            Some(Item::Value(Value::Array(all))) => {
                all.iter().filter_map(|v| Some(v.as_inline_table()? as &dyn TableLike)).collect()
            }
            _ => Vec::new(),
        }
    }

    fn entry_mut(&mut self, list: &str, index: usize) -> Option<&mut dyn TableLike> {
        match self.toml.get_mut(list)? {
            Item::ArrayOfTables(all) => Some(all.get_mut(index)? as &mut dyn TableLike),
            Item::Value(Value::Array(all)) => {
                Some(all.get_mut(index)?.as_inline_table_mut()? as &mut dyn TableLike)
            }
            _ => None,
        }
    }

    fn displacement_mut(&mut self, shape: usize) -> Option<&mut dyn TableLike> {
        self.shape_mut(shape)?.get_mut("displacement")?.as_table_like_mut()
    }

    /// Writes a key of the displacement of a shape. Terrain has none: there it changes nothing.
    pub fn set_displacement(&mut self, shape: usize, key: DisplacementKey, value: Value) {
        if let Some(table) = self.displacement_mut(shape) {
            put(table, key.name(), value);
        }
    }

    /// Lets the displacement of a shape take the map file `file`, not inverted, under the name `name`.
    pub fn set_map(&mut self, shape: usize, name: &str, file: &str) {
        let Some(table) = self.displacement_mut(shape) else { return };
        let old = table.get("map").and_then(Item::as_str).unwrap_or_default().to_owned();
        put(table, "map", name.into());
        let maps = self.toml.entry("maps").or_insert_with(implicit);
        let Some(maps) = maps.as_table_like_mut() else { return };
        let mut entry = match maps.get(&old).and_then(Item::as_table_like) {
            Some(old) => old.iter().map(|(k, v)| (k.to_owned(), v.clone())).collect(),
            None => Vec::new(),
        };
        entry.retain(|(key, _)| ["grid", "wrap", "layout"].contains(&key.as_str()));
        let mut table = Table::new();
        table.insert("file", toml_edit::value(file));
        table.extend(entry);
        maps.insert(name, Item::Table(table));
    }

    /// Writes `key` of the table `[section]`.
    pub fn set(&mut self, section: &str, key: &str, value: impl Into<Value>) {
        let table = self.toml.entry(section).or_insert_with(toml_edit::table);
        if let Some(table) = table.as_table_like_mut() {
            put(table, key, value.into());
        }
    }

    /// Writes how bounds are stored to every map that has a table.
    pub fn set_layouts(&mut self, layout: &str) {
        let Some(maps) = self.toml.get_mut("maps").and_then(Item::as_table_like_mut) else {
            return;
        };
        for (_, map) in maps.iter_mut() {
            if let Some(map) = map.as_table_like_mut() {
                put(map, "layout", layout.into());
            }
        }
    }

    /// Takes away what shapes say of how they are walked, so that `[render]` decides.
    pub fn clear_methods(&mut self) {
        for index in 0..self.shapes().len() {
            if let Some(shape) = self.shape_mut(index) {
                shape.remove("method");
            }
        }
    }

    /// The name of the material of a shape.
    pub fn material(&self, shape: usize) -> Option<String> {
        Some(self.shapes().get(shape)?.get("material")?.as_str()?.to_owned())
    }

    /// The roughness of a material, 0 where it is not written as a number.
    pub fn roughness(&self, material: &str) -> f64 {
        let found = self.toml.get("materials").and_then(|m| m.get(material)?.get("roughness"));
        found.and_then(number).unwrap_or(0.0)
    }

    /// Writes a key of a material.
    pub fn set_material(&mut self, name: &str, key: &str, value: Value) {
        let materials = self.toml.entry("materials").or_insert_with(implicit);
        let Some(materials) = materials.as_table_like_mut() else { return };
        if let Some(table) = materials.get_mut(name).and_then(Item::as_table_like_mut) {
            put(table, key, value);
        }
    }

    /// Gives displaced shapes that show the same map, and have no material, one of their own; its name.
    /// Of a texture set it shows the colours, as shapes without a material do.
    pub fn own_material(&mut self, shape: usize) -> String {
        if let Some(name) = self.material(shape) {
            return name;
        }
        let displaced = self.displaced();
        let map = displaced.iter().find(|(index, ..)| *index == shape).map(|(.., map)| map.clone());
        let map = map.unwrap_or_default();
        let name = OWN.to_owned();
        let mut table = Table::new();
        if map.ends_with('/') {
            let mut texture = InlineTable::new();
            texture.insert("file", map.as_str().into());
            for key in ["tile", "shift"] {
                let laid = self.displacement(shape).and_then(|laid| laid.get(key).cloned());
                texture.extend(laid.map(|laid| (key, laid)));
            }
            texture.fmt();
            table.insert("texture", toml_edit::value(texture));
        }
        let materials = self.toml.entry("materials").or_insert_with(implicit);
        if let Some(materials) = materials.as_table_like_mut() {
            materials.insert(&name, Item::Table(table));
        }
        for (index, ..) in displaced.iter().filter(|(.., other)| *other == map) {
            if self.material(*index).is_none()
                && let Some(shape) = self.shape_mut(*index)
            {
                put(shape, "material", name.as_str().into());
            }
        }
        name
    }

    /// Lets the colours of a material made here repeat with its map.
    pub fn tile_own_texture(&mut self, tile: [f64; 2]) {
        let own = self.toml.get_mut("materials").and_then(|m| m.get_mut(OWN));
        let texture = own.and_then(|own| own.get_mut("texture")).and_then(Item::as_table_like_mut);
        if let Some(texture) = texture {
            put(texture, "tile", array(tile));
        }
    }

    /// By how much a terrain is higher than in nature.
    pub fn exaggeration(&self, shape: usize) -> f64 {
        let written = self.shapes().get(shape).and_then(|shape| shape.get("exaggeration"));
        written.and_then(number).unwrap_or(1.0)
    }

    /// Writes by how much a terrain is higher than in nature.
    pub fn set_exaggeration(&mut self, shape: usize, factor: f64) {
        if let Some(shape) = self.shape_mut(shape) {
            put(shape, "exaggeration", factor.into());
        }
    }

    /// Writes a terrain as the displaced quad that it is, with these corners.
    pub fn terrain_to_quad(&mut self, shape: usize, corners: [DVec3; 4]) {
        let Some(table) = self.shape_mut(shape) else { return };
        let map = table.remove("map").and_then(|map| map.into_value().ok());
        for key in ["center", "unit", "exaggeration", "cell", "zero"] {
            table.remove(key);
        }
        put(table, "type", "quad".into());
        let corners = corners.map(|c| array(c.to_array()));
        put(table, "corners", corners.into_iter().collect::<Array>().into());
        let mut displacement = InlineTable::new();
        displacement.extend(map.map(|map| ("map", map)));
        displacement.fmt();
        put(table, "displacement", displacement.into());
    }

    /// The corners of a quad.
    pub fn corners(&self, shape: usize) -> Option<[DVec3; 4]> {
        let corners = self.shapes().get(shape)?.get("corners")?.as_array()?;
        let all: Option<Vec<_>> = corners.iter().map(point_of).collect();
        all?.try_into().ok()
    }

    /// Writes where the camera is and where it looks.
    pub fn set_camera(&mut self, camera: &CameraParts) {
        for (key, value) in
            [("position", camera.position), ("look_at", camera.look_at), ("up", camera.up)]
        {
            self.set("camera", key, array(value.to_array()));
        }
        // Without one it has the default, which is what it was read as.
        if self.toml.get("camera").is_some_and(|c| c.get("fov").is_some()) {
            self.set("camera", "fov", camera.fov);
        }
    }

    /// The displacement of a shape as it is written.
    pub fn displacement(&self, shape: usize) -> Option<InlineTable> {
        let table = self.shapes().get(shape)?.get("displacement")?.as_table_like()?;
        let mut copy = InlineTable::new();
        for (key, item) in table.iter() {
            if let Some(value) = item.as_value() {
                copy.insert(key, value.clone());
            }
        }
        Some(copy)
    }

    /// Puts these shapes in place of all there are.
    pub fn set_shapes(&mut self, shapes: impl IntoIterator<Item = Table>) {
        let all: ArrayOfTables = shapes.into_iter().collect();
        self.toml.insert("shapes", Item::ArrayOfTables(all));
    }

    /// Takes a table or a list out.
    pub fn remove(&mut self, section: &str, key: Option<&str>) {
        match key {
            None => {
                self.toml.remove(section);
            }
            Some(key) => {
                let table = self.toml.get_mut(section).and_then(Item::as_table_like_mut);
                table.and_then(|table| table.remove(key));
            }
        }
    }
}

/// Numbers as an array.
pub fn array(numbers: impl IntoIterator<Item = f64>) -> Value {
    numbers.into_iter().collect::<Array>().into()
}

fn implicit() -> Item {
    let mut table = Table::new();
    table.set_implicit(true);
    Item::Table(table)
}

/// Puts a value in place of another, whose comments stay.
fn put(table: &mut dyn TableLike, key: &str, value: Value) {
    if let Some(old) = table.get_mut(key).and_then(Item::as_value_mut) {
        let decor = old.decor().clone();
        *old = value;
        *old.decor_mut() = decor;
    } else {
        table.insert(key, Item::Value(value));
    }
}

fn number(item: &Item) -> Option<f64> {
    number_of(item.as_value()?)
}

fn number_of(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64))
}

fn point(item: &Item) -> Option<DVec3> {
    point_of(item.as_value()?)
}

fn point_of(value: &Value) -> Option<DVec3> {
    let all: Option<Vec<f64>> = value.as_array()?.iter().map(number_of).collect();
    Some(DVec3::from_array(all?.try_into().ok()?))
}
