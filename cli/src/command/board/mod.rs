//! `kiloray board`: a picture from a ring of boards, emulated ones with processes among them, or real ones at serial ports, with this machine as their host.

mod emulator;
mod firmware;
mod host;
mod inquiry;
mod json;
mod lines;
mod link;
mod nodes;
mod process;
mod serial;
mod told;

use std::{
    collections::BTreeMap,
    os::fd::OwnedFd,
    path::{Path, PathBuf},
    sync::atomic::Ordering,
    time::Instant,
};

use kiloray_core::{
    network::{HOST, Mesh, NodeId, Topology},
    node::{Dealing, Placement, PointHome, Schedule, Setup, ShadowPolicy, Time},
    shade::{self, Shader, Tables},
    view::Camera,
};
use kiloray_mesh::Ledger;
use kiloray_render::Options;
use kiloray_scene::kilo;

pub(super) use self::process::line_node;
use self::{
    firmware::{Board, LINKS},
    host::{Done, End, Heard, host},
    lines::Lines,
    nodes::{Kind, Nodes, Parts},
    told::Told,
};
use super::{division, engine, mesh::Why};
use crate::{
    args,
    console::{bytes, count, counted, line},
    failure::{Failure, Outcome},
    interrupt,
    output::Output,
    picture::{self, Format, Saved},
    progress::Progress,
    scene::{self, Scene},
};

/// Size of a block where nothing is said: small, as lines are slow.
pub(super) const BLOCK: u32 = 1 << 10;
/// Longer side of the picture where nothing is said.
const SIDE: u32 = 64;
/// Greatest payload of a packet: the least, as a line carries one packet after the other.
const PAYLOAD: u16 = 256;
/// Memory of a process, where nothing is said.
const MEMORY: u64 = 64 << 10;
/// Sides of a tile, and so many tiles for each board.
const SIDES: [u16; 2] = [8, 4];
const TILES_PER_NODE: u32 = 4;

/// A run that has ended.
struct Run<'a> {
    board: &'a args::Board,
    scene: &'a Scene,
    options: &'a Options,
    nodes: u16,
    /// Those that died on the way.
    dead: Vec<NodeId>,
    /// What each has said.
    said: Vec<Vec<String>>,
    /// Blocks of the board that has the most.
    owned: u32,
    done: &'a Done,
    picture: &'a picture::Picture,
    saved: Saved,
    time_s: f64,
    render_s: f64,
}

