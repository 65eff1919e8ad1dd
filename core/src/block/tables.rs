//! The checks of the file's tables.

use super::file::{FileError, Table};
use super::format::FileHeader;
#[cfg(feature = "many-lights")]
use crate::scene::LightNode;
use crate::scene::{Light, LightKind, Material, MaterialKind, Needs, View, ViewKind};

/// Checks every entry of the four tables.
pub(super) fn check(
    materials: &[Material],
    lights: &[Light],
    views: &[View],
    needs: &[Needs],
) -> Result<(), FileError> {
    all(Table::Materials, materials, |m| material(m, lights.len()))?;
    all(Table::Lights, lights, |l| light(l, materials.len()))?;
    all(Table::Views, views, view)?;
    all(Table::Needs, needs, |n| n.radiance_max >= 0.0 && n.radiance_max.is_finite())
}

/// Units of frames are powers of two that f64 holds, and one over them too.
const EXPONENT_MAX: u32 = 1020;

/// The numbers of the header that are no sizes or offsets.
pub(super) fn header_is_sound(header: &FileHeader) -> bool {
    header._zero == [0; 2]
        && finite(&header.lo)
        && finite(&header.hi)
        && header.frame.center.iter().all(|c| c.is_finite())
        && header.frame.position_error >= 0.0
        && header.frame.exponent.unsigned_abs() <= EXPONENT_MAX
}

fn all<T>(table: Table, entries: &[T], sound: impl Fn(&T) -> bool) -> Result<(), FileError> {
    match entries.iter().position(|entry| !sound(entry)) {
        Some(entry) => Err(FileError::Table { table, entry: entry as u32 }),
        None => Ok(()),
    }
}

fn material(m: &Material, lights: usize) -> bool {
    let amounts = [m.diffuse, m.specular, m.transmit, m.absorption, m.emission];
    MaterialKind::from_u32(m.kind).is_some()
        && amounts.iter().all(not_negative)
        && not_negative(&[m.roughness, m.ior, m.transmit_specular])
        && m.light as usize <= lights
}

fn light(l: &Light, materials: usize) -> bool {
    LightKind::from_u32(l.kind).is_some()
        && (l.material == u32::MAX || (l.material as usize) < materials)
        && l.reach >= 0.0
        && [l.position, l.u, l.v, l.cone].iter().all(finite)
        && not_negative(&l.radiance)
        && l.focus >= 0.0
        && finite(&[l.cone_cos, l.focus, 0.0])
}

/// Checks a tree of so many lights: that each node ends where its second child does, and that there are as many leaves as lights.
#[cfg(feature = "many-lights")]
pub(super) fn check_tree(nodes: &[LightNode], lights: usize) -> Result<(), FileError> {
    if nodes.is_empty() {
        return Ok(());
    }
    let end = |index: u32| nodes.get(index as usize).map(|node| node.end(index));
    let mut leaves = 0_usize;
    for (index, node) in (0_u32..).zip(nodes) {
        let is_in_place = if let Some(light) = node.light() {
            leaves = leaves.saturating_add(1);
            (light as usize) < lights
        } else {
            let second = end(index.saturating_add(1)).filter(|&second| second < node.next);
            second.and_then(end) == Some(node.next)
        };
        let numbers = [node.radius, node.power, node.reach, node.mean_cos];
        let is_sound = is_in_place
            && finite(&node.center)
            && finite(&node.axis)
            && numbers.iter().all(|&x| x >= 0.0)
            && node.power.is_finite()
            && (-1.0..=1.0).contains(&node.cone_cos);
        if !is_sound {
            return Err(FileError::Table { table: Table::LightTree, entry: index });
        }
    }
    let entry = nodes.len() as u32;
    if leaves == lights { Ok(()) } else { Err(FileError::Table { table: Table::LightTree, entry }) }
}

fn view(v: &View) -> bool {
    let unit = |d: &[f32; 3]| {
        let square: f32 = d.iter().map(|x| x * x).sum();
        (0.99..1.01).contains(&square)
    };
    ViewKind::from_u32(v.kind).is_some()
        && finite(&v.position)
        && unit(&v.direction)
        && finite(&v.up)
        && v.size.iter().all(|&s| s > 0.0 && s.is_finite())
        && v.offset.iter().all(|o| o.is_finite())
        && v.clip.iter().all(|&c| c >= 0.0 && c.is_finite())
}

fn finite(v: &[f32; 3]) -> bool {
    v.iter().all(|x| x.is_finite())
}

fn not_negative(v: &[f32; 3]) -> bool {
    v.iter().all(|&x| x >= 0.0 && x.is_finite())
}
