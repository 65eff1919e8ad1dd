use kiloray_core::store::{CHUNK_BYTES, Chunk};
use memmap2::MmapMut;

use crate::Error;

/// The memory of all nodes, in one piece: what a node does not touch takes nothing of this machine's.
///
/// Where the machine has large pages, it is asked for them: nodes take their steps in turns, so that each finds its translations of addresses
/// gone.
#[derive(Debug)]
pub(crate) struct Arenas {
    map: MmapMut,
    /// Bytes of each.
    size: usize,
}

/// Bytes between arenas: sizes of memories are multiples of what a way of a cache holds, so that the same line of all nodes, as the head of a
/// queue, would lie in a few sets of it.
const GAP: usize = 33 * CHUNK_BYTES;

impl Arenas {
    /// So many arenas, of so many chunks each.
    pub(crate) fn new(count: usize, chunks: usize) -> Result<Self, Error> {
        let size = chunks * CHUNK_BYTES;
        let bytes = size.checked_add(GAP).and_then(|each| each.checked_mul(count));
        let map = bytes.ok_or_else(|| std::io::ErrorKind::OutOfMemory.into());
        let map = map.and_then(|bytes| MmapMut::map_anon(bytes.max(CHUNK_BYTES)));
        let map = map.map_err(|cause| Error::Memory { nodes: count, bytes: size, cause })?;
        #[cfg(target_os = "linux")]
        // A machine without large pages does without.
        let _ = map.advise(memmap2::Advice::HugePage);
        Ok(Self { map, size })
    }

    /// All of them, zeroed.
    pub(crate) fn each(&mut self) -> impl Iterator<Item = &mut [Chunk]> {
        let arenas = self.map.chunks_exact_mut(self.size + GAP);
        arenas.map(|arena| bytemuck::cast_slice_mut(&mut arena[..self.size]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_machine_has_is_refused() {
        for (count, chunks) in [(1, usize::MAX / CHUNK_BYTES), (usize::MAX, 1)] {
            assert!(matches!(Arenas::new(count, chunks), Err(Error::Memory { .. })));
        }
    }
}
