//! Writing a file so that under its name there is all of it or nothing.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Names that are tried for the file beside: others may have been left by processes that died.
const TRIES: u32 = 100;

/// Writes the bytes to a file beside `path`, and renames it when all is on the disk. What is no
/// regular file (a pipe, a device) is written as it is.
pub(super) fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
        return File::options().write(true).open(path)?.write_all(bytes);
    }
    write_with(path, |file| {
        file.write_all(bytes)?;
        // A full disk may show only here.
        file.sync_all()
    })
}

/// The same, with whatever `fill` writes.
pub(super) fn write_with(
    path: &Path,
    fill: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    // A link stays one: its target is replaced.
    let path = fs::canonicalize(path).unwrap_or_else(|_| path.into());
    let (mut file, beside) = create_beside(&path)?;
    let filled = fill(&mut file);
    drop(file);
    let done = filled.and_then(|()| fs::rename(&beside, &path));
    if done.is_err() {
        // What is left is of no use; that it cannot be removed is no news beside the first error.
        let _ = fs::remove_file(&beside);
    }
    done
}

/// A new file in the same directory, with a name that no other has.
fn create_beside(path: &Path) -> io::Result<(File, PathBuf)> {
    let name = path
        .file_name()
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"))?;
    let mut last = io::ErrorKind::AlreadyExists.into();
    for attempt in 0..TRIES {
        let mut hidden = OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}-{attempt}", std::process::id()));
        let beside = path.with_file_name(hidden);
        match File::create_new(&beside) {
            Ok(file) => return Ok((file, beside)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => last = error,
            Err(error) => return Err(error),
        }
    }
    Err(last)
}
