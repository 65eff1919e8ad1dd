use crate::top::Top;
use crate::{Control, Error, Picture, Report};
use kiloray_core::block::{Expanded, KiloView};
use kiloray_core::render::{Job, Plan, RenderError, Renderer, Sight, Tiling};
use kiloray_core::shade::Counts;
use kiloray_core::store::{Arena, Budget, CHUNK_BYTES, CacheCounts, Chunk, FetchError};
use kiloray_core::trace::{TraceError, Tracer};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

/// Least side of a tile, however many threads want one.
const SIDE_MIN: usize = 8;
/// So many tiles for each thread, that the last ones do not wait long for each other.
const TILES_PER_THREAD: u32 = 16;

/// What threads share, and one of them changes at a time.
struct Shared<'p> {
    picture: &'p mut Picture,
    counts: Counts,
    budget: Budget,
    overflows: u64,
    done: u64,
    error: Option<Error>,
}

/// Renders all tiles on all cores, with the blocks where they are.
pub(crate) fn render<T: Tracer + Send + Sync>(
    file: &KiloView<'_>,
    job: &Job<'_>,
    mut plan: Plan,
    threads: usize,
    tracer: T,
    control: &Control<'_>,
    picture: &mut Picture,
) -> Result<Report, Error> {
    // One thread is this one.
    let pool = (threads != 1).then(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build());
    let pool =
        pool.transpose().map_err(|cause| Error::Threads { threads, cause: cause.to_string() })?;
    let threads = pool.as_ref().map_or(1, rayon::ThreadPool::current_num_threads);
    let (width, height) = (picture.width, picture.height);
    while plan.side > SIDE_MIN
        && Tiling::new(width, height, plan.side as u32).len() < TILES_PER_THREAD * threads as u32
    {
        plan.side /= 2;
    }
    let tiling = Tiling::new(width, height, plan.side as u32);
    let budget = plan.budget(usize::MAX)?;
    let next = AtomicU32::new(0);
    let top = Top::new(file);
    let source = top.over(*file);
    let shared = Mutex::new(Shared {
        picture,
        counts: Counts::default(),
        budget,
        overflows: 0,
        done: 0,
        error: None,
    });
    let work = || {
        let done = worker(source, job, &plan, tiling, tracer, control, &next, &shared);
        if let Err(error) = done {
            // The others stop at their next tile.
            next.store(u32::MAX / 2, Ordering::Relaxed);
            if let Ok(mut shared) = shared.lock() {
                shared.error.get_or_insert(error);
            }
        }
    };
    match &pool {
        Some(pool) => drop(pool.broadcast(|_| work())),
        None => work(),
    }
    let shared = match shared.into_inner() {
        Ok(shared) => shared,
        Err(poisoned) => poisoned.into_inner(),
    };
    let Shared { counts, budget, overflows, error, .. } = shared;
    let report = Report {
        counts,
        cache: CacheCounts::default(),
        budget,
        top_bytes: top.bytes(),
        threads,
        overflows,
    };
    error.map_or(Ok(report), Err)
}

/// Renders tiles as long as there are any.
#[expect(clippy::too_many_arguments, reason = "called once, with all that a picture is")]
fn worker<T: Tracer>(
    source: Expanded<'_>,
    job: &Job<'_>,
    plan: &Plan,
    tiling: Tiling,
    tracer: T,
    control: &Control<'_>,
    next: &AtomicU32,
    shared: &Mutex<Shared<'_>>,
) -> Result<(), Error> {
    let mut budget = plan.budget(usize::MAX)?;
    let mut chunks = vec![Chunk::ZERO; budget.bytes() / CHUNK_BYTES];
    let mut renderer = Renderer::new(&mut Arena::new(&mut chunks), plan)?;
    let mut sight = Sight::new(tracer, source);
    let mut counts = Counts::default();
    let settings = job.shader.settings();
    while let Some(tile) = tiling.tile(next.fetch_add(1, Ordering::Relaxed)) {
        let sums = renderer.tile(job, tile, &mut sight, &mut counts).map_err(fetched)?;
        let Ok(mut shared) = shared.lock() else { break };
        shared.overflows += shared.picture.enter(tile, sums, job.shader.unit(), settings.samples);
        shared.done += 1;
        (control.progress)(shared.done, u64::from(tiling.len()));
    }
    renderer.note_peaks(&mut budget);
    if let Ok(mut shared) = shared.lock() {
        shared.counts.add(&counts);
        shared.budget.merge_peaks(&budget);
    }
    Ok(())
}

/// An error of blocks in place, as one of blocks that are fetched.
fn fetched(error: RenderError<kiloray_core::block::NoBlock>) -> Error {
    let error = match error {
        RenderError::Trace(TraceError::Source(error)) => {
            RenderError::Trace(TraceError::Source(FetchError::Medium { block: error.0, error }))
        }
        RenderError::Trace(TraceError::Corrupt { block }) => {
            RenderError::Trace(TraceError::Corrupt { block })
        }
        RenderError::Plan => RenderError::Plan,
        RenderError::Cancelled => RenderError::Cancelled,
    };
    error.into()
}
