use kiloray_core::{
    network::{NodeId, Topology},
    node::NodePlan,
    store::Budget,
};
use kiloray_render::framing;
use kiloray_sim::{Error, MeshLayout, MeshOptions, Options};
use serde_json::json;

use super::{
    super::{division, frames, least, mesh, sim},
    budget_json, too_small,
};
use crate::{
    args::{self, Bounds},
    console::{bytes, count, line, lines},
    failure::{self, Failure, Outcome},
    output::Output,
    scene::{self, Scene},
};

/// Prints the budget of the node of a mesh that has the least room.
pub(super) fn run(arguments: &args::Plan) -> Outcome {
    let topology = arguments.mesh.division.topology().map_err(Failure::usage)?;
    let json_out = arguments.json.as_deref().map(Output::create).transpose()?;
    let to_standard = arguments.json.as_deref() == Some("-".as_ref());
    let memory = arguments.memory();
    let block = division::default_block(memory);
    let scene = scene::load(&arguments.scene, arguments.block, block, to_standard)?;
    scene.print_notes(to_standard);
    let file = scene.file.view();
    let block_bytes = file.header().block_bytes;
    let blocks = least::Mesh {
        sources: &arguments.scene,
        block: arguments.block,
        scene: &scene,
        options: |scene: &Scene| self::options(arguments, topology, scene),
    };
    let (options, layout) =
        blocks.check(|error, least, packet| too_small(arguments, error, least, packet))?;
    let refused = |error| sim::refused(error, &options);
    let least = blocks.least(kiloray_sim::least(&file, &options).map_err(refused)?);
    let (number, plan, budget) = fullest(&layout)?;
    failure::note(frames::of_mesh(&file, &options.mesh, &layout).as_deref(), to_standard);

    let within = MeshOptions { owned_in_arena: true, ..options.mesh };
    let in_arena = Options { mesh: within, ..options.clone() };
    let owned = owned(&layout);
    let share = Share {
        scene: &scene,
        nodes: layout.plans.len(),
        number,
        plan,
        budget,
        least,
        follows: blocks.follows(),
        owned,
        in_arena: match kiloray_sim::plan(&file, &in_arena) {
            Ok(_) => None,
            Err(Error::Budget(error)) => Some(error.need()),
            Err(other) => return Err(sim::refused(other, &in_arena)),
        },
    };
    if let Some(output) = json_out {
        let name = arguments.mesh.division.topology_name(&options.mesh.topology);
        let value = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "scene": scene.name,
            "memory": memory,
            "least": least,
            "nodes": layout.plans.len(),
            "topology": name,
            "node": number,
            "total": budget.bytes(),
            "lines": budget_json(budget),
            "fetches": plan.fetches,
            "tile": plan.side,
            "packet_payload": plan.payload(),
            "blocks": file.blocks(),
            "block_bytes": block_bytes,
            "owned": { "least": owned.0, "most": owned.1, "in_arena": options.mesh.owned_in_arena, "would_fit": share.in_arena.is_none() },
            "tables_bytes": file.header().blocks_at,
            "beside": mesh::beside_json(),
        });
        output.write(format!("{value:#}\n").as_bytes())?;
    }
    if to_standard { Ok(()) } else { share.print(options.mesh.owned_in_arena) }
}

/// What the simulator would be told.
fn options(arguments: &args::Plan, topology: Topology, scene: &Scene) -> Outcome<Options> {
    let view = scene.choose_view(None)?;
    let Bounds { width, height } =
        Bounds::new(arguments.width, arguments.height, framing::aspect(&view))
            .map_err(Failure::usage)?;
    let mut divided = MeshOptions::new(width, height, topology);
    divided.settings.bounces = arguments.bounces as u8;
    divided.memory = usize::try_from(arguments.memory())
        .map_err(|_| Failure::usage("--memory is more than can be addressed"))?;
    let divided = division::with(divided, &arguments.mesh.division, &scene.file.view())?;
    sim::on(divided, view, &arguments.mesh)
}

/// What is told.
struct Share<'a> {
    scene: &'a Scene,
    nodes: usize,
    number: usize,
    plan: &'a NodePlan,
    budget: &'a Budget,
    /// The least memory with which it works.
    least: usize,
    /// The size of blocks follows from the memory.
    follows: bool,
    owned: (u32, u32),
    /// With its own blocks in the arena as well: what a node then needs at least, where that is more than there is.
    in_arena: Option<usize>,
}

impl Share<'_> {
    fn print(&self, owned_in_arena: bool) -> Outcome {
        let file = self.scene.file.view();
        let Self { nodes, plan, budget, .. } = self;
        let block_bytes = u64::from(file.header().block_bytes);
        lines(format_args!("{budget}"))?;
        lines(format_args!(
            "\nNode {} of {nodes}, which has the least room. At least {} bytes of memory are needed{}.",
            self.number,
            self.least,
            if self.follows { "" } else { " with these blocks" },
        ))?;
        line(format_args!(
            "Tiles of {0} x {0} pixels; packets hold {1} bytes, a block takes {2} of them.",
            plan.side,
            plan.payload(),
            plan.block_bytes.div_ceil(plan.piece().max(1)),
        ))?;
        let (least, most) = self.owned;
        let of = |blocks: u32| bytes(u64::from(blocks) * block_bytes);
        line(format_args!(
            "A node owns {} of {} blocks of {block_bytes} bytes ({}), has frames for {} others, and at most {} of them on their way at once.",
            range(least, most),
            count(file.blocks().into()),
            if least == most { of(most) } else { format!("{} to {}", of(least), of(most)) },
            plan.frames,
            plan.fetches,
        ))?;
        match self.in_arena {
            _ if owned_in_arena => line(format_args!(
                "Its own blocks and the tables of materials and lights lie in the arena, and are counted."
            ))?,
            None => line(format_args!(
                "Its own blocks are read in place, and not counted here; with --owned-in-arena they fit too."
            ))?,
            Some(need) => line(format_args!(
                "Its own blocks are read in place, and not counted here; with --owned-in-arena at least {need} bytes are needed, in blocks of this size."
            ))?,
        }
        if !owned_in_arena {
            line(format_args!(
                "Read in place too: {} bytes of tables (materials, lights, views).",
                file.header().blocks_at
            ))?;
        }
        line(format_args!("{}", mesh::beside()))
    }
}

fn range(least: u32, most: u32) -> String {
    if least == most { most.to_string() } else { format!("{least} to {most}") }
}

/// The node with the fewest frames: those next to the host have a link more.
fn fullest(layout: &MeshLayout) -> Outcome<(usize, &NodePlan, &Budget)> {
    let nodes = layout.plans.iter().zip(&layout.budgets).enumerate();
    nodes
        .map(|(number, (plan, budget))| (number, plan, budget))
        .min_by_key(|(_, plan, _)| (plan.frames, plan.rays))
        .ok_or_else(|| Failure::new("a mesh has nodes"))
}

/// Least and most blocks that a node owns.
fn owned(layout: &MeshLayout) -> (u32, u32) {
    let owned = (0..layout.plans.len() as u16).map(|node| layout.owned(NodeId(node)));
    (owned.clone().min().unwrap_or(0), owned.max().unwrap_or(0))
}
