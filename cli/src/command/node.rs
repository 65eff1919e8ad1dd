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
    let incarnation = node.incarnation.unwrap_or_else(Identity::any_incarnation);
    run_node(&config, node.node, incarnation, node.tied).map_err(refused)
}

/// An error of a mesh of processes in one line: exit code 2 where it is about what was typed.
pub(super) fn refused(error: Error) -> Failure {
    match error {
        Error::Io { path, source } => Failure::io(&path, &source),
        Error::Budget(error) => super::engine::too_small(&error),
        Error::Size { .. } | Error::View | Error::Topology(_) | Error::Options(_) => {
            Failure::usage(error)
        }
        other => Failure::new(other),
    }
}
