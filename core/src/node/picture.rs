#[cfg(feature = "bundles")]
use super::Ends;
use super::{Lit, Missing, Traced, Work, World};
use crate::block::{BlockLimits, BlockSource};
use crate::geometry::{Aabb, Hit, Pyramid, Ray};
use crate::material::OpticalDepth;
use crate::path::PathKey;
#[cfg(feature = "bundles")]
use crate::render::Neighbours;
use crate::render::{Clearings, Places, Scratch, Tile, Tiling, Trust, is_clear};
use crate::scene::{Material, Needs};
use crate::shade::{
    Bundle, Counts, Direct, Memo, PackedHit, Path, PathRay, Point, Shader, Shadow, ShadowRays, Sum,
};
use crate::trace::{Clip, ClipEntry, Cursor, Query, TraceError, Tracer, Trail, Whole};
use crate::view::Camera;

/// A picture of a scene. What its steps run in is its own ([`Cursor`]), or [lent](Self::working_in).
#[derive(Debug)]
pub struct Picture<'a, T, C = Cursor> {
    tracer: T,
    shader: Shader<'a>,
    camera: Camera,
    tiling: Tiling,
    /// What blocks are checked by when they arrive; `None` if they are as they left.
    limits: Option<BlockLimits>,
    scratch: C,
    /// The tile of the last camera ray, and where it lies.
    opened: (u32, Option<Tile>),
    trust: Trust,
    clearings: Clearings<CLEARINGS>,
    memo: Memo,
}

impl<'a, T: Tracer> Picture<'a, T> {
    /// The picture that `camera` takes, in the tiles of `tiling`. The order of the tiles follows from the shader's seed.
    #[must_use]
    pub const fn new(
        tracer: T,
        shader: Shader<'a>,
        camera: Camera,
        tiling: Tiling,
        limits: BlockLimits,
    ) -> Self {
        Self {
            tracer,
            shader,
            camera,
            tiling,
            limits: Some(limits),
            scratch: Cursor::new(),
            opened: (u32::MAX, None),
            trust: Trust::new(),
            clearings: Clearings::new(),
            memo: Memo::new(),
        }
    }

    /// The same picture, where blocks were checked before and come as they left: they are not checked again.
    #[must_use]
    pub fn with_checked_blocks(self) -> Self {
        Self { limits: None, ..self }
    }

    /// The same picture, where steps run in something else.
    #[must_use]
    pub fn working_in<C: Scratch>(self, scratch: C) -> Picture<'a, T, C> {
        let Self { tracer, shader, camera, tiling, limits, opened, trust, clearings, memo, .. } =
            self;
        Picture { tracer, shader, camera, tiling, limits, scratch, opened, trust, clearings, memo }
    }
}

