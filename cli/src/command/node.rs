//! `kiloray node`: one node of a mesh of processes.

use kiloray_host::{Config, Error, Identity, run_node, tie};

use crate::{
    args,
    failure::{Failure, Outcome},
};

/// Works until the host says that it is over.
pub(super) fn run(node: &args::Node) -> Outcome {
    if node.tied {
        tie(&node.config);
        // Whoever has started it knows which it is.
        return work(node);
    }
    work(node).map_err(|failure| failure.of(format_args!("node {}", node.node)))
}

fn work(node: &args::Node) -> Outcome {
    let mut config = Config::read(&node.config).map_err(refused)?;
    config.listen.clone_from(&node.listen);
    config.insecure = node.insecure;
    let nodes = config.addresses.len();
    if usize::from(node.node) >= nodes {
        let last = nodes.saturating_sub(1);
        return Err(Failure::usage(format_args!(
            "{} has nodes 0 to {last} only",
            node.config.display()
        )));
    }
    let incarnation = node.incarnation.unwrap_or_else(Identity::any_incarnation);
    run_node(&config, node.node, incarnation, node.tied).map_err(refused)
}

/// An error of a mesh of processes in one line: exit code 2 where it is about what was typed.
pub(super) fn refused(error: Error) -> Failure {
    refused_with(error, 0)
}

/// The same where packets have this size.
pub(super) fn refused_with(error: Error, packet: u16) -> Failure {
    match error {
        Error::Io { path, source } => Failure::io(&path, &source),
        Error::Budget(error) => super::engine::too_small(&error, error.need(), packet),
        Error::Picture(_) | Error::Topology(_) | Error::Options(_) => Failure::usage(error),
        other => Failure::new(other),
    }
}
