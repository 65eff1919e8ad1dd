use kiloray_core::block::KiloView;
use kiloray_core::network::NodeId;
use kiloray_core::node::NodePlan;
use kiloray_core::store::{Budget, BudgetError};

use crate::check::check;
use crate::pace::layout;
use crate::{Error, Options};

/// How a run would be divided: blocks among nodes, and the memory of each.
#[derive(Debug, Clone)]
pub struct MeshPlan {
    /// The nodes, by number.
    pub nodes: Vec<NodeShare>,
    /// The least memory of a node with which these options work \[bytes\].
    pub least: usize,
}

/// What a node has.
#[derive(Debug, Clone, Copy)]
pub struct NodeShare {
    /// The lengths of all lines of its memory.
    pub plan: NodePlan,
    /// The same, in bytes.
    pub budget: Budget,
    /// Blocks that it owns, those at the top of the tree that all have included.
    pub owned: u32,
}

/// Divides blocks and memory as [`simulate`](crate::simulate()) would, and does no more.
///
/// # Errors
/// [`Error`]: for what cannot begin.
pub fn plan(file: &KiloView<'_>, options: &Options) -> Result<MeshPlan, Error> {
    check(file, options)?;
    let (least, short) = least(file, options)?;
    let layout = layout(file, options).map_err(|error| match short {
        // What is needed in the end: the next node may need more than the first that has too little.
        Some(short) => BudgetError { memory: options.mesh.memory, ..short },
        None => error,
    })?;
    let nodes =
        layout.plans.iter().zip(&layout.budgets).zip(0..).map(|((&plan, &budget), node)| {
            NodeShare { plan, budget, owned: layout.owned(NodeId(node)) }
        });
    Ok(MeshPlan { nodes: nodes.collect(), least })
}

/// The least memory that works, and what is needed where there is less: from nothing up, each that is too small names what it needs.
fn least(file: &KiloView<'_>, options: &Options) -> Result<(usize, Option<BudgetError>), Error> {
    let (mut memory, mut short) = (0, None);
    loop {
        match layout(file, &options.with_memory(memory)) {
            Err(error) if error.need() > memory => {
                (memory, short) = (error.need(), Some(error));
            }
            other => return Ok(other.map(|_| (memory, short))?),
        }
    }
}
