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

use crate::embree::Rival;
use crate::rates::Rates;
use crate::rays::{KINDS, Sets};
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

/// A way to trace, what it is held against, and the ratios to reach with each kind of ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Way {
    name: &'static str,
    pub(crate) rival: Rival,
    goals: [f64; 3],
}

const WAYS: [Way; 4] = [
    Way::new("single", "robust", 1, [1.0, 1.0, 1.0]),
    Way::new("batch", "default", 1, [1.2, 1.2, 1.2]),
    Way::new("bundle", "avx2", 16, [0.7, 0.0, 0.7]),
    Way::new("single, scalar", "robust", 1, [0.0; 3]),
];

impl Way {
    const fn new(
        name: &'static str,
        configuration: &'static str,
        width: u32,
        goals: [f64; 3],
    ) -> Self {
        Self { name, rival: Rival { configuration, width }, goals }
    }

    /// All of them, or the one of this name.
    pub(crate) fn all(only: Option<&str>) -> Vec<Self> {
        let named = |way: &Self| only.is_none_or(|only| only == way.name);
        WAYS.into_iter().filter(named).collect()
    }
}

/// Passes over the same rays, one after the other, whose median counts in a round: as in `embree_bench.cpp`.
const PASSES: usize = 5;

/// What rays of each kind visit.
pub(crate) fn count(scene: &Scene, sets: &Sets) -> Result<(), Error> {
    let view = scene.view()?;
    sets.all().try_for_each(|(kind, rays)| count::print(scene.top.over(view), kind, rays))
}

/// The rays of a kind, in one way.
pub(crate) fn run(
    scene: &Scene,
    sets: &Sets,
    kind: &'static str,
    way: Way,
    table: &mut Table,
) -> Result<(), Error> {
    let rays = sets.of(kind);
    let view = scene.view()?;
    let source = scene.top.over(view);
    let any = kind == "shadow";
    let mut rates = [0.0; PASSES];
    for rate in &mut rates {
        let begin = ThreadTime::now();
        let hits = match way.name {
            "single" => single(Auto::detect(), source, rays, any),
            "batch" => batch(Auto::detect(), source, rays, any),
            "bundle" => bundle(Auto::detect(), source, rays, any),
            _ => single(Scalar, source, rays, any),
        }?;
        *rate = rays.len() as f64 / begin.elapsed().as_secs_f64() / 1e6;
        table.hits.insert((way.name, kind), hits);
    }
    let best = rates.iter().copied().fold(0.0, f64::max);
    table.rates.entry((way.name, kind)).or_default().add(median(&rates), best);
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
        for Way { name, rival, goals } in WAYS {
            let Rival { configuration, width } = rival;
            for (kind, goal) in KINDS.into_iter().zip(goals) {
                let Some(rates) = self.rates.get(&(name, kind)) else { continue };
                let hits = self.hits.get(&(name, kind)).copied().unwrap_or(0);
                print!("kiloray {name:16} {kind:8} {rates}  hits {hits}");
                if let Some(theirs) = peer.rates(rival, kind) {
                    let (pairs, best) = rates.to(theirs);
                    let ratio = median(&pairs);
                    let [least, most] =
                        [f64::min, f64::max].map(|of| pairs.iter().copied().fold(ratio, of));
                    print!(
                        "  {ratio:5.2} x {configuration} {width}, rounds {least:.2} to {most:.2}, at best {best:.2}"
                    );
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
