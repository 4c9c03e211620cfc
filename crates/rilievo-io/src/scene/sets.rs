//! Texture sets in a scene: wherever a file is named, a folder may be, with a slash at its end.
//!
//! The folder's map for the place is taken: displacement for the `file` of a map, albedo for the
//! `texture` of a material and so on (`set_materials`), the normal map for `normals`. `displacement = { map = "rock/" }` needs no
//! `[maps]` at all. Before anything is loaded the scene is rewritten to one that names files, with
//! what the set assumes in place of what the scene does not say; notes tell all of it. Terrain is laid
//! out in the same pass (`terrain`).

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::PathBuf;

use rilievo::glam::DVec2;
use rilievo::map::{Lattice, Layout, NormalConvention, Wrap};
use rilievo::relief::Displacement;

use super::cache::Cache;
use super::file::{
    DisplacementEntry, MapEntry, MapSource, MaterialEntry, Normals, QuadEntry, SceneFile, Shape,
};
use super::options::LoadOptions;
use super::syntax::Located;
use crate::error::{Error, Result};
use crate::image::{HeightOptions, MARK, Udim};
use crate::limits::Limits;
use crate::texture_set::{Assumed, MapRole, TextureSet};

/// Whether a path of a scene is a texture set.
pub(super) fn is_set(path: &str) -> bool {
    path.ends_with('/')
}

/// Texture sets, each found and judged once.
pub(super) struct Sets<'a> {
    pub(super) file: &'a SceneFile,
    limits: &'a Limits,
    cache: Option<&'a Cache>,
    /// Whether all of a material is shown.
    pub(super) paths: bool,
    found: HashMap<PathBuf, (TextureSet, Option<Assumed>)>,
    notes: Vec<String>,
}

impl SceneFile {
    /// The scene with files in place of texture sets, and what was found and assumed.
    pub(super) fn with_sets(
        &self,
        options: &LoadOptions<'_>,
    ) -> Result<(Cow<'_, Self>, Vec<String>)> {
        let (limits, paths) = (&options.limits, self.traces_paths(options));
        let cache = options.cache;
        let (found, notes) = (HashMap::new(), Vec::new());
        let mut sets = Sets { file: self, limits, cache, paths, found, notes };
        let mut file = Cow::Borrowed(self);
        for (k, (_, material)) in self.materials.iter().enumerate() {
            if let Some(changed) = sets.in_material(material)? {
                file.to_mut().materials[k].1 = changed;
            }
        }
        for k in 0..self.shapes.len() {
            let shape = &self.shapes[k];
            if let Shape::Quad(QuadEntry { ground: Some(ground), .. }) = &shape.shape
                && let Shape::Quad(quad) = &mut file.to_mut().shapes[k].shape
            {
                sets.notes.extend(self.lay_out(quad, ground, limits)?);
                continue;
            }
            let (Some(entry), width) = (shape.shape.displacement(), map_width(&shape.shape)) else {
                continue;
            };
            let map = self.maps.iter().position(|(name, _)| name.value == entry.map.value);
            let folder = match map.map(|place| &self.maps[place].1.source) {
                Some(MapSource::File { file, .. }) => file,
                Some(MapSource::Procedural { .. }) => continue,
                None => &entry.map,
            };
            let set_normals = match &entry.normals {
                Normals::File { file, .. } if is_set(&file.value) => Some(file),
                _ => None,
            };
            if !is_set(&folder.value) {
                if let Some(name) = set_normals {
                    let allowed = "the set's displacement beside it, or a file";
                    return Err(self.fault(&name.at, "normals", "a set without", allowed));
                }
                continue;
            }
            let mut entry = entry.clone();
            let albedo = sets.displace(&mut entry, folder, width)?;
            if let Some(name) = set_normals
                && let Normals::File { convention: written, .. } = entry.normals
            {
                entry.normals = sets.normals(name, folder, written)?;
            }
            let path = sets.map(folder, MapRole::Displacement)?;
            let written = matches!(
                map.map(|place| &self.maps[place].1.source),
                Some(MapSource::File { invert: true, .. })
            );
            let turn = sets.assumed(folder)?.invert != written;
            let file = file.to_mut();
            file.name_map(&entry.map, map, path, turn);
            if let (None, Some(texture)) = (&shape.material, albedo) {
                let name = file.add_material(&entry, texture);
                if let Some((_, material)) = file.materials.last_mut() {
                    sets.fill_added(material, folder)?;
                }
                file.shapes[k].material = Some(name);
            }
            if let Some(slot) = file.shapes[k].shape.displacement_mut() {
                *slot = entry;
            }
        }
        if self.names_tiles() || !sets.found.is_empty() {
            file = Cow::Owned(file.with_spread_tiles()?);
        }
        Ok((file, sets.notes))
    }

