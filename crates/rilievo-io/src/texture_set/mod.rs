//! [`TextureSet`]: a folder with the maps of one material, as asset libraries ship them.
//!
//! Which file is what is told by its name (see [`naming`]); of several files for one role the
//! largest is taken, of equal ones that with more bits. Where no name says displacement, the
//! largest image of one channel that no other role claims is taken for it: folders of terrain are
//! so.
//!
//! **What is assumed.** A folder does not say how deep its displacement is, nor which height stays
//! in place. [`TextureSet::assumed`] takes 0.5 for the zero level, as these libraries make their
//! maps, and for the depth what the author's normal map says, where it agrees with the heights
//! (see [`NormalAgreement`]) and says 1 to 30 % of the map's width; otherwise 5 %. A map of numbers
//! or metres is brought to 10 % of the width from its lowest to its highest sample. All of it is
//! reported, none of it is hidden.

mod naming;
mod presentation;

use std::fs;
use std::path::{Path, PathBuf};

use rilievo::map::{HeightMap, NormalAgreement, NormalConvention, Samples};

pub use naming::MapRole;
pub(crate) use presentation::ground;

use crate::error::{Error, Place, Result};
use crate::image::{HeightOptions, ImageInfo, NormalOptions, SampleKind, read_image_info};
use crate::limits::Limits;

/// Endings of files that are looked at.
const ENDINGS: [&str; 12] =
    ["png", "jpg", "jpeg", "tif", "tiff", "exr", "pfm", "asc", "hgt", "bil", "r16", "r32"];
/// Most entries of a folder.
const MAX_ENTRIES: usize = 10_000;
/// The height that stays in place without a better word for it.
const ZERO: f64 = 0.5;
/// Depth without a better word for it, in widths of the map.
const DEPTH: f64 = 0.05;
/// Depth of a map of numbers or metres from its lowest to its highest sample.
const TERRAIN_DEPTH: f64 = 0.1;
/// Depths that are believed when normals say so.
const BELIEVED: std::ops::RangeInclusive<f64> = 0.01..=0.3;
/// Correlation of slopes from which normals and heights are of the same relief.
const SAME_RELIEF: f64 = 0.5;

/// A map of a set.
#[derive(Clone, Debug, PartialEq)]
pub struct SetMap {
    /// What it is for.
    pub role: MapRole,
    /// Its file.
    pub path: PathBuf,
    /// Of a normal map: what its name says of green.
    pub convention: Option<NormalConvention>,
    /// Whether its role was told by its name; otherwise it is what was left.
    pub named: bool,
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
}

/// What is assumed of a set's displacement.
#[derive(Clone, Debug, PartialEq)]
pub struct Assumed {
    /// The height that stays in place.
    pub zero: f64,
    /// Displacement of a height of 1, in widths of the map.
    pub scale: f64,
    /// Whether black is high.
    pub invert: bool,
    /// Where scale and invert come from, in words.
    pub why: String,
    /// How the author's normal map agrees, if there is one.
    pub agreement: Option<NormalAgreement>,
}

impl TextureSet {
    /// Finds the maps of a folder.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Invalid`] for a folder without an image whose role can be told.
    pub fn find(folder: &Path, limits: &Limits) -> Result<Self> {
        let mut set = Self { folder: folder.to_owned(), maps: Vec::new(), passed_over: Vec::new() };
        let mut unnamed = Vec::new();
        let mut ranked: Vec<(bool, SetMap)> = Vec::new();
        for path in images(folder)? {
            let Ok(image) = read_image_info(&path, limits) else {
                set.passed_over.push((path, "cannot be read"));
                continue;
            };
            let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            match naming::meaning(&stem) {
                Some(m) => {
                    let (role, convention) = (m.role, m.convention);
                    let map = SetMap { role, path, convention, named: true, image };
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
                self.maps.push(SetMap { role, path, convention: None, named: false, image });
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
            let why = if map.named { "" } else { ", for want of a name" };
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

    /// What is assumed of the displacement, for heights that were read without `invert`.
    ///
    /// # Errors
    /// Of the normal map's file.
    pub fn assumed(&self, heights: &HeightMap, limits: &Limits) -> Result<Assumed> {
        let agreement = self.agreement(heights, limits)?;
        let mut assumed = Assumed::of(heights, &self.displacement()?.path);
        assumed.agreement = agreement;
        if is_measured(heights, &self.displacement()?.path) {
            return Ok(assumed);
        }
        if let Some(a) = agreement {
            let same = a.correlation.iter().all(|c| c.abs() >= SAME_RELIEF);
            assumed.invert = same && a.inverted;
            if !same {
                assumed.why = "the normal map is of another relief: the usual depth".to_owned();
            } else if BELIEVED.contains(&a.depth) {
                assumed.scale = a.depth;
                assumed.why = "the depth that the normal map fits".to_owned();
            } else {
                assumed.why = format!(
                    "the normal map fits a depth of {:.4}, which is not believed: the usual one",
                    a.depth
                );
            }
        }
        Ok(assumed)
    }
}

impl Assumed {
    /// What is assumed of heights alone, read from `path`.
    pub fn of(heights: &HeightMap, path: &Path) -> Self {
        let (low, high) = heights.raw_range();
        let [low, high] = [low, high].map(|raw| f64::from(raw) * heights.unit());
        let (zero, scale, why) = match is_measured(heights, path) && high > low {
            true => (
                low,
                TERRAIN_DEPTH / (high - low),
                "numbers or metres, from lowest to highest a tenth of the width",
            ),
            false => (ZERO, DEPTH, "no word on the depth: the usual one"),
        };
        Self { zero, scale, invert: false, why: why.to_owned(), agreement: None }
    }

    /// The assumptions in one line.
    pub fn describe(&self) -> String {
        let Self { zero, scale, .. } = self;
        let black = if self.invert { "; black is high, as the normal map says" } else { "" };
        format!("assumed zero {zero}, depth {scale:.6} of the width ({}){black}", self.why)
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

/// Whether heights are metres or other numbers rather than shares of a depth.
fn is_measured(heights: &HeightMap, path: &Path) -> bool {
    let (low, high) = heights.raw_range();
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().to_lowercase();
    let numbers = matches!(heights.samples(), Samples::F32(_)) && (low < -1.0 || high > 2.0);
    numbers || stem.contains("metres") || stem.contains("meters")
}

/// The images of a folder, by name.
fn images(folder: &Path) -> Result<Vec<PathBuf>> {
    let fail = |e| Error::io(folder, e);
    let mut all = Vec::new();
    for (count, entry) in fs::read_dir(folder).map_err(fail)?.enumerate() {
        if count == MAX_ENTRIES {
            let found = format!("more than {MAX_ENTRIES} files");
            return Err(Error::invalid(folder, Place::File, "texture set", found, "fewer"));
        }
        let path = entry.map_err(fail)?.path();
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        if ENDINGS.contains(&ending.as_str()) && path.is_file() {
            all.push(path);
        }
    }
    all.sort();
    Ok(all)
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
        assert!(!set.displacement().unwrap().named);
        let heights = set.heights(&HeightOptions::default(), &Limits::default()).unwrap();
        let assumed = set.assumed(&heights, &Limits::default()).unwrap();
        assert_eq!((assumed.zero, assumed.scale), (0.5, DEPTH));
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