impl<'a, T: Tracer, C: Scratch> Picture<'a, T, C> {
    /// The materials that shadow rays may pass, if there are any.
    fn passable(&self) -> Option<&'a [Material]> {
        let tables = self.shader.tables();
        tables.needs.any(Needs::TRANSPARENT).then_some(tables.materials)
    }

    /// Traces rays together in its room: how many.
    #[cfg(feature = "bundles")]
    fn together(
        &self,
        work: &mut Work,
        trace: impl FnOnce(&mut Neighbours) -> (usize, Result<(), TraceError<Missing>>),
    ) -> usize {
        let traced = self.scratch.neighbours(|room| (trace(room), room.take_visited()));
        let Some(((count, traced), visited)) = traced else { return 0 };
        work.bundle_rays = work.bundle_rays.saturating_add(count as u32);
        work.bundle_nodes = work.bundle_nodes.saturating_add(visited.nodes as u32);
        work.bundle_boxes = work.bundle_boxes.saturating_add(visited.boxes as u32);
        work.bundle_ray_boxes = work.bundle_ray_boxes.saturating_add(visited.ray_boxes as u32);
        work.bundle_triangles = work.bundle_triangles.saturating_add(visited.triangles as u32);
        work.bundle_ray_triangles =
            work.bundle_ray_triangles.saturating_add(visited.ray_triangles as u32);
        work.nodes = work.nodes.saturating_add(visited.single.nodes as u32);
        work.leaves = work.leaves.saturating_add(visited.single.leaves as u32);
        work.blocks = work.blocks.saturating_add(visited.single.blocks as u32);
        work.blocks = work.blocks.saturating_add(visited.blocks as u32);
        match traced {
            Ok(()) | Err(TraceError::Source(Missing(_))) => count,
            // Each ray finds out for itself.
            Err(TraceError::Corrupt { .. }) => 0,
        }
    }

    /// Goes on to the next bundle of a point, if there is one.
    ///
    /// A function of its own: among the rays of a bundle, all of the bundle would be loaded and stored for each of them.
    #[inline(never)]
    fn next_bundle(&self, point: &Point, lights: &mut Lights, counts: &mut Counts) -> bool {
        lights.before = lights.direct.pack();
        let mut counted = Counts::default();
        let Self { shader, tracer, memo, .. } = self;
        lights.bundle = shader.next_bundle(*tracer, point, &mut lights.direct, memo, &mut counted);
        if lights.bundle.as_ref().and_then(Bundle::unshadowed).is_some() {
            lights.made = core::mem::take(&mut lights.next);
        }
        if !core::mem::take(&mut lights.again) {
            counts.add(&counted);
        }
        lights.bundle.is_some()
    }

    /// What the light of a bundle brings, if it is not begun and that is known. Then that was the bundle.
    #[inline(never)]
    fn whole<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        point: &Point,
        lights: &mut Lights,
        counts: &mut Counts,
        work: &mut Work,
    ) -> Option<Sum> {
        let bundle = lights.bundle.as_ref().filter(|_| lights.next == 0 && lights.made == 0)?;
        let Self { clearings, shader, .. } = self;
        let whole = clearings.whole(shader, point, bundle, source, &mut work.clips)?;
        counts.shadow_clear = counts.shadow_clear.saturating_add(u64::from(bundle.len));
        work.light_samples = work.light_samples.saturating_add(1);
        lights.bundle = None;
        Some(whole)
    }

    /// Makes the next shadow rays of a point, and takes the first.
    ///
    /// A function of its own, as most rays have been made before.
    #[inline(never)]
    fn go_on<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        point: &Point,
        lights: &mut Lights,
        counts: &mut Counts,
        work: &mut Work,
    ) -> Option<Lit> {
        loop {
            let Lights { bundle, next, made, ahead, first, .. } = &mut *lights;
            if let Some(bundle) = bundle {
                if *next < bundle.len {
                    self.shader.shadow_rays(self.tracer, point, bundle, *next, ahead);
                    *first = *next;
                    *next = (*made).min(first.saturating_add(ahead.len())).max(*first);
                    #[cfg(feature = "bundles")]
                    {
                        let again = next.wrapping_sub(*first);
                        work.light_samples = work.light_samples.saturating_add(again);
                    }
                    match lights.take(counts) {
                        Some(shadow) => return Some(Lit::By(shadow)),
                        None => continue,
                    }
                }
                (*next, *made, *first) = (0, 0, 0);
                ahead.clear();
            }
            if !self.next_bundle(point, lights, counts) {
                return None;
            }
            work.lights = work.lights.saturating_add(1);
            if let Some(sum) = self.whole(source, point, lights, counts, work) {
                return Some(Lit::Whole(sum));
            }
        }
    }

    /// Goes on with a ray. All rays come here, so that the traversal is there once in the code of a node, and not once for each question.
    #[inline(never)]
    fn ask<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        ray: &Ray,
        trail: &mut Trail,
        asked: &mut Asked<'_>,
        work: &mut Work,
    ) -> Traced {
        let Self { tracer, scratch, .. } = self;
        let (ended, visited) = scratch.cursor(|cursor| {
            let ended = tracer.continue_query(cursor, source, ray, trail, asked);
            if let Err(TraceError::Source(_)) = ended {
                *trail = cursor.trail();
            }
            (ended, cursor.take_visited())
        });
        work.nodes = work.nodes.saturating_add(visited.nodes as u32);
        work.leaves = work.leaves.saturating_add(visited.leaves as u32);
        work.blocks = work.blocks.saturating_add(visited.blocks as u32);
        match ended {
            Ok(()) => Traced::Done,
            Err(TraceError::Source(Missing(block))) => Traced::Missing(block),
            Err(TraceError::Corrupt { block }) => Traced::Corrupt(block),
        }
    }
}