    /// Whether a path of the scene stands for tiles.
    fn names_tiles(&self) -> bool {
        self.text.contains(MARK)
    }

    /// The scene with images in tiles laid over as many units of uv as they have tiles.
    fn with_spread_tiles(&self) -> Result<Self> {
        let tiles = |file: &Located<String>| {
            let found = Udim::find(&self.beside(&file.value));
            let found = found.map_err(|e| self.referenced(file, "tiles", e))?;
            Ok::<_, Error>(found.map(|t| DVec2::new(f64::from(t.columns), f64::from(t.rows))))
        };
        let mut spread = self.clone();
        for (_, material) in &mut spread.materials {
            for texture in material.textures_mut() {
                if let Some(count) = tiles(&texture.file)? {
                    texture.tile /= count;
                    texture.shift /= count;
                }
            }
        }
        for shape in &mut spread.shapes {
            let Some(entry) = shape.shape.displacement_mut() else { continue };
            let map = self.maps.iter().find(|(name, _)| name.value == entry.map.value);
            if let Some((_, MapEntry { source: MapSource::File { file, .. }, .. })) = map
                && let Some(count) = tiles(file)?
            {
                let Displacement { tile, shift, .. } = &mut entry.displacement;
                *tile = (DVec2::from(*tile) / count).into();
                *shift = (DVec2::from(*shift) / count).into();
            }
        }
        Ok(spread)
    }

    /// Lets the map of a displacement name the file `path`: the map `written` in the scene, or a new
    /// one under the name of the set.
    fn name_map(
        &mut self,
        name: &Located<String>,
        written: Option<usize>,
        path: String,
        turn: bool,
    ) {
        let at = name.at.clone();
        let file = Located { value: path, at: at.clone() };
        if let Some(place) = written {
            self.maps[place].1.source = MapSource::File { file, invert: turn };
        } else if self.maps.iter().all(|(n, _)| n.value != name.value) {
            let map = MapEntry {
                source: MapSource::File { file, invert: turn },
                lattice: Lattice::Texel,
                wrap: Wrap::Repeat,
                layout: Layout::Default,
                distance: Default::default(),
                at,
            };
            self.maps.push((name.clone(), map));
        }
    }

    /// A material that shows the image `texture` where the displacement lies.
    fn add_material(&mut self, entry: &DisplacementEntry, texture: String) -> Located<String> {
        let at = entry.map.at.clone();
        let name =
            Located { value: format!("{} of {}", entry.map.value, self.materials.len()), at };
        let file = Located { value: texture, at: name.at.clone() };
        let [tile, shift] = [entry.displacement.tile, entry.displacement.shift].map(DVec2::from);
        self.materials.push((name.clone(), MaterialEntry::textured(file, tile, shift)));
        name
    }

    fn fault(&self, at: &std::ops::Range<usize>, what: &str, found: &str, allowed: &str) -> Error {
        Error::Invalid(Box::new(self.document().fault(at, what, found, allowed)))
    }
}

