use crate::top::Top;
use crate::undersampled::Rounds;
use crate::{Control, Error, Picture, Report};
use kiloray_core::block::{Expanded, KiloView};
use kiloray_core::render::{Job, Plan, RenderError, Renderer, Sight, Tiling};
use kiloray_core::shade::Counts;
use kiloray_core::store::{Arena, CHUNK_BYTES, CacheCounts, Chunk, FetchError};
use kiloray_core::trace::{TraceError, Tracer};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};

/// Least side of a tile, however many threads want one.
const SIDE_MIN: usize = 8;
/// So many tiles for each thread, that the last ones do not wait long for each other.
const TILES_PER_THREAD: u32 = 16;

/// A thread's memory, and what it has found.
struct Worker<'m, T> {
    renderer: Renderer<'m>,
    sight: Sight<T, Expanded<'m>>,
    counts: Counts,
}

/// The work of a round, which threads share.
struct Round<'r> {
    job: Job<'r>,
    tiling: Tiling,
    control: &'r Control<'r>,
    /// The tile that is next.
    next: AtomicU32,
    /// Rounds and tiles, done and in all.
    rounds: &'r Rounds,
    shared: Mutex<Shared<'r>>,
}

/// What one thread changes at a time.
struct Shared<'r> {
    picture: &'r mut Picture,
    overflows: u64,
    done: u32,
    error: Option<Error>,
}

/// Renders all tiles on all cores, with the blocks where they are.
#[expect(clippy::too_many_arguments, reason = "called once, with all that a picture is")]
pub(crate) fn render<T: Tracer + Send + Sync>(
    file: &KiloView<'_>,
    job: &Job<'_>,
    mut plan: Plan,
    threads: usize,
    tracer: T,
    control: &Control<'_>,
    rounds: &mut Rounds,
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
    let mut budget = plan.budget(usize::MAX)?;
    let top = Top::new(file);
    let source = top.over(*file);
    let memory = || vec![Chunk::ZERO; budget.bytes() / CHUNK_BYTES];
    let mut memories: Vec<_> = (0..threads).map(|_| memory()).collect();
    let mut workers = Vec::new();
    for memory in &mut memories {
        let renderer = Renderer::new(&mut Arena::new(memory), &plan)?;
        let sight = Sight::new(tracer, source);
        workers.push(Mutex::new(Worker { renderer, sight, counts: Counts::default() }));
    }
    let mut overflows = 0;
    loop {
        let shared = Shared { picture, overflows, done: 0, error: None };
        let round = Round {
            job: Job { only: rounds.wanted(), ..*job },
            tiling,
            control,
            next: AtomicU32::new(0),
            rounds,
            shared: Mutex::new(shared),
        };
        match &pool {
            Some(pool) => drop(pool.broadcast(|thread| round.work(&workers[thread.index()]))),
            None => round.work(&workers[0]),
        }
        let shared = into_inner(round.shared);
        overflows = shared.overflows;
        if let Some(error) = shared.error {
            return Err(error);
        }
        if !rounds.next(picture) {
            break;
        }
    }
    let mut counts = Counts::default();
    for worker in workers.into_iter().map(into_inner) {
        counts.add(&worker.counts);
        worker.renderer.note_peaks(&mut budget);
    }
    Ok(Report {
        counts,
        cache: CacheCounts::default(),
        budget,
        top_bytes: top.bytes(),
        threads,
        overflows,
        interpolated: rounds.interpolated(),
    })
}

/// What is behind a lock; a panic of another thread is reported where that ends.
fn into_inner<T>(lock: Mutex<T>) -> T {
    lock.into_inner().unwrap_or_else(PoisonError::into_inner)
}

impl Round<'_> {
    /// Renders tiles as long as there are any.
    fn work<T: Tracer>(&self, worker: &Mutex<Worker<'_, T>>) {
        let Ok(mut worker) = worker.lock() else { return };
        if let Err(error) = self.tiles(&mut worker) {
            // The others stop at their next tile.
            self.next.store(u32::MAX / 2, Ordering::Relaxed);
            if let Ok(mut shared) = self.shared.lock() {
                shared.error.get_or_insert(error);
            }
        }
    }

    fn tiles<T: Tracer>(&self, worker: &mut Worker<'_, T>) -> Result<(), Error> {
        let Worker { renderer, sight, counts } = worker;
        while let Some(tile) = self.tiling.tile(self.next.fetch_add(1, Ordering::Relaxed)) {
            let mut sums = None;
            if !self.rounds.skips(tile, self.job.width) {
                sums = Some(renderer.tile(&self.job, tile, sight, counts).map_err(fetched)?);
            }
            let Ok(mut shared) = self.shared.lock() else { break };
            if let Some(sums) = sums {
                shared.overflows += shared.picture.enter(tile, sums, &self.job);
            }
            shared.done += 1;
            let (done, all) = self.rounds.progress(shared.done, self.tiling.len());
            (self.control.progress)(done, all);
        }
        Ok(())
    }
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
