//! [`TextureSet`]: a folder with the maps of one material, as asset libraries ship them.
//!
//! Which file is what is told by its name (see `naming`); of several files for one role the
//! largest is taken, of equal ones that with more bits. Where no name says displacement, the
//! largest image of one channel that no other role claims is taken for it: folders of terrain are
//! so. A MaterialX file in the folder ([`MaterialX`]) goes before names.

mod assumed;
mod material_x;
mod naming;
mod presentation;

use std::fs;
use std::path::{Path, PathBuf};

use rilievo::map::{HeightMap, NormalAgreement, NormalConvention};

pub use assumed::Assumed;
pub use material_x::{MaterialX, WrittenDisplacement};
pub use naming::MapRole;
pub(crate) use presentation::ground;

use crate::error::{Error, Place, Result};
use crate::image::{
    HeightOptions, ImageInfo, MARK, NormalOptions, SampleKind, number, read_image_info,
};
use crate::limits::Limits;

/// Endings of files that are looked at.
const ENDINGS: [&str; 12] =
    ["png", "jpg", "jpeg", "tif", "tiff", "exr", "pfm", "asc", "hgt", "bil", "r16", "r32"];
/// Most entries of a folder.
const MAX_ENTRIES: usize = 10_000;

/// What tells the role of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Told {
    /// Its name.
    Name,
    /// A MaterialX file in the folder.
    Document,
    /// Nothing: it is what was left.
    Nothing,
}

/// A map of a set.
#[derive(Clone, Debug, PartialEq)]
pub struct SetMap {
    /// What it is for.
    pub role: MapRole,
    /// Its file.
    pub path: PathBuf,
    /// Of a normal map: what its name says of green.
    pub convention: Option<NormalConvention>,
    /// What told its role.
    pub told: Told,
    /// Its header.
    pub image: ImageInfo,
}

/// A folder of maps.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureSet {
    /// The folder.
    pub folder: PathBuf,
    /// One map for each role, in the order of roles.
    pub maps: Vec<SetMap>,
    /// Images that were not taken, and why.
    pub passed_over: Vec<(PathBuf, &'static str)>,
    /// What a MaterialX file of the folder says of the displacement, one width a scene unit.
    pub written: Option<WrittenDisplacement>,
}

impl TextureSet {
    /// Finds the maps of a folder.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Invalid`] for a folder without an image whose role can be told.
    pub fn find(folder: &Path, limits: &Limits) -> Result<Self> {
        let mut set = Self {
            folder: folder.to_owned(),
            maps: Vec::new(),
            passed_over: Vec::new(),
            written: None,
        };
        let (images, documents) = files(folder)?;
        set.take_document(&documents, limits)?;
        let mut unnamed = Vec::new();
        let mut ranked: Vec<(bool, SetMap)> = Vec::new();
        for path in images {
            if set.maps.iter().any(|map| map.path == path) {
                continue;
            }
            let Ok(image) = read_image_info(&path, limits) else {
                set.passed_over.push((path, "cannot be read"));
                continue;
            };
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let stem = stem.replace(MARK, "");
            match naming::meaning(&stem) {
                Some(m) => {
                    let (role, convention) = (m.role, m.convention);
                    let told = Told::Name;
                    let map = SetMap { role, path, convention, told, image };
                    ranked.push((m.vague, map));
                }
                None => unnamed.push((path, image)),
            }
        }
        // The best first: see the module.
        ranked.sort_by_key(|(vague, map)| (map.role, *vague, map.order()));
        for (_, map) in ranked {
            match set.map(map.role) {
                None => set.maps.push(map),
                Some(_) => set.passed_over.push((map.path, "a better file for its role is there")),
            }
        }
        set.take_unnamed(unnamed);
        set.maps.sort_by_key(|map| map.role);
        if set.maps.is_empty() {
            let found = format!("no map among {} images", set.passed_over.len());
            let allowed = "images named for their role, such as rock_Displacement.png";
            return Err(Error::invalid(folder, Place::File, "texture set", found, allowed));
        }
        Ok(set)
    }

    /// Takes what the first MaterialX file names.
    fn take_document(&mut self, documents: &[PathBuf], limits: &Limits) -> Result<()> {
        let Some(path) = documents.first() else { return Ok(()) };
        let document = MaterialX::read(path, limits)?;
        for (role, path) in document.images {
            match read_image_info(&path, limits) {
                Ok(image) => {
                    let told = Told::Document;
                    self.maps.push(SetMap { role, path, convention: None, told, image });
                    if role == MapRole::Displacement {
                        self.written = document.displacement;
                    }
                }
                Err(_) => self.passed_over.push((path, "named by MaterialX, cannot be read")),
            }
        }
        Ok(())
    }