impl Sets<'_> {
    /// The set called `name`.
    pub(super) fn find(
        &mut self,
        name: &Located<String>,
    ) -> Result<&mut (TextureSet, Option<Assumed>)> {
        let folder = self.file.beside(&name.value);
        if !self.found.contains_key(&folder) {
            let found = match self.cache.and_then(|cache| cache.set(&folder)) {
                Some((set, assumed)) => (set, Some(assumed)),
                None => {
                    let set = TextureSet::find(&folder, self.limits);
                    (set.map_err(|e| self.file.referenced(name, "texture set", e))?, None)
                }
            };
            self.notes.extend(found.0.describe());
            self.found.insert(folder.clone(), found);
        }
        // It was put there just now, if not before.
        self.found.get_mut(&folder).ok_or_else(|| {
            self.file.fault(&name.at, "texture set", "nothing", "a folder with maps")
        })
    }

    /// The path of the map for `role`, as a scene would write it.
    pub(super) fn map(&mut self, name: &Located<String>, role: MapRole) -> Result<String> {
        let (set, _) = self.find(name)?;
        let Some(map) = set.map(role) else {
            let allowed = format!("a folder with a map for {}", role.name());
            return Err(self.file.fault(&name.at, role.name(), "not in the set", &allowed));
        };
        // A MaterialX file may name maps in other folders.
        let file = map.path.strip_prefix(&set.folder).unwrap_or(&map.path);
        Ok(format!("{}{}", name.value, file.display()))
    }

    /// What is assumed of the set `name`.
    fn assumed(&mut self, name: &Located<String>) -> Result<Assumed> {
        let (limits, cache) = (*self.limits, self.cache);
        let (set, assumed) = self.find(name)?;
        if let Some(assumed) = assumed {
            return Ok(assumed.clone());
        }
        let judge = |set: &TextureSet| {
            let heights = set.heights(&HeightOptions::default(), &limits)?;
            let assumed = set.assumed(&heights, &limits)?;
            if let Some(cache) = cache {
                cache.keep_judged(&set.displacement()?.path, heights);
                cache.keep_set(&set.folder, set, &assumed);
            }
            Ok(assumed)
        };
        match judge(set) {
            Ok(found) => {
                let note = format!("{}: {}", set.folder.display(), found.describe());
                *assumed = Some(found.clone());
                self.notes.push(note);
                Ok(found)
            }
            Err(e) => Err(self.file.referenced(name, "texture set", e)),
        }
    }

    /// Fills in what the displacement does not say; gives the set's albedo.
    fn displace(
        &mut self,
        entry: &mut DisplacementEntry,
        folder: &Located<String>,
        width: Option<f64>,
    ) -> Result<Option<String>> {
        let assumed = self.assumed(folder)?;
        if !entry.zero_written {
            entry.displacement.zero = assumed.zero;
        }
        if !entry.scale_written {
            let Some(width) = width else {
                let allowed = "`scale`, since the width of the map on a mesh is not known";
                return Err(self.file.fault(&entry.at, "displacement", "no scale", allowed));
            };
            entry.displacement.scale = assumed.scale * width / entry.displacement.tile[0];
        }
        let (set, _) = self.find(folder)?;
        match set.map(MapRole::Albedo) {
            Some(_) => self.map(folder, MapRole::Albedo).map(Some),
            None => Ok(None),
        }
    }

    /// The set's normal map, with green as it was found to point.
    fn normals(
        &mut self,
        name: &Located<String>,
        folder: &Located<String>,
        written: Option<NormalConvention>,
    ) -> Result<Normals> {
        let value = self.map(name, MapRole::Normal)?;
        let measured = self.assumed(folder)?.agreement.and_then(|a| a.convention);
        let (set, _) = self.find(name)?;
        let named = set.map(MapRole::Normal).and_then(|map| map.convention);
        let convention = written.or(measured).or(named).unwrap_or(NormalConvention::OpenGl);
        let file = Located { value, at: name.at.clone() };
        Ok(Normals::File { file, convention: Some(convention) })
    }
}

/// Scene units that one width of a map takes on a shape, untiled; none where uv do not tell.
fn map_width(shape: &Shape) -> Option<f64> {
    match shape {
        Shape::Quad(quad) => {
            let [c0, c1, _, _] = quad.corners.value;
            Some((c1 - c0).length())
        }
        Shape::Sphere(sphere) => Some(std::f64::consts::TAU * sphere.radius.value),
        Shape::Mesh(_) => None,
    }
}
