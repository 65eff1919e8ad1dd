//! Meshes: KTRI files as `gen_mesh.py` writes them, or OBJ files with a camera before them.

use std::path::{Path, PathBuf};
use std::process::Command;

use glam::DVec3;
use kiloray_scene::model::{Material, Model, NO_NORMAL};

use crate::Error;

/// A KTRI file of the mesh: made by the peers' script, or from an OBJ file.
pub(crate) fn prepare(
    mesh: Option<&Path>,
    peers: Option<&Path>,
    work: &Path,
) -> Result<PathBuf, Error> {
    match mesh {
        Some(path) if path.extension().is_some_and(|e| e == "obj") => from_obj(path, work),
        Some(path) => Ok(path.to_path_buf()),
        None => {
            let ktri = work.join("mesh.ktri");
            if !ktri.exists() {
                let peers = peers.ok_or("no mesh: give --peers or --mesh")?;
                let script = peers.join("gen_mesh.py");
                let status = Command::new("python3").arg(script).arg(&ktri).status()?;
                if !status.success() {
                    return Err("gen_mesh.py failed (it needs numpy)".into());
                }
            }
            Ok(ktri)
        }
    }
}

/// Writes an OBJ file's triangles with a camera that sees all of them from an upper corner.
fn from_obj(path: &Path, work: &Path) -> Result<PathBuf, Error> {
    let text = std::fs::read_to_string(path)?;
    let (mut points, mut triangles): (Vec<[f32; 3]>, Vec<[u32; 3]>) = (vec![], vec![]);
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let p: Vec<f32> = words.take(3).map(str::parse).collect::<Result<_, _>>()?;
                points.push(p.try_into().map_err(|_| "a vertex of less than three numbers")?);
            }
            Some("f") => {
                let index = |w: &str| -> Result<u32, Error> {
                    let i: i64 = w.split('/').next().unwrap_or_default().parse()?;
                    let i = if i < 0 { points.len() as i64 + i } else { i - 1 };
                    Ok(u32::try_from(i)?)
                };
                let face: Vec<u32> = words.map(index).collect::<Result<_, _>>()?;
                for i in 2..face.len() {
                    triangles.push([face[0], face[i - 1], face[i]]);
                }
            }
            _ => {}
        }
    }
    let fold = |f: fn(f32, f32) -> f32, a: usize| points.iter().map(|p| p[a]).reduce(f);
    let corner = |f| [0, 1, 2].map(|a| fold(f, a).unwrap_or(0.0));
    let (lo, hi): ([f32; 3], [f32; 3]) = (corner(f32::min), corner(f32::max));
    let center = [0, 1, 2].map(|a| 0.5 * (lo[a] + hi[a]));
    let size = (0..3).map(|a| hi[a] - lo[a]).fold(0.0, f32::max);
    let away = |v: [f32; 3]| [0, 1, 2].map(|a| center[a] + size * v[a]);
    let mut bytes = b"KTRI".to_vec();
    bytes.extend((points.len() as u32).to_le_bytes());
    bytes.extend((triangles.len() as u32).to_le_bytes());
    let camera = [away([0.8, 0.5, 1.2]), center, [0.0, 1.0, 0.0]];
    let numbers = camera.into_iter().flatten().chain([35.0]).chain(away([1.0, 3.0, 1.5]));
    bytes.extend(numbers.flat_map(f32::to_le_bytes));
    bytes.extend(points.iter().flatten().flat_map(|x| x.to_le_bytes()));
    bytes.extend(triangles.iter().flatten().flat_map(|x| x.to_le_bytes()));
    let name = path.file_stem().unwrap_or_default();
    let ktri = work.join(name).with_extension("ktri");
    std::fs::write(&ktri, bytes)?;
    Ok(ktri)
}

/// Reads a KTRI file.
pub(crate) fn read(path: &Path) -> Result<Model, Error> {
    let bytes = std::fs::read(path)?;
    let word = |i: usize| -> Result<[u8; 4], Error> {
        Ok(bytes.get(4 * i..4 * i + 4).ok_or("the mesh ends too soon")?.try_into()?)
    };
    if word(0)? != *b"KTRI" {
        return Err("not a KTRI file".into());
    }
    let count = |i| word(i).map(|w| u32::from_le_bytes(w) as usize);
    let (vertices, triangles) = (count(1)?, count(2)?);
    let mut model = Model::default();
    let grey = model.add_material(Material::default())?;
    for i in 0..vertices {
        let at = |k| word(16 + 3 * i + k).map(|w| f64::from(f32::from_le_bytes(w)));
        model.add_vertex(DVec3::new(at(0)?, at(1)?, at(2)?))?;
    }
    for i in 0..triangles {
        let at = |k| word(16 + 3 * vertices + 3 * i + k).map(u32::from_le_bytes);
        model.add_face(grey, [at(0)?, at(1)?, at(2)?], [NO_NORMAL; 3])?;
    }
    Ok(model)
}