/// Starts, renders and writes.
pub(super) fn run(board: &args::Board) -> Outcome {
    let common = &board.common;
    let quiet = common.quiet;
    let start = Instant::now();
    if let Some(path) = &board.output {
        Format::of(path)?;
    }
    refuse_foreign(board)?;
    let mesh = mesh(board)?;
    let replicas = division::replicas(board.block_replicas, mesh.nodes())?;
    board.firmware.as_deref().map_or(Ok(()), firmware::check)?;
    if board.serial.is_empty() {
        emulator::is_there()?;
    }
    let scene =
        scene::load(&board.scene, common.block, BLOCK, quiet)?.with_view(common.view.as_ref());
    let options = options(board, &scene)?;
    let path = board.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.png", scene.name)));
    let cancel = interrupt::gentle();
    // Whether all can be written shows before the work.
    let output = Output::create(&path)?;
    let json_out = common.json.as_deref().map(Output::create).transpose()?;
    scene.print_notes(quiet);

    let (placement, setup) = (placement(replicas, &scene, &mesh), setup(&scene, &options, &mesh)?);
    let parts =
        if board.serial.is_empty() { parts(board, &scene, &placement)? } else { Vec::new() };
    let ledger = ledger(&scene, &options, &setup, &mesh)?;
    let folder = tempfile::tempdir().map_err(|error| Failure::io(Path::new("/tmp"), &error))?;
    let all = ledger.pixels();
    let render_start = Instant::now();
    let (mut nodes, lines) = if board.serial.is_empty() {
        let mut lines = Lines::new(&mesh, board.noise.map_or(0.0, f64::from))
            .map_err(|error| Failure::new(format_args!("sockets: {error}")))?;
        let nodes = Nodes::start(&mesh, placement.replicas, &parts, &mut lines, folder.path())?;
        (Some(nodes), lines.take(HOST).into_iter().map(OwnedFd::from).collect())
    } else {
        (None, serial::open_all(&board.serial, board.baud, &mesh)?)
    };
    let bar = Progress::new("boards", all, quiet);
    let mut look = |pixels, heard: Heard| {
        bar.set(pixels);
        bar.message(match heard.frames {
            0 => "waiting for the boards".to_owned(),
            _ => format!("{} of {} pixels", count(pixels), count(all)),
        });
        match &mut nodes {
            Some(nodes) => nodes.look(heard.frames > 0)?,
            None => serial::look(&board.serial, board.baud, &heard, render_start.elapsed())?,
        }
        Ok(!cancel.load(Ordering::Relaxed))
    };
    let done = host(mesh, &setup, ledger, lines, &mut look)?;
    drop(bar);
    let (dead, said) =
        nodes.as_ref().map_or_else(Default::default, |nodes| (nodes.dead().to_vec(), nodes.said()));
    drop(nodes);

    let output = if done.end == End::Complete { output } else { output.incomplete() };
    let path = output.path().to_owned();
    let rendered = done.ledger.picture();
    let saved = picture::save(&rendered, Format::of(&path)?, common.exposure, output)?;
    let run = Run {
        board,
        scene: &scene,
        options: &options,
        nodes: mesh.nodes(),
        dead,
        said,
        owned: placement.most_blocks(),
        done: &done,
        picture: &rendered,
        saved,
        time_s: start.elapsed().as_secs_f64(),
        render_s: render_start.elapsed().as_secs_f64(),
    };
    if let Some(output) = json_out {
        output.write(format!("{:#}\n", run.as_json()).as_bytes())?;
    }
    let to_standard =
        [Some(path.as_path()), common.json.as_deref()].contains(&Some(Path::new("-")));
    if !quiet && !to_standard {
        run.print(&path)?;
    }
    match done.end {
        End::Complete => Ok(()),
        End::Lost(block) => Err(Failure::new(format_args!(
            "{}; what was rendered is in {}",
            Why::NoneAnswers.lost(block),
            path.display()
        ))),
        End::Stopped => Err(Failure::new(format_args!(
            "interrupted; what was rendered is in {}",
            path.display()
        ))),
    }
}

/// What a board decides for itself.
fn refuse_foreign(board: &args::Board) -> Outcome {
    let common = &board.common;
    let is_alone = board.processes == 0;
    let given = [
        (
            common.memory.is_some() && is_alone,
            "--memory: a board has the memory that its firmware says",
        ),
        (common.threads.is_some(), "--threads: a board is one thread"),
        (common.report.is_some(), "--report: there is no page of boards; --json has all figures"),
    ];
    match given.into_iter().find(|(given, _)| *given) {
        Some((_, message)) => Err(Failure::usage(message)),
        None => Ok(()),
    }
}

fn mesh(board: &args::Board) -> Outcome<Mesh> {
    let nodes = match board.serial.is_empty() {
        true => board.qemu.saturating_add(board.processes),
        false => board.boards,
    };
    let name = &board.topology;
    let topology = Topology::parse(name, nodes).map_err(|error| {
        Failure::usage(format_args!("--topology {name} for {nodes} boards: {error}"))
    })?;
    let mesh = Mesh::new(topology);
    let most = (0..mesh.nodes()).map(|node| mesh.joined(NodeId(node)).count()).max().unwrap_or(0);
    if most > LINKS {
        return Err(Failure::usage(format_args!(
            "--topology {name} for {nodes} boards: one needs {most} links, and has {LINKS}"
        )));
    }
    Ok(mesh)
}

fn options(board: &args::Board, scene: &Scene) -> Outcome<Options> {
    let mut common = board.common.clone();
    if common.width.is_none() && common.height.is_none() {
        common.width = Some(SIDE);
    }
    engine::options(&common, scene.choose_view(common.view.as_ref())?)
}

/// As `kiloray compile` deals the blocks out.
fn placement(replicas: u16, scene: &Scene, mesh: &Mesh) -> Placement {
    let blocks = scene.file.view().blocks();
    Placement {
        dealing: Dealing::Subtrees,
        blocks,
        nodes: mesh.nodes(),
        top: blocks.min(1),
        replicas,
    }
}

