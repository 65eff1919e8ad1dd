use super::{Missing, Work};
use crate::block::BlockSource;
use crate::geometry::Ray;
use crate::path::PathKey;
use crate::shade::{Counts, PackedHit, PathRay, Shadow, Sum};
use crate::trace::{BUNDLE, Trail};

/// What a node computes, apart from how it is divided: geometry and light.
///
/// The actor knows rays, hits and sums only by these functions, so that a checker of its rules can run it over a toy scene.
pub trait World {
    /// A place that answers light; made again at will from a ray and its hit.
    type Point;
    /// The choice of lights of a point, on its way.
    type Lights;

    /// Pixels of a tile; 0 if there is no such tile.
    fn tile_pixels(&self, tile: u32) -> usize;

    /// The next camera ray of a tile.
    fn camera(&mut self, tile: u32, next: &mut [u32; 3]) -> Option<PathRay>;

    /// Goes on with a closest-hit ray.
    fn closest<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        ray: &PathRay,
        trail: &mut Trail,
        best: &mut PackedHit,
        work: &mut Work,
    ) -> Traced;

    /// Goes on with a shadow ray.
    fn shadow<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        ray: &Ray,
        trail: &mut Trail,
        depth: &mut [u32; 3],
        work: &mut Work,
    ) -> Traced;

    /// Traces some closest-hit rays together, from their beginning: the first so many.
    fn closest_together<'r, S: BlockSource<Error = Missing>>(
        &mut self,
        _source: &mut S,
        _rays: impl Iterator<Item = &'r PathRay>,
        _work: &mut Work,
    ) -> usize {
        0
    }

    /// How far one of the rays has come that were traced together last, and its best hit.
    fn closest_end(&self, _at: usize) -> Option<(Traced, Trail, PackedHit)> {
        None
    }

    /// Traces some shadow rays together, from their beginning: the first so many.
    fn shadows_together<S: BlockSource<Error = Missing>>(
        &mut self,
        _source: &mut S,
        _rays: impl Iterator<Item = Ray>,
        _work: &mut Work,
    ) -> Ends {
        Ends::default()
    }

    /// How far one of the shadow rays has come that were traced together last, and its optical depth.
    fn shadow_end(&self, _at: usize) -> Option<(Traced, Trail, [u32; 3])> {
        None
    }

    /// How many shadow rays [`clear_of`](Self::clear_of) is asked about next, at most.
    fn most(&self) -> usize {
        BUNDLE
    }

    /// Of shadow rays to one light how many, from the first, nothing is in the way of, as far as is known.
    fn clear_of<'r, S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        rays: impl ExactSizeIterator<Item = &'r Shadow> + Clone,
        work: &mut Work,
    ) -> usize;

    /// The blocks that are not here and that a bundle of shadow rays to one light may touch, the nearest first, as
    /// many as there is room for: how many.
    fn touched<'r, S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        rays: impl ExactSizeIterator<Item = &'r Shadow> + Clone,
        room: &mut [u32],
        work: &mut Work,
    ) -> usize;

    /// What a ray brings where it ends, and the point that goes on.
    fn arrive(&self, ray: &PathRay, hit: &PackedHit) -> (Sum, Option<Self::Point>);

    /// Begins, or goes on with, the choice of lights of a point.
    fn lights(&mut self, point: &Self::Point, saved: Option<[u32; 8]>) -> Self::Lights;

    /// What is next to be known of a point's lights.
    fn next_light<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        point: &Self::Point,
        lights: &mut Self::Lights,
        counts: &mut Counts,
        work: &mut Work,
    ) -> Option<Lit>;

    /// The name of the shadow ray that came last.
    fn shadow_key(&self, point: &Self::Point, lights: &Self::Lights) -> PathKey;

    /// Where the choice of lights is.
    fn save(&self, lights: &Self::Lights) -> [u32; 8];

    /// The specular rays of a point.
    fn children(
        &self,
        point: &Self::Point,
        pixel: u16,
        counts: &mut Counts,
    ) -> [Option<PathRay>; 2];

    /// Whether a point asks no light and sends one ray at most, so that it only passes on what that brings.
    fn passes_on(&self, point: &Self::Point) -> bool;

    /// What is left of a shadow ray's light.
    fn passed(&self, light: glam::Vec3, depth: [u32; 3]) -> Sum;

    /// How often a ray of this depth may still split: each time needs another slot.
    fn splits(&self, depth: u32) -> usize;

    /// Whether an arrived block is sound.
    fn check(&self, block: u32, bytes: &[u8]) -> bool;
}

/// What became of shadow rays that were traced together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Ends {
    /// The first so many: 64 at most.
    pub count: usize,
    /// Those of which [`World::shadow_end`] says more, a bit each: they have not come to their end, or lost a part of their light.
    pub apart: u64,
    /// Those whose light is hidden, a bit each. Nothing is in the way of the others.
    pub hidden: u64,
}

/// What a point asks of its lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lit {
    /// Whether anything is in the way of a shadow ray.
    By(Shadow),
    /// Nothing: all of a light is seen, and brings this.
    Whole(Sum),
}

/// How far a ray has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Traced {
    /// To its end.
    Done,
    /// To a block that is not here.
    Missing(u32),
    /// To a block that is not sound: it is left at that.
    Corrupt(u32),
}

#[cfg(feature = "bundles")]
impl Traced {
    /// Of a ray that has stopped there, or not at all.
    pub(super) fn of(stopped: Option<Trail>) -> (Self, Trail) {
        match stopped {
            Some(trail) => (Self::Missing(trail.block()), trail),
            None => (Self::Done, Trail::START),
        }
    }
}
