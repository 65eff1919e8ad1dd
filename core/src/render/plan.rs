use crate::shade::{PathRay, Shadow};
use crate::shade::{SPLITS, Sum};
use crate::store::{
    Arena, Budget, BudgetError, Line, LineBudget, frame_table_bytes, frames_that_fit,
};

/// How a node's memory is divided for rendering: the lengths of all lines.
///
/// Each line has a least length with which everything works, one ray at a time. What memory there is beyond it goes first to the
/// batch, doubled as long as frames keep half of it, then to frames, as many as there are blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Plan {
    /// Rays traced together.
    pub batch: usize,
    /// Specular rays that can wait.
    pub waiting: usize,
    /// Shadow rays that can wait.
    pub shadows: usize,
    /// Pixels along a tile.
    pub side: usize,
    /// Block frames; 0 where blocks are read in place.
    pub frames: usize,
    /// Bytes of a block.
    pub block_bytes: usize,
}

/// What of a scene decides about memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SceneSize {
    /// Bytes of a block.
    pub block_bytes: usize,
    /// Number of blocks.
    pub blocks: usize,
    /// Specular rays may occur.
    pub specular: bool,
}

/// What a person chose that decides about memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlanSettings {
    /// How many specular rays may follow each other.
    pub bounces: u8,
    /// Blocks are read in place (flash, a mapped file): no frames.
    pub in_place: bool,
    /// Most rays in a batch, 0 for the default.
    pub batch_max: usize,
}

/// Most rays in a batch by default: a bundle of the tracer.
const BATCH: usize = 64;
/// Shadow rays for each ray of a batch.
const SHADOWS: usize = 16;
/// Specular rays that can wait, for each ray of a batch: those of a batch of camera rays, and as many again.
const WAITING: usize = 4;
/// Of the memory, frames get at least this part, or as many as there are blocks: a half.
const FRAMES_PART: usize = 2;

impl Plan {
    /// Divides `memory` bytes.
    ///
    /// # Errors
    /// [`BudgetError`] if even single rays do not fit: then what each line needs at least.
    pub fn new(
        memory: usize,
        scene: &SceneSize,
        settings: &PlanSettings,
    ) -> Result<Self, BudgetError> {
        let least = Self::of(0, scene, settings);
        least.budget(memory)?;
        let steps = match settings.batch_max {
            0 => BATCH,
            max => max,
        };
        let mut best = least;
        for step in 1..=steps.ilog2().saturating_add(1) {
            let plan = Self::of(step, scene, settings);
            let work = plan.bytes();
            let frames = memory.saturating_sub(work);
            let wanted = (memory / FRAMES_PART).min(all_frames(scene, settings));
            if work > memory || frames < wanted {
                break;
            }
            best = plan;
        }
        if !settings.in_place {
            let left = memory.saturating_sub(Self { frames: 0, ..best }.bytes());
            best.frames =
                frames_that_fit(left, scene.block_bytes).min(scene.blocks).max(best.frames);
        }
        Ok(best)
    }

    /// The lengths for batches of `2^(step - 1)` rays with a single frame; the least ones for step 0.
    fn of(step: u32, scene: &SceneSize, settings: &PlanSettings) -> Self {
        let batch = 1_usize << step.saturating_sub(1).min(24);
        let splits = usize::from(SPLITS.min(settings.bounces));
        let waiting = match (scene.specular && settings.bounces > 0, step) {
            (false, _) => 0,
            (true, 0) => splits.saturating_add(1),
            (true, _) => batch.saturating_mul(WAITING).saturating_add(splits),
        };
        Self {
            batch,
            waiting,
            shadows: if step == 0 { 1 } else { batch.saturating_mul(SHADOWS) },
            side: match batch {
                ..4 => 1_usize << step.min(2),
                4..16 => 8,
                16..64 => 16,
                _ => 32,
            },
            frames: usize::from(!settings.in_place && scene.blocks > 0),
            block_bytes: scene.block_bytes,
        }
    }

    /// Pixels of a tile.
    #[must_use]
    pub const fn pixels(&self) -> usize {
        self.side.saturating_mul(self.side)
    }

    /// Bytes of all lines.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.lines().iter().fold(0, |sum, line| sum.saturating_add(line.bytes))
    }

    /// The plan, line by line.
    ///
    /// # Errors
    /// [`BudgetError`] if it takes more than `memory` bytes.
    pub fn budget(&self, memory: usize) -> Result<Budget, BudgetError> {
        Budget::new(memory, &self.lines())
    }

    fn lines(&self) -> [LineBudget; 6] {
        let frames = self.block_bytes.saturating_mul(self.frames);
        let table = if self.frames == 0 { 0 } else { frame_table_bytes(self.frames) };
        [
            LineBudget::new(Line::Points, self.waiting, Arena::bytes_of::<PathRay>(self.waiting)),
            LineBudget::new(Line::Rays, self.batch, Arena::bytes_of::<PathRay>(self.batch)),
            LineBudget::new(Line::Bundles, self.shadows, Arena::bytes_of::<Shadow>(self.shadows)),
            LineBudget::new(Line::Tile, self.pixels(), Arena::bytes_of::<Sum>(self.pixels())),
            LineBudget::new(Line::FrameTable, self.frames, table),
            LineBudget::new(Line::Frames, self.frames, Arena::bytes_of::<u8>(frames)),
        ]
    }
}

/// Bytes of frames for all blocks.
fn all_frames(scene: &SceneSize, settings: &PlanSettings) -> usize {
    if settings.in_place {
        return 0;
    }
    frame_table_bytes(scene.blocks).saturating_add(scene.block_bytes.saturating_mul(scene.blocks))
}
