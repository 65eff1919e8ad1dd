use kiloray_core::network::{NodeId, Topology};
use kiloray_core::node::{Placement, Rom};
use kiloray_core::scene::Needs;
use kiloray_mesh::MeshOptions;
use kiloray_scene::{compile::Stats, kilo};
use serde_json::{Value, json};

use super::{board, division};
use crate::{
    args,
    console::{bytes, count, line},
    failure::{Failure, Outcome},
    output::Output,
    scene::{self, Scene, view_name},
};

/// Blocks of a scene that is compiled without a word on them, nor on nodes.
const BLOCK: u32 = 16 << 10;

/// Compiles, prints and writes.
pub(super) fn run(arguments: &args::Compile) -> Outcome {
    if let Some(path) = &arguments.output
        && arguments.for_node.is_none()
        && path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("kilo"))
    {
        return Err(Failure::usage(format_args!(
            "{}: a compiled scene's name ends in .kilo",
            path.display()
        )));
    }
    let nodes = arguments.nodes.or(arguments.for_node.map(|_| args::BOARDS));
    if let Some(nodes) = nodes
        && arguments.block_replicas > nodes
    {
        return Err(Failure::usage(format_args!(
            "--block-replicas {}: {nodes} nodes hold at most {nodes} copies of a block",
            arguments.block_replicas
        )));
    }
    if let (Some(node), Some(nodes)) = (arguments.for_node, nodes)
        && u32::from(node) >= nodes
    {
        return Err(Failure::usage(format_args!(
            "--for-node {node}: {nodes} nodes are numbered from 0 to {}",
            nodes - 1
        )));
    }
    let block = match (arguments.for_node, arguments.nodes) {
        (Some(_), _) => board::BLOCK,
        (None, Some(_)) => division::default_block(args::MESH_MEMORY),
        (None, None) => BLOCK,
    };
    let output = arguments.output.as_deref().map(Output::create).transpose()?;
    let json_out = arguments.json.as_deref().map(Output::create).transpose()?;
    let to_standard = arguments.json.as_deref() == Some("-".as_ref());

    let scene = scene::load(&arguments.scene, arguments.block, block, arguments.quiet)?;
    scene.print_notes(arguments.quiet);
    let shares = nodes.map(|nodes| Shares::new(&scene, arguments, nodes)).transpose()?;
    if !arguments.quiet && !to_standard {
        print(&scene)?;
        shares.iter().try_for_each(Shares::print)?;
    }
    if let Some(output) = output {
        let of_node = arguments.for_node.zip(shares.as_ref());
        let share =
            of_node.map(|(node, shares)| kilo::share(&scene.file, &shares.placement, NodeId(node)));
        let written = share.as_deref().unwrap_or(scene.file.bytes());
        output.write(written)?;
        if !arguments.quiet && !to_standard {
            let path = arguments.output.as_deref().unwrap_or_else(|| "".as_ref());
            line(format_args!("{}: {}", path.display(), bytes(written.len() as u64)))?;
        }
    }
    match json_out {
        Some(output) => {
            let mut json = as_json(&scene);
            if let Some(shares) = shares {
                json["placement"] = shares.as_json();
            }
            output.write(format!("{json:#}\n").as_bytes())
        }
        None => Ok(()),
    }
}

/// How the blocks are dealt out to the nodes of a mesh.
struct Shares {
    placement: Placement,
    nodes: u32,
    copies: u32,
    block_bytes: u64,
    /// Blocks of the node that has the fewest, and of the one that has the most: those at the top of the tree, which all have, among them.
    least: u64,
    most: u64,
}

impl Shares {
    fn new(scene: &Scene, arguments: &args::Compile, nodes: u32) -> Outcome<Self> {
        let file = scene.file.view();
        let block_bytes = file.header().block_bytes;
        // All boards have the root's block alone, other nodes more of the top of the tree.
        let options = MeshOptions {
            dealing: arguments.placement,
            top: arguments.for_node.map(|_| 1),
            replicas: arguments.block_replicas as u16,
            ..MeshOptions::new(1, 1, Topology::Full { nodes: nodes as u16 })
        };
        let placement = options.placement(&file);
        let rom = arguments.rom.unwrap_or(u64::MAX);
        let placement = division::limited(placement, rom, block_bytes.into(), false)?;
        let owned = |node| {
            Rom::of_file(&[], block_bytes as usize, placement, NodeId(node as u16)).len() as u64
        };
        let shares: Vec<_> = (0..nodes).map(owned).collect();
        Ok(Self {
            placement,
            nodes,
            copies: placement.copies().into(),
            block_bytes: block_bytes.into(),
            least: shares.iter().copied().min().unwrap_or(0),
            most: shares.iter().copied().max().unwrap_or(0),
        })
    }

    fn print(&self) -> Outcome {
        let copies =
            if self.copies > 1 { format!(", {} copies", self.copies) } else { String::new() };
        let top = match self.placement.top {
            0 | 1 => "the root's lies with all".into(),
            top => format!("{top} at the root lie with all"),
        };
        line(format_args!(
            "placement  {} nodes{copies}: each has {} to {} blocks of {}, {} to {}; {top}",
            self.nodes,
            self.least,
            self.most,
            bytes(self.block_bytes),
            bytes(self.least * self.block_bytes),
            bytes(self.most * self.block_bytes),
        ))
    }

