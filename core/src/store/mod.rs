//! A node's memory: one arena, carved once into lines whose lengths are chosen at run time.
//!
//! | part | what it is |
//! | --- | --- |
//! | [`Budget`] | the plan: how many bytes each [`Line`] gets, or why that cannot work |
//! | [`Arena`] | the bytes, carved by the plan into slices of plain data |
//! | [`BlockCache`] | frames for blocks, found by block number, least recently used leaves first |
//! | [`FetchedBlocks`] | a source of blocks for the tracer: the cache, and the medium behind it |
//! | [`Queue`] | first in, first out, over a slice |
//!
//! Everything is bounded by the length of a slice that the caller lends, and full is a normal state with a defined answer.

mod arena;
mod budget;
mod cache;
mod fetch;
mod frame_table;
mod queue;

pub use arena::{Arena, ArenaFull, CHUNK_BYTES, Chunk};
pub use budget::{Budget, BudgetError, Line, LineBudget, LineNeed};
pub use cache::{BlockCache, CacheCounts, CacheFull, Claim, Residency};
pub use fetch::{Checked, FetchError, FetchedBlocks, Medium};
pub(crate) use frame_table::frame_bytes;
pub use frame_table::{frame_table_bytes, frames_that_fit};
pub use queue::Queue;
