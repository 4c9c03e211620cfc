//! [`Device`]: one Embree device that counts the memory it holds.

use std::ffi::{CString, c_void};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicI64, Ordering};

use super::ffi;

/// Bytes that a device holds, and the most it ever held.
#[derive(Debug, Default)]
struct Ledger {
    held: AtomicI64,
    peak: AtomicI64,
}

/// A device of its own for each contender, so that memory is told apart.
pub struct Device {
    raw: NonNull<ffi::DeviceTy>,
    /// On the heap: the library keeps its address.
    ledger: Box<Ledger>,
}

impl Device {
    /// A device with an Embree configuration string such as `threads=1`.
    ///
    /// # Errors
    /// A configuration that Embree refuses, or a version whose structs are not those of
    /// [`ffi`].
    pub fn new(config: &str) -> Result<Self, String> {
        let config = CString::new(config).map_err(|e| e.to_string())?;
        // SAFETY: the string ends in a zero byte and lives through the call.
        let raw = unsafe { ffi::rtcNewDevice(config.as_ptr()) };
        let raw = NonNull::new(raw).ok_or("Embree refuses to make a device")?;
        let device = Self { raw, ledger: Box::default() };
        let version = device.version();
        if version / 100 != ffi::VERSION / 100 {
            return Err(format!("Embree {version} found; the bindings are for 3.13"));
        }
        let ledger: *const Ledger = &raw const *device.ledger;
        // SAFETY: the ledger outlives the device, `Drop` sees to it, and is shared through atomics
        // alone.
        unsafe {
            ffi::rtcSetDeviceMemoryMonitorFunction(
                device.as_ptr(),
                Some(record),
                ledger.cast_mut().cast(),
            );
        }
        Ok(device)
    }

    /// The handle; valid as long as `self`.
    pub(super) fn as_ptr(&self) -> *mut ffi::DeviceTy {
        self.raw.as_ptr()
    }

    /// `RTC_DEVICE_PROPERTY_VERSION`: 31305 for 3.13.5.
    pub fn version(&self) -> isize {
        // SAFETY: the device is alive, the property exists in every version 3.
        unsafe { ffi::rtcGetDeviceProperty(self.as_ptr(), ffi::DEVICE_PROPERTY_VERSION) }
    }

    /// Bytes held now and at most, buffers included.
    pub fn bytes(&self) -> (u64, u64) {
        let read = |counter: &AtomicI64| counter.load(Ordering::Relaxed).max(0) as u64;
        (read(&self.ledger.held), read(&self.ledger.peak))
    }

    /// The first error of this thread since the last call.
    ///
    /// # Errors
    /// The number of the error, an `RTCError`.
    pub fn check(&self) -> Result<(), String> {
        // SAFETY: the device is alive.
        let code = unsafe { ffi::rtcGetDeviceError(self.as_ptr()) };
        if code == ffi::ERROR_NONE { Ok(()) } else { Err(format!("Embree error {code}")) }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: made by `new`, released once. Scenes hold a reference of their own inside the
        // library, but ours own their `Device` and are released before it; nothing then frees
        // memory later, so the ledger is not written after it is dropped.
        unsafe { ffi::rtcReleaseDevice(self.as_ptr()) };
    }
}

/// Called by the library, from any of its threads, before or after memory changes hands.
unsafe extern "C" fn record(user: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: `user` is the ledger that `Device::new` registered, alive until the device is
    // released; it is only read as a shared reference.
    let ledger = unsafe { &*user.cast::<Ledger>() };
    let held = ledger.held.fetch_add(bytes as i64, Ordering::Relaxed) + bytes as i64;
    ledger.peak.fetch_max(held, Ordering::Relaxed);
    true
}
