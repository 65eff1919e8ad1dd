use std::mem::take;
use std::sync::atomic::Ordering;

use kiloray_core::block::KiloView;
use kiloray_core::network::{HOST, Mesh, NodeId, Router};
use kiloray_core::node::{Node, Picture, Progress, Time, Work};
use kiloray_core::render::Tiling;
use kiloray_core::shade::{LightRows, Shader, Tables};
use kiloray_core::store::{Arena, CHUNK_BYTES, Chunk};
use kiloray_mesh::{Ledger, MeshLayout};
use kiloray_render::{MeshNode, ThreadScratch, camera};
use kiloray_simd::Auto;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::arenas::Arenas;
use crate::check::check;
use crate::pace::layout;
use crate::run::{Actor, Run, RunSettings};
use crate::watchdog::Watchdog;
use crate::{
    Control, End, Error, Faults, LineReport, MeshReport, MessageReport, NodeReport, Options,
    Outcome, Report, Slow, Status, Totals,
};

/// Events after which the caller is told how far the run is; more, where there are many nodes to look at.
const EVENTS_PER_STATUS: u64 = 1024;
const EVENTS_PER_NODE: u64 = 16;
/// Events without a step forward after which a run is given up, for each node: where packets are lost, the last tile of a node with room for one block
/// takes as many.
const EVENTS_PER_STEP: u64 = if cfg!(test) { 1 << 14 } else { 1 << 20 };

/// What the task of a node takes beside the memory that it divides, on this machine \[bytes\].
pub const TASK_BYTES: usize = size_of::<MeshNode<'static>>();

/// Renders a picture of a file in memory on a mesh of simulated nodes.
///
/// Its blocks must have been checked before ([`KiloView::check_blocks`]).
///
/// # Errors
/// [`Error`]: for what cannot begin. What cannot come to its end, or is cancelled, gives an [`Outcome`] that is not complete.
pub fn simulate(
    file: &KiloView<'_>,
    options: &Options,
    control: &Control<'_>,
) -> Result<Outcome, Error> {
    with_lanes(Auto::detect(), file, options, control)
}

/// [`simulate`] with the lanes of some machine.
pub(crate) fn with_lanes(
    lanes: Auto,
    file: &KiloView<'_>,
    options: &Options,
    control: &Control<'_>,
) -> Result<Outcome, Error> {
    check(file, options)?;
    let (width, height) = (options.mesh.width, options.mesh.height);
    let samples = options.mesh.settings.samples;
    let camera = camera(&options.view, width, height, samples)?;
    let mesh = Mesh::new(options.mesh.topology);
    let mut layout = layout(file, options)?;
    let tables = Tables::of(file);
    let tiling = Tiling::new(width, height, layout.side());
    let rows = LightRows::new(file.lights());
    let world = |tables| {
        let shader = Shader::new(tables, options.mesh.settings).with_rows(&rows);
        let scratch = ThreadScratch { together: options.profile.together };
        let picture = Picture::new(lanes, shader, camera, tiling, file.limits());
        // No link changes a byte: debug builds see that it is so.
        let picture = if cfg!(debug_assertions) { picture } else { picture.with_checked_blocks() };
        picture.working_in(scratch)
    };

    let size = layout.host_router(&mesh);
    let mut host_arena = vec![Chunk::ZERO; size.arena_bytes() / CHUNK_BYTES];
    let host = HostEnd {
        router: Router::new(&mut Arena::new(&mut host_arena), mesh, HOST, size)?,
        ledger: layout.ledger(file, &options.mesh)?,
    };
    let settings = RunSettings {
        link: options.link,
        profile: options.profile.clone().in_scene(file),
        faults: options.faults.clone(),
        seed: options.seed,
        packet: layout.packet(),
        block_bytes: file.limits().block_bytes,
        trace: options.trace,
    };
    let division = layout.resolved(&options.mesh);
    let chunks = options.mesh.memory / CHUNK_BYTES;
    let mut arenas = Arenas::new(layout.plans.len(), chunks)?;
    // There may be thousands: nobody needs their plans but they themselves.
    let plans = take(&mut layout.plans).into_iter().zip(take(&mut layout.budgets));
    let nodes = arenas.each().zip(plans).zip(0..).map(|((arena, (plan, budget)), index)| {
        let here = NodeId(index);
        let rom = layout.rom(file, here);
        let mut arena = Arena::new(arena);
        let (rom, tables) = match options.mesh.owned_in_arena {
            true => (rom.copied(&mut arena)?, tables.copied(&mut arena)?),
            false => (rom, tables),
        };
        let node = Node::new(&mut arena, &plan, budget, layout.settings, rom, mesh, world(tables));
        node.map(MeshNode)
    });
    let pool = pool(options, &mesh)?;
    let threads = pool.as_ref().map_or(1, ThreadPool::current_num_threads);
    let mut run = Run::new(&mesh, nodes, host, settings, threads)?;
    let end = match pool {
        Some(pool) => pool.install(|| drive(&mut run, options, control)),
        None => drive(&mut run, options, control),
    };
    run.settle();
    let report = report(&mut run, options, &mesh, &layout);
    let ledger = &run.host.actor.ledger;
    Ok(Outcome { picture: ledger.picture(), end, overflows: ledger.overflows(), division, report })
}

