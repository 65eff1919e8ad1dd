//! The tree of very many lights, so that a point need not look at each.

use glam::DVec3;
use kiloray_core::light::Aim;
use kiloray_core::scene::{Light, LightKind, LightNode};

/// So many are looked at one by one: a choice by the tree is coarser, and no quicker.
const FEW: usize = 64;
/// Parts of an axis between which a split is looked for.
const BINS: usize = 12;
/// From so many levels on lights are split in two halves: each split may leave one light on its side, and there may be 2³¹ nodes.
const DEPTH: usize = 40;

/// The nodes of the tree, in the order of [`LightNode`]; none if the lights are few.
pub(crate) fn light_tree(lights: &[Light]) -> Vec<LightNode> {
    let mut nodes = Vec::new();
    if lights.len() > FEW {
        let mut near = Vec::new();
        for (light, index) in lights.iter().zip(0..) {
            match Item::of(light, index) {
                Some(item) => near.push(item),
                // What is infinitely far is near nothing: a root for each.
                None => nodes.push(LightNode {
                    radius: f32::INFINITY,
                    reach: f32::INFINITY,
                    next: LightNode::LEAF | index,
                    ..enclosing(&[])
                }),
            }
        }
        if !near.is_empty() {
            grow(&mut near, 0, &mut nodes);
        }
    }
    nodes
}

/// A light of the tree.
#[derive(Debug, Clone, Copy)]
struct Item {
    index: u32,
    center: DVec3,
    /// Of a sphere that holds it.
    radius: f64,
    /// Of what shines to one side.
    normal: Option<DVec3>,
    /// See [`LightNode::power`].
    power: f64,
    reach: f32,
}

impl Item {
    fn of(light: &Light, index: u32) -> Option<Self> {
        let kind = LightKind::from_u32(light.kind)?;
        let [u, v] = [light.u, light.v].map(|v| DVec3::from(v.map(f64::from)));
        let brightest = f64::from(light.radiance.into_iter().fold(0.0, f32::max));
        let square = u.length_squared() + v.length_squared();
        let normal = u.cross(v);
        let (radius, area, normal) = match kind {
            LightKind::Parallelogram => ((0.5 * square).sqrt(), normal.length(), Some(normal)),
            LightKind::Triangle => (square.sqrt(), 0.5 * normal.length(), Some(normal)),
            LightKind::Disc => {
                (square.sqrt(), std::f64::consts::PI * normal.length(), Some(normal))
            }
            LightKind::Sphere => (u.x, std::f64::consts::PI * u.x * u.x, None),
            LightKind::Point | LightKind::Spot => (0.0, 1.0, None),
            LightKind::Distant => return None,
        };
        Some(Self {
            index,
            center: Aim::center(light).as_dvec3(),
            radius,
            normal: normal.and_then(DVec3::try_normalize),
            power: brightest * area,
            reach: light.reach,
        })
    }
}

/// Adds the node of these lights, which are some, and all below.
fn grow(items: &mut [Item], depth: usize, nodes: &mut Vec<LightNode>) {
    let at = nodes.len();
    nodes.push(enclosing(items));
    if let [item] = items {
        nodes[at].next = LightNode::LEAF | item.index;
        return;
    }
    let half = items.len() / 2;
    let middle = if depth < DEPTH { split(items).unwrap_or(half) } else { half };
    let (first, second) = items.split_at_mut(middle);
    grow(first, depth + 1, nodes);
    grow(second, depth + 1, nodes);
    nodes[at].next = nodes.len() as u32;
}

/// A node that holds these lights.
fn enclosing(items: &[Item]) -> LightNode {
    let all = items.iter().fold(Group::EMPTY, |all, item| all.with(item));
    // Their centre of power: what is nearer then counts as much more as what is farther counts less.
    let center = if all.power > 0.0 { all.centers / all.power } else { DVec3::ZERO }.as_vec3();
    let reaches = |item: &Item| item.center.distance(center.as_dvec3()) + item.radius;
    let radius = items.iter().map(reaches).fold(0.0, f64::max);
    let is_aligned = items.iter().all(|item| item.normal.is_some());
    let axis = all.normals.try_normalize().filter(|_| is_aligned);
    let axis = axis.unwrap_or(DVec3::Z).as_vec3();
    let cos = |item: &Item| item.normal.map_or(-1.0, |normal| normal.dot(axis.as_dvec3()));
    let cone_cos = items.iter().map(cos).fold(1.0, f64::min);
    LightNode {
        center: center.to_array(),
        // Rounded up.
        radius: (radius * (1.0 + 1e-6)) as f32,
        power: all.power.min(f64::from(f32::MAX)) as f32,
        axis: axis.to_array(),
        mean_cos: if is_aligned { all.aligned() as f32 } else { 0.0 },
        cone_cos: (cone_cos - 1e-6).max(-1.0) as f32,
        reach: items.iter().map(|item| item.reach).fold(0.0, f32::max),
        next: 0,
    }
}

