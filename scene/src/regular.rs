//! Files that have an end: neither pipes nor devices, which may have none, or never begin.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Opens a regular file.
///
/// # Errors
/// What the system says; [`io::ErrorKind::InvalidInput`] for what is no regular file, [`io::ErrorKind::IsADirectory`] for a directory.
pub fn open(path: &Path) -> io::Result<File> {
    // Before it is opened: a pipe would wait for who writes.
    let found = fs::metadata(path)?;
    if found.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !found.is_file() {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "is not a regular file; give the name of one",
        ));
    }
    File::open(path)
}

/// Reads a regular file of at most so many bytes.
///
/// # Errors
/// As [`open`]; [`io::ErrorKind::FileTooLarge`].
pub fn read(path: &Path, bytes_max: u64) -> io::Result<Vec<u8>> {
    let mut file = open(path)?.take(bytes_max.saturating_add(1));
    let too_long = || {
        let cause = format!("is longer than the {bytes_max} bytes that such a file can have");
        io::Error::new(io::ErrorKind::FileTooLarge, cause)
    };
    let len = file.get_ref().metadata()?.len();
    if len > bytes_max {
        return Err(too_long());
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(usize::try_from(len).unwrap_or(usize::MAX))?;
    file.read_to_end(&mut bytes)?;
    if bytes.len() as u64 > bytes_max { Err(too_long()) } else { Ok(bytes) }
}

/// What the system says of a file, in words that say what to do; without its numbers.
#[must_use]
pub fn words(error: &io::Error) -> String {
    use io::ErrorKind as Kind;
    let words = match error.kind() {
        Kind::NotFound => "no such file or directory",
        Kind::PermissionDenied => "permission denied",
        Kind::StorageFull => "the disk is full",
        Kind::QuotaExceeded => "the disk quota is used up",
        Kind::ReadOnlyFilesystem => "the file system is read-only",
        Kind::IsADirectory => "is a directory, not a file",
        Kind::NotADirectory => "a part of the path is a file, not a directory",
        _ if error.raw_os_error() == Some(LOOP) => {
            "symbolic links lead in a circle; make them lead to a file"
        }
        _ => {
            let said = error.to_string();
            return said.split(" (os error").next().unwrap_or_default().into();
        }
    };
    words.into()
}

/// Too many symbolic links on a path (`ELOOP`): the standard library has no stable name for it.
const LOOP: i32 = if cfg!(target_os = "linux") { 40 } else { 62 };

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_with_an_end_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, b"1234").unwrap();
        assert_eq!(read(&path, 4).unwrap(), b"1234");
        let kind = |path: &Path, max| read(path, max).unwrap_err().kind();
        assert_eq!(kind(&path, 3), io::ErrorKind::FileTooLarge);
        assert_eq!(kind(folder.path(), 3), io::ErrorKind::IsADirectory);
        #[cfg(unix)]
        assert_eq!(kind("/dev/zero".as_ref(), 3), io::ErrorKind::InvalidInput);
        // It says that it is empty.
        #[cfg(target_os = "linux")]
        assert_eq!(kind("/proc/self/status".as_ref(), 3), io::ErrorKind::FileTooLarge);
    }

    #[cfg(unix)]
    #[test]
    fn words_have_no_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::os::unix::fs::symlink(&path, &path).unwrap();
        let said = |path: &Path| words(&open(path).unwrap_err());
        assert!(said(&path).contains("in a circle; make"), "{}", said(&path));
        let long = folder.path().join("a".repeat(1000));
        assert!(!said(&long).is_empty() && !said(&long).contains("os error"), "{}", said(&long));
    }
}
