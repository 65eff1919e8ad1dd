//! Very many lights, by their tree.

use super::direct::horizontal;
use super::*;
use crate::light::{Aim, Seen};
use crate::material::Surface;
use crate::random::Sequence;
use crate::scene::LightNode;
use crate::trace::Scalar;
use std::vec;

/// A tree of lights by halves along each axis in turn, and bounds of the plainest kind.
fn tree(lights: &[Light], items: &mut [u32], depth: usize, nodes: &mut Vec<LightNode>) {
    let at = nodes.len();
    let of = |items: &[u32]| items.iter().map(|&i| lights[i as usize]).collect::<Vec<_>>();
    let below = of(items);
    let power = |light: &Light| match LightKind::from_u32(light.kind) {
        Some(LightKind::Point) => 1.0,
        _ => Aim::size(light) * Aim::size(light),
    };
    let sum = below.iter().map(power).sum::<f32>();
    let center = below.iter().map(Aim::center).sum::<Vec3>() / below.len() as f32;
    let ends = |light: &Light| Aim::center(light).distance(center) + Aim::size(light);
    let normal = |light: &Light| match LightKind::from_u32(light.kind) {
        Some(LightKind::Point | LightKind::Sphere) => None,
        _ => Vec3::from(light.u).cross(light.v.into()).try_normalize(),
    };
    let normals = below.iter().map(normal).collect::<Option<Vec<_>>>();
    let axis = normals.iter().flatten().sum::<Vec3>().try_normalize().unwrap_or(Vec3::Z);
    let cos = |normals: Vec<Vec3>| normals.iter().map(|n| n.dot(axis)).fold(1.0, f32::min) - 1e-6;
    nodes.push(LightNode {
        center: center.into(),
        radius: below.iter().map(ends).fold(0.0, f32::max) * 1.000_01,
        power: sum,
        axis: axis.into(),
        mean_cos: if normals.is_some() { 0.7 } else { 0.0 },
        cone_cos: normals.map_or(-1.0, cos).max(-1.0),
        reach: below.iter().map(|light| light.reach).fold(0.0, f32::max),
        next: LightNode::LEAF | items[0],
    });
    if items.len() > 1 {
        items.sort_by(|&a, &b| {
            let place = |i: u32| Aim::center(&lights[i as usize])[depth % 3];
            place(a).total_cmp(&place(b))
        });
        let (first, second) = items.split_at_mut(items.len() / 3 + 1);
        tree(lights, first, depth + 1, nodes);
        tree(lights, second, depth + 1, nodes);
        nodes[at].next = nodes.len() as u32;
    }
}

/// A number for each of some places.
fn numbers(seed: u32) -> impl Fn(u32) -> f32 {
    let sequence = Sequence::from_seed(seed);
    move |k| sequence.point(k / 2)[k as usize % 2]
}

/// Lamps of all kinds in a few clusters above and below a floor, small and large, facing anywhere.
fn lamps(count: u32, seed: u32, sizes: [f32; 3]) -> Vec<Light> {
    let at = numbers(seed);
    let mut next = 0;
    let mut number = || {
        next += 1;
        at(next)
    };
    let mut lights = vec![];
    for k in 0..count {
        let cluster = k % 5;
        let size = sizes[k as usize % 3];
        let mut vector = |scale: f32| Vec3::new(number(), number(), number()) * scale - scale / 2.0;
        let middle = Vec3::new(cluster as f32 - 2.0, 0.3, 0.8 - 0.3 * cluster as f32);
        let (position, u, v) = (middle + vector(0.8), vector(size), vector(size));
        lights.push(match k % 7 {
            0 => light(LightKind::Point, position, Vec3::ZERO, Vec3::ZERO, size * size),
            1 => light(LightKind::Sphere, position, Vec3::X * size, Vec3::ZERO, 1.0),
            2 => Light { reach: 1.5, ..light(LightKind::Parallelogram, position, u, v, 1.0) },
            3 => light(LightKind::Triangle, position, u, v, 1.0),
            // All the same way.
            _ => horizontal(
                LightKind::Parallelogram,
                [position.x, position.x + size],
                [position.y, position.y + size],
                position.z,
            ),
        });
    }
    lights
}

fn tree_of(lights: &[Light]) -> Vec<LightNode> {
    let mut items: Vec<_> = (0..lights.len() as u32).collect();
    let mut nodes = vec![];
    tree(lights, &mut items, 0, &mut nodes);
    nodes
}

/// A point of a surface that looks up or down, and takes light from its sides.
fn surface(position: Vec3, side: f32) -> Surface {
    let normal = Vec3::Z * side;
    Surface {
        position,
        above: position,
        below: position,
        normal,
        shading: normal,
        outgoing: normal,
        distance: 1.0,
        front: true,
        material: 0,
    }
}

