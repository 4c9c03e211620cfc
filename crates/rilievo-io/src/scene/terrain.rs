//! Terrain: a map is laid out in the metres that its file gives.
//!
//! u runs east, along +x; v north, along +y; heights are along +z. The map keeps its lattice: on the
//! vertex lattice the outermost samples lie on the border, on the texel lattice half a cell inside.

use rilievo::glam::DVec3;
use rilievo::map::{Lattice, Samples};

use super::file::{GroundEntry, MapSource, QuadEntry, SceneFile};
use super::syntax::Located;
use crate::error::{Error, Result};
use crate::image::{HeightOptions, Terrain, read_image_info};
use crate::limits::Limits;

impl SceneFile {
    /// Gives a terrain its corners, scale and zero; says in a line what they are.
    pub(super) fn lay_out(
        &self,
        quad: &mut QuadEntry,
        ground: &GroundEntry,
        limits: &Limits,
    ) -> Result<Option<String>> {
        let Some(entry) = &mut quad.displacement else { return Ok(None) };
        let index = self.find(&entry.map, &self.maps, "map")?;
        let map = &self.maps[index].1;
        let MapSource::File { file, invert } = &map.source else {
            let fault =
                self.document().fault(&entry.map.at, "map", "not a file", "a map of a file");
            return Err(Error::Invalid(Box::new(fault)));
        };
        let path = self.beside(&file.value);
        let refer = |e| self.referenced(file, "terrain", e);
        let terrain = Terrain::read(&path, limits).map_err(refer)?;
        let Some(cell) = ground.cell.or(terrain.map(|t| t.cell)) else {
            let found = "the file does not say how large a cell is";
            let allowed = "`cell = [metres, metres]` in the shape";
            let fault = self.document().fault(&ground.at, "terrain", found, allowed);
            return Err(Error::Invalid(Box::new(fault)));
        };
        let image = read_image_info(&path, limits).map_err(refer)?;
        let steps = |samples: u32| match map.lattice {
            Lattice::Vertex => f64::from(samples.max(2) - 1),
            Lattice::Texel => f64::from(samples),
        };
        let metre = terrain.map_or(1.0, |t| t.metre);
        let options = HeightOptions { lattice: map.lattice, wrap: map.wrap, invert: *invert };
        let (heights, voids) = options.read_with_voids(&path, limits).map_err(refer)?;
        // Of codes a height of 1 is 65535 units.
        let metres = metre
            * match heights.samples() {
                Samples::U16(_) => 65535.0,
                Samples::F32(_) => 1.0,
            };
        let lowest = f64::from(heights.raw_range().0) * heights.unit() * metres;
        let zero = ground.zero.unwrap_or(lowest);
        entry.displacement.scale = metres * ground.exaggeration / ground.unit;
        entry.displacement.zero = zero / metres;
        let half = DVec3::new(steps(image.width) * cell[0], steps(image.height) * cell[1], 0.0)
            * (0.5 / ground.unit);
        let corner = |x: f64, y: f64| ground.center + DVec3::new(x * half.x, y * half.y, 0.0);
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        quad.corners = Located { value: corners, at: ground.at.clone() };
        let [x, y] = [image.width, image.height].map(steps);
        Ok(Some(format!(
            "{}: terrain of {:.0} x {:.0} m, cells of {:.2} x {:.2} m, {zero:.1} m at the centre's \
             height; {voids} samples without a measurement, filled with the lowest",
            path.display(),
            x * cell[0],
            y * cell[1],
            cell[0],
            cell[1],
        )))
    }
}
