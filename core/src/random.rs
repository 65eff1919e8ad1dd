//! Low-discrepancy numbers as functions of a path's key.
//!
//! A [`Sequence`] is Sobol's (0, 2)-sequence, Owen-scrambled and shuffled by a hash (Burley 2020, "Practical
//! hash-based Owen scrambling"; the hash is Vegdahl's 2021 form of Laine and Karras'). Every aligned run of 2ᵏ
//! indices is a (0, k, 2)-net: so the samples of a pixel stratify each other, and so does each power-of-two part of them.
//!
//! The crate `sobol_burley` does this for 256 dimensions, with a table of 16 KiB that a board would keep in flash,
//! and for 2¹⁶ indices, which 1024 paths of 64 shadow rays use up. Two dimensions per purpose need no table.

use crate::path::PathKey;
use crate::real::{Bits, Part, Real};

/// What a random number is for: the dimensions of [`PathKey::scramble`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Purpose {
    /// The place in the pixel.
    Pixel,
    /// Which lights are sampled.
    Lights,
    /// The direction of a reflected glossy ray.
    Reflect,
    /// The direction of a transmitted glossy ray.
    Transmit,
    /// Which children a point has.
    Children,
    /// The place on the light with this index.
    Light(u32),
    /// Another one, of which the others know nothing.
    Rest(u32),
}

impl Purpose {
    const fn dimension(self) -> u32 {
        match self {
            Self::Pixel => 0,
            Self::Lights => 1,
            Self::Reflect => 2,
            Self::Transmit => 3,
            Self::Children => 4,
            Self::Light(index) => index.wrapping_add(256),
            Self::Rest(index) => !index,
        }
    }
}

/// A sequence of points of the unit square.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sequence {
    shuffle: u32,
    x: u32,
    y: u32,
}

impl Sequence {
    /// The sequence of a path's last point for a purpose. The samples of a pixel share it: where a sample takes `n`
    /// points, they are those from `sample * n`.
    #[must_use]
    pub const fn new(key: PathKey, purpose: Purpose) -> Self {
        Self::from_seed(key.scramble(purpose.dimension()))
    }

    /// The sequence with this seed.
    #[must_use]
    pub const fn from_seed(seed: u32) -> Self {
        let shuffle = hash(seed ^ 0xa511_e9b3);
        let x = hash(shuffle ^ 0x6395_2d5d);
        Self { shuffle, x, y: hash(x ^ 0x1b56_c4e9) }
    }

    /// The power of two that is the first not below a number of points: see [`middles`](Self::middles).
    #[must_use]
    pub const fn fine(points: u32) -> u32 {
        let fine = u32::BITS - points.saturating_sub(1).leading_zeros();
        if fine < FINEST { fine } else { FINEST }
    }

    /// Point `index`: two numbers in [0, 1), multiples of 2⁻²⁴.
    #[must_use]
    pub fn point(self, index: u32) -> [f32; 2] {
        self.points(index)
    }

    /// The points of several indices.
    #[inline(always)]
    #[must_use]
    pub fn points<B: Bits>(self, index: B) -> [B::Real; 2] {
        self.middles(index, FINEST)
    }

    /// The points of several indices, each moved to the middle of its column and row of 2 to the power `fine`, 31 at most. Of an aligned run of so many
    /// points each has both for itself.
    #[inline(always)]
    #[must_use]
    pub fn middles<B: Bits>(self, index: B, fine: u32) -> [B::Real; 2] {
        let [shuffle, x, y] = self.seeds();
        let seeds = [index.same(shuffle), index.same(x), index.same(y)];
        B::Real::apart(Points { seeds, index, half: 0x8000_0000_u32.wrapping_shr(fine) })
    }

    /// What it is: to shuffle, and of both numbers.
    pub(crate) const fn seeds(self) -> [u32; 3] {
        [self.shuffle, self.x, self.y]
    }
}

/// [`Sequence::points`] of a sequence of its own in each lane.
#[cfg(feature = "bundles")]
#[inline(always)]
pub(crate) fn points_of<B: Bits>(seeds: [B; 3], index: B) -> [B::Real; 2] {
    B::Real::apart(Points { seeds, index, half: 0x8000_0000_u32.wrapping_shr(FINEST) })
}

