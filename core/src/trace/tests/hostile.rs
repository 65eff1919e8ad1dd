use super::shared::scenes::{Random, clutter, rays};
use super::shared::writer::write;
use super::shared::{Grown, Resident, Source, Topped, Visit, erased, limits};
use crate::block::format::Child;
use crate::block::{BlockError, BlockView, SPHERES};
use crate::trace::{Cursor, Scalar, TraceError, Tracer};

/// Traces whatever the bytes say: it must end, without a panic.
fn trace(mut source: Source<'_>, random: &mut Random) {
    let source = &mut source;
    let mut cursor = Cursor::new();
    for ray in rays(&[], 3, random) {
        let _ = Scalar.closest(&mut cursor, source, &ray);
        let _ = Scalar.any(&mut cursor, source, &ray);
        let visit: Visit<'_> = &mut |_| false;
        let _ = Scalar.every(&mut cursor, source, &ray, visit);
    }
}

#[test]
fn flipped_bits_are_refused_by_the_checksum_and_harmless_without_it() {
    let mut random = Random(31);
    let items = clutter(120, SPHERES, &mut random);
    let sound = write(&items, 1 << 10, 1, 99);
    assert!(sound.count() > 8);
    let mut refused = 0;
    for _ in 0..4000 {
        let mut blocks = sound.clone();
        let block = random.below(sound.count());
        for _ in 0..=random.below(3) {
            let bytes = blocks.get_mut(block);
            let at = random.below(bytes.len() as u32) as usize;
            bytes[at] ^= 1 << random.below(8);
        }
        let bytes = blocks.get(block).unwrap();
        let error = BlockView::parse(bytes, block, &limits(&sound)).err();
        if bytes != sound.get(block).unwrap() {
            assert_eq!(error, Some(BlockError::Checksum));
        }
        blocks.seal(block);
        let error = BlockView::parse(blocks.get(block).unwrap(), block, &limits(&sound)).err();
        refused += usize::from(error.is_some());
        trace(&mut Resident(&blocks), &mut random);
    }
    // Coordinates and boxes may be anything; indices and counts may not.
    assert!(refused > 1000, "{refused}");
}

#[test]
fn random_bytes_are_refused_and_harmless() {
    let mut random = Random(32);
    let items = clutter(60, false, &mut random);
    let sound = write(&items, 1 << 10, 1, 99);
    for round in 0..400 {
        let mut blocks = sound.clone();
        for block in 0..blocks.count() {
            let kept = if round % 2 == 0 { 0 } else { 64 };
            for byte in &mut blocks.get_mut(block)[kept..] {
                *byte = random.bits() as u8;
            }
            blocks.seal(block);
            let bytes = blocks.get(block).unwrap();
            assert!(BlockView::parse(bytes, block, &limits(&sound)).is_err());
        }
        trace(&mut Resident(&blocks), &mut random);
    }
}

#[test]
fn any_bytes_are_a_harmless_top() {
    let mut random = Random(35);
    let items = clutter(200, SPHERES, &mut random);
    let blocks = write(&items, 1 << 10, 1, 99);
    for round in 0..2000 {
        let mut grown = Grown::new(&blocks, 1 + random.below(40) as usize);
        // All of it, or a byte here and there.
        for bytes in
            [bytemuck::cast_slice_mut(&mut grown.nodes), bytemuck::cast_slice_mut(&mut grown.refs)]
        {
            let bytes: &mut [u8] = bytes;
            for byte in bytes {
                if round % 4 == 0 || random.below(200) == 0 {
                    *byte = random.bits() as u8;
                }
            }
        }
        trace(&mut Topped(Resident(&blocks), grown.top()), &mut random);
    }
}

#[test]
fn blocks_that_refer_to_the_same_nodes_again_and_again_end() {
    let mut random = Random(33);
    let items = clutter(4000, false, &mut random);
    let mut blocks = write(&items, 1 << 10, 1, 1);
    // In the first blocks, all references of a block lead to the next one's root, and every box is as large as it can be:
    // an exponential number of paths.
    for block in 0..28 {
        let refs = BlockView::trusted(blocks.get(block).unwrap()).refs().to_vec();
        let next = block + 1;
        let bytes = blocks.get_mut(block);
        let root = bytes.len() - 128;
        bytes[root..root + 48].fill(0);
        bytes[root + 48..root + 96].fill(0xff);
        for r in refs {
            let at = bytes.chunks(4).position(|w| w == r.block.to_le_bytes()).unwrap() * 4;
            bytes[at..at + 4].copy_from_slice(&next.to_le_bytes());
            bytes[at + 4..at + 6].fill(0);
        }
        blocks.seal(block);
    }
    let ray = &rays(&items, 1, &mut random)[0];
    let result = Scalar.any(&mut Cursor::new(), &mut erased(&mut Resident(&blocks)), ray);
    assert!(matches!(result, Err(TraceError::Corrupt { .. }) | Ok(true)), "{result:?}");
}

