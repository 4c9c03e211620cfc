//! [`Cache`]: what one loading of a scene leaves for the next.
//!
//! A program that shows a scene while it is edited loads it again after every change of its text. With
//! a cache only what the change touches is made anew: heights with their pyramids and distance maps,
//! cubes of spheres, images, models and texture sets are kept under the files and the keys they were
//! made from. What a file gave is used only while the file has the size and the time of change it had
//! then. Heights may be edited in place ([`Cache::edit`]); edited ones stay until their file changes.

use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt::Debug;
use std::fs;
use std::hash::Hash;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use rilievo::map::{CubeFace, DistanceKind, HeightMap, Layout, NormalMap, Tiling};
use rilievo::relief::{CubeRelief, Relief};
use rilievo_render::bsdf::GlassTable;
use rilievo_render::texture::ColourImage;

use super::file::{MapEntry, MapSource, SceneFile};
use super::materials::{Codes, ImageKey};
use super::options::LoadOptions;
use crate::error::Result;
use crate::image::{NormalOptions, read_colour};
use crate::mesh::Model;
use crate::texture_set::{Assumed, TextureSet};

/// Most cubes that are kept: each tiling of a sphere has one.
const MOST_CUBES: usize = 3;

/// Files as they were: size and time of the last change, none of a file that is not there.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stamp(Vec<Option<(u64, Option<SystemTime>)>>);

impl Stamp {
    /// How files and folders are now.
    pub fn of<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Self {
        let one = |path: &Path| {
            let data = fs::metadata(path).ok()?;
            Some((data.len(), data.modified().ok()))
        };
        Self(paths.into_iter().map(one).collect())
    }
}

/// Things by their keys, each with the files it was made from.
#[derive(Debug)]
struct Shelf<K, V> {
    things: RefCell<HashMap<K, (Stamp, V)>>,
    /// Of what was asked for in vain: the files before they are read.
    missed: RefCell<HashMap<K, Stamp>>,
}

impl<K, V> Default for Shelf<K, V> {
    fn default() -> Self {
        Self { things: RefCell::default(), missed: RefCell::default() }
    }
}

impl<K: Hash + Eq + Clone, V: Clone> Shelf<K, V> {
    fn get<'a>(&self, key: &K, files: impl IntoIterator<Item = &'a Path>) -> Option<V> {
        let now = Stamp::of(files);
        let things = self.things.borrow();
        match things.get(key) {
            Some((stamp, value)) if *stamp == now => Some(value.clone()),
            _ => {
                self.missed.borrow_mut().insert(key.clone(), now);
                None
            }
        }
    }

    /// Files that change while they are read count as they were before.
    fn put<'a>(&self, key: K, files: impl IntoIterator<Item = &'a Path>, value: V) {
        let mut things = self.things.borrow_mut();
        let missed = self.missed.borrow_mut().remove(&key);
        let kept = || things.get(&key).map(|(stamp, _)| stamp.clone());
        let stamp = missed.or_else(kept).unwrap_or_else(|| Stamp::of(files));
        things.insert(key, (stamp, value));
    }
}

/// What heights are made from, and how their samples are meant.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct MapKey {
    /// The file; none of a formula.
    file: Option<PathBuf>,
    rest: String,
}

impl MapKey {
    pub fn of(scene: &SceneFile, entry: &MapEntry) -> Self {
        let (file, source) = match &entry.source {
            MapSource::File { file, invert } => {
                (Some(scene.beside(&file.value)), format!("{invert}"))
            }
            MapSource::Procedural { shape, size, codes } => {
                (None, format!("{shape:?} {:?} {codes}", size.value))
            }
        };
        let baked = entry.distance.file.as_ref().map(|file| &file.value);
        let distance = (baked, entry.distance.size.as_ref().map(|s| s.value), entry.distance.bits);
        let rest = format!("{source} {:?} {:?} {distance:?}", entry.lattice, entry.wrap);
        Self { file, rest }
    }

    fn files(&self) -> impl Iterator<Item = &Path> {
        self.file.as_deref().into_iter()
    }
}

/// A map of a [`Cache`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeptMap(MapKey);

