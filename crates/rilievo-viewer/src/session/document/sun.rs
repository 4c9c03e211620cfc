//! The first sun of a scene, read and written.

use toml_edit::{ArrayOfTables, InlineTable, Item, Table, TableLike, Value};

use super::{Document, array, number, point, put};
use crate::session::Sun;

impl Document {
    /// The first sun among the lights.
    pub fn sun(&self) -> Option<Sun> {
        let lights = self.list("lights");
        let table = lights.into_iter().find(|light| is_sun(*light))?;
        let point = |key: &str| point(table.get(key)?);
        let angle = table.get("angle").and_then(number).unwrap_or(0.0);
        Some(Sun::along(point("direction")?, point("irradiance")?, angle))
    }

    /// Writes the first sun, or adds one.
    pub fn set_sun(&mut self, sun: &Sun) {
        let place = self.list("lights").into_iter().position(is_sun);
        let place = place.unwrap_or_else(|| self.add_sun());
        if let Some(table) = self.entry_mut("lights", place) {
            put(table, "direction", array(sun.direction().to_array()));
            put(table, "irradiance", array(sun.irradiance.to_array()));
            put(table, "angle", sun.angle.into());
        }
    }

    /// Adds a sun that says nothing yet; its place.
    fn add_sun(&mut self) -> usize {
        let place = self.list("lights").len();
        let lights = self.toml.entry("lights");
        match lights.or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new())) {
            Item::ArrayOfTables(all) => {
                let mut table = Table::new();
                table.insert("type", toml_edit::value("sun"));
                all.push(table);
            }
            Item::Value(Value::Array(all)) => {
                let mut table = InlineTable::new();
                table.insert("type", "sun".into());
                all.push(table);
            }
            _ => {}
        }
        place
    }
}

fn is_sun(light: &dyn TableLike) -> bool {
    light.get("type").and_then(Item::as_str) == Some("sun")
}