/// Some lights, for what it costs to have them in one node.
#[derive(Debug, Clone, Copy)]
struct Group {
    lo: DVec3,
    hi: DVec3,
    power: f64,
    /// The sums of the centres and of the normals, by power.
    centers: DVec3,
    normals: DVec3,
    count: usize,
}

impl Group {
    const EMPTY: Self = Self {
        lo: DVec3::INFINITY,
        hi: DVec3::NEG_INFINITY,
        power: 0.0,
        centers: DVec3::ZERO,
        normals: DVec3::ZERO,
        count: 0,
    };

    fn with(self, item: &Item) -> Self {
        Self {
            lo: self.lo.min(item.center - item.radius),
            hi: self.hi.max(item.center + item.radius),
            power: self.power + item.power,
            centers: self.centers + item.center * item.power,
            normals: self.normals + item.normal.unwrap_or(DVec3::ZERO) * item.power,
            count: self.count + 1,
        }
    }

    fn and(self, other: Self) -> Self {
        Self {
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
            power: self.power + other.power,
            centers: self.centers + other.centers,
            normals: self.normals + other.normals,
            count: self.count + other.count,
        }
    }

    /// Power times size squared, and up to twice that if they shine in all directions (after the surface-area orientation heuristic of Conty & Kulla 2018).
    fn cost(&self) -> f64 {
        if self.count == 0 {
            return f64::INFINITY;
        }
        self.power * (self.hi - self.lo).length_squared() * (2.0 - self.aligned())
    }

    /// The mean cosine between the normals and their mean.
    fn aligned(&self) -> f64 {
        if self.power > 0.0 { self.normals.length() / self.power } else { 0.0 }
    }
}

