//! Reads a compiled scene back and holds it against its model, by other means than the compiler's.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use kiloray_core::block::format::{Child, RECORD_SPHERES, Record};
use kiloray_core::block::{BlockView, KiloView, octahedral};
use kiloray_core::geometry::Aabb;

use crate::compile::Compiled;
use crate::kilo::KiloFile;
use crate::model::{Model, NO_NORMAL};

/// A primitive by its bits: material, sphere or not, vertices in order, codes of normals.
type Found = (u16, bool, [[u32; 3]; 3], [u32; 3]);

/// Every primitive of the model is in the blocks exactly once, in its place, and every box on the
/// way to it holds it; header counts are true.
pub(super) fn check(model: &Model, compiled: &Compiled) {
    let file = KiloFile::from_bytes(compiled.bytes()).unwrap();
    let view = file.view();
    let mut walk = Walk { view: &view, found: BTreeMap::new(), deepest: 0, longest: 0 };
    if view.blocks() > 0 {
        walk.node(0, 0, None, 1, 1);
    }
    let mut expected = expected(model, &view);
    let total = |map: &BTreeMap<Found, u64>| map.values().sum::<u64>();
    assert_eq!(total(&walk.found), u64::from(view.header().primitives));
    assert_eq!(total(&walk.found), compiled.stats.triangles + compiled.stats.spheres);
    for (found, count) in walk.found {
        assert_eq!(expected.remove(&found), Some(count), "{found:?}");
    }
    assert!(expected.is_empty(), "left out: {expected:?}");
    if view.blocks() > 0 {
        let root = view.trusted_block(0).unwrap();
        assert_eq!(u32::from(root.header().height), walk.deepest);
        assert_eq!(u32::from(root.header().nesting), walk.longest);
    }
    let used = (compiled.stats.fill() * 1e6) as u64;
    assert!(view.blocks() == 0 || used > 0 && used <= 1_000_000);
}

struct Walk<'a> {
    view: &'a KiloView<'a>,
    found: BTreeMap<Found, u64>,
    deepest: u32,
    longest: u32,
}

impl Walk<'_> {
    /// `within`, the box of the slot that leads here, in f64.
    fn node(
        &mut self,
        block: u32,
        node: u16,
        within: Option<[[f64; 3]; 2]>,
        levels: u32,
        blocks: u32,
    ) {
        let content = self.view.trusted_block(block).unwrap();
        self.deepest = self.deepest.max(levels);
        self.longest = self.longest.max(blocks);
        let stored = content.node(node).unwrap();
        for slot in 0..8 {
            let own = slot_box(&content, node, slot);
            match Child::decode(stored.child[slot]) {
                Child::Empty => {
                    for axis in 0..3 {
                        assert_eq!((stored.lo[axis][slot], stored.hi[axis][slot]), (65535, 0));
                    }
                    continue;
                }
                Child::Node(kid) => self.node(block, kid, Some(own), levels + 1, blocks),
                Child::Ref(r) => {
                    let r = content.reference(r).unwrap();
                    assert!(r.block > block);
                    self.node(r.block, r.node, Some(own), levels + 1, blocks + 1);
                }
                Child::Leaf { at, count } => {
                    for record in content.leaf(at, count) {
                        self.record(&content, record, own);
                    }
                }
            }
            if let Some([lo, hi]) = within {
                // The box of a child may be coarser than its parent's where blocks differ, but not
                // by more than their steps.
                let step = DVec3::from_array(content.header().scale.map(f64::from)) + 1e-4;
                assert!(DVec3::from_array(own[0]).cmpge(DVec3::from_array(lo) - step).all());
                assert!(DVec3::from_array(own[1]).cmple(DVec3::from_array(hi) + step).all());
            }
        }
    }

    fn record(&mut self, content: &BlockView<'_>, record: &Record, within: [[f64; 3]; 2]) {
        let spheres = record.base & RECORD_SPHERES != 0;
        let base = usize::from(record.base & !RECORD_SPHERES);
        for [a, b, c] in record.index {
            if a == b && b == c {
                continue;
            }
            let at = [a, b, c].map(|i| base + usize::from(i));
            let vertices = at.map(|i| content.vertex(i).unwrap());
            let normals = at.map(|i| content.normal(i).unwrap_or(octahedral::NONE));
            let own = if spheres {
                Aabb::of_sphere(vertices[0], vertices[1].x)
            } else {
                Aabb::of_triangle(vertices)
            };
            let [min, max] = [own.min.as_dvec3(), own.max.as_dvec3()];
            assert!(DVec3::from_array(within[0]).cmple(min).all());
            assert!(DVec3::from_array(within[1]).cmpge(max).all());
            let bits = vertices.map(|v| v.to_array().map(f32::to_bits));
            let found = (record.material, spheres, bits, normals);
            let found =
                if spheres { (found.0, true, [bits[0], bits[1], bits[0]], [0; 3]) } else { found };
            *self.found.entry(found).or_default() += 1;
        }
    }
}

/// The box of a slot: once in f64, and as an f32 evaluation has it, which must be the same.
fn slot_box(content: &BlockView<'_>, node: u16, slot: usize) -> [[f64; 3]; 2] {
    let (header, node) = (content.header(), content.node(node).unwrap());
    [&node.lo, &node.hi].map(|q| {
        std::array::from_fn(|axis| {
            let q = q[axis][slot];
            let exact =
                f64::from(header.origin[axis]) + f64::from(header.scale[axis]) * f64::from(q);
            let rounded = header.origin[axis] + header.scale[axis] * f32::from(q);
            assert_eq!(exact, f64::from(rounded));
            exact
        })
    })
}

fn expected(model: &Model, view: &KiloView<'_>) -> BTreeMap<Found, u64> {
    let frame = view.header().frame;
    let scale = 2f64.powi(-frame.exponent);
    let center = DVec3::from_array(frame.center);
    let place = |p: DVec3| ((p - center) * scale).as_vec3() + Vec3::ZERO;
    let bits = |v: Vec3| v.to_array().map(f32::to_bits);
    // With the model's materials first.
    let mut found: Vec<Found> = Vec::new();
    for t in &model.triangles {
        let v = t.vertices.map(|i| bits(place(model.vertices[i as usize])));
        if v[0] == v[1] || v[1] == v[2] || v[2] == v[0] {
            continue;
        }
        let normals = t.normals.map(|n| match n {
            NO_NORMAL => octahedral::NONE,
            n => octahedral::encode(model.normals[n as usize].as_vec3()),
        });
        found.push((t.material, false, v, normals));
    }
    for s in &model.spheres {
        let radius = (s.radius * scale) as f32;
        let shape = [radius, if s.inward { 1.0 } else { 0.0 }, -0.0].map(f32::to_bits);
        let center = bits(place(s.center));
        if radius > 0.0 {
            found.push((s.material, true, [center, shape, center], [0; 3]));
        }
    }
    // Materials that are used keep their order.
    let mut used: Vec<u16> = found.iter().map(|f| f.0).collect();
    used.extend(model.lights.iter().filter_map(|l| l.material));
    used.sort_unstable();
    used.dedup();
    let mut expected = BTreeMap::new();
    for (material, spheres, vertices, normals) in found {
        let material = used.binary_search(&material).unwrap() as u16;
        *expected.entry((material, spheres, vertices, normals)).or_default() += 1;
    }
    expected
}
