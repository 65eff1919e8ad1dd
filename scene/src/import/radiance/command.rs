//! Command lines: words, pipes and sequences. Nothing here runs anything.

use super::genbox::Box;
use super::xform::Stage;
use crate::import::Cause;
use crate::import::error::syntax;
use crate::import::scan::shown;

/// Pipes in one command: each is a level of recursion.
const FILTERS_MAX: usize = 16;

/// What begins a pipe.
#[derive(Debug)]
pub(super) enum Head {
    /// `xform` with files: they are named by the stage.
    Files(Stage),
    Box(Box),
}

/// A command and the `xform`s that its output passes, in order.
#[derive(Debug)]
pub(super) struct Pipe {
    pub(super) head: Head,
    pub(super) filters: Vec<Stage>,
}

/// Takes a command line apart; `;` separates pipes.
pub(super) fn parse(line: &[u8]) -> Result<Vec<Pipe>, Cause> {
    let words = words(line)?;
    let mut pipes = Vec::new();
    for sequence in words.split(|w| *w == Word::Then) {
        if !sequence.is_empty() {
            pipes.push(pipe(sequence)?);
        }
    }
    if pipes.is_empty() { Err(syntax("`!` without a command")) } else { Ok(pipes) }
}

fn pipe(words: &[Word]) -> Result<Pipe, Cause> {
    if words.iter().filter(|w| **w == Word::Pipe).count() > FILTERS_MAX {
        return Err(Cause::Limit {
            what: "too many pipes in one command",
            limit: FILTERS_MAX as u64,
        });
    }
    let mut commands = words.split(|w| *w == Word::Pipe).map(|command| {
        let text = |w: &Word| if let Word::Text(t) = w { t.clone() } else { Vec::new() };
        command.iter().map(text).collect::<Vec<_>>()
    });
    let head = commands.next().unwrap_or_default();
    let head = match head.split_first() {
        Some((name, rest)) if name == b"xform" => {
            let stage = Stage::parse(rest)?;
            if stage.files.is_empty() {
                return Err(syntax("xform without a file would read standard input: name a file"));
            }
            Head::Files(stage)
        }
        Some((name, rest)) if name == b"genbox" => Head::Box(Box::parse(rest)?),
        Some((name, _)) => return Err(Cause::Command(shown(name))),
        None => return Err(syntax("a pipe without a command")),
    };
    let filters = commands.map(|command| match command.split_first() {
        Some((name, rest)) if name == b"xform" => {
            let stage = Stage::parse(rest)?;
            if stage.files.is_empty() {
                Ok(stage)
            } else {
                Err(syntax("xform behind a pipe takes no file"))
            }
        }
        Some((name, _)) => Err(Cause::Command(shown(name))),
        None => Err(syntax("a pipe without a command")),
    });
    Ok(Pipe { head, filters: filters.collect::<Result<_, _>>()? })
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Word {
    Text(Vec<u8>),
    Pipe,
    Then,
}

/// Splits as a shell does: at spaces outside quotes; what else a shell knows is refused.
fn words(line: &[u8]) -> Result<Vec<Word>, Cause> {
    let mut out = Vec::new();
    let mut word: Option<Vec<u8>> = None;
    let mut bytes = line.iter().copied();
    while let Some(byte) = bytes.next() {
        match byte {
            b'"' | b'\'' => {
                let text = word.get_or_insert_default();
                loop {
                    match bytes.next() {
                        Some(b) if b == byte => break,
                        Some(b) => text.push(b),
                        None => return Err(syntax("a quote is not closed")),
                    }
                }
            }
            b'|' | b';' => {
                out.extend(word.take().map(Word::Text));
                out.push(if byte == b'|' { Word::Pipe } else { Word::Then });
            }
            b'#' if word.is_none() => break,
            b'<' | b'>' | b'&' | b'`' | b'$' | b'(' | b')' => {
                let sign = char::from(byte);
                return Err(syntax(format!(
                    "`{sign}` in a command: only pipes between xform and genbox are built in"
                )));
            }
            b'\\' => word.get_or_insert_default().extend(bytes.next()),
            b if b.is_ascii_whitespace() => out.extend(word.take().map(Word::Text)),
            b => word.get_or_insert_default().push(b),
        }
    }
    out.extend(word.map(Word::Text));
    Ok(out)
}
