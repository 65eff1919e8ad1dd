//! The materials that a mesh can name.

use std::cmp::Reverse;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::lines::{self, Lines};
use super::{Cause, Failure, ImportError, Limits, defaults, mtl, place, shown, text};
use crate::model::{Material, Model};

/// Greatest number of materials that a file, and all files of a mesh, may define.
pub(super) const DEFINED_MAX: usize = 1 << 20;

/// Materials by name, entered into the model as they are used.
///
/// A name means what was defined last before the line that uses it; if nothing was, what is defined
/// behind it. Of the files of one `mtllib` the first counts.
pub(super) struct Library<'a> {
    limits: &'a Limits,
    path: &'a Path,
    /// By name, of each file that was read.
    known: HashMap<Vec<u8>, Vec<Entry>>,
    /// The files behind the current line have been read too.
    has_looked_ahead: bool,
    /// The files read so far, each once, in their order.
    files: HashMap<Vec<u8>, usize>,
    /// When the materials of each file were defined last; 0 if only behind the current line.
    defined_at: Vec<u64>,
    time: u64,
    text_bytes: u64,
    defined: usize,
    /// The index of the default.
    fallback: Option<u16>,
}

/// A material of a file, with its index once it is used.
struct Entry {
    file: usize,
    material: Material,
    index: Option<u16>,
}

impl<'a> Library<'a> {
    pub(super) fn new(path: &'a Path, limits: &'a Limits) -> Self {
        Self {
            limits,
            path,
            known: HashMap::new(),
            has_looked_ahead: false,
            files: HashMap::new(),
            defined_at: Vec::new(),
            time: 0,
            text_bytes: 0,
            defined: 0,
            fallback: None,
        }
    }

    pub(super) fn limits(&self) -> &'a Limits {
        self.limits
    }

    /// Defines what the files of a `mtllib` hold.
    pub(super) fn define(&mut self, model: &mut Model, list: &[u8]) -> Result<(), ImportError> {
        let names = self.names(list);
        for name in &names {
            self.file(model, name)?;
        }
        for name in names.into_iter().rev() {
            let file = self.files.get(name).and_then(|&file| self.defined_at.get_mut(file));
            if let Some(at) = file {
                self.time += 1;
                *at = self.time;
            }
        }
        Ok(())
    }

    /// The index of a material by name; that of the default if there is none of that name.
    /// `ahead` are the lines behind this one.
    pub(super) fn index(
        &mut self,
        model: &mut Model,
        name: &[u8],
        ahead: &Lines<'_>,
    ) -> Result<u16, Failure> {
        if !self.known.contains_key(name) && !self.has_looked_ahead {
            self.look_ahead(model, ahead.clone())?;
        }
        let entries = self.known.get_mut(name).into_iter().flatten();
        // Of those that are defined behind this line alone the first.
        let last = |e: &&mut Entry| (self.defined_at.get(e.file), Reverse(e.file));
        let Some(entry) = entries.max_by_key(last) else {
            model.notes.add_named("a material is not defined: grey instead", &shown(name));
            return Ok(self.fallback(model)?);
        };
        match entry.index {
            Some(index) => Ok(index),
            None => {
                let index = model.add_material(entry.material.clone())?;
                entry.index = Some(index);
                Ok(index)
            }
        }
    }

    /// The index of the default.
    pub(super) fn fallback(&mut self, model: &mut Model) -> Result<u16, Cause> {
        match self.fallback {
            Some(index) => Ok(index),
            None => {
                let index = model.add_material(defaults::material())?;
                self.fallback = Some(index);
                Ok(index)
            }
        }
    }

    /// Reads the files that later lines name: once, so that the time stays that of the text.
    fn look_ahead(&mut self, model: &mut Model, lines: Lines<'_>) -> Result<(), Failure> {
        let outer = model.notes.place().clone();
        for line in lines {
            if lines::words(&line.text).next() != Some(b"mtllib") {
                continue;
            }
            model.notes.set_line(line.first);
            for name in self.names(lines::name(&line.text, b"mtllib")) {
                self.file(model, name).map_err(|mut error| {
                    error.from.get_or_insert_with(|| place(self.path, line.last));
                    Failure::Elsewhere(Box::new(error))
                })?;
            }
        }
        self.has_looked_ahead = true;
        model.notes.set_place(outer);
        Ok(())
    }

    /// The files that a `mtllib` names. Names may contain spaces: if all of it is no file, each ends
    /// with `.mtl`, and what is left are words.
    fn names<'t>(&self, list: &'t [u8]) -> Vec<&'t [u8]> {
        if self.files.contains_key(list) || self.beside(list).is_file() {
            return vec![list];
        }
        let (mut names, mut begin, mut at) = (Vec::new(), 0, 0);
        for word in list.split_inclusive(u8::is_ascii_whitespace) {
            at += word.len();
            if word.trim_ascii().to_ascii_lowercase().ends_with(b".mtl") {
                names.push(list.get(begin..at).unwrap_or_default().trim_ascii());
                begin = at;
            }
        }
        let left = list.get(begin..).unwrap_or_default();
        names.extend(left.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()));
        names
    }

    /// A file in the directory of the mesh.
    fn beside(&self, name: &[u8]) -> PathBuf {
        let name = String::from_utf8_lossy(name).into_owned();
        self.path.parent().unwrap_or(Path::new("")).join(name)
    }

    /// Reads a file of materials; a missing one is noted.
    fn file(&mut self, model: &mut Model, name: &[u8]) -> Result<(), ImportError> {
        if self.files.contains_key(name) {
            return Ok(());
        }
        let file = self.beside(name);
        let here = |cause| ImportError::new(place(&file, 0), cause);
        let text = match text::read(model, &file, self.limits) {
            Ok(text) => text,
            Err(Cause::Missing) => {
                let text = "a file of materials is missing: grey instead";
                model.notes.add_named(text, &shown(name));
                self.enter(name, Vec::new());
                return Ok(());
            }
            Err(cause) => return Err(here(cause)),
        };
        self.text_bytes = self.text_bytes.saturating_add(text.len() as u64);
        if self.text_bytes > self.limits.text_bytes {
            let limit = self.limits.text_bytes;
            return Err(here(Cause::Limit { what: "too much text in all [bytes]", limit }));
        }
        let outer = model.notes.place().clone();
        model.notes.set_place(place(&file, 0));
        let materials = mtl::read(model, &text, &file)?;
        model.notes.set_place(outer);
        self.defined = self.defined.saturating_add(materials.len());
        if self.defined > DEFINED_MAX {
            return Err(here(Cause::Limit {
                what: "too many materials in all",
                limit: DEFINED_MAX as u64,
            }));
        }
        self.enter(name, materials);
        Ok(())
    }

    /// Keeps what a file holds. Within it the last of a name counts.
    fn enter(&mut self, name: &[u8], materials: Vec<Material>) {
        let file = self.defined_at.len();
        self.files.insert(name.to_owned(), file);
        self.defined_at.push(0);
        for material in materials {
            let entries = self.known.entry(material.name.clone().into_bytes()).or_default();
            let entry = Entry { file, material, index: None };
            match entries.last_mut().filter(|last| last.file == file) {
                Some(last) => *last = entry,
                None => entries.push(entry),
            }
        }
    }
}
