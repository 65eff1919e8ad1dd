use std::hint::black_box;

use cpu_time::ThreadTime;
use kiloray_core::trace::Tracer;
use kiloray_scene::{builtin, compile, kilo::KiloFile};
use kiloray_simd::Auto;

use crate::failure::{Failure, Outcome};

/// Bytes that are copied or checked to find how long one takes.
const BYTES: u64 = 64 << 20;

/// Copying a byte, in pieces as packets have them \[ns\].
pub(super) fn copy_ns() -> f64 {
    let (from, mut to) = (vec![1_u8; 1 << 20], vec![0_u8; 1 << 20]);
    let begin = ThreadTime::now();
    for _ in 0..BYTES / from.len() as u64 {
        for (to, from) in to.chunks_mut(1024).zip(from.chunks(1024)) {
            black_box(&mut *to).copy_from_slice(black_box(from));
        }
    }
    begin.elapsed().as_nanos() as f64 / BYTES as f64
}

/// Checking a byte of a block, the mean over some scenes: spheres take longer than triangles \[ns\].
pub(super) fn check_ns() -> Outcome<f64> {
    const SCENES: [&str; 4] = ["sphereflake", "colour-cube", "conference", "sinc"];
    const BLOCK: usize = 4096;
    let tracer = Auto::detect();
    let mut mean = 0.0;
    for scene in SCENES {
        let model = builtin::build(scene).map_err(Failure::new)?;
        let options = compile::Options::blocks_of(BLOCK);
        let compiled = compile::compile(&model, &options, &mut ()).map_err(Failure::new)?;
        let file = KiloFile::from_compiled(compiled);
        let file = file.view();
        let (blocks, limits) = (file.block_section(), file.limits());
        let begin = ThreadTime::now();
        let mut bytes = 0;
        while bytes < BYTES {
            for (block, block_bytes) in (0..).zip(blocks.chunks(BLOCK)) {
                black_box(tracer.check(block_bytes, block, &limits)).map_err(Failure::new)?;
                bytes += BLOCK as u64;
            }
        }
        mean += begin.elapsed().as_nanos() as f64 / bytes as f64 / SCENES.len() as f64;
    }
    Ok(mean)
}
