//! Materials, and displacement in their `extras`.
//!
//! glTF has no displacement. This library reads it from `extras` of a material, which are for
//! applications:
//!
//! ```json
//! { "extras": { "displacement": { "texture": { "index": 3 }, "scale": 0.02, "zero": 0.5 } } }
//! ```
//!
//! `texture` is a texture of the document, `file` in its place a path beside it. `scale` (1) and
//! `zero` (0) as everywhere: `scale * (H - zero)` along the normal.

use glam::{DVec2, DVec3};
use rilievo::map::NormalConvention;

use super::images::Images;
use super::json::Json;
use super::uri::{self, Target};
use crate::error::Result;
use crate::mesh::{ImageSource, ImageUse, ModelDisplacement, ModelMaterial};

/// A material, and the sets of uv that its textures ask for.
pub(super) struct GltfMaterial {
    pub material: ModelMaterial,
    /// For each texture its pointer and its set.
    sets: Vec<(String, u64)>,
}

impl GltfMaterial {
    /// Reads a material.
    pub fn read(json: &Json<'_>, images: &Images, notes: &mut Vec<String>) -> Result<Self> {
        let mut reader = Reader { images, notes, sets: Vec::new() };
        let material = reader.material(json)?;
        Ok(Self { material, sets: reader.sets })
    }

    /// The set of uv that the mesh gets: that of the displacement, then of the colour.
    pub fn uv_set(&self) -> usize {
        let of = |key: &str| self.sets.iter().find(|(pointer, _)| pointer.contains(key));
        let set = of("/extras/").or_else(|| of("baseColor")).or(self.sets.first());
        set.map_or(0, |(_, set)| *set as usize)
    }

    /// The first texture that asks for a set that is not among `sets`.
    pub fn lacking(&self, sets: usize) -> Option<&(String, u64)> {
        self.sets.iter().find(|(_, set)| *set >= sets as u64)
    }
}

struct Reader<'a> {
    images: &'a Images,
    notes: &'a mut Vec<String>,
    sets: Vec<(String, u64)>,
}