/// A map and how it was laid on a cube.
type CubeKey = (MapKey, String);

/// A cube, and along u and v the samples of its map.
type KeptCube = (Arc<CubeRelief>, [u32; 2]);

/// What one loading leaves for the next; see [`LoadOptions::cache`](super::LoadOptions::cache).
#[derive(Debug, Default)]
pub struct Cache {
    reliefs: Shelf<MapKey, Arc<Relief>>,
    cubes: Shelf<CubeKey, KeptCube>,
    /// Keys of cubes, the latest last.
    latest_cubes: RefCell<Vec<CubeKey>>,
    images: Shelf<ImageKey, Arc<ColourImage>>,
    models: Shelf<PathBuf, Model>,
    normals: Shelf<(PathBuf, String), Arc<NormalMap>>,
    sets: Shelf<PathBuf, (TextureSet, Assumed)>,
    glasses: RefCell<Vec<Arc<GlassTable>>>,
    /// Heights read to be judged that will be asked for next.
    judged: RefCell<Option<(PathBuf, HeightMap)>>,
}

/// The image of a file that is no material's, from the cache if it is there.
pub(super) fn colour_of_file(path: PathBuf, options: &LoadOptions<'_>) -> Result<Arc<ColourImage>> {
    let key = (path, Codes::Colour);
    let image = match options.cache.and_then(|cache| cache.image(&key)) {
        Some(image) => image,
        None => Arc::new(read_colour(&key.0, &options.limits)?),
    };
    if let Some(cache) = options.cache {
        cache.keep_image(key, &image);
    }
    Ok(image)
}

impl Cache {
    /// Which map of the cache these heights are, if they are one.
    pub fn map_of(&self, relief: &Arc<Relief>) -> Option<KeptMap> {
        let things = self.reliefs.things.borrow();
        let mut things = things.iter();
        let (key, _) = things.find(|(_, (_, kept))| Arc::ptr_eq(kept, relief))?;
        Some(KeptMap(key.clone()))
    }

    /// The heights of a map, if they are still kept.
    pub fn heights_of(&self, map: &KeptMap) -> Option<Arc<Relief>> {
        let things = self.reliefs.things.borrow();
        things.get(&map.0).map(|(_, relief)| Arc::clone(relief))
    }

    /// The heights of the map that a cube around a sphere was resampled from, if they are still kept.
    pub fn source_of(&self, cube: &Arc<CubeRelief>) -> Option<Arc<Relief>> {
        let cubes = self.cubes.things.borrow();
        let mut cubes = cubes.iter();
        let ((key, _), _) = cubes.find(|(_, (_, (kept, _)))| Arc::ptr_eq(kept, cube))?;
        self.heights_of(&KeptMap(key.clone()))
    }

    /// Changes the heights of a map, in place if no scene holds them; otherwise heights and pyramid are
    /// copied first. What `change` gives back, or none if they are gone.
    pub fn edit<T>(&self, map: &KeptMap, change: impl FnOnce(&mut Relief) -> T) -> Option<T> {
        let mut things = self.reliefs.things.borrow_mut();
        let (_, relief) = things.get_mut(&map.0)?;
        self.cubes.things.borrow_mut().retain(|(of, _), _| *of != map.0);
        Some(change(Arc::make_mut(relief)))
    }

    /// The heights of a map with this layout of bounds.
    pub(super) fn relief(&self, key: &MapKey, layout: Layout) -> Option<Arc<Relief>> {
        let relief = self.reliefs.get(key, key.files())?;
        if relief.pyramid().layout() == layout {
            return Some(relief);
        }
        let relief = Arc::new(Relief::with_layout(relief.heights().clone(), layout));
        self.keep_relief(key.clone(), &relief);
        Some(relief)
    }

    /// The heights of a map, whatever the layout of their bounds.
    pub(super) fn heights(&self, key: &MapKey) -> Option<HeightMap> {
        Some(self.reliefs.get(key, key.files())?.heights().clone())
    }

    pub(super) fn keep_relief(&self, key: MapKey, relief: &Arc<Relief>) {
        let file = key.file.clone();
        self.reliefs.put(key, file.as_deref(), Arc::clone(relief));
    }

