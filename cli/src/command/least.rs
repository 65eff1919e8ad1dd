//! The least memory of a mesh's nodes: it is the least also where less or more of it has other blocks.

use kiloray_core::store::BudgetError;
use kiloray_sim::{Error, MeshLayout, Options, least, plan};

use super::{division, sim};
use crate::{
    args,
    failure::{Failure, Outcome},
    scene::{self, Scene},
};

/// A scene, and how it is divided.
pub(super) struct Mesh<'a, F> {
    /// Where it is from.
    pub(super) sources: &'a args::Scene,
    /// Its size of blocks, where that was said.
    pub(super) block: Option<u32>,
    pub(super) scene: &'a Scene,
    /// What the simulator is told of it.
    pub(super) options: F,
}

impl<F: Fn(&Scene) -> Outcome<Options>> Mesh<'_, F> {
    /// Whether the size of blocks follows from the memory.
    pub(super) fn follows(&self) -> bool {
        self.block.is_none() && self.scene.stats.is_some()
    }

    /// The options, and how they divide the scene. Refuses a memory that is `too_small`, of which it is told the least and the packet that was asked for,
    /// and options that cannot be.
    pub(super) fn check(
        &self,
        too_small: impl FnOnce(&BudgetError, usize, u16) -> Failure,
    ) -> Outcome<(Options, MeshLayout)> {
        let options = (self.options)(self.scene)?;
        match plan(&self.scene.file.view(), &options) {
            Ok(layout) => Ok((options, layout)),
            Err(Error::Budget(error)) => {
                Err(too_small(&error, self.least(error.need()), options.mesh.packet))
            }
            Err(other) => Err(sim::refused(other, &options)),
        }
    }

    /// The least memory that works; `here` is that with the blocks that the scene has now.
    pub(super) fn least(&self, here: usize) -> usize {
        if !self.follows() {
            return here;
        }
        let now = self.scene.file.view().header().block_bytes;
        let mut above = 0;
        for size in division::sizes() {
            let need = if size == now { Some(here) } else { self.need(size) };
            let suited = division::suited_by(size);
            match need {
                Some(need) if need as u64 <= suited => return need.max(above),
                // Even all that has such blocks may be too little.
                _ => above = suited as usize + 1,
            }
        }
        here
    }

    /// The least memory with blocks of a size; `None` where that cannot be.
    fn need(&self, block: u32) -> Option<usize> {
        let scene = scene::load(self.sources, Some(block), block, true).ok()?;
        least(&scene.file.view(), &(self.options)(&scene).ok()?).ok()
    }
}
