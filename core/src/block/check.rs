//! The checks of a block on arrival: after them, every index in it leads somewhere.

use super::error::BlockError;
use super::format::{
    BLOCK_BYTES_MAX, BLOCK_BYTES_MIN, BlockHeader, Child, DEPTH_MAX, FLAG_NORMALS, Node,
    RECORD_SPHERES, Record,
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
    match view.bytes().get(view.content_end()..) {
        Some(padding) if padding.iter().all(|&b| b == 0) => Ok(()),
        _ => Err(BlockError::Reserved),
    }
}

fn vertices(view: &BlockView<'_>) -> Result<(), BlockError> {
    match view.vertices().iter().position(|v| !v.iter().all(|x| x.abs() <= 1.0)) {
        Some(vertex) => Err(BlockError::Vertex { vertex: vertex as u16 }),
        None => Ok(()),
    }
}

fn records(view: &BlockView<'_>, limits: &BlockLimits) -> Result<(), BlockError> {
    for (i, record) in (0u16..).zip(view.records()) {
        let spheres = record.base & RECORD_SPHERES != 0;
        if spheres && !cfg!(feature = "sphere") {
            return Err(BlockError::SpheresLeftOut);
        }
        let known = u32::from(record.material) < limits.materials;
        if !known || !primitives(view, record, spheres) {
            return Err(BlockError::Record { record: i });
        }
    }
    Ok(())
}

/// Whether a record holds at least one primitive, its unused places come last, and its indices are
/// in range.
fn primitives(view: &BlockView<'_>, record: &Record, spheres: bool) -> bool {
    let base = usize::from(record.base & !RECORD_SPHERES);
    let vertex = |i: u8| view.vertices().get(base + usize::from(i));
    let used = |t: &[u8; 3]| t.iter().any(|i| Some(i) != t.first());
    let count = record.index.iter().take_while(|t| used(t)).count();
    let [first, ..] = &record.index;
    // Spheres leave the third index free. Unused places name the same vertex three times; it must
    // exist as well, so that lanes may load it.
    let in_range = record.index.iter().all(|&[a, b, c]| {
        vertex(a).is_some() && vertex(b).is_some() && (spheres || vertex(c).is_some())
    });
    let round = record.index.iter().filter(|t| spheres && used(t)).all(|&[a, b, _]| {
        let Some((center, &[radius, inward, zero])) = vertex(a).zip(vertex(b)) else {
            return false;
        };
        let inside = center.iter().all(|c| c.abs() + radius <= 1.001);
        radius > 0.0 && inside && (inward == 0.0 || inward == 1.0) && zero == 0.0
    });
    used(first) && !record.index.iter().skip(count).any(used) && in_range && round
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
        for (slot, &bits) in (0u8..).zip(&node.child) {
            let wrong = Err(BlockError::Child { node: i, slot });
            if bits & 0x8000 != 0 && slot >= 6 {
                return wrong;
            }
            match Child::decode(bits) {
                Child::Empty if bits & 0x7fff == Child::Empty.encode() => {}
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
