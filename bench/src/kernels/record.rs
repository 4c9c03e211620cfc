//! [`Record`]: one line of `kernels --json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::rays::Family;

/// One contender on one row: a map, a size, a family, single rays or packets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Always `kernels`.
    pub bench: String,
    pub map: String,
    /// Samples a side.
    pub size: u32,
    /// Scene units of height 1, on a unit square.
    pub depth: f64,
    pub family: Family,
    /// Whether the rays come in packets; such rows compare packets with packets.
    pub packet: bool,
    /// Rays given to the contender at once.
    pub rays_a_call: usize,
    pub contender: String,
    /// Million rays a second of one thread's processor time, the median pass.
    pub mrays_per_s: f64,
    /// (slowest - fastest) / median pass.
    pub spread: f64,
    pub passes: usize,
    pub rays: u64,
    pub hits: u64,
    /// Mean ray parameter of the hits, where it is known.
    pub mean_t: Option<f64>,
    /// Processor seconds from the heights to the first ray, one thread.
    pub build_seconds: f64,
    pub build_wall_seconds: f64,
    /// Bytes held beyond the 16-bit heights, for each sample of the map.
    pub bytes_per_texel: f64,
    /// The same at the worst moment of the build.
    pub peak_bytes_per_texel: f64,
    /// Versions, flags and calls.
    pub against: BTreeMap<String, String>,
}

impl Record {
    /// Whether `other` measures the same work: the map, the rays, their packets.
    pub fn is_same_work(&self, other: &Self) -> bool {
        let key = |r: &Self| (r.size, r.family, r.packet, r.rays, r.depth.to_bits());
        self.map == other.map && key(self) == key(other)
    }

    /// The SIMD level of rilievo's kernel; none for peers.
    pub fn simd(&self) -> Option<&str> {
        self.against.get("simd").map(String::as_str)
    }

    /// Whether `other` measures the same work of the same contender, called alike.
    pub fn is_same_row(&self, other: &Self) -> bool {
        let key = |r: &Self| (r.rays_a_call, r.simd().map(str::to_owned));
        self.is_same_work(other) && self.contender == other.contender && key(self) == key(other)
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A record with the given rate.
    pub fn example(contender: &str, family: Family, packet: bool, rate: f64) -> Record {
        Record {
            bench: "kernels".to_owned(),
            map: "fbm".to_owned(),
            size: 1024,
            depth: 0.1,
            family,
            packet,
            rays_a_call: 1,
            contender: contender.to_owned(),
            mrays_per_s: rate,
            spread: 0.01,
            passes: 5,
            rays: 100,
            hits: 50,
            mean_t: None,
            build_seconds: 0.5,
            build_wall_seconds: 0.5,
            bytes_per_texel: 0.27,
            peak_bytes_per_texel: 0.27,
            against: BTreeMap::from([("call".to_owned(), "x".to_owned())]),
        }
    }

    #[test]
    fn a_line_has_the_fixed_keys_and_is_read_back() {
        let record = example("embree-grid", Family::Primary16, true, 9.5);
        let line = serde_json::to_string(&record).unwrap();
        assert!(!line.contains('\n'));
        let value: serde_json::Value = serde_json::from_str(&line).unwrap();
        for key in ["map", "contender"] {
            assert!(value[key].is_string(), "{key}");
        }
        for key in ["size", "mrays_per_s", "build_seconds", "bytes_per_texel", "rays", "hits"] {
            assert!(value[key].is_number(), "{key}");
        }
        assert_eq!(value["family"], "primary16");
        assert_eq!(value["packet"], true);
        assert!(value["against"].is_object());
        assert_eq!(serde_json::from_str::<Record>(&line).unwrap(), record);
    }
}
