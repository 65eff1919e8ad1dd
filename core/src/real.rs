//! Numbers of one sample, or of as many at once as a vector holds.
//!
//! What is written over a [`Real`] is there once: with `f32` it is plain code for any processor, with the lanes of a
//! [`Lanes`](crate::trace::Lanes) it does several samples with the same instructions. What f32 is too short for goes by its [`Double`]. Both give each sample the same bits: all operations are those of IEEE 754,
//! in the order in which they are written, and where a plain program would branch both sides are computed and one is [selected](Real::select).
//!
//! Values come from values: whoever has one has proven that the machine has the instructions for it. Constants are therefore made by
//! [`Real::same`], or are the `f32` of an operation.

mod rows;
mod vector;

#[cfg(feature = "bundles")]
pub(crate) use self::rows::{Row, at, set};
pub(crate) use self::rows::{Rows, put};
pub use self::vector::Vector;
use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

/// Most lanes of any [`Real`].
pub const LANES: usize = 8;

/// A part of a computation. (A closure would be compiled without the instructions of the lanes.)
pub trait Part {
    /// What comes of it.
    type Result;

    /// Does it. Is inlined, so that all of it is compiled for the instructions of its caller.
    fn run(self) -> Self::Result;
}

/// Numbers of either length, one in each lane.
pub trait Number:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
{
    /// The square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Without its sign.
    #[must_use]
    fn abs(self) -> Self;
    /// `self` if it is greater, else `other`: so `other` for NaN.
    #[must_use]
    fn greater(self, other: Self) -> Self;
}

/// Numbers of f32, one in each lane.
pub trait Real:
    Number
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
    + Div<f32, Output = Self>
{
    /// An answer in each lane.
    type Mask: Mask;
    /// The same bits as whole numbers.
    type Bits: Bits<Real = Self, Mask = Self::Mask>;
    /// The same numbers in f64.
    type Double: Double<Real = Self>;

    /// How many, [`LANES`] at most.
    const COUNT: usize;

    /// One number in all lanes.
    #[must_use]
    fn same(self, x: f32) -> Self;
    /// In f64.
    fn double(self) -> Self::Double;
    /// With the sign of another.
    #[must_use]
    fn copysign(self, sign: Self) -> Self;
    /// `self` if it is less, else `other`: so `other` for NaN.
    #[must_use]
    fn lesser(self, other: Self) -> Self;
    /// `self > other`.
    fn above(self, other: Self) -> Self::Mask;
    /// One of two by lane.
    #[must_use]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Its bits.
    fn bits(self) -> Self::Bits;
    /// Of bits.
    #[must_use]
    fn of_bits(bits: Self::Bits) -> Self;
    /// Without its fraction, as a whole number of 32 bits with a sign, in whose range it is.
    fn whole(self) -> Self::Bits;
    /// Puts down all lanes.
    fn store(self, to: &mut [f32; LANES]);

    /// Does a part that several places ask for: where there is one lane, as on boards, whose flash is small, by a function of its own.
    #[inline(always)]
    fn apart<P: Part>(part: P) -> P::Result {
        part.run()
    }

    /// One less this, exactly as `1.0 - self`.
    #[inline(always)]
    #[must_use]
    fn complement(self) -> Self {
        -self + 1.0
    }

    /// [`Number::greater`] than a number.
    #[inline(always)]
    #[must_use]
    fn at_least(self, x: f32) -> Self {
        self.greater(self.same(x))
    }

    /// [`Real::lesser`] than a number.
    #[inline(always)]
    #[must_use]
    fn at_most(self, x: f32) -> Self {
        self.lesser(self.same(x))
    }

    /// Yes in all lanes.
    #[inline(always)]
    fn always(self) -> Self::Mask {
        !self.above(self)
    }

    /// `self > 0`.
    #[inline(always)]
    fn is_positive(self) -> Self::Mask {
        self.above(self.same(0.0))
    }

    /// The nearest whole number; of two the greater by magnitude.
    #[inline(always)]
    fn nearest(self) -> Self::Bits {
        (self + self.same(0.5).copysign(self)).whole()
    }
}

/// Numbers of f64, one in each lane.
pub trait Double: Number {
    /// Those of f32.
    type Real: Real<Double = Self>;

