//! Processes that do nothing, under the eyes of a supervisor.

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use kiloray_core::network::NodeId;

use super::mesh::{config, scene};
use crate::{Error, Folder, Place, Supervisor};

/// A supervisor of two nodes, each of which only waits for its end.
fn supervisor() -> Supervisor {
    start(false)
}

fn start(is_cancelled: bool) -> Supervisor {
    let program = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/src/tests/waits"));
    let config = config(&scene("cornell"), 2, "full", 1 << 16);
    let folder = Folder::new().expect("a directory");
    let cancel = AtomicBool::new(is_cancelled);
    Supervisor::start(program, folder, &config, &cancel).expect("they start")
}

/// When all that has been started has had so many seconds.
fn after(seconds: u64) -> Instant {
    Instant::now() + Duration::from_secs(seconds)
}

#[test]
fn what_is_cancelled_starts_no_more() {
    assert_eq!(supervisor().processes().len(), 2);
    assert!(start(true).processes().is_empty());
}

#[test]
fn one_that_runs_and_is_not_there_is_replaced() {
    let mut supervisor = supervisor();
    let first = supervisor.processes();
    supervisor.is_there(Place::new(NodeId(0)), 0);
    assert_eq!(supervisor.look(after(9)).expect("all run"), []);
    let replaced = supervisor.look(after(15)).expect("another starts");
    assert_eq!(replaced.iter().map(|one| one.node).collect::<Vec<_>>(), [1]);
    assert!(replaced[0].cause.contains("not there after 10 s"), "{replaced:?}");
    let second = supervisor.processes();
    assert_eq!(first[0], second[0]);
    assert_ne!(first[1], second[1]);
    // The next has twice as long: where all are slow, few are replaced in vain.
    assert_eq!(supervisor.look(after(19)).expect("all run"), []);
    // The one before may have been late only.
    supervisor.is_there(Place::new(NodeId(1)), 0);
    assert_eq!(supervisor.look(after(25)).expect("another starts").len(), 1);
    // It is there: it has all the time that it wants.
    supervisor.is_there(Place::new(NodeId(1)), 2);
    assert_eq!(supervisor.look(after(1000)).expect("all run"), []);
}

#[test]
fn a_node_that_is_never_there_ends_the_run() {
    let mut supervisor = supervisor();
    supervisor.is_there(Place::new(NodeId(1)), 0);
    let mut looks = (1..).map(|_| supervisor.look(after(60)));
    let error = looks.find_map(Result::err).expect("it gives up");
    assert!(matches!(&error, Error::Node { node, .. } if node.id() == NodeId(0)), "{error}");
    assert!(error.to_string().contains("not there after 40 s"), "{error}");
}
