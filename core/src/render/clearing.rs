use super::clear::{FacePlane, Side, holds_only};
use crate::block::BlockSource;
use crate::geometry::rounding::UNIT_ROUNDOFF;
use crate::geometry::{Aabb, Pyramid};
use crate::material::Surface;
use crate::scene::{Light, LightKind};
use crate::shade::{Bundle, Point, Shader, Sum};
use glam::{DVec3, Vec3};

/// Clearings of some lights: at most `N`; none where searches are left out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clearings<const N: usize>([Clearing; N]);

impl<const N: usize> Clearings<N> {
    pub(crate) const fn new() -> Self {
        Self([Clearing::new(); N])
    }

    /// What the light of a bundle brings, if it is known, and all of the light is known to be seen from the point. Then no ray of it need be made.
    pub(crate) fn whole<S: BlockSource>(
        &mut self,
        shader: &Shader<'_>,
        point: &Point,
        bundle: &Bundle,
        source: &mut S,
        searches: &mut u64,
    ) -> Option<Sum> {
        let whole = bundle.unshadowed()?;
        let light = shader.tables().lights.get(bundle.light as usize)?;
        let Self(clearings) = self;
        let clearing = clearings.get_mut((bundle.light as usize).checked_rem(N)?)?;
        let light = (bundle.light, light);
        let seen = clearing.shows(light, &point.surface, bundle.len, source, searches);
        seen.then(|| shader.unit().quantise(whole))
    }
}

/// Places from which a light is seen whole: whoever shades a point there need not ask.
///
/// A search finds one around the point that it is for. Surfaces come in runs of neighbours, so the next points mostly lie in it as well. How far it reaches is tried
/// out: twice as far after each that was found, half as far after each search in vain.
///
/// What is known is a box and a few planes: the pyramid from the box to the light touches nothing but triangles in these planes, and the light
/// is off all of them. So no ray to the light, from a point of the box that lies on the light's side of each, hits anything. (For such a triangle: if
/// its test were to find a hit, the ray would come within `TRIANGLE_ERROR * R` of its plane at a `t` of the ray, by the argument of
/// [`SurfacePoint::spawn`](crate::geometry::SurfacePoint::spawn); but both its ends lie farther off than that, on the same side.)
#[derive(Debug, Clone, Copy)]
struct Clearing {
    light: u32,
    bounds: Aabb,
    behind: [Option<(FacePlane, Side)>; BEHIND_MAX],
    /// Half the size of the next, in parts of the distance to the eye.
    reach: f32,
    /// What searches may cost: see [`SEARCH`].
    purse: u32,
    /// How often another light must be asked for until this one makes room.
    kept: u32,
}

/// Planes that may lie behind the points: of their own surface and of what is beside it.
const BEHIND_MAX: usize = 8;
const REACH_FIRST: f32 = 1.0 / 32.0;
const REACH_MAX: f32 = 0.5;
const REACH_MIN: f32 = 1.0 / 128.0;
/// The price of a search, about that of so many shadow rays that nothing is in the way of.
const SEARCH: u32 = 32;
/// What can be laid by: for searches in vain, each for half the size, before there are few.
const PURSE_MAX: u32 = 4 * SEARCH;
const KEPT: u32 = 32;

impl Clearing {
    const fn new() -> Self {
        Self {
            light: u32::MAX,
            bounds: Aabb::EMPTY,
            behind: [None; BEHIND_MAX],
            reach: REACH_FIRST,
            purse: PURSE_MAX,
            kept: 0,
        }
    }

