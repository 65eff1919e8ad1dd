//! A ray that is parked at every missing block, as ray, best hit and trail, finds what a ray finds that is never stopped.

use proptest::prelude::*;

use super::scenes::{Random, clutter, rays};
use super::writer::{Blocks, write};
use super::{Resident, Source, Visit, brute, erased, shown};
use crate::block::format::DEPTH_MAX;
use crate::block::{BlockSource, BlockView, NoBlock, SPHERES};
use crate::geometry::Hit;
use crate::trace::{Cursor, TraceError, Tracer, Trail};

/// A source that does not have all blocks.
#[derive(Debug, Clone, Copy)]
enum Kind {
    /// It has the block that was last fetched.
    One,
    /// It has that once, and then nothing.
    Once,
    /// It also has some blocks always: of 256 so many.
    Some(u8),
    /// It also has any block now and then.
    Forgets(u8),
}

struct Fickle<'a> {
    blocks: &'a Blocks,
    kind: Kind,
    fetched: Option<u32>,
    random: Random,
}

impl BlockSource for Fickle<'_> {
    type Error = NoBlock;

    fn block(&mut self, block: u32) -> Result<BlockView<'_>, NoBlock> {
        let fetched = self.fetched == Some(block);
        let here = match self.kind {
            Kind::One => fetched,
            Kind::Once => self.fetched.take() == Some(block),
            Kind::Some(of) => fetched || Random(u64::from(block)).below(256) < u32::from(of),
            Kind::Forgets(of) => fetched || self.random.below(256) < u32::from(of),
        };
        if !here {
            return Err(NoBlock(block));
        }
        if matches!(self.kind, Kind::Forgets(_)) {
            self.fetched = None;
        }
        self.blocks.get(block).map(BlockView::trusted).ok_or(NoBlock(block))
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Case {
    seed: u64,
    items: usize,
    block_bytes: usize,
    leaf: usize,
    nodes: usize,
    kind: Kind,
}

pub(crate) fn cases() -> impl Strategy<Value = Case> {
    let kind = prop_oneof![
        Just(Kind::One),
        Just(Kind::Once),
        any::<u8>().prop_map(Kind::Some),
        any::<u8>().prop_map(Kind::Forgets),
    ];
    let shape = prop_oneof![Just((1 << 10, 1, 1)), Just((1 << 10, 1, 99)), Just((1 << 11, 2, 99))];
    (any::<u64>(), 1_usize..400, shape, kind).prop_map(|(seed, items, shape, kind)| {
        let (block_bytes, leaf, nodes) = shape;
        Case { seed, items, block_bytes, leaf, nodes, kind }
    })
}

/// More stops than any ray of these tests has.
const STOPS_MAX: usize = 20_000;

