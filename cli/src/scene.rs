//! From what was typed to a compiled scene.

use std::{
    io::Read,
    path::{Path, PathBuf},
    sync::Once,
};

use kiloray_core::{block::FileError, node::ShareHeader, scene::View};
use kiloray_scene::{
    builtin,
    compile::{self, CompileError, Stage, Stats},
    import::{self, ImportOptions},
    kilo::{KiloError, KiloFile},
    model::{self, Model, Note},
    needs::Summary,
    regular,
};

use crate::{
    args::{self, ViewChoice, size::typed},
    console,
    failure::{self, Failure, Outcome},
    input, memory,
    progress::Progress,
};

/// A scene, ready to be traced.
#[derive(Debug)]
pub(crate) struct Scene {
    /// What files that belong to it are called.
    pub(crate) name: String,
    /// Its blocks.
    pub(crate) file: KiloFile,
    /// What the compiler did; `None` for a `.kilo` file.
    pub(crate) stats: Option<Stats>,
    /// What the compiler left out; `None` for a `.kilo` file.
    pub(crate) summary: Option<Summary>,
    /// What was ignored or repaired.
    pub(crate) notes: Vec<String>,
    /// The view that was typed, or is in a file that was named, with its name.
    typed: Option<(String, model::View)>,
    /// They were printed.
    told: Once,
    quiet: bool,
}

/// One of the names typed.
enum Source {
    Builtin(String),
    Compiled(PathBuf),
    File(PathBuf),
}

/// Reads and compiles. `block` is what was asked for, `fallback` the size otherwise.
pub(crate) fn load(
    args::Scene { scenes, lights }: &args::Scene,
    block: Option<u32>,
    fallback: u32,
    quiet: bool,
) -> Outcome<Scene> {
    let sources = scenes.iter().map(|name| source(name)).collect::<Outcome<Vec<_>>>()?;
    if let Some(Source::Compiled(path)) = sources.iter().find(|s| matches!(s, Source::Compiled(_)))
    {
        if sources.len() > 1 {
            return Err(Failure::usage(format_args!(
                "{}: a compiled scene stands alone; choose a view with --view",
                path.display()
            )));
        }
        return open(path, block, fallback, quiet);
    }
    let mut notes = Vec::new();
    let read = {
        let progress = Progress::new("reading", 0, quiet);
        progress.message(scenes[0].display().to_string());
        read(&sources, &mut notes)
    };
    let model = read.inspect_err(|_| tell(&notes, quiet))?;
    model.files.iter().try_for_each(|file| input::keep(file))?;
    notes.extend(model.notes.iter().map(Note::to_string));
    let options = compile::Options {
        block_bytes: block.unwrap_or(fallback) as usize,
        lights_max: *lights as usize,
    };
    let mut stage = None;
    let mut report = |next: Stage, done: u64, total: u64| {
        let current = match stage.take() {
            Some((last, progress)) if last == next => progress,
            other => {
                drop(other);
                Progress::new(next.name(), total, quiet)
            }
        };
        current.set(done);
        stage = Some((next, current));
    };
    let compiled = compile::compile(&model, &options, &mut report);
    drop(stage);
    let compiled = compiled.inspect_err(|_| tell(&notes, quiet)).map_err(refused)?;
    let (stats, summary) = (compiled.stats.clone(), compiled.summary.clone());
    let name = match &sources[0] {
        Source::Builtin(name) => name.replace(':', "-"),
        Source::Compiled(path) | Source::File(path) => stem(path),
    };
    if stats.dropped > 0 {
        notes.push(format!(
            "a surface that is too small beside the whole scene for 32 bits: left out ({} {})",
            stats.dropped,
            if stats.dropped == 1 { "time" } else { "times" },
        ));
    }
    if stats.is_coarse() {
        notes.push(format!(
            "the scene reaches so far that 32 bits hold positions to {:.1e} only, more than a hundredth of the size of {} of {} surfaces: \
             leave out what lies far away, and make a sun a `source`, not a sphere",
            stats.coarse_error,
            console::count(stats.coarse),
            console::count(stats.triangles + stats.spheres),
        ));
    }
    let file = KiloFile::from_compiled(compiled);
    let (stats, summary) = (Some(stats), Some(summary));
    Ok(Scene { name, file, stats, summary, notes, typed: None, told: Once::new(), quiet })
}

/// So many times the size that suits a memory leave it few blocks, which is worth a note.
const TOO_GREAT: u32 = 8;

