use bytemuck::{Pod, Zeroable};
use core::fmt;

/// Bytes in a [`Chunk`].
pub const CHUNK_BYTES: usize = 64;

/// The unit of an arena: 64 bytes at an address divisible by 64.
///
/// That the memory is a slice of these makes its alignment a matter of types: no plain data asks for
/// more, so a line can begin at any chunk and nothing has to be checked at run time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Chunk([u8; CHUNK_BYTES]);

impl Chunk {
    /// Zeros.
    pub const ZERO: Self = Self([0; CHUNK_BYTES]);
}

/// Memory that is carved once, from front to back, and never given back.
///
/// ```
/// use kiloray_core::store::{Arena, Chunk};
/// let mut memory = [Chunk::ZERO; 4];
/// let mut arena = Arena::new(&mut memory);
/// let sums: &mut [u64] = arena.carve(9)?;
/// assert_eq!(sums.len(), 9);
/// assert_eq!(arena.free_bytes(), 128);
/// # Ok::<(), kiloray_core::store::ArenaFull>(())
/// ```
#[derive(Debug)]
pub struct Arena<'a> {
    free: &'a mut [Chunk],
}

impl<'a> Arena<'a> {
    /// An arena over all of `memory`.
    #[must_use]
    pub const fn new(memory: &'a mut [Chunk]) -> Self {
        Self { free: memory }
    }

    /// Bytes that are not carved yet.
    #[must_use]
    pub const fn free_bytes(&self) -> usize {
        self.free.len().saturating_mul(CHUNK_BYTES)
    }

    /// What `len` values of `T` take of an arena: whole chunks.
    #[must_use]
    pub const fn bytes_of<T>(len: usize) -> usize {
        bytes_of(size_of::<T>(), len)
    }

    /// Takes `len` zeroed values of `T` off the front.
    ///
    /// # Errors
    /// [`ArenaFull`] if fewer bytes are left; nothing is taken then.
    pub fn carve<T: Pod>(&mut self, len: usize) -> Result<&'a mut [T], ArenaFull> {
        const { assert!(align_of::<T>() <= CHUNK_BYTES && size_of::<T>() > 0) };
        let bytes = self.carve_bytes(size_of::<T>(), len)?;
        // It cannot fail: the bytes are those of `len` values, and a chunk is aligned for any `T`.
        Ok(bytemuck::try_cast_slice_mut(bytes).unwrap_or_default())
    }

    /// What all types have in common: it is in the code once.
    #[inline(never)]
    fn carve_bytes(&mut self, size: usize, len: usize) -> Result<&'a mut [u8], ArenaFull> {
        let need = bytes_of(size, len);
        let full = ArenaFull { need, have: self.free_bytes() };
        let free = core::mem::take(&mut self.free);
        if need / CHUNK_BYTES > free.len() {
            self.free = free;
            return Err(full);
        }
        let (line, rest) = free.split_at_mut(need / CHUNK_BYTES);
        self.free = rest;
        line.fill(Chunk::ZERO);
        bytemuck::cast_slice_mut::<Chunk, u8>(line).get_mut(..size.saturating_mul(len)).ok_or(full)
    }
}

/// The arena has fewer bytes left than a line needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ArenaFull {
    /// Bytes of the line.
    pub need: usize,
    /// Bytes left.
    pub have: usize,
}

impl fmt::Display for ArenaFull {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the arena has {} bytes left, {} are needed", self.have, self.need)
    }
}

impl core::error::Error for ArenaFull {}

/// What so many values of this size take, up to whole chunks.
#[cfg_attr(not(feature = "bundles"), inline(never))]
const fn bytes_of(size: usize, len: usize) -> usize {
    size.saturating_mul(len).saturating_add(CHUNK_BYTES - 1) / CHUNK_BYTES * CHUNK_BYTES
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_aligned_disjoint_and_zero() {
        let mut memory = [Chunk([0xff; CHUNK_BYTES]); 8];
        let mut arena = Arena::new(&mut memory);
        let a: &mut [u8] = arena.carve(65).unwrap();
        let b: &mut [u64] = arena.carve(8).unwrap();
        let c: &mut [u32] = arena.carve(0).unwrap();
        assert_eq!((a.len(), b.len(), c.len()), (65, 8, 0));
        assert!(a.iter().all(|&x| x == 0) && b.iter().all(|&x| x == 0));
        assert_eq!(a.as_ptr() as usize % 64, 0);
        assert_eq!(b.as_ptr() as usize - a.as_ptr() as usize, 128);
        a.fill(1);
        assert!(b.iter().all(|&x| x == 0));
        assert_eq!(arena.free_bytes(), 5 * 64);
    }

    #[test]
    fn what_does_not_fit_is_refused_and_nothing_is_lost() {
        let mut memory = [Chunk::ZERO; 2];
        let mut arena = Arena::new(&mut memory);
        assert_eq!(arena.carve::<u64>(17).unwrap_err(), ArenaFull { need: 192, have: 128 });
        assert_eq!(
            arena.carve::<u64>(usize::MAX).unwrap_err().need / CHUNK_BYTES,
            usize::MAX / CHUNK_BYTES
        );
        assert_eq!(arena.carve::<u64>(16).unwrap().len(), 16);
        assert!(arena.carve::<u8>(1).is_err());
    }
}
