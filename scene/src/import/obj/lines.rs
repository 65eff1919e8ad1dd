//! The lines of a mesh, and of its materials.

use std::borrow::Cow;

/// Lines one by one, each joined with the next as long as it ends with a backslash. A clone goes on
/// from the same place: so what comes later can be looked for.
#[derive(Debug, Clone)]
pub(super) struct Lines<'a> {
    rest: Option<&'a [u8]>,
    number: u64,
}

/// A line, and the number of the last that was joined to it.
#[derive(Debug)]
pub(super) struct Line<'a> {
    pub(super) text: Cow<'a, [u8]>,
    pub(super) first: u64,
    pub(super) last: u64,
}

impl<'a> Lines<'a> {
    pub(super) fn new(text: &'a [u8]) -> Self {
        Self { rest: Some(text), number: 0 }
    }

    /// The next line as it stands there.
    fn plain(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest?;
        self.number += 1;
        let end = rest.iter().position(|&b| b == b'\n');
        let line = rest.get(..end.unwrap_or(rest.len())).unwrap_or_default();
        self.rest = end.and_then(|end| rest.get(end + 1..));
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        let mut line = self.plain()?;
        let first = self.number;
        // A comment may end with the name of a folder: it joins nothing.
        if !line.ends_with(b"\\") || line.trim_ascii_start().starts_with(b"#") {
            return Some(Line { text: Cow::Borrowed(line), first, last: first });
        }
        let mut joined = Vec::new();
        while let Some(part) = line.strip_suffix(b"\\") {
            joined.extend_from_slice(part);
            joined.push(b' ');
            line = self.plain().unwrap_or_default();
        }
        joined.extend_from_slice(line);
        Some(Line { text: Cow::Owned(joined), first, last: self.number })
    }
}

/// The words of a line, up to a comment.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
    words.take_while(|w| !w.starts_with(b"#"))
}

/// What stands behind the keyword. Names may contain spaces, and begin with `#`: so only a `#`
/// between spaces begins a comment here.
pub(super) fn name<'t>(line: &'t [u8], keyword: &[u8]) -> &'t [u8] {
    let line = line.trim_ascii();
    let rest = line.get(keyword.len()..).unwrap_or_default();
    let comment = |at: &usize| {
        let beside = |i: Option<usize>| {
            let byte = i.and_then(|i| rest.get(i));
            byte.is_none_or(u8::is_ascii_whitespace)
        };
        rest.get(*at) == Some(&b'#') && beside(at.checked_sub(1)) && beside(at.checked_add(1))
    };
    let end = (0..rest.len()).find(comment).unwrap_or(rest.len());
    rest.get(..end).unwrap_or_default().trim_ascii()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_join_and_are_numbered() {
        let text = b"a\r\nb \\\n c\\\r\nd\n# C:\\scenes\\\ne\n\nf\\";
        let found: Vec<_> = Lines::new(text)
            .map(|l| (String::from_utf8(l.text.into_owned()).unwrap(), l.first, l.last))
            .collect();
        let expected =
            [("a", 1, 1), ("b   c d", 2, 4), ("# C:\\scenes\\", 5, 5), ("e", 6, 6), ("", 7, 7)];
        let expected = expected.into_iter().chain([("f ", 8, 8)]);
        assert_eq!(found, expected.map(|(t, a, b)| (t.to_owned(), a, b)).collect::<Vec<_>>());
    }

    #[test]
    fn comments_end_words_and_names() {
        let found: Vec<_> = words(b" f 1 2#3 #4 5").collect();
        assert_eq!(found, [&b"f"[..], b"1", b"2#3"]);
        for (line, expected) in [
            ("usemtl red paint", "red paint"),
            ("usemtl #3 a#b #c", "#3 a#b #c"),
            ("usemtl red # paint", "red"),
            ("usemtl red #", "red"),
            ("usemtl", ""),
        ] {
            assert_eq!(name(line.as_bytes(), b"usemtl"), expected.as_bytes());
        }
    }
}
