//! The checks of a block on arrival: after them, every index in it leads somewhere.

use super::error::BlockError;
use super::format::{
    BLOCK_BYTES_MAX, BLOCK_BYTES_MIN, BlockHeader, DEPTH_MAX, FLAG_NORMALS, Node, RECORD_SPHERES,
    Record, is_order,
};
use super::view::{BlockLimits, BlockView};

/// More nodes than this fit no block.
const NODES_MAX: usize = (BLOCK_BYTES_MAX - size_of::<BlockHeader>()) / size_of::<Node>();

/// The length: the size that the file names, and one that the format allows.
pub(super) fn length(bytes: &[u8], limits: &BlockLimits) -> Result<(), BlockError> {
    let allowed = (BLOCK_BYTES_MIN..=BLOCK_BYTES_MAX).contains(&bytes.len());
    if bytes.len() == limits.block_bytes && bytes.len().is_power_of_two() && allowed {
        Ok(())
    } else {
        Err(BlockError::Length)
    }
}

/// Everything behind the checksum.
#[cfg_attr(feature = "bundles", inline(always))]
pub(super) fn content(
    view: &BlockView<'_>,
    block: u32,
    limits: &BlockLimits,
) -> Result<(), BlockError> {
    head(view.header(), block, limits)?;
    parts(view)?;
    vertices(view)?;
    records(view, limits)?;
    refs(view, block, limits)?;
    tree(view)
}

#[cfg_attr(feature = "bundles", inline(always))]
fn head(header: &BlockHeader, block: u32, limits: &BlockLimits) -> Result<(), BlockError> {
    if header.block != block || block >= limits.blocks {
        return Err(BlockError::Number { found: header.block });
    }
    let step = |s: f32| {
        let exponent = (s.to_bits() >> 23) as i32 - 127;
        s.to_bits() & 0x807f_ffff == 0 && (-80..=1).contains(&exponent)
    };
    // Frames begin at a box of the scene, rounded outward.
    let place = |o: f32| o.abs() <= 1.001;
    if !header.scale.iter().all(|&s| step(s)) || !header.origin.iter().all(|&o| place(o)) {
        return Err(BlockError::Frame);
    }
    if header.flags & !FLAG_NORMALS != 0 || header._zero != [0; 9] {
        return Err(BlockError::Reserved);
    }
    let depth_max = DEPTH_MAX as u16;
    let leaves_only = header.refs == 0;
    if !(1..=depth_max).contains(&header.height)
        || !(1..=depth_max).contains(&header.nesting)
        || leaves_only != (header.nesting == 1)
    {
        return Err(BlockError::Depth);
    }
    Ok(())
}

#[cfg_attr(feature = "bundles", inline(always))]
fn parts(view: &BlockView<'_>) -> Result<(), BlockError> {
    let header = view.header();
    if header.nodes == 0 || header.refs > 4096 {
        return Err(BlockError::Counts);
    }
    let (before, behind) = view.padding().ok_or(BlockError::Counts)?;
    if is_zero(before) & is_zero(behind) { Ok(()) } else { Err(BlockError::Reserved) }
}

/// Whether all words are zero. Without an early end that is a few instructions for many of them.
#[cfg_attr(feature = "bundles", inline(always))]
fn is_zero(words: &[u32]) -> bool {
    let mut any = 0;
    for word in words {
        any |= word;
    }
    any == 0
}

#[cfg_attr(feature = "bundles", inline(always))]
fn vertices(view: &BlockView<'_>) -> Result<(), BlockError> {
    if inside(view.vertices().as_flattened()) {
        return Ok(());
    }
    let vertex = view.vertices().iter().position(|vertex| !inside(vertex));
    Err(BlockError::Vertex { vertex: vertex.unwrap_or_default() as u16 })
}

/// Whether coordinates lie in the scene's box.
#[cfg_attr(feature = "bundles", inline(always))]
fn inside(words: &[f32]) -> bool {
    let mut all = true;
    for x in words {
        all &= x.abs() <= 1.0;
    }
    all
}