/// Sorts the lights into two parts that cost least together: the length of the first. `None` if no plane separates any.
fn split(items: &mut [Item]) -> Option<usize> {
    let ends = items.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), item| {
        (lo.min(item.center), hi.max(item.center))
    });
    let size = ends.1 - ends.0;
    let bin = |item: &Item, axis: usize| {
        let part = (item.center[axis] - ends.0[axis]) / size[axis];
        ((part * BINS as f64) as usize).min(BINS - 1)
    };
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| size[axis] > 0.0) {
        let mut bins = [Group::EMPTY; BINS];
        for item in &*items {
            let place = &mut bins[bin(item, axis)];
            *place = place.with(item);
        }
        // Long thin parts are no good whatever they cost.
        let thinness = size.max_element() / size[axis];
        for plane in 1..BINS {
            let group = |bins: &[Group]| bins.iter().fold(Group::EMPTY, |all, bin| all.and(*bin));
            let (first, second) = (group(&bins[..plane]), group(&bins[plane..]));
            if first.count == 0 || second.count == 0 {
                continue;
            }
            let cost = (first.cost() + second.cost()) * thinness;
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, plane));
            }
        }
    }
    let (_, axis, plane) = best?;
    items.sort_by_key(|item| bin(item, axis) >= plane);
    Some(items.partition_point(|item| bin(item, axis) < plane))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use bytemuck::Zeroable;
    use kiloray_core::block::format::FileHeader;
    use kiloray_core::block::{FileError, KiloView, Table};
    use kiloray_core::scene::Needs;

    use super::*;
    use crate::kilo::{Image, Tables};

    /// Lights of all kinds on a ball, in its middle and infinitely far.
    fn lights(count: u32) -> Vec<Light> {
        let mut random = fastrand::Rng::with_seed(5);
        let mut vector = || [0; 3].map(|_| random.f32() - 0.5);
        let light = |k: u32| Light {
            kind: if k.is_multiple_of(50) { 6 } else { [0, 1, 2, 0, 1, 3, 4, 5][k as usize % 8] },
            material: u32::MAX,
            reach: if k.is_multiple_of(4) { 0.3 } else { f32::INFINITY },
            position: if k.is_multiple_of(9) { [0.25; 3] } else { vector() },
            u: vector().map(|x| 0.01 * x),
            v: vector().map(|x| 0.01 * x),
            radiance: [1.0, 2.0, 3.0],
            cone_cos: -1.0,
            ..Light::zeroed()
        };
        let ball = |light: Light| Light { u: light.u.map(f32::abs), ..light };
        (0..count).map(light).map(|l| if l.kind == 3 { ball(l) } else { l }).collect()
    }

    #[test]
    fn few_lights_have_no_tree() {
        assert!(light_tree(&lights(64)).is_empty() && !light_tree(&lights(65)).is_empty());
    }

    #[test]
    fn nodes_hold_the_lights_below_them() {
        for count in [65, 100, 1_000] {
            let lights = lights(count);
            let nodes = light_tree(&lights);
            let leaves: Vec<_> = nodes.iter().filter_map(LightNode::light).collect();
            assert_eq!(leaves.iter().copied().collect::<BTreeSet<_>>(), (0..count).collect());
            assert_eq!(leaves.len(), lights.len());
            let inner = (0_u32..).zip(&nodes).filter(|(_, node)| node.light().is_none());
            let mut cones = 0;
            for (index, node) in inner {
                let below = nodes[index as usize..node.end(index) as usize].iter();
                let center = DVec3::from(node.center.map(f64::from));
                let mut power = 0.0;
                for light in below.filter_map(LightNode::light).map(|i| &lights[i as usize]) {
                    let item = Item::of(light, 0).unwrap();
                    let end = item.center.distance(center) + item.radius;
                    assert!(end <= f64::from(node.radius), "{node:?} {light:?}");
                    assert!(light.reach <= node.reach);
                    let axis = DVec3::from(node.axis.map(f64::from));
                    let cos = item.normal.map_or(-1.0, |normal| normal.dot(axis));
                    assert!(cos >= f64::from(node.cone_cos), "{node:?} {light:?}");
                    power += item.power;
                }
                cones += u32::from(node.cone_cos > -1.0);
                assert!((f64::from(node.power) / power - 1.0).abs() < 1e-6);
            }
            assert!(cones > count / 20, "{cones} of {count}");
        }
    }

    #[test]
    fn a_forged_tree_is_refused() {
        let lights = lights(70);
        let nodes = light_tree(&lights);
        let bits = Needs::MANY_LIGHTS | Needs::DISTANT;
        let opened = |light_tree: &[LightNode], bits| {
            let needs = Needs { bits, radiance_max: 3.0 };
            let tables = Tables { materials: &[], lights: &lights, views: &[], light_tree, needs };
            let header = FileHeader {
                magic: kiloray_core::block::format::MAGIC,
                version: kiloray_core::block::format::VERSION,
                block_bytes: 1024,
                blocks: 1,
                ..FileHeader::zeroed()
            };
            KiloView::parse_head(Image::new(header, tables).bytes()).map(|_| ())
        };
        assert_eq!(opened(&nodes, bits), Ok(()));
        // A tree that the scene does not need, and none where it does.
        assert_eq!(opened(&nodes, Needs::DISTANT), Err(FileError::Header));
        assert_eq!(opened(&[], bits), Err(FileError::Header));
        let refused = |entry| Err(FileError::Table { table: Table::LightTree, entry });
        // A leaf less.
        let last = nodes.len() as u32 - 1;
        assert!(opened(&nodes[..last as usize], bits).is_err());
        for (index, node) in (0_u32..).zip(&nodes) {
            let forged = |forge: &dyn Fn(&mut LightNode)| {
                let mut nodes = nodes.clone();
                forge(&mut nodes[index as usize]);
                opened(&nodes, bits)
            };
            if node.light().is_some() {
                assert_eq!(forged(&|node| node.next = LightNode::LEAF | 70), refused(index));
                assert!(forged(&|node| node.next = 0).is_err());
            } else {
                for next in [0, index, index + 1, node.next - 1, node.next + 1, last + 2, u32::MAX]
                {
                    assert!(forged(&|node| node.next = next).is_err(), "{index} {next}");
                }
            }
            assert_eq!(forged(&|node| node.power = f32::NAN), refused(index));
            assert_eq!(forged(&|node| node.radius = -1.0), refused(index));
            assert_eq!(forged(&|node| node.axis[1] = f32::INFINITY), refused(index));
        }
    }
}
