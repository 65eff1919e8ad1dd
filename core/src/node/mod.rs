//! The actor: a node of a mesh, in one arena.

mod actor;
mod counts;
mod fetch;
mod inbox;
mod outbox;
mod placement;
mod plan;
mod rays;
mod rom;
mod settings;
mod slots;
#[cfg(test)]
mod tests;
mod tiles;
mod work;
mod world;

pub use actor::Node;
pub use counts::{Counts, Kind, Kinds};
pub use placement::{Dealing, Placement};
pub use plan::{NodeNeeds, NodePlan};
pub use rom::{Missing, Rom};
pub use settings::{Prefetch, RayKind, Schedule, Settings, TaskOrder};
pub use work::{Lack, Next, Progress, Time, Work};
pub use world::{Lights, Picture, Traced, World};
