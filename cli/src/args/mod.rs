//! What can be typed.

mod axis;
mod choice;
mod division;
pub(crate) mod firmware;
mod mesh;
mod options;
mod parse;
pub(crate) mod size;
mod text;
mod units;

use std::path::PathBuf;

pub(crate) use axis::{Axis, axes, point, scale};
use choice::choice;
use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};
pub(crate) use division::Division;
use kiloray_core::node::Dealing;
#[cfg(feature = "host")]
pub(crate) use mesh::Top;
pub(crate) use mesh::{Mesh, Profile, Switching};
pub(crate) use options::{BLOCK_MIN, Bounds, Common, Exposure, Undersampling, ViewChoice};
pub(crate) use parse::{command, parse};
use serde::Serialize;
pub(crate) use units::Part;
use units::parse_part;

/// Lights that a scene may have where nothing is said: as much as 11 MiB of tables.
const LIGHTS_MAX: u32 = 1 << 16;

/// Memory of a node of a mesh, and of one that is alone and planned, where nothing is said.
pub(crate) const MESH_MEMORY: u64 = 256 << 10;
const PLAN_MEMORY: u64 = 64 << 10;

/// Ray tracing in kilobytes.
#[derive(Debug, Parser)]
#[command(
    name = "kiloray",
    version,
    about = text::ABOUT,
    after_help = text::EXAMPLES,
    args_override_self = true,
    disable_help_subcommand = true,
    max_term_width = 100
)]
pub(crate) struct Arguments {
    /// What to do; without it a built-in scene is rendered.
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene on this machine, in all its memory or in as little as you say
    #[command(after_help = text::RENDER, args_override_self = true)]
    Render(Box<Render>),
    /// Render a scene on a simulated mesh of nodes, and show what it costs
    #[command(
        after_help = text::SIM,
        args_override_self = true,
        mut_arg("block", |arg| arg.help(text::NODE_BLOCK)),
        mut_arg("memory", |arg| arg.help(text::NODE_MEMORY)),
        mut_arg("threads", |arg| arg.help(text::SIM_THREADS))
    )]
    Sim(Box<Sim>),
    /// Render a scene on a mesh of processes, one for each node, on this machine
    #[cfg(feature = "host")]
    #[command(
        after_help = text::HOST,
        args_override_self = true,
        mut_arg("scenes", |arg| arg.required(false).required_unless_present("config")),
        mut_arg("block", |arg| arg.help(text::NODE_BLOCK)),
        mut_arg("memory", |arg| arg.help(text::NODE_MEMORY)),
        mut_arg("nodes", |arg| arg.help(text::HOST_NODES)),
        mut_arg("topology", |arg| arg.help(text::HOST_TOPOLOGY)),
        mut_arg("threads", |arg| arg.hide(true)),
        mut_arg("config", |arg| arg.conflicts_with_all(said_by_config()))
    )]
    Host(Box<Host>),
    /// Be one node of a mesh of processes
    #[cfg(feature = "host")]
    #[command(after_help = text::NODE, args_override_self = true)]
    Node(Node),
    /// Simulate every combination of some options: a table, plots and a page
    #[command(
        after_help = text::SWEEP,
        args_override_self = true,
        mut_arg("block", |arg| arg.help(text::NODE_BLOCK)),
        mut_arg("memory", |arg| arg.help(text::NODE_MEMORY)),
        mut_arg("threads", |arg| arg.help(text::SWEEP_THREADS)),
        mut_arg("json", |arg| arg.help(text::SWEEP_JSON)),
        mut_arg("report", |arg| arg.hide(true))
    )]
    Sweep(Box<Sweep>),
    /// Render a scene on a ring of small boards, linked by serial lines: emulated by QEMU, or real; this machine is their host
    #[command(
        after_help = text::BOARD,
        args_override_self = true,
        mut_arg("width", |arg| arg.help(text::BOARD_WIDTH)),
        mut_arg("block", |arg| arg.help(text::BOARD_BLOCK)),
        mut_arg("memory", |arg| arg.help(text::BOARD_MEMORY)),
        mut_arg("threads", |arg| arg.hide(true)),
        mut_arg("report", |arg| arg.hide(true))
    )]
    Board(Box<Board>),
    /// Be a node whose lines come over the standard input
    #[command(hide = true)]
    LineNode(LineNode),
    /// Compile a scene to a .kilo file of blocks, and print what it needs
    #[command(after_help = text::COMPILE, args_override_self = true)]
    Compile(Compile),
    /// Print what a memory is spent on, line by line
    #[command(after_help = text::PLAN, args_override_self = true)]
    Plan(Box<Plan>),
    /// Measure how fast this machine is, for 'kiloray sim --profile'
    #[command(after_help = text::CALIBRATE, args_override_self = true)]
    Calibrate(Calibrate),
    /// Measure how far a picture is from a reference
    #[command(after_help = text::COMPARE, args_override_self = true)]
    Compare(Compare),
    /// List the built-in scenes
    #[command(args_override_self = true)]
    Scenes(Scenes),
    /// Print a script that completes this command in a shell
    #[command(after_help = text::COMPLETIONS)]
    Completions(Completions),
}

