//! The checks of a block on arrival: after them, every index in it leads somewhere.

use super::error::BlockError;
use super::format::{
    BLOCK_BYTES_MAX, BLOCK_BYTES_MIN, BlockHeader, Child, DEPTH_MAX, FLAG_NORMALS, Node,
    RECORD_SPHERES, Record, is_order,
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

fn parts(view: &BlockView<'_>) -> Result<(), BlockError> {
    let header = view.header();
    if header.nodes == 0
        || usize::from(header.nodes) > NODES_MAX
        || header.records > 4096
        || header.refs > 4096
        || view.content_end() + 4 > view.bytes().len()
    {
        return Err(BlockError::Counts);
    }
    // Without an early end these loops are a few instructions for many bytes.
    match view.bytes().get(view.content_end()..) {
        Some(padding) if padding.iter().fold(0, |all, byte| all | byte) == 0 => Ok(()),
        _ => Err(BlockError::Reserved),
    }
}

fn vertices(view: &BlockView<'_>) -> Result<(), BlockError> {
    let inside = |words: &[f32]| words.iter().fold(true, |all, x| all & (x.abs() <= 1.0));
    if inside(view.vertices().as_flattened()) {
        return Ok(());
    }
    let vertex = view.vertices().iter().position(|vertex| !inside(vertex));
    Err(BlockError::Vertex { vertex: vertex.unwrap_or_default() as u16 })
}

fn records(view: &BlockView<'_>, limits: &BlockLimits) -> Result<(), BlockError> {
    let vertices = view.vertices();
    for (i, record) in (0u16..).zip(view.records()) {
        let spheres = record.base & RECORD_SPHERES != 0;
        if spheres && !cfg!(feature = "sphere") {
            return Err(BlockError::SpheresLeftOut);
        }
        let known = u32::from(record.material) < limits.materials;
        let sound = primitives(record, vertices.len()) && (!spheres || round(record, vertices));
        if !known || !sound {
            return Err(BlockError::Record { record: i });
        }
    }
    Ok(())
}

/// Whether a record holds at least one primitive, its unused places come last, and its indices are
/// in range.
#[inline]
fn primitives(record: &Record, vertices: usize) -> bool {
    // Spheres leave the third index free.
    let spheres = record.base & RECORD_SPHERES != 0;
    let (mut used, mut greatest) = (0_u8, 0);
    for (place, &[a, b, c]) in record.index.iter().enumerate() {
        used |= u8::from((a != b) | (a != c)) << place;
        // Unused places name the same vertex three times; it must exist as well, so that lanes may load it.
        greatest = greatest.max(a).max(b).max(if spheres { a } else { c });
    }
    let base = usize::from(record.base & !RECORD_SPHERES);
    used != 0 && used & (used + 1) == 0 && base + usize::from(greatest) < vertices
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
fn tree(view: &BlockView<'_>) -> Result<(), BlockError> {
    let header = view.header();
    // Levels above each node, by index; roots keep 0. A node with a parent has 1 or more.
    let mut above = [0u8; NODES_MAX];
    for (i, node) in (0u16..).zip(view.nodes()) {
        let levels = above.get(usize::from(i)).copied().unwrap_or(0) + 1;
        if u16::from(levels) > header.height {
            return Err(BlockError::Depth);
        }
        if !node.order.iter().fold(true, |all, &word| all & is_order(word)) {
            return Err(BlockError::Order { node: i });
        }
        for (slot, &bits) in (0u8..).zip(&node.child) {
            let wrong = Err(BlockError::Child { node: i, slot });
            match Child::decode(bits) {
                _ if bits & 0x8000 != 0 => return wrong,
                Child::Empty if bits == Child::EMPTY => {}
                Child::Empty => return wrong,
                Child::Node(child) => match above.get_mut(usize::from(child)) {
                    Some(above) if child > i && child < header.nodes && *above == 0 => {
                        *above = levels;
                    }
                    _ => return wrong,
                },
                Child::Leaf { first, count } => {
                    if first + count > header.records {
                        return wrong;
                    }
                }
                Child::Ref(index) => {
                    if index >= header.refs {
                        return wrong;
                    }
                    if u16::from(levels) >= header.height {
                        return Err(BlockError::Depth);
                    }
                }
            }
        }
    }
    Ok(())
}
