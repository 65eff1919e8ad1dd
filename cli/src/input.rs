//! Files that are read, and that no output of the same command may replace.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    sync::Mutex,
};

use crate::{
    failure::{Failure, Outcome},
    output,
};

/// What this command reads, or has read.
static KEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// The bytes of a regular file that has at most so many: a pipe or a device may have no end, or never begin.
pub(crate) fn read(path: &Path, bytes_max: u64) -> Outcome<Vec<u8>> {
    keep(path)?;
    kiloray_scene::regular::read(path, bytes_max).map_err(|error| Failure::io(path, &error))
}

/// Says that the command reads a file: no output gets its place, neither one that is begun already nor one that comes later.
pub(crate) fn keep(path: &Path) -> Outcome {
    let Some(place) = place(path) else { return Ok(()) };
    if output::is_claimed(&place) {
        return Err(refused(path));
    }
    if let Ok(mut kept) = KEPT.lock() {
        kept.insert(place);
    }
    Ok(())
}

/// Refuses an output where a file is that the command reads.
pub(crate) fn spare(path: &Path) -> Outcome {
    let is_kept = |place: PathBuf| KEPT.lock().is_ok_and(|kept| kept.contains(&place));
    if place(path).is_some_and(is_kept) { Err(refused(path)) } else { Ok(()) }
}

/// What is not there is nobody's input, and a device is not replaced.
fn place(path: &Path) -> Option<PathBuf> {
    fs::canonicalize(path).ok().filter(|place| place.is_file())
}

fn refused(path: &Path) -> Failure {
    Failure::usage(format_args!(
        "{}: this command reads it; give its output a place of its own",
        path.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Output;

    /// Whichever comes first, and by whatever name.
    #[test]
    fn what_is_read_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let [read, written] = ["read.mtl", "written.mtl"].map(|name| folder.path().join(name));
        for path in [&read, &written] {
            fs::write(path, "as it was").unwrap();
        }
        keep(&read).unwrap();
        let again = folder.path().join(".").join("read.mtl");
        assert!(spare(&again).is_err());
        assert!(matches!(Output::create(&again), Err(Failure::Usage(m)) if m.contains("reads it")));
        let output = Output::create(&written).unwrap();
        assert!(matches!(keep(&written), Err(Failure::Usage(m)) if m.contains("reads it")));
        drop(output);
        keep(&written).unwrap();
        keep(&folder.path().join("missing.mtl")).unwrap();
        assert_eq!(fs::read(&written).unwrap(), b"as it was");
    }
}
