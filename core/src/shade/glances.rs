use super::LightRows;
use crate::light::{Glance, GlanceRows};
use crate::material::Surfaces;
use crate::real::{LANES, Real};
use crate::trace::{Kernel, Lanes, Tracer};

use super::FEW_LIGHTS;

/// What the surfaces that [`LANES`] rays hit see of the lights, found together, where lights are few.
#[derive(Debug, Clone)]
pub(crate) struct Glances([GlanceRows; FEW_LIGHTS]);

impl Glances {
    /// None yet.
    pub(crate) const fn new() -> Self {
        Self([GlanceRows::NONE; FEW_LIGHTS])
    }

    /// Finds them.
    pub(crate) fn find<T: Tracer>(&mut self, tracer: T, surfaces: &Surfaces, lights: &LightRows) {
        if !surfaces.is_empty() && lights.planes().iter().any(Option::is_some) {
            tracer.compute(Find { glances: self, surfaces, lights });
        }
    }

    /// What the surface of a ray sees of a light.
    #[inline(always)]
    pub(super) fn get(&self, light: usize, lane: usize) -> Option<(Glance<f32>, Option<f32>)> {
        self.0.get(light).map(|rows| rows.get(lane))
    }
}

/// [`Glances::find`].
struct Find<'a> {
    glances: &'a mut Glances,
    surfaces: &'a Surfaces,
    lights: &'a LightRows,
}

impl Kernel for Find<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self, lanes: L) {
        let Self { glances, surfaces, lights } = self;
        for (rows, plane) in glances.0.iter_mut().zip(lights.planes()) {
            let Some(plane) = plane else { continue };
            for first in (0..LANES).step_by(L::Real::COUNT) {
                let (position, normal) = surfaces.places(lanes, first);
                rows.put(first, plane, position, normal);
            }
        }
    }
}
