//! Radiance view options, on a command line or in a `.vf` file.

use std::path::Path;

use glam::DVec3;
use kiloray_core::scene::ViewKind;

use super::error::{place, syntax};
use super::scan::{Words, number, shown};
use super::{Cause, ImportError, Limits, text};
use crate::model::{Model, Notes, Place, View};

/// A view given by a person: view options (`-vp 0 0 1 -vd 0 1 0`), or the name of a file of them.
///
/// Options that are not given are those of `base`, else Radiance's: `-vtv -vp 0 0 0 -vd 0 1 0
/// -vu 0 0 1 -vh 45 -vv 45`, without shift, lift or clipping. With it comes what of a file was ignored.
///
/// # Errors
/// If the file cannot be read, or if an option is not as it should be. Of those that are typed each must be one of a view: a
/// file may hold a whole command.
pub fn view(argument: &str, base: Option<&View>) -> Result<(View, Notes), ImportError> {
    let mut model = Model::default();
    let mut view = base.cloned().unwrap_or_else(standard);
    if argument.trim_start().starts_with('-') {
        let here = |cause| {
            let file = Some("--view".into());
            ImportError::new(Place { file, line: 0 }, cause)
        };
        let foreign = |word: &[u8]| Err(unknown(word));
        options(&mut view, argument.as_bytes(), foreign).map_err(here)?;
        model.add_view(view).map_err(|e| here(e.into()))?;
    } else {
        file(&mut view, &mut model, Path::new(argument), &Limits::default())?;
    }
    let view = model.views.pop();
    let view = view.ok_or_else(|| ImportError::new(Place::default(), syntax("no view")))?;
    Ok((view, model.notes))
}

/// Reads a file of view options into the model: one view, named as the file.
pub(super) fn read(model: &mut Model, path: &Path, limits: &Limits) -> Result<(), ImportError> {
    file(&mut standard(), model, path, limits)
}

/// Radiance's view where nothing else is said.
fn standard() -> View {
    View {
        kind: ViewKind::Perspective,
        name: String::new(),
        position: DVec3::ZERO,
        direction: DVec3::Y,
        up: DVec3::Z,
        size: [45.0, 45.0],
        offset: [0.0; 2],
        clip: [0.0; 2],
    }
}

/// Each line of view options changes the same view, as in Radiance.
fn file(
    view: &mut View,
    model: &mut Model,
    path: &Path,
    limits: &Limits,
) -> Result<(), ImportError> {
    let mut at = place(path, 0);
    let text = text::read(model, path, limits).map_err(|c| ImportError::new(at.clone(), c))?;
    let mut found = 0;
    for (line, index) in text.split(|&b| b == b'\n').zip(1..) {
        at.line = index;
        model.notes.set_place(at.clone());
        let line = line.trim_ascii();
        // The options stand behind a program's name (`rvu -vtv ..`) or `VIEW=`.
        let begin = (0..line.len()).find(|&i| {
            let before = i.checked_sub(1).and_then(|i| line.get(i));
            before.is_none_or(|b| b.is_ascii_whitespace() || *b == b'=')
                && line.get(i..).is_some_and(|rest| rest.starts_with(b"-"))
        });
        let Some(rest) = begin.and_then(|i| line.get(i..)).filter(|_| !line.starts_with(b"#"))
        else {
            if !line.is_empty() && !line.starts_with(b"#") {
                model.note("a line without view options: left out");
            }
            continue;
        };
        let foreign = |_: &[u8]| {
            model.note("an option that is no view option: left out");
            Ok(())
        };
        found += options(view, rest, foreign).map_err(|c| ImportError::new(at.clone(), c))?;
    }
    at.line = 0;
    if found == 0 {
        return Err(ImportError::new(at, syntax("no view options in it, such as -vp 0 0 1")));
    }
    if let Some(stem) = path.file_stem() {
        view.name = stem.to_string_lossy().into_owned();
    }
    model.add_view(view.clone()).map_err(|e| ImportError::new(at, e))
}

