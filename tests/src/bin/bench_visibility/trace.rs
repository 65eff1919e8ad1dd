//! Kiloray's side.

use std::collections::BTreeMap;
use std::path::Path;

use cpu_time::ThreadTime;
use kiloray_core::block::{Expanded, KiloView};
use kiloray_core::geometry::Ray;
use kiloray_core::trace::{BUNDLE, Batch, Bundle, Cursor, Scalar, Tracer};
use kiloray_render::Top;
use kiloray_simd::Auto;
use kiloray_tests::statistics::median;
use memmap2::{Advice, Mmap, MmapMut};

use crate::rates::Rates;
use crate::rays::Sets;
use crate::{Error, count, embree};

/// A compiled scene, in memory as a host has it.
pub(crate) struct Scene {
    memory: Memory,
    len: usize,
    pub(crate) top: Top,
}

enum Memory {
    /// Read once, in large pages where the system gives them.
    Read(MmapMut),
    /// The file itself.
    Mapped(Mmap),
}

impl Scene {
    pub(crate) fn new(bytes: &[u8], work: &Path, mapped: bool) -> Result<Self, Error> {
        let memory = if mapped {
            let path = work.join("scene.kilo");
            std::fs::write(&path, bytes)?;
            let file = std::fs::File::open(&path)?;
            // SAFETY: the file was just written, and nobody else writes it.
            Memory::Mapped(unsafe { Mmap::map(&file)? })
        } else {
            let mut memory = MmapMut::map_anon(bytes.len().next_multiple_of(2 << 20))?;
            // Large pages are a wish: without them it is slower, and no less right.
            let _ = memory.advise(Advice::HugePage);
            memory[..bytes.len()].copy_from_slice(bytes);
            Memory::Read(memory)
        };
        let mut scene = Self { memory, len: bytes.len(), top: Top::default() };
        let view = scene.view()?;
        view.check_blocks()?;
        scene.top = Top::new(&view);
        Ok(scene)
    }

    fn view(&self) -> Result<KiloView<'_>, Error> {
        let bytes = match &self.memory {
            Memory::Read(memory) => memory.get(..self.len),
            Memory::Mapped(memory) => memory.get(..self.len),
        };
        Ok(KiloView::parse(bytes.unwrap_or_default())?)
    }
}

/// Rates by way and kind of ray.
#[derive(Default)]
pub(crate) struct Table {
    rates: BTreeMap<(&'static str, &'static str), Rates>,
    hits: BTreeMap<(&'static str, &'static str), u64>,
}

/// The ways, and what each is held against: Embree's configuration, packet width, and the ratio to reach.
const WAYS: [(&str, &str, u32, [f64; 3]); 4] = [
    ("single", "robust", 1, [1.0, 1.0, 1.0]),
    ("batch", "default", 1, [1.2, 1.2, 1.2]),
    ("bundle", "avx2", 16, [0.7, 0.0, 0.7]),
    ("single, scalar", "robust", 1, [0.0; 3]),
];

/// Passes over the same rays, one after the other, whose median counts in a round: as in `embree_bench.cpp`.
const PASSES: usize = 5;

/// All ways in one round.
pub(crate) fn run(
    scene: &Scene,
    sets: &Sets,
    first: bool,
    only: Option<&str>,
    table: &mut Table,
) -> Result<(), Error> {
    let view = scene.view()?;
    let source = scene.top.over(view);
    for (kind, rays) in &sets.sets {
        if first {
            count::print(source, kind, rays)?;
        }
        let any = *kind == "shadow";
        for (way, ..) in WAYS {
            if only.is_some_and(|only| only != way) {
                continue;
            }
            let mut rates = [0.0; PASSES];
            for rate in &mut rates {
                let begin = ThreadTime::now();
                let hits = match way {
                    "single" => single(Auto::detect(), source, rays, any),
                    "batch" => batch(Auto::detect(), source, rays, any),
                    "bundle" => bundle(Auto::detect(), source, rays, any),
                    _ => single(Scalar, source, rays, any),
                }?;
                *rate = rays.len() as f64 / begin.elapsed().as_secs_f64() / 1e6;
                table.hits.insert((way, kind), hits);
            }
            let best = rates.iter().copied().fold(0.0, f64::max);
            table.rates.entry((way, kind)).or_default().add(median(&rates), best);
        }
    }
    Ok(())
}

#[inline(never)]
fn single(
    tracer: impl Tracer,
    mut source: Expanded<'_>,
    rays: &[Ray],
    any: bool,
) -> Result<u64, Error> {
    let mut cursor = Cursor::new();
    let mut hits = 0;
    for ray in rays {
        let hit = if any {
            tracer.any(&mut cursor, &mut source, ray)?
        } else {
            tracer.closest(&mut cursor, &mut source, ray)?.is_some()
        };
        hits += u64::from(hit);
    }
    Ok(hits)
}

#[inline(never)]
fn batch(
    tracer: impl Tracer,
    mut source: Expanded<'_>,
    rays: &[Ray],
    any: bool,
) -> Result<u64, Error> {
    let mut room = Batch::new();
    let mut hits = 0;
    let (mut closest, mut found) = ([None; 1024], [false; 1024]);
    for rays in rays.chunks(1024) {
        if any {
            tracer.any_batch(&mut room, &mut source, rays, &mut found[..rays.len()])?;
            hits += found[..rays.len()].iter().filter(|found| **found).count();
        } else {
            tracer.closest_batch(&mut room, &mut source, rays, &mut closest[..rays.len()])?;
            hits += closest[..rays.len()].iter().filter(|hit| hit.is_some()).count();
        }
    }
    Ok(hits as u64)
}

#[inline(never)]
fn bundle(
    tracer: impl Tracer,
    mut source: Expanded<'_>,
    rays: &[Ray],
    any: bool,
) -> Result<u64, Error> {
    let mut room = Bundle::new();
    let mut hits = 0;
    let (mut closest, mut found) = ([None; BUNDLE], [false; BUNDLE]);
    for rays in rays.chunks(BUNDLE) {
        if any {
            tracer.any_bundle(&mut room, &mut source, rays, &mut found[..rays.len()])?;
            hits += found[..rays.len()].iter().filter(|found| **found).count();
        } else {
            tracer.closest_bundle(&mut room, &mut source, rays, &mut closest[..rays.len()])?;
            hits += closest[..rays.len()].iter().filter(|hit| hit.is_some()).count();
        }
    }
    Ok(hits as u64)
}

impl Table {
    /// Prints rates, ratios, and whether each is reached.
    pub(crate) fn print(&self, peer: &embree::Table) {
        for (way, configuration, width, goals) in WAYS {
            for (kind, goal) in ["primary", "bounce", "shadow"].into_iter().zip(goals) {
                let Some(rates) = self.rates.get(&(way, kind)) else { continue };
                let hits = self.hits.get(&(way, kind)).copied().unwrap_or(0);
                print!("kiloray {way:16} {kind:8} {rates}  hits {hits}");
                if let Some(theirs) = peer.rates(configuration, kind, width) {
                    let (ratio, best) =
                        (rates.median() / theirs.median(), rates.best() / theirs.best());
                    print!("  {ratio:5.2} x {configuration} {width}, at best {best:.2}");
                    if goal > 0.0 {
                        let verdict = if ratio >= goal { "reached" } else { "not reached" };
                        print!(" (to reach {goal}: {verdict})");
                    }
                }
                if let Some(theirs) = peer.hits(kind) {
                    print!("  embree hits {theirs}");
                }
                println!();
            }
        }
    }
}
