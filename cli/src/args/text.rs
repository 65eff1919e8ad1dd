//! What the help says beyond a line for each option.

pub(super) const ABOUT: &str = "\
Ray tracing in kilobytes: a scene is compiled to small blocks, and rendered by nodes that each have
as little memory as you say. The picture does not depend on the memory, the mesh or the machine.";

pub(super) const EXAMPLES: &str = "\
Examples:
  kiloray                                          render a built-in scene on a simulated mesh
  kiloray scenes                                   list the built-in scenes
  kiloray render glass -o glass.png                render one of them
  kiloray render room.rad lamps.rad --view room.vf -o room.exr
  kiloray render sinc:1000 --memory 64KiB          two million triangles in 64 KiB
  kiloray sim glass --nodes 64 --topology torus:8x8 --memory 64KiB --report page
  kiloray sweep glass --over nodes=1..256 -o speed-up
  kiloray host glass --nodes 8                     the same on real processes
  kiloray board glass --qemu 4                     four Cortex-M boards, emulated
  kiloray compare reference.exr room.exr -o difference.png

Exit codes: 0 done, 1 failed, 2 the command line makes no sense.
'kiloray COMMAND --help' tells more about a command. Of an option given twice the last one counts.";

pub(super) const RENDER: &str = "\
Examples:
  kiloray render cornell                           cornell.png, with the defaults
  kiloray render colour-cube:40 --width 800 --samples 64 -o cube.png
  kiloray render scene.obj lights.rad view.vf -o scene.exr
  kiloray render big.kilo --memory 256KiB --json run.json
  kiloray render cornell --pixel-spacing 4         a look at it, in less than half of the time
  kiloray render cornell --exposure 1.5            a PNG brighter by one and a half stops

With --pixel-spacing, as with rpict's -ps and -pt, there are fewer camera paths than pixels. What is
traced is as in the whole picture, and less --pixel-contrast traces more. Noise looks like contrast:
with few shadow samples little can be left out.

A PNG is for the eye: radiance is multiplied by 2^STOPS, the brightest parts are compressed by
Reinhard's curve, and the result is encoded as sRGB. 'auto' brings the logarithmic mean of the
luminance to middle grey, and prints the stops it chose. .hdr (RGBE) and .exr (32-bit float) hold
radiance as it is.

The image_hash of --json is the BLAKE3 hash of all linear pixels: rows from the top, red, green and
blue as 32-bit little-endian floats.";

pub(super) const SIM: &str = "\
Examples:
  kiloray sim cornell                              64 nodes of 256 KiB on a torus
  kiloray sim glass --topology mesh:8x8 --memory 64KiB --report page
  kiloray sim sinc:1000 --nodes 256 --topology hypercube --schedule data
  kiloray sim cornell --profile t800 --link-bandwidth 20Mbit/s --link-latency 5us
  kiloray sim cornell --loss 1/1000 --crash 5@2ms --block-replicas 2 --trace run.json

Every node is the real one: it has --memory for all that it holds, and knows no more than what its
links bring. Time is virtual: a profile says how long an operation takes, so the same command gives
the same times on any machine. The pixels are those of 'kiloray render', to the bit, whatever the
mesh, the memory, the schedule and the faults; where all copies of a block die with their nodes the
run ends with an error, and what was rendered is marked as incomplete.

efficiency = T1 / (nodes x TN), with T1 the virtual time of one node of the same profile that has
the whole scene in its memory. The page of --report shows what the rest was lost to.";

pub(super) const CALIBRATE: &str = "\
Examples:
  kiloray calibrate -o mine.json                   a minute or two; best when the machine is quiet
  kiloray sim glass --nodes 2 --profile mine.json  how long 'kiloray host' would take here

It renders pictures of built-in scenes on each of --threads threads, and finds how long an operation
of a node takes (a box test, a shading, ..) such that what a simulated node counts for the same
pictures adds up to the times measured. It prints both, also for pictures that it did not use.";

pub(super) const BOARD: &str = "\
Examples:
  kiloray board glass                              a ring of four Cortex-M4F boards
  kiloray board cornell --qemu 1 --width 64
  kiloray board glass --machine mps2-an386,mps2-an385 --width 32 --samples 4
  kiloray board glass --machine lm3s6965evb --topology line --json run.json
  kiloray board glass --qemu 2 --processes 2       a ring of two boards and two processes
  kiloray board glass --serial /dev/ttyACM0 --boards 2 --topology line    two real ones

Each board runs the firmware of 'node-board' with a quarter of the scene (of four boards) in its
flash, and serial lines to its neighbours; this machine is at the lines of one or two of them, gives
the tiles and takes the pixels, which are those of 'kiloray render', to the bit. A line carries some
10 kB a second under QEMU. It takes qemu-system-arm, and a Rust compiler with the boards' targets:
'rustup target add thumbv7em-none-eabihf thumbv7m-none-eabi', or 'bash node-board/toolchain'.";

pub(super) const BOARD_WIDTH: &str = "\
Width of the picture in pixels [default: 64, or by the height and the view]";

pub(super) const BOARD_MEMORY: &str = "\
Memory of each process of --processes; that of a board is as its firmware says [default: 64KiB]";

pub(super) const BOARD_BLOCK: &str = "\
Size of a block: 1KiB to 64KiB, a power of two [default: 1KiB]";

