use clap::Args;
use kiloray_core::{
    network::{Topology, TopologyError},
    node::{Dealing, PointHome, Prefetch, Schedule, ShadowPolicy, TaskOrder},
};
use serde::Serialize;

use super::choice::choice;
use super::mesh::{Top, group, nodes, packet, prefetch, refusals, replicas, tile};
use super::size::parse_bytes;
#[cfg(feature = "host")]
use crate::cores::cores;

/// Nodes where neither their number nor sizes of the topology are given.
const NODES: u32 = 64;
/// Most processes that are all next to each other by default: buffers of their links take a quarter of a node's memory then, with packets of half a block.
#[cfg(feature = "host")]
const FULL_NODES_MAX: u32 = 16;

/// How a run is divided among the nodes of a mesh, simulated or not.
#[derive(Debug, Clone, Args, Serialize)]
pub(crate) struct Division {
    /// How many nodes [default: as the sizes of the topology say, else 64]
    #[arg(long, value_name = "N", value_parser = nodes, allow_hyphen_values = true, help_heading = "Mesh")]
    pub(crate) nodes: Option<u32>,
    /// Who is next to whom: line, ring, mesh, torus (mesh:8x4, torus:4x4x4), hypercube, tree, tree:ARITY, full [default: torus, nearly square]
    #[arg(long, value_name = "T", help_heading = "Mesh")]
    pub(crate) topology: Option<String>,

    /// Which rays fetch blocks, and which go to them: hybrid (only specular rays go), demand (all fetch), data (all go)
    #[arg(long, value_name = "S", value_parser = choice::<Schedule>(), default_value = "hybrid", help_heading = "Work")]
    pub(crate) schedule: Schedule,
    /// Who traces shadow rays, where they fetch: the node that found what they start from (keep), or also idle nodes, sent by the master (offer) or asking others (steal) [default: offer]
    #[arg(long, value_name = "S", value_parser = choice::<ShadowPolicy>(), help_heading = "Work")]
    pub(crate) shadow: Option<ShadowPolicy>,
    /// Where the hits of rays are shaded, and wait for their shadow rays and reflections: with the node that found them (finder), or with the one that owns what was hit (owner) [default: finder]
    #[arg(long, value_name = "P", value_parser = choice::<PointHome>(), help_heading = "Work")]
    pub(crate) points: Option<PointHome>,
    /// How many blocks are fetched ahead for a bundle of shadow rays: all that its pyramid touches, up to 16, the K nearest, or none [default: 0]
    #[arg(long, value_name = "all|K|0", value_parser = prefetch, allow_hyphen_values = true, help_heading = "Work")]
    pub(crate) prefetch: Option<Prefetch>,
    /// Which of the waiting rays goes on first: that of the oldest path, or the one whose block came first [default: ready]
    #[arg(long, value_name = "O", value_parser = choice::<TaskOrder>(), help_heading = "Work")]
    pub(crate) task_order: Option<TaskOrder>,
    /// Side of a tile, the unit in which pixels are handed out [default: by picture, nodes and memory]
    #[arg(long, value_name = "PIXELS", value_parser = tile, allow_hyphen_values = true, help_heading = "Work")]
    pub(crate) tile: Option<u32>,
    /// Nodes of a group, of which one asks the host for tiles and gives them to the others; 0: all ask the host [default: 0]
    #[arg(long, value_name = "N", value_parser = group, allow_hyphen_values = true, help_heading = "Work")]
    pub(crate) group: Option<u32>,
    /// How often a ray that was refused is sent again, before the node that sent it runs it itself [default: 0]
    #[arg(long, value_name = "K", value_parser = refusals, allow_hyphen_values = true, help_heading = "Work")]
    pub(crate) refusals: Option<u32>,

    /// Which node owns which blocks: subtrees of equal bytes, or each block in turn
    #[arg(long, value_name = "P", value_parser = choice::<Dealing>(), default_value = "subtrees", help_heading = "Data")]
    pub(crate) placement: Dealing,
    /// How much of the top of the tree lies with every node: bytes (16KiB) or a number of blocks, the one at the root in any case [default: one block in 64, or as many
    /// as would fit a sixteenth of the memory: the more of the two, the less where they take part of the memory]
    #[arg(long, value_name = "SIZE|N", allow_hyphen_values = true, help_heading = "Data")]
    pub(crate) top: Option<Top>,
    /// Read-only memory of a node, as in 1MiB: no node owns more blocks than it holds, and the default of --top gives way to that [default: as much as is needed]
    #[arg(long, value_name = "SIZE", value_parser = parse_bytes, allow_hyphen_values = true, help_heading = "Data")]
    pub(crate) rom: Option<u64>,
    /// Copies of each block in all; the picture survives K - 1 crashes
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = replicas, allow_hyphen_values = true, help_heading = "Data")]
    pub(crate) block_replicas: u32,

    /// Greatest packet with its header, 280B to 16408B, or from more where blocks are greater than 16KiB [default: a block, or a part of one, as the memory allows]
    #[arg(long, value_name = "SIZE", value_parser = packet, allow_hyphen_values = true, help_heading = "Links")]
    pub(crate) packet: Option<u32>,
}

