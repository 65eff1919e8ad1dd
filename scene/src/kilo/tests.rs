use std::fs;
use std::io::{self, Write};
use std::mem::offset_of;
use std::path::PathBuf;

use glam::DVec3;
use kiloray_core::block::format::{Child, FileHeader, Node, VERSION};
use kiloray_core::block::{BlockError, FileError, KiloView, Table, checksum};
use kiloray_core::scene::{Light as LightEntry, Needs};
use proptest::prelude::*;

use super::write::write_with;
use super::{Image, KiloError, KiloFile, Tables};
use crate::compile::{Compiled, Options, compile};
use crate::model::{Light, Material, Model, NO_NORMAL, Triangle, View};

/// A bumpy field over several blocks of 1 KiB, with a light and a view.
fn compiled() -> Compiled {
    let n = 12;
    let mut model = Model { materials: vec![Material::default()], ..Model::default() };
    for i in 0..=n {
        for j in 0..=n {
            let z = f64::from((i * 7 + j * 5) % 11) * 0.1;
            model.vertices.push(DVec3::new(f64::from(i), f64::from(j), z));
        }
    }
    for i in 0..n {
        for j in 0..n {
            let a = i * (n + 1) + j;
            for vertices in [[a, a + n + 1, a + 1], [a + 1, a + n + 1, a + n + 2]] {
                model.triangles.push(Triangle { vertices, normals: [NO_NORMAL; 3], material: 0 });
            }
        }
    }
    model.lights.push(Light {
        kind: kiloray_core::scene::LightKind::Point,
        material: None,
        reach: f64::INFINITY,
        position: DVec3::splat(9.0),
        u: DVec3::ZERO,
        v: DVec3::ZERO,
        radiance: DVec3::ONE,
        cone: None,
    });
    model.views.push(View {
        kind: kiloray_core::scene::ViewKind::Perspective,
        name: "v".into(),
        position: DVec3::splat(20.0),
        direction: DVec3::NEG_ONE,
        up: DVec3::Z,
        size: [45.0, 45.0],
        offset: [0.0; 2],
        clip: [0.0; 2],
    });
    compile(&model, &Options::blocks_of(1024), &mut ()).unwrap()
}

/// A directory of this test's own, which is gone when it ends.
struct Directory(PathBuf);

impl Directory {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("kiloray-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn what_is_written_is_read() {
    let directory = Directory::new("written");
    let path = directory.0.join("a.kilo");
    let file = KiloFile::from_compiled(compiled());
    file.write(&path).unwrap();
    // Written again, over itself.
    file.write(&path).unwrap();
    let mapped = KiloFile::open(&path).unwrap();
    assert_eq!(mapped.bytes(), file.bytes());
    assert_eq!(mapped.view().blocks(), file.view().blocks());
    let names: Vec<_> =
        fs::read_dir(&directory.0).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names, ["a.kilo"], "nothing else is left");
}

#[test]
fn what_cannot_be_written_leaves_nothing() {
    let directory = Directory::new("refused");
    let file = KiloFile::from_compiled(compiled());
    let missing = directory.0.join("missing").join("a.kilo");
    let error = file.write(&missing).unwrap_err();
    assert!(error.to_string().contains("a.kilo: "), "{error}");
    // A directory in the place of the file: the rename fails, and the temporary file is removed.
    let taken = directory.0.join("taken.kilo");
    fs::create_dir(&taken).unwrap();
    assert!(matches!(file.write(&taken), Err(KiloError::Io { .. })));
    let names: Vec<_> =
        fs::read_dir(&directory.0).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names, ["taken.kilo"]);
}

#[test]
fn a_full_disk_leaves_the_old_file() {
    let directory = Directory::new("full");
    let path = directory.0.join("a.kilo");
    fs::write(&path, b"old").unwrap();
    let full = || io::Error::from(io::ErrorKind::StorageFull);
    let error = write_with(&path, |file| {
        file.write_all(b"half of it")?;
        Err(full())
    });
    assert_eq!(error.unwrap_err().kind(), io::ErrorKind::StorageFull);
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(fs::read_dir(&directory.0).unwrap().count(), 1);
}

