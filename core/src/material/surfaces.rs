use super::surface::{Facing, Surface, Surfacing};
use crate::geometry::{Base, Hit, Primitive, Ray};
use crate::real::{self, LANES, Mask, Real, Row, Rows, Vector};
use crate::trace::{Kernel, Lanes, Tracer};
use glam::Vec3;

/// The surfaces that [`LANES`] rays hit, made together as far as they are of triangles.
#[derive(Debug, Clone)]
pub(crate) struct Surfaces {
    position: Rows,
    above: Rows,
    below: Rows,
    normal: Rows,
    outgoing: Rows,
    distance: Row,
    side: Row,
    /// Those that are made, a bit each.
    made: u32,
    /// Whether rays may go on behind them.
    through: bool,
}

impl Surfaces {
    /// None yet.
    pub(crate) const fn new() -> Self {
        Self {
            position: Rows::NONE,
            above: Rows::NONE,
            below: Rows::NONE,
            normal: Rows::NONE,
            outgoing: Rows::NONE,
            distance: [0.0; LANES],
            side: [0.0; LANES],
            made: 0,
            through: false,
        }
    }

    /// Makes those of the first [`LANES`] rays, of which this is the direction and the hit.
    #[inline(always)]
    pub(crate) fn make<'a, T: Tracer>(
        &mut self,
        tracer: T,
        rays: impl Iterator<Item = (Vec3, &'a Option<Hit>)>,
        through: bool,
    ) {
        self.through = through;
        tracer.compute(Make { surfaces: self, rays });
    }

    /// Places and normals from lane `first` on.
    #[inline(always)]
    pub(crate) fn places<L: Lanes>(
        &self,
        lanes: L,
        first: usize,
    ) -> (Vector<L::Real>, Vector<L::Real>) {
        (self.position.read(lanes, first), self.normal.read(lanes, first))
    }

    /// Whether there is none.
    #[inline(always)]
    pub(crate) const fn is_empty(&self) -> bool {
        self.made == 0
    }

    /// Whether that of a ray is among them.
    #[inline(always)]
    pub(crate) const fn is_made(&self, lane: usize) -> bool {
        self.made >> lane & 1 != 0
    }

    #[inline(always)]
    fn has(&self, lane: usize, through: bool) -> bool {
        self.is_made(lane) && (self.through || !through)
    }

    #[inline(always)]
    fn facing(&self, lane: usize, through: bool) -> Facing<f32> {
        Facing {
            position: self.position.at(lane).into(),
            above: self.above.at(lane).into(),
            below: if through { &self.below } else { &self.above }.at(lane).into(),
            normal: self.normal.at(lane).into(),
            outgoing: self.outgoing.at(lane).into(),
            distance: real::at(&self.distance, lane),
            side: real::at(&self.side, lane),
        }
    }
}

/// The surface of a ray, as far as it is made: it has the bits of [`Surface::new`].
pub(crate) struct Made<'a> {
    pub(crate) surfaces: Option<&'a Surfaces>,
    pub(crate) lane: usize,
}

impl Surfacing for Made<'_> {
    #[inline(always)]
    fn surface(&self, ray: &Ray, hit: &Hit, through: bool) -> Surface {
        let facing = match self.surfaces {
            Some(surfaces) if surfaces.has(self.lane, through) => {
                surfaces.facing(self.lane, through)
            }
            _ => Facing::alone(ray, hit, through),
        };
        Surface::of(facing, hit)
    }
}

/// Lanes that are emptier than this cost more than they save.
const FULL: u32 = LANES as u32 / 2;

/// [`Surfaces::make`].
struct Make<'s, I> {
    surfaces: &'s mut Surfaces,
    rays: I,
}

impl<'a, I: Iterator<Item = (Vec3, &'a Option<Hit>)>> Kernel for Make<'_, I> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { surfaces: to, rays } = self;
        let [mut v0, mut v1, mut v2, mut direction] = [Rows::NONE; 4];
        let [mut b1, mut b2, mut t] = [[0.0; LANES]; 3];
        let mut triangles = 0_u32;
        for (lane, (towards, hit)) in rays.take(LANES).enumerate() {
            let Some(hit) = hit else { continue };
            let Primitive::Triangle { vertices: [a, b, c], .. } = hit.primitive else { continue };
            triangles |= 1 << lane;
            v0.set(lane, a);
            v1.set(lane, b);
            v2.set(lane, c);
            direction.set(lane, towards);
            real::set(&mut b1, lane, hit.b1);
            real::set(&mut b2, lane, hit.b2);
            real::set(&mut t, lane, hit.t);
        }
        to.made = 0;
        if triangles.count_ones() < FULL {
            return;
        }
        let mut found = 0;
        for first in (0..LANES).step_by(L::Real::COUNT) {
            // (Closures would be compiled without the instructions of the lanes.)
            let vertices = [v0.read(lanes, first), v1.read(lanes, first), v2.read(lanes, first)];
            let weights = [lanes.read(&b1, first), lanes.read(&b2, first)];
            let (base, edges) = Base::on_triangle(vertices, weights);
            found |= edges.has_normal().lanes() << first;
            let direction = direction.read(lanes, first);
            let facing = Facing::new(&base, direction, lanes.read(&t, first), to.through);
            to.position.put(first, facing.position);
            to.above.put(first, facing.above);
            to.below.put(first, facing.below);
            to.normal.put(first, facing.normal);
            to.outgoing.put(first, facing.outgoing);
            real::put(&mut to.distance, first, facing.distance);
            real::put(&mut to.side, first, facing.side);
        }
        to.made = found & triangles;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::Scalar;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-2.0f32..2.0).prop_map(Vec3::from)
    }

    /// Triangles, slivers, smooth ones, spheres, and none.
    fn hit() -> impl Strategy<Value = Option<Hit>> {
        let of_kind = (0..5, [point(), point(), point()], any::<[u16; 3]>(), 0f32..0.5, 0f32..0.5);
        of_kind.prop_map(|(kind, [a, b, c], codes, b1, b2)| {
            let thin = a + (b - a) * 0.5 + (c - a) * 1e-6;
            let normals = (kind == 2).then_some(codes.map(|code| u32::from(code) << 12));
            let primitive = match kind {
                0 => Primitive::Sphere { center: a, radius: 0.5, inward: false },
                1 => Primitive::Triangle { vertices: [a, b, thin], normals },
                _ => Primitive::Triangle { vertices: [a, b, c], normals },
            };
            (kind < 4).then_some(Hit { t: 1.0, b1, b2, material: 0, primitive, block: 0 })
        })
    }

    proptest! {
        #[test]
        fn surfaces_made_together_are_those_made_alone(
            rays in prop::collection::vec((point(), point(), hit()), 0..=LANES),
            through: bool,
        ) {
            let mut surfaces = Surfaces::new();
            surfaces.make(Scalar, rays.iter().map(|(_, direction, hit)| (*direction, hit)), through);
            for (lane, (origin, direction, hit)) in rays.iter().enumerate() {
                let Some(hit) = hit else { continue };
                let ray =
                    Ray { origin: *origin, direction: *direction, t_min: 0.0, t_max: f32::INFINITY };
                for through in [false, true] {
                    let made = Made { surfaces: Some(&surfaces), lane };
                    prop_assert_eq!(
                        made.surface(&ray, hit, through),
                        Surface::new(&ray, hit, through)
                    );
                }
            }
        }
    }
}
