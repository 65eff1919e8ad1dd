//! How much a ray visits: nodes, records and blocks, on average.

use std::cell::Cell;

use kiloray_core::block::format::{BlockHeader, Node, Record};
use kiloray_core::block::{BlockSource, BlockView, Expanded, ExpandedNode, ExpandedTop, NoBlock};
use kiloray_core::geometry::{PreparedRay, Ray};
use kiloray_core::trace::{
    Crossings, Cursor, Lanes, Octants, Query, Scalar, Search, TraceError, Tracer, Verdict,
};

use crate::Error;

#[derive(Default)]
struct Counts {
    nodes: Cell<u64>,
    expanded: Cell<u64>,
    records: Cell<u64>,
    candidates: Cell<u64>,
    blocks: Cell<u64>,
}

#[derive(Clone, Copy)]
struct Counting<'a>(&'a Counts);

fn add(to: &Cell<u64>) {
    to.set(to.get() + 1);
}

impl Lanes for Counting<'_> {
    type Frame = <Scalar as Lanes>::Frame;
    type Ray = <Scalar as Lanes>::Ray;

    fn ray(self, ray: &PreparedRay) -> Self::Ray {
        Scalar.ray(ray)
    }

    fn frame(self, ray: &Self::Ray, header: &BlockHeader) -> Self::Frame {
        Scalar.frame(ray, header)
    }

    fn slots(
        self,
        frame: &Self::Frame,
        node: &Node,
        t_min: f32,
        t_max: f32,
        near: &mut [f32; 8],
    ) -> u32 {
        add(&self.0.nodes);
        Scalar.slots(frame, node, t_min, t_max, near)
    }

    fn expanded_slots(
        self,
        frame: &Self::Frame,
        node: &ExpandedNode,
        t_min: f32,
        t_max: f32,
        near: &mut [f32; 8],
    ) -> u32 {
        add(&self.0.expanded);
        Scalar.expanded_slots(frame, node, t_min, t_max, near)
    }

    fn flip(self, octants: &Octants, node: &Node) -> u8 {
        Scalar.flip(octants, node)
    }

    fn record(
        self,
        ray: &Self::Ray,
        words: &[f32],
        record: &Record,
        t_max: f32,
        crossings: &mut Crossings,
    ) -> Verdict {
        add(&self.0.records);
        let used = record.index.iter().filter(|[a, b, c]| a != b || b != c).count() as u64;
        self.0.candidates.set(self.0.candidates.get() + used);
        Scalar.record(ray, words, record, t_max, crossings)
    }
}

impl Tracer for Counting<'_> {
    fn run<T: Search, S: BlockSource, Q: Query>(
        self,
        room: &mut T::Room,
        source: &mut S,
        rays: &T::Rays,
        queries: &mut T::Queries<Q>,
    ) -> Result<(), TraceError<S::Error>> {
        T::run(self, room, source, rays, queries)
    }
}

struct Source<'a>(Expanded<'a>, &'a Counts);

impl BlockSource for Source<'_> {
    type Error = NoBlock;
    fn block(&mut self, block: u32) -> Result<BlockView<'_>, NoBlock> {
        add(&self.1.blocks);
        self.0.block(block)
    }
    fn top(&self) -> ExpandedTop<'_> {
        self.0.top()
    }
}

/// Prints the averages of a set of rays.
pub(crate) fn print(source: Expanded<'_>, kind: &str, rays: &[Ray]) -> Result<(), Error> {
    let counts = Counts::default();
    let lanes = Counting(&counts);
    let mut source = Source(source, &counts);
    let mut cursor = Cursor::new();
    for ray in rays {
        if kind == "shadow" {
            lanes.any(&mut cursor, &mut source, ray)?;
        } else {
            lanes.closest(&mut cursor, &mut source, ray)?;
        }
    }
    let per_ray = |n: &Cell<u64>| n.get() as f64 / rays.len() as f64;
    println!(
        "per {kind} ray: {:.2} nodes and {:.2} expanded, {:.2} records, {:.2} triangles, {:.2} times a block",
        per_ray(&counts.nodes),
        per_ray(&counts.expanded),
        per_ray(&counts.records),
        per_ray(&counts.candidates),
        per_ray(&counts.blocks),
    );
    Ok(())
}
