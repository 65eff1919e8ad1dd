use super::deal::Deal;
use super::shadows::FEW;
use super::{Bundle, Point, ShadowRay, ShadowRays};
use crate::geometry::Ray;
use crate::light::Lamps;
use crate::material::lambert;
use crate::random::points_of;
use crate::real::{LANES, Mask, Real, Row, Rows, set};
use crate::trace::{Kernel, Lanes, Tracer};
use glam::Vec3;

/// Bundles of few rays, of any points to any lights, whose rays are made together, one in each lane.
///
/// They are what most points and lights are: flat lights that look small, and flat surfaces that only reflect diffusely, in clear air. All others are made
/// [bundle by bundle](super::Shader::shadow_rays).
#[derive(Debug, Clone)]
pub struct FewRays {
    from: Rows,
    above: Rows,
    normal: Rows,
    throughput: Rows,
    diffuse: Rows,
    position: Rows,
    u: Rows,
    v: Rows,
    shining: Rows,
    radiance: Rows,
    strength: Row,
    size: Row,
    /// Above zero for triangles.
    corners: Row,
    scale: Row,
    seeds: [[u32; LANES]; 3],
    index: [u32; LANES],
    owners: [Owner; LANES],
    len: usize,
}

/// Whose ray it is.
#[derive(Debug, Clone, Copy)]
struct Owner {
    light: u32,
    pixel: u16,
    /// The first ray of a bundle deals with its known light, for the others too.
    is_first: bool,
    /// It takes the rest of it.
    is_rest: bool,
    deal: Deal,
}

impl Owner {
    const NONE: Self =
        Self { light: 0, pixel: 0, is_first: true, is_rest: false, deal: Deal::UNKNOWN };
}

impl Default for FewRays {
    fn default() -> Self {
        Self::new()
    }
}

impl FewRays {
    /// None yet.
    #[must_use]
    pub const fn new() -> Self {
        const ROWS: Rows = Rows::NONE;
        const ROW: Row = [0.0; LANES];
        Self {
            from: ROWS,
            above: ROWS,
            normal: ROWS,
            throughput: ROWS,
            diffuse: ROWS,
            position: ROWS,
            u: ROWS,
            v: ROWS,
            shining: ROWS,
            radiance: ROWS,
            strength: ROW,
            size: ROW,
            corners: ROW,
            scale: ROW,
            seeds: [[0; LANES]; 3],
            index: [0; LANES],
            owners: [Owner::NONE; LANES],
            len: 0,
        }
    }

    /// Whether they must be made before a bundle finds room.
    #[must_use]
    pub const fn are_in_the_way_of(&self, bundle: &Bundle) -> bool {
        bundle.len < FEW && self.len.saturating_add(bundle.len as usize) > LANES
    }

    /// Forgets them.
    pub const fn clear(&mut self) {
        self.len = 0;
    }

    /// The light and the pixel of a ray.
    #[must_use]
    pub fn owner(&self, lane: u32) -> (u32, u16) {
        let owner = self.owners.get(lane as usize).unwrap_or(&Owner::NONE);
        (owner.light, owner.pixel)
    }

    /// Takes in a bundle of which no ray is made yet; `false` if it is to be made by itself.
    pub fn put(&mut self, point: &Point, bundle: &Bundle, pixel: u16) -> bool {
        let Point { surface, bsdf, path, .. } = point;
        if bundle.len >= FEW || !point.is_matt() || bsdf.through != Vec3::ZERO {
            return false;
        }
        let Some(lamp) = bundle.aim.lamp().filter(|_| !self.are_in_the_way_of(bundle)) else {
            return false;
        };
        for j in 0..bundle.len {
            let lane = self.len % LANES;
            self.from.set(lane, surface.position);
            self.above.set(lane, surface.above);
            self.normal.set(lane, surface.normal);
            self.throughput.set(lane, path.throughput);
            self.diffuse.set(lane, bsdf.diffuse);
            self.position.set(lane, lamp.position);
            self.u.set(lane, lamp.u);
            self.v.set(lane, lamp.v);
            self.shining.set(lane, lamp.normal);
            self.radiance.set(lane, bundle.aim.radiance());
            set(&mut self.strength, lane, lamp.strength);
            set(&mut self.size, lane, lamp.size);
            set(&mut self.corners, lane, if lamp.is_triangle { 1.0 } else { 0.0 });
            set(&mut self.scale, lane, bundle.scale);
            let (sequence, index) = bundle.place(point, j);
            let seeds = self.seeds.iter_mut().zip(sequence.seeds());
            seeds.for_each(|(row, seed)| set(row, lane, seed));
            set(&mut self.index, lane, index);
            let owner = Owner {
                light: bundle.light,
                pixel,
                is_first: j == 0,
                is_rest: bundle.is_rest(j),
                deal: bundle.deal,
            };
            set(&mut self.owners, lane, owner);
            self.len = lane.wrapping_add(1);
        }
        true
    }

    /// Makes all rays: each has the bits that [`Shader::shadow_ray`](super::Shader::shadow_ray) gives it.
    pub fn make<T: Tracer>(&self, tracer: T, rays: &mut ShadowRays) {
        tracer.compute(Few { few: self, rays });
    }
}

/// [`FewRays::make`].
struct Few<'a> {
    few: &'a FewRays,
    rays: &'a mut ShadowRays,
}

impl Kernel for Few<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { few, rays } = self;
        rays.begin(few.len as u32);
        let mut deal = Deal::UNKNOWN;
        for first in (0..few.len).step_by(L::Real::COUNT) {
            let row = |row: &Row| lanes.read(row, first);
            let rows = |rows: &Rows| rows.read(lanes, first);
            let lamps = Lamps {
                from: rows(&few.from),
                position: rows(&few.position),
                u: rows(&few.u),
                v: rows(&few.v),
                normal: rows(&few.shining),
                strength: row(&few.strength),
                size: row(&few.size),
                is_triangle: row(&few.corners).is_positive(),
            };
            let [shuffle, x, y] = &few.seeds;
            let whole = |row: &_| lanes.read_whole(row, first);
            let seeds = [whole(shuffle), whole(x), whole(y)];
            let sample = lamps.sample(points_of(seeds, whole(&few.index)));
            let above = sample.direction.dot(rows(&few.normal));
            let answer = lambert(rows(&few.diffuse), above);
            let power = rows(&few.radiance) * sample.inverse;
            let light = rows(&few.throughput) * answer * (power * row(&few.scale));
            let origin = rows(&few.above);
            let direction = sample.end.map_or(sample.direction, |end| end - origin);
            let is_lit = sample.is_lit.lanes();
            let [mut lights, mut origins, mut directions] = [Rows::NONE; 3];
            lights.put(0, light);
            origins.put(0, origin);
            directions.put(0, direction);
            for lane in 0..L::Real::COUNT.min(few.len.saturating_sub(first)) {
                let at = first.wrapping_add(lane);
                let owner = few.owners.get(at).unwrap_or(&Owner::NONE);
                if owner.is_first {
                    deal = owner.deal;
                }
                let is_lit = is_lit >> lane & 1 != 0;
                let light = if is_lit { deal.part(lights.at(lane), owner.is_rest) } else { None };
                rays.put(
                    at,
                    light.map(|light| {
                        let (origin, direction) = (origins.at(lane), directions.at(lane));
                        ShadowRay { ray: Ray { origin, direction, t_min: 0.0, t_max: 1.0 }, light }
                    }),
                );
            }
        }
    }
}
