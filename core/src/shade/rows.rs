use super::FEW_LIGHTS;
use super::memo::Memo;
use crate::light::{Far, FarRows, Look, Plane};
use crate::material::Surface;
use crate::real::{LANES, Real};
use crate::scene::Light;
use crate::trace::{Kernel, Lanes, Tracer};

/// The first lights of a table, in the form in which lanes look at many of them together: a copy, for machines that have the memory for it.
///
/// It changes no result. What is not in it is looked at light by light, as all is where there is none.
#[derive(Debug, Clone)]
pub struct LightRows {
    /// How many there are.
    len: usize,
    rows: [FarRows; GROUPS],
    /// Of the first, where they are few.
    planes: [Option<Plane>; FEW_LIGHTS],
}

/// Groups of lights that lanes look at together.
pub(super) const GROUPS: usize = 64 / LANES;

impl LightRows {
    /// Of these lights.
    #[must_use]
    pub fn new(lights: &[Light]) -> Self {
        let mut rows = [FarRows::default(); GROUPS];
        for (rows, group) in rows.iter_mut().zip(lights.chunks(LANES)) {
            for (lane, light) in group.iter().enumerate() {
                Far::put(Far::new(light), rows, lane);
            }
        }
        let mut planes = [None; FEW_LIGHTS];
        if lights.len() <= FEW_LIGHTS {
            planes.iter_mut().zip(lights).for_each(|(to, light)| *to = Plane::of(light));
        }
        Self { len: lights.len().min(GROUPS.wrapping_mul(LANES)), rows, planes }
    }

    /// A light that is flat, if lights are few.
    #[inline(always)]
    pub(super) fn plane(&self, light: usize) -> Option<&Plane> {
        self.planes.get(light)?.as_ref()
    }

    /// The lights that are flat, if lights are few.
    #[inline(always)]
    pub(super) const fn planes(&self) -> &[Option<Plane>; FEW_LIGHTS] {
        &self.planes
    }

    /// Looks at all of them from a surface that answers light from its sides or not.
    #[inline(always)]
    pub(super) fn look<T: Tracer>(
        &self,
        tracer: T,
        surface: &Surface,
        answers: [bool; 2],
        memo: &mut Memo,
    ) {
        tracer.compute(Looks { rows: self, surface, answers, memo });
    }
}

/// [`LightRows::look`].
struct Looks<'a> {
    rows: &'a LightRows,
    surface: &'a Surface,
    answers: [bool; 2],
    memo: &'a mut Memo,
}

impl Kernel for Looks<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { rows: LightRows { len, rows, .. }, surface, answers, memo } = self;
        for (rows, looks) in rows.iter().zip(memo.begin(*len)) {
            for first in (0..LANES).step_by(L::Real::COUNT) {
                let far = Far::read(lanes, rows, first);
                let mut seen = [0.0; LANES];
                far.look(surface.position, surface.normal, answers).store(&mut seen);
                let places = looks.iter_mut().skip(first).take(L::Real::COUNT);
                places.zip(seen).for_each(|(place, look)| *place = Look(look));
            }
        }
    }
}