    fn as_json(&self) -> Value {
        json!({
            "nodes": self.nodes,
            "copies": self.copies,
            "blocks": { "least": self.least, "most": self.most },
            "bytes": { "least": self.least * self.block_bytes, "most": self.most * self.block_bytes },
        })
    }
}

/// What a scene can need, and what each of them spares a scene without it.
pub(super) const NEEDS: [(u32, &str, &str); 8] = [
    (Needs::SPECULAR, "specular", "specular rays"),
    (Needs::TRANSPARENT, "transparent", "shadow rays that go on behind the first hit"),
    (Needs::SPHERES, "spheres", "tests of spheres"),
    (Needs::NORMALS, "normals", "shading normals"),
    (Needs::GLOSSY, "glossy", "glossy lobes"),
    (Needs::DIELECTRIC, "dielectric", "refraction"),
    (Needs::DISTANT, "distant", "light from beyond the scene"),
    (Needs::MANY_LIGHTS, "many_lights", "a tree of lights"),
];

fn print(scene: &Scene) -> Outcome {
    let file = scene.file.view();
    let header = file.header();
    let has = |bit: u32| file.needs().bits & bit != 0;
    let names = |wanted: bool| -> String {
        let all: Vec<_> = NEEDS
            .iter()
            .filter(|(bit, ..)| has(*bit) == wanted)
            .map(|&(_, need, spared)| if wanted { need.replace('_', " ") } else { spared.into() })
            .collect();
        if all.is_empty() { "nothing".into() } else { all.join(", ") }
    };
    line(format_args!("scene      {}", scene.name))?;
    match &scene.stats {
        Some(stats) => print_stats(stats)?,
        None => line(format_args!("surfaces   {}", count(header.primitives.into())))?,
    }
    line(format_args!(
        "blocks     {} of {}, {} in all",
        count(header.blocks.into()),
        bytes(header.block_bytes.into()),
        bytes(u64::from(header.blocks) * u64::from(header.block_bytes)),
    ))?;
    let [materials, lights] = scene
        .left_out()
        .map(|n| if n > 0 { format!(" ({n} without effect left out)") } else { String::new() });
    line(format_args!(
        "tables     {} materials{materials}, {} lights{lights}, {} views",
        file.materials().len(),
        file.lights().len(),
        file.views().len()
    ))?;
    for (i, view) in file.views().iter().enumerate() {
        line(format_args!("view {:<5} {}", i + 1, view_name(view)))?;
    }
    line(format_args!("needs      {}", names(true)))?;
    line(format_args!("skips      {}", names(false)))?;
    line(format_args!("position   within {:.2e} of the input", header.frame.position_error))
}

fn print_stats(stats: &Stats) -> Outcome {
    line(format_args!(
        "surfaces   {} triangles, {} spheres{}",
        count(stats.triangles),
        count(stats.spheres),
        if stats.void > 0 {
            format!("; {} left out, as they are void", count(stats.void))
        } else {
            String::new()
        }
    ))?;
    line(format_args!(
        "tree       {} nodes, {} levels, {} blocks deep; {:.1} bytes per surface, {:.0} % filled",
        count(stats.nodes),
        stats.depth,
        stats.nesting,
        stats.bytes_per_primitive(),
        100.0 * stats.fill()
    ))?;
    line(format_args!(
        "compiled   in {:.2} s",
        stats.times.iter().map(std::time::Duration::as_secs_f64).sum::<f64>()
    ))
}

fn as_json(scene: &Scene) -> Value {
    let file = scene.file.view();
    let header = file.header();
    let needs: serde_json::Map<_, _> = NEEDS
        .iter()
        .map(|&(bit, name, _)| (name.to_owned(), json!(file.needs().bits & bit != 0)))
        .collect();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "scene": scene.name,
        "surfaces": header.primitives,
        "triangles": scene.stats.as_ref().map(|s| s.triangles),
        "spheres": scene.stats.as_ref().map(|s| s.spheres),
        "void": scene.stats.as_ref().map(|s| s.void),
        "dropped": scene.stats.as_ref().map(|s| s.dropped),
        "blocks": {
            "count": header.blocks,
            "block_bytes": header.block_bytes,
            "bytes": u64::from(header.blocks) * u64::from(header.block_bytes),
            "fill": scene.stats.as_ref().map(Stats::fill),
        },
        "bytes_per_surface": scene.stats.as_ref().map(Stats::bytes_per_primitive),
        "depth": scene.stats.as_ref().map(|s| s.depth),
        "nesting": scene.stats.as_ref().map(|s| s.nesting),
        "materials": file.materials().len(),
        "lights": file.lights().len(),
        "views": file.views().iter().map(view_name).collect::<Vec<_>>(),
        "needs": needs,
        "position_error": header.frame.position_error,
        "file_bytes": scene.file.bytes().len(),
        "time_s": scene.stats.as_ref().map(|s| s.times.iter().map(|t| t.as_secs_f64()).sum::<f64>()),
        "notes": scene.notes,
    })
}
