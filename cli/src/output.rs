//! Files that appear complete or not at all.

use std::{
    collections::BTreeSet,
    fs::{self, File, OpenOptions},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
    sync::Mutex,
    time::Duration,
};

use tempfile::NamedTempFile;

use crate::{
    failure::{Failure, Outcome},
    input,
    interrupt::Partial,
};

/// Names of files that are not complete begin and end with these.
const PREFIX: &str = ".kiloray-";
const SUFFIX: &str = ".part";
/// One that nobody holds may have been made just now.
const ABANDONED_AFTER: Duration = Duration::from_secs(60);

/// A file to be written: under a name of its own beside its place, and renamed when complete.
///
/// Opening it shows at once, before any work, whether it can be written, and whether another output has the same place, or an input.
#[derive(Debug)]
pub(crate) struct Output {
    path: PathBuf,
    target: Target,
    /// Until it is written.
    claim: Option<Claim>,
}

/// Where something is being written.
static CLAIMED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// A place that no other output gets, as long as this lives.
#[derive(Debug)]
struct Claim(PathBuf);

impl Claim {
    /// `path` is what was typed, for the message.
    fn new(place: &Path, path: &Path) -> Outcome<Self> {
        if CLAIMED.lock().is_ok_and(|mut all| !all.insert(place.to_owned())) {
            let what = if path == Path::new("-") {
                "the standard output".into()
            } else {
                path.display().to_string()
            };
            return Err(Failure::usage(format_args!(
                "{what}: two outputs of this command go there; give each a place of its own"
            )));
        }
        Ok(Self(place.to_owned()))
    }
}

/// Whether an output is begun that will have this place.
pub(crate) fn is_claimed(place: &Path) -> bool {
    CLAIMED.lock().is_ok_and(|all| all.contains(place))
}

impl Drop for Claim {
    fn drop(&mut self) {
        if let Ok(mut all) = CLAIMED.lock() {
            all.remove(&self.0);
        }
    }
}

/// Removes what is left of commands that were killed, before they could: it is old, and nobody holds it.
fn remove_abandoned(folder: &Path) {
    let files = fs::read_dir(folder).into_iter().flatten().flatten();
    let is_part = |name: &str| name.starts_with(PREFIX) && name.ends_with(SUFFIX);
    for file in files.filter(|file| file.file_name().to_str().is_some_and(is_part)) {
        let is_old = file.metadata().is_ok_and(|found| {
            let age = found.modified().ok().and_then(|time| time.elapsed().ok());
            found.is_file() && age.is_some_and(|age| age > ABANDONED_AFTER)
        });
        let path = file.path();
        if is_old && File::open(&path).is_ok_and(|file| file.try_lock().is_ok()) {
            let _ = fs::remove_file(path);
        }
    }
}

/// A directory for outputs. Those that were made on the way to it go again, with an interrupt as well, if nothing was written into them.
#[derive(Debug)]
pub(crate) struct Folder {
    /// From the innermost.
    made: Vec<(PathBuf, Partial)>,
}

