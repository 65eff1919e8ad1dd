use super::sort::sort_by_key;
use super::stack::Stack;
use super::tile::{Place, Places, SomePlaces, Tile};
use super::{Plan, Sight};
use crate::block::BlockSource;
use crate::material::OpticalDepth;
use crate::path::PathKey;
use crate::scene::Needs;
#[cfg(feature = "bundles")]
use crate::shade::FewRays;
use crate::shade::{Counts, Memo, Path, Point, SPLITS, Shader, Sum};
use crate::shade::{PathRay, Shadow, ShadowRays};
use crate::store::{Arena, ArenaFull, Budget, Line};
use crate::trace::{BUNDLE, TraceError, Tracer};
use crate::view::Camera;
use core::fmt;
use core::sync::atomic::{AtomicBool, Ordering};

/// What is rendered.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// How surfaces answer light, and how many samples are taken.
    pub shader: Shader<'a>,
    /// From pixels to rays.
    pub camera: Camera,
    /// Width of the picture \[pixels\].
    pub width: u32,
    /// Which pixels of the picture are rendered, row by row from its top; the others stay as they are. `None` for all.
    pub only: Option<&'a [bool]>,
    /// Set from outside, it ends the work within a batch.
    pub cancel: Option<&'a AtomicBool>,
}

impl Job<'_> {
    /// Index of the pixel in the picture.
    #[cfg_attr(feature = "bundles", inline)]
    fn pixel(&self, place: &Place) -> u32 {
        place.y.wrapping_mul(self.width).wrapping_add(place.x)
    }
}

/// Renders tile after tile in the memory it was given.
#[derive(Debug)]
pub struct Renderer<'a> {
    /// Rays that are traced together.
    batch: Stack<'a, PathRay>,
    /// Specular rays that wait, the deepest on top.
    waiting: Stack<'a, PathRay>,
    /// Shadow rays that wait.
    shadows: Stack<'a, Shadow>,
    sums: &'a mut [Sum],
    sums_peak: usize,
}

/// Why a tile could not be rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RenderError<E> {
    /// A block could not be had, or is not sound.
    Trace(TraceError<E>),
    /// The memory was planned for another job: the tile has more pixels, or paths split more often.
    Plan,
    /// It was told to stop.
    Cancelled,
}

/// What a tile is rendered from.
struct Work<'w, 'a, T, S> {
    job: &'w Job<'a>,
    sight: &'w mut Sight<T, S>,
    counts: &'w mut Counts,
    places: SomePlaces<'a>,
    /// The camera ray that comes next.
    next: Option<Place>,
    /// Whether points have children.
    #[cfg(feature = "specular")]
    splits: bool,
    /// Shadow rays that are not made yet.
    #[cfg(feature = "bundles")]
    few: FewRays,
    memo: Memo,
}

impl<'a> Renderer<'a> {
    /// A renderer in its part of the arena.
    ///
    /// # Errors
    /// [`ArenaFull`] if the arena is smaller than the plan.
    pub fn new(arena: &mut Arena<'a>, plan: &Plan) -> Result<Self, ArenaFull> {
        Ok(Self {
            batch: Stack::new(arena.carve(plan.batch)?),
            waiting: Stack::new(arena.carve(plan.waiting)?),
            shadows: Stack::new(arena.carve(plan.shadows)?),
            sums: arena.carve(plan.pixels())?,
            sums_peak: 0,
        })
    }

