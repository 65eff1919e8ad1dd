use crate::undersampled::Rounds;
use crate::{Control, Error, Picture, Report};
use kiloray_core::block::KiloView;
use kiloray_core::render::{Job, Plan, Renderer, Sight, Tiling};
use kiloray_core::shade::Counts;
use kiloray_core::store::{Arena, BlockCache, CHUNK_BYTES, Checked, Chunk, FetchedBlocks, Line};
use kiloray_core::trace::Tracer;

/// Renders all tiles as one node with a given memory.
#[expect(clippy::too_many_arguments, reason = "called once, with all that a picture is")]
pub(crate) fn render<T: Tracer>(
    file: &KiloView<'_>,
    job: &Job<'_>,
    plan: &Plan,
    memory: usize,
    tiling: Tiling,
    tracer: T,
    control: &Control<'_>,
    rounds: &mut Rounds,
    picture: &mut Picture,
) -> Result<Report, Error> {
    let mut budget = plan.budget(memory)?;
    let mut chunks = vec![Chunk::ZERO; budget.bytes() / CHUNK_BYTES];
    let mut arena = Arena::new(&mut chunks);
    let mut renderer = Renderer::new(&mut arena, plan)?;
    let cache = BlockCache::new(&mut arena, plan.block_bytes, plan.frames)?;
    let mut sight = Sight::new(tracer, FetchedBlocks::new(cache, Checked(*file), file.limits()));
    let mut counts = Counts::default();
    let mut overflows = 0;
    loop {
        let job = &Job { only: rounds.wanted(), ..*job };
        for index in 0..tiling.len() {
            let Some(tile) = tiling.tile(index) else { break };
            if !rounds.skips(tile, job.width) {
                let sums = renderer.tile(job, tile, &mut sight, &mut counts)?;
                overflows += picture.enter(tile, sums, job);
            }
            let (done, all) = rounds.progress(index + 1, tiling.len());
            (control.progress)(done, all);
        }
        if !rounds.next(picture) {
            break;
        }
    }
    renderer.note_peaks(&mut budget);
    let cache = sight.source().counts();
    budget.note_peak(Line::Frames, cache.frames_peak as usize);
    budget.note_peak(Line::FrameTable, cache.frames_peak as usize);
    let interpolated = rounds.interpolated();
    Ok(Report { counts, cache, budget, top_bytes: 0, threads: 1, overflows, interpolated })
}