    /// Takes the largest grey image for the displacement, if nothing else is it.
    fn take_unnamed(&mut self, unnamed: Vec<(PathBuf, ImageInfo)>) {
        let has_heights = self.map(MapRole::Displacement).is_some();
        let grey = (unnamed.iter())
            .filter(|(_, image)| image.channels == 1 && !has_heights)
            .max_by_key(|(_, image)| u64::from(image.width) * u64::from(image.height))
            .map(|(path, _)| path.clone());
        for (path, image) in unnamed {
            if Some(&path) == grey.as_ref() {
                let role = MapRole::Displacement;
                let told = Told::Nothing;
                self.maps.push(SetMap { role, path, convention: None, told, image });
            } else {
                self.passed_over.push((path, "its name says no role"));
            }
        }
    }

    /// What was found, a line a map.
    pub fn describe(&self) -> impl Iterator<Item = String> {
        let name =
            |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let folder = self.folder.display().to_string();
        self.maps.iter().map(move |map| {
            let ImageInfo { width, height, file_bits, .. } = map.image;
            let why = match map.told {
                Told::Name => "",
                Told::Document => ", by MaterialX",
                Told::Nothing => ", for want of a name",
            };
            let (file, role) = (name(&map.path), map.role.name());
            format!("{folder}: {role}: {file}, {width} x {height}, {file_bits} bit{why}")
        })
    }

    /// The map for `role`.
    pub fn map(&self, role: MapRole) -> Option<&SetMap> {
        self.maps.iter().find(|map| map.role == role)
    }

    /// The displacement map.
    ///
    /// # Errors
    /// [`Error::Invalid`] if there is none.
    pub fn displacement(&self) -> Result<&SetMap> {
        self.map(MapRole::Displacement).ok_or_else(|| {
            let found = "no displacement map";
            let allowed = "an image named displacement, disp, height, heightmap or bump, or one \
                           of a single channel";
            Error::invalid(&self.folder, Place::File, "texture set", found, allowed)
        })
    }

    /// Reads the displacement map as `options` say.
    ///
    /// # Errors
    /// Of [`TextureSet::displacement`] and of the file.
    pub fn heights(&self, options: &HeightOptions, limits: &Limits) -> Result<HeightMap> {
        options.read(&self.displacement()?.path, limits)
    }

    /// Compares the author's normal map with `heights`, if there is one.
    ///
    /// # Errors
    /// Of the normal map's file.
    pub fn agreement(
        &self,
        heights: &HeightMap,
        limits: &Limits,
    ) -> Result<Option<NormalAgreement>> {
        let Some(map) = self.map(MapRole::Normal) else { return Ok(None) };
        let (lattice, wrap) = (heights.x().lattice(), heights.x().wrap());
        let options = NormalOptions { convention: NormalConvention::OpenGl, lattice, wrap };
        let normals = options.read(&map.path, limits)?;
        Ok(Some(NormalAgreement::of(heights, &normals)))
    }
}

impl SetMap {
    /// Sorts files for one role, the best first.
    fn order(&self) -> (u8, std::cmp::Reverse<(u64, u32)>, PathBuf) {
        let convention = match self.convention {
            Some(NormalConvention::OpenGl) => 0,
            Some(NormalConvention::DirectX) => 1,
            None => 2,
        };
        let pixels = u64::from(self.image.width) * u64::from(self.image.height);
        let bits = match self.image.sample {
            SampleKind::F32 => 32,
            _ => self.image.file_bits,
        };
        (convention, std::cmp::Reverse((pixels, bits)), self.path.clone())
    }
}

/// The path with `<UDIM>` in place of the number of a tile, if the last word of its stem is one.
fn tiled(path: PathBuf) -> PathBuf {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let Some((stem, ending)) = name.rsplit_once('.') else { return path };
    let Some(cut) = stem.rfind(['.', '_', '-']) else { return path };
    match number(&stem[cut + 1..]) {
        Some(_) => path.with_file_name(format!("{}{MARK}.{ending}", &stem[..=cut])),
        None => path,
    }
}