pub(super) fn lights() -> String {
    format!(
        "Lights that a scene may have: a face that emits is one, each costs every node {} bytes and \
         every shaded point time",
        size_of::<kiloray_core::scene::Light>()
    )
}

pub(super) const NODE_BLOCK: &str = "\
Size of a block: 1KiB to 64KiB, a power of two [default: by the memory of a node: 1KiB up to \
512KiB, 2KiB up to 2MiB, 4KiB up to 8MiB, 8KiB up to 32MiB, else 16KiB]";

pub(super) const NODE_MEMORY: &str = "\
Memory of each node for all that it holds, as in 64KiB; the blocks it owns are read-only and apart \
[default: 256KiB]";

pub(super) const SIM_THREADS: &str = "\
Threads to use, one of them for the one node that efficiency is measured against; with 1 that \
runs after the mesh [default: all cores]";

#[cfg(feature = "host")]
pub(super) const HOST: &str = "\
Examples:
  kiloray host cornell                             a process for each processor of this machine
  kiloray host glass --nodes 8 --memory 64KiB -o glass.exr
  kiloray host room.kilo --nodes 16 --topology torus:4x4 --block-replicas 2 --json run.json

Each process is a real node: it has --memory for all that it holds, maps the compiled scene, and
reads the blocks of its share; all else comes over its links, which are sockets that only you can
open. The pixels are those of 'kiloray render', to the bit. A process that dies or freezes is
replaced, and costs time alone; all end with this command. Ctrl-C keeps what is rendered.

The --json fields are those of 'kiloray sim', with times of the clock in place of virtual ones; it
has no bounds_s, events, fingerprint, profile_source, virtual_time_one_node_s, memory.beside,
links.control_packets, links.busiest and links.worst_cut, and other parts of lost and faults;
virtual_time_s and efficiency are null. docs/json.md tells what each field means.";

#[cfg(feature = "host")]
pub(super) const HOST_NODES: &str = "How many nodes, 256 at most on this machine [default: as the sizes of the topology say, else one for each processor]";

#[cfg(feature = "host")]
pub(super) const HOST_TOPOLOGY: &str = "\
Who is next to whom: line, ring, mesh, torus (mesh:8x4, torus:4x4x4), hypercube, tree, tree:ARITY, full \
[default: full up to 16 nodes, then torus]";

#[cfg(feature = "host")]
pub(super) const NODE: &str = "\
Examples:
  kiloray node --config mesh.toml --node 3

It listens at its address in the configuration, connects to its neighbours, works for the host
when there is one ('kiloray host --config'), reports to it, and ends.";

pub(super) const SWEEP_THREADS: &str = "Points that are simulated at once [default: all cores]";

pub(super) const SWEEP_JSON: &str = "Write all points as JSON ('-' for the standard output)";

pub(super) const SWEEP: &str = "\
Examples:
  kiloray sweep glass -o glass                     nodes, memory, prefetch, links: each by itself
  kiloray sweep glass --over nodes=1..256 -o speed-up
  kiloray sweep glass --over nodes=1..64 --over schedule=hybrid,demand,data -o schedules
  kiloray sweep sinc:500 --over memory=64KiB..1MiB --over prefetch=0,4,all -o caches
  kiloray sweep cornell --over link-bandwidth=1MB/s..1GB/s --samples 4 --width 128

Any option of 'kiloray sim' that changes a run can be an axis, by its name; what is not varied is
given as for 'sim'. Lists and ranges mix: nodes=1..16,24,32. A range doubles. All combinations are
simulated, on all cores, or with --each one option at a time, with a row of plots for each; the
order of the table is that of the axes, whatever was done first. The first axis with numbers is
across in the plots, the others make a line each. A point that fails has its error in the table and
does not stop the others.";

pub(super) const COMPILE: &str = "\
Examples:
  kiloray compile room.rad lamps.rad -o room.kilo
  kiloray compile sphereflake:5 --block 4KiB -o flake.kilo
  kiloray compile cornell                          only look at what it needs";

pub(super) const PLAN: &str = "\
Examples:
  kiloray plan cornell --memory 64KiB
  kiloray plan room.kilo --memory 512KiB
  kiloray plan colour-cube --memory 64KiB --nodes 64 --topology torus:8x8

With any option of a mesh it is the plan that 'kiloray sim' makes of the same options, the link
buffers included; what does not touch memory is taken and left alone.

Exit code 1 says that the memory is too small; the line that does not fit is named, with what is
needed.";

pub(super) const COMPARE: &str = "\
Examples:
  kiloray compare reference.exr image.exr
  kiloray compare reference.hdr image.hdr -o difference.png --mask floor.png

Measures, over all pixels and over smooth ones (away from edges and from what is ten times brighter
than the mean): the mean of the image over the mean of the reference, RMSE, RMSE over the
reference's mean, and percentiles of the relative error, |image - reference| over the reference but
at least 1 % of its mean. The picture shows the worst relative error of each pixel on a logarithmic
scale from 0.1 % (black) to 100 % (pale yellow).";

pub(super) const COMPLETIONS: &str = "\
Examples:
  kiloray completions bash > ~/.local/share/bash-completion/completions/kiloray
  kiloray completions zsh > ~/.zfunc/_kiloray
  kiloray completions fish > ~/.config/fish/completions/kiloray.fish";