/// `kiloray render`.
#[derive(Debug, Args)]
pub(crate) struct Render {
    #[command(flatten)]
    pub(crate) scene: Scene,
    /// The picture: .png (for the eye), .hdr or .exr (linear radiance); default: the scene's name and .png
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) undersampling: Undersampling,
    #[command(flatten)]
    pub(crate) common: Common,
}

/// `kiloray sim`.
#[derive(Debug, Clone, Args)]
pub(crate) struct Sim {
    #[command(flatten)]
    pub(crate) scene: Scene,
    /// The picture: .png (for the eye), .hdr or .exr (linear radiance); default: the scene's name and .png
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) mesh: Mesh,
    #[command(flatten)]
    pub(crate) common: Common,
    /// Write what each node did, and when, for Perfetto (ui.perfetto.dev): a slice for each step, called by what took most of it
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Report")]
    pub(crate) trace: Option<PathBuf>,
    /// Leave out the one-node run that efficiency is measured against
    #[arg(long, help_heading = "Report")]
    pub(crate) no_baseline: bool,
}

/// `kiloray host`.
#[cfg(feature = "host")]
#[derive(Debug, Args)]
pub(crate) struct Host {
    #[command(flatten)]
    pub(crate) scene: Scene,
    /// The picture: .png (for the eye), .hdr or .exr (linear radiance); default: the scene's name and .png
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) division: Division,
    #[command(flatten)]
    pub(crate) common: Common,
    /// Have the system end a node that holds more than its memory and a constant for program and network
    #[arg(long, help_heading = "Mesh")]
    pub(crate) enforce: bool,
    /// Drive the nodes of this configuration, which 'kiloray node' starts, on any machines; it says all but where the picture goes
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Cluster")]
    pub(crate) config: Option<PathBuf>,
    /// Write such a configuration, with this machine's addresses, and render nothing
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Cluster", conflicts_with_all = ["config", "output", "json", "report", "exposure"])]
    pub(crate) write_config: Option<PathBuf>,
    /// Let anybody who reaches the addresses see and change the picture: no TLS beyond this machine
    #[arg(long, help_heading = "Cluster", requires = "config")]
    pub(crate) insecure: bool,
}

/// What can be typed beside a configuration, which says all else.
#[cfg(feature = "host")]
const BESIDE_CONFIG: [&str; 10] = [
    "output",
    "lights",
    "exposure",
    "threads",
    "json",
    "report",
    "quiet",
    "config",
    "write_config",
    "insecure",
];

/// What a configuration says, and cannot be typed beside it.
#[cfg(feature = "host")]
fn said_by_config() -> Vec<clap::Id> {
    let host = Host::augment_args(clap::Command::new("host"));
    let all = host.get_arguments().map(clap::Arg::get_id);
    all.filter(|id| !BESIDE_CONFIG.contains(&id.as_str())).cloned().collect()
}

