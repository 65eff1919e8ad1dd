//! Names of paths, and every random number as a function of them.
//!
//! Any ray can be made again from its parent by anyone: nothing random depends on who asks, or when.

/// The name of a path: which camera sample it began with, and which children were taken.
///
/// `sample` stands apart from the hash so that the samples of a pixel can share one low-discrepancy
/// sequence at every place of the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PathKey {
    /// Hash of seed, pixel and the children taken.
    pub path: u64,
    /// The camera sample of the pixel.
    pub sample: u32,
}

impl PathKey {
    /// The key of a camera path. `pixel` is `y * width + x`.
    #[must_use]
    pub const fn camera(seed: u64, pixel: u32, sample: u32) -> Self {
        Self { path: mix(seed ^ mix(pixel as u64 ^ 0x6b69_6c6f)), sample }
    }

    /// The key of a child: a ray that this path's last point sends.
    #[must_use]
    pub const fn child(self, index: u32) -> Self {
        Self { path: mix(self.path ^ mix(index as u64 ^ 0x0072_6179)), sample: self.sample }
    }

    /// 32 bits for a purpose at this path's last point; the same for all samples of the pixel.
    #[must_use]
    pub const fn scramble(self, dimension: u32) -> u32 {
        (mix(self.path ^ (dimension as u64) << 32 ^ 0x0064_696d) >> 32) as u32
    }
}

/// The finaliser of SplitMix64 (Steele, Lea, Flood 2014; constants: Stafford's variant 13): a bijection of 64 bits. A board has it once: a dozen copies would take
/// a kilobyte of its flash.
#[cfg_attr(not(feature = "bundles"), inline(never))]
pub(crate) const fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}
