//! Vertices and faces, line by line.

use std::path::Path;

use glam::DVec3;

use super::library::Library;
use super::lines::{Lines, name, words};
use super::{Cause, Failure, ImportError, place, shown, syntax};
use crate::import::scan::number;
use crate::model::{Model, NO_NORMAL};

/// Reads the lines of a mesh.
pub(super) fn read(
    model: &mut Model,
    text: &[u8],
    path: &Path,
    library: &mut Library<'_>,
) -> Result<(), ImportError> {
    let mut mesh = Mesh::new(model, library);
    let mut lines = Lines::new(text);
    while let Some(line) = lines.next() {
        mesh.model.notes.set_line(line.first);
        if let Err(failure) = mesh.line(&line.text, &lines) {
            let at = place(path, line.last);
            return Err(match failure {
                Failure::Here(cause) => ImportError::new(at, cause),
                Failure::Elsewhere(mut error) => {
                    error.from.get_or_insert(at);
                    *error
                }
            });
        }
    }
    mesh.end();
    Ok(())
}

/// What is left out and may come up at every line: counted here, and noted at the end.
#[derive(Debug, Clone, Copy)]
enum Lost {
    Color,
    Smoothing,
    HalfNormals,
    Words,
}

/// The text of each, in the order of [`Lost`].
const LOST: [&str; 4] = [
    "a colour of a vertex (numbers 4 to 6 of `v`): left out, the colour is the material's",
    "a face of a smoothing group (`s`) without normals (`vn`): flat, as no normals are made up",
    "a face of which only some corners name a normal: flat",
    "words behind all that a statement takes: left out",
];

struct Mesh<'a, 'b> {
    model: &'a mut Model,
    library: &'a mut Library<'b>,
    /// Where this file's vertices begin in the model, so that several files can be read.
    first_vertex: usize,
    /// Its normals: the model's index, as those without a direction get none.
    normals: Vec<u32>,
    /// Number of its texture coordinates: they are not used, but indices must be right.
    textures: usize,
    material: Option<u16>,
    /// In a smoothing group.
    smoothing: bool,
    statements: u64,
    /// How often each of [`LOST`] came up after the first time.
    lost: [Option<u64>; LOST.len()],
    /// The corners of a face.
    corners: Vec<u32>,
    corner_normals: Vec<u32>,
}

impl<'a, 'b> Mesh<'a, 'b> {
    fn new(model: &'a mut Model, library: &'a mut Library<'b>) -> Self {
        let first_vertex = model.vertices.len();
        Self {
            model,
            library,
            first_vertex,
            normals: Vec::new(),
            textures: 0,
            material: None,
            smoothing: false,
            statements: 0,
            lost: [None; LOST.len()],
            corners: Vec::new(),
            corner_normals: Vec::new(),
        }
    }

    /// Notes what is not noted yet.
    fn end(self) {
        for (text, count) in LOST.into_iter().zip(self.lost) {
            self.model.notes.add_many(text, count.unwrap_or(0));
        }
        if self.statements == 0 {
            self.model.notes.set_line(0);
            self.model.note("the file is empty");
        }
    }

    /// Counts something lost; the first time is noted with its line.
    fn lose(&mut self, what: Lost) {
        let Some(count) = self.lost.get_mut(what as usize) else { return };
        match count {
            Some(count) => *count = count.saturating_add(1),
            None => {
                *count = Some(0);
                self.model.note(LOST.get(what as usize).copied().unwrap_or_default());
            }
        }
    }

    /// Reads a line; `ahead` are those behind it.
    fn line(&mut self, line: &[u8], ahead: &Lines<'_>) -> Result<(), Failure> {
        let mut words = words(line);
        let Some(keyword) = words.next() else { return Ok(()) };
        self.statements += 1;
        match keyword {
            b"v" => self.vertex(words)?,
            b"vn" => {
                let normal = self.model.add_normal(vector(&mut words, "vn")?)?;
                self.normals.push(normal);
                if words.next().is_some() {
                    self.lose(Lost::Words);
                }
            }
            b"f" => self.face(words)?,
            b"usemtl" => {
                let name = name(line, keyword);
                if name.is_empty() {
                    return Err(syntax("usemtl without a name").into());
                }
                self.material = Some(self.library.index(self.model, name, ahead)?);
            }
            b"mtllib" => {
                let list = name(line, keyword);
                if list.is_empty() {
                    return Err(syntax("mtllib without a name").into());
                }
                let read = self.library.define(self.model, list);
                read.map_err(|e| Failure::Elsewhere(Box::new(e)))?;
            }
            b"s" => self.smoothing = !matches!(words.next(), None | Some(b"off" | b"0")),
            // They change nothing that is seen: textures are left out where materials name them.
            b"vt" => self.textures += 1,
            b"vp" | b"g" | b"o" => {}
            b"p" | b"l" => self.model.note("points or lines: left out"),
            _ => return other(self.model, keyword),
        }
        Ok(())
    }

