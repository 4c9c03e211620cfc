//! Tracing whole batches, one ray or one packet a call.

use super::ffi::{self, INVALID_GEOMETRY_ID};
use super::scene::Scene;
use crate::rays::Ray32;
use crate::tally::Tally;

/// A ray in Embree's own format, made before the clock starts.
#[derive(Clone, Copy)]
pub struct Ray1(ffi::Ray);

/// Packets in Embree's own format.
pub enum Packets {
    Of8(Vec<ffi::RayPacket<8>>),
    Of16(Vec<ffi::RayPacket<16>>),
}

impl From<&Ray32> for Ray1 {
    fn from(ray: &Ray32) -> Self {
        Self(ffi::Ray {
            org: ray.origin,
            tnear: 0.0,
            dir: ray.direction,
            time: 0.0,
            tfar: ray.t_max,
            mask: u32::MAX,
            id: 0,
            flags: 0,
        })
    }
}

impl Packets {
    /// `rays` in packets of `width`, 8 or 16; none for another width. Rays that fill no packet are
    /// left out.
    pub fn of(rays: &[Ray32], width: usize) -> Option<Self> {
        match width {
            8 => Some(Self::Of8(packed(rays))),
            16 => Some(Self::Of16(packed(rays))),
            _ => None,
        }
    }
}

fn packed<const N: usize>(rays: &[Ray32]) -> Vec<ffi::RayPacket<N>> {
    let (packets, _) = rays.as_chunks::<N>();
    let pack = |rays: &[Ray32; N]| ffi::RayPacket {
        org: [0, 1, 2].map(|axis| rays.map(|ray| ray.origin[axis])),
        tnear: [0.0; N],
        dir: [0, 1, 2].map(|axis| rays.map(|ray| ray.direction[axis])),
        time: [0.0; N],
        tfar: rays.map(|ray| ray.t_max),
        mask: [u32::MAX; N],
        id: [0; N],
        flags: [0; N],
    };
    packets.iter().map(pack).collect()
}

fn context(coherent: bool) -> ffi::Context {
    let flags = if coherent { ffi::CONTEXT_FLAG_COHERENT } else { ffi::CONTEXT_FLAG_INCOHERENT };
    ffi::Context { flags, filter: None, inst_id: [INVALID_GEOMETRY_ID] }
}

/// No hit yet.
const NOTHING: ffi::Hit = ffi::Hit {
    ng: [0.0; 3],
    u: 0.0,
    v: 0.0,
    prim_id: INVALID_GEOMETRY_ID,
    geom_id: INVALID_GEOMETRY_ID,
    inst_id: [INVALID_GEOMETRY_ID],
};

fn no_hits<const N: usize>() -> ffi::HitPacket<N> {
    ffi::HitPacket {
        ng: [[0.0; N]; 3],
        u: [0.0; N],
        v: [0.0; N],
        prim_id: [INVALID_GEOMETRY_ID; N],
        geom_id: [INVALID_GEOMETRY_ID; N],
        inst_id: [[INVALID_GEOMETRY_ID; N]],
    }
}

impl Scene {
    /// Nearest hits by `rtcIntersect1`.
    pub fn closest(&self, rays: &[Ray1], coherent: bool) -> Tally {
        let mut tally = Tally::default();
        self.each_closest(rays, coherent, |t| {
            if let Some(t) = t {
                tally.hit(f64::from(t));
            }
        });
        tally
    }

    /// Calls `see` with the parameter of each ray's nearest hit, by `rtcIntersect1`.
    #[inline]
    pub fn each_closest(&self, rays: &[Ray1], coherent: bool, mut see: impl FnMut(Option<f32>)) {
        let mut context = context(coherent);
        for ray in rays {
            let mut both = ffi::RayHit { ray: ray.0, hit: NOTHING };
            // SAFETY: the scene is committed; context and ray are aligned, initialised and ours.
            unsafe { ffi::rtcIntersect1(self.as_ptr(), &raw mut context, &raw mut both) };
            see((both.hit.geom_id != INVALID_GEOMETRY_ID).then_some(both.ray.tfar));
        }
    }

    /// Whether there are hits, by `rtcOccluded1`.
    pub fn occluded(&self, rays: &[Ray1], coherent: bool) -> Tally {
        let (mut tally, mut context) = (Tally::default(), context(coherent));
        for ray in rays {
            let mut ray = ray.0;
            // SAFETY: as for `closest`.
            unsafe { ffi::rtcOccluded1(self.as_ptr(), &raw mut context, &raw mut ray) };
            // Embree's sign of a hit is a tfar of minus infinity.
            if ray.tfar < 0.0 {
                tally.hit(0.0);
            }
        }
        tally
    }

    /// Nearest hits by `rtcIntersect8` or `rtcIntersect16`.
    pub fn closest_packets(&self, packets: &Packets, coherent: bool) -> Tally {
        match packets {
            Packets::Of8(packets) => self.intersect(packets, ffi::rtcIntersect8, coherent),
            Packets::Of16(packets) => self.intersect(packets, ffi::rtcIntersect16, coherent),
        }
    }

    /// Whether there are hits, by `rtcOccluded8` or `rtcOccluded16`.
    pub fn occluded_packets(&self, packets: &Packets, coherent: bool) -> Tally {
        match packets {
            Packets::Of8(packets) => self.occlude(packets, ffi::rtcOccluded8, coherent),
            Packets::Of16(packets) => self.occlude(packets, ffi::rtcOccluded16, coherent),
        }
    }

    /// `call` is the header's function for packets of `N`.
    #[inline]
    fn intersect<const N: usize>(
        &self,
        packets: &[ffi::RayPacket<N>],
        call: ffi::Intersect<N>,
        coherent: bool,
    ) -> Tally {
        let (mut tally, mut context) = (Tally::default(), context(coherent));
        let valid = ffi::Valid([-1; N]);
        let Some(&first) = packets.first() else {
            return tally;
        };
        let mut both = ffi::RayHitPacket { ray: first, hit: no_hits() };
        for packet in packets {
            both.ray = *packet;
            both.hit.geom_id = [INVALID_GEOMETRY_ID; N];
            // SAFETY: the scene is committed; mask, context and packet are aligned, initialised and
            // of N lanes.
            unsafe { call(valid.0.as_ptr(), self.as_ptr(), &raw mut context, &raw mut both) };
            for (&id, &t) in both.hit.geom_id.iter().zip(&both.ray.tfar) {
                if id != INVALID_GEOMETRY_ID {
                    tally.hit(f64::from(t));
                }
            }
        }
        tally
    }

    /// `call` is the header's function for packets of `N`.
    #[inline]
    fn occlude<const N: usize>(
        &self,
        packets: &[ffi::RayPacket<N>],
        call: ffi::Occlude<N>,
        coherent: bool,
    ) -> Tally {
        let (mut tally, mut context) = (Tally::default(), context(coherent));
        let valid = ffi::Valid([-1; N]);
        for packet in packets {
            let mut packet = *packet;
            // SAFETY: as for `intersect`.
            unsafe { call(valid.0.as_ptr(), self.as_ptr(), &raw mut context, &raw mut packet) };
            for tfar in packet.tfar {
                if tfar < 0.0 {
                    tally.hit(0.0);
                }
            }
        }
        tally
    }
}
