//! The actor: a node of a mesh, in one arena.

mod counts;
mod placement;
mod settings;
mod work;

pub use counts::{Counts, Kind, Kinds};
pub use placement::{Dealing, Placement};
pub use settings::{Prefetch, RayKind, Schedule, Settings, TaskOrder};
pub use work::{Lack, Next, Progress, Time, Work};
