use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

/// Where in the input something stands.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// The file as the user named it; `None` for what no file holds.
    pub file: Option<Arc<str>>,
    /// The line, from 1; 0 where it is not known.
    pub line: u64,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.file, self.line) {
            (None, _) => f.write_str("the scene"),
            (Some(file), 0) => f.write_str(file),
            (Some(file), line) => write!(f, "{file}:{line}"),
        }
    }
}

/// Something that was ignored or repaired.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// What.
    pub text: String,
    /// How often.
    pub count: u64,
    /// Where it came up first.
    pub first: Place,
    /// What it is about, if that has names: the first different ones.
    pub names: Vec<String>,
    /// There are more names.
    pub more_names: bool,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.first.file.is_some() {
            write!(f, "{}: ", self.first)?;
        }
        f.write_str(&self.text)?;
        for (i, name) in self.names.iter().enumerate() {
            write!(f, "{} `{name}`", if i == 0 { ":" } else { "," })?;
        }
        if self.more_names {
            f.write_str(", and others")?;
        }
        match (self.count, &self.first.file) {
            (1, _) => Ok(()),
            (n, None) => write!(f, " ({n} times)"),
            (n, Some(_)) => write!(f, " ({n} times in all)"),
        }
    }
}

/// Greatest number of different notes; what comes later is counted together.
const DIFFERENT_MAX: usize = 1000;
/// Greatest number of names that a note shows.
const NAMES_MAX: usize = 4;
/// What they are counted as.
const FURTHER: &str = "further notes of other kinds, not shown";

/// What was ignored or repaired: each once, counted, in the order in which it came up.
#[derive(Debug, Clone, Default)]
pub struct Notes {
    list: Vec<Note>,
    index: HashMap<String, usize>,
    place: Place,
}

impl Notes {
    /// Adds one to the count of `text`. The first time, the current place is kept with it.
    pub fn add(&mut self, text: &str) {
        self.add_many(text, 1);
    }

    /// As [`add`](Self::add), about something that has a name: the note shows the first few names.
    pub fn add_named(&mut self, text: &str, name: &str) {
        self.add(text);
        let Some(note) = self.get_mut(text) else { return };
        if note.names.iter().any(|known| known == name) {
            return;
        }
        if note.names.len() < NAMES_MAX {
            note.names.push(name.to_owned());
        } else {
            note.more_names = true;
        }
    }

    fn get_mut(&mut self, text: &str) -> Option<&mut Note> {
        self.index.get(text).and_then(|&i| self.list.get_mut(i))
    }

    /// Adds `count` to the count of `text`.
    pub fn add_many(&mut self, text: &str, count: u64) {
        if count == 0 {
            return;
        }
        if let Some(note) = self.get_mut(text) {
            note.count = note.count.saturating_add(count);
            return;
        }
        // The last place is for the rest, which is no kind of its own.
        let text = if self.list.len() < DIFFERENT_MAX { text } else { FURTHER };
        if let Some(note) = self.list.get_mut(DIFFERENT_MAX) {
            note.count = note.count.saturating_add(count);
            return;
        }
        self.index.insert(text.to_owned(), self.list.len());
        let (text, first) = (text.to_owned(), self.place.clone());
        self.list.push(Note { text, count, first, names: Vec::new(), more_names: false });
    }

    /// Sets the file that later notes refer to.
    pub fn set_place(&mut self, place: Place) {
        self.place = place;
    }

    /// Sets the line that later notes refer to.
    pub fn set_line(&mut self, line: u64) {
        self.place.line = line;
    }

    /// The place that a note would refer to now.
    #[must_use]
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// The notes, in the order in which they came up.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &Note> {
        self.list.iter()
    }

    /// How often `text` came up.
    #[must_use]
    pub fn count(&self, text: &str) -> u64 {
        self.index.get(text).and_then(|&i| self.list.get(i)).map_or(0, |note| note.count)
    }

    /// Number of different notes.
    #[must_use]
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// There are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_are_counted_and_keep_order_and_first_place() {
        let mut notes = Notes::default();
        notes.add("b");
        notes.set_place(Place { file: Some("x.rad".into()), line: 3 });
        notes.add("a");
        notes.set_line(9);
        notes.add("a");
        notes.add("b");
        let shown: Vec<String> = notes.iter().map(ToString::to_string).collect();
        assert_eq!(shown, ["b (2 times)", "x.rad:3: a (2 times in all)"]);
        assert_eq!(notes.count("a"), 2);
    }

    #[test]
    fn the_first_names_are_shown() {
        let mut notes = Notes::default();
        let shown = |notes: &Notes| notes.iter().map(Note::to_string).collect::<Vec<_>>();
        notes.add_named("lost", "a");
        assert_eq!(shown(&notes), ["lost: `a`"]);
        notes.add_named("lost", "b");
        notes.add_named("lost", "a");
        assert_eq!(shown(&notes), ["lost: `a`, `b` (3 times)"]);
        for i in 0..100 {
            notes.add_named("lost", &i.to_string());
        }
        assert_eq!(shown(&notes), ["lost: `a`, `b`, `0`, `1`, and others (103 times)"]);
    }

    #[test]
    fn different_notes_are_bounded() {
        let mut notes = Notes::default();
        for i in 0..5000 {
            notes.add(&i.to_string());
        }
        assert!(notes.len() <= DIFFERENT_MAX + 1);
        assert_eq!(notes.iter().map(|n| n.count).sum::<u64>(), 5000);
    }
}
