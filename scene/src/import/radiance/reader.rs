//! The stream of objects and commands.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::command::{self, Head, Pipe};
use super::kinds::{Kind, Shape};
use super::material::material;
use super::names::{Modifier, Names};
use super::surface::{self, Context};
use super::xform::Stage;
use crate::import::error::{place, syntax};
use crate::import::scan::{Words, number, shown};
use crate::import::{Cause, ImportError, Limits, text};
use crate::model::{Material, Model, Place};

/// The arguments of an object; integers are not kept, Radiance has no use for them.
#[derive(Debug, Default)]
pub(super) struct Arguments {
    pub(super) strings: Vec<String>,
    pub(super) numbers: Vec<f64>,
}

/// Reads files, and what they include, into a model.
pub(super) struct Reader<'a> {
    model: &'a mut Model,
    limits: &'a Limits,
    names: &'a mut Names,
    /// Text of the files read so far: a copy of an array reads it again.
    texts: HashMap<PathBuf, Arc<[u8]>>,
    /// The files being read, from the outermost.
    open: Vec<PathBuf>,
    text_bytes: u64,
    copies: u64,
    arguments: Arguments,
}

impl<'a> Reader<'a> {
    pub(super) fn new(model: &'a mut Model, names: &'a mut Names, limits: &'a Limits) -> Self {
        Self {
            model,
            limits,
            names,
            texts: HashMap::new(),
            open: Vec::new(),
            text_bytes: 0,
            copies: 0,
            arguments: Arguments::default(),
        }
    }

    /// Reads a file as it is.
    pub(super) fn file(&mut self, path: &Path) -> Result<(), ImportError> {
        self.include(path, &Context::TOP)
    }

    /// Reads a file within others.
    fn include(&mut self, path: &Path, context: &Context) -> Result<(), ImportError> {
        let here = |cause: Cause| ImportError::new(place(path, 0), cause);
        // Names of the same file differ; a link can hide a loop.
        let known = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        if self.open.contains(&known) {
            return Err(here(syntax("the file includes itself")));
        }
        if self.open.len() as u64 >= self.limits.depth {
            let limit = self.limits.depth;
            return Err(here(Cause::Limit { what: "files nested too deep", limit }));
        }
        let text = match self.texts.get(&known) {
            Some(text) => Arc::clone(text),
            None => {
                let text: Arc<[u8]> =
                    text::read(self.model, path, self.limits).map_err(here)?.into();
                self.texts.insert(known.clone(), Arc::clone(&text));
                text
            }
        };
        self.text_bytes = self.text_bytes.saturating_add(text.len() as u64);
        if self.text_bytes > self.limits.text_bytes {
            let limit = self.limits.text_bytes;
            return Err(here(Cause::Limit { what: "too much text in all [bytes]", limit }));
        }
        let outer = self.model.notes.place().clone();
        self.open.push(known);
        let read = self.stream(path, &text, context);
        self.open.pop();
        self.model.notes.set_place(outer);
        read
    }

    /// Reads objects and commands to the end of the text.
    fn stream(&mut self, path: &Path, text: &[u8], context: &Context) -> Result<(), ImportError> {
        let file = place(path, 0).file;
        let mut words = Words::new(text);
        self.model.notes.set_place(Place { file: file.clone(), line: 0 });
        let mut things = 0u64;
        let mut before = None;
        while let Some(first) = words.peek(true) {
            things += 1;
            let begin = words.line();
            self.model.notes.set_line(begin);
            if first == b'!' {
                let line = words.rest_of_line();
                let place = Place { file: file.clone(), line: begin };
                let line = line.get(1..).unwrap_or_default();
                self.command(line, path, &place, context)?;
                before = None;
            } else {
                let name = self.object(&mut words, before, context).map_err(|cause| {
                    ImportError::new(Place { file: file.clone(), line: words.line() }, cause)
                })?;
                before = Some((name, begin));
            }
        }
        if things == 0 {
            self.model.notes.set_line(0);
            self.model.note("the file is empty");
        }
        Ok(())
    }

