//! [`Paged`]: words in as many buffers as a device wants them in.
//!
//! A shader binds at most `maxStorageBufferBindingSize` bytes at once, 128 MiB on the least of devices. More
//! words lie in several buffers, *pages* of a power of two of words each, and a shader picks the page by the high bits
//! of a place (`shaders::words`). One page is read without that.

use rilievo::map::{HeightMap, Samples};

use crate::device::Gpu;
use crate::error::GpuError;

/// How words are cut into pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Pages {
    /// Buffers, at least one.
    pub count: u32,
    /// The power of two of words in each but the last.
    pub shift: u32,
}

impl Pages {
    /// For `words` words in buffers of at most `allowed` bytes.
    pub fn of(words: u64, allowed: u64) -> Self {
        let most = (allowed / 4).max(1);
        if words <= most {
            return Self { count: 1, shift: 31 };
        }
        let shift = most.ilog2().min(31);
        Self { count: words.div_ceil(1 << shift).try_into().unwrap_or(u32::MAX), shift }
    }
}

/// Words on a device.
pub(crate) struct Paged {
    buffers: Vec<wgpu::Buffer>,
    pages: Pages,
}

impl Paged {
    /// Room for `words` words.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if places would not fit 32 bits; [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn new(gpu: &Gpu, what: &'static str, words: u64) -> Result<Self, GpuError> {
        if words > 1 << 32 {
            return Err(gpu.too_large(what, words * 4, 1 << 34));
        }
        let pages = Pages::of(words, gpu.largest_binding());
        let usage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_DST
            | wgpu::BufferUsages::COPY_SRC;
        let buffer = |page: u64| {
            let rest = words - (page << pages.shift);
            gpu.allocate(what, 4 * rest.min(1 << pages.shift), usage)
        };
        let buffers = (0..u64::from(pages.count)).map(buffer).collect::<Result<_, _>>()?;
        Ok(Self { buffers, pages })
    }

    /// The samples of a map, as the CPU holds them.
    ///
    /// # Errors
    /// As [`Paged::new`].
    pub fn of_samples(gpu: &Gpu, map: &HeightMap) -> Result<Self, GpuError> {
        let bytes: &[u8] = match map.samples() {
            Samples::U16(codes) => bytemuck::cast_slice(codes),
            Samples::F32(all) => bytemuck::cast_slice(all),
        };
        let paged = Self::new(gpu, "height maps", (bytes.len() as u64).div_ceil(4))?;
        paged.write(gpu, 0, bytes);
        Ok(paged)
    }

    /// How the words are cut.
    pub fn pages(&self) -> Pages {
        self.pages
    }

    /// The buffers, in order.
    pub fn buffers(&self) -> &[wgpu::Buffer] {
        &self.buffers
    }

    /// Writes bytes from a word on; a last word that is not whole is filled up with zeros.
    pub fn write(&self, gpu: &Gpu, first: u64, bytes: &[u8]) {
        gpu.traffic.add_maps(bytes.len());
        let page_bytes = 4u64 << self.pages.shift;
        let mut at = first * 4;
        let mut left = bytes;
        while !left.is_empty() {
            let place = at % page_bytes;
            let here = (page_bytes - place).min(left.len() as u64) as usize;
            let (part, rest) = left.split_at(here);
            let whole = part.len() / 4 * 4;
            if let Some(buffer) = self.buffers.get((at / page_bytes) as usize) {
                gpu.queue.write_buffer(buffer, place, &part[..whole]);
                if whole < part.len() {
                    let mut last = [0; 4];
                    last[..part.len() - whole].copy_from_slice(&part[whole..]);
                    gpu.queue.write_buffer(buffer, place + whole as u64, &last);
                }
            }
            at += here as u64;
            left = rest;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_cut_into_powers_of_two_where_one_buffer_does_not_hold_them() {
        assert_eq!(Pages::of(100, 400), Pages { count: 1, shift: 31 });
        assert_eq!(Pages::of(101, 400), Pages { count: 2, shift: 6 });
        assert_eq!(Pages::of(1 << 32, 128 << 20), Pages { count: 128, shift: 25 });
        assert_eq!(Pages::of(0, 16).count, 1);
    }
}
