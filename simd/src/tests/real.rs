//! Numbers in lanes are those of one sample.

use kiloray_core::real::{Bits, Double, LANES, Mask, Number, Real};
use kiloray_core::trace::Lanes;
use proptest::prelude::*;

/// Eight numbers of these bits.
fn eight<L: Lanes>(lanes: L, bits: [u32; LANES]) -> L::Real {
    lanes.read(&bits.map(f32::from_bits), 0)
}

fn stored(x: impl Real) -> [f32; LANES] {
    let mut to = [0.0; LANES];
    x.store(&mut to);
    to
}

/// The bits of a number; of all NaN the same.
fn bits(x: f32) -> u32 {
    if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() }
}

/// Numbers near 1, all others, and those at the ends.
fn numbers() -> impl Strategy<Value = [u32; LANES]> {
    let ends = [0.0, -0.0, 1.0, f32::INFINITY, f32::MIN_POSITIVE, f32::NAN, f32::MAX, 1e-45];
    let number = prop_oneof![
        (-3f32..3.0).prop_map(f32::to_bits),
        any::<u32>(),
        prop::sample::select(ends.map(f32::to_bits).to_vec()),
    ];
    prop::array::uniform8(number)
}

proptest! {
    #[test]
    fn lanes_do_what_single_numbers_do(a in numbers(), b in numbers(), x: u32, shift in 0_u32..32) {
        of_all!(|lanes| agree(lanes, a, b, x, shift)?);
    }
}

fn agree<L: Lanes>(
    lanes_of: L,
    a: [u32; LANES],
    b: [u32; LANES],
    x: u32,
    shift: u32,
) -> Result<(), TestCaseError> {
    let (wide, other) = (eight(lanes_of, a), eight(lanes_of, b));
    let single = |f: fn(f32, f32) -> f32| -> [f32; LANES] {
        core::array::from_fn(|i| f(f32::from_bits(a[i]), f32::from_bits(b[i])))
    };
    let c = f32::from_bits(b[0]);
    let with_one = |f: fn(f32, f32) -> f32| -> [f32; LANES] {
        core::array::from_fn(|i| f(f32::from_bits(a[i]), c))
    };
    let cases = [
        ("+", wide + other, single(|a, b| a + b)),
        ("-", wide - other, single(|a, b| a - b)),
        ("*", wide * other, single(|a, b| a * b)),
        ("/", wide / other, single(|a, b| a / b)),
        ("+ c", wide + c, with_one(|a, b| a + b)),
        ("- c", wide - c, with_one(|a, b| a - b)),
        ("* c", wide * c, with_one(|a, b| a * b)),
        ("/ c", wide / c, with_one(|a, b| a / b)),
        ("-a", -wide, single(|a, _| -a)),
        ("same", wide.same(c), with_one(|_, c| c)),
        ("sqrt", wide.sqrt(), single(|a, _| Number::sqrt(a))),
        ("abs", wide.abs(), single(|a, _| Number::abs(a))),
        ("copysign", wide.copysign(other), single(Real::copysign)),
        ("greater", wide.greater(other), single(Number::greater)),
        ("lesser", wide.lesser(other), single(Real::lesser)),
        ("complement", wide.complement(), single(|a, _| 1.0 - a)),
        ("at_least", wide.at_least(c), with_one(Real::at_least)),
        ("at_most", wide.at_most(c), with_one(Real::at_most)),
        (
            "select",
            L::Real::select(wide.above(other), wide, other),
            single(|a, b| Real::select(a > b, a, b)),
        ),
        (
            "not",
            L::Real::select(!wide.above(other) & wide.always(), wide, other),
            single(|a, b| if a > b { b } else { a }),
        ),
        ("of_bits", L::Real::of_bits(wide.bits()), single(|a, _| a)),
        (
            "bits",
            L::Real::of_bits(Bits::select(wide.above(other), wide.bits(), other.bits())),
            single(|a, b| if a > b { a } else { b }),
        ),
    ];
    for (name, found, exact) in cases {
        prop_assert_eq!(stored(found).map(bits), exact.map(bits), "{}", name);
    }
    let lanes = |f: fn(f32, f32) -> bool| {
        (0..LANES).fold(0, |lanes, i| {
            lanes | u32::from(f(f32::from_bits(a[i]), f32::from_bits(b[i]))) << i
        })
    };
    prop_assert_eq!(wide.above(other).lanes(), lanes(|a, b| a > b));
    prop_assert_eq!((wide.above(other) | other.above(wide)).lanes(), lanes(|a, b| a > b || b > a));
    let whole = wide.bits();
    let as_bits = |x: <L::Real as Real>::Bits| stored(L::Real::of_bits(x)).map(f32::to_bits);
    prop_assert_eq!(as_bits(whole ^ other.bits()), core::array::from_fn(|i| a[i] ^ b[i]));
    prop_assert_eq!(as_bits(whole ^ x), a.map(|a| a ^ x));
    prop_assert_eq!(as_bits(whole & x), a.map(|a| a & x));
    prop_assert_eq!(as_bits(whole | x), a.map(|a| a | x));
    prop_assert_eq!(as_bits(whole.same(x)), [x; LANES]);
    prop_assert_eq!(
        as_bits(whole.sum(other.bits())),
        core::array::from_fn(|i| a[i].wrapping_add(b[i]))
    );
    prop_assert_eq!(
        as_bits(whole.product(other.bits())),
        core::array::from_fn(|i| a[i].wrapping_mul(b[i]))
    );
    prop_assert_eq!(as_bits(lanes_of.read_whole(&a, 0)), a);
    prop_assert_eq!(as_bits(whole << shift), a.map(|a| a << shift));
    prop_assert_eq!(as_bits(whole >> shift), a.map(|a| a >> shift));
    prop_assert_eq!(as_bits(whole.plus(x)), a.map(|a| a.wrapping_add(x)));
    prop_assert_eq!(as_bits(whole.times(x)), a.map(|a| a.wrapping_mul(x)));
    prop_assert_eq!(as_bits(whole.reversed()), a.map(u32::reverse_bits));
    prop_assert_eq!(stored(whole.real()).map(bits), a.map(|a| bits(a as i32 as f32)));
    prop_assert_eq!(
        as_bits(lanes_of.count_from(x)),
        core::array::from_fn(|i| x.wrapping_add(i as u32))
    );
    // Of what is no 32-bit number nobody asks.
    let small = a.map(|a| f32::from_bits(a & 0x807f_ffff | 0x3f80_0000) * 1e5);
    let wide = eight(lanes_of, small.map(f32::to_bits));
    prop_assert_eq!(as_bits(wide.whole()), small.map(|x| x as i32 as u32));
    prop_assert_eq!(as_bits(wide.nearest()), small.map(|x| x.round() as i32 as u32));
    Ok(())
}