impl Division {
    /// The topology, by what is given of the two.
    pub(crate) fn topology(&self) -> Result<Topology, String> {
        let name = self.topology.as_deref().unwrap_or("torus");
        let of_sizes = || product(name).filter(|&nodes| nodes > 0);
        let nodes = self.nodes.or_else(of_sizes).unwrap_or(NODES);
        Topology::parse(name, nodes).map_err(|error| match (&self.topology, self.nodes) {
            (Some(given), Some(_)) => format!("--topology {given} for {nodes} nodes: {error}"),
            (Some(given), None) if error == TopologyError::BadSizes => {
                format!("--topology {given}: {error}, which --nodes says")
            }
            (Some(given), None) => format!("--topology {given}: {error}"),
            (None, _) => format!("--nodes {nodes}: {error}"),
        })
    }

    /// What suits processes, where it is not given: nodes are as many as processors, and each is next to each, as long as the buffers of so many links are a small part of
    /// its memory. A packet that passes through another process waits for that to be scheduled.
    #[cfg(feature = "host")]
    pub(crate) fn for_processes(&self) -> Self {
        let nodes = self.nodes.or_else(|| product(self.topology.as_deref()?));
        let nodes = nodes.unwrap_or_else(|| (cores() as u32).clamp(1, FULL_NODES_MAX));
        let name = if nodes <= FULL_NODES_MAX { "full" } else { "torus" };
        let topology = self.topology.clone().unwrap_or_else(|| name.into());
        Self { nodes: Some(nodes), topology: Some(topology), ..self.clone() }
    }

    /// What the report calls the topology: with its sizes.
    pub(crate) fn topology_name(&self, topology: &Topology) -> String {
        let name = self.topology.as_deref().unwrap_or("torus");
        match topology {
            Topology::Grid(grid) if matches!(name, "mesh" | "torus") => {
                let sizes: Vec<_> = grid.sizes().map(|s| s.to_string()).collect();
                format!("{name}:{}", sizes.join("x"))
            }
            _ => name.to_owned(),
        }
    }
}

/// Nodes by the sizes after the name of a grid.
fn product(name: &str) -> Option<u32> {
    let (_, sizes) = name.split_once(':').filter(|(name, _)| matches!(*name, "mesh" | "torus"))?;
    sizes.split('x').try_fold(1_u32, |n, size| Some(n.saturating_mul(size.parse().ok()?)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Mesh {
        #[command(flatten)]
        division: Division,
    }

    #[test]
    fn a_topology_that_is_none_is_told_without_nodes_that_nobody_named() {
        let error = |options: &[&str]| {
            let mesh = Mesh::parse_from([&["mesh"], options].concat());
            mesh.division.topology().unwrap_err()
        };
        let sizes = "bad sizes: a mesh or torus takes";
        for name in ["ring:5", "torus:0x8", "hypercube:8"] {
            let told = error(&["--topology", name]);
            assert!(told.starts_with(&format!("--topology {name}: {sizes}")), "{told}");
            assert!(told.ends_with("the number of nodes, which --nodes says"), "{told}");
        }
        let told = error(&["--topology", "ring:5", "--nodes", "9"]);
        assert!(told.starts_with("--topology ring:5 for 9 nodes: bad sizes"), "{told}");
        assert!(error(&["--nodes", "5", "--topology", "hypercube"]).contains("for 5 nodes"));
        assert!(!error(&["--topology", "disc"]).contains("--nodes"));
        for name in
            ["mesh:300x300", "mesh:70000x70000", "torus:60000x60000x60000", "mesh:9999999999x2"]
        {
            let told = error(&["--topology", name]);
            assert_eq!(told, format!("--topology {name}: a mesh has 1 to 32768 nodes"));
        }
    }

    #[test]
    fn sizes_of_a_topology_give_the_nodes() {
        assert_eq!(
            ["torus:8x8", "mesh:3x3x3", "ring", "tree:3", "mesh:x"].map(product),
            [Some(64), Some(27), None, None, None]
        );
    }
}