#[test]
#[cfg(target_os = "linux")]
fn a_device_is_written_and_not_replaced() {
    let file = KiloFile::from_compiled(compiled());
    file.write("/dev/null".as_ref()).unwrap();
    match file.write("/dev/full".as_ref()) {
        Err(KiloError::Io { source, .. }) => {
            assert_eq!(source.kind(), io::ErrorKind::StorageFull);
        }
        other => panic!("{other:?}"),
    }
    assert!(!fs::metadata("/dev/full").unwrap().is_file());
}

#[test]
#[cfg(unix)]
fn a_link_stays_a_link() {
    let directory = Directory::new("link");
    let (target, link) = (directory.0.join("a.kilo"), directory.0.join("b.kilo"));
    fs::write(&target, b"old").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    let file = KiloFile::from_compiled(compiled());
    file.write(&link).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&target).unwrap(), file.bytes());
}

#[test]
fn files_that_are_none_are_refused() {
    let directory = Directory::new("none");
    let path = directory.0.join("a.kilo");
    let refused = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        match KiloFile::open(&path) {
            Err(KiloError::Damaged { error, .. }) => error,
            other => panic!("{other:?}"),
        }
    };
    let whole = compiled();
    let whole = whole.bytes();
    assert_eq!(refused(b""), FileError::Magic);
    assert_eq!(refused(b"GIF89a"), FileError::Magic);
    assert!(matches!(refused(&whole[..100]), FileError::Truncated { .. }));
    assert!(matches!(refused(&whole[..whole.len() - 1]), FileError::Truncated { .. }));
    let expected = whole.len() as u64;
    let longer = [whole, &[0]].concat();
    assert_eq!(refused(&longer), FileError::Longer { expected, found: expected + 1 });
    let mut other = whole.to_vec();
    other[4] += 1;
    assert_eq!(refused(&other), FileError::Version { found: VERSION + 1 });
    let absent = KiloFile::open(&directory.0.join("b.kilo")).unwrap_err();
    assert!(absent.to_string().contains("b.kilo: "), "{absent}");
}

/// Changes the file's bytes and makes the checksums true again.
fn forged(change: impl FnOnce(&mut [u8])) -> Result<KiloFile, KiloError> {
    let whole = compiled();
    let mut bytes = whole.bytes().to_vec();
    change(&mut bytes);
    let header = *whole.header();
    let end = header.needs.at as usize + size_of::<Needs>();
    let crc = checksum(&bytes[12..end]);
    bytes[8..12].copy_from_slice(&crc.to_le_bytes());
    for block in bytes[header.blocks_at as usize..].chunks_mut(1024) {
        let crc = checksum(&block[4..]);
        block[..4].copy_from_slice(&crc.to_le_bytes());
    }
    KiloFile::from_bytes(&bytes)
}

#[test]
fn what_fills_up_to_the_first_block_is_zero() {
    let whole = compiled();
    let header = whole.header();
    let end = header.needs.at as usize + size_of::<Needs>();
    assert!(end < header.blocks_at as usize);
    for at in end..header.blocks_at as usize {
        let mut bytes = whole.bytes().to_vec();
        bytes[at] = 1;
        let refused = KiloFile::from_bytes(&bytes);
        assert!(matches!(refused, Err(KiloError::Refused(FileError::Padding))), "byte {at}");
    }
}

#[test]
fn a_file_without_blocks_is_refused_by_every_reader() {
    let whole = compiled();
    let header = FileHeader { blocks: 0, ..*whole.header() };
    let needs = *KiloView::parse(whole.bytes()).unwrap().needs();
    let tables = Tables { materials: &[], lights: &[], views: &[], light_tree: &[], needs };
    let image = Image::new(header, tables);
    assert_eq!(KiloView::parse(image.bytes()).err(), Some(FileError::Header));
    assert_eq!(KiloView::parse_head(image.bytes()).err(), Some(FileError::Header));
    for exponent in [1021, -1021, i32::MIN, i32::MAX] {
        let mut header = *whole.header();
        header.frame.exponent = exponent;
        let image = Image::new(
            header,
            Tables { materials: &[], lights: &[], views: &[], light_tree: &[], needs },
        );
        assert_eq!(KiloView::parse(image.bytes()).err(), Some(FileError::Header), "{exponent}");
    }
    let directory = Directory::new("rootless");
    let path = directory.0.join("a.kilo");
    fs::write(&path, image.bytes()).unwrap();
    for read in [KiloFile::open, KiloFile::map] {
        let error = read(&path).unwrap_err();
        assert!(matches!(error, KiloError::Damaged { error: FileError::Header, .. }), "{error}");
    }
}

