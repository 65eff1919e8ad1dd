//! Words, numbers and lines of a text.

use super::Cause;
use super::error::syntax;

/// A finite number.
pub(super) fn number(word: &[u8]) -> Result<f64, Cause> {
    let value = std::str::from_utf8(word).ok().and_then(|w| w.parse::<f64>().ok());
    match value {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(syntax(format!("`{}` is not a finite number", shown(word)))),
        None => Err(syntax(format!("`{}` is not a number", shown(word)))),
    }
}

/// A word as it can stand in a message of one line: what is not printable is replaced, what is
/// long is cut.
pub(super) fn shown(word: &[u8]) -> String {
    const LENGTH_MAX: usize = 40;
    let text = String::from_utf8_lossy(word);
    let mut out: String =
        text.chars().take(LENGTH_MAX).map(|c| if c.is_control() { '?' } else { c }).collect();
    if text.chars().nth(LENGTH_MAX).is_some() {
        out.push('…');
    }
    out
}

/// Space as in C, which has the vertical tab too.
fn is_space(byte: u8) -> bool {
    byte.is_ascii_whitespace() || byte == 0x0b
}

/// Reads a text word by word, and knows the line.
#[derive(Debug)]
pub(super) struct Words<'a> {
    text: &'a [u8],
    at: usize,
    line: u64,
}

impl<'a> Words<'a> {
    pub(super) fn new(text: &'a [u8]) -> Self {
        Self { text, at: 0, line: 1 }
    }

    /// The line of what was read last.
    pub(super) fn line(&self) -> u64 {
        self.line
    }

    /// The next byte that is no space, and not read yet; behind comments if `comments`.
    pub(super) fn peek(&mut self, comments: bool) -> Option<u8> {
        while let Some(&byte) = self.text.get(self.at) {
            if byte == b'#' && comments {
                self.skip_line();
            } else if byte == b'\n' {
                self.line += 1;
                self.at += 1;
            } else if is_space(byte) {
                self.at += 1;
            } else {
                return Some(byte);
            }
        }
        None
    }

    /// The next word: up to a space, or to the closing quote if it begins with one.
    pub(super) fn word(&mut self, comments: bool) -> Option<&'a [u8]> {
        let first = self.peek(comments)?;
        let rest = self.text.get(self.at..).unwrap_or_default();
        if first == b'"' || first == b'\'' {
            let body = rest.get(1..).unwrap_or_default();
            if let Some(end) = body.iter().position(|&b| b == first || b == b'\n') {
                let closed = body.get(end) == Some(&first);
                self.at += 1 + end + usize::from(closed);
                return body.get(..end);
            }
        }
        Some(self.until(is_space))
    }

    /// The next number or count: a word that a comment ends too.
    pub(super) fn value(&mut self) -> Option<&'a [u8]> {
        self.peek(true)?;
        Some(self.until(|byte| is_space(byte) || byte == b'#'))
    }

    /// What stands before the next byte that ends it.
    fn until(&mut self, ends: impl Fn(u8) -> bool) -> &'a [u8] {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let end = rest.iter().position(|&b| ends(b)).unwrap_or(rest.len());
        self.at += end;
        rest.get(..end).unwrap_or_default()
    }

    /// The rest of the line; a backslash at its end joins the next.
    pub(super) fn rest_of_line(&mut self) -> Vec<u8> {
        let mut out = Vec::new();
        loop {
            let rest = self.text.get(self.at..).unwrap_or_default();
            let end = rest.iter().position(|&b| b == b'\n');
            let line = rest.get(..end.unwrap_or(rest.len())).unwrap_or_default();
            self.at += line.len();
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            let joined = line.strip_suffix(b"\\");
            out.extend_from_slice(joined.unwrap_or(line));
            if joined.is_none() || end.is_none() {
                return out;
            }
            out.push(b' ');
            self.at += 1;
            self.line += 1;
        }
    }

    fn skip_line(&mut self) {
        let rest = self.text.get(self.at..).unwrap_or_default();
        self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_finite() {
        assert_eq!(number(b"-1.5e3").unwrap(), -1500.0);
        assert_eq!(number(b".5").unwrap(), 0.5);
        for bad in ["nan", "inf", "-infinity", "1e999", "", "1,5", "0x10", "12abc", "\u{fffd}"] {
            assert!(number(bad.as_bytes()).is_err(), "{bad}");
        }
    }

    #[test]
    fn words_quotes_comments_and_lines() {
        let mut words = Words::new(b"a 'b c'\n# x\n \"d\" #e\nf! \\\ng\n'open\nz");
        assert_eq!(words.word(true).unwrap(), b"a");
        assert_eq!(words.word(true).unwrap(), b"b c");
        assert_eq!(words.word(true).unwrap(), b"d");
        assert_eq!(words.line(), 3);
        assert_eq!(words.word(false).unwrap(), b"#e");
        assert_eq!(words.peek(true), Some(b'f'));
        assert_eq!(words.rest_of_line(), b"f!  g");
        assert_eq!(words.word(true).unwrap(), b"open");
        assert_eq!((words.word(true).unwrap(), words.line()), (&b"z"[..], 7));
        assert_eq!(words.word(true), None);
    }

    #[test]
    fn shown_words_are_short_and_printable() {
        assert_eq!(shown(b"a\x1b[31m\n"), "a?[31m?");
        assert_eq!(shown(&[b'x'; 999]).chars().count(), 41);
    }
}