    /// Reads an object: modifier, type, name and arguments. Gives its name; `before` is the name
    /// and line of the one that ended where this begins.
    fn object<'t>(
        &mut self,
        words: &mut Words<'t>,
        before: Option<(&[u8], u64)>,
        context: &Context,
    ) -> Result<&'t [u8], Cause> {
        let modifier = words.word(true).unwrap_or_default();
        let word = words.word(true).ok_or_else(|| {
            syntax(format!("the file ends behind `{}`, where a type is expected", shown(modifier)))
        })?;
        let kind = Kind::of(word);
        let kind = kind.ok_or_else(|| {
            let mut text = format!("`{}` is not a type of object", shown(word));
            // What is no modifier may be an argument that was not announced.
            if let Some((name, line)) = before.filter(|_| self.names.get(modifier).is_none()) {
                let name = shown(name);
                text += &format!("; `{name}` of line {line}, before it, may have more arguments than it announces");
            }
            syntax(text)
        })?;
        let name = words.word(true).ok_or_else(|| {
            syntax(format!("the file ends behind `{}`, where a name is expected", shown(word)))
        })?;
        if kind == Kind::Alias {
            return self.alias(modifier, name, words).map(|()| name);
        }
        let modifier = match (kind, &context.modifier) {
            (Kind::Surface(_), Some(forced)) => forced.as_slice(),
            _ => modifier,
        };
        let about = || format!("{} `{}`", shown(word), shown(name));
        let modifier = self.modifier(modifier).map_err(|cause| behind(about(), cause))?;
        let corners = self.limits.corners.saturating_mul(3);
        let most = if kind == Kind::Surface(Shape::Polygon) { corners } else { u64::MAX };
        let mut arguments = std::mem::take(&mut self.arguments);
        let made = arguments
            .read(words, most)
            .and_then(|()| self.define(kind, modifier, [word, name], &arguments, context));
        self.arguments = arguments;
        made.map_err(|cause| behind(about(), cause))?;
        self.limits.room(self.model)?;
        Ok(name)
    }

    fn define(
        &mut self,
        kind: Kind,
        modifier: Modifier,
        [word, name]: [&[u8]; 2],
        arguments: &Arguments,
        context: &Context,
    ) -> Result<(), Cause> {
        let Self { model, names, .. } = self;
        match kind {
            Kind::Surface(shape) => {
                surface::add(model, names, context, modifier, shape, &arguments.numbers)
            }
            Kind::Material(stuff) => {
                let shown = [&shown(word)[..], &shown(name)];
                let (material, glow) =
                    material(stuff, shown, arguments, &context.xform, names, model)?;
                if modifier.pattern {
                    say_plain(&material, model);
                }
                names.define(name, material, glow);
                Ok(())
            }
            Kind::Pattern | Kind::Texture => {
                model.note("a pattern or texture: left out, the plain material is used");
                let pattern = kind == Kind::Pattern;
                if let Some(modified) = names.definition(modifier).filter(|_| pattern) {
                    say_plain(&modified.material, model);
                }
                names.set(name, Modifier { pattern: pattern || modifier.pattern, ..modifier });
                Ok(())
            }
            Kind::Mixture => {
                model.note("a mixture: only its foreground is used");
                let parts = arguments.strings.iter().take(2);
                let parts = parts.filter_map(|part| names.get(part.as_bytes()));
                let mut all = parts.chain([modifier]);
                let pattern = all.clone().any(|part| part.pattern);
                let material = all.find_map(|part| part.material);
                names.set(name, Modifier { material, pattern });
                Ok(())
            }
            Kind::Refused(what) => Err(syntax(format!("not read: it holds {what}"))),
            Kind::Alias => Ok(()),
        }
    }

    /// `modifier alias name what`: another name for a modifier, which is modified by the first.
    fn alias(&mut self, modifier: &[u8], name: &[u8], words: &mut Words<'_>) -> Result<(), Cause> {
        let about = || format!("alias `{}`", shown(name));
        let modifier = match modifier {
            b"inherit" => Modifier::VOID,
            modifier => self.modifier(modifier).map_err(|cause| behind(about(), cause))?,
        };
        let what = words.word(true).ok_or_else(|| syntax("the file ends inside an alias"))?;
        let what = self.modifier(what).map_err(|cause| behind(about(), cause))?;
        if let Some(named) = self.names.definition(what).filter(|_| modifier.pattern) {
            say_plain(&named.material, self.model);
        }
        self.names.set(name, Modifier { pattern: what.pattern || modifier.pattern, ..what });
        Ok(())
    }

    fn modifier(&self, name: &[u8]) -> Result<Modifier, Cause> {
        self.names.get(name).ok_or_else(|| {
            let name = shown(name);
            syntax(format!("the modifier `{name}` is not defined; define it before its first use"))
        })
    }

    /// Does what a command line says.
    fn command(
        &mut self,
        line: &[u8],
        path: &Path,
        place: &Place,
        context: &Context,
    ) -> Result<(), ImportError> {
        let pipes = command::parse(line).map_err(|c| ImportError::new(place.clone(), c))?;
        for Pipe { head, filters } in &pipes {
            if matches!(head, Head::Box(made) if made.facets) {
                self.model.note("genbox -n or -s: left out, round edges are cylinders and spheres");
            }
            self.filtered(head, filters, path, place, context)?;
        }
        Ok(())
    }

    /// Runs the head for each copy that the filters make, the last filter being the outermost.
    fn filtered(
        &mut self,
        head: &Head,
        filters: &[Stage],
        path: &Path,
        place: &Place,
        context: &Context,
    ) -> Result<(), ImportError> {
        if let Some((last, earlier)) = filters.split_last() {
            return self.copies(last, place, context, &mut |reader, context| {
                reader.filtered(head, earlier, path, place, context)
            });
        }
        match head {
            Head::Files(stage) => self.copies(stage, place, context, &mut |reader, context| {
                for file in &stage.files {
                    let file = Path::new(std::str::from_utf8(file).unwrap_or_default());
                    let near = path.parent().unwrap_or(Path::new("")).join(file);
                    // Radiance looks in the current directory.
                    let found = if near.exists() || !file.exists() { &near } else { file };
                    reader.include(found, context).map_err(|mut error| {
                        error.from.get_or_insert_with(|| place.clone());
                        error
                    })?;
                }
                Ok(())
            }),
            Head::Box(made) => {
                let name = context.modifier.as_deref().unwrap_or(&made.modifier);
                let at = |cause| ImportError::new(place.clone(), cause);
                let modifier = self.modifier(name).map_err(at)?;
                let Self { model, names, limits, .. } = self;
                made.make(&mut |shape, numbers| {
                    surface::add(model, names, context, modifier, shape, numbers)?;
                    limits.room(model)
                })
                .map_err(at)
            }
        }
    }

    /// Does something for each copy of an `xform`.
    fn copies(
        &mut self,
        stage: &Stage,
        place: &Place,
        context: &Context,
        each: &mut dyn FnMut(&mut Self, &Context) -> Result<(), ImportError>,
    ) -> Result<(), ImportError> {
        for index in 0..stage.copies() {
            self.copies += 1;
            if self.copies > self.limits.copies {
                let limit = self.limits.copies;
                let cause = Cause::Limit { what: "too many copies in all", limit };
                return Err(ImportError::new(place.clone(), cause));
            }
            let inner = Context {
                xform: stage.copy(index).then(&context.xform),
                invert: context.invert != stage.invert,
                modifier: context.modifier.clone().or_else(|| stage.modifier.clone()),
            };
            each(self, &inner)?;
        }
        Ok(())
    }
}

