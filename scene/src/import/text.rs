//! Whole files as text, bounded.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use super::{Cause, Limits};
use crate::model::Model;

/// Reads a file that is text: not larger than the limit, and without zero bytes. A byte order mark
/// and the end of the file that DOS writes are left out; where carriage returns alone end lines,
/// newlines do. The model knows it then as one of its files.
pub(super) fn read(model: &mut Model, path: &Path, limits: &Limits) -> Result<Vec<u8>, Cause> {
    let known = match fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Err(Cause::Missing),
        known => known?,
    };
    // A pipe or a device may have no end, or never begin.
    if !known.is_file() {
        return Err(Cause::Kind("cannot be read: not a regular file"));
    }
    let too_long =
        || Cause::Limit { what: "the file is too long [bytes]", limit: limits.file_bytes };
    if known.len() > limits.file_bytes {
        return Err(too_long());
    }
    let mut file = File::open(path)?.take(limits.file_bytes.saturating_add(1));
    let mut text = Vec::new();
    let len = usize::try_from(known.len()).unwrap_or(usize::MAX);
    text.try_reserve_exact(len).map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    // What is no text shows it soon.
    file.by_ref().take(1 << 16).read_to_end(&mut text)?;
    check(&text)?;
    file.read_to_end(&mut text)?;
    if text.len() as u64 > limits.file_bytes {
        return Err(too_long());
    }
    check(&text)?;
    if text.starts_with(b"\xef\xbb\xbf") {
        text.drain(..3);
    }
    text.pop_if(|last| *last == 0x1a);
    if !text.contains(&b'\n') {
        text.iter_mut().filter(|b| **b == b'\r').for_each(|b| *b = b'\n');
    }
    model.files.push(path.to_owned());
    Ok(text)
}

/// Refuses what is no text.
fn check(text: &[u8]) -> Result<(), Cause> {
    // No text holds a zero byte, UTF-16 does: neither is read. Control characters stand for the
    // compressed and the encrypted.
    let head = text.get(..4096.min(text.len())).unwrap_or_default();
    let control = |&&b: &&u8| b < 0x20 && !matches!(b, b'\t' | b'\n' | b'\r' | 0x0b | 0x0c | 0x1a);
    let strange = head.iter().filter(control).count();
    if text.contains(&0) || strange * 50 > head.len() { Err(Cause::Binary) } else { Ok(()) }
}
