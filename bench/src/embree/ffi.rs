//! What the bench uses of `<embree3/rtcore.h>`, version 3.13.5, by the names of the header.
//!
//! Layouts are those of a 64-bit Linux build with `RTC_MAX_INSTANCE_LEVEL_COUNT` 1 and
//! `RTC_MIN_WIDTH` 0, as Debian's; the tests compare them with what a C compiler says. A build with
//! other settings needs other structs: [`super::Scene`] refuses other versions.

use std::ffi::{c_char, c_int, c_uint, c_void};

/// `RTCDeviceTy`, opaque.
#[repr(C)]
pub struct DeviceTy {
    private: [u8; 0],
}

/// `RTCSceneTy`, opaque.
#[repr(C)]
pub struct SceneTy {
    private: [u8; 0],
}

/// `RTCGeometryTy`, opaque.
#[repr(C)]
pub struct GeometryTy {
    private: [u8; 0],
}

// rtcore_config.h
pub const VERSION: isize = 31305;

// rtcore_common.h
pub const INVALID_GEOMETRY_ID: c_uint = c_uint::MAX;
pub const FORMAT_UINT3: c_uint = 0x5003;
pub const FORMAT_UINT4: c_uint = 0x5004;
pub const FORMAT_FLOAT3: c_uint = 0x9003;
pub const FORMAT_GRID: c_uint = 0xA001;
pub const BUILD_QUALITY_MEDIUM: c_uint = 1;
pub const CONTEXT_FLAG_INCOHERENT: c_uint = 0;
pub const CONTEXT_FLAG_COHERENT: c_uint = 1;

// rtcore_device.h
pub const DEVICE_PROPERTY_VERSION: c_uint = 0;
pub const ERROR_NONE: c_uint = 0;

// rtcore_buffer.h
pub const BUFFER_TYPE_INDEX: c_uint = 0;
pub const BUFFER_TYPE_VERTEX: c_uint = 1;
pub const BUFFER_TYPE_GRID: c_uint = 8;

// rtcore_geometry.h
pub const GEOMETRY_TYPE_TRIANGLE: c_uint = 0;
pub const GEOMETRY_TYPE_QUAD: c_uint = 1;
pub const GEOMETRY_TYPE_GRID: c_uint = 2;

// rtcore_scene.h
pub const SCENE_FLAG_NONE: c_uint = 0;
pub const SCENE_FLAG_COMPACT: c_uint = 1 << 1;
pub const SCENE_FLAG_ROBUST: c_uint = 1 << 2;

/// `RTCMemoryMonitorFunction`.
pub type MemoryMonitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;

/// `rtcIntersect8` and `rtcIntersect16`.
pub type Intersect<const N: usize> =
    unsafe extern "C" fn(*const c_int, *mut SceneTy, *mut Context, *mut RayHitPacket<N>);

/// `rtcOccluded8` and `rtcOccluded16`.
pub type Occlude<const N: usize> =
    unsafe extern "C" fn(*const c_int, *mut SceneTy, *mut Context, *mut RayPacket<N>);

/// `RTCIntersectContext`.
#[repr(C)]
pub struct Context {
    pub flags: c_uint,
    pub filter: Option<unsafe extern "C" fn(*const c_void)>,
    pub inst_id: [c_uint; 1],
}

/// `RTCGrid`.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct Grid {
    pub start_vertex_id: c_uint,
    pub stride: c_uint,
    pub width: u16,
    pub height: u16,
}

/// `RTCRay`.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
pub struct Ray {
    pub org: [f32; 3],
    pub tnear: f32,
    pub dir: [f32; 3],
    pub time: f32,
    pub tfar: f32,
    pub mask: c_uint,
    pub id: c_uint,
    pub flags: c_uint,
}

/// `RTCHit`.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
pub struct Hit {
    pub ng: [f32; 3],
    pub u: f32,
    pub v: f32,
    pub prim_id: c_uint,
    pub geom_id: c_uint,
    pub inst_id: [c_uint; 1],
}

/// `RTCRayHit`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct RayHit {
    pub ray: Ray,
    pub hit: Hit,
}

/// `RTCRay8` and `RTCRay16`. Both sizes are multiples of 64 bytes, so the stricter alignment of the
/// larger one changes nothing else.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub struct RayPacket<const N: usize> {
    pub org: [[f32; N]; 3],
    pub tnear: [f32; N],
    pub dir: [[f32; N]; 3],
    pub time: [f32; N],
    pub tfar: [f32; N],
    pub mask: [c_uint; N],
    pub id: [c_uint; N],
    pub flags: [c_uint; N],
}

/// `RTCHit8` and `RTCHit16`.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub struct HitPacket<const N: usize> {
    pub ng: [[f32; N]; 3],
    pub u: [f32; N],
    pub v: [f32; N],
    pub prim_id: [c_uint; N],
    pub geom_id: [c_uint; N],
    pub inst_id: [[c_uint; N]; 1],
}

/// `RTCRayHit8` and `RTCRayHit16`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct RayHitPacket<const N: usize> {
    pub ray: RayPacket<N>,
    pub hit: HitPacket<N>,
}

/// The lanes of a packet that are traced: -1 yes, 0 no.
#[repr(C, align(64))]
pub struct Valid<const N: usize>(pub [c_int; N]);