/// `kiloray node`.
#[cfg(feature = "host")]
#[derive(Debug, Args)]
pub(crate) struct Node {
    /// The configuration of the mesh, the same for all its nodes
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) config: PathBuf,
    /// Which of its nodes
    #[arg(long, value_name = "N", value_parser = mesh::node, allow_hyphen_values = true)]
    pub(crate) node: u16,
    /// Which of the processes that are there one after the other [default: by chance]
    #[arg(long, value_name = "N", hide = true)]
    pub(crate) incarnation: Option<u32>,
    /// Where to listen, if not at its address in the configuration: quic/0.0.0.0:7447 in a container
    #[arg(long, value_name = "ADDRESS")]
    pub(crate) listen: Option<String>,
    /// Let anybody who reaches the addresses see and change the picture: no TLS beyond this machine
    #[arg(long)]
    pub(crate) insecure: bool,
    /// End with the process at the other end of the standard input.
    #[arg(long, hide = true)]
    pub(crate) tied: bool,
}

/// `kiloray sweep`.
#[derive(Debug, Args)]
pub(crate) struct Sweep {
    #[command(flatten)]
    pub(crate) scene: Scene,
    /// An option to vary, and its values: memory=64KiB,128KiB or, doubling, nodes=1..256 (repeatable: all combinations) [default: nodes, memory, prefetch and link-bandwidth, each by itself]
    #[arg(long, value_name = "OPTION=VALUES")]
    pub(crate) over: Vec<Axis>,
    /// Vary one option at a time, with the others as they are given for all: plots for each, not all combinations
    #[arg(long)]
    pub(crate) each: bool,
    /// The directory of sweep.csv, the plots and index.html
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath, default_value = "sweep")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) mesh: Mesh,
    #[command(flatten)]
    pub(crate) common: Common,
    /// Leave out the one-node runs that efficiency is measured against
    #[arg(long, help_heading = "Report")]
    pub(crate) no_baseline: bool,
    /// The words that each point has.
    #[arg(skip)]
    pub(crate) typed: Vec<std::ffi::OsString>,
}

/// What is said of emulated boards, and not of real ones.
const EMULATED: [&str; 5] = ["qemu", "processes", "machine", "noise", "firmware"];

/// Boards where nothing is said.
pub(crate) const BOARDS: u32 = 4;

/// `kiloray board`.
#[derive(Debug, Args)]
pub(crate) struct Board {
    #[command(flatten)]
    pub(crate) scene: Scene,
    /// The picture: .png (for the eye), .hdr or .exr (linear radiance); default: the scene's name and .png
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: Option<PathBuf>,
    /// Boards that QEMU emulates
    #[arg(long, value_name = "N", default_value_t = BOARDS, value_parser = mesh::emulators, allow_hyphen_values = true, help_heading = "Boards")]
    pub(crate) qemu: u32,
    /// Nodes that are processes of this machine, behind the boards: the same actor, and lines as the boards have them
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = mesh::processes, allow_hyphen_values = true, help_heading = "Boards")]
    pub(crate) processes: u32,
    /// What each board is; of a list, in turn
    #[arg(
        long,
        value_name = "M",
        value_enum,
        value_delimiter = ',',
        default_value = "mps2-an386",
        help_heading = "Boards"
    )]
    pub(crate) machine: Vec<Machine>,
    /// Real boards in place of emulated ones: the serial ports of this machine that lead to them, in the order of the host's links
    #[arg(long, value_name = "PORT", value_delimiter = ',', value_hint = ValueHint::FilePath, conflicts_with_all = EMULATED, help_heading = "Boards")]
    pub(crate) serial: Vec<PathBuf>,
    /// How many real boards there are
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = mesh::nodes, requires = "serial", conflicts_with_all = EMULATED, allow_hyphen_values = true, help_heading = "Boards")]
    pub(crate) boards: u32,
    /// Bits a second of their lines
    #[arg(long, value_name = "BAUD", default_value_t = 115_200, value_parser = mesh::baud, requires = "serial", conflicts_with_all = EMULATED, allow_hyphen_values = true, help_heading = "Boards")]
    pub(crate) baud: u32,
    /// How they are linked: ring, line, or what else leaves each three links at most, the host's included
    #[arg(long, value_name = "T", default_value = "ring", help_heading = "Boards")]
    pub(crate) topology: String,
    /// Copies of each block in all; where routes go round it, the picture survives the death of K - 1 boards
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = mesh::replicas, allow_hyphen_values = true, help_heading = "Boards")]
    pub(crate) block_replicas: u32,
    /// Bytes of every line that are damaged or lost on their way: 1/1000, 0.001 or 0.1%
    #[arg(long, value_name = "PART", value_parser = parse_part, allow_hyphen_values = true, help_heading = "Boards")]
    pub(crate) noise: Option<Part>,
    /// The firmware, built before, for boards of one kind [default: it is built]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Boards")]
    pub(crate) firmware: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) common: Common,
}