    /// Renders a tile: the sums of its pixels, row by row.
    ///
    /// # Errors
    /// [`RenderError`]; the next tile may be tried all the same.
    pub fn tile<T: Tracer, S: BlockSource>(
        &mut self,
        job: &Job<'_>,
        tile: Tile,
        sight: &mut Sight<T, S>,
        counts: &mut Counts,
    ) -> Result<&[Sum], RenderError<S::Error>> {
        let pixels = (tile.width as usize).saturating_mul(tile.height as usize);
        self.sums.get_mut(..pixels).ok_or(RenderError::Plan)?.fill(Sum::ZERO);
        self.sums_peak = self.sums_peak.max(pixels);
        self.waiting.clear();
        self.shadows.clear();
        let places = Places::new(tile, job.shader.settings().samples);
        let mut places = SomePlaces::new(places, job.only, job.width);
        let next = places.next();
        let mut work = Work {
            job,
            sight,
            counts,
            places,
            next,
            #[cfg(feature = "specular")]
            splits: job.shader.tables().needs.any(Needs::SPECULAR),
            #[cfg(feature = "bundles")]
            few: FewRays::new(),
            memo: Memo::new(),
        };
        let mut rays = ShadowRays::NONE;
        while self.fill_batch(&mut work) {
            if job.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
                return Err(RenderError::Cancelled);
            }
            for at in 0..self.batch.len() {
                let found = work.sight.closest(self.batch.items(), at, &job.shader);
                found.map_err(RenderError::Trace)?;
                let Some(ray) = self.batch.items().get(at) else { break };
                let pixel = ray.pixel();
                // (What is not moved need not be copied: points and bundles are large.)
                let (light, point) = &work.sight.arrive(&job.shader, ray, at, &mut work.memo);
                if *light != Sum::ZERO
                    && let Some(sum) = self.sums.get_mut(usize::from(pixel))
                {
                    sum.add(*light);
                }
                if let Some(point) = point {
                    self.go_on(&mut work, point, pixel, &mut rays)?;
                }
            }
        }
        if work.next.is_some() || self.waiting.len() > 0 {
            return Err(RenderError::Plan);
        }
        #[cfg(feature = "bundles")]
        self.make_few(&mut work, &mut rays)?;
        self.light(&mut work)?;
        self.sums.get(..pixels).ok_or(RenderError::Plan)
    }

    /// Enters the most that its lines ever held.
    pub fn note_peaks(&self, budget: &mut Budget) {
        budget.note_peak(Line::Rays, self.batch.peak());
        budget.note_peak(Line::Points, self.waiting.peak());
        budget.note_peak(Line::Bundles, self.shadows.peak());
        budget.note_peak(Line::Tile, self.sums_peak);
    }

    /// The rays to trace next; `false` at the end of the tile.
    ///
    /// What waits goes first when it fills a batch, or when a batch of camera rays might not find room for its children.
    fn fill_batch<T, S>(&mut self, work: &mut Work<'_, '_, T, S>) -> bool {
        self.batch.clear();
        let camera = if work.next.is_some() { self.room_for_camera_rays(work.job) } else { 0 };
        let waits = self.waiting.len() > 0;
        if waits && (camera < self.batch.capacity() || self.waiting.len() >= self.batch.capacity())
        {
            self.take_waiting(work.job);
        }
        if self.batch.len() == 0 {
            self.take_camera_rays(work, camera);
        }
        self.batch.len() > 0
    }

    /// How many camera rays can be traced without risk.
    fn room_for_camera_rays(&self, job: &Job<'_>) -> usize {
        let children = children_of(0, job);
        let free = self.waiting.capacity().saturating_sub(self.waiting.len());
        let room = free.saturating_sub(reserve(0, job)).checked_div(children);
        room.unwrap_or(usize::MAX).min(self.batch.capacity())
    }

    fn take_camera_rays<T, S>(&mut self, work: &mut Work<'_, '_, T, S>, count: usize) {
        let Job { camera, shader, .. } = work.job;
        for _ in 0..count {
            let Some(place) = work.next else { break };
            let pixel = work.job.pixel(&place);
            let key = PathKey::camera(shader.settings().seed, pixel, place.sample);
            let ray = camera.ray(place.x, place.y, key);
            if !self.batch.push(PathRay::new(&ray, &Path::camera(key), place.pixel)) {
                break;
            }
            work.counts.primary = work.counts.primary.saturating_add(1);
            work.next = work.places.next();
        }
    }

    /// Takes rays off the stack as long as the children of all of them fit.
    fn take_waiting(&mut self, job: &Job<'_>) {
        let mut after = self.waiting.len();
        let mut least = u32::MAX;
        while let Some(top) = self.waiting.items().last() {
            after = after.saturating_sub(1).saturating_add(children_of(top.depth(), job));
            least = least.min(top.depth());
            let fits = after.saturating_add(reserve(least, job)) <= self.waiting.capacity();
            if !fits || self.batch.is_full() {
                break;
            }
            if let Some(ray) = self.waiting.pop() {
                self.batch.push(ray);
            }
        }
    }

    /// Queues what a point sends.
    fn go_on<T: Tracer, S: BlockSource>(
        &mut self,
        work: &mut Work<'_, '_, T, S>,
        point: &Point,
        pixel: u16,
        rays: &mut ShadowRays,
    ) -> Result<(), RenderError<S::Error>> {
        #[cfg(feature = "specular")]
        if work.splits {
            for child in work.job.shader.children(point, work.counts).into_iter().flatten() {
                work.counts.specular = work.counts.specular.saturating_add(1);
                if !self.waiting.push(PathRay::new(&child.ray, &child.path, pixel)) {
                    return Err(RenderError::Plan);
                }
            }
        }
        self.ask_lights(work, point, pixel, rays)
    }

    /// Queues the shadow rays of a point, which are made in `rays`.
    fn ask_lights<T: Tracer, S: BlockSource>(
        &mut self,
        work: &mut Work<'_, '_, T, S>,
        point: &Point,
        pixel: u16,
        rays: &mut ShadowRays,
    ) -> Result<(), RenderError<S::Error>> {
        let shader = work.job.shader;
        let tracer = work.sight.tracer();
        let mut direct = shader.direct(tracer, point, &mut work.memo);
        while let Some(bundle) =
            &mut shader.next_bundle(tracer, point, &mut direct, &work.memo, work.counts)
        {
            if let Some(whole) = work.sight.whole(&shader, point, bundle) {
                if let Some(sum) = self.sums.get_mut(usize::from(pixel)) {
                    sum.add(whole);
                }
                let count = &mut work.counts.shadow_clear;
                *count = count.saturating_add(u64::from(bundle.len));
                continue;
            }
            #[cfg(feature = "bundles")]
            {
                if work.few.are_in_the_way_of(bundle) {
                    self.make_few(work, rays)?;
                }
                if work.few.put(point, bundle, pixel) {
                    continue;
                }
            }
            let mut j = 0;
            while j < bundle.len {
                shader.shadow_rays(tracer, point, bundle, j, rays);
                let dark = &mut work.counts.shadow_dark;
                *dark = dark.saturating_add(rays.dark().into());
                for ray in rays.lit() {
                    if self.shadows.is_full() {
                        self.light(work)?;
                    }
                    self.shadows.push(Shadow::new(ray, bundle.light, pixel));
                }
                j = j.saturating_add(rays.len());
            }
        }
        Ok(())
    }

    /// Makes and queues the shadow rays of bundles that have few, in `rays`.
    #[cfg(feature = "bundles")]
    #[inline(never)]
    fn make_few<T: Tracer, S: BlockSource>(
        &mut self,
        work: &mut Work<'_, '_, T, S>,
        rays: &mut ShadowRays,
    ) -> Result<(), RenderError<S::Error>> {
        work.few.make(work.sight.tracer(), rays);
        let dark = &mut work.counts.shadow_dark;
        *dark = dark.saturating_add(rays.dark().into());
        for (lane, ray) in rays.places() {
            if self.shadows.is_full() {
                self.light(work)?;
            }
            let (light, pixel) = work.few.owner(lane);
            self.shadows.push(Shadow::new(ray, light, pixel));
        }
        work.few.clear();
        Ok(())
    }

    /// Traces the shadow rays that wait, light by light, and adds what is not hidden.
    fn light<T: Tracer, S: BlockSource>(
        &mut self,
        work: &mut Work<'_, '_, T, S>,
    ) -> Result<(), RenderError<S::Error>> {
        let tables = work.job.shader.tables();
        let unit = work.job.shader.unit();
        let transparent = tables.needs.any(Needs::TRANSPARENT);
        let materials = transparent.then_some(tables.materials);
        // Where blocks have to come, rays of the same signs go through them together.
        let by_signs = cfg!(feature = "bundles") && work.sight.fetches();
        if by_signs || tables.lights.len() > 1 {
            sort_by_key(self.shadows.items_mut(), |shadow| shadow.order(by_signs));
        }
        let mut rest = self.shadows.items();
        while let Some(first) = rest.first() {
            let run = rest.get(..run_len(rest, first.source, work.sight.most())).unwrap_or(rest);
            let light = tables.lights.get(first.source as usize);
            let skipped = light.map_or(0, |light| work.sight.clear_of(run, light));
            let clear = skipped > 0;
            let len = if clear { skipped } else { run.len().min(BUNDLE) };
            let Some((bundle, behind)) = rest.split_at_checked(len) else { break };
            rest = behind;
            let count = if clear { &mut work.counts.shadow_clear } else { &mut work.counts.shadow };
            *count = count.saturating_add(bundle.len() as u64);
            for (at, shadow) in bundle.iter().enumerate() {
                let depth = if clear {
                    OpticalDepth::CLEAR
                } else {
                    work.sight.depth(bundle, at, materials).map_err(RenderError::Trace)?
                };
                if !depth.is_opaque()
                    && let Some(sum) = self.sums.get_mut(usize::from(shadow.pixel))
                {
                    sum.add(unit.quantise(shadow.light() * depth.transmittance()));
                }
            }
        }
        self.shadows.clear();
        Ok(())
    }
}