/// The images and the MaterialX files of a folder, by name.
fn files(folder: &Path) -> Result<(Vec<PathBuf>, Vec<PathBuf>)> {
    let fail = |e| Error::io(folder, e);
    let (mut images, mut documents) = (Vec::new(), Vec::new());
    for (count, entry) in fs::read_dir(folder).map_err(fail)?.enumerate() {
        if count == MAX_ENTRIES {
            let found = format!("more than {MAX_ENTRIES} files");
            return Err(Error::invalid(folder, Place::File, "texture set", found, "fewer"));
        }
        let path = entry.map_err(fail)?.path();
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match ending.as_str() {
            "mtlx" => documents.push(path),
            ending if ENDINGS.contains(&ending) && path.is_file() => images.push(tiled(path)),
            _ => {}
        }
    }
    images.sort();
    images.dedup();
    documents.sort();
    Ok((images, documents))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{write_png_grey16, write_png_rgb8};

    fn grey(folder: &Path, name: &str, side: u32) {
        let count = (side * side) as usize;
        let codes: Vec<u16> = (0..count).map(|k| (k * 65535 / count) as u16).collect();
        write_png_grey16(&folder.join(name), [side; 2], &codes).unwrap();
    }

    fn rgb(folder: &Path, name: &str) {
        write_png_rgb8(&folder.join(name), [4, 4], &[[128, 128, 255]; 16]).unwrap();
    }

    #[test]
    fn the_largest_file_of_a_role_is_taken_and_the_rest_is_named() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path();
        grey(folder, "a_disp_1k.png", 4);
        grey(folder, "a_disp_2k.png", 8);
        grey(folder, "a_bump.png", 16);
        rgb(folder, "a_NormalDX.png");
        rgb(folder, "a_NormalGL.png");
        rgb(folder, "preview.png");
        fs::write(folder.join("a_rough.png"), "no image").unwrap();
        fs::write(folder.join("a_color.txt"), "no image").unwrap();
        let set = TextureSet::find(folder, &Limits::default()).unwrap();
        let name = |role| set.map(role).map(|m| m.path.file_name().unwrap().to_str().unwrap());
        assert_eq!(name(MapRole::Displacement), Some("a_disp_2k.png"));
        assert_eq!(name(MapRole::Normal), Some("a_NormalGL.png"));
        assert_eq!((name(MapRole::Albedo), name(MapRole::Roughness)), (None, None));
        assert_eq!((set.maps.len(), set.passed_over.len()), (2, 5));
    }

    #[test]
    fn a_folder_with_one_grey_image_is_terrain() {
        let dir = tempfile::tempdir().unwrap();
        grey(dir.path(), "somewhere_n40.png", 4);
        rgb(dir.path(), "look.png");
        let set = TextureSet::find(dir.path(), &Limits::default()).unwrap();
        assert_eq!(set.displacement().unwrap().told, Told::Nothing);
        let heights = set.heights(&HeightOptions::default(), &Limits::default()).unwrap();
        let assumed = set.assumed(&heights, &Limits::default()).unwrap();
        assert_eq!((assumed.zero, assumed.scale), (0.5, 0.05));
    }

    #[test]
    fn tiles_are_one_map() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["a_disp.1001.png", "a_disp.1002.png", "a_Color_1001.png"] {
            grey(dir.path(), name, 4);
        }
        let set = TextureSet::find(dir.path(), &Limits::default()).unwrap();
        let displacement = set.displacement().unwrap();
        assert!(displacement.path.ends_with("a_disp.<UDIM>.png"));
        assert_eq!((displacement.image.width, displacement.image.height), (8, 4));
        assert!(set.map(MapRole::Albedo).unwrap().path.ends_with("a_Color_<UDIM>.png"));
        assert_eq!((set.maps.len(), set.passed_over.len()), (2, 0));
    }

    #[test]
    fn a_materialx_file_goes_before_names() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path();
        fs::create_dir(folder.join("tex")).unwrap();
        grey(folder, "tex/one.png", 4);
        grey(folder, "a_disp.png", 8);
        rgb(folder, "a_color.png");
        let text = r#"<materialx><image name="i" type="float"><input name="file" value="tex/one.png"/></image>
            <displacement name="d"><input name="displacement" nodename="i"/>
            <input name="scale" value="0.25"/></displacement></materialx>"#;
        fs::write(folder.join("a.mtlx"), text).unwrap();
        let limits = Limits::default();
        let set = TextureSet::find(folder, &limits).unwrap();
        let displacement = set.displacement().unwrap();
        assert!(displacement.path.ends_with("tex/one.png") && displacement.told == Told::Document);
        assert_eq!(set.map(MapRole::Albedo).unwrap().told, Told::Name);
        let heights = set.heights(&HeightOptions::default(), &limits).unwrap();
        let assumed = set.assumed(&heights, &limits).unwrap();
        assert_eq!((assumed.scale, assumed.zero), (0.25, 0.0));
        fs::write(folder.join("a.mtlx"), "<").unwrap();
        assert!(TextureSet::find(folder, &limits).is_err());
    }

    #[test]
    fn folders_without_maps_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let limits = Limits::default();
        rgb(dir.path(), "look.png");
        let message = TextureSet::find(dir.path(), &limits).unwrap_err().to_string();
        assert!(message.contains("no map among 1 images"), "{message}");
        rgb(dir.path(), "a_color.png");
        let set = TextureSet::find(dir.path(), &limits).unwrap();
        let message = set.displacement().unwrap_err().to_string();
        assert!(message.contains("no displacement map; allowed"), "{message}");
        let none = dir.path().join("none");
        assert!(matches!(TextureSet::find(&none, &limits), Err(Error::Io { .. })));
    }
}
