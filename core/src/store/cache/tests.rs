//! The cache against a model that is too slow and too large for a node: a map and a list.

use super::*;
use crate::store::Chunk;
use proptest::prelude::*;
use std::collections::HashMap;
use std::vec;
use std::vec::Vec;

const BLOCK: usize = 64;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct State {
    on_its_way: bool,
    unused: bool,
}

impl State {
    fn evictable(self) -> bool {
        !(self.on_its_way || self.unused)
    }
}

/// Blocks in frames, and the evictable ones from the oldest to the newest.
#[derive(Debug, Default)]
struct Model {
    frames: usize,
    blocks: HashMap<u32, State>,
    order: Vec<u32>,
    counts: CacheCounts,
}

impl Model {
    fn change(&mut self, block: u32, f: impl Fn(&mut State)) {
        if let Some(state) = self.blocks.get_mut(&block) {
            let before = state.evictable();
            f(state);
            match (before, state.evictable()) {
                (true, false) => self.order.retain(|&b| b != block),
                (false, true) => self.order.push(block),
                _ => {}
            }
        }
    }

    fn get(&mut self, block: u32) -> bool {
        let here = self.blocks.get(&block).is_some_and(|s| !s.on_its_way);
        if here {
            self.counts.hits += 1;
            if self.blocks[&block].evictable() && self.counts.evictions > 0 {
                self.order.retain(|&b| b != block);
                self.order.push(block);
            }
            self.change(block, |s| s.unused = false);
        } else {
            self.counts.misses += 1;
        }
        here
    }

    fn available(&self) -> usize {
        self.frames - self.blocks.len() + self.order.len()
    }

    fn reserve(&mut self, block: u32, claim: Claim) -> Result<bool, CacheFull> {
        if self.blocks.contains_key(&block) {
            return Ok(false);
        }
        if self.available() < if claim == Claim::Prefetch { 2 } else { 1 } {
            return Err(CacheFull);
        }
        if self.blocks.len() == self.frames {
            let oldest = self.order.remove(0);
            self.blocks.remove(&oldest);
            self.counts.evictions += 1;
        }
        let unused = claim == Claim::Demand;
        self.blocks.insert(block, State { on_its_way: true, unused });
        self.counts.frames_peak = self.counts.frames_peak.max(self.blocks.len() as u64);
        Ok(true)
    }

    fn arrived(&mut self, block: u32) -> bool {
        let waited = self.blocks.get(&block).is_some_and(|s| s.on_its_way);
        self.change(block, |s| s.on_its_way = false);
        self.counts.fetched += u64::from(waited);
        waited
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]
    #[test]
    fn behaves_as_the_model(
        frames in 0_usize..6,
        steps in prop::collection::vec((0_u8..7, 0_u32..9), 0..300),
    ) {
        let mut memory = vec![Chunk::ZERO; 64];
        let mut cache = BlockCache::new(&mut Arena::new(&mut memory), BLOCK, frames).unwrap();
        let mut model = Model { frames, ..Model::default() };
        for (what, block) in steps {
            match what {
                0 | 1 => {
                    let claim = [Claim::Demand, Claim::Prefetch][usize::from(what)];
                    prop_assert_eq!(cache.reserve(block, claim), model.reserve(block, claim));
                }
                2 | 3 => {
                    if let Some(bytes) = cache.incoming(block) {
                        prop_assert_eq!(bytes.len(), BLOCK);
                        bytes.fill(block as u8);
                    }
                    prop_assert_eq!(cache.arrived(block), model.arrived(block));
                }
                4 | 5 => {
                    let here = model.get(block);
                    let bytes = cache.get(block);
                    prop_assert_eq!(bytes.is_some(), here);
                    prop_assert!(bytes.is_none_or(|b| b == [block as u8; BLOCK]), "bytes of another block");
                    if !here {
                        cache.note_miss();
                    }
                }
                _ => {
                    cache.discard(block);
                    model.blocks.remove(&block);
                    model.order.retain(|&b| b != block);
                }
            }
            for block in 0..9 {
                let residency = match model.blocks.get(&block) {
                    None => Residency::Remote,
                    Some(s) if s.on_its_way => Residency::OnItsWay,
                    Some(_) => Residency::Cached,
                };
                prop_assert_eq!(cache.residency(block), residency);
            }
            prop_assert_eq!(cache.counts(), model.counts);
        }
    }
}

#[test]
fn a_thousand_frames_are_found_again_after_a_million_changes() {
    let frames = 1000;
    let mut memory = vec![Chunk::ZERO; 2000];
    let mut cache = BlockCache::new(&mut Arena::new(&mut memory), BLOCK, frames).unwrap();
    let mut random = 1_u64;
    for step in 0..1_000_000_u32 {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let block = (random >> 33) as u32 % 3000;
        if cache.get(block).is_none() {
            cache.note_miss();
            cache.reserve(block, Claim::Demand).unwrap();
            cache.incoming(block).unwrap()[..4].copy_from_slice(&block.to_le_bytes());
            assert!(cache.arrived(block));
            assert_eq!(cache.get(block).unwrap()[..4], block.to_le_bytes(), "step {step}");
        } else {
            assert_eq!(cache.get(block).unwrap()[..4], block.to_le_bytes(), "step {step}");
        }
    }
    let counts = cache.counts();
    assert_eq!(counts.frames_peak, 1000);
    assert_eq!(counts.evictions + 1000, counts.fetched);
    // Uniform requests for 3000 blocks with 1000 frames: a third is here.
    let here = 1.0 - counts.misses as f64 / 1e6;
    assert!((here - 1.0 / 3.0).abs() < 0.01, "{here}");
}

#[test]
fn one_frame_is_enough_to_stream() {
    let mut memory = vec![Chunk::ZERO; 3];
    let mut cache = BlockCache::new(&mut Arena::new(&mut memory), BLOCK, 1).unwrap();
    assert_eq!(cache.reserve(0, Claim::Prefetch), Err(CacheFull), "the last frame");
    for block in 0..10 {
        assert_eq!(cache.reserve(block, Claim::Demand), Ok(true));
        assert_eq!(cache.reserve(block + 1, Claim::Demand), Err(CacheFull), "on its way");
        assert!(cache.arrived(block));
        assert_eq!(cache.reserve(block + 1, Claim::Demand), Err(CacheFull), "unused");
        assert!(cache.get(block).is_some());
    }
}

#[test]
fn late_and_doubled_replies_are_dropped() {
    let mut memory = vec![Chunk::ZERO; 4];
    let mut cache = BlockCache::new(&mut Arena::new(&mut memory), BLOCK, 2).unwrap();
    assert!(cache.incoming(5).is_none() && !cache.arrived(5), "never asked for");
    cache.reserve(5, Claim::Demand).unwrap();
    assert!(cache.arrived(5));
    assert!(cache.incoming(5).is_none() && !cache.arrived(5), "twice");
    cache.discard(5);
    assert_eq!(cache.residency(5), Residency::Remote);
    assert!(cache.incoming(5).is_none(), "late");
}