#[test]
fn each_kind_of_damage_has_its_error() {
    let mut random = Random(34);
    let items = clutter(200, false, &mut random);
    let sound = write(&items, 1 << 12, 3, 99);
    let damaged = |block: u32, at: usize, with: &[u8]| {
        let mut blocks = sound.clone();
        blocks.get_mut(block)[at..at + with.len()].copy_from_slice(with);
        blocks.seal(block);
        BlockView::parse(blocks.get(block).unwrap(), block, &limits(&sound)).err()
    };
    let view = BlockView::trusted(sound.get(0).unwrap());
    assert_eq!(damaged(0, 4, &[9]), Some(BlockError::Number { found: 9 }));
    assert_eq!(damaged(0, 8, &f32::NAN.to_le_bytes()), Some(BlockError::Frame));
    assert_eq!(damaged(0, 20, &3.0_f32.to_le_bytes()), Some(BlockError::Frame));
    assert_eq!(damaged(0, 24, &0.0_f32.to_le_bytes()), Some(BlockError::Frame));
    assert_eq!(damaged(0, 32, &0_u16.to_le_bytes()), Some(BlockError::Counts));
    assert_eq!(damaged(0, 36, &9999_u16.to_le_bytes()), Some(BlockError::Counts));
    assert_eq!(damaged(0, 40, &2_u16.to_le_bytes()), Some(BlockError::Reserved));
    assert_eq!(damaged(0, 42, &33_u16.to_le_bytes()), Some(BlockError::Depth));
    assert_eq!(damaged(0, 44, &1_u16.to_le_bytes()), Some(BlockError::Depth));
    assert_eq!(damaged(0, 46, &[1]), Some(BlockError::Reserved));
    assert_eq!(damaged(0, 4096 - 128 * view.nodes().len() - 1, &[1]), Some(BlockError::Reserved));
    // The first child: the root itself, one beyond the last, an undefined code.
    let node_at = 4096 - 128;
    let child = |code: u16| damaged(0, node_at + 96, &code.to_le_bytes());
    let wrong = Some(BlockError::Child { node: 0, slot: 0 });
    assert_eq!(child(0), wrong);
    assert_eq!(child(view.nodes().len() as u16), wrong);
    assert_eq!(child(0x2000), wrong);
    assert_eq!(child(0x3001), wrong);
    assert_eq!(child(0x4fff), wrong);
    assert_eq!(child(0x1fff), wrong);
    assert_eq!(child(0x4000 | 0x8000), wrong);
    // An order that names a slot twice.
    let twice = damaged(0, node_at + 112, &0o77654321_u32.to_le_bytes());
    assert_eq!(twice, Some(BlockError::Order { node: 0 }));
    // Leaves that begin before the records, and end behind them.
    let vertices_at = 64;
    let refs_at = vertices_at + 12 * view.vertices().len() + 4 * view.normals().len();
    let records_at = (refs_at + 8 * view.refs().len()).next_multiple_of(16);
    let first = (records_at / 16) as u16;
    let behind = first + view.records().len() as u16;
    let leaf = |at, count| child(Child::Leaf { at, count }.encode());
    assert_eq!(leaf(behind - 1, 1), None);
    assert_eq!(leaf(first - 1, 1), wrong);
    assert_eq!(leaf(behind, 1), wrong);
    assert_eq!(leaf(behind - 1, 2), wrong);
    // A record without a primitive, with an index or a material out of range.
    let record = Some(BlockError::Record { record: 0 });
    assert_eq!(damaged(0, records_at, &[0; 12]), record);
    assert_eq!(damaged(0, records_at + 12, &30000_u16.to_le_bytes()), record);
    assert_eq!(damaged(0, records_at + 14, &[0xff, 0xff]), record);
    let vertex = Some(BlockError::Vertex { vertex: 1 });
    assert_eq!(damaged(0, vertices_at + 16, &f32::INFINITY.to_le_bytes()), vertex);
    let back = Some(BlockError::Ref { index: 0 });
    assert_eq!(damaged(0, refs_at, &0_u32.to_le_bytes()), back);
    assert_eq!(damaged(0, refs_at, &99999_u32.to_le_bytes()), back);
    let bytes = sound.get(0).unwrap();
    let parse = |bytes| BlockView::parse(bytes, 0, &limits(&sound)).err();
    assert_eq!(parse(bytes), None);
    assert_eq!(parse(&bytes[..4095]), Some(BlockError::Length));
    let other = crate::block::BlockLimits { block_bytes: 2048, ..limits(&sound) };
    assert_eq!(BlockView::parse(&bytes[8..2056], 0, &other).err(), Some(BlockError::Alignment));
}
