//! Displaced spheres of a scene, and the maps resampled for them.

use std::sync::Arc;

use rilievo::map::{ResamplingError, Tiling};
use rilievo::relief::{CubeRelief, Displacement, ReliefSphere, ReliefSphereError, SphereOptions};

use super::file::{DisplacementEntry, Shape, SphereEntry};
use super::load_map::{self, Face, Needs};
use super::resolve::Loader;
use super::syntax::Located;
use crate::error::Result;

/// A map of a scene, resampled for spheres.
#[derive(Clone, Debug)]
pub struct LoadedSphereMap {
    /// Its name in the scene.
    pub name: String,
    /// Samples of the map itself, along u and v.
    pub size: [u32; 2],
    /// Heights and pyramids, shared by the spheres.
    pub relief: Arc<CubeRelief>,
    /// How far these heights are off the map's, if [`LoadOptions::resampling_error`](super::LoadOptions::resampling_error) asks.
    pub error: Option<ResamplingError>,
}

impl LoadedSphereMap {
    /// What a list of maps is sorted by.
    pub(super) fn order(&self) -> (String, u32) {
        (self.name.clone(), self.relief.cells())
    }
}

/// Spheres whose displacements have this in common share a map: its name, tile and shift.
pub(super) type SphereMapKey<'a> = (&'a str, [[u64; 2]; 2]);

fn key(entry: &DisplacementEntry) -> SphereMapKey<'_> {
    let Displacement { tile, shift, .. } = entry.displacement;
    (&entry.map.value, [tile, shift].map(|pair| pair.map(f64::to_bits)))
}

impl<'a> Loader<'a> {
    /// Loads the maps of all displaced spheres, each once.
    pub(super) fn load_sphere_maps(&mut self) -> Result<()> {
        let mut all: Vec<(SphereMapKey<'a>, usize, &'a DisplacementEntry, Needs)> = Vec::new();
        for shape in &self.file.shapes {
            let Shape::Sphere(sphere) = &shape.shape else { continue };
            let Some(entry) = &sphere.displacement else { continue };
            let (key, index) = (key(entry), self.file.find(&entry.map, &self.file.maps, "map")?);
            let at = all.iter().position(|(k, ..)| *k == key).unwrap_or_else(|| {
                all.push((key, index, entry, Needs::default()));
                all.len() - 1
            });
            let sides = [2.0 * sphere.radius.value; 2];
            let face = Face { sides, scale: entry.displacement.scale };
            all[at].3.add(self.method(sphere.method), face);
        }
        for (key, index, entry, needs) in all {
            let Displacement { tile, shift, .. } = entry.displacement;
            let tiling = Located { value: Tiling { tile, shift }, at: entry.at.clone() };
            let (name, map) = &self.file.maps[index];
            let map = (name.value.as_str(), map);
            let (relief, size, error) =
                load_map::load_cube(self.file, map, &tiling, &needs, self.options)?;
            let map = LoadedSphereMap { name: name.value.clone(), size, relief, error };
            self.sphere_maps.insert(key, map);
        }
        Ok(())
    }

    /// A sphere whose map is loaded.
    pub(super) fn relief_sphere(
        &self,
        sphere: &SphereEntry,
        entry: &DisplacementEntry,
    ) -> Result<ReliefSphere> {
        let map = &self.file.maps[self.file.find(&entry.map, &self.file.maps, "map")?].1;
        let options = SphereOptions {
            displacement: entry.displacement,
            method: self.method(sphere.method),
            normals: self.normals(&entry.normals, (map.lattice, map.wrap))?,
            simd: self.options.simd,
        };
        let relief = Arc::clone(&self.sphere_maps[&key(entry)].relief);
        ReliefSphere::new(sphere.center, sphere.radius.value, relief, options).map_err(|e| {
            let at = match e {
                ReliefSphereError::Center | ReliefSphereError::Radius(_) => &sphere.radius.at,
                _ => &entry.at,
            };
            self.file.invalid(at, "displacement", e.to_string(), String::new())
        })
    }
}
