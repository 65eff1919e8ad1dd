//! Transformations as Radiance's `xform` takes them: similarities, and arrays of them.

use glam::{DMat3, DVec3};

use crate::import::Cause;
use crate::import::error::syntax;
use crate::import::scan::{number, shown};

/// A similarity: turns, moves, mirrors, and scales alike along all axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Xform {
    pub(super) linear: DMat3,
    pub(super) offset: DVec3,
    /// Factor of lengths, below zero if it mirrors.
    pub(super) scale: f64,
}

impl Xform {
    pub(super) const IDENTITY: Self =
        Self { linear: DMat3::IDENTITY, offset: DVec3::ZERO, scale: 1.0 };

    pub(super) fn point(&self, p: DVec3) -> DVec3 {
        self.linear * p + self.offset
    }

    pub(super) fn vector(&self, v: DVec3) -> DVec3 {
        self.linear * v
    }

    /// First `self`, then `next`.
    pub(super) fn then(&self, next: &Self) -> Self {
        Self {
            linear: next.linear * self.linear,
            offset: next.point(self.offset),
            scale: self.scale * next.scale,
        }
    }

    /// `count` times itself.
    fn power(mut self, mut count: u64) -> Self {
        let mut total = Self::IDENTITY;
        while count > 0 {
            if count & 1 == 1 {
                total = total.then(&self);
            }
            self = self.then(&self);
            count >>= 1;
        }
        total
    }

    fn rotation(axis: u8, degrees: f64) -> Self {
        let (sin, cos) = sin_cos(degrees);
        let mut linear = DMat3::IDENTITY;
        let (u, v) = match axis {
            b'x' => (1, 2),
            b'y' => (2, 0),
            _ => (0, 1),
        };
        linear.col_mut(u)[u] = cos;
        linear.col_mut(v)[v] = cos;
        linear.col_mut(u)[v] = sin;
        linear.col_mut(v)[u] = -sin;
        Self { linear, ..Self::IDENTITY }
    }

    fn mirror(axis: u8) -> Self {
        let mut diagonal = DVec3::ONE;
        diagonal[usize::from(axis - b'x')] = -1.0;
        Self { linear: DMat3::from_diagonal(diagonal), scale: -1.0, ..Self::IDENTITY }
    }
}

/// Exact for quarter turns, so that boxes stay boxes.
fn sin_cos(degrees: f64) -> (f64, f64) {
    let turn = degrees % 360.0;
    match turn {
        0.0 => (0.0, 1.0),
        90.0 | -270.0 => (1.0, 0.0),
        180.0 | -180.0 => (0.0, -1.0),
        270.0 | -90.0 => (-1.0, 0.0),
        _ => libm::sincos(turn.to_radians()),
    }
}

/// What one `xform` does to its input.
#[derive(Debug, Default)]
pub(super) struct Stage {
    /// `-m`: the modifier of all surfaces.
    pub(super) modifier: Option<Vec<u8>>,
    /// `-I`: surfaces are turned inside out.
    pub(super) invert: bool,
    /// Files to read; none if it takes what a pipe brings.
    pub(super) files: Vec<Vec<u8>>,
    parts: Vec<Part>,
}

/// A transformation that is applied once or several times, or 0, 1, .. times in the copies of an
/// array.
#[derive(Debug)]
struct Part {
    xform: Xform,
    count: u64,
    array: bool,
}

impl Stage {
    /// Takes the arguments of an `xform` command.
    pub(super) fn parse(arguments: &[Vec<u8>]) -> Result<Self, Cause> {
        let mut stage = Self::default();
        let mut rest = arguments.iter();
        let mut part = Part { xform: Xform::IDENTITY, count: 1, array: false };
        let mut begun = false;
        while let Some(word) = rest.next() {
            let Some(option) = word.strip_prefix(b"-") else {
                stage.files.push(word.clone());
                stage.files.extend(rest.by_ref().cloned());
                break;
            };
            let mut value = || {
                let word = rest.next().ok_or_else(|| lacking(word))?;
                number(word)
            };
            let step = match option {
                b"n" if !begun => {
                    rest.next().ok_or_else(|| lacking(word))?;
                    continue;
                }
                b"m" if !begun => {
                    let name = rest.next().ok_or_else(|| lacking(word))?;
                    // The first counts, as in Radiance.
                    stage.modifier.get_or_insert_with(|| name.clone());
                    continue;
                }
                b"I" if !begun => {
                    stage.invert = !stage.invert;
                    continue;
                }
                b"c" | b"e" if !begun => continue,
                b"t" => {
                    let offset = DVec3::new(value()?, value()?, value()?);
                    Xform { offset, ..Xform::IDENTITY }
                }
                b"rx" | b"ry" | b"rz" => Xform::rotation(option[1], value()?),
                b"mx" | b"my" | b"mz" => Xform::mirror(option[1]),
                b"s" => {
                    let scale = value()?;
                    if scale == 0.0 {
                        return Err(syntax("xform -s 0: nothing would be left"));
                    }
                    Xform {
                        linear: DMat3::from_diagonal(DVec3::splat(scale)),
                        scale,
                        ..Xform::IDENTITY
                    }
                }
                b"a" | b"i" => {
                    let array = option == b"a";
                    let word = rest.next().ok_or_else(|| lacking(word))?;
                    let next = Part { xform: Xform::IDENTITY, count: count(word, array)?, array };
                    stage.parts.push(std::mem::replace(&mut part, next));
                    begun = true;
                    continue;
                }
                b"f" => {
                    return Err(syntax(
                        "xform: -f takes options from a file, which is not built in: write them in the command",
                    ));
                }
                _ => {
                    let option = shown(word);
                    return Err(syntax(format!("xform: the option `{option}` is not known here")));
                }
            };
            part.xform = part.xform.then(&step);
            begun = true;
        }
        stage.parts.push(part);
        Ok(stage)
    }

    /// Number of copies, at most `u64::MAX`.
    pub(super) fn copies(&self) -> u64 {
        let counts = self.parts.iter().filter(|p| p.array).map(|p| p.count);
        counts.fold(1, u64::saturating_mul)
    }

    /// The transformation of a copy; the first array counts slowest.
    pub(super) fn copy(&self, mut index: u64) -> Xform {
        let mut total = Xform::IDENTITY;
        for part in self.parts.iter().rev() {
            let times = if part.array {
                let times = index % part.count.max(1);
                index /= part.count.max(1);
                times
            } else {
                part.count
            };
            total = part.xform.power(times).then(&total);
        }
        total
    }
}

fn count(word: &[u8], array: bool) -> Result<u64, Cause> {
    let value = std::str::from_utf8(word).ok().and_then(|w| w.parse::<u64>().ok());
    match value {
        Some(value) if value > 0 || !array => Ok(value),
        _ => {
            let (word, least) = (shown(word), if array { 1 } else { 0 });
            let text = format!("xform: `{word}` is not a count: a whole number from {least} is");
            Err(syntax(text))
        }
    }
}

fn lacking(option: &[u8]) -> Cause {
    syntax(format!("xform: the option `{}` lacks a value", shown(option)))
}
