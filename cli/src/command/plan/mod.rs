//! `kiloray plan`: what a memory is spent on.

mod mesh;
mod node;

use kiloray_core::store::{Budget, BudgetError};
use serde_json::{Value, json};

use super::engine;
use crate::{
    args::{self, firmware, size::typed},
    console::{bytes, line},
    failure::{Failure, Outcome},
};

/// Prints the budget of a node, alone or of a mesh.
pub(super) fn run(arguments: &args::Plan) -> Outcome {
    let to_standard = arguments.json.as_deref() == Some("-".as_ref());
    if let (Some(ram), false) = (arguments.ram, to_standard) {
        line(format_args!(
            "Of {} of RAM a board's firmware takes {} of statics and {} of stack; {}.",
            bytes(ram),
            bytes(firmware::STATICS),
            bytes(firmware::STACK),
            match arguments.memory() {
                0 => "nothing is left".into(),
                left => format!("{} are left", bytes(left)),
            }
        ))?;
    }
    if arguments.is_mesh { mesh::run(arguments) } else { node::run(arguments) }
}

/// What is needed: of the memory, or of the RAM where that was given.
fn too_small(arguments: &args::Plan, error: &BudgetError, least: usize, packet: u16) -> Failure {
    let Some(ram) = arguments.ram else { return engine::too_small(error, least, packet) };
    let firmware = firmware::STATICS + firmware::STACK;
    let all = firmware + least as u64;
    Failure::new(format_args!(
        "--ram {}: the firmware takes {} and the node at least {least} bytes: give {}",
        typed(ram),
        bytes(firmware),
        typed(all.next_multiple_of(1 << 10))
    ))
}

/// The lines that take anything.
fn budget_json(budget: &Budget) -> Vec<Value> {
    let lines = budget.lines().iter().filter(|line| line.bytes > 0);
    lines
        .map(|l| json!({ "line": l.line.name(), "capacity": l.capacity, "bytes": l.bytes }))
        .collect()
}
