//! Models of every kind of awkwardness.

use glam::DVec3;
use proptest::prelude::*;

use super::oracle::check;
use crate::compile::{Options, compile};
use crate::model::{Material, Model, NO_NORMAL, Sphere, Triangle};

/// A group of primitives in one place.
#[derive(Debug, Clone)]
struct Group {
    kind: Kind,
    count: usize,
    center: [f64; 3],
    /// Decimal exponent of its size, against that of the model.
    size: i32,
    materials: u16,
    normals: bool,
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    /// Triangles that share no vertex.
    Soup,
    /// Long and very thin.
    Slivers,
    /// All the same.
    Coincident,
    /// Strips: each shares two vertices with the one before.
    Strip,
    /// In one plane that is normal to an axis.
    Flat,
    /// Side by side, each half as large as the one before.
    Geometric,
    Spheres,
    /// One inside the other.
    Shells,
}

fn group() -> impl Strategy<Value = Group> {
    let kind = prop_oneof![
        Just(Kind::Soup),
        Just(Kind::Slivers),
        Just(Kind::Coincident),
        Just(Kind::Strip),
        Just(Kind::Flat),
        Just(Kind::Geometric),
        Just(Kind::Spheres),
        Just(Kind::Shells),
    ];
    (kind, 0..120_usize, prop::array::uniform3(-1.0..1.0), -8..1, 1..9_u16, any::<bool>()).prop_map(
        |(kind, count, center, size, materials, normals)| Group {
            kind,
            count,
            center,
            size,
            materials,
            normals,
        },
    )
}

/// Numbers in -1..1 (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ x >> 31) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}

fn build(groups: &[Group], scale: f64, offset: f64, seed: u64) -> Model {
    let mut random = Random(seed);
    let mut model = Model { materials: vec![Material::default(); 9], ..Model::default() };
    for group in groups {
        let size = scale * 10f64.powi(group.size);
        let center = (DVec3::from_array(group.center) + offset) * scale;
        let same = [random.point(), random.point(), random.point()];
        let mut last = same;
        for i in 0..group.count {
            let material = (i * 7 % usize::from(group.materials)) as u16;
            let shape = match group.kind {
                Kind::Soup => [random.point(), random.point(), random.point()],
                Kind::Slivers => {
                    let (a, b) = (random.point(), random.point());
                    [a, b, a + (b - a) * 0.5 + random.point() * 1e-6]
                }
                Kind::Coincident => same,
                Kind::Strip => {
                    last = [last[1], last[2], last[2] + random.point() * 0.1];
                    last
                }
                Kind::Flat => [(); 3].map(|()| random.point() * DVec3::new(1.0, 0.0, 1.0)),
                Kind::Geometric => {
                    let s = 0.5f64.powi(i as i32);
                    [DVec3::splat(s), DVec3::new(s * 2.0, s, 0.0), DVec3::new(0.0, s * 2.0, s)]
                }
                Kind::Spheres | Kind::Shells => {
                    let shell = matches!(group.kind, Kind::Shells);
                    let radius = if shell { (i + 1) as f64 } else { random.next().abs() + 1e-3 };
                    model.spheres.push(Sphere {
                        center: center + if shell { DVec3::ZERO } else { random.point() * size },
                        radius: radius * size,
                        material,
                        inward: i % 3 == 0,
                    });
                    continue;
                }
            };
            let first = model.vertices.len() as u32;
            model.vertices.extend(shape.map(|p| center + p * size));
            let mut normals = [NO_NORMAL; 3];
            if group.normals {
                // Some triangles have them at some corners only.
                let first = usize::from(group.count.is_multiple_of(5));
                for (i, normal) in normals.iter_mut().enumerate().skip(first) {
                    *normal = model.normals.len() as u32;
                    model.normals.push((random.point() + i as f64).normalize_or(DVec3::Z));
                }
            }
            let vertices = [first, first + 1, first + 2];
            model.triangles.push(Triangle { vertices, normals, material });
        }
    }
    model
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn any_model_survives_in_blocks_of_any_size(
        groups in prop::collection::vec(group(), 0..7),
        exponent in prop_oneof![Just(0), Just(-20), Just(20), -6..7],
        offset in prop_oneof![Just(0.0), Just(1e4), Just(-1e4)],
        seed: u64,
        kib_log2 in 0..7_u32,
    ) {
        let model = build(&groups, 10f64.powi(exponent), offset, seed);
        let options = Options::blocks_of(1024_usize << kib_log2);
        let compiled = compile(&model, &options, &mut ()).unwrap();
        check(&model, &compiled);
        // Positions are as near as f32 allows; the frame is at most twice as large as the scene.
        let frame = compiled.header().frame;
        let unit = 2f64.powi(frame.exponent);
        prop_assert!(f64::from(frame.position_error) <= unit * 2f64.powi(-24));
        let again = compile(&model, &options, &mut ()).unwrap();
        prop_assert!(again.bytes() == compiled.bytes());
    }
}

#[test]
fn the_least_block_holds_nodes_of_large_leaves() {
    // No vertex is shared, every vertex has a normal: eight leaves never fit a KiB.
    let group = Group {
        kind: Kind::Soup,
        count: 400,
        center: [0.0; 3],
        size: 0,
        materials: 4,
        normals: true,
    };
    let model = build(&[group], 1.0, 0.0, 7);
    let compiled = compile(&model, &Options::blocks_of(1024), &mut ()).unwrap();
    check(&model, &compiled);
    assert_eq!(compiled.stats.triangles, 400);
}

#[test]
fn ten_thousand_triangles_in_one_place_are_cut_by_count() {
    let group = |count| Group {
        kind: Kind::Coincident,
        count,
        center: [0.5; 3],
        size: -3,
        materials: 8,
        normals: false,
    };
    let model = build(&[group(10_000), Group { kind: Kind::Geometric, ..group(100) }], 1.0, 0.0, 3);
    let compiled = compile(&model, &Options::blocks_of(4096), &mut ()).unwrap();
    check(&model, &compiled);
    // 10,000 / 4 leaves of 8 children each need 4 levels.
    assert!(compiled.stats.depth <= 12, "{}", compiled.stats.depth);
}