#[link(name = "embree3")]
unsafe extern "C" {
    pub fn rtcNewDevice(config: *const c_char) -> *mut DeviceTy;
    pub fn rtcReleaseDevice(device: *mut DeviceTy);
    pub fn rtcGetDeviceProperty(device: *mut DeviceTy, property: c_uint) -> isize;
    pub fn rtcGetDeviceError(device: *mut DeviceTy) -> c_uint;
    pub fn rtcSetDeviceMemoryMonitorFunction(
        device: *mut DeviceTy,
        monitor: Option<MemoryMonitor>,
        user: *mut c_void,
    );

    pub fn rtcNewGeometry(device: *mut DeviceTy, kind: c_uint) -> *mut GeometryTy;
    pub fn rtcReleaseGeometry(geometry: *mut GeometryTy);
    pub fn rtcSetGeometryBuildQuality(geometry: *mut GeometryTy, quality: c_uint);
    pub fn rtcSetNewGeometryBuffer(
        geometry: *mut GeometryTy,
        kind: c_uint,
        slot: c_uint,
        format: c_uint,
        byte_stride: usize,
        item_count: usize,
    ) -> *mut c_void;
    pub fn rtcCommitGeometry(geometry: *mut GeometryTy);

    pub fn rtcNewScene(device: *mut DeviceTy) -> *mut SceneTy;
    pub fn rtcReleaseScene(scene: *mut SceneTy);
    pub fn rtcSetSceneFlags(scene: *mut SceneTy, flags: c_uint);
    pub fn rtcSetSceneBuildQuality(scene: *mut SceneTy, quality: c_uint);
    pub fn rtcAttachGeometry(scene: *mut SceneTy, geometry: *mut GeometryTy) -> c_uint;
    pub fn rtcCommitScene(scene: *mut SceneTy);

    pub fn rtcIntersect1(scene: *mut SceneTy, context: *mut Context, rayhit: *mut RayHit);
    pub fn rtcIntersect8(
        valid: *const c_int,
        scene: *mut SceneTy,
        context: *mut Context,
        rayhit: *mut RayHitPacket<8>,
    );
    pub fn rtcIntersect16(
        valid: *const c_int,
        scene: *mut SceneTy,
        context: *mut Context,
        rayhit: *mut RayHitPacket<16>,
    );
    pub fn rtcOccluded1(scene: *mut SceneTy, context: *mut Context, ray: *mut Ray);
    pub fn rtcOccluded8(
        valid: *const c_int,
        scene: *mut SceneTy,
        context: *mut Context,
        ray: *mut RayPacket<8>,
    );
    pub fn rtcOccluded16(
        valid: *const c_int,
        scene: *mut SceneTy,
        context: *mut Context,
        ray: *mut RayPacket<16>,
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::{align_of, offset_of, size_of};

    /// Printed by a C program over the header of 3.13.5 with gcc 12 on x86_64 Linux.
    #[test]
    fn layouts_are_the_headers() {
        assert_eq!((size_of::<Ray>(), align_of::<Ray>()), (48, 16));
        assert_eq!((size_of::<Hit>(), align_of::<Hit>()), (32, 16));
        assert_eq!((size_of::<RayHit>(), align_of::<RayHit>()), (80, 16));
        assert_eq!((size_of::<Context>(), align_of::<Context>()), (24, 8));
        assert_eq!((size_of::<Grid>(), align_of::<Grid>()), (12, 4));
        assert_eq!([offset_of!(Ray, tnear), offset_of!(Ray, dir)], [12, 16]);
        assert_eq!([offset_of!(Ray, time), offset_of!(Ray, tfar)], [28, 32]);
        assert_eq!([offset_of!(Ray, mask), offset_of!(Ray, flags)], [36, 44]);
        assert_eq!([offset_of!(Hit, u), offset_of!(Hit, prim_id)], [12, 20]);
        assert_eq!([offset_of!(Hit, geom_id), offset_of!(Hit, inst_id)], [24, 28]);
        assert_eq!([offset_of!(RayHit, ray), offset_of!(RayHit, hit)], [0, 48]);
        assert_eq!([offset_of!(Context, filter), offset_of!(Context, inst_id)], [8, 16]);
        assert_eq!([offset_of!(Grid, stride), offset_of!(Grid, width)], [4, 8]);
        assert_eq!(offset_of!(Grid, height), 10);
    }

    #[test]
    fn layouts_of_packets_are_the_headers() {
        assert_eq!([size_of::<RayPacket<8>>(), size_of::<RayPacket<16>>()], [384, 768]);
        assert_eq!([size_of::<HitPacket<8>>(), size_of::<HitPacket<16>>()], [256, 512]);
        assert_eq!([size_of::<RayHitPacket<8>>(), size_of::<RayHitPacket<16>>()], [640, 1280]);
        // The header asks for 32 and 64.
        assert_eq!([align_of::<RayPacket<8>>(), align_of::<RayPacket<16>>()], [64, 64]);
        let of8 = [offset_of!(RayPacket<8>, tnear), offset_of!(RayPacket<8>, tfar)];
        assert_eq!((of8, offset_of!(RayPacket<8>, flags)), ([96, 256], 352));
        let of8 = [offset_of!(HitPacket<8>, geom_id), offset_of!(HitPacket<8>, inst_id)];
        assert_eq!((of8, offset_of!(RayHitPacket<8>, hit)), ([192, 224], 384));
        let of16 = [offset_of!(RayPacket<16>, tnear), offset_of!(RayPacket<16>, tfar)];
        assert_eq!((of16, offset_of!(RayPacket<16>, flags)), ([192, 512], 704));
        let of16 = [offset_of!(HitPacket<16>, geom_id), offset_of!(HitPacket<16>, inst_id)];
        assert_eq!((of16, offset_of!(RayHitPacket<16>, hit)), ([384, 448], 768));
    }
}
