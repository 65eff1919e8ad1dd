//! Vertices and faces, line by line.

use std::path::Path;

use glam::DVec3;

use super::{Cause, ImportError, Materials, place, shown, syntax};
use crate::import::scan::number;
use crate::model::{Model, NO_NORMAL};

/// Reads the lines of a mesh.
pub(super) fn read(
    model: &mut Model,
    text: &[u8],
    path: &Path,
    materials: &mut Materials<'_>,
) -> Result<(), ImportError> {
    let mut at = place(path, 0);
    let mut mesh = Mesh::new(model, materials);
    let mut lines = text.split(|&b| b == b'\n').zip(1u64..);
    let mut joined = Vec::new();
    while let Some((line, number)) = lines.next() {
        mesh.model.notes.set_line(number);
        let mut line = line.strip_suffix(b"\r").unwrap_or(line);
        let mut last = number;
        if line.ends_with(b"\\") {
            joined.clear();
            while let Some(part) = line.strip_suffix(b"\\") {
                joined.extend_from_slice(part);
                joined.push(b' ');
                let Some((next, number)) = lines.next() else {
                    line = b"";
                    break;
                };
                last = number;
                line = next.strip_suffix(b"\r").unwrap_or(next);
            }
            joined.extend_from_slice(line);
            line = &joined;
        }
        if let Err(failure) = mesh.line(line) {
            at.line = last;
            return Err(match failure {
                Failure::Here(cause) => ImportError::new(at, cause),
                Failure::Elsewhere(mut error) => {
                    error.from.get_or_insert(at);
                    *error
                }
            });
        }
    }
    let seen = mesh.statements;
    if seen == 0 {
        model.notes.set_line(0);
        model.note("the file is empty");
    }
    Ok(())
}

/// In this line, or in a file that it names.
enum Failure {
    Here(Cause),
    Elsewhere(Box<ImportError>),
}

impl<C: Into<Cause>> From<C> for Failure {
    fn from(cause: C) -> Self {
        Self::Here(cause.into())
    }
}

struct Mesh<'a, 'b> {
    model: &'a mut Model,
    materials: &'a mut Materials<'b>,
    /// Where this file's vertices begin in the model, so that several files can be read.
    first_vertex: usize,
    /// Its normals: the model's index, as those without a direction get none.
    normals: Vec<u32>,
    material: Option<u16>,
    statements: u64,
    /// The corners of a face.
    corners: Vec<u32>,
    corner_normals: Vec<u32>,
}

impl<'a, 'b> Mesh<'a, 'b> {
    fn new(model: &'a mut Model, materials: &'a mut Materials<'b>) -> Self {
        let first_vertex = model.vertices.len();
        Self {
            model,
            materials,
            first_vertex,
            normals: Vec::new(),
            material: None,
            statements: 0,
            corners: Vec::new(),
            corner_normals: Vec::new(),
        }
    }

    fn line(&mut self, line: &[u8]) -> Result<(), Failure> {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        let Some(keyword) = words.next() else { return Ok(()) };
        if keyword.starts_with(b"#") {
            return Ok(());
        }
        self.statements += 1;
        match keyword {
            b"v" => {
                let mut point = vector(&mut words, "v")?;
                let more: Vec<&[u8]> = words.take(5).collect();
                // A fourth number is a weight; six or seven bring a colour, which is left out.
                if let [weight] = more[..] {
                    point /= number(weight)?;
                    if !point.is_finite() {
                        return Err(syntax("a weight of zero").into());
                    }
                }
                self.model.add_vertex(point)?;
            }
            b"vn" => {
                let normal = self.model.add_normal(vector(&mut words, "vn")?)?;
                self.normals.push(normal);
            }
            b"f" => self.face(words)?,
            b"usemtl" => {
                let name = rest(line, keyword);
                if name.is_empty() {
                    return Err(syntax("usemtl without a name").into());
                }
                self.material = Some(self.materials.index(self.model, Some(name))?);
            }
            b"mtllib" => {
                let name = rest(line, keyword);
                if name.is_empty() {
                    return Err(syntax("mtllib without a name").into());
                }
                let read = self.materials.read(self.model, name);
                read.map_err(|e| Failure::Elsewhere(Box::new(e)))?;
            }
            b"vt" | b"vp" | b"g" | b"o" | b"s" | b"usemap" | b"maplib" | b"lod" | b"bevel"
            | b"c_interp" | b"d_interp" | b"shadow_obj" | b"trace_obj" => {}
            b"p" | b"l" => self.model.note("points or lines: left out"),
            b"curv" | b"curv2" | b"surf" | b"parm" | b"trim" | b"hole" | b"scrv" | b"sp"
            | b"end" | b"con" | b"cstype" | b"deg" | b"bmat" | b"step" | b"mg" | b"ctech"
            | b"stech" => self.model.note("free-form curves or surfaces: left out"),
            other => {
                let what = shown(other);
                return Err(syntax(format!("`{what}` is not a statement of an .obj file")).into());
            }
        }
        Ok(())
    }

