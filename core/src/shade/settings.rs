use crate::real::Real;

/// What a person chooses about the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Camera paths per pixel; at least 1.
    pub samples: u32,
    /// Shadow rays per light and point at the reference distance, 4 times the side of a square as large as the light; 0 for adaptive.
    /// See [`Settings::shadow_count`].
    pub shadow_samples: u16,
    /// About how many lights a point asks, at most, where there are more: those that bring most, and others by chance, in proportion to what they bring
    /// (see [`Direct`](super::Direct)); at least 1.
    pub lights: u16,
    /// How many specular rays may follow each other.
    pub bounces: u8,
    /// Of all random numbers.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { samples: 16, shadow_samples: 0, lights: 64, bounces: 8, seed: 0 }
    }
}

impl Settings {
    /// Most camera paths of a pixel.
    pub const SAMPLES_MAX: u32 = 1 << 18;
    /// Most specular rays that follow each other.
    pub const BOUNCES_MAX: u8 = 64;
    /// Most shadow rays of one bundle.
    pub const BUNDLE_MAX: u32 = 4096;

    /// How many shadow rays a light of this solid angle is worth: `reference * 4 sqrt(Ω)`, so as many as
    /// asked for at the reference distance (Ω = 1/16), in proportion to the light's size as seen, up to 4 times as many, and at least 1.
    ///
    /// The reference is `shadow_samples`, or if that is 0, `32 / sqrt(samples)`: a pixel's samples share one sequence of places on the light, so what
    /// counts is how many they have together, and that grows with the quality asked for. In the adaptive case
    /// [`Direct`](super::Direct) takes fewer for a light that brings only a part of the light, and on a path that brings only a part of the
    /// pixel: by the root of the product of both.
    ///
    /// [`Direct`](super::Direct) rounds to a power of two: aligned runs of a [`Sequence`](crate::random::Sequence) are even.
    #[must_use]
    #[inline(always)]
    pub fn shadow_count<R: Real>(&self, solid_angle: R) -> R {
        let size = (solid_angle.at_least(0.0).sqrt() * 4.0).at_most(4.0);
        (size * self.reference()).at_least(1.0).at_most(Self::BUNDLE_MAX as f32)
    }

    /// Shadow rays at the reference distance.
    fn reference(&self) -> f32 {
        match self.shadow_samples {
            0 => (32.0 / libm::sqrtf(self.samples.max(1) as f32)).max(1.0),
            n => f32::from(n),
        }
    }
}
