//! A scene of nothing but rules: what a ray meets follows from its name.

use super::super::{Ends, Lit, Missing, Traced, Work, World};
use crate::block::BlockSource;
use crate::geometry::{Hit, Primitive, Ray};
use crate::path::PathKey;
use crate::shade::{Counts, PackedHit, Path, PathRay, Shadow, ShadowRay, Sum};
use crate::trace::Trail;
use glam::Vec3;

/// Pixels of a tile and camera rays of each are one; every ray passes some blocks, and hits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Toy {
    pub(super) tiles: u32,
    /// Blocks of the scene; all rays begin with block 0.
    pub(super) blocks: u32,
    /// Blocks on the way of a ray, at most.
    pub(super) way: u32,
    /// How often a path splits.
    pub(super) splits: u32,
    /// Reflections behind the last split.
    pub(super) tail: u32,
    /// Shadow rays of a point.
    pub(super) shadows: u32,
    pub(super) block_bytes: usize,
    pub(super) seed: u32,
    /// What came of the rays that were traced together last.
    pub(super) ends: [(Traced, Trail, PackedHit); TOGETHER],
}

/// Rays that are traced together.
pub(super) const TOGETHER: usize = 5;
/// Nothing came of any yet.
pub(super) const NO_ENDS: [(Traced, Trail, PackedHit); TOGETHER] =
    [(Traced::Done, Trail::START, PackedHit::NONE); TOGETHER];

fn hash(x: u64) -> u64 {
    PathKey { path: x, sample: 0 }.child(77).path
}

pub(super) struct ToyPoint(PathRay);
pub(super) struct ToyLights(u32);

impl Toy {
    /// Block `i` on the way of the ray of a name; `None` behind the last.
    fn block(&self, key: PathKey, i: u32) -> Option<u32> {
        let h = hash(key.path);
        let len = 1 + (h as u32) % self.way;
        match i {
            0 => Some(0),
            i if i < len => Some((hash(h ^ u64::from(i)) % u64::from(self.blocks)) as u32),
            _ => None,
        }
    }

    /// A ray hits something in the last block on its way.
    fn hit(&self, key: PathKey) -> PackedHit {
        let block = (0..).map_while(|i| self.block(key, i)).last().unwrap();
        let primitive = Primitive::Sphere { center: Vec3::ZERO, radius: 1.0, inward: false };
        PackedHit::new(Some(&Hit { t: 1.0, b1: 0.0, b2: 0.0, material: 0, primitive, block }))
    }

    fn light(key: PathKey) -> Sum {
        let h = hash(key.path ^ 99);
        Sum([(h & 0xffff) as i64, (h >> 16 & 0xffff) as i64, 1])
    }

    fn ray(key: PathKey, depth: u8) -> PathRay {
        let ray = Ray { origin: Vec3::ZERO, direction: Vec3::X, t_min: 0.0, t_max: 1.0 };
        PathRay::new(&ray, &Path { depth, ..Path::camera(key) }, 0)
    }

    fn key(&self, tile: u32) -> PathKey {
        PathKey::camera(self.seed.into(), tile, 0)
    }

    fn children_of(&self, ray: &PathRay) -> [Option<PathRay>; 2] {
        let depth = ray.depth();
        let child = |i| Some(Self::ray(ray.key().child(i), depth as u8 + 1));
        if depth < self.splits {
            [child(0), child(1)]
        } else if depth < self.splits + self.tail {
            [child(0), None]
        } else {
            [None; 2]
        }
    }

    /// The shadow ray's light tells its name to its blocks.
    fn shadow_of(&self, key: PathKey, j: u32) -> (Shadow, PathKey) {
        let key = key.child(1000 + j);
        let light = Vec3::new((key.path & 0xffff) as f32, (key.path >> 16 & 0xffff) as f32, 1.0);
        let ray = Ray { origin: light, direction: Vec3::X, t_min: 0.0, t_max: 1.0 };
        (Shadow::new(&ShadowRay { ray, light }, j % 2, 0), key)
    }

    fn of_light(light: Vec3) -> Sum {
        Sum([light.x as i64, light.y as i64, 1])
    }

    fn shadow_key(origin: Vec3) -> PathKey {
        PathKey { path: origin.x as u64 | (origin.y as u64) << 16, sample: 0 }
    }

    /// What a tile must come to.
    pub(super) fn expected(&self, tile: u32) -> Sum {
        let mut sum = Sum::ZERO;
        let mut rays = vec![Self::ray(self.key(tile), 0)];
        while let Some(ray) = rays.pop() {
            sum.add(Self::light(ray.key()));
            for j in 0..self.shadows {
                sum.add(Self::of_light(self.shadow_of(ray.key(), j).0.light()));
            }
            rays.extend(self.children_of(&ray).into_iter().flatten());
        }
        sum
    }

    /// What a block's bytes are.
    pub(super) fn bytes(&self, block: u32) -> impl Iterator<Item = u8> {
        (0..self.block_bytes).map(move |i| (hash(u64::from(block)) >> (i % 8)) as u8 ^ i as u8)
    }

