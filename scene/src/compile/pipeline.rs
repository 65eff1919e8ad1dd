use std::time::Instant;

use kiloray_core::block::format::{FileHeader, MAGIC, VERSION};

use super::bounds::Bounds;
use super::build::build;
use super::compiled::Compiled;
use super::cut::Cutter;
use super::emit::emit;
use super::fit::{fit, leaf_max};
use super::frame::Placement;
use super::layout::Source;
use super::light_tree::light_tree;
use super::lights::{split_materials, useful};
use super::options::{CompileError, Options, Progress, Stage};
use super::order::order;
use super::pack::{Blocks, pack};
use super::stats::{Stats, fill};
use super::surfaces::Surfaces;
use super::tables::{Materials, check_lights, view};
use super::tree::Node;
use crate::kilo::{Image, Tables};
use crate::model::Model;
use crate::needs::{Summary, needs};

/// Compiles a model to the bytes of a `.kilo` file.
///
/// # Errors
///
/// [`CompileError`]: a size of blocks that cannot be, a model whose indices lead nowhere, more
/// surfaces than the file's numbers can count, or more lights than are allowed.
pub fn compile(
    model: &Model,
    options: &Options,
    progress: &mut dyn Progress,
) -> Result<Compiled, CompileError> {
    options.check()?;
    check_lights(model)?;
    let mut clock = Clock { last: Instant::now(), stats: Stats::default() };
    let place = Placement::of(model);
    let mut surfaces = Surfaces::of(model, place)?;
    let (mut lights, dark) = useful(model, place);
    if lights.len() > options.lights_max {
        return Err(CompileError::Lights { count: lights.len(), limit: options.lights_max });
    }
    let mut list = model.materials.clone();
    split_materials(&mut list, &mut surfaces, &mut lights, place);
    let mut materials = Materials::of(&list, &mut surfaces, &lights, place);
    let count = surfaces.items.len() as u64;
    progress.report(Stage::Surfaces, count, count);
    clock.stage(0);

    let leaf_max = leaf_max(options.block_bytes);
    let mut nodes =
        build(&mut surfaces.items, leaf_max, &mut |done| progress.report(Stage::Tree, done, count));
    surfaces.sort_corners();
    fit(&mut nodes, &surfaces, options.block_bytes);
    progress.report(Stage::Tree, count, count);
    clock.stage(1);

    let source = Source { nodes: &nodes, surfaces: &surfaces, block_bytes: options.block_bytes };
    let parents = parents(&nodes);
    let total = nodes.len() as u64;
    let packed = fullest(source, &parents, progress);
    let blocks = order(packed, &nodes, &parents);
    clock.stage(2);

    let mut all = Bounds::EMPTY;
    for item in &surfaces.items {
        all.grow(item.lanes());
    }
    let (lo, hi) = all.ends();
    let lights = materials.lights(&lights, place);
    let views: Vec<_> = model.views.iter().filter_map(|v| view(v, place)).collect();
    let light_tree = light_tree(&lights);
    let needs = needs(&materials.table, &lights, &light_tree, &surfaces, (lo, hi));
    let header = FileHeader {
        magic: MAGIC,
        version: VERSION,
        block_bytes: options.block_bytes as u32,
        blocks: blocks.nodes.len() as u32,
        primitives: count as u32,
        frame: place.frame(surfaces.error),
        lo,
        hi,
        ..bytemuck::Zeroable::zeroed()
    };
    let tables = Tables {
        materials: &materials.table,
        lights: &lights,
        views: &views,
        light_tree: &light_tree,
        needs,
    };
    let mut image = Image::new(header, tables);
    let totals = emit(source, &parents, &blocks, image.blocks_mut());
    let number = header.blocks.into();
    progress.report(Stage::Blocks, number, number);
    clock.stage(3);

    let stats = Stats {
        triangles: surfaces.triangles,
        spheres: surfaces.spheres,
        void: surfaces.void,
        dropped: surfaces.dropped,
        coarse: surfaces.coarse,
        coarse_error: f64::from(surfaces.coarse_error) / place.scale(),
        block_bytes: options.block_bytes,
        blocks: number,
        used_bytes: blocks.used,
        nodes: total,
        records: totals.records,
        vertices: totals.vertices,
        refs: totals.refs,
        depth: totals.height.into(),
        nesting: totals.nesting.into(),
        ..clock.stats
    };
    let stats = stats.with_expectations(&nodes, &surfaces, &blocks);
    let unused = renamed(&materials, model.materials.len());
    let summary = Summary {
        needs,
        materials: materials.table.len(),
        materials_unused: unused,
        lights: lights.len(),
        lights_dark: dark,
        views: views.len(),
        size: (place.hi - place.lo).to_array(),
        position_error: header.frame.position_error,
    };
    Ok(Compiled { image, stats, summary })
}

/// What treelets that leave much of a block empty are charged for it, until blocks are full enough: where all are alike, as in a grid of like objects, nothing
/// fits in beside them. In 4 KiB: colour-cube:36 .76, .89 and .91, conference:40 .84 and .91, a displaced sphere .945 at once; sinc:700, whose every node takes
/// 700 bytes, stays at .84.
const WASTE: [f32; 3] = [0.0, 2.0, 8.0];
/// Full enough.
const FILL: f64 = 0.9;

/// The fullest blocks that are found.
fn fullest(source: Source<'_>, parents: &[u32], progress: &mut dyn Progress) -> Blocks {
    let mut cutter = Cutter::new(source);
    let mut best = Blocks::default();
    let (nodes, more) = (source.nodes.len() as u64, WASTE.len() as u64 - 1);
    for (before, waste) in (0..).zip(WASTE) {
        let mut done = |done| match before {
            0 => progress.report(Stage::Cut, done, nodes),
            _ => progress.report(Stage::Recut, (before - 1) * nodes + done, more * nodes),
        };
        let blocks = pack(source, parents, &cutter.cut(waste, &mut done));
        if best.nodes.is_empty() || blocks.nodes.len() < best.nodes.len() {
            best = blocks;
        }
        if fill(best.used, best.nodes.len() as u64, source.block_bytes) >= FILL {
            break;
        }
    }
    best
}

/// How many of the model's materials are not in the table.
fn renamed(materials: &Materials, len: usize) -> usize {
    materials.renamed[..len].iter().filter(|&&new| new == u32::MAX).count()
}

struct Clock {
    last: Instant,
    stats: Stats,
}

impl Clock {
    fn stage(&mut self, stage: usize) {
        let now = Instant::now();
        self.stats.times[stage] = now - self.last;
        self.last = now;
    }
}

/// The parent of each node; `u32::MAX` for the root.
fn parents(nodes: &[Node]) -> Vec<u32> {
    let mut parents = vec![u32::MAX; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        for (_, kid) in node.nodes() {
            parents[kid as usize] = index as u32;
        }
    }
    parents
}
