use crate::block::BlockSource;
use crate::geometry::{Hit, Ray};
use crate::material::OpticalDepth;
use crate::scene::Material;
use crate::trace::{BUNDLE, Bundle, BundleVisited, Query, TraceError, Tracer, Trail, Whole};
use glam::Vec3;

/// Room for rays that are traced together, and for what they hit until it is asked for: 33 KiB.
#[derive(Debug)]
pub struct Neighbours {
    room: Bundle,
    rays: [Ray; BUNDLE],
    hits: [Option<Hit>; BUNDLE],
    hidden: [bool; BUNDLE],
    /// Means something only for rays whose bit is set in `weakened`.
    depths: [OpticalDepth; BUNDLE],
    /// Rays that have lost some of their light, and not all: a bit each.
    weakened: u64,
}

/// What a shadow ray loses on its way.
struct Through<'a> {
    depth: OpticalDepth,
    ray: &'a Ray,
    materials: &'a [Material],
}

impl Query for Through<'_> {
    #[inline(always)]
    fn shortens(&self) -> bool {
        false
    }

    #[inline(always)]
    fn hit(&mut self, _: &mut f32, _: f32, hit: &impl Whole) -> bool {
        self.depth.cross(self.materials, self.ray, &hit.whole())
    }
}

impl Default for Neighbours {
    fn default() -> Self {
        Self::new()
    }
}

impl Neighbours {
    /// Room for rays.
    #[must_use]
    pub const fn new() -> Self {
        const RAY: Ray = Ray { origin: Vec3::ZERO, direction: Vec3::ZERO, t_min: 0.0, t_max: 0.0 };
        Self {
            room: Bundle::new(),
            rays: [RAY; BUNDLE],
            hits: [None; BUNDLE],
            hidden: [false; BUNDLE],
            depths: [OpticalDepth::CLEAR; BUNDLE],
            weakened: 0,
        }
    }

    /// Finds the closest hits of the first [`BUNDLE`] rays: how many they were.
    pub(crate) fn trace<T: Tracer, S: BlockSource>(
        &mut self,
        tracer: T,
        source: &mut S,
        rays: impl Iterator<Item = Ray>,
    ) -> (usize, Result<(), TraceError<S::Error>>) {
        let together = fill(&mut self.rays, rays);
        let traced = tracer.closest_bundle(&mut self.room, source, together, &mut self.hits);
        (together.len(), traced)
    }

    /// Finds what is in the way of the first [`BUNDLE`] shadow rays: how many they were. Without `materials` all that they meet stops them.
    pub(crate) fn ask<T: Tracer, S: BlockSource>(
        &mut self,
        tracer: T,
        source: &mut S,
        rays: impl Iterator<Item = Ray>,
        materials: Option<&[Material]>,
    ) -> (usize, Result<(), TraceError<S::Error>>) {
        let count = fill(&mut self.rays, rays).len();
        let Self { room, rays, hidden, depths, weakened, .. } = self;
        let together = rays.get(..count).unwrap_or_default();
        *weakened = 0;
        let Some(materials) = materials else {
            return (count, tracer.any_bundle(room, source, together, hidden));
        };
        let ask = |ray| Through { depth: OpticalDepth::CLEAR, ray, materials };
        let mut queries = rays.each_ref().map(ask);
        let traced = tracer.query_bundle(room, source, together, &mut queries);
        let ends = hidden.iter_mut().zip(depths).zip(queries).zip(0..).take(count);
        for (((hidden, depth), query), at) in ends {
            (*hidden, *depth) = (query.depth.is_opaque(), query.depth);
            let is_weakened = !*hidden && *depth != OpticalDepth::CLEAR;
            *weakened |= u64::from(is_weakened) << at;
        }
        (count, traced)
    }

    /// The closest hits of all rays that were traced, and of others before.
    pub(super) const fn hits(&self) -> &[Option<Hit>; BUNDLE] {
        &self.hits
    }

    /// The closest hit of a ray that was traced; of one that has stopped, the best so far.
    pub(crate) fn hit(&self, at: usize) -> Option<&Hit> {
        self.hits.get(at).and_then(Option::as_ref)
    }

    /// Whether anything is in the way of a ray that was asked about, as far as it is known.
    pub(crate) fn is_hidden(&self, at: usize) -> bool {
        self.hidden.get(at).copied().unwrap_or(true)
    }

    /// What a ray that was asked about has lost, as far as it is known.
    pub(crate) fn depth(&self, at: usize) -> OpticalDepth {
        match self.depths.get(at) {
            _ if self.is_hidden(at) => OpticalDepth::OPAQUE,
            Some(depth) if self.weakened >> at & 1 != 0 => *depth,
            _ => OpticalDepth::CLEAR,
        }
    }

    /// All rays that have lost some of their light, and not all, as far as it is known: a bit each.
    pub(crate) const fn all_weakened(&self) -> u64 {
        self.weakened
    }

    /// All rays that are hidden, as far as it is known: a bit each.
    pub(crate) fn all_hidden(&self) -> u64 {
        const { assert!(BUNDLE <= 64) };
        self.hidden.iter().zip(0..).fold(0, |all, (&hidden, at)| all | u64::from(hidden) << at)
    }

    /// All rays that have stopped for want of a block: a bit each.
    pub(crate) fn all_stopped(&self) -> u64 {
        self.room.all_stopped()
    }

    /// Where a ray has stopped for want of a block.
    pub(crate) fn stopped(&self, at: usize) -> Option<Trail> {
        self.room.stopped(at)
    }

    /// What was visited since the last call.
    pub(crate) fn take_visited(&mut self) -> BundleVisited {
        self.room.take_visited()
    }
}

/// Takes rays as long as there is room.
fn fill(room: &mut [Ray; BUNDLE], rays: impl Iterator<Item = Ray>) -> &[Ray] {
    let count = room.iter_mut().zip(rays).map(|(place, ray)| *place = ray).count();
    room.get(..count).unwrap_or_default()
}