impl Folder {
    /// Makes the directory, and those above it.
    pub(crate) fn create(path: &Path) -> Outcome<Self> {
        let missing: Vec<_> = path
            .ancestors()
            .filter(|folder| *folder != Path::new(""))
            .take_while(|folder| fs::symlink_metadata(folder).is_err())
            .collect();
        let mut folder = Self { made: Vec::new() };
        for missing in missing.into_iter().rev() {
            match fs::create_dir(missing) {
                // As in `a/..` behind `a`, or somebody else was quicker.
                Err(_) if missing.is_dir() => {}
                made => {
                    made.map_err(|error| Failure::io(missing, &error))?;
                    let place = fs::canonicalize(missing).unwrap_or_else(|_| missing.to_owned());
                    let partial = Partial::new(&place);
                    folder.made.insert(0, (place, partial));
                }
            }
        }
        if !path.is_dir() {
            return Err(Failure::file(path, "is a file; give a directory, or a new name for one"));
        }
        Ok(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        for (folder, _) in &self.made {
            // One that is not empty stays.
            let _ = fs::remove_dir(folder);
        }
    }
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
        let (target, claim) = if path == Path::new("-") {
            (Target::Standard, Some(Claim::new(path, path)?))
        } else if let Some(kind) = fs::metadata(path).ok().filter(|kind| !kind.is_file()) {
            if kind.is_dir() {
                return Err(Failure::file(path, "is a directory; give a file name"));
            }
            // Several may write to one.
            let file = OpenOptions::new().write(true).open(path).map_err(io)?;
            (Target::Special(file), None)
        } else {
            input::spare(path)?;
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
            let folder = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
            let claim = Claim::new(&folder.join(place.file_name().unwrap_or_default()), path)?;
            remove_abandoned(&folder);
            let mut builder = tempfile::Builder::new();
            builder.prefix(PREFIX).suffix(SUFFIX);
            #[cfg(unix)]
            {
                use std::os::unix::fs::PermissionsExt;
                // As for any new file; the process's mask is taken from it.
                builder.permissions(fs::Permissions::from_mode(0o666));
            }
            let file = builder.tempfile_in(folder).map_err(io)?;
            let partial = Partial::new(file.path());
            // For others: somebody works on it.
            let _ = file.as_file().lock();
            (Target::File(file, partial), Some(claim))
        };
        Ok(Self { path: path.to_owned(), target, claim })
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
        let Self { path, target, claim: _claim } = self;
        let io = |error: io::Error| Failure::io(&path, &error);
        match target {
            Target::Standard => {
                let mut out = io::stdout().lock();
                write(&mut out)
                    .and_then(|()| out.flush())
                    .map_err(|error| Failure::io("standard output".as_ref(), &error))
            }
            Target::Special(file) => {
                let mut out = BufWriter::new(file);
                write(&mut out).and_then(|()| out.flush()).map_err(io)
            }
            Target::File(mut file, partial) => {
                let io = |error| io(error).and("nothing of it was left behind");
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
            matches!(failed, Err(Failure::Failed(message)) if message.ends_with("out.txt: the disk is full; nothing of it was left behind"))
        );
        assert_eq!(fs::read(&path).unwrap(), b"first");
        drop(Output::create(&path).unwrap());
        assert_eq!(names(), 1, "a partial file is left");

        Output::create(&path).unwrap().incomplete().write(b"half").unwrap();
        assert_eq!(fs::read(folder.path().join("out.incomplete.txt")).unwrap(), b"half");
        assert_eq!(fs::read(&path).unwrap(), b"first");
    }

    #[test]
    fn no_two_outputs_have_one_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt");
        let again = folder.path().join(".").join("out.txt");
        let first = Output::create(&path).unwrap();
        let refused = Output::create(&again);
        assert!(matches!(refused, Err(Failure::Usage(message)) if message.contains("out.txt")));
        first.write(b"first").unwrap();
        // There now, and free.
        let second = Output::create(&again).unwrap();
        assert!(Output::create(&path).is_err());
        second.write(b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
    }

    #[test]
    fn directories_that_stay_empty_go_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a").join("b");
        drop(Folder::create(&path).unwrap());
        assert!(!folder.path().join("a").exists());
        let made = Folder::create(&path).unwrap();
        Output::create(&path.join("out.txt")).unwrap().write(b"all").unwrap();
        drop(made);
        assert_eq!(fs::read(path.join("out.txt")).unwrap(), b"all");
        // What was there before stays, empty or not.
        fs::create_dir(folder.path().join("c")).unwrap();
        drop(Folder::create(&folder.path().join("c")).unwrap());
        assert!(folder.path().join("c").is_dir());
        let refused = Folder::create(&path.join("out.txt"));
        assert!(matches!(refused, Err(Failure::Failed(message)) if message.contains("is a file")));
    }

    #[test]
    fn what_was_abandoned_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt");
        let ours = Output::create(&path).unwrap();
        let part = |name: &str, age: u64| {
            let path = folder.path().join(format!("{PREFIX}{name}{SUFFIX}"));
            let file = File::create(&path).unwrap();
            file.set_modified(std::time::SystemTime::now() - Duration::from_secs(age)).unwrap();
            (path, file)
        };
        let (held, new, old) = (part("held", 900), part("new", 0), part("old", 900));
        held.1.lock().unwrap();
        Output::create(&folder.path().join("other.txt")).unwrap();
        assert_eq!([&held, &new, &old].map(|(path, _)| path.exists()), [true, true, false]);
        ours.write(b"all").unwrap();
        assert_eq!(fs::read(path).unwrap(), b"all");
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
