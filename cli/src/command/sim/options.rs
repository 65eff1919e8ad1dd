use kiloray_core::{
    network::{NodeId, Topology},
    scene::View,
};
use kiloray_render::framing;
use kiloray_sim::{
    Crash, Error, Faults, Link, MeshOptions, Options, Profile, Rate, Slow, Switching,
};

use crate::{
    args::{self, Bounds},
    command::{calibrate, division, engine},
    console, cores,
    failure::{Failure, Outcome},
    scene::Scene,
};

/// Memory of the one node that efficiency is measured against: more than it can use.
const BASELINE_MEMORY: usize = 64 << 20;
/// Most events of a trace: a file of some 30 MB.
const TRACE_EVENTS: usize = 300_000;

/// What the simulator is told.
pub(in crate::command) fn options(sim: &args::Sim, scene: &Scene) -> Outcome<Options> {
    let (common, mesh) = (&sim.common, &sim.mesh);
    let view = scene.choose_view(common.view.as_ref())?;
    let bounds =
        Bounds::new(common.width, common.height, framing::aspect(&view)).map_err(Failure::usage)?;
    let topology = mesh.division.topology().map_err(Failure::usage)?;
    let divided = division::options(common, &mesh.division, bounds, topology, &scene.file.view())?;
    let view = framing::fitted(view, bounds.width, bounds.height);
    let mut options = on(divided, view, mesh)?;
    options.seed = mesh.fault_seed.unwrap_or(common.seed);
    options.trace = if sim.trace.is_some() { TRACE_EVENTS } else { 0 };
    options.threads = threads(sim);
    Ok(options)
}

/// Threads of the mesh: all that there are but one, where the one node to compare it with takes its steps at the same time.
fn threads(sim: &args::Sim) -> usize {
    let all = cores::threads(sim.common.threads);
    all.saturating_sub(usize::from(!sim.no_baseline)).max(1)
}

/// A divided run with what is said of the machine, on one thread.
pub(in crate::command) fn on(
    divided: MeshOptions,
    view: View,
    mesh: &args::Mesh,
) -> Outcome<Options> {
    let mut options = Options::new(divided.width, divided.height, view, divided.topology);
    options.mesh = MeshOptions { owned_in_arena: mesh.owned_in_arena, ..divided };
    options.link = link(mesh, options.link);
    options.bundle_age = mesh.bundle;
    options.profile = match &mesh.profile {
        args::Profile::Named(name) => Profile::named(name).unwrap_or(Profile::PC),
        args::Profile::File(path) => calibrate::read(path)?,
    };
    options.faults = faults(mesh);
    options.threads = 1;
    Ok(options)
}

/// The same picture on one node of the same profile that has all blocks, and memory to spare.
pub(in crate::command) fn baseline(options: &Options) -> Outcome<Options> {
    let topology = Topology::parse("line", 1).map_err(Failure::new)?;
    let mesh = MeshOptions {
        topology,
        memory: BASELINE_MEMORY,
        replicas: 1,
        group: 0,
        owned_in_arena: false,
        ..options.mesh
    };
    // Without faults their seed is none: baselines of runs that differ by it alone are one.
    let faults = Faults::default();
    Ok(Options { mesh, faults, seed: 0, trace: 0, threads: 1, ..options.clone() })
}

/// An error of the simulator with these options: exit code 2 where it is about what was typed.
pub(in crate::command) fn refused(error: Error, options: &Options) -> Failure {
    match error {
        Error::Budget(error) => engine::too_small(&error, error.need(), options.mesh.packet),
        Error::Memory { nodes, bytes, .. } => Failure::new(format_args!(
            "{nodes} nodes of {} have more memory than can be had here; take fewer --nodes, or less --memory",
            console::bytes(bytes as u64)
        )),
        Error::Arena(_) | Error::Threads { .. } => Failure::new(error),
        other => Failure::usage(other),
    }
}

fn link(mesh: &args::Mesh, mut link: Link) -> Link {
    link.bandwidth = mesh.link_bandwidth.unwrap_or(link.bandwidth);
    link.latency = mesh.link_latency.unwrap_or(link.latency);
    link.switching = match mesh.switching {
        Some(args::Switching::Store) => Switching::StoreAndForward,
        Some(args::Switching::Cut) => Switching::CutThrough,
        None => link.switching,
    };
    link
}

fn faults(mesh: &args::Mesh) -> Faults {
    let rate = |part: Option<args::Part>| {
        part.map_or_else(Rate::default, |part| Rate { count: part.numerator, of: part.denominator })
    };
    Faults {
        loss: rate(mesh.loss),
        duplicate: rate(mesh.duplicate),
        jitter: mesh.jitter.unwrap_or(0),
        slow: mesh
            .slow
            .iter()
            .map(|slow| Slow { node: NodeId(slow.node), factor: slow.factor })
            .collect(),
        crashes: mesh
            .crash
            .iter()
            .map(|crash| Crash { node: NodeId(crash.node), at: crash.time })
            .collect(),
    }
}
