//! Files that appear complete or not at all.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
};

use tempfile::NamedTempFile;

use crate::{
    failure::{Failure, Outcome},
    interrupt::Partial,
};

/// A file to be written: under a name of its own beside its place, and renamed when complete.
///
/// Opening it shows at once, before any work, whether it can be written.
#[derive(Debug)]
pub(crate) struct Output {
    path: PathBuf,
    target: Target,
}

#[derive(Debug)]
enum Target {
    /// `-`.
    Standard,
    /// A device or a pipe, which a rename would replace.
    Special(File),
    File(NamedTempFile, Partial),
}

impl Output {
    /// Begins a file; `-` is the standard output.
    pub(crate) fn create(path: &Path) -> Outcome<Self> {
        let io = |error: io::Error| Failure::io(path, &error);
        let target = if path == Path::new("-") {
            Target::Standard
        } else if let Some(kind) = fs::metadata(path).ok().filter(|kind| !kind.is_file()) {
            if kind.is_dir() {
                return Err(Failure::file(path, "is a directory; give a file name"));
            }
            Target::Special(OpenOptions::new().write(true).open(path).map_err(io)?)
        } else {
            // A link stays, what it leads to is replaced.
            let place = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
            let folder = match place.parent() {
                Some(folder) if folder != Path::new("") => folder,
                _ => Path::new("."),
            };
            if !folder.is_dir() {
                let cause =
                    format!("there is no directory '{}'; create it first", folder.display());
                return Err(Failure::file(path, cause));
            }
            let mut builder = tempfile::Builder::new();
            builder.prefix(".kiloray-").suffix(".part");
            #[cfg(unix)]
            {
                use std::os::unix::fs::PermissionsExt;
                // As for any new file; the process's mask is taken from it.
                builder.permissions(fs::Permissions::from_mode(0o666));
            }
            let file = builder.tempfile_in(folder).map_err(io)?;
            let partial = Partial::new(file.path());
            Target::File(file, partial)
        };
        Ok(Self { path: path.to_owned(), target })
    }

    /// The same file under a name that says that it is not all: `room.incomplete.png`.
    pub(crate) fn incomplete(mut self) -> Self {
        if let (Target::File(..), Some(stem)) = (&self.target, self.path.file_stem()) {
            let mut name = stem.to_owned();
            name.push(".incomplete");
            if let Some(extension) = self.path.extension() {
                name.push(".");
                name.push(extension);
            }
            self.path.set_file_name(name);
        }
        self
    }

    /// Where it will be.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the whole file and puts it in its place.
    pub(crate) fn write(self, bytes: &[u8]) -> Outcome {
        self.write_with(|out| out.write_all(bytes))
    }

    /// As [`Output::write`], piece by piece.
    pub(crate) fn write_with(
        self,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Outcome {
        let Self { path, target } = self;
        let io = |error: io::Error| Failure::io(&path, &error);
        match target {
            Target::Standard => {
                let mut out = io::stdout().lock();
                write(&mut out).and_then(|()| out.flush()).map_err(io)
            }
            Target::Special(file) => {
                let mut out = BufWriter::new(file);
                write(&mut out).and_then(|()| out.flush()).map_err(io)
            }
            Target::File(mut file, partial) => {
                let mut out = BufWriter::new(file.as_file_mut());
                write(&mut out).and_then(|()| out.flush()).map_err(io)?;
                drop(out);
                // Some systems tell of a full disk only here.
                file.as_file().sync_all().map_err(io)?;
                let place = fs::canonicalize(&path).unwrap_or_else(|_| path.clone());
                file.persist(place).map_err(|error| io(error.error))?;
                drop(partial);
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_appears_when_it_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt");
        let names = || fs::read_dir(folder.path()).unwrap().count();

        let output = Output::create(&path).unwrap();
        assert!(!path.exists());
        output.write(b"first").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"first");

        let failed = Output::create(&path)
            .unwrap()
            .write_with(|out| out.write_all(b"half").and(Err(io::ErrorKind::StorageFull.into())));
        assert!(
            matches!(failed, Err(Failure::Failed(message)) if message.contains("disk is full"))
        );
        assert_eq!(fs::read(&path).unwrap(), b"first");
        drop(Output::create(&path).unwrap());
        assert_eq!(names(), 1, "a partial file is left");

        Output::create(&path).unwrap().incomplete().write(b"half").unwrap();
        assert_eq!(fs::read(folder.path().join("out.incomplete.txt")).unwrap(), b"half");
        assert_eq!(fs::read(&path).unwrap(), b"first");
    }

    #[cfg(unix)]
    #[test]
    fn a_new_file_has_the_usual_permissions_and_a_link_stays() {
        use std::os::unix::fs::MetadataExt;
        let folder = tempfile::tempdir().unwrap();
        let (file, link, plain) =
            (folder.path().join("a"), folder.path().join("b"), folder.path().join("c"));
        File::create(&plain).unwrap();
        Output::create(&file).unwrap().write(b"1").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        Output::create(&link).unwrap().write(b"2").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"2");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        let mode = |path| fs::metadata(path).unwrap().mode();
        assert_eq!(mode(&file), mode(&plain));
    }
}
