//! The materials that a mesh can name.

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
    known: HashMap<Vec<u8>, Entry>,
    /// What is defined behind the current line, once it was looked for.
    later: Option<HashMap<Vec<u8>, Entry>>,
    /// The files read so far, each once, with the materials that are not in `known` yet.
    files: HashMap<Vec<u8>, Vec<Material>>,
    text_bytes: u64,
    defined: usize,
    /// The index of the default.
    fallback: Option<u16>,
}

/// A material, with its index once it is used.
struct Entry {
    material: Material,
    index: Option<u16>,
}

impl<'a> Library<'a> {
    pub(super) fn new(path: &'a Path, limits: &'a Limits) -> Self {
        Self {
            limits,
            path,
            known: HashMap::new(),
            later: None,
            files: HashMap::new(),
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
            for material in self.files.get_mut(name).map(std::mem::take).unwrap_or_default() {
                let key = material.name.as_bytes();
                let early = self.later.as_mut().and_then(|later| later.remove(key));
                let entry = match early {
                    Some(early) if early.material == material => early,
                    _ => Entry { material, index: None },
                };
                self.known.insert(entry.material.name.clone().into_bytes(), entry);
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
        if !self.known.contains_key(name) && self.later.is_none() {
            self.look_ahead(model, ahead.clone())?;
        }
        let later = self.later.as_mut().and_then(|later| later.get_mut(name));
        let Some(entry) = self.known.get_mut(name).or(later) else {
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
        let mut later = HashMap::new();
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
                // Within a file the last of a name counts, of files the first.
                for material in self.files.get(name).into_iter().flatten().rev() {
                    let key = material.name.as_bytes();
                    if !later.contains_key(key) {
                        let entry = Entry { material: material.clone(), index: None };
                        later.insert(key.to_owned(), entry);
                    }
                }
            }
        }
        self.later = Some(later);
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
                self.files.insert(name.to_owned(), Vec::new());
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
        self.files.insert(name.to_owned(), materials);
        Ok(())
    }
}