impl Arguments {
    /// Reads the three lists: strings, integers, numbers.
    fn read(&mut self, words: &mut Words<'_>, most: u64) -> Result<(), Cause> {
        self.strings.clear();
        self.numbers.clear();
        let strings = count(words)?;
        for found in 0..strings {
            let word = words.word(false).ok_or_else(|| ends("strings", strings, found))?;
            self.strings.push(String::from_utf8_lossy(word).into_owned());
        }
        let integers = count(words)?;
        for found in 0..integers {
            let word = words.value().ok_or_else(|| ends("integers", integers, found))?;
            number(word)?;
        }
        let numbers = count(words)?;
        if numbers > most {
            return Err(Cause::Limit { what: "too many numbers", limit: most });
        }
        for found in 0..numbers {
            let word = words.value().ok_or_else(|| ends("numbers", numbers, found))?;
            let value = number(word)
                .map_err(|cause| behind(format!("number {} of {numbers}", found + 1), cause))?;
            self.numbers.push(value);
        }
        Ok(())
    }
}

/// Says of a light that it is not as bright as its pattern would make it.
fn say_plain(material: &Material, model: &mut Model) {
    if material.radiance() != DVec3::ZERO {
        let text = "a light with a pattern: its brightness is not the real one, as the pattern is left out";
        model.notes.add_named(text, &material.name);
    }
}

/// The length of a list.
fn count(words: &mut Words<'_>) -> Result<u64, Cause> {
    let word = words.value().ok_or_else(|| syntax("the file ends inside it"))?;
    let value = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
    value.ok_or_else(|| syntax(format!("`{}` is not a count of arguments", shown(word))))
}

fn ends(what: &str, announced: u64, found: u64) -> Cause {
    syntax(format!("the file ends inside it: {announced} {what} announced, {found} found"))
}

/// Says what a cause is about.
fn behind(about: String, cause: Cause) -> Cause {
    match cause {
        Cause::Syntax(text) => Cause::Syntax(format!("{about}: {text}")),
        other => other,
    }
}
