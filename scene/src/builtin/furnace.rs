use core::f64::consts::PI;
use std::collections::BTreeMap;

use glam::DVec3;

use super::shape::{Shaper, matt};

pub(super) fn surfaces(n: u64) -> u64 {
    8 << (2 * n)
}

/// A convex ball of flat facets in light of radiance 1 from everywhere. No facet sees another, so
/// the reflected radiance is the reflectance, exactly: every pixel is ½ on the ball and 1 beside it.
pub(super) fn build(s: &mut Shaper, n: u32) {
    let grey = s.material(matt("grey", [0.5, 0.5, 0.5]));
    let mut vertices = vec![DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
    let mut faces: Vec<[u32; 3]> = vec![
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    for _ in 0..n {
        let mut middles = BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                vertices.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    s.facets(&vertices, &faces, grey);
    s.distant(DVec3::Z, PI, DVec3::ONE);
    s.view(DVec3::new(2.2, -3.6, 1.6), DVec3::ZERO, 36.0, 1.0);
}