    fn face<'t>(&mut self, words: impl Iterator<Item = &'t [u8]>) -> Result<(), Failure> {
        let vertices = self.model.vertices.len() - self.first_vertex;
        self.corners.clear();
        self.corner_normals.clear();
        let mut smooth = true;
        for word in words {
            let mut parts = word.splitn(3, |&b| b == b'/');
            let vertex = index(parts.next().unwrap_or_default(), vertices, "vertex")?;
            self.corners.push((self.first_vertex + vertex) as u32);
            let normal = match parts.nth(1) {
                Some(part) if !part.is_empty() => {
                    let i = index(part, self.normals.len(), "normal")?;
                    self.normals.get(i).copied().unwrap_or(NO_NORMAL)
                }
                _ => NO_NORMAL,
            };
            smooth &= normal != NO_NORMAL;
            self.corner_normals.push(normal);
            if self.corners.len() as u64 > self.materials.limits.corners {
                let limit = self.materials.limits.corners;
                return Err(Cause::Limit { what: "too many corners of a face", limit }.into());
            }
        }
        if self.corners.len() < 3 {
            return Err(syntax("a face needs at least three corners").into());
        }
        let material = match self.material {
            Some(material) => material,
            None => {
                let material = self.materials.index(self.model, None)?;
                self.model.note("faces without a material: grey, diffuse");
                self.material = Some(material);
                material
            }
        };
        let normals = if smooth { &self.corner_normals[..] } else { &[] };
        self.model.add_polygon_face(material, &self.corners, normals)?;
        self.materials.limits.room(self.model)?;
        Ok(())
    }
}

/// Three finite numbers.
fn vector<'t>(words: &mut impl Iterator<Item = &'t [u8]>, what: &str) -> Result<DVec3, Cause> {
    let mut value = || match words.next() {
        Some(word) => number(word),
        None => Err(syntax(format!("`{what}` needs three numbers"))),
    };
    Ok(DVec3::new(value()?, value()?, value()?))
}

/// An index, from 1 forwards or from -1 backwards, as one from 0.
fn index(word: &[u8], known: usize, what: &str) -> Result<usize, Cause> {
    let value = std::str::from_utf8(word).ok().and_then(|w| w.parse::<i64>().ok());
    let found = match value {
        Some(i) if i > 0 => usize::try_from(i - 1).ok(),
        Some(i) if i < 0 => {
            usize::try_from(i.unsigned_abs()).ok().and_then(|back| known.checked_sub(back))
        }
        Some(_) => None,
        None => return Err(syntax(format!("`{}` is not the index of a {what}", shown(word)))),
    };
    found.filter(|&i| i < known).ok_or_else(|| {
        let word = shown(word);
        syntax(format!("there is no {what} {word}: {known} are defined before this line"))
    })
}

/// What stands behind the keyword: names may contain spaces.
fn rest<'t>(line: &'t [u8], keyword: &[u8]) -> &'t [u8] {
    let line = line.trim_ascii();
    line.get(keyword.len()..).unwrap_or_default().trim_ascii()
}