/// Changes a view by options, and counts those that are view options. What else there is goes to `foreign`.
fn options(
    view: &mut View,
    text: &[u8],
    mut foreign: impl FnMut(&[u8]) -> Result<(), Cause>,
) -> Result<usize, Cause> {
    let mut words = Words::new(text);
    let mut found = 0;
    while let Some(option) = words.word(false) {
        let mut value = || match words.word(false) {
            Some(word) => number(word).map_err(|cause| {
                syntax(format!("the view option `{}` takes numbers: {cause}", shown(option)))
            }),
            None => Err(syntax(format!(
                "the view option `{}` lacks a number; -vp, -vd and -vu take three, others one",
                shown(option)
            ))),
        };
        let mut vector = || Ok::<_, Cause>(DVec3::new(value()?, value()?, value()?));
        found += 1;
        match option {
            b"-vp" => view.position = vector()?,
            b"-vd" => view.direction = vector()?,
            b"-vu" => view.up = vector()?,
            b"-vh" => view.size[0] = value()?,
            b"-vv" => view.size[1] = value()?,
            b"-vs" => view.offset[0] = value()?,
            b"-vl" => view.offset[1] = value()?,
            b"-vo" => view.clip[0] = value()?,
            b"-va" => view.clip[1] = value()?,
            b"-vtv" => view.kind = ViewKind::Perspective,
            b"-vtl" => view.kind = ViewKind::Parallel,
            [b'-', b'v', b't', ..] => {
                let option = shown(option);
                return Err(syntax(format!(
                    "the view type `{option}` is not built in; take -vtv (perspective) or -vtl (parallel)"
                )));
            }
            [b'-', b'v', ..] => return Err(unknown(option)),
            _ => {
                found -= 1;
                foreign(option)?;
            }
        }
    }
    Ok(found)
}

fn unknown(option: &[u8]) -> Cause {
    syntax(format!(
        "`{}` is not a view option; there are -vtv -vtl -vp -vd -vu -vh -vv -vs -vl -vo -va",
        shown(option)
    ))
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;

    fn view(argument: &str, base: Option<&View>) -> Result<View, ImportError> {
        super::view(argument, base).map(|(view, _)| view)
    }

    #[test]
    fn options_change_what_they_name() {
        let text = "-vtl -vp 1 2 3 -vd 0 0 -9 -vu 0 1 0 -vh 4 -vv 2 -vs .5 -vl -.25 -vo 1 -va 9";
        let view = view(text, None).unwrap();
        assert_eq!(view.kind, ViewKind::Parallel);
        assert_eq!(view.position, dvec3(1.0, 2.0, 3.0));
        assert_eq!(view.direction, dvec3(0.0, 0.0, -1.0));
        assert_eq!(view.up, DVec3::Y);
        assert_eq!((view.size, view.offset, view.clip), ([4.0, 2.0], [0.5, -0.25], [1.0, 9.0]));
    }

    #[test]
    fn what_is_not_given_is_the_base_or_the_standard() {
        let first = view("-vp 1 0 0", None).unwrap();
        assert_eq!((first.direction, first.size), (DVec3::Y, [45.0, 45.0]));
        let second = view("-vh 60", Some(&first)).unwrap();
        assert_eq!((second.position, second.size), (DVec3::X, [60.0, 45.0]));
    }

    #[test]
    fn bad_options_are_named() {
        for (bad, says) in [
            ("-vth", "-vth"),
            ("-vp 1 2", "-vp, -vd and -vu take three"),
            ("-vp 1 2 nan", "finite"),
            ("-vp 1 2 x", "`-vp` takes numbers: `x`"),
            ("-vq 3", "there are -vtv"),
            ("-vp 1 2 3 -foo", "`-foo` is not a view option; there are -vtv"),
            ("-pv 3 4 5", "`-pv` is not"),
            ("-vp 3 4 5 junk", "`junk` is not"),
            ("-vh 180", "180"),
            ("-vd 0 0 0", "direction"),
            ("-vd 0 0 1", "parallel"),
            ("-va 1 -vo 2", "clipping"),
        ] {
            let error = view(bad, None).unwrap_err().to_string();
            assert!(error.contains(says) && !error.contains('\n'), "{bad}: {error}");
        }
        assert!(view("no/such/file.vf", None).unwrap_err().to_string().contains("no such file"));
    }

    #[test]
    fn what_else_is_in_a_file_is_noted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vf");
        std::fs::write(&path, "rvu -vp 0 0 1 -x 800\nhello\n").unwrap();
        let (view, notes) = super::view(path.to_str().unwrap(), None).unwrap();
        assert_eq!(view.position, DVec3::Z);
        let told: Vec<_> = notes.iter().map(|note| (note.first.line, note.count)).collect();
        assert_eq!(told, [(1, 2), (2, 1)]);
    }
}