    /// One number in all lanes.
    #[must_use]
    fn same(self, x: f64) -> Self;
    /// `self > other`.
    fn above(self, other: Self) -> <Self::Real as Real>::Mask;
    /// The nearest f32.
    fn single(self) -> Self::Real;
    /// With the other sign where a number is below zero.
    #[must_use]
    fn turned(self, by: Self::Real) -> Self;

    /// `self > 0`.
    #[inline(always)]
    fn is_positive(self) -> <Self::Real as Real>::Mask {
        self.above(self.same(0.0))
    }
}

/// Whole numbers of 32 bits, one in each lane. Sums and products wrap.
pub trait Bits:
    Copy
    + BitXor<Output = Self>
    + BitAnd<u32, Output = Self>
    + BitOr<u32, Output = Self>
    + BitXor<u32, Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    /// As numbers.
    type Real: Real;
    /// An answer in each lane.
    type Mask: Mask;

    /// `x` in all lanes.
    #[must_use]
    fn same(self, x: u32) -> Self;
    /// The sum of both.
    #[must_use]
    fn sum(self, other: Self) -> Self;
    /// The product of both.
    #[must_use]
    fn product(self, other: Self) -> Self;
    /// The bits in reverse.
    #[must_use]
    fn reversed(self) -> Self;
    /// Whether it is 0.
    fn is_zero(self) -> Self::Mask;
    /// One of two by lane.
    #[must_use]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The number, as one with a sign.
    fn real(self) -> Self::Real;

    /// The sum with a number.
    #[inline(always)]
    #[must_use]
    fn plus(self, x: u32) -> Self {
        self.sum(self.same(x))
    }

    /// The product with a number.
    #[inline(always)]
    #[must_use]
    fn times(self, x: u32) -> Self {
        self.product(self.same(x))
    }
}

/// An answer in each lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// A bit for each lane, the first lowest.
    fn lanes(self) -> u32;
}

impl Number for f32 {
    #[inline(always)]
    fn sqrt(self) -> Self {
        libm::sqrtf(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

impl Number for f64 {
    #[inline(always)]
    fn sqrt(self) -> Self {
        libm::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
}

impl Double for f64 {
    type Real = f32;

    #[inline(always)]
    fn same(self, x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn above(self, other: Self) -> bool {
        self > other
    }

    #[inline(always)]
    fn single(self) -> f32 {
        self as f32
    }

    #[inline(always)]
    fn turned(self, by: f32) -> Self {
        if by < 0.0 { -self } else { self }
    }
}

impl Real for f32 {
    type Mask = bool;
    type Bits = u32;
    type Double = f64;

    const COUNT: usize = 1;

    #[inline(always)]
    fn same(self, x: f32) -> Self {
        x
    }

    #[inline(always)]
    fn double(self) -> f64 {
        self.into()
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        f32::copysign(self, sign)
    }

    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn above(self, other: Self) -> bool {
        self > other
    }

    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        self.to_bits()
    }

    #[inline(always)]
    fn of_bits(bits: u32) -> Self {
        Self::from_bits(bits)
    }

    #[inline(always)]
    fn whole(self) -> u32 {
        self as i32 as u32
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; LANES]) {
        let [first, ..] = to;
        *first = self;
    }

    fn apart<P: Part>(part: P) -> P::Result {
        part.run()
    }
}

impl Bits for u32 {
    type Real = f32;
    type Mask = bool;

    #[inline(always)]
    fn same(self, x: u32) -> Self {
        x
    }

    #[inline(always)]
    fn sum(self, other: Self) -> Self {
        self.wrapping_add(other)
    }

    #[inline(always)]
    fn product(self, other: Self) -> Self {
        self.wrapping_mul(other)
    }

    #[inline(always)]
    fn reversed(self) -> Self {
        self.reverse_bits()
    }

    #[inline(always)]
    fn is_zero(self) -> bool {
        self == 0
    }

    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    #[inline(always)]
    fn real(self) -> f32 {
        self as i32 as f32
    }
}

impl Mask for bool {
    #[inline(always)]
    fn lanes(self) -> u32 {
        self.into()
    }
}