/// `kiloray line-node`: what `kiloray board` starts for each of its processes.
#[derive(Debug, Args)]
pub(crate) struct LineNode {
    /// The node's share of the scene.
    #[arg(long)]
    pub(crate) share: PathBuf,
    /// Memory of the node \[bytes\].
    #[arg(long)]
    pub(crate) memory: usize,
}

/// A board, by QEMU's name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum, Serialize)]
pub(crate) enum Machine {
    /// Arm MPS2 with a Cortex-M4F
    #[value(name = "mps2-an386")]
    #[serde(rename = "mps2-an386")]
    Mps2An386,
    /// Arm MPS2 with a Cortex-M3, without floating-point unit
    #[value(name = "mps2-an385")]
    #[serde(rename = "mps2-an385")]
    Mps2An385,
    /// Texas Instruments LM3S6965: Cortex-M3, 64 KiB of RAM
    #[value(name = "lm3s6965evb")]
    #[serde(rename = "lm3s6965evb")]
    Lm3s6965evb,
}

/// What to read.
#[derive(Debug, Clone, Args)]
pub(crate) struct Scene {
    /// A built-in scene (see 'kiloray scenes') or files: .rad, .obj, .vf, .kilo; several make one scene
    #[arg(required = true, value_name = "SCENE", value_hint = ValueHint::FilePath)]
    pub(crate) scenes: Vec<PathBuf>,
    #[arg(long, value_name = "N", value_parser = options::lights, default_value_t = LIGHTS_MAX, allow_hyphen_values = true, help = text::lights())]
    pub(crate) lights: u32,
}

/// `kiloray compile`.
#[derive(Debug, Args)]
pub(crate) struct Compile {
    #[command(flatten)]
    pub(crate) scene: Scene,
    /// The file of blocks; without it the figures are printed and nothing is written
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: Option<PathBuf>,
    /// Size of a block: 1KiB to 64KiB, a power of two [default: 16KiB; with --nodes 1KiB, which suits the default memory of 'kiloray sim']
    #[arg(long, value_name = "SIZE", value_parser = options::block)]
    pub(crate) block: Option<u32>,
    /// Print how the blocks are dealt out to the nodes of a mesh, as 'kiloray sim' deals them, with its default memory
    #[arg(long, value_name = "N", value_parser = mesh::nodes, allow_hyphen_values = true)]
    pub(crate) nodes: Option<u32>,
    /// Write what this node (from 0) needs of the scene: the tables and its blocks, for its read-only memory. Of 4 nodes and in blocks of 1 KiB where nothing is
    /// said, as for 'kiloray board'
    #[arg(long, value_name = "K", value_parser = mesh::node, allow_hyphen_values = true, requires = "output")]
    pub(crate) for_node: Option<u16>,
    /// Which node owns which blocks: subtrees of equal bytes, or each block in turn
    #[arg(long, value_name = "P", value_parser = choice::<Dealing>(), default_value = "subtrees", requires = "nodes")]
    pub(crate) placement: Dealing,
    /// Copies of each block in all
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = mesh::replicas, allow_hyphen_values = true, requires = "nodes")]
    pub(crate) block_replicas: u32,
    /// Read-only memory of a node, as in 1MiB: less of the tree's top lies with all where a node would own more blocks than it holds, or it is refused
    #[arg(long, value_name = "SIZE", value_parser = size::parse_bytes, allow_hyphen_values = true, requires = "nodes")]
    pub(crate) rom: Option<u64>,
    /// Write the figures as JSON ('-' for the standard output)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) json: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// `kiloray plan`.
