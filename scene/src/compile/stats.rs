use core::fmt;
use std::time::Duration;

use kiloray_core::block::format::RECORD_PRIMITIVES;

use super::pack::Blocks;
use super::surfaces::Surfaces;
use super::tree::Node;

/// What a compilation made, and what it took.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Stats {
    /// Triangles in the blocks.
    pub triangles: u64,
    /// Spheres in the blocks.
    pub spheres: u64,
    /// Triangles and spheres left out, as their material is void.
    pub void: u64,
    /// Others left out: they vanish when rounded to f32.
    pub dropped: u64,
    /// Surfaces in the blocks that rounding to f32 can move by more than a hundredth of their size,
    /// the longest side of their box: they are small beside the whole scene.
    pub coarse: u64,
    /// The most that it can move one of these [input units].
    pub coarse_error: f64,
    /// Size of a block.
    pub block_bytes: usize,
    /// Blocks.
    pub blocks: u64,
    /// Bytes of the blocks that are used.
    pub used_bytes: u64,
    /// Nodes.
    pub nodes: u64,
    /// Records.
    pub records: u64,
    /// Vertices stored in blocks; one that several blocks need counts in each.
    pub vertices: u64,
    /// References between blocks.
    pub refs: u64,
    /// Levels of nodes.
    pub depth: u32,
    /// Blocks on the longest path.
    pub nesting: u32,
    /// Nodes that a random line through the scene's box meets, by the surface-area heuristic.
    pub expected_nodes: f64,
    /// Records that it meets.
    pub expected_records: f64,
    /// Treelets that it enters.
    pub expected_blocks: f64,
    /// Time of the stages: surfaces, tree, cut, blocks.
    pub times: [Duration; 4],
}

impl Stats {
    /// Bytes of blocks per primitive.
    #[must_use]
    pub fn bytes_per_primitive(&self) -> f64 {
        (self.blocks * self.block_bytes as u64) as f64
            / (self.triangles + self.spheres).max(1) as f64
    }

    /// Whether rounding to f32 can show: in at least one of a hundred surfaces. A scene may have a few
    /// that are tiny, and nobody sees those.
    #[must_use]
    pub fn is_coarse(&self) -> bool {
        self.coarse > 0 && self.coarse * 100 >= self.triangles + self.spheres
    }

    /// Fills in what the surface-area heuristic expects.
    pub(crate) fn with_expectations(
        mut self,
        nodes: &[Node],
        surfaces: &Surfaces,
        blocks: &Blocks,
    ) -> Self {
        let mut areas: Vec<f64> = Vec::with_capacity(nodes.len());
        let of_roots = nodes.first().map_or(1.0, |root| f64::from(root.area()).max(1e-300));
        for node in nodes {
            areas.push(f64::from(node.area()) / of_roots);
        }
        self.expected_nodes = areas.iter().sum();
        self.expected_blocks = if nodes.is_empty() { 0.0 } else { 1.0 };
        for (index, node) in nodes.iter().enumerate() {
            for (_, kid) in node.nodes() {
                if blocks.places[kid as usize].0 != blocks.places[index].0 {
                    self.expected_blocks += areas[kid as usize];
                }
            }
            for (slot, first, count) in node.leaves() {
                let items = &surfaces.items[first as usize..(first + count) as usize];
                let records: usize = items
                    .chunk_by(|a, b| a.group == b.group)
                    .map(|group| group.len().div_ceil(RECORD_PRIMITIVES))
                    .sum();
                self.expected_records +=
                    f64::from(node.bounds[slot].area()) / of_roots * records as f64;
            }
        }
        self
    }

    /// Used part of the blocks.
    #[must_use]
    pub fn fill(&self) -> f64 {
        fill(self.used_bytes, self.blocks, self.block_bytes)
    }
}

/// The part of so many blocks that is used.
pub(super) fn fill(used_bytes: u64, blocks: u64, block_bytes: usize) -> f64 {
    used_bytes as f64 / (blocks * block_bytes as u64).max(1) as f64
}

impl fmt::Display for Stats {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} triangles, {} spheres in {} blocks of {} bytes: {:.2} bytes each, fill {:.3}, depth {}, nesting {}",
            self.triangles,
            self.spheres,
            self.blocks,
            self.block_bytes,
            self.bytes_per_primitive(),
            self.fill(),
            self.depth,
            self.nesting,
        )?;
        let [surfaces, tree, cut, blocks] = self.times.map(|t| t.as_secs_f64() * 1e3);
        write!(
            f,
            "\nexpected per line: {:.2} nodes, {:.2} records, {:.3} blocks; \
             {} nodes, {} records, {} vertices, {} references; \
             surfaces {surfaces:.0} + tree {tree:.0} + cut {cut:.0} + blocks {blocks:.0} ms",
            self.expected_nodes,
            self.expected_records,
            self.expected_blocks,
            self.nodes,
            self.records,
            self.vertices,
            self.refs,
        )
    }
}
