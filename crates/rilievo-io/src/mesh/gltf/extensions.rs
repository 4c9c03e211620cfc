//! Which extensions a document uses and requires.

use std::collections::HashSet;

use serde_json::Value;

use super::json::Json;
use crate::error::{Error, Place, Result};

/// Extensions that a document may require: what they change is read, or does not change the shape
/// of anything.
const KNOWN: [&str; 16] = [
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Checks the extensions; gives those that are used.
pub(super) fn check(root: &Json<'_>) -> Result<HashSet<String>> {
    let mut lists = Vec::new();
    for key in ["extensionsUsed", "extensionsRequired"] {
        let mut names = HashSet::new();
        for item in root.list(key)? {
            if !names.insert(item.text()?.to_owned()) {
                return Err(item.fault(key, item.value.to_string(), "each name once"));
            }
        }
        lists.push(names);
    }
    let [used, required] = [lists.swap_remove(0), lists.swap_remove(0)];
    let mut required: Vec<_> = required.into_iter().collect();
    required.sort_unstable();
    for name in required {
        let fault =
            |found: String, allowed: String| root.fault("extensionsRequired", found, allowed);
        if !used.contains(&name) {
            return Err(fault(format!("{name:?}"), "extensions of extensionsUsed".to_owned()));
        }
        if !KNOWN.contains(&name.as_str()) {
            let place = Place::Pointer("/extensionsRequired".to_owned());
            let (what, allowed) = ("extension", KNOWN.join(", "));
            return Err(Error::unsupported(root.path, place, what, format!("{name:?}"), allowed));
        }
    }
    declared(root, &used)?;
    Ok(used)
}

/// Checks that every `extensions` holds objects under names that are declared.
fn declared(json: &Json<'_>, used: &HashSet<String>) -> Result<()> {
    if let Some(extensions) = json.get("extensions") {
        for (name, value) in extensions.object()?.properties() {
            if !used.contains(name) {
                let found = format!("{name:?}");
                return Err(value.fault("extension", found, "a name of extensionsUsed"));
            }
            value.object()?;
        }
    }
    // Applications keep what they like in extras.
    for (key, value) in json.properties().filter(|(key, _)| *key != "extras") {
        match value.value {
            Value::Object(_) if key != "extensions" => declared(&value, used)?,
            Value::Object(_) => {
                value.properties().try_for_each(|(_, value)| declared(&value, used))?;
            }
            Value::Array(items) if items.iter().any(Value::is_object) => {
                value.items()?.iter().try_for_each(|item| declared(item, used))?;
            }
            _ => {}
        }
    }
    Ok(())
}
