use std::io;
use std::path::Path;
use std::time::{Duration, Instant};
use std::{fs, process, thread};

use kiloray_core::block::KiloView;
use kiloray_core::network::NodeId;
use kiloray_core::node::{Node, Picture};
use kiloray_core::shade::LightRows;
use kiloray_core::store::{Arena, CHUNK_BYTES, Chunk};
use kiloray_render::{MeshNode, ThreadScratch};
use kiloray_scene::kilo::KiloFile;
use kiloray_simd::Auto;

use crate::drive::Drive;
use crate::supervisor::FOLDER_PREFIX;
use crate::{Config, Error, Job, Network, NodeReport, Place, ProcessMemory, drive, memory};

/// A host that is gone may have said before that the run is over: that is on its way for so long at most.
const LAST_WORDS: Duration = Duration::from_millis(500);
/// The host leaves when it has the reports of all nodes, or has waited for them in vain: no later than this.
const HOST_LEAVES: Duration = Duration::from_secs(3);

/// How often a directory is removed, at most, into which something is put meanwhile.
const REMOVALS: u32 = 1000;

/// A node's life: it takes its place in the network, works until the host says that it is over, and reports.
///
/// `incarnation` tells it from others that were or will be at its place. Unless it `is_tied` to a supervisor ([`tie`]), it ends also when the host is gone.
///
/// # Errors
/// [`Error`], for what cannot begin, and a host that works on something else.
pub fn run_node(config: &Config, node: u16, incarnation: u32, is_tied: bool) -> Result<(), Error> {
    let start = Instant::now();
    if config.mesh.enforce {
        memory::enforce(config.mesh.memory)?;
    }
    let here = NodeId(node);
    let place = Place::new(here);
    let file = KiloFile::map(&config.scene)?;
    let file_bytes = file.bytes().len() as u64;
    let file = file.view();
    let job = Job::new(config, &file)?;
    let (Some(plan), Some(&budget)) =
        (job.layout.plans.get(usize::from(node)), job.layout.budgets.get(usize::from(node)))
    else {
        let last = job.layout.plans.len().saturating_sub(1);
        return Err(Error::Options(format!(
            "there is no node {node}: the mesh has nodes 0 to {last}"
        )));
    };
    // Header and tables, and the blocks of its share.
    let others = u64::from(file.blocks() - job.layout.owned(here));
    let mapped = file_bytes - others * file.limits().block_bytes as u64;
    check_share(&config.scene, &file, &job, here)?;

    let mut chunks = vec![Chunk::ZERO; config.mesh.memory / CHUNK_BYTES];
    let rows = LightRows::new(file.lights());
    let shader = job.shader(&file).with_rows(&rows);
    let world = Picture::new(Auto::detect(), shader, job.camera, job.tiling(), file.limits())
        .working_in(ThreadScratch { together: true });
    let rom = job.layout.rom(&file, here);
    let mut arena = Arena::new(&mut chunks);
    let actor = Node::new(&mut arena, plan, budget, job.layout.settings, rom, job.mesh, world)?;
    let mut actor = MeshNode(actor);

    let identity = job.identity(&file, place, incarnation);
    let mut network = Network::open(config, &job, identity.clone())?;
    let (mut gone, mut differs) = (None, None);
    let (time, waits) =
        drive(&mut actor, &mut network, &Drive::new(start, &job, place), |_, network| {
            for (host, is_there) in network.take_changes() {
                if host.place == Place::HOST {
                    gone = (!is_tied && !is_there).then(Instant::now);
                    differs = host.differs(&identity).filter(|_| !is_tied);
                }
            }
            let is_gone = gone.is_some_and(|since: Instant| since.elapsed() >= LAST_WORDS);
            is_gone || differs.is_some() || network.is_over()
        });
    if let Some(cause) = differs {
        return Err(Error::Node { node: Place::HOST, cause });
    }
    if !network.is_over() {
        let cause = "has gone, and has not said that the run is over".into();
        return Err(Error::Node { node: Place::HOST, cause });
    }
    if gone.is_none() {
        let budget = actor.budget();
        let report = NodeReport {
            node,
            incarnation,
            counts: actor.counts(),
            time,
            memory: budget.memory(),
            peak_bytes: budget.peak_bytes(),
            lines: NodeReport::lines(&budget),
            process: ProcessMemory::now(config.mesh.memory, mapped, config.mesh.enforce),
            owned_blocks: job.layout.owned(here),
            waits,
            foreign: network.foreign(),
        };
        let report = serde_json::to_vec(&report).map_err(|e| Error::Network(e.to_string()))?;
        network.report(report)?;
        // Who leaves takes along what has not arrived: QUIC sends nothing of a connection that was closed.
        let said = Instant::now();
        while network.there(Place::HOST).is_some()
            && let Some(rest) = HOST_LEAVES.checked_sub(said.elapsed())
        {
            network.wait_for_news(rest);
        }
    }
    network.close();
    Ok(())
}

/// Ties this process to the one that holds the other end of its standard input: when that is closed, as it is by the death of whoever held it,
/// this one ends, and removes the directory that a supervisor made for its nodes.
pub fn tie(config: &Path) {
    let folder = config.parent().map(Path::to_owned);
    // One that is frozen then goes on, to see it.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::set_parent_process_death_signal(Some(rustix::process::Signal::CONT));
    thread::spawn(move || {
        // What comes is of no interest, how it ends neither.
        let _ = io::copy(&mut io::stdin().lock(), &mut io::sink());
        let name = folder.as_deref().and_then(Path::file_name).and_then(|name| name.to_str());
        if let Some(folder) = &folder
            && name.is_some_and(|name| name.starts_with(FOLDER_PREFIX))
        {
            remove(folder);
        }
        // Not `exit`: it would wait for the engine's threads, and whatever is half done is of no use to anybody.
        #[cfg(unix)]
        let _ =
            rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::KILL);
        process::exit(0);
    });
}

/// Removes the directory of nodes. Others remove it at the same time, and what has only begun to listen, here or there, may put a socket into it
/// between the last look and the end: then it is removed again.
fn remove(folder: &Path) {
    for _ in 0..REMOVALS {
        if fs::remove_dir_all(folder).is_ok() || !folder.exists() {
            return;
        }
    }
}

/// Checks the blocks that a node reads in place, once, and no others.
fn check_share(path: &Path, file: &KiloView<'_>, job: &Job, here: NodeId) -> Result<(), Error> {
    let held = |block: &u32| job.layout.settings.placement.holds(here, *block);
    for block in (0..file.blocks()).filter(held) {
        file.check_block(block)
            .and_then(|view| file.check_refs(&view))
            .map_err(|error| Error::Share { path: path.into(), error })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_directory_is_removed_into_which_others_put_something_meanwhile() {
        for _ in 0..20 {
            let folder = tempfile::tempdir().unwrap().keep();
            let fills = |from: u32| {
                let folder = &folder;
                move || {
                    (from..from + 100).for_each(|n| drop(fs::write(folder.join(n.to_string()), [])))
                }
            };
            thread::scope(|scope| {
                scope.spawn(fills(0));
                scope.spawn(fills(100));
                scope.spawn(|| remove(&folder));
            });
            assert!(!folder.exists());
        }
    }
}