/// The length of the run of shadow rays to a light that these begin with, as far as `most`: at least 1.
#[cfg_attr(feature = "bundles", inline)]
fn run_len(rays: &[Shadow], source: u32, most: usize) -> usize {
    rays.iter().take(most).take_while(|ray| ray.source == source).count().max(1)
}

/// Most children of a point that a ray of this depth finds.
fn children_of(depth: u32, job: &Job<'_>) -> usize {
    let specular = job.shader.tables().needs.any(Needs::SPECULAR);
    let bounces = u32::from(job.shader.settings().bounces);
    if !specular || bounces == 0 {
        0
    } else if depth < bounces.min(u32::from(SPLITS)) {
        2
    } else {
        // Beyond the last bounce rays go straight on through panes.
        1
    }
}

/// Places of the stack that stay free when rays of this depth have been traced: one for each deeper bounce that may split.
fn reserve(depth: u32, job: &Job<'_>) -> usize {
    job.shader.splits(depth.saturating_add(1))
}

impl<E: fmt::Display> fmt::Display for RenderError<E> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Trace(error) => error.fmt(f),
            Self::Cancelled => f.write_str("cancelled"),
            Self::Plan => f.write_str("the memory was planned for another job"),
        }
    }
}

impl<E: fmt::Debug + fmt::Display> core::error::Error for RenderError<E> {}