/// What is asked of a ray.
enum Asked<'a> {
    /// Its closest hit.
    Closest(Option<Hit>),
    /// What is in the way of a shadow ray: all stops it, or what these materials do not let pass.
    Depth(OpticalDepth, Option<&'a [Material]>, &'a Ray),
}

impl Query for Asked<'_> {
    #[inline(always)]
    fn shorten(&self, t_max: &mut f32) {
        if let Self::Closest(best) = self {
            best.shorten(t_max);
        }
    }

    #[inline(always)]
    fn hit(&mut self, t_max: &mut f32, t: f32, hit: &impl Whole) -> bool {
        match self {
            Self::Closest(best) => best.hit(t_max, t, hit),
            Self::Depth(sum, Some(materials), ray) if cfg!(feature = "transparent") => {
                sum.cross(materials, ray, &hit.whole())
            }
            Self::Depth(sum, ..) => {
                *sum = OpticalDepth::OPAQUE;
                true
            }
        }
    }
}

/// The choice of lights of a point, in the midst of a bundle.
#[derive(Debug)]
pub struct Lights {
    direct: Direct,
    /// As it was before the bundle, [packed](Direct::pack).
    before: [u32; 6],
    bundle: Option<Bundle>,
    next: u32,
    /// Rays that have been made before it was taken up again, and have to be made once more for the others to come out alike.
    made: u32,
    /// It was taken up again: the bundle has been counted.
    again: bool,
    /// Rays of the bundle that have been made, the first of which has this number.
    ahead: ShadowRays,
    first: u32,
}

impl Lights {
    /// Takes the next of the rays that have been made; passes over those whose light does not count.
    #[inline(always)]
    fn take(&mut self, counts: &mut Counts) -> Option<Shadow> {
        let Self { bundle, next, ahead, first, .. } = self;
        let at = next.wrapping_sub(*first);
        let (dark, shadow) = match ahead.next(at) {
            Some((place, ray)) => {
                let light = bundle.as_ref().map_or(0, |bundle| bundle.light);
                (place.wrapping_sub(at), Some(Shadow::new(ray, light, 0)))
            }
            None => (ahead.len().saturating_sub(at), None),
        };
        counts.shadow_dark = counts.shadow_dark.saturating_add(dark.into());
        *next = next.saturating_add(dark).saturating_add(shadow.is_some().into());
        shadow
    }
}