#[test]
fn a_light_without_sense_is_refused() {
    let with = |field: usize, value: f32| {
        let first = compiled().header().lights.at as usize + field;
        forged(|bytes| bytes[first..first + 4].copy_from_slice(&value.to_le_bytes()))
    };
    let [focus, reach, cos] = [
        offset_of!(LightEntry, focus),
        offset_of!(LightEntry, reach),
        offset_of!(LightEntry, cone_cos),
    ];
    assert!(with(focus, 3.0).is_ok() && with(reach, f32::INFINITY).is_ok());
    for (field, value) in [
        (focus, -1.0),
        (focus, f32::INFINITY),
        (focus, f32::NAN),
        (reach, -1.0),
        (reach, f32::NAN),
        (cos, f32::NAN),
    ] {
        let refused = with(field, value);
        let expected = FileError::Table { table: Table::Lights, entry: 0 };
        assert!(matches!(refused, Err(KiloError::Refused(e)) if e == expected), "{field} {value}");
    }
}

/// The child bits of a slot of block 0.
fn child_at(header: &FileHeader, node: usize, slot: usize) -> usize {
    let end = header.blocks_at as usize + header.block_bytes as usize;
    end - (node + 1) * size_of::<Node>() + 96 + 2 * slot
}

#[test]
fn a_forged_tree_is_refused() {
    let whole = compiled();
    let header = *whole.header();
    assert!(header.blocks > 2);
    assert!(forged(|_| {}).is_ok());
    let view = KiloView::parse(whole.bytes()).unwrap();
    let block = view.trusted_block(0).unwrap();
    let kids = block.node(0).unwrap().child.map(Child::decode);
    let refs: Vec<usize> = (0..8).filter(|&s| matches!(kids[s], Child::Ref(_))).collect();
    let [first, second, ..] = refs[..] else { panic!("the root has two references: {kids:?}") };
    // Two slots that lead to the same place: a walk would take exponentially many steps.
    let twice = forged(|bytes| {
        let (from, to) = (child_at(&header, 0, first), child_at(&header, 0, second));
        bytes.copy_within(from..from + 2, to);
    });
    let error = BlockError::Child { node: 0, slot: second as u8 };
    match twice {
        Err(KiloError::Refused(found)) => assert_eq!(found, FileError::Block { block: 0, error }),
        other => panic!("{other:?}"),
    }
    // Levels and nesting that are too small.
    for field in [42, 44] {
        let shallow = forged(|bytes| {
            let at = header.blocks_at as usize + field;
            bytes[at] -= 1;
        });
        assert!(matches!(
            shallow,
            Err(KiloError::Refused(FileError::Block { block: 0, error: BlockError::Depth }))
        ));
    }
}

proptest! {
    #[test]
    fn a_flipped_bit_is_refused(at: prop::sample::Index, bit in 0..8_u8) {
        let whole = compiled();
        let mut bytes = whole.bytes().to_vec();
        let at = at.index(bytes.len());
        bytes[at] ^= 1 << bit;
        prop_assert!(KiloFile::from_bytes(&bytes).is_err(), "byte {}", at);
    }

    #[test]
    fn forged_bytes_never_hang_or_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)
    ) {
        // Whatever is accepted is a tree: a walk over it ends within its number of nodes.
        if let Ok(file) = forged(|bytes| {
            for (at, byte) in flips {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
        }) {
            let view = file.view();
            let mut stack = vec![(0, 0)];
            let mut seen = 0;
            while let Some((block, node)) = stack.pop() {
                seen += 1;
                prop_assert!(seen <= 1_000);
                let content = view.trusted_block(block).unwrap();
                for bits in content.node(node).unwrap().child {
                    match Child::decode(bits) {
                        Child::Node(kid) => stack.push((block, kid)),
                        Child::Ref(r) => {
                            let r = content.reference(r).unwrap();
                            stack.push((r.block, r.node));
                        }
                        Child::Leaf { .. } | Child::Empty => {}
                    }
                }
            }
        }
    }
}