proptest! {
    #[test]
    fn lanes_of_f64_do_what_single_numbers_do(a in numbers(), b in numbers(), near in 0_u32..9) {
        of_all!(|lanes| doubles_agree(lanes, a, b, f64::from(near) * 1e-9)?);
    }
}

/// Of numbers that f32 has, and of some next to them.
fn doubles_agree<L: Lanes>(
    lanes_of: L,
    a: [u32; LANES],
    b: [u32; LANES],
    near: f64,
) -> Result<(), TestCaseError> {
    let (by, other) = (eight(lanes_of, a), eight(lanes_of, b));
    let beside = |x: f64| x * (1.0 + near);
    let wide = by.double() * by.double().same(1.0 + near);
    let other = other.double();
    let single = |f: fn(f64, f64) -> f64| -> [f32; LANES] {
        core::array::from_fn(|i| {
            let [a, b] = [a[i], b[i]].map(|x| f64::from(f32::from_bits(x)));
            f(beside(a), b) as f32
        })
    };
    let turned = core::array::from_fn(|i| {
        let [a, b] = [a[i], b[i]].map(f32::from_bits);
        Double::turned(f64::from(b), a) as f32
    });
    let rest: [f32; LANES] = core::array::from_fn(|i| {
        let x = beside(f64::from(f32::from_bits(a[i])));
        (x - f64::from(x as f32)) as f32
    });
    let cases = [
        ("+", wide + other, single(|a, b| a + b)),
        ("-", wide - other, single(|a, b| a - b)),
        ("*", wide * other, single(|a, b| a * b)),
        ("/", wide / other, single(|a, b| a / b)),
        ("-a", -wide, single(|a, _| -a)),
        ("sqrt", wide.sqrt(), single(|a, _| Number::sqrt(a))),
        ("abs", wide.abs(), single(|a, _| Number::abs(a))),
        ("greater", wide.greater(other), single(Number::greater)),
        ("turned", other.turned(by), turned),
        ("rest", wide - wide.single().double(), rest),
    ];
    for (name, found, exact) in cases {
        prop_assert_eq!(stored(found.single()).map(bits), exact.map(bits), "{}", name);
    }
    let above = (0..LANES).fold(0, |lanes, i| {
        let [a, b] = [a[i], b[i]].map(|x| f64::from(f32::from_bits(x)));
        lanes | u32::from(beside(a) > b) << i
    });
    prop_assert_eq!(wide.above(other).lanes(), above);
    Ok(())
}
