//! Changes that a parser may stumble over.

use fastrand::Rng;

/// Longest input, so that a run stays quick.
const LENGTH_MAX: usize = 1 << 14;

/// Words of the formats, and numbers at the edges.
const WORDS: &[&str] = &[
    "0",
    "-0",
    "1",
    "-1",
    "3",
    "9",
    "1e-300",
    "1e300",
    "-1e300",
    "1e999",
    "nan",
    "inf",
    "1e100",
    "1e-40",
    ".1",
    "4294967295",
    "4294967296",
    "18446744073709551616",
    "65536",
    "-9223372036854775808",
    "1/1/1",
    "1//1",
    "-1//-1",
    "/",
    "//",
    "void",
    "polygon",
    "sphere",
    "bubble",
    "cylinder",
    "tube",
    "cone",
    "cup",
    "ring",
    "source",
    "plastic",
    "metal",
    "trans",
    "dielectric",
    "interface",
    "glass",
    "mirror",
    "light",
    "illum",
    "glow",
    "spotlight",
    "alias",
    "inherit",
    "brightfunc",
    "mixfunc",
    "mesh",
    "instance",
    "BSDF",
    "m",
    "a",
    "!xform",
    "!genbox",
    "-a",
    "-i",
    "-n",
    "-m",
    "-I",
    "-t",
    "-rx",
    "-ry",
    "-rz",
    "-s",
    "-mx",
    "-b",
    "-f",
    "-o",
    "3.0",
    "-r",
    "a.rad",
    "a.obj",
    "|",
    ";",
    "'",
    "\"",
    "\\\n",
    "#",
    "!",
    "\n",
    "\r\n",
    "\r",
    "\t",
    "v",
    "vn",
    "vt",
    "f",
    "usemtl",
    "mtllib",
    "a.mtl",
    "newmtl",
    "Kd",
    "Ks",
    "Ke",
    "Ns",
    "Ni",
    "d",
    "Tr",
    "Tf",
    "illum 5",
    "illum 7",
    "Ka",
    "-halo",
    "xyz",
    "s",
    "call",
    "csh",
    "b c.mtl",
    "# x",
    "map_Kd",
    "-vtv",
    "-vtl",
    "-vth",
    "-vp",
    "-vd",
    "-vu",
    "-vh",
    "-vv",
    "-vs",
    "-vl",
    "-vo",
    "-va",
    "\u{feff}",
    "é",
];

/// Changes an input in one to eight places; sometimes takes a part of another.
pub(crate) fn mutate(rng: &mut Rng, seed: &[u8], other: &[u8], text: bool) -> Vec<u8> {
    let mut input = seed.to_vec();
    for _ in 0..rng.usize(1..=8) {
        if text && rng.u8(..) < 160 {
            words(rng, &mut input)
        } else {
            bytes(rng, &mut input, other)
        }
        input.truncate(LENGTH_MAX.max(seed.len()));
    }
    input
}

/// Replaces, inserts, repeats or removes words and lines.
fn words(rng: &mut Rng, input: &mut Vec<u8>) {
    let lines = rng.u8(..4) == 0;
    let ends = |b: &u8| if lines { *b == b'\n' } else { b.is_ascii_whitespace() };
    let cuts: Vec<usize> =
        input.iter().enumerate().filter(|(_, b)| ends(b)).map(|(i, _)| i).collect();
    let cut = |rng: &mut Rng| if cuts.is_empty() { 0 } else { cuts[rng.usize(..cuts.len())] };
    let from = cut(rng);
    let to = cuts.iter().copied().find(|&c| c > from).unwrap_or(input.len());
    let word = format!(" {} ", WORDS[rng.usize(..WORDS.len())]);
    match rng.u8(..6) {
        0 | 1 => drop(input.splice(from..to, word.bytes())),
        2 => drop(input.splice(from..from, word.bytes())),
        3 => drop(input.drain(from..to)),
        4 => {
            let part = input[from..to].to_vec();
            let at = cut(rng);
            let times = rng.usize(1..=40);
            drop(input.splice(at..at, part.repeat(times)));
        }
        _ => {
            let part = input[from..to].to_vec();
            let at = cut(rng);
            input.splice(at..at, part);
        }
    }
}

/// Changes bytes, whatever they mean.
fn bytes(rng: &mut Rng, input: &mut Vec<u8>, other: &[u8]) {
    let at = rng.usize(..=input.len());
    match rng.u8(..8) {
        0 => input.truncate(at),
        1 => input.insert(at, rng.u8(..)),
        2 if at < input.len() => input[at] = rng.u8(..),
        3 if at < input.len() => input[at] ^= 1 << rng.u8(..8),
        4 if at < input.len() => drop(input.remove(at)),
        5 if !other.is_empty() => {
            let from = rng.usize(..other.len());
            let to = rng.usize(from..=other.len());
            input.splice(at..at, other[from..to].iter().copied());
        }
        6 => {
            let end = (at + rng.usize(..64)).min(input.len());
            input.drain(at..end);
        }
        _ => {
            // A word of four bytes at an extreme: lengths and offsets of binary formats.
            let value = [0u32, 1, u32::MAX, 1 << 31, 0x7f80_0000, 0x7fc0_0000][rng.usize(..6)];
            for (byte, new) in input.iter_mut().skip(at & !3).zip(value.to_le_bytes()) {
                *byte = new;
            }
        }
    }
}