#[cfg_attr(feature = "bundles", inline(always))]
fn records(view: &BlockView<'_>, limits: &BlockLimits) -> Result<(), BlockError> {
    let (all, vertices) = (view.records(), view.vertices());
    let mut spheres = false;
    for record in all {
        spheres |= is_sphere(record);
    }
    if spheres && !cfg!(feature = "sphere") {
        return Err(BlockError::SpheresLeftOut);
    }
    // Lanes look at several records at once: without an early end and without branches.
    let mut known = cfg!(feature = "bundles");
    if known {
        for record in all {
            known &= sound(record, view, limits);
        }
    }
    if known && !spheres {
        return Ok(());
    }
    let wrong = |record: &Record| {
        !(known || sound(record, view, limits))
            || spheres && is_sphere(record) && !round(record, vertices)
    };
    match all.iter().position(wrong) {
        Some(record) => Err(BlockError::Record { record: record as u16 }),
        None => Ok(()),
    }
}

#[inline(always)]
fn is_sphere(record: &Record) -> bool {
    record.base & RECORD_SPHERES != 0
}

/// Whether a record is, but for the places of its spheres.
#[cfg_attr(feature = "bundles", inline(always))]
fn sound(record: &Record, view: &BlockView<'_>, limits: &BlockLimits) -> bool {
    let is_known = u32::from(record.material) < limits.materials;
    is_known & primitives(record, view.header().vertices)
}

/// Whether a record holds at least one primitive, its unused places come last, and its indices are
/// in range.
///
/// Its twelve bytes are taken as three words, of which a shift lays each byte over the one before it.
#[cfg_attr(feature = "bundles", inline(always))]
fn primitives(record: &Record, vertices: u16) -> bool {
    let [x, y, z]: [u32; 3] = bytemuck::cast(record.index);
    let [x, y, z] = [x, y, z].map(u32::from_le);
    // A place is used if its three bytes differ: the first two or the last two do.
    let is_used = |triple: u32| u32::from((triple ^ triple >> 8) & 0xffff != 0);
    let used = is_used(x)
        | is_used(x >> 24 | y << 8) << 1
        | is_used(y >> 16 | z << 16) << 2
        | is_used(z >> 8) << 3;
    // Spheres leave the third index free. Unused places name the same vertex three times; it must exist as well, so that lanes may load it.
    let free = 0_u32.wrapping_sub(u32::from(cfg!(feature = "sphere") && is_sphere(record)));
    let indices = [x & !(free & 0x00ff_0000), y & !(free & 0x0000_ff00), z & !(free & 0xff00_00ff)];
    // Vertices from the base on: a byte that leads to none of them carries into the byte above it, which is free.
    let count = u32::from(vertices).saturating_sub(u32::from(record.base & !RECORD_SPHERES));
    let carry = 256_u32.saturating_sub(count) * 0x0001_0001;
    let mut over = 0;
    for word in indices {
        over |= ((word & 0x00ff_00ff) + carry) | ((word >> 8 & 0x00ff_00ff) + carry);
    }
    (used & 1 != 0) & (used & (used + 1) == 0) & (over & 0x0100_0100 == 0)
}

/// Whether the spheres of a record are spheres.
fn round(record: &Record, vertices: &[[f32; 3]]) -> bool {
    let base = usize::from(record.base & !RECORD_SPHERES);
    let vertex = |i: u8| vertices.get(base + usize::from(i));
    record.index.iter().filter(|[a, b, c]| (a != b) | (a != c)).fold(true, |all, &[a, b, _]| {
        let Some((&[x, y, z], &[radius, inward, zero])) = vertex(a).zip(vertex(b)) else {
            return false;
        };
        let inside = x.abs().max(y.abs()).max(z.abs()) + radius <= 1.001;
        all & (radius > 0.0) & inside & ((inward == 0.0) | (inward == 1.0)) & (zero == 0.0)
    })
}

#[cfg_attr(feature = "bundles", inline(always))]
fn refs(view: &BlockView<'_>, block: u32, limits: &BlockLimits) -> Result<(), BlockError> {
    for (index, r) in (0u16..).zip(view.refs()) {
        let ahead = r.block > block && r.block < limits.blocks;
        if !ahead || usize::from(r.node) >= NODES_MAX || r._zero != 0 {
            return Err(BlockError::Ref { index });
        }
    }
    Ok(())
}