/// Threads for the nodes of a mesh, if there are several of both.
fn pool(options: &Options, mesh: &Mesh) -> Result<Option<ThreadPool>, Error> {
    if options.threads == 1 || mesh.nodes() == 1 {
        return Ok(None);
    }
    let threads = options.threads;
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|cause| Error::Threads { threads, cause })?;
    Ok(Some(pool).filter(|pool| pool.current_num_threads() > 1))
}

type SimulatedRun<'m> = Run<'m, MeshNode<'m>, HostEnd<'m>>;

fn drive(run: &mut SimulatedRun<'_>, options: &Options, control: &Control<'_>) -> End {
    let nodes = run.nodes.len() as u64;
    let paths = run.host.actor.ledger.pixels() * u64::from(options.mesh.settings.samples);
    let mut watchdog = Watchdog::new(EVENTS_PER_STEP * nodes.max(64), paths);
    let pause = EVENTS_PER_STATUS.max(EVENTS_PER_NODE * nodes);
    let mut slow = SlowNodes::new(&options.faults);
    let mut told = 0;
    loop {
        let moves = run.advance();
        let ledger = &run.host.actor.ledger;
        let done = ledger.pixels_done();
        watchdog.pixels(done, (run.events, run.now));
        if ledger.is_complete() {
            return End::Complete;
        }
        if let Some(block) = ledger.lost() {
            return End::Lost(block);
        }
        if run.events - told >= pause {
            told = run.events;
            if control.cancel.load(Ordering::Relaxed) {
                return End::Cancelled;
            }
            (control.progress)(&Status {
                pixels: done,
                pixels_all: ledger.pixels(),
                virtual_ns: run.now,
                events: run.events,
                rays: run.nodes.iter().map(|place| place.actor.rays()).sum(),
            });
            let begun = run.nodes.iter().map(|place| place.actor.begun()).sum();
            watchdog.begun(begun, (run.events, run.now));
        }
        slow.note(run, watchdog.since());
        if !moves || watchdog.is_in_vain(run.events, run.now) {
            return slow.awaited(run).map_or(End::Stuck, End::Slow);
        }
    }
}

/// The nodes that are slower than the others, and how long they had worked when the run last went forward.
struct SlowNodes {
    nodes: Vec<(Slow, u64)>,
    since: u64,
}

/// A node is waited for that has worked for one in so much of the time.
const AWAITED: u64 = 8;

impl SlowNodes {
    /// The slowest first.
    fn new(faults: &Faults) -> Self {
        let mut nodes: Vec<_> =
            faults.slow.iter().filter(|slow| slow.factor > 1.0).map(|&slow| (slow, 0)).collect();
        nodes.sort_by(|(a, _), (b, _)| b.factor.total_cmp(&a.factor));
        Self { nodes, since: 0 }
    }

