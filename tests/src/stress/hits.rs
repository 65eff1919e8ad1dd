//! Closest hits, any hits and lanes over random scenes, against brute force.

use std::fmt;

use fastrand::Rng;
use kiloray_core::geometry::{Hit, Primitive, Ray};
use kiloray_core::trace::{Cursor, Scalar, Tracer};
use kiloray_render::Top;
use kiloray_simd::Auto;

use super::rays::ray;
use super::scenes::{KINDS, scene};
use super::sieve::Sieve;
use super::{compiled, primitives};
use crate::oracle::{Scene, Verdict, Wrong};

/// What a run has seen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Rays traced and judged.
    pub rays: u64,
    /// That hit something.
    pub hits: u64,
    /// Whose answer is not sure, but within the bounds of [`crate::oracle`].
    pub within_bounds: u64,
    /// Scenes.
    pub scenes: u64,
    /// Primitives of all scenes.
    pub primitives: u64,
}

impl Counts {
    /// Both together.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            hits: self.hits + other.hits,
            within_bounds: self.within_bounds + other.within_bounds,
            scenes: self.scenes + other.scenes,
            primitives: self.primitives + other.primitives,
        }
    }
}

/// A wrong answer, with all that makes it again.
#[derive(Debug, Clone)]
pub struct Failure {
    /// The seed of the run.
    pub seed: u64,
    /// The number of the scene.
    pub scene: u64,
    /// What is wrong.
    pub what: What,
}

/// What can be wrong.
#[derive(Debug, Clone)]
pub enum What {
    /// The scene could not be made or compiled.
    Scene(String),
    /// A closest hit is not the truth.
    Closest {
        /// The ray.
        ray: Ray,
        /// What was found.
        hit: Option<Hit>,
        /// Why that is wrong.
        wrong: Wrong,
    },
    /// Scalar lanes, the expanded top, or any hit, say something else than the closest hit.
    Differ {
        /// The ray.
        ray: Ray,
        /// The closest hit.
        hit: Option<Hit>,
        /// Of scalar lanes.
        scalar: Option<Hit>,
        /// With the top of the tree expanded.
        below: Option<Hit>,
        /// Any hit.
        any: bool,
    },
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "seed {} scene {}: {:#?}", self.seed, self.scene, self.what)
    }
}

/// Block sizes, each scene has one.
const BLOCKS: [usize; 4] = [1 << 10, 1 << 12, 1 << 14, 1 << 16];

/// Makes scene number `number` of a run, and judges `rays` rays over it.
///
/// # Errors
/// The first failure.
pub fn run(seed: u64, number: u64, rays: u64) -> Result<Counts, Box<Failure>> {
    let mut rng = Rng::with_seed(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ number);
    let failure = |what| Box::new(Failure { seed, scene: number, what });
    let broken = |e: &dyn fmt::Display| failure(What::Scene(e.to_string()));
    let model = scene(&mut rng, number as usize % KINDS).map_err(|e| broken(&e))?;
    let block_bytes = BLOCKS[rng.usize(0..BLOCKS.len())];
    let file = compiled(&model, block_bytes).map_err(|e| broken(&e))?;
    let mut view = file.view();
    let top = Top::new(&view);
    let mut topped = top.over(view);
    let primitives = primitives(&view);
    let mut counts = Counts { scenes: 1, primitives: primitives.len() as u64, ..Counts::default() };
    if primitives.is_empty() {
        return Ok(counts);
    }
    let sieve = Sieve::new(&primitives);
    let (tracer, mut cursor) = (Auto::detect(), Cursor::new());
    let mut few = Scene::default();
    let mut found = Vec::new();
    for i in 0..rays {
        let ray = ray(&mut rng, &primitives);
        let hit = tracer
            .closest(&mut cursor, &mut view, &ray)
            .map_err(|e| failure(What::Scene(format!("{e:?}"))))?;
        if i % 8 == 0 {
            let scalar = Scalar.closest(&mut cursor, &mut view, &ray).ok().flatten();
            let any = tracer.any(&mut cursor, &mut view, &ray).unwrap_or(hit.is_none());
            let below = tracer.closest(&mut cursor, &mut topped, &ray).ok().flatten();
            if scalar != hit || below != hit || any != hit.is_some() {
                return Err(failure(What::Differ { ray, hit, scalar, below, any }));
            }
        }
        found.clear();
        sieve.pass(&ray, &mut found);
        few.primitives.clear();
        few.primitives.extend(found.iter().map(|&i| primitives[i as usize]));
        let verdict = judge(&few, &primitives, &ray, hit.as_ref());
        counts.rays += 1;
        counts.hits += u64::from(hit.is_some());
        match verdict {
            Verdict::Right => {}
            Verdict::WithinBounds => counts.within_bounds += 1,
            Verdict::Wrong(wrong) => return Err(failure(What::Closest { ray, hit, wrong })),
        }
    }
    Ok(counts)
}

/// The verdict on a hit; one that the sieve has left out is judged among all.
fn judge(few: &Scene, all: &[(Primitive, u16)], ray: &Ray, hit: Option<&Hit>) -> Verdict {
    match few.judge(ray, hit) {
        Verdict::Wrong(Wrong::NotThere) => Scene { primitives: all.to_vec() }.judge(ray, hit),
        verdict => verdict,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_run_finds_nothing_wrong() {
        for number in 0..3 * KINDS as u64 {
            if let Err(failure) = run(1, number, 400) {
                panic!("{failure}");
            }
        }
    }
}
