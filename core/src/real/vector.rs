use super::{Double, Number, Real};
use core::ops::{Add, Div, Mul, Neg, Sub};
use glam::{DVec3, Vec3};

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

impl<N: Number> Vector<N> {
    /// The product with another vector.
    #[inline(always)]
    #[must_use]
    pub fn dot(self, other: Self) -> N {
        self.x * other.x + self.y * other.y + self.z * other.z
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

    /// Without signs.
    #[inline(always)]
    #[must_use]
    pub fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// By axis the greater, of `other` where there is none.
    #[inline(always)]
    #[must_use]
    pub fn greater(self, other: Self) -> Self {
        Self { x: self.x.greater(other.x), y: self.y.greater(other.y), z: self.z.greater(other.z) }
    }

    /// Its length.
    #[inline(always)]
    #[must_use]
    pub fn length(self) -> N {
        self.dot(self).sqrt()
    }

    /// The greatest element.
    #[inline(always)]
    #[must_use]
    pub fn greatest(self) -> N {
        self.x.greater(self.y).greater(self.z)
    }
}

impl<D: Double> Vector<D> {
    /// The nearest of f32.
    #[inline(always)]
    #[must_use]
    pub fn single(self) -> Vector<D::Real> {
        Vector { x: self.x.single(), y: self.y.single(), z: self.z.single() }
    }

    /// The other way where a number is below zero.
    #[inline(always)]
    #[must_use]
    pub fn turned(self, by: D::Real) -> Self {
        Self { x: self.x.turned(by), y: self.y.turned(by), z: self.z.turned(by) }
    }
}

impl<R: Real> Vector<R> {
    /// In f64.
    #[inline(always)]
    #[must_use]
    pub fn double(self) -> Vector<R::Double> {
        Vector { x: self.x.double(), y: self.y.double(), z: self.z.double() }
    }

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

    /// The product with one vector.
    #[inline(always)]
    #[must_use]
    pub fn on(self, v: Vec3) -> R {
        self.x * v.x + self.y * v.y + self.z * v.z
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

impl From<DVec3> for Vector<f64> {
    #[inline(always)]
    fn from(v: DVec3) -> Self {
        Self { x: v.x, y: v.y, z: v.z }
    }
}

impl From<Vector<f64>> for DVec3 {
    #[inline(always)]
    fn from(v: Vector<f64>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl<N: Number> Neg for Vector<N> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}

impl<N: Number> Add for Vector<N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<N: Number> Sub for Vector<N> {
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

impl<N: Number> Mul<N> for Vector<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, by: N) -> Self {
        Self { x: self.x * by, y: self.y * by, z: self.z * by }
    }
}

impl<N: Number> Div<N> for Vector<N> {
    type Output = Self;

    #[inline(always)]
    fn div(self, by: N) -> Self {
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