    /// Takes down how long they have worked, if the run has gone forward.
    fn note(&mut self, run: &SimulatedRun<'_>, since: u64) {
        if since == self.since {
            return;
        }
        self.since = since;
        for (slow, worked) in &mut self.nodes {
            *worked = run.nodes[usize::from(slow.node.0)].state.worked(run.now).0;
        }
    }

    /// The slowest that works, or has mostly worked, since the run last went forward: nothing else can be said to have come to a stop.
    fn awaited(&self, run: &SimulatedRun<'_>) -> Option<NodeId> {
        let waited = run.now.saturating_sub(self.since);
        let works = |&&(slow, before): &&(Slow, u64)| {
            let (worked, now) = run.nodes[usize::from(slow.node.0)].state.worked(run.now);
            now || worked.saturating_sub(before) > waited / AWAITED
        };
        self.nodes.iter().find(works).map(|(slow, _)| slow.node)
    }
}

impl<'m> Actor<'m> for MeshNode<'m> {
    fn poll(&mut self, now: Time) -> Progress {
        self.poll(now)
    }

    fn router(&mut self) -> &mut Router<'m> {
        (**self).router()
    }

    fn stored(&self) -> u32 {
        (**self).stored() as u32
    }

    fn rays(&self) -> u64 {
        self.counts().shade.rays()
    }

    fn begun(&self) -> u64 {
        self.counts().shade.primary
    }
}

/// The host outside the mesh: it takes no time.
struct HostEnd<'m> {
    router: Router<'m>,
    ledger: Ledger,
}

impl<'m> Actor<'m> for HostEnd<'m> {
    fn poll(&mut self, now: Time) -> Progress {
        Progress { work: Work::default(), next: self.ledger.poll(now, &mut self.router) }
    }

    fn router(&mut self) -> &mut Router<'m> {
        &mut self.router
    }

    fn pixels(&self) -> u64 {
        self.ledger.pixels_done()
    }

    fn may_end(&self, bytes: u64) -> bool {
        self.ledger.bytes_missing() <= bytes
    }

    fn has_ended(&self) -> bool {
        self.ledger.is_complete() || self.ledger.lost().is_some()
    }
}

fn report(
    run: &mut SimulatedRun<'_>,
    options: &Options,
    mesh: &Mesh,
    layout: &MeshLayout,
) -> Report {
    let slow = |node: u16| {
        let slow = options.faults.slow.iter().rfind(|slow| slow.node.0 == node);
        slow.map_or(1.0, |slow| slow.factor)
    };
    let faults = run.faults();
    let crashed = |node: u16| {
        let crash = faults.crashes.iter().find(|crash| crash.node == node);
        crash.map(|crash| crash.at_ns)
    };
    let fingerprint = format!("{:016x}", run.fingerprint());
    let links = run.take_links();
    // Each report where its place was: there may be thousands.
    let nodes = take(&mut run.nodes).into_iter().zip(0..);
    let nodes: Vec<NodeReport> = nodes
        .map(|(place, number)| {
            let (node, state) = (&place.actor, &place.state);
            let budget = node.budget();
            NodeReport {
                node: number,
                slow: slow(number),
                crashed_ns: crashed(number),
                time: state.time,
                steps: state.steps,
                counts: node.counts(),
                work: state.work,
                memory: budget.memory(),
                peak_bytes: budget.peak_bytes(),
                lines: budget.lines().iter().map(LineReport::from).collect(),
                owned_blocks: layout.owned(NodeId(number)),
            }
        })
        .collect();
    let totals = Totals::new(&nodes, &links);
    Report {
        mesh: MeshReport::new(mesh),
        profile: options.profile.name.to_string(),
        virtual_ns: run.now,
        messages: MessageReport::of(&totals.counts),
        timeline: take(&mut run.record.timeline).finish(
            run.now,
            mesh.nodes(),
            faults.crashes.iter().map(|crash| crash.at_ns),
        ),
        latencies: run.record.watch.waits().latencies(),
        faults,
        tiles: run.host.actor.ledger.counts().into(),
        totals,
        trace: take(&mut run.record.trace),
        flows: run.record.watch.take_flows(),
        events: run.events,
        fingerprint,
        nodes,
        links,
    }
}
