//! Numbers of one sample, or of as many at once as a vector holds.
//!
//! What is written over a [`Real`] is there once: with `f32` it is plain code for any processor, with the lanes of a
//! [`Lanes`](crate::trace::Lanes) it does several samples with the same instructions. Both give each sample the same bits: all operations are those of IEEE 754,
//! in the order in which they are written, and where a plain program would branch both sides are computed and one is [selected](Real::select).
//!
//! Values come from values: whoever has one has proven that the machine has the instructions for it. Constants are therefore made by
//! [`Real::same`], or are the `f32` of an operation.

use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};
use glam::Vec3;

/// Most lanes of any [`Real`].
pub const LANES: usize = 8;

/// A part of a computation. (A closure would be compiled without the instructions of the lanes.)
pub trait Part {
    /// What comes of it.
    type Result;

    /// Does it. Is inlined, so that all of it is compiled for the instructions of its caller.
    fn run(self) -> Self::Result;
}

/// Numbers, one in each lane.
pub trait Real:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
    + Div<f32, Output = Self>
{
    /// An answer in each lane.
    type Mask: Mask;
    /// The same bits as whole numbers.
    type Bits: Bits<Real = Self, Mask = Self::Mask>;

    /// How many, [`LANES`] at most.
    const COUNT: usize;

    /// One number in all lanes.
    #[must_use]
    fn same(self, x: f32) -> Self;
    /// The square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// Without its sign.
    #[must_use]
    fn abs(self) -> Self;
    /// With the sign of another.
    #[must_use]
    fn copysign(self, sign: Self) -> Self;
    /// `self` if it is greater, else `other`: so `other` for NaN.
    #[must_use]
    fn greater(self, other: Self) -> Self;
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

    /// [`Real::greater`] than a number.
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

impl Real for f32 {
    type Mask = bool;
    type Bits = u32;

    const COUNT: usize = 1;

    #[inline(always)]
    fn same(self, x: f32) -> Self {
        x
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        libm::sqrtf(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        f32::copysign(self, sign)
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        if self > other { self } else { other }
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

/// A vector in each lane. Sums of three are taken in the order of the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vector<R> {
    /// Along the first axis.
    pub x: R,
    /// Along the second.
    pub y: R,
    /// Along the third.
    pub z: R,
}

impl<R: Real> Vector<R> {
    /// One vector in as many lanes as `like` has.
    #[inline(always)]
    #[must_use]
    pub fn same(like: R, v: Vec3) -> Self {
        Self { x: like.same(v.x), y: like.same(v.y), z: like.same(v.z) }
    }

    /// One vector times a number by lane.
    #[inline(always)]
    #[must_use]
    pub fn along(v: Vec3, by: R) -> Self {
        Self { x: by * v.x, y: by * v.y, z: by * v.z }
    }

    /// The product with another vector.
    #[inline(always)]
    #[must_use]
    pub fn dot(self, other: Self) -> R {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The product with one vector.
    #[inline(always)]
    #[must_use]
    pub fn on(self, v: Vec3) -> R {
        self.x * v.x + self.y * v.y + self.z * v.z
    }

    /// The vector at right angles to both.
    #[inline(always)]
    #[must_use]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// Its length.
    #[inline(always)]
    #[must_use]
    pub fn length(self) -> R {
        self.dot(self).sqrt()
    }

    /// One of two by lane.
    #[inline(always)]
    #[must_use]
    pub fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            x: R::select(mask, yes.x, no.x),
            y: R::select(mask, yes.y, no.y),
            z: R::select(mask, yes.z, no.z),
        }
    }

    /// The greatest element.
    #[inline(always)]
    #[must_use]
    pub fn greatest(self) -> R {
        self.x.greater(self.y).greater(self.z)
    }
}

impl From<Vec3> for Vector<f32> {
    #[inline(always)]
    fn from(v: Vec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<Vector<f32>> for Vec3 {
    #[inline(always)]
    fn from(v: Vector<f32>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl<R: Real> Add for Vector<R> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<R: Real> Sub for Vector<R> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<R: Real> Add<Vec3> for Vector<R> {
    type Output = Self;

    #[inline(always)]
    fn add(self, v: Vec3) -> Self {
        Self { x: self.x + v.x, y: self.y + v.y, z: self.z + v.z }
    }
}

impl<R: Real> Sub<Vec3> for Vector<R> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, v: Vec3) -> Self {
        Self { x: self.x - v.x, y: self.y - v.y, z: self.z - v.z }
    }
}

impl<R: Real> Mul<R> for Vector<R> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, by: R) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }
}

impl<R: Real> Div<R> for Vector<R> {
    type Output = Self;

    #[inline(always)]
    fn div(self, by: R) -> Self {
        Self { x: self.x / by, y: self.y / by, z: self.z / by }
    }
}

/// Element by element.
impl<R: Real> Mul for Vector<R> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }
}

/// Element by element.
impl<R: Real> Mul<Vec3> for Vector<R> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, v: Vec3) -> Self {
        Self { x: self.x * v.x, y: self.y * v.y, z: self.z * v.z }
    }
}
