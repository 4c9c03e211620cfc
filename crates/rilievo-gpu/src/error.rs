//! [`GpuError`]: why nothing was traced on a GPU, and what to do about it.

/// Why nothing was traced on a GPU.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GpuError {
    /// The system has no adapter that wgpu can use.
    #[error(
        "no GPU was found ({reason}); install the driver of the graphics card, or a software one: \
         on Debian and Ubuntu the package mesa-vulkan-drivers"
    )]
    NoAdapter {
        /// What the system said.
        reason: String,
    },
    /// There is a program in a GPU's place, and nobody asked for that.
    #[error(
        "{adapter} is no GPU but a program, slower than the CPU itself; the backend gpu takes it all the same"
    )]
    OnlySoftware {
        /// Name of the adapter.
        adapter: String,
    },
    /// The adapter refused to be used.
    #[error("the GPU {adapter} cannot be used: {reason}")]
    NoDevice {
        /// Name of the adapter.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// Something does not fit the buffers of the device.
    #[error(
        "{what} need {needed} bytes in buffers, the GPU {adapter} allows {allowed}; \
         use smaller maps or the CPU"
    )]
    TooLarge {
        /// What does not fit.
        what: &'static str,
        /// Name of the adapter.
        adapter: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        allowed: u64,
    },
    /// A distance map that is not allowed, on any machine.
    #[error("{reason}")]
    Distances {
        /// What is wrong with it.
        reason: String,
    },
    /// The device has no memory left.
    #[error(
        "the GPU {adapter} is out of memory; use smaller maps, close other programs, or use the CPU"
    )]
    OutOfMemory {
        /// Name of the adapter.
        adapter: String,
    },
    /// The device went away or stopped answering.
    #[error(
        "the GPU {adapter} was lost: {reason}; its driver may have been reset, try again or use the CPU"
    )]
    Lost {
        /// Name of the adapter.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// Something in the scene is traced on the CPU only.
    #[error("{what} cannot be traced on the GPU yet; use the CPU")]
    Unsupported {
        /// What it is.
        what: String,
    },
}
