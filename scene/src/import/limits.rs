use super::Cause;
use crate::model::Model;

/// What is refused as too much, so that hostile input cannot take all memory or time.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one file.
    pub file_bytes: u64,
    /// Bytes of text that are read in all; a file that is included again counts again.
    pub text_bytes: u64,
    /// Triangles and spheres in all. A triangle takes at most 100 bytes until it is compiled.
    pub surfaces: u64,
    /// Corners of one polygon.
    pub corners: u64,
    /// Files and commands that are included in all, each copy of an array counted.
    pub copies: u64,
    /// Files within files.
    pub depth: u64,
}

impl Default for Limits {
    /// 4 GiB of text, 100 million surfaces, 32,768 corners, a million copies, 32 levels.
    fn default() -> Self {
        Self {
            file_bytes: 4 << 30,
            text_bytes: 4 << 30,
            surfaces: 100_000_000,
            corners: 1 << 15,
            copies: 1 << 20,
            depth: 32,
        }
    }
}

impl Limits {
    /// The model has not grown beyond its bound.
    pub(super) fn room(&self, model: &Model) -> Result<(), Cause> {
        let surfaces = (model.triangles.len() + model.spheres.len()) as u64;
        if surfaces > self.surfaces {
            let what = "too many triangles and spheres";
            return Err(Cause::Limit { what, limit: self.surfaces });
        }
        Ok(())
    }
}