    fn walk<S: BlockSource<Error = Missing>>(
        &self,
        source: &mut S,
        key: PathKey,
        trail: &mut Trail,
    ) -> Traced {
        let words: [u32; 5] = bytemuck::cast(*trail);
        let mut i = words[0];
        while let Some(block) = self.block(key, i) {
            if let Err(Missing(block)) = source.block(block) {
                *trail = bytemuck::cast([i, 0, 0, block, 0]);
                return Traced::Missing(block);
            }
            i += 1;
        }
        Traced::Done
    }

    fn together<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        keys: impl Iterator<Item = PathKey>,
    ) -> usize {
        let mut count = 0;
        for key in keys.take(TOGETHER) {
            let mut trail = Trail::START;
            let traced = self.walk(source, key, &mut trail);
            self.ends[count] = (traced, trail, self.hit(key));
            count += 1;
        }
        count
    }
}

impl World for Toy {
    type Point = ToyPoint;
    type Lights = ToyLights;

    fn tile_pixels(&self, tile: u32) -> usize {
        usize::from(tile < self.tiles)
    }

    fn camera(&mut self, tile: u32, next: &mut [u32; 3]) -> Option<PathRay> {
        let first = core::mem::replace(&mut next[0], 1) == 0;
        (first && tile < self.tiles).then(|| Self::ray(self.key(tile), 0))
    }

    fn closest<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        ray: &PathRay,
        trail: &mut Trail,
        best: &mut PackedHit,
        _: &mut Work,
    ) -> Traced {
        *best = self.hit(ray.key());
        self.walk(source, ray.key(), trail)
    }

    fn shadow<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        ray: &Ray,
        trail: &mut Trail,
        _: &mut [u32; 3],
        _: &mut Work,
    ) -> Traced {
        self.walk(source, Self::shadow_key(ray.origin), trail)
    }

    fn closest_together<'r, S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        rays: impl Iterator<Item = &'r PathRay>,
        _: &mut Work,
    ) -> usize {
        self.together(source, rays.map(PathRay::key))
    }

    fn closest_end(&self, at: usize) -> Option<(Traced, Trail, PackedHit)> {
        self.ends.get(at).copied()
    }

    fn shadows_together<S: BlockSource<Error = Missing>>(
        &mut self,
        source: &mut S,
        rays: impl Iterator<Item = Ray>,
        _: &mut Work,
    ) -> Ends {
        let count = self.together(source, rays.map(|ray| Self::shadow_key(ray.origin)));
        let apart = self.ends.iter().take(count).zip(0..);
        let apart = apart.filter(|((traced, ..), _)| *traced != Traced::Done);
        Ends { count, apart: apart.fold(0, |all, (_, at)| all | 1 << at), hidden: 0 }
    }

    fn shadow_end(&self, at: usize) -> Option<(Traced, Trail, [u32; 3])> {
        self.ends.get(at).map(|&(traced, trail, _)| (traced, trail, [0; 3]))
    }

    fn clear_of<'r, S: BlockSource<Error = Missing>>(
        &mut self,
        _: &mut S,
        _: impl ExactSizeIterator<Item = &'r Shadow> + Clone,
        _: &mut Work,
    ) -> usize {
        0
    }

    fn touched<'r, S: BlockSource<Error = Missing>>(
        &mut self,
        _: &mut S,
        rays: impl ExactSizeIterator<Item = &'r Shadow> + Clone,
        room: &mut [u32],
        _: &mut Work,
    ) -> usize {
        // Some blocks: right ones or wrong ones.
        let blocks = rays.map(|ray| ray.light().x as u32 % self.blocks);
        room.iter_mut().zip(blocks).map(|(place, block)| *place = block).count()
    }

    fn arrive(&self, ray: &PathRay, _: &PackedHit) -> (Sum, Option<ToyPoint>) {
        (Self::light(ray.key()), Some(ToyPoint(*ray)))
    }

    fn lights(&mut self, _: &ToyPoint, saved: Option<[u32; 8]>) -> ToyLights {
        ToyLights(saved.map_or(0, |saved| saved[0]))
    }

    fn next_light<S: BlockSource<Error = Missing>>(
        &mut self,
        _: &mut S,
        point: &ToyPoint,
        lights: &mut ToyLights,
        _: &mut Counts,
        _: &mut Work,
    ) -> Option<Lit> {
        let j = lights.0;
        lights.0 += 1;
        (j < self.shadows).then(|| Lit::By(self.shadow_of(point.0.key(), j).0))
    }

    fn shadow_key(&self, point: &ToyPoint, lights: &ToyLights) -> PathKey {
        self.shadow_of(point.0.key(), lights.0 - 1).1
    }

    fn save(&self, lights: &ToyLights) -> [u32; 8] {
        [lights.0, 0, 0, 0, 0, 0, 0, 1]
    }

    fn children(&self, point: &ToyPoint, _: u16, _: &mut Counts) -> [Option<PathRay>; 2] {
        self.children_of(&point.0)
    }

    fn passes_on(&self, point: &ToyPoint) -> bool {
        self.shadows == 0 && self.children_of(&point.0).iter().flatten().count() < 2
    }

    fn passed(&self, light: Vec3, _: [u32; 3]) -> Sum {
        Self::of_light(light)
    }

    fn splits(&self, depth: u32) -> usize {
        self.splits.saturating_sub(depth) as usize
    }

    fn check(&self, block: u32, bytes: &[u8]) -> bool {
        bytes.iter().copied().eq(self.bytes(block))
    }
}
