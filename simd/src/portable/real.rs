//! Eight numbers at a time, for samples of light: to each is done what is done to one.

use core::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

use kiloray_core::real::{Bits, Double, LANES, Mask, Number, Real};

/// Eight of a kind, each by itself: a kernel has thousands of them, and takes minutes to compile if each is a loop.
#[inline(always)]
fn each<T>(of: impl Fn(usize) -> T) -> [T; LANES] {
    [of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7)]
}

/// A number, or an answer, in each lane.
#[derive(Debug, Clone, Copy)]
pub struct Each<T>(pub(super) [T; LANES]);

impl<T: Copy> Each<T> {
    #[inline(always)]
    fn map<U>(self, of: impl Fn(T) -> U) -> Each<U> {
        Each(each(|lane| of(self.0[lane])))
    }

    #[inline(always)]
    fn with(self, other: Self, of: impl Fn(T, T) -> T) -> Self {
        Self(each(|lane| of(self.0[lane], other.0[lane])))
    }
}

macro_rules! operators {
    ($($trait:ident $method:ident,)*) => {
        $(impl<T: Copy + $trait<Output = T>> $trait for Each<T> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.with(other, T::$method)
            }
        }

        impl<T: Copy + $trait<Output = T>> $trait<T> for Each<T> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: T) -> Self {
                self.map(|x| x.$method(other))
            }
        })*
    };
}

operators! {
    Add add, Sub sub, Mul mul, Div div, BitXor bitxor, BitAnd bitand, BitOr bitor, Shl shl, Shr shr,
}

impl<T: Copy + Not<Output = T>> Not for Each<T> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        self.map(T::not)
    }
}

impl<T: Copy + Neg<Output = T>> Neg for Each<T> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.map(T::neg)
    }
}

impl<T: Copy + Number> Number for Each<T> {
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(T::sqrt)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.map(T::abs)
    }

    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        self.with(other, T::greater)
    }
}

impl Real for Each<f32> {
    type Mask = Each<bool>;
    type Bits = Each<u32>;
    type Double = Each<f64>;

    const COUNT: usize = LANES;

    #[inline(always)]
    fn same(self, x: f32) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn double(self) -> Each<f64> {
        self.map(f64::from)
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        self.with(sign, f32::copysign)
    }

    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        self.with(other, Real::lesser)
    }

    #[inline(always)]
    fn above(self, other: Self) -> Each<bool> {
        Each(each(|lane| self.0[lane] > other.0[lane]))
    }

    #[inline(always)]
    fn select(mask: Each<bool>, yes: Self, no: Self) -> Self {
        Self(each(|lane| if mask.0[lane] { yes.0[lane] } else { no.0[lane] }))
    }

    #[inline(always)]
    fn bits(self) -> Each<u32> {
        self.map(f32::to_bits)
    }

    #[inline(always)]
    fn of_bits(bits: Each<u32>) -> Self {
        bits.map(f32::from_bits)
    }

    #[inline(always)]
    fn whole(self) -> Each<u32> {
        self.map(Real::whole)
    }

    #[inline(always)]
    fn store(self, to: &mut [f32; LANES]) {
        *to = self.0;
    }
}

impl Double for Each<f64> {
    type Real = Each<f32>;

    #[inline(always)]
    fn same(self, x: f64) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn above(self, other: Self) -> Each<bool> {
        Each(each(|lane| self.0[lane] > other.0[lane]))
    }

    #[inline(always)]
    fn single(self) -> Each<f32> {
        self.map(Double::single)
    }

    #[inline(always)]
    fn turned(self, by: Each<f32>) -> Self {
        Self(each(|lane| self.0[lane].turned(by.0[lane])))
    }
}

impl Bits for Each<u32> {
    type Real = Each<f32>;
    type Mask = Each<bool>;

    #[inline(always)]
    fn same(self, x: u32) -> Self {
        Self([x; LANES])
    }

    #[inline(always)]
    fn sum(self, other: Self) -> Self {
        self.with(other, u32::wrapping_add)
    }

    #[inline(always)]
    fn product(self, other: Self) -> Self {
        self.with(other, u32::wrapping_mul)
    }

    #[inline(always)]
    fn reversed(self) -> Self {
        self.map(u32::reverse_bits)
    }

    #[inline(always)]
    fn is_zero(self) -> Each<bool> {
        self.map(|x| x == 0)
    }

    #[inline(always)]
    fn select(mask: Each<bool>, yes: Self, no: Self) -> Self {
        Self(each(|lane| if mask.0[lane] { yes.0[lane] } else { no.0[lane] }))
    }

    #[inline(always)]
    fn real(self) -> Each<f32> {
        self.map(Bits::real)
    }
}

impl Mask for Each<bool> {
    #[inline(always)]
    fn lanes(self) -> u32 {
        (0..LANES).fold(0, |lanes, lane| lanes | u32::from(self.0[lane]) << lane)
    }
}