/// One continuation after the other, with a cursor that knows nothing of the ray, until it ends. Returns how often it was stopped.
fn parked<R>(
    source: &mut Fickle<'_>,
    mut go_on: impl FnMut(&mut Cursor, &mut Source<'_>, &Trail) -> Result<R, TraceError<NoBlock>>,
) -> (R, usize) {
    let mut cursor = Cursor::new();
    let mut trail = Trail::START;
    for stops in 0..STOPS_MAX {
        match go_on(&mut cursor, &mut erased(source), &trail) {
            Ok(result) => return (result, stops),
            Err(TraceError::Source(NoBlock(block))) => {
                assert_eq!(cursor.trail().block(), block);
                assert_ne!((stops > 0).then_some(cursor.trail()), Some(trail), "no progress");
                trail = cursor.trail();
                source.fetched = Some(block);
                cursor = Cursor::new();
            }
            Err(error) => panic!("{error:?}"),
        }
    }
    panic!("never ends")
}

/// The rays of a case, with the lanes of two tracers in turns.
pub(crate) fn agree(case: &Case, one: impl Tracer, other: impl Tracer) {
    let mut random = Random(case.seed);
    let items = clutter(case.items, SPHERES, &mut random);
    let blocks = write(&items, case.block_bytes, case.leaf, case.nodes);
    let source =
        |seed| Fickle { blocks: &blocks, kind: case.kind, fetched: None, random: Random(seed) };
    let nesting = usize::from(BlockView::trusted(blocks.get(0).unwrap()).header().nesting);
    for ray in rays(&items, 12, &mut random) {
        let mut resident = Resident(&blocks);
        let resident = &mut erased(&mut resident);
        let mut cursor = Cursor::new();
        let seed = random.bits();
        // For each child: on the way back to it, each block of the path may be missing, and then its own.
        let most = |cursor: &mut Cursor| {
            let visited = cursor.take_visited();
            (visited.nodes + visited.leaves + 1) as usize * (nesting + 2)
        };

        let closest = one.closest(&mut cursor, resident, &ray).unwrap();
        assert_eq!(closest, brute(&items, &ray).first().copied());
        let mut turn = 0;
        let mut best = None;
        let (hit, stops) = parked(&mut source(seed), |cursor, source, trail| {
            turn += 1;
            let result = if turn % 2 == 0 {
                one.continue_closest(cursor, source, &ray, best, trail)
            } else {
                other.continue_closest(cursor, source, &ray, best, trail)
            };
            best = cursor.best();
            result
        });
        assert_eq!(hit, closest, "{ray:?}");
        let bits = |hit: Option<Hit>| hit.map(|h| [h.t, h.b1, h.b2].map(f32::to_bits));
        assert_eq!(bits(hit), bits(closest));
        assert!(stops <= most(&mut cursor), "{stops} stops, nesting {nesting}");

        assert_eq!(one.any(&mut cursor, resident, &ray), Ok(closest.is_some()));
        let (found, stops) = parked(&mut source(seed), |cursor, source, trail| {
            turn += 1;
            if turn % 2 == 0 {
                one.continue_any(cursor, source, &ray, trail)
            } else {
                other.continue_any(cursor, source, &ray, trail)
            }
        });
        assert_eq!(found, closest.is_some());
        // All that it may visit: where all blocks are at hand it begins at the other end.
        cursor.take_visited();
        let visit: Visit<'_> = &mut |_| false;
        one.every(&mut cursor, resident, &ray, visit).unwrap();
        let most = most(&mut cursor);
        assert!(stops <= most, "{stops} stops, nesting {nesting}");

        let (((), stops), all) = shown(|visit| {
            parked(&mut source(seed), |cursor, source, trail| {
                turn += 1;
                if turn % 2 == 0 {
                    one.continue_every(cursor, source, &ray, trail, &mut *visit)
                } else {
                    other.continue_every(cursor, source, &ray, trail, &mut *visit)
                }
            })
        });
        assert_eq!(all, brute(&items, &ray), "{ray:?}");
        assert!(stops <= most, "{stops} stops, nesting {nesting}");
    }
}

/// Trails of other trees, damaged ones, and bytes that never were one.
pub(crate) fn hostile(case: &Case, damage: &[(usize, u8)], bytes: [u8; 20], tracer: impl Tracer) {
    let mut random = Random(case.seed);
    let items = clutter(case.items, SPHERES, &mut random);
    let blocks = write(&items, case.block_bytes, case.leaf, case.nodes);
    let nodes: usize =
        (0..blocks.count()).map(|b| BlockView::trusted(blocks.get(b).unwrap()).nodes().len()).sum();
    let rays = rays(&items, 6, &mut random);
    let mut trails = std::vec![bytemuck::cast::<[u8; 20], Trail>(bytes)];
    for ray in &rays {
        // Where a ray is stopped at a block that never comes.
        let missing = random.below(blocks.count());
        let mut source = Resident(&blocks);
        let mut cursor = Cursor::new();
        let visit: Visit<'_> = &mut |_| false;
        let _ =
            tracer.every(&mut cursor, &mut erased(&mut Without(&mut source, missing)), ray, visit);
        let mut bytes: [u8; 20] = bytemuck::cast(cursor.trail());
        trails.push(cursor.trail());
        for &(at, with) in damage {
            bytes[at % 20] ^= with;
            trails.push(bytemuck::cast(bytes));
        }
    }
    for ray in &rays {
        for trail in &trails {
            let mut cursor = Cursor::new();
            let mut resident = Resident(&blocks);
            let source = &mut erased(&mut resident);
            let visit: Visit<'_> = &mut |_| false;
            let _ = tracer.continue_closest(&mut cursor, source, ray, None, trail);
            let _ = tracer.continue_any(&mut cursor, source, ray, trail);
            let _ = tracer.continue_every(&mut cursor, source, ray, trail, visit);
            // Twice a subtree and a way back, at most, for each of the three.
            let most = 3 * (2 * nodes + 2 * DEPTH_MAX) as u64;
            assert!(cursor.visited().nodes <= most, "{:?} of {most}, {trail:?}", cursor.visited());
        }
    }
}

/// All blocks but one.
struct Without<'a>(&'a mut Resident<'a>, u32);

impl BlockSource for Without<'_> {
    type Error = NoBlock;

    fn block(&mut self, block: u32) -> Result<BlockView<'_>, NoBlock> {
        if block == self.1 {
            return Err(NoBlock(block));
        }
        self.0.block(block)
    }
}
