use bytemuck::bytes_of;
use kiloray_core::network::NodeId;
use kiloray_core::node::{Placement, Rom, ShareHeader};

use super::KiloFile;

/// What node `here` of a mesh needs of a scene, as [`kiloray_core::node::Share`] reads it.
#[must_use]
pub fn share(file: &KiloFile, placement: &Placement, here: NodeId) -> Vec<u8> {
    let view = file.view();
    let head = &file.bytes()[..view.head_bytes()];
    let header = ShareHeader::new(placement, here, head.len() as u32);
    let mut bytes = [bytes_of(&header), head].concat();
    bytes.resize(bytes.len().next_multiple_of(64), 0);
    let block_bytes = view.limits().block_bytes;
    let rom = Rom::of_share(&[], block_bytes, *placement, here);
    let mut blocks: Vec<u32> = (0..view.blocks()).filter(|&block| rom.holds(block)).collect();
    blocks.sort_by_key(|&block| rom.place(block));
    bytes.extend(blocks.into_iter().filter_map(|block| view.block_bytes(block)).flatten());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{builtin, compile};
    use kiloray_core::node::{Dealing, Share, ShareError};

    fn scene() -> KiloFile {
        let model = builtin::build("glass").expect("a scene that exists");
        let options = compile::Options::blocks_of(1024);
        let compiled = compile::compile(&model, &options, &mut ());
        KiloFile::from_compiled(compiled.expect("it compiles"))
    }

    /// In memory as a node has it.
    fn aligned(bytes: &[u8]) -> Vec<[u64; 8]> {
        let mut lines = vec![[0; 8]; bytes.len().div_ceil(64)];
        bytemuck::cast_slice_mut(&mut lines)[..bytes.len()].copy_from_slice(bytes);
        lines
    }

    #[test]
    fn a_share_has_the_tables_and_the_blocks_of_its_node() {
        let file = scene();
        let view = file.view();
        for (dealing, nodes, top, replicas) in [
            (Dealing::Subtrees, 4, 1, 1),
            (Dealing::Subtrees, 5, 2, 2),
            (Dealing::Subtrees, 7, 1, 5),
            (Dealing::RoundRobin, 4, 3, 2),
        ] {
            let placement = Placement { dealing, blocks: view.blocks(), nodes, top, replicas };
            for here in (0..nodes).map(NodeId) {
                let bytes = share(&file, &placement, here);
                let lines = aligned(&bytes);
                let share = Share::parse(bytemuck::cast_slice(&lines)).expect("it is sound");
                share.check_blocks().expect("they are sound");
                assert_eq!((share.here(), *share.placement()), (here, placement));
                assert_eq!(share.file().materials(), view.materials());
                assert_eq!(share.file().lights(), view.lights());
                assert_eq!(share.scene(), view.header().crc);
                for block in 0..view.blocks() {
                    let expected = view.block_bytes(block).filter(|_| placement.holds(here, block));
                    assert_eq!(share.rom().block(block), expected, "{here:?} {block}");
                }
                let expected =
                    64 + view.head_bytes().next_multiple_of(64) + 1024 * share.rom().len();
                assert_eq!(bytes.len(), expected);
            }
        }
    }

    #[test]
    fn a_damaged_share_is_refused_by_cause() {
        let file = scene();
        let dealing = Dealing::Subtrees;
        let placement =
            Placement { dealing, blocks: file.view().blocks(), nodes: 4, top: 1, replicas: 1 };
        let bytes = share(&file, &placement, NodeId(2));
        let parse = |bytes: &[u8]| {
            let lines = aligned(bytes);
            let bytes = &bytemuck::cast_slice(&lines)[..bytes.len()];
            Share::parse(bytes).and_then(|share| share.check_blocks())
        };
        assert_eq!(parse(&bytes), Ok(()));
        for end in 0..bytes.len() {
            assert!(parse(&bytes[..end]).is_err(), "{end} of {} bytes", bytes.len());
        }
        let mut damaged = bytes.clone();
        for at in 0..bytes.len() {
            damaged[at] ^= 0x10;
            // What fills up to the next 64 belongs to nothing.
            let is_gap = (64 + file.view().head_bytes()..).contains(&at)
                && at < (64 + file.view().head_bytes()).next_multiple_of(64);
            assert_eq!(parse(&damaged).is_ok(), is_gap, "byte {at}");
            damaged[at] = bytes[at];
        }
        damaged[4] += 1;
        assert_eq!(parse(&damaged), Err(ShareError::Version { found: 2 }));
        damaged[0] = 0;
        assert_eq!(parse(&damaged), Err(ShareError::Magic));
        assert_eq!(parse(&bytes[..70]), Err(ShareError::Truncated));
    }
}