fn open(path: &Path, block: Option<u32>, suits: u32, quiet: bool) -> Outcome<Scene> {
    input::keep(path)?;
    let file = KiloFile::open(path).map_err(|error| match error {
        KiloError::Io { path, source } => Failure::io(&path, &source),
        KiloError::Damaged { path, error: FileError::Magic } if is_share(&path) => Failure::file(
            &path,
            "is the share of one node, for its read-only memory: name the scene itself, \
             as 'kiloray compile SCENE -o scene.kilo' writes it",
        ),
        KiloError::Damaged { path, error } => Failure::file(
            &path,
            format!("{error}; the file is damaged or of another version: compile the scene again"),
        ),
        other => Failure::new(other),
    })?;
    let has = file.view().header().block_bytes;
    let is_great = block.is_none() && has / TOO_GREAT >= suits;
    let note = || {
        format!(
            "{}: its blocks of {} are great for this memory, of which few are at hand then: 'kiloray compile --block {}' suits it",
            path.display(),
            typed(has.into()),
            typed(suits.into()),
        )
    };
    match block {
        Some(wanted) if wanted != has => Err(Failure::usage(format_args!(
            "{}: is compiled to blocks of {has} bytes; leave out --block, or compile the scene again",
            path.display()
        ))),
        _ => Ok(Scene {
            name: stem(path),
            file,
            stats: None,
            summary: None,
            notes: is_great.then(note).into_iter().collect(),
            typed: None,
            told: Once::new(),
            quiet,
        }),
    }
}

/// Whether a file is what `kiloray compile --for-node` writes.
fn is_share(path: &Path) -> bool {
    let mut start = [0; ShareHeader::MAGIC.len()];
    let read = regular::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && start == ShareHeader::MAGIC
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned())
}

/// Whether the name is that of a file.
pub(crate) fn is_file(name: &Path) -> bool {
    matches!(source(name), Ok(Source::Compiled(_) | Source::File(_)))
}

/// A file where the name looks like one, with an extension or in a folder; else a built-in scene, else a file that is there.
fn source(name: &Path) -> Outcome<Source> {
    let extension = name.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let text = name.to_string_lossy();
    if extension.as_deref() == Some("kilo") {
        return Ok(Source::Compiled(name.to_owned()));
    }
    let looks_like_file = extension.is_some() || text.contains(['/', '\\']);
    if let Ok((entry, size)) = builtin::find(&text)
        && !looks_like_file
    {
        let name =
            if entry.size.is_some() { format!("{}:{size}", entry.name) } else { text.into() };
        return Ok(Source::Builtin(name));
    }
    if looks_like_file || name.exists() {
        return Ok(Source::File(name.to_owned()));
    }
    match builtin::find(&text) {
        Err(error @ builtin::BuiltinError::Unknown { .. }) => {
            Err(Failure::usage(format_args!("{error}; and there is no such file")))
        }
        Err(error) => Err(Failure::usage(error)),
        Ok(_) => Ok(Source::Builtin(text.into())),
    }
}

/// What the compiler will not take, and what to do then.
fn refused(error: CompileError) -> Failure {
    match error {
        CompileError::Lights { count, limit } => Failure::new(format_args!(
            "{} {}, and at most {}: give fewer faces a material that emits, or allow more with --lights {count}",
            console::count(count as u64),
            if count == 1 { "light" } else { "lights" },
            console::count(limit as u64),
        )),
        error => Failure::new(error),
    }
}

/// One model of all sources, in their order. Views that were named as files come first. Where there is an error, `notes` are what was
/// ignored or repaired before it.
fn read(sources: &[Source], notes: &mut Vec<String>) -> Outcome<Model> {
    let files: Vec<_> = sources
        .iter()
        .filter_map(|s| if let Source::File(path) = s { Some(path) } else { None })
        .collect();
    let mut builtins = sources.iter().filter_map(|s| match s {
        Source::Builtin(name) => Some(name),
        _ => None,
    });
    let Some(name) = builtins.next() else {
        let model = import::load(&files, &ImportOptions::default()).map_err(|error| {
            notes.extend(error.notes.iter().map(Note::to_string));
            Failure::new(error)
        })?;
        let surfaces = (model.triangles.len() + model.spheres.len()) as u64;
        memory::for_surfaces(surfaces, &files[0].display().to_string())?;
        return Ok(model);
    };
    if let Some(other) = builtins.next() {
        return Err(Failure::usage(format_args!(
            "'{other}' beside '{name}': built-in scenes cannot be put together"
        )));
    }
    let (entry, size) = builtin::find(name).map_err(Failure::usage)?;
    memory::for_surfaces(entry.surfaces(size), name)?;
    let mut model = builtin::build(name).map_err(Failure::usage)?;
    for (at, path) in files.into_iter().enumerate() {
        if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("vf")) {
            return Err(Failure::usage(format_args!(
                "{}: only a view (.vf) can stand beside the built-in scene '{name}'",
                path.display()
            )));
        }
        let (view, told) = import::view(&path.to_string_lossy(), None).map_err(Failure::new)?;
        notes.extend(told.iter().map(Note::to_string));
        model.views.insert(at, view);
    }
    Ok(model)
}

