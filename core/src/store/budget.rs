use core::fmt;

/// A part of a node's memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum Line {
    /// Frames for blocks.
    Frames,
    /// Which block lies in which frame, and which leaves next.
    FrameTable,
    /// Intersection points that wait for their children.
    Points,
    /// Rays under way, with their best hits and stacks.
    Rays,
    /// Bundles of shadow rays.
    Bundles,
    /// Messages between nodes, both channels.
    Messages,
    /// Sums of the pixels of a tile.
    Tile,
    /// Tables of the scene that are kept in the arena; tables read in place take nothing of it.
    Tables,
}

impl Line {
    /// All lines, in the order of a plan.
    pub const ALL: [Self; 8] = [
        Self::Tables,
        Self::Points,
        Self::Rays,
        Self::Bundles,
        Self::Messages,
        Self::Tile,
        Self::FrameTable,
        Self::Frames,
    ];

    /// What a plan calls it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Frames => "block frames",
            Self::FrameTable => "frame table",
            Self::Points => "intersection points",
            Self::Rays => "rays",
            Self::Bundles => "shadow bundles",
            Self::Messages => "messages",
            Self::Tile => "tile of pixel sums",
            Self::Tables => "scene tables",
        }
    }
}

/// A line of a plan, and how much of it was used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineBudget {
    /// The line.
    pub line: Line,
    /// Items it can hold.
    pub capacity: usize,
    /// Bytes it takes of the arena: whole [chunks](super::Chunk).
    pub bytes: usize,
    /// Most items it ever held.
    pub peak: usize,
}

impl LineBudget {
    /// An unused line.
    #[must_use]
    pub const fn new(line: Line, capacity: usize, bytes: usize) -> Self {
        Self { line, capacity, bytes, peak: 0 }
    }

    /// Bytes of the items it ever held at once.
    #[must_use]
    pub const fn peak_bytes(&self) -> usize {
        if self.peak >= self.capacity {
            return self.bytes;
        }
        let bytes = (self.bytes as u64).saturating_mul(self.peak as u64);
        bytes.div_ceil(self.capacity as u64) as usize
    }
}

/// How a node's memory is divided: a line for everything it holds, in the order of [`Line::ALL`].
///
/// It prints as a table, a line for a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    memory: usize,
    lines: [LineBudget; Line::ALL.len()],
}

impl Budget {
    /// A plan of these lines; those not named are empty.
    ///
    /// # Errors
    /// [`BudgetError`] if they need more than `memory` bytes.
    pub fn new(memory: usize, lines: &[LineBudget]) -> Result<Self, BudgetError> {
        let mut all = Line::ALL.map(|line| LineBudget::new(line, 0, 0));
        for wanted in lines {
            for line in all.iter_mut().filter(|l| l.line == wanted.line) {
                *line = *wanted;
            }
        }
        let budget = Self { memory, lines: all };
        if budget.bytes() > memory {
            Err(BudgetError { memory, need: budget.lines.map(|line| line.bytes) })
        } else {
            Ok(budget)
        }
    }

    /// The memory it divides.
    #[must_use]
    pub const fn memory(&self) -> usize {
        self.memory
    }

    /// The lines.
    #[must_use]
    pub const fn lines(&self) -> &[LineBudget] {
        &self.lines
    }

    /// A line.
    #[must_use]
    pub fn line(&self, line: Line) -> LineBudget {
        self.lines.into_iter().find(|l| l.line == line).unwrap_or(LineBudget::new(line, 0, 0))
    }

    /// Bytes of all lines.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.lines.iter().fold(0, |sum, line| sum.saturating_add(line.bytes))
    }

    /// Bytes in use when each line was fullest: no less than were ever in use at once.
    #[must_use]
    pub fn peak_bytes(&self) -> usize {
        self.lines.iter().fold(0, |sum, line| sum.saturating_add(line.peak_bytes()))
    }

    /// Notes that a line held this many items.
    pub fn note_peak(&mut self, line: Line, items: usize) {
        for l in self.lines.iter_mut().filter(|l| l.line == line) {
            l.peak = l.peak.max(items);
        }
    }

    /// Notes of each line how many items it held at once.
    pub(crate) fn note_peaks(&mut self, items: impl Fn(&LineBudget) -> usize) {
        for line in &mut self.lines {
            line.peak = line.peak.max(items(line));
        }
    }
}