impl<T: Tracer, C: Scratch> World for Picture<'_, T, C> {
    type Point = Point;
    type Lights = Lights;

    fn tile_pixels(&self, tile: u32) -> usize {
        let tile = self.tiling.shuffled(tile, self.shader.settings().seed);
        tile.map_or(0, |tile| (tile.width as usize).saturating_mul(tile.height as usize))
    }

    fn camera(&mut self, tile: u32, next: &mut [u32; 3]) -> Option<PathRay> {
        let settings = self.shader.settings();
        if self.opened.0 != tile {
            self.opened = (tile, self.tiling.shuffled(tile, settings.seed));
        }
        let mut places = Places::resume(self.opened.1?, settings.samples, *next);
        let place = places.next()?;
        *next = places.state();
        let pixel = place.y.wrapping_mul(self.tiling.width()).wrapping_add(place.x);
        let key = PathKey::camera(settings.seed, pixel, place.sample);
        let ray = self.camera.ray(place.x, place.y, key);
        Some(PathRay::new(&ray, &Path::camera(key), place.pixel))
    }

    #[inline]
    fn closest<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        ray: &PathRay,
        trail: &mut Trail,
        best: &mut PackedHit,
        work: &mut Work,
    ) -> Traced {
        work.rays = work.rays.saturating_add(1);
        let mut asked = Asked::Closest(best.get());
        let traced = self.ask(source, &ray.ray(), trail, &mut asked, work);
        if let (Asked::Closest(hit), Traced::Done | Traced::Missing(_)) = (&asked, traced) {
            *best = PackedHit::new(hit.as_ref());
        }
        traced
    }

    #[inline]
    fn shadow<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        ray: &Ray,
        trail: &mut Trail,
        depth: &mut [u32; 3],
        work: &mut Work,
    ) -> Traced {
        work.shadow_rays = work.shadow_rays.saturating_add(1);
        let mut asked = Asked::Depth(OpticalDepth::of_steps(*depth), self.passable(), ray);
        let traced = self.ask(source, ray, trail, &mut asked, work);
        if let Asked::Depth(sum, ..) = asked {
            *depth = sum.steps();
        }
        traced
    }

    #[cfg(feature = "bundles")]
    fn closest_together<'r, S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        rays: impl Iterator<Item = &'r PathRay>,
        work: &mut Work,
    ) -> usize {
        let tracer = self.tracer;
        self.together(work, |room| room.trace(tracer, source, rays.map(PathRay::ray)))
    }

    #[cfg(feature = "bundles")]
    fn closest_end(&self, at: usize) -> Option<(Traced, Trail, PackedHit)> {
        self.scratch.neighbours(|room| {
            let (traced, trail) = Traced::of(room.stopped(at));
            (traced, trail, PackedHit::new(room.hit(at)))
        })
    }

    #[cfg(feature = "bundles")]
    fn shadows_together<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        rays: impl Iterator<Item = Ray>,
        work: &mut Work,
    ) -> Ends {
        let (tracer, passable) = (self.tracer, self.passable());
        let count = self.together(work, |room| room.ask(tracer, source, rays, passable));
        let ends = |room: &mut Neighbours| Ends {
            count,
            apart: room.all_stopped() | room.all_weakened(),
            hidden: room.all_hidden(),
        };
        self.scratch.neighbours(ends).unwrap_or_default()
    }

    #[cfg(feature = "bundles")]
    fn shadow_end(&self, at: usize) -> Option<(Traced, Trail, [u32; 3])> {
        self.scratch.neighbours(|room| {
            let (traced, trail) = Traced::of(room.stopped(at));
            (traced, trail, room.depth(at).steps())
        })
    }

    fn most(&self) -> usize {
        self.trust.most()
    }

    fn clear_of<'r, S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        rays: impl ExactSizeIterator<Item = &'r Shadow> + Clone,
        work: &mut Work,
    ) -> usize {
        let light = rays.clone().next().map_or(u32::MAX, |ray| ray.source);
        let Some(light) = self.shader.tables().lights.get(light as usize) else { return 0 };
        self.trust.clear_of(rays.len(), |len| {
            work.clips = work.clips.saturating_add(1);
            is_clear(rays.clone().take(len), light, source)
        })
    }

    fn touched<'r, S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        rays: impl ExactSizeIterator<Item = &'r Shadow> + Clone,
        room: &mut [u32],
        work: &mut Work,
    ) -> usize {
        if !cfg!(feature = "clips") {
            return 0;
        }
        let light = rays.clone().next().map_or(u32::MAX, |ray| ray.source);
        let Some(light) = self.shader.tables().lights.get(light as usize) else { return 0 };
        let Ok(nesting) = source.block(0).map(|root| root.header().nesting) else { return 0 };
        let from = rays.fold(Aabb::EMPTY, |from, ray| from.with(ray.ray().origin));
        let mut window = [ClipEntry::EMPTY; WINDOW];
        let pyramid = Pyramid::to_light(&from, light);
        let Some(mut clip) = Clip::new(pyramid, nesting, &mut window) else { return 0 };
        // A block that is not sound is found out by who traces it.
        let _ = clip.round(source);
        work.clips = work.clips.saturating_add(1);
        work.nodes = work.nodes.saturating_add(clip.counts().boxes / 8);
        let blocks = clip.waiting().map(|entry| entry.block);
        room.iter_mut().zip(blocks).map(|(place, block)| *place = block).count()
    }

    fn arrive(&self, ray: &PathRay, hit: &PackedHit) -> (Sum, Option<Point>) {
        self.shader.arrive(&ray.path(), &ray.ray(), hit.get().as_ref())
    }

    fn lights(&mut self, point: &Point, saved: Option<[u32; 8]>) -> Lights {
        let (direct, next) = match saved {
            None => (self.shader.direct(self.tracer, point, &mut self.memo), 0),
            Some([a, b, c, d, e, f, next, _]) => (Direct::unpack([a, b, c, d, e, f]), next),
        };
        Lights {
            direct,
            before: direct.pack(),
            bundle: None,
            next,
            made: 0,
            again: next > 0,
            ahead: ShadowRays::NONE,
            first: 0,
        }
    }

    #[inline(always)]
    fn next_light<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        point: &Point,
        lights: &mut Lights,
        counts: &mut Counts,
        work: &mut Work,
    ) -> Option<Lit> {
        match lights.take(counts) {
            Some(shadow) => Some(Lit::By(shadow)),
            None => self.go_on(source, point, lights, counts, work),
        }
    }

    fn shadow_key(&self, point: &Point, lights: &Lights) -> PathKey {
        let light = lights.bundle.map_or(0, |bundle| bundle.light);
        point.path.key.child(!light).child(lights.next.saturating_sub(1))
    }

    fn save(&self, lights: &Lights) -> [u32; 8] {
        let now = || lights.direct.pack();
        let [a, b, c, d, e, f] = if lights.bundle.is_some() { lights.before } else { now() };
        [a, b, c, d, e, f, lights.next, 1]
    }

    #[cfg(feature = "specular")]
    fn children(&self, point: &Point, pixel: u16, counts: &mut Counts) -> [Option<PathRay>; 2] {
        self.shader
            .children(point, counts)
            .map(|child| child.map(|child| PathRay::new(&child.ray, &child.path, pixel)))
    }

    #[cfg(not(feature = "specular"))]
    fn children(&self, _: &Point, _: u16, _: &mut Counts) -> [Option<PathRay>; 2] {
        [None; 2]
    }

    fn passes_on(&self, point: &Point) -> bool {
        point.passes_on()
    }

    #[cfg_attr(feature = "bundles", inline(always))]
    fn passed(&self, light: glam::Vec3, depth: [u32; 3]) -> Sum {
        let depth = OpticalDepth::of_steps(depth);
        if depth.is_opaque() {
            return Sum::ZERO;
        }
        self.shader.unit().quantise(light * depth.transmittance())
    }

    fn splits(&self, depth: u32) -> usize {
        self.shader.splits(depth)
    }

    fn check(&self, block: u32, bytes: &[u8]) -> bool {
        self.limits.is_none_or(|limits| self.tracer.check(bytes, block, &limits).is_ok())
    }
}

/// Entries of the list of what a bundle may touch.
const WINDOW: usize = 32;
/// Clearings that are known, at most.
const CLEARINGS: usize = if cfg!(feature = "clips") { 4 } else { 0 };