    fn vertex<'t>(&mut self, mut words: impl Iterator<Item = &'t [u8]>) -> Result<(), Failure> {
        let mut point = vector(&mut words, "v")?;
        let (mut more, mut found) = ([0.0; 4], 0);
        for (slot, word) in more.iter_mut().zip(words.by_ref()) {
            *slot = number(word)?;
            found += 1;
        }
        match found {
            0 => {}
            // A fourth number is a weight; six or seven bring a colour.
            1 => {
                point /= more[0];
                if !point.is_finite() {
                    return Err(syntax("a weight of zero").into());
                }
            }
            2 => self.lose(Lost::Words),
            _ => self.lose(Lost::Color),
        }
        if words.next().is_some() {
            self.lose(Lost::Words);
        }
        self.model.add_vertex(point)?;
        Ok(())
    }

    fn face<'t>(&mut self, words: impl Iterator<Item = &'t [u8]>) -> Result<(), Failure> {
        let vertices = self.model.vertices.len() - self.first_vertex;
        self.corners.clear();
        self.corner_normals.clear();
        let (mut smooth, mut named) = (true, false);
        for word in words {
            let mut parts = word.splitn(3, |&b| b == b'/');
            let vertex = index(parts.next().unwrap_or_default(), vertices, "vertex")?;
            self.corners.push((self.first_vertex + vertex) as u32);
            // Each may be left out.
            let mut optional = |known, what| match parts.next() {
                Some(part) if !part.is_empty() => index(part, known, what).map(Some),
                _ => Ok(None),
            };
            optional(self.textures, "texture coordinate")?;
            let normal = optional(self.normals.len(), "normal")?;
            let normal = normal.and_then(|i| self.normals.get(i).copied()).unwrap_or(NO_NORMAL);
            smooth &= normal != NO_NORMAL;
            named |= normal != NO_NORMAL;
            self.corner_normals.push(normal);
            if self.corners.len() as u64 > self.library.limits().corners {
                let limit = self.library.limits().corners;
                return Err(Cause::Limit { what: "too many corners of a face", limit }.into());
            }
        }
        if self.corners.len() < 3 {
            return Err(syntax("a face needs at least three corners").into());
        }
        let material = match self.material {
            Some(material) => material,
            None => {
                let material = self.library.fallback(self.model)?;
                self.model.note("faces without a material: grey, diffuse");
                self.material = Some(material);
                material
            }
        };
        if !smooth && named {
            self.lose(Lost::HalfNormals);
        } else if !smooth && self.smoothing {
            self.lose(Lost::Smoothing);
        }
        let normals = if smooth { &self.corner_normals[..] } else { &[] };
        self.model.add_polygon_face(material, &self.corners, normals)?;
        self.library.limits().room(self.model)?;
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

/// A statement that is not read.
fn other(model: &mut Model, keyword: &[u8]) -> Result<(), Failure> {
    let refused = match keyword {
        b"curv" | b"curv2" | b"surf" | b"parm" | b"trim" | b"hole" | b"scrv" | b"sp" | b"end"
        | b"con" | b"cstype" | b"deg" | b"bmat" | b"step" | b"mg" | b"ctech" | b"stech" => {
            model.note("free-form curves or surfaces: left out");
            return Ok(());
        }
        b"usemap" | b"maplib" | b"lod" | b"bevel" | b"c_interp" | b"d_interp" | b"shadow_obj"
        | b"trace_obj" => {
            let text = "an attribute of faces that is not read: left out";
            model.notes.add_named(text, &shown(keyword));
            return Ok(());
        }
        b"call" => "`call` includes a file, which is not done: put its lines in place of this one",
        b"csh" => "`csh` runs a command, which is never done: put what it prints in its place",
        other => {
            let what = shown(other);
            return Err(syntax(format!("`{what}` is not a statement of an .obj file")).into());
        }
    };
    Err(syntax(refused).into())
}