impl Reader<'_> {
    fn material(&mut self, json: &Json<'_>) -> Result<ModelMaterial> {
        let mut material = ModelMaterial {
            name: json.text_of("name")?.unwrap_or_default().to_owned(),
            metalness: 1.0,
            ..ModelMaterial::default()
        };
        if let Some(pbr) = json.get("pbrMetallicRoughness") {
            let pbr = pbr.object()?;
            let [r, g, b, alpha] = pbr.numbers_or("baseColorFactor", [1.0; 4])?;
            if json.text_of("alphaMode")? == Some("BLEND") {
                material.opacity = alpha.clamp(0.0, 1.0);
            }
            material.colour = in_range(&pbr, "baseColorFactor", DVec3::new(r, g, b))?;
            material.colour_map = self.texture(&pbr, "baseColorTexture")?;
            material.metalness = pbr.number_or("metallicFactor", 1.0)?.clamp(0.0, 1.0);
            material.roughness = pbr.number_or("roughnessFactor", 1.0)?.clamp(0.0, 1.0);
            material.metalness_map = self.texture(&pbr, "metallicRoughnessTexture")?;
            material.roughness_map = material.metalness_map.clone();
        }
        let normals = self.texture(json, "normalTexture")?;
        material.normal_map = normals.map(|image| (image, NormalConvention::OpenGl));
        self.texture(json, "occlusionTexture")?;
        if let Some(info) = json.get("normalTexture") {
            material.normal_strength = info.object()?.number_or("scale", 1.0)?.clamp(0.0, 10.0);
        }
        material.emission_map = self.texture(json, "emissiveTexture")?;
        let emitted = DVec3::from_array(json.numbers_or("emissiveFactor", [0.0; 3])?);
        let emitted = in_range(json, "emissiveFactor", emitted)?;
        let strength = match json.extension("KHR_materials_emissive_strength") {
            Some(extension) => extension.number_or("emissiveStrength", 1.0)?.max(0.0),
            None => 1.0,
        };
        material.emitted = emitted * strength;
        self.layers(json, &mut material)?;
        if json.text_of("alphaMode")?.is_some_and(|mode| mode != "OPAQUE")
            && material.colour_map.is_some()
        {
            self.notes.push(format!("{}: the alpha of its image is not used", json.pointer));
        }
        for (name, extension) in json.get("extensions").iter().flat_map(|e| e.properties()) {
            self.extension_textures(name, &extension)?;
        }
        if let Some(json) = json.get("extras").and_then(|extras| extras.get("displacement")) {
            material.displacement = self.displacement(&json.object()?)?;
        }
        Ok(material)
    }

    /// Reads the extensions that add to a material.
    fn layers(&mut self, json: &Json<'_>, material: &mut ModelMaterial) -> Result<()> {
        let share = |json: &Json<'_>, key| Ok(json.number_or(key, 0.0)?.clamp(0.0, 1.0));
        if let Some(ior) = json.extension("KHR_materials_ior") {
            let ior = ior.number_or("ior", 1.5)?;
            // 0 stands for a body that reflects all: an index without end.
            material.ior = if ior == 0.0 { 10.0 } else { ior.clamp(1.0, 10.0) };
        }
        if let Some(specular) = json.extension("KHR_materials_specular") {
            material.specular = specular.number_or("specularFactor", 1.0)?.clamp(0.0, 1.0);
            let colour = DVec3::from_array(specular.numbers_or("specularColorFactor", [1.0; 3])?);
            material.specular_colour = in_range(&specular, "specularColorFactor", colour)?;
        }
        if let Some(glass) = json.extension("KHR_materials_transmission") {
            material.transmission = share(&glass, "transmissionFactor")?;
            material.transmission_map = self.texture(&glass, "transmissionTexture")?;
            // Without a volume the surface is a sheet.
            material.thin = match json.extension("KHR_materials_volume") {
                Some(volume) => volume.number_or("thicknessFactor", 0.0)? <= 0.0,
                None => true,
            };
        }
        if let Some(coat) = json.extension("KHR_materials_clearcoat") {
            material.coat = share(&coat, "clearcoatFactor")?;
            material.coat_map = self.texture(&coat, "clearcoatTexture")?;
            material.coat_roughness = share(&coat, "clearcoatRoughnessFactor")?;
            material.coat_roughness_map = self.texture(&coat, "clearcoatRoughnessTexture")?;
        }
        if let Some(sheen) = json.extension("KHR_materials_sheen") {
            let colour = DVec3::from_array(sheen.numbers_or("sheenColorFactor", [0.0; 3])?);
            material.sheen = in_range(&sheen, "sheenColorFactor", colour)?;
            material.sheen_roughness = share(&sheen, "sheenRoughnessFactor")?;
        }
        Ok(())
    }

    /// Checks the textures of an extension that is not read otherwise.
    fn extension_textures(&mut self, name: &str, json: &Json<'_>) -> Result<()> {
        if name == "KHR_texture_transform" {
            return Ok(());
        }
        for (key, value) in json.properties() {
            if key.ends_with("Texture") && value.get("index").is_some() {
                self.texture(json, key)?;
            }
        }
        Ok(())
    }

    /// The texture `key`; none if there is none, or its image cannot be used.
    fn texture(&mut self, json: &Json<'_>, key: &str) -> Result<Option<ImageUse>> {
        let Some(info) = json.get(key) else { return Ok(None) };
        let info = info.object()?;
        let index = info.require("index")?.index(self.images.textures())?;
        let mut set = info.whole_or("texCoord", 0)?;
        let (mut tile, mut turn, mut shift) = (DVec2::ONE, DVec2::X, DVec2::ZERO);
        if let Some(transform) = info.extension("KHR_texture_transform") {
            set = transform.whole_or("texCoord", set)?;
            let [scale_u, scale_v] = transform.numbers_or("scale", [1.0; 2])?;
            let [offset_u, offset_v] = transform.numbers_or("offset", [0.0; 2])?;
            let rotation = transform.number_or("rotation", 0.0)?;
            // v runs down there, and the turn is counterclockwise as seen: from u to our v.
            let (sin, cos) = rotation.sin_cos();
            tile = DVec2::new(scale_u, scale_v);
            if rotation != 0.0 {
                turn = DVec2::new(cos, sin);
            }
            shift = DVec2::new(offset_u + sin * scale_v, 1.0 - cos * scale_v - offset_v);
        }
        self.sets.push((info.pointer.clone(), set));
        let source = self.images.of_texture(index);
        Ok(source.map(|(source, wrap)| ImageUse { source, tile, turn, shift, wrap }))
    }

    fn displacement(&mut self, json: &Json<'_>) -> Result<Option<ModelDisplacement>> {
        let image = match json.get("file") {
            Some(file) => {
                let target = uri::resolve(file.text()?, json.path);
                let Ok(Target::File(path)) = target else {
                    return Err(file.fault("file", file.value.to_string(), "a relative path"));
                };
                let source = ImageSource::File(path);
                Some(ImageUse::new(source))
            }
            None => {
                json.require("texture")?;
                self.texture(json, "texture")?
            }
        };
        let (scale, zero) = (json.number_or("scale", 1.0)?, json.number_or("zero", 0.0)?);
        if scale == 0.0 {
            return Err(json.fault("scale", "0", "a number other than 0"));
        }
        Ok(image.map(|image| ModelDisplacement { image, scale, zero }))
    }
}

fn in_range(json: &Json<'_>, key: &str, colour: DVec3) -> Result<DVec3> {
    match colour.min_element() >= 0.0 {
        true => Ok(colour),
        false => Err(json.fault(key, format!("{colour}"), "numbers of at least 0")),
    }
}