/// What all boards are told.
fn setup(scene: &Scene, options: &Options, mesh: &Mesh) -> Outcome<Setup> {
    let shade::Settings { samples, shadow_samples, lights, bounces, seed } = options.settings;
    let pixels = u64::from(options.width) * u64::from(options.height);
    let enough = |side: &u16| {
        let area = u64::from(*side) * u64::from(*side);
        pixels >= area * u64::from(TILES_PER_NODE) * u64::from(mesh.nodes())
    };
    let camera = Camera::new(&options.view, options.width, options.height, samples);
    let setup = Setup {
        version: Setup::VERSION,
        scene: scene.file.view().header().crc,
        sizes: [0; 15],
        topology: 0,
        policy: Setup::code(Schedule::Hybrid, ShadowPolicy::Keep, PointHome::Finder),
        seed,
        // A block takes some tenths of a second over each of the lines. Nodes wait longer where they see that it takes longer.
        patience: Time(2_000_000_000),
        bundle_age: Time(10_000_000),
        reminder: Time(500_000_000),
        width: options.width,
        height: options.height,
        samples,
        shadow_samples,
        lights,
        side: SIDES.into_iter().find(enough).unwrap_or(SIDES[SIDES.len() - 1]),
        payload: PAYLOAD,
        depth: 1,
        group: 0,
        prefetch: 0,
        bounces,
        refusals: 0,
        camera: camera.ok_or_else(|| Failure::new("the view shows nothing"))?,
    };
    Ok(setup.with_topology(mesh.topology()))
}

/// What the nodes are: boards first, then processes.
fn parts(board: &args::Board, scene: &Scene, placement: &Placement) -> Outcome<Vec<Parts>> {
    let mut built = BTreeMap::new();
    let machines = board.machine.iter().copied().cycle();
    let nodes = (0..placement.nodes).map(NodeId);
    nodes
        .zip(machines)
        .map(|(node, machine)| {
            let of = Board::of(machine);
            let share = kilo::share(&scene.file, placement, node);
            if u32::from(node.0) >= board.qemu {
                let memory = board.common.memory.unwrap_or(MEMORY) as usize;
                return Ok(Parts { kind: Kind::Process(memory), share });
            }
            if share.len() as u64 > of.share_bytes {
                return Err(Failure::new(format_args!(
                    "board {} needs {} bytes of the scene, and {} has room for {}; take more boards",
                    node.0,
                    count(share.len() as u64),
                    of.name,
                    count(of.share_bytes)
                )));
            }
            let firmware = match (&board.firmware, built.get(&machine)) {
                (Some(given), _) => given.clone(),
                (None, Some(firmware)) => PathBuf::clone(firmware),
                (None, None) => of.build(board.common.quiet)?,
            };
            built.insert(machine, firmware.clone());
            Ok(Parts { kind: Kind::Board(of, firmware), share })
        })
        .collect()
}

fn ledger(scene: &Scene, options: &Options, setup: &Setup, mesh: &Mesh) -> Outcome<Ledger> {
    let file = scene.file.view();
    let unit = Shader::new(Tables::of(&file), options.settings).unit();
    let (width, height, side) = (options.width, options.height, u32::from(setup.side));
    let ledger = Ledger::new(width, height, side, setup.seed, unit, setup.samples);
    ledger.map(|ledger| ledger.with_askers(u32::from(mesh.nodes()))).map_err(Failure::usage)
}

impl Run<'_> {
    fn print(&self, path: &Path) -> Outcome {
        line(format_args!(
            "{}: {} x {}, {} samples per pixel{}",
            path.display(),
            self.options.width,
            self.options.height,
            self.options.settings.samples,
            self.saved.said(),
        ))?;
        let processes = self.board.processes;
        let carried: u64 = self.done.links.iter().map(|l| l.sent_bytes + l.received_bytes).sum();
        line(format_args!(
            "{}{} in {:.1} s, {} of {} blocks with each at most; {} bytes over the host's lines, {} frames damaged",
            counted((u32::from(self.nodes) - processes).into(), ["board", "boards"]),
            match processes {
                0 => String::new(),
                n => format!(" and {}", counted(n.into(), ["process", "processes"])),
            },
            self.render_s,
            count(self.owned.into()),
            count(self.scene.file.view().blocks().into()),
            count(carried),
            self.done.links.iter().map(|l| u64::from(l.damaged)).sum::<u64>(),
        ))?;
        let told = Told::of(&self.done.ledger);
        if let Some((node, figures)) = told.fullest() {
            line(format_args!(
                "memory {} of {} at the fullest node, {node}; {} blocks fetched, {} rays migrated",
                bytes(figures.peak_bytes() as u64),
                bytes(figures.memory.into()),
                count(told.counts.cache.fetched),
                count(told.counts.migrated),
            ))?;
        }
        Ok(())
    }
}