/// Children lie behind their parents, no node has two parents, and no path is longer than the
/// header says.
#[cfg_attr(feature = "bundles", inline(always))]
fn tree(view: &BlockView<'_>) -> Result<(), BlockError> {
    let header = view.header();
    let (below, records_at) = (limits_of(header), view.records_at() as u16);
    // Levels above each node, by index; roots keep 0. A node with a parent has 1 or more. What is no node has the last place.
    let mut above = [0u8; NODES_MAX + 1];
    for (i, node) in (0u16..).zip(view.nodes()) {
        let levels = above.get(usize::from(i)).copied().unwrap_or(0) + 1;
        if u16::from(levels) > header.height {
            return Err(BlockError::Depth);
        }
        let mut orders = true;
        for &word in &node.order {
            orders &= is_order(word);
        }
        if !orders {
            return Err(BlockError::Order { node: i });
        }
        // No one foresees what a child is: it is not branched upon.
        let (mut wrong, mut refs) = (0_u32, false);
        for &bits in &node.child {
            let (kind, index) = (bits >> 12, bits & 0xfff);
            // The records of a leaf are counted from the begin of the block.
            let index = if kind & LEAF != 0 { index.wrapping_sub(records_at) } else { index };
            let is_node = kind == NODE;
            let place = if is_node { usize::from(index) } else { NODES_MAX };
            // One bit for each slot, of the first the lowest.
            wrong >>= 1;
            let Some(above) = above.get_mut(place) else {
                wrong |= 0x80;
                continue;
            };
            let out = below.get(usize::from(kind)).is_none_or(|&below| index >= below);
            let taken = is_node & ((index <= i) | (*above != 0));
            wrong |= u32::from(out | taken) << 7;
            *above = levels;
            refs |= kind == REF;
        }
        if wrong != 0 {
            return Err(BlockError::Child { node: i, slot: wrong.trailing_zeros() as u8 });
        }
        if refs && u16::from(levels) >= header.height {
            return Err(BlockError::Depth);
        }
    }
    Ok(())
}

/// The upper four bits of a child that is a node of this block, and of one of another.
const NODE: u16 = 0;
const REF: u16 = 1;
/// Among them, of a leaf.
const LEAF: u16 = 4;

/// By the upper four bits of a child: what its lower twelve are below. Nothing is below 0.
fn limits_of(header: &BlockHeader) -> [u16; 16] {
    let leaf = |more: u16| header.records.saturating_sub(more);
    let [a, b, c, d] = [0, 1, 2, 3].map(leaf);
    [header.nodes, header.refs, 0, 1, a, b, c, d, 0, 0, 0, 0, 0, 0, 0, 0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// [`primitives`], word by word of its description.
    fn described(record: &Record, vertices: u16) -> bool {
        let spheres = cfg!(feature = "sphere") && is_sphere(record);
        let base = usize::from(record.base & !RECORD_SPHERES);
        let exists = |i: u8| base + usize::from(i) < usize::from(vertices);
        let is_used = |[a, b, c]: [u8; 3]| !(a == b && b == c);
        let first_unused = record.index.iter().position(|&triple| !is_used(triple)).unwrap_or(4);
        first_unused > 0
            && record.index[first_unused..].iter().all(|&triple| !is_used(triple))
            && record
                .index
                .iter()
                .all(|&[a, b, c]| exists(a) && exists(b) && (spheres || exists(c)))
    }

    proptest! {
        #[test]
        fn records_are_what_is_described(
            index in prop::array::uniform4(prop_oneof![
                prop::array::uniform3(any::<u8>()),
                prop::array::uniform3(0..4_u8),
                any::<u8>().prop_map(|i| [i; 3]),
                (any::<u8>(), any::<u8>()).prop_map(|(a, b)| [a, a, b]),
                (any::<u8>(), any::<u8>()).prop_map(|(a, b)| [a, b, b]),
            ]),
            used in 0_usize..5,
            base in prop_oneof![Just(0), 0..400_u16, any::<u16>()],
            spheres: bool,
            room in prop_oneof![(-2_i32..270).prop_map(|room| (0, room)), (-1_i32..3).prop_map(|more| (1, more))],
        ) {
            let mut record = Record { index, base, material: 0 };
            // Half of them as the compiler makes them: what is unused comes last.
            if used > 0 {
                record.index[used..].iter_mut().for_each(|triple| *triple = [triple[0]; 3]);
            }
            record.base = base & !RECORD_SPHERES | if spheres { RECORD_SPHERES } else { 0 };
            // Any number of vertices, or about as many as are named.
            let greatest = record.index.as_flattened().iter().copied().max().map_or(0, i32::from);
            let room = room.0 * greatest + room.1;
            let vertices = (i32::from(base & !RECORD_SPHERES) + room).clamp(0, 65535) as u16;
            prop_assert_eq!(primitives(&record, vertices), described(&record, vertices));
        }
    }
}