#[derive(Debug, Args)]
pub(crate) struct Plan {
    #[command(flatten)]
    pub(crate) scene: Scene,
    /// Memory of the node, as in 64KiB [default: 64KiB, with any option of a mesh 256KiB, as 'kiloray sim' takes it]
    #[arg(long, value_name = "SIZE", value_parser = size::parse_bytes)]
    pub(crate) memory: Option<u64>,
    /// All RAM of a board, as in 64KiB: the memory is what the firmware's statics and stack leave of it
    #[arg(long, value_name = "SIZE", value_parser = size::parse_bytes, conflicts_with = "memory")]
    pub(crate) ram: Option<u64>,
    /// Size of a block: 1KiB to 64KiB, a power of two [default: as 'kiloray render' takes it, with --nodes or --topology as 'kiloray sim' does]
    #[arg(long, value_name = "SIZE", value_parser = options::block)]
    pub(crate) block: Option<u32>,
    /// Most reflections and refractions on a path
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = options::bounces)]
    pub(crate) bounces: u32,
    /// Write the plan as JSON ('-' for the standard output)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) json: Option<PathBuf>,
    /// Width of the picture: with the nodes it decides about tiles [default: 512, or by the height and the view]
    #[arg(long, value_name = "PIXELS", value_parser = options::side, allow_hyphen_values = true, help_heading = "Mesh")]
    pub(crate) width: Option<u32>,
    /// Height of the picture [default: by the width and the view]
    #[arg(long, value_name = "PIXELS", value_parser = options::side, allow_hyphen_values = true, help_heading = "Mesh")]
    pub(crate) height: Option<u32>,
    #[command(flatten)]
    pub(crate) mesh: Mesh,
    /// Something is said of a mesh.
    #[arg(skip)]
    pub(crate) is_mesh: bool,
}

impl Plan {
    /// Memory of a node: what was said, or what the RAM leaves.
    pub(crate) fn memory(&self) -> u64 {
        let left = |ram: u64| ram.saturating_sub(firmware::STATICS + firmware::STACK);
        let default = if self.is_mesh { MESH_MEMORY } else { PLAN_MEMORY };
        self.ram.map(left).or(self.memory).unwrap_or(default)
    }
}

/// `kiloray calibrate`.
#[derive(Debug, Args)]
pub(crate) struct Calibrate {
    /// The profile: a file for --profile, called as the profile is
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath, default_value = "machine.json")]
    pub(crate) output: PathBuf,
    /// Nodes that this machine is to run at the same time: each may be slower beside others [default: as many as it has cores]
    #[arg(long, value_name = "N", value_parser = options::threads, allow_hyphen_values = true)]
    pub(crate) threads: Option<u32>,
    /// How often each picture is rendered; the quickest counts
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000), allow_hyphen_values = true)]
    pub(crate) repeats: u32,
    /// Render a sixteenth of each picture: in seconds, for a first look; the profile is less exact
    #[arg(long)]
    pub(crate) quick: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// `kiloray compare`.
#[derive(Debug, Args)]
pub(crate) struct Compare {
    /// The picture to measure against: .exr, .hdr, .pic or .png
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) reference: PathBuf,
    /// The picture to measure
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) image: PathBuf,
    /// A picture of the difference in false colours (.png)
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: Option<PathBuf>,
    /// Measure also where this picture is brighter than one half
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) mask: Option<PathBuf>,
    /// Contrast in a pixel's neighbourhood above which it is not smooth
    #[arg(long, value_name = "PART", default_value_t = 0.15, value_parser = options::part, allow_hyphen_values = true)]
    pub(crate) edge: f64,
    /// Exit with 1 if the relative RMSE of all pixels is above this part
    #[arg(long, value_name = "PART", value_parser = options::part, allow_hyphen_values = true)]
    pub(crate) fail_above: Option<f64>,
    /// Write the measures as JSON ('-' for the standard output)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) json: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// `kiloray scenes`.
#[derive(Debug, Args)]
pub(crate) struct Scenes {
    /// Print the list as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// `kiloray completions`.
#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// The shell
    pub(crate) shell: clap_complete::Shell,
}