    /// Whether all of a light that is wholly above a surface is seen from there, so that this many rays need not be made. `false` says nothing.
    fn shows<S: BlockSource>(
        &mut self,
        (index, light): (u32, &Light),
        surface: &Surface,
        rays: u32,
        source: &mut S,
        searches: &mut u64,
    ) -> bool {
        if self.light != index {
            if self.kept > 0 {
                self.kept = self.kept.saturating_sub(1);
                return false;
            }
            *self = Self { light: index, ..Self::new() };
        }
        self.kept = KEPT;
        let held = self.holds(surface.above);
        let earned = if held { rays } else { 1 };
        self.purse = self.purse.saturating_add(earned).min(PURSE_MAX);
        if held || self.purse < SEARCH {
            return held;
        }
        self.purse = self.purse.saturating_sub(SEARCH);
        *searches = searches.saturating_add(1);
        let found = self.search(light, surface, source);
        if !found {
            self.bounds = Aabb::EMPTY;
        }
        let factor = if found { 1.3 } else { 0.6 };
        self.reach = (self.reach * factor).clamp(REACH_MIN, REACH_MAX);
        found
    }

    /// Whether it is known of this place.
    fn holds(&self, from: Vec3) -> bool {
        self.bounds.contains(&Aabb::EMPTY.with(from))
            && self.behind.iter().flatten().all(|(plane, side)| plane.side_of(from) == Some(*side))
    }

    /// Looks round the point: whether it is free to see the light.
    fn search<S: BlockSource>(&mut self, light: &Light, surface: &Surface, source: &mut S) -> bool {
        let from = surface.above;
        let size = self.reach * surface.distance;
        // Flat along the surface.
        let half = (Vec3::ONE - surface.normal.abs()).max(Vec3::splat(THICKNESS)) * size;
        self.bounds = Aabb { min: from - half, max: from + half };
        self.behind = [None; BEHIND_MAX];
        let (bounds, behind) = (self.bounds, &mut self.behind);
        let mut len = 0;
        holds_only(Pyramid::to_light(&bounds, light), source, |primitive| {
            let is_behind = |plane: &FacePlane, side: Side| {
                side_of_light(plane, light, &bounds) == Some(side)
                    && plane.side_of(from) == Some(side)
            };
            for (plane, side) in behind.iter_mut().flatten() {
                if plane.take_in(primitive) {
                    return is_behind(plane, *side);
                }
            }
            let Some(plane) = FacePlane::new(primitive) else { return false };
            let Some(side) = plane.side_of(from) else { return false };
            let Some(place) = behind.get_mut(len) else { return false };
            *place = Some((plane, side));
            len = len.saturating_add(1);
            is_behind(&plane, side)
        })
    }
}

/// Thickness of the box, in parts of its width.
const THICKNESS: f32 = 1.0 / 16.0;

/// The side of a plane on which all shadow rays to a light end, from wherever in a box they come.
fn side_of_light(plane: &FacePlane, light: &Light, bounds: &Aabb) -> Option<Side> {
    let [position, u, v] = [light.position, light.u, light.v].map(|v| Vec3::from(v).as_dvec3());
    let (corners, radius): (&[DVec3], f64) = match LightKind::from_u32(light.kind)? {
        LightKind::Parallelogram => {
            (&[position, position + u, position + v, position + u + v], 0.0)
        }
        LightKind::Triangle => (&[position, position + u, position + v], 0.0),
        LightKind::Sphere => (&[position], u.x),
        LightKind::Disc | LightKind::Point | LightKind::Spot | LightKind::Distant => return None,
    };
    // Rays end before the light, by a clearance in parts of all lengths, and are rounded: far less than this.
    let of_plane = plane.bounds();
    let lengths =
        [bounds.min, bounds.max, of_plane.min, of_plane.max].map(|v| v.abs().max_element());
    let of_light = corners.iter().map(|c| c.abs().max_element() + radius);
    let all: f64 = lengths.into_iter().map(f64::from).chain(of_light).sum();
    let least = radius + 1024.0 * f64::from(UNIT_ROUNDOFF) * all;
    let heights = corners.iter().map(|c| plane.height(*c));
    if heights.clone().all(|height| height > least * plane.length) {
        Some(Side::Front)
    } else if heights.clone().all(|height| height < -least * plane.length) {
        Some(Side::Back)
    } else {
        None
    }
}

#[cfg(test)]
mod tests;