/// Columns and rows of a power of two as great are narrower than numbers have digits: all points are in their middles.
const FINEST: u32 = 31;

/// [`Sequence::middles`].
struct Points<B> {
    /// To shuffle, and of both numbers.
    seeds: [B; 3],
    index: B,
    /// Half a column, in parts of 2³².
    half: u32,
}

impl<B: Bits> Part for Points<B> {
    type Result = [B::Real; 2];

    #[inline(always)]
    fn run(self) -> Self::Result {
        let Self { seeds: [shuffle, x, y], index, half } = self;
        let index = owen(index.reversed(), shuffle).reversed();
        let (x, y) = (owen(index, x).reversed(), owen(pascal(index), y).reversed());
        [unit(middle(x, half)), unit(middle(y, half))]
    }
}

/// The middle of the column in which a number lies, of columns that are twice a power of two wide.
#[inline(always)]
fn middle<B: Bits>(x: B, half: u32) -> B {
    x & half.wrapping_neg() << 1 ^ half
}

/// The second dimension of Sobol's sequence, bits reversed: the matrix of binomial coefficients mod 2, whose rows are
/// the supersets of their index; five steps add them up as a sum over subsets does.
#[inline(always)]
fn pascal<B: Bits>(i: B) -> B {
    let i = i ^ (i >> 16 & 0x0000_ffff);
    let i = i ^ (i >> 8 & 0x00ff_00ff);
    let i = i ^ (i >> 4 & 0x0f0f_0f0f);
    let i = i ^ (i >> 2 & 0x3333_3333);
    i ^ (i >> 1 & 0x5555_5555)
}

/// Owen's scramble of a number whose bits are reversed: each bit is flipped by a hash of those below it.
#[inline(always)]
fn owen<B: Bits>(x: B, seed: B) -> B {
    let x = x ^ x.times(0x3d20_adea);
    let x = x.sum(seed).product(seed >> 16 | 1);
    let x = x ^ x.times(0x0552_6c56);
    x ^ x.times(0x53a2_2864)
}

/// Wellons' `lowbias32`, a bijection.
const fn hash(x: u32) -> u32 {
    let x = (x ^ x >> 16).wrapping_mul(0x7feb_352d);
    let x = (x ^ x >> 15).wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

#[inline(always)]
fn unit<B: Bits>(x: B) -> B::Real {
    (x >> 8).real() * (1.0 / (1 << 24) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The definition of a (0, k, 2)-net: every elementary interval of area 2⁻ᵏ holds one point.
    #[test]
    fn aligned_runs_are_nets() {
        for seed in 0..20 {
            let sequence = Sequence::from_seed(seed);
            for k in 0..11_u32 {
                let n = 1 << k;
                for run in [0, 1, 5, (u32::MAX >> k) - 1] {
                    let points: Vec<_> = (0..n).map(|i| sequence.point((run << k) + i)).collect();
                    for a in 0..=k {
                        let cells: std::collections::BTreeSet<_> = points
                            .iter()
                            .map(|[x, y]| {
                                let columns = (1 << a) as f32;
                                let rows = (1 << (k - a)) as f32;
                                ((x * columns) as u32, (y * rows) as u32)
                            })
                            .collect();
                        assert_eq!(cells.len(), n as usize, "seed {seed} k {k} run {run} a {a}");
                    }
                }
            }
        }
    }

    /// Two purposes of one sample must not agree: pairs of first coordinates fill the square evenly.
    #[test]
    fn sequences_of_two_seeds_are_independent() {
        let n = 1 << 16;
        let mut cells = [0_u32; 256];
        for seed in 0..16 {
            let a = Sequence::from_seed(seed);
            let b = Sequence::from_seed(seed + 1000);
            for i in 0..n / 16 {
                let (x, y) = (a.point(i)[0], b.point(i)[0]);
                cells[(x * 16.0) as usize * 16 + (y * 16.0) as usize] += 1;
            }
        }
        // 255 degrees of freedom; dependence within a net makes it smaller or far greater, never 400 by chance.
        let expected = n as f64 / 256.0;
        let chi2: f64 = cells.iter().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
        assert!(chi2 < 400.0, "{chi2}");
    }
}