impl Scene {
    /// Materials and lights of the input that change nothing, and were left out.
    pub(crate) fn left_out(&self) -> [u64; 2] {
        self.summary.as_ref().map_or([0; 2], |summary| {
            [summary.materials_unused as u64, summary.lights_dark.values().sum()]
        })
    }

    /// Forgets the word on the default view, where another is chosen that is not of the scene, and adds what is to say of that. (What is wrong
    /// with it is said when it is looked for.)
    pub(crate) fn with_view(mut self, choice: Option<&ViewChoice>) -> Self {
        if let Some(ViewChoice::Options(text)) = choice {
            self.notes.retain(|note| !note.starts_with("no view given"));
            if let Ok((view, told)) = import::view(text, None) {
                self.notes.extend(told.iter().map(Note::to_string));
                self.typed = Some((text.clone(), view));
            }
        }
        self
    }

    /// Says once what was ignored or repaired.
    pub(crate) fn print_notes(&self, quiet: bool) {
        self.told.call_once(|| tell(&self.notes, quiet));
    }

    /// The view to render. If there is none, the notes may say why.
    pub(crate) fn choose_view(&self, choice: Option<&ViewChoice>) -> Outcome<View> {
        self.find_view(choice).inspect_err(|_| self.print_notes(self.quiet))
    }

    fn find_view(&self, choice: Option<&ViewChoice>) -> Outcome<View> {
        let file = self.file.view();
        let views = file.views();
        let names = || {
            let all: Vec<_> = views
                .iter()
                .enumerate()
                .map(|(i, view)| format!("{} ({})", i + 1, view_name(view)))
                .collect();
            if all.is_empty() { "it has none".into() } else { format!("it has {}", all.join(", ")) }
        };
        match choice {
            None => views.first().copied().ok_or_else(|| {
                Failure::new(format_args!("{}: no view; give one with --view FILE.vf", self.name))
            }),
            Some(ViewChoice::Number(number)) => {
                views.get(*number as usize - 1).copied().ok_or_else(|| {
                    Failure::usage(format_args!("the scene has no view {number}; {}", names()))
                })
            }
            Some(ViewChoice::Name(name)) => {
                views.iter().find(|view| view_name(view) == *name).copied().ok_or_else(|| {
                    Failure::usage(format_args!("the scene has no view '{name}'; {}", names()))
                })
            }
            Some(ViewChoice::Options(text)) => {
                let is_typed = text.starts_with('-');
                let read = |text: &String| {
                    import::view(text, None).map(|(view, _)| view).map_err(|error| {
                        if is_typed { Failure::usage(error) } else { Failure::new(error) }
                    })
                };
                let known = self.typed.as_ref().filter(|(of, _)| of == text);
                let view = known.map_or_else(|| read(text), |(_, view)| Ok(view.clone()))?;
                compile::view_in(&file.header().frame, &view)
                    .ok_or_else(|| Failure::new(format_args!("{text}: the view has no direction")))
            }
        }
    }
}

/// Prints what was ignored or repaired.
fn tell(notes: &[String], quiet: bool) {
    if !quiet {
        notes.iter().for_each(|note| failure::warn(note));
    }
}

/// The name of a view.
pub(crate) fn view_name(view: &View) -> String {
    let end = view.name.iter().position(|&b| b == 0).unwrap_or(view.name.len());
    String::from_utf8_lossy(&view.name[..end]).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_light_is_no_lights() {
        let refused = |count| refused(CompileError::Lights { count, limit: 0 });
        assert!(refused(1).message().starts_with("1 light, and at most 0: "));
        assert!(refused(2).message().starts_with("2 lights, and at most 0: "));
    }

    #[test]
    fn a_file_of_a_view_is_read_once() {
        let folder = tempfile::tempdir().expect("a directory");
        let file = folder.path().join("once.vf");
        std::fs::write(&file, "rvu -vtl -vp 1 2 3 -vd 0 1 0 -vu 0 0 1\n").expect("it is written");
        let sources = args::Scene { scenes: vec!["cornell".into()], lights: 64 };
        let scene = load(&sources, None, 1024, true).expect("the scene");
        let choice = ViewChoice::Options(file.display().to_string());
        let scene = scene.with_view(Some(&choice));
        std::fs::remove_file(&file).expect("it is there");
        scene.choose_view(Some(&choice)).expect("the view that was read");
    }
}