impl fmt::Display for Budget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<20} {:>9} {:>11}", "line", "items", "bytes")?;
        for line in self.lines.iter().filter(|line| line.bytes > 0) {
            writeln!(f, "{:<20} {:>9} {:>11}", line.line.name(), line.capacity, line.bytes)?;
        }
        write!(f, "{:<20} {:>9} {:>11} of {}", "total", "", self.bytes(), self.memory)
    }
}

/// A memory that cannot work: the least that each line needs, and what there is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BudgetError {
    /// The memory that was given \[bytes\].
    pub memory: usize,
    /// The least that each line works with, in the order of [`Line::ALL`] \[bytes\].
    pub need: [usize; Line::ALL.len()],
}

/// A line of a refused plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LineNeed {
    /// The line.
    pub line: Line,
    /// The least it works with \[bytes\].
    pub need: usize,
    /// What there is for it \[bytes\].
    pub have: usize,
}

impl BudgetError {
    /// What each line needs, and what there is for it when the lines before it are served.
    pub fn lines(&self) -> impl Iterator<Item = LineNeed> {
        let mut left = self.memory;
        Line::ALL.into_iter().zip(self.need).map(move |(line, need)| {
            let have = need.min(left);
            left = left.saturating_sub(have);
            LineNeed { line, need, have }
        })
    }

    /// The least memory that would do \[bytes\].
    #[must_use]
    pub fn need(&self) -> usize {
        self.need.into_iter().fold(0, usize::saturating_add)
    }
}

impl fmt::Display for BudgetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "a memory of {} bytes is too small, at least {} are needed:",
            self.memory,
            self.need()
        )?;
        for line in self.lines().filter(|line| line.need > 0) {
            let name = line.line.name();
            write!(f, "\n  {name:<20} needs {:>9}, has {:>9}", line.need, line.have)?;
        }
        Ok(())
    }
}

impl core::error::Error for BudgetError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_line_by_line() {
        let lines = [
            LineBudget::new(Line::Frames, 2, 2048),
            LineBudget::new(Line::Points, 3, 192),
            LineBudget::new(Line::Tile, 1, 64),
        ];
        assert_eq!(Budget::new(2304, &lines).unwrap().bytes(), 2304);
        let error = Budget::new(300, &lines).unwrap_err();
        assert_eq!(error.need(), 2304);
        assert_eq!(
            error.to_string(),
            "a memory of 300 bytes is too small, at least 2304 are needed:\
             \n  intersection points  needs       192, has       192\
             \n  tile of pixel sums   needs        64, has        64\
             \n  block frames         needs      2048, has        44"
        );
    }

    #[test]
    fn a_budget_prints_its_lines() {
        let lines = [LineBudget::new(Line::Frames, 2, 2048), LineBudget::new(Line::Points, 3, 192)];
        assert_eq!(
            Budget::new(4096, &lines).unwrap().to_string(),
            "line                     items       bytes\
             \nintersection points          3         192\
             \nblock frames                 2        2048\
             \ntotal                                 2240 of 4096"
        );
    }

    #[test]
    fn peaks_never_exceed_what_was_planned() {
        let mut budget = Budget::new(4096, &[LineBudget::new(Line::Points, 3, 192)]).unwrap();
        budget.note_peak(Line::Points, 2);
        budget.note_peak(Line::Points, 1);
        assert_eq!((budget.line(Line::Points).peak, budget.peak_bytes()), (2, 128));
        budget.note_peak(Line::Points, 3);
        assert_eq!(budget.peak_bytes(), 192);
    }
}
