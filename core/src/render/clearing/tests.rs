use super::*;
use crate::geometry::Ray;
use crate::light::Aim;
use crate::random::Sequence;
use crate::trace::tests::shared::Resident;
use crate::trace::tests::shared::scenes::Random;
use crate::trace::tests::shared::writer::{Item, triangle, write};
use crate::trace::{Cursor, Scalar, Tracer};
use bytemuck::Zeroable;
use std::vec::Vec;

/// A ground of 8 × 8 squares with steps and slopes in it, walls here and there, and what hangs above: corners in units of `scale` from `offset`.
fn scene(random: &mut Random, scale: f32, offset: Vec3) -> Vec<Item> {
    let at = |x: f32, y: f32, z: f32| (offset + Vec3::new(x, y, z) * scale).to_array();
    let mut heights = [[0.0; 9]; 9];
    let rough = [0.0, 0.0, 0.05, 0.5][random.below(4) as usize];
    heights.iter_mut().flatten().for_each(|height| *height = rough * random.signed());
    let mut items = Vec::new();
    for x in 0..8_usize {
        for y in 0..8_usize {
            let corner = |x: usize, y: usize| at(x as f32, y as f32, heights[x][y]);
            let (a, b, c, d) =
                (corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1));
            items.extend([triangle(a, b, c, 0), triangle(a, c, d, 0)]);
        }
    }
    for _ in 0..random.below(6) {
        let mut place = || 4.0 + 4.0 * random.signed();
        let (x, y, z) = (place(), place(), place() * 0.5);
        let (u, v) = (random.signed(), random.signed());
        let upright = random.below(2) == 0;
        let (b, c) =
            if upright { ((x + u, y + v, 0.0), (x, y, z)) } else { ((x + u, y, z), (x, y + v, z)) };
        let first = if upright { at(x, y, 0.0) } else { at(x, y, z) };
        items.push(triangle(first, at(b.0, b.1, b.2), at(c.0, c.1, c.2), 0));
    }
    items
}

fn lamp(random: &mut Random, scale: f32, offset: Vec3) -> Light {
    let kind = [LightKind::Parallelogram, LightKind::Triangle, LightKind::Sphere]
        [random.below(3) as usize];
    let mut place = || 4.0 + 6.0 * random.signed();
    let position = offset + Vec3::new(place(), place(), 3.0 + place().abs()) * scale;
    let size = scale * [0.01, 0.3, 2.0][random.below(3) as usize];
    // It shines down.
    let (u, v) = match kind {
        LightKind::Sphere => (Vec3::X * size, Vec3::ZERO),
        _ => (
            Vec3::new(0.1 * random.signed(), 1.0, 0.2) * size,
            Vec3::new(1.0, 0.3 * random.signed(), -0.1) * size,
        ),
    };
    Light {
        kind: kind as u32,
        position: position.into(),
        u: u.into(),
        v: v.into(),
        radiance: [1.0; 3],
        reach: f32::INFINITY,
        cone_cos: -1.0,
        focus: 0.0,
        ..Light::zeroed()
    }
}

#[test]
fn nothing_is_in_the_way_of_a_light_that_a_clearing_shows() {
    let (mut asked, mut shown) = (0, 0);
    for seed in 0..400_u64 {
        let random = &mut Random(seed << 8 | 1);
        let scale = [1e-3, 1.0, 1e3][random.below(3) as usize];
        let offset =
            Vec3::from(random.point()) * scale * [0.0, 1.0, 300.0][random.below(3) as usize];
        let items = scene(random, scale, offset);
        let blocks = write(&items, 1 << 10, 4, 64);
        let mut source = Resident(&blocks);
        let light = lamp(random, scale, offset);
        let mut clearings = Clearings::<4>::new();
        let mut cursor = Cursor::new();
        let eye = offset + Vec3::new(4.0, 4.0, 30.0) * scale;
        for point in 0..60 {
            // A walk along the ground, with as many searches as there are in a longer one.
            if point % 6 == 0 {
                clearings = Clearings::new();
            }
            let step = Vec3::new(4.0 + 0.05 * point as f32, 4.0 + random.signed(), 0.0);
            let direction = offset + step * scale - eye;
            let ray = Ray { origin: eye, direction, t_min: 0.0, t_max: f32::INFINITY };
            let hit = Scalar.closest(&mut cursor, &mut source, &ray).unwrap();
            let Some(hit) = hit else { continue };
            let surface = Surface::new(&ray, &hit, false);
            let Ok(mut aim) = Aim::new(&light, &surface, [true, false]) else { continue };
            aim.prepare();
            if light.kind != LightKind::Sphere as u32
                && aim.projected(Scalar, surface.normal).is_none()
            {
                continue;
            }
            asked += 1;
            if !clearings.show((0, &light), &surface, 16, &mut source, &mut 0) {
                continue;
            }
            shown += 1;
            let sequence = Sequence::from_seed(point);
            for i in 0..64 {
                let sample = aim.sample(sequence.point(i));
                let Some(end) = sample.end.map(Vec3::from) else { continue };
                let direction = Vec3::from(sample.direction);
                if !sample.is_lit || direction.dot(surface.normal) <= 0.0 {
                    continue;
                }
                let origin = surface.origin(direction);
                let ray = Ray { origin, direction: end - origin, t_min: 0.0, t_max: 1.0 };
                let hidden = Scalar.any(&mut cursor, &mut source, &ray).unwrap();
                assert!(!hidden, "seed {seed}, point {point}: {ray:?} {light:?} {clearings:?}");
            }
        }
    }
    assert!(asked > 10_000 && shown > 2_000, "{shown} of {asked}");
}
