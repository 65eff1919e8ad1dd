use crate::path::PathKey;
use crate::real::Real;
use crate::scene::Light;
use glam::Vec3;

/// What a ray carries of its path, besides itself: with it, what the ray finds is shaded without its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Path {
    /// Its name.
    pub key: PathKey,
    /// The part of the light along the ray that reaches the pixel.
    pub throughput: Vec3,
    /// The density [1/sr] with which the ray was sent in its direction, for weighing it against light sampling;
    /// infinite for a camera ray, and for one that no light sample could replace.
    pub density: f32,
    /// How many rays came before it.
    pub depth: u8,
    /// Index of the dielectric that it runs in; [`Path::AIR`] for none.
    pub medium: u16,
}

impl Path {
    /// No medium.
    pub const AIR: u16 = u16::MAX;

    /// The path of a camera ray.
    #[must_use]
    pub const fn camera(key: PathKey) -> Self {
        Self { key, throughput: Vec3::ONE, density: f32::INFINITY, depth: 0, medium: Self::AIR }
    }

    /// Whether the lights that the ray finds are sampled by shadow rays as well: it was sent by a rough lobe.
    #[must_use]
    pub(super) fn shares_light(&self) -> bool {
        cfg!(feature = "specular") && self.density < f32::INFINITY
    }

    /// The greatest part of the light that reaches the pixel in any channel.
    #[must_use]
    pub fn importance(&self) -> f32 {
        self.throughput.max_element()
    }
}

/// The part of a light's radiance that counts for a ray that found it by itself: the balance heuristic (Veach & Guibas 1995)
/// between one such ray of density `ray` and light sampling of density `light`. Both sides add up to 1.
#[must_use]
#[inline(always)]
pub(super) fn share<R: Real>(ray: R, light: R) -> R {
    let (none, one, infinity) = (ray.same(0.0), ray.same(1.0), ray.same(f32::INFINITY));
    // A quotient of both, so that neither their sum nor their product overflows.
    let share = one / (light / ray + 1.0);
    let share = R::select(ray.is_positive() & infinity.above(light), share, none);
    R::select(light.is_positive() & infinity.above(ray), share, one)
}

/// Whether a ray that finds this light by itself may see it: then the two share, else light sampling does all.
pub(super) fn is_seen(light: &Light, emits: impl Fn(u32) -> bool) -> bool {
    light.kind == crate::scene::LightKind::Distant as u32
        || light.material != u32::MAX && emits(light.material)
}
