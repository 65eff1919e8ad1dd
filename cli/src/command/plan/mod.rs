//! `kiloray plan`: what a memory is spent on.

mod mesh;
mod node;

use kiloray_core::store::Budget;
use serde_json::{Value, json};

use crate::{
    args::{self, firmware},
    console::{bytes, line},
    failure::Outcome,
};

/// Prints the budget of a node, alone or of a mesh.
pub(super) fn run(arguments: &args::Plan) -> Outcome {
    let to_standard = arguments.json.as_deref() == Some("-".as_ref());
    if let (Some(ram), false) = (arguments.ram, to_standard) {
        line(format_args!(
            "Of {} of RAM a board's firmware takes {} of statics and {} of stack; {} are left.",
            bytes(ram),
            bytes(firmware::STATICS),
            bytes(firmware::STACK),
            bytes(arguments.memory)
        ))?;
    }
    if arguments.is_mesh { mesh::run(arguments) } else { node::run(arguments) }
}

/// The lines that take anything.
fn lines(budget: &Budget) -> Vec<Value> {
    let lines = budget.lines().iter().filter(|line| line.bytes > 0);
    lines
        .map(|l| json!({ "line": l.line.name(), "capacity": l.capacity, "bytes": l.bytes }))
        .collect()
}