    /// The cube of a map with these distance maps.
    pub(super) fn cube(
        &self,
        key: &MapKey,
        (tiling, layout): (Tiling, Layout),
        kinds: impl IntoIterator<Item = DistanceKind>,
    ) -> Option<KeptCube> {
        let key = (key.clone(), format!("{tiling:?} {layout:?}"));
        let (cube, size) = self.cubes.get(&key, key.0.files())?;
        let side = cube.face(CubeFace::PosX);
        let complete = kinds.into_iter().all(|kind| side.distance(kind).is_some());
        complete.then_some((cube, size))
    }

    pub(super) fn keep_cube(
        &self,
        key: MapKey,
        (tiling, layout): (Tiling, Layout),
        cube: KeptCube,
    ) {
        let key = (key, format!("{tiling:?} {layout:?}"));
        let file = key.0.file.clone();
        self.cubes.put(key.clone(), file.as_deref(), cube);
        let mut latest = self.latest_cubes.borrow_mut();
        latest.retain(|k| *k != key);
        latest.push(key);
        let extra = latest.len().saturating_sub(MOST_CUBES);
        for old in latest.drain(..extra) {
            self.cubes.things.borrow_mut().remove(&old);
        }
    }

    pub(super) fn image(&self, key: &ImageKey) -> Option<Arc<ColourImage>> {
        self.images.get(key, [key.0.as_path()])
    }

    pub(super) fn keep_image(&self, key: ImageKey, image: &Arc<ColourImage>) {
        let path = key.0.clone();
        self.images.put(key, [path.as_path()], Arc::clone(image));
    }

    pub(super) fn model(&self, path: &Path) -> Option<Model> {
        self.models.get(&path.to_owned(), [path])
    }

    pub(super) fn keep_model(&self, path: &Path, model: &Model) {
        self.models.put(path.to_owned(), [path], model.clone());
    }

    pub(super) fn normals(&self, path: &Path, options: &NormalOptions) -> Option<Arc<NormalMap>> {
        self.normals.get(&(path.to_owned(), format!("{options:?}")), [path])
    }

    pub(super) fn keep_normals(&self, path: &Path, options: &NormalOptions, map: &Arc<NormalMap>) {
        let key = (path.to_owned(), format!("{options:?}"));
        self.normals.put(key, [path], Arc::clone(map));
    }

    pub(super) fn set(&self, folder: &Path) -> Option<(TextureSet, Assumed)> {
        let files = |set: &TextureSet| -> Vec<PathBuf> {
            let maps = set.maps.iter().map(|map| map.path.clone());
            std::iter::once(set.folder.clone()).chain(maps).collect()
        };
        let of = files(&self.sets.things.borrow().get(folder)?.1.0);
        self.sets.get(&folder.to_owned(), of.iter().map(PathBuf::as_path))
    }

    pub(super) fn keep_set(&self, folder: &Path, set: &TextureSet, assumed: &Assumed) {
        let maps = set.maps.iter().map(|map| map.path.as_path());
        let files: Vec<_> = std::iter::once(set.folder.as_path()).chain(maps).collect();
        self.sets.put(folder.to_owned(), files, (set.clone(), assumed.clone()));
    }

    pub(super) fn glasses(&self) -> Vec<Arc<GlassTable>> {
        self.glasses.borrow().clone()
    }

    pub(super) fn keep_glasses(&self, glasses: Vec<Arc<GlassTable>>) {
        self.glasses.replace(glasses);
    }

    /// Puts heights of a file by that will be asked for next, read as they are, not inverted.
    pub(crate) fn keep_judged(&self, path: &Path, heights: HeightMap) {
        self.judged.replace(Some((path.to_owned(), heights)));
    }

    /// Those heights, once.
    pub(super) fn take_judged(&self, path: &Path) -> Option<HeightMap> {
        let mut judged = self.judged.borrow_mut();
        judged.take_if(|(of, _)| of == path).map(|(_, heights)| heights)
    }

    /// Those heights if nobody asked for them: nobody will.
    pub(super) fn drop_judged(&self) {
        self.judged.replace(None);
    }
}