/// Nodes hide no light: where one is dark, each light below is.
#[test]
fn where_a_node_is_dark_its_lights_are() {
    let lights = lamps(300, 11, [0.01, 0.05, 0.003]);
    let nodes = tree_of(&lights);
    let at = numbers(5);
    let (mut dark, mut seen) = (0, 0);
    for k in 0..3_000_u32 {
        let place = Vec3::new(at(4 * k), at(4 * k + 1), at(4 * k + 2));
        let surface = surface(
            place * Vec3::new(8.0, 3.0, 3.0) - Vec3::new(4.0, 1.0, 1.5),
            [1.0, -1.0][k as usize % 2],
        );
        let answers = [[true, false], [false, true], [true, true]][k as usize % 3];
        for (index, node) in (0_u32..).zip(&nodes) {
            if node.light().is_some() {
                continue;
            }
            match node.look(&surface, answers) {
                Seen::Near => {}
                Seen::Far(_) => seen += 1,
                Seen::Dark(_) => {
                    dark += 1;
                    let below = nodes[index as usize..node.end(index) as usize].iter();
                    for light in below.filter_map(LightNode::light) {
                        let light = &lights[light as usize];
                        assert!(
                            Aim::new(light, &surface, answers).is_err(),
                            "{node:?} {light:?} {surface:?}"
                        );
                    }
                }
            }
        }
    }
    assert!(dark > 20_000 && seen > 20_000, "{dark} {seen}");
}

/// Each light that can light a point stands for itself on average: asked with a probability, it counts for one over it.
#[test]
fn lights_are_chosen_with_the_probability_that_they_count_for() {
    const SAMPLES: u32 = 1 << 14;
    for (lights, seed) in [(1, 3), (4, 4), (40, 5)] {
        let settings =
            Settings { shadow_samples: 1, lights, samples: SAMPLES, ..Settings::default() };
        let mut scene =
            Scene { settings, lights: lamps(100, seed, [0.03, 0.05, 0.04]), ..Scene::default() };
        floor(&mut scene, matt(1.0));
        let nodes = tree_of(&scene.lights);
        let tables = Tables { tree: &nodes, ..scene.shader().tables() };
        let shader = Shader::new(tables, settings);
        let ray = down(0.1, 0.2);
        let hit = Brute(&scene).closest(&ray).unwrap();
        let mut sums = vec![[0.0_f64; 2]; scene.lights.len()];
        let mut counts = Counts::default();
        for sample in 0..SAMPLES {
            let path = Path::camera(PathKey::camera(9, 3, sample));
            let (_, point) = shader.arrive(&path, &ray, hit.as_ref());
            let (point, mut memo) = (point.unwrap(), Memo::new());
            let mut direct = shader.direct(Scalar, &point, &mut memo);
            let mut asked = 0;
            loop {
                // As a node that puts it away and goes on with it.
                direct = Direct::unpack(direct.pack());
                let next = shader.next_bundle(Scalar, &point, &mut direct, &memo, &mut counts);
                let Some(bundle) = next else { break };
                let [sum, square] = &mut sums[bundle.light as usize];
                let weight = f64::from(bundle.scale * bundle.samples as f32);
                (*sum, *square) = (*sum + weight, *square + weight * weight);
                asked += 1;
            }
            assert!(asked <= u32::from(lights) + 1, "{asked}");
        }
        let all = u64::from(SAMPLES) * scene.lights.len() as u64;
        let mut of_all = counts.lights_below + counts.lights_facing_away + counts.lights_by_chance;
        of_all += counts.lights_out_of_reach;
        let point = surface(Vec3::new(0.1, 0.2, 0.0), 1.0);
        let (mut often, mut worth, mut counted) = (0, 0.0, 0.0);
        for (index, (light, [sum, square])) in scene.lights.iter().zip(sums).enumerate() {
            let n = f64::from(SAMPLES);
            let (mean, square) = (sum / n, square / n);
            let Ok(aim) = Aim::new(light, &point, [true, false]) else {
                assert_eq!(mean, 0.0, "{lights}: {index} {light:?}");
                continue;
            };
            worth += f64::from(aim.estimate);
            counted += f64::from(aim.estimate) * mean;
            // The mean of what counts for s if it is asked has a deviation of √(s/n) at most: the offsets of the comb are spread more evenly than at random.
            let bound = 4.0 * (square / n).sqrt();
            if mean > 0.0 && bound < 0.5 {
                often += 1;
                assert!((mean - 1.0).abs() <= bound, "{lights}: {index} {mean} {bound} {light:?}");
            }
        }
        assert!((counted / worth - 1.0).abs() < 0.01, "{lights}: {counted} {worth}");
        assert!(often > 15 && of_all < all && of_all > all / 3, "{often} {of_all} {all}");
    }
}
