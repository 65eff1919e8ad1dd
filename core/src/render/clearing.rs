use super::clear::{FacePlane, holds_only};
use crate::block::BlockSource;
use crate::geometry::rounding::UNIT_ROUNDOFF;
use crate::geometry::{Aabb, Pyramid};
use crate::material::Surface;
use crate::scene::{Light, LightKind};
use crate::shade::{Bundle, Point, Shader, Sum};
use glam::{DVec3, Vec3};

/// Clearings that are known, at most `N`; none where searches are left out.
///
/// Searches pay for themselves, light by light: each costs what rays that need not be made have earned.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clearings<const N: usize> {
    known: [Clearing; N],
    /// Of lights whose numbers differ by other than multiples of `N`.
    searches: [Searches; N],
    /// How often it was asked, after [`KEPT`] times that count for nothing.
    asked: u64,
}

impl<const N: usize> Clearings<N> {
    pub(crate) const fn new() -> Self {
        Self { known: [Clearing::NOWHERE; N], searches: [Searches::of(u32::MAX); N], asked: KEPT }
    }

    /// What the light of a bundle brings, if it is known, and all of the light is known to be seen from the point. Then no ray of it need be made.
    pub(crate) fn whole<S: BlockSource>(
        &mut self,
        shader: &Shader<'_>,
        point: &Point,
        bundle: &Bundle,
        source: &mut S,
        searched: &mut u32,
    ) -> Option<Sum> {
        let whole = bundle.unshadowed()?;
        let light = shader.tables().lights.get(bundle.light as usize)?;
        let light = (bundle.light, light);
        let seen = self.show(light, &point.surface, bundle.len, source, searched);
        seen.then(|| shader.unit().quantise(whole))
    }

    /// Whether all of a light that is wholly above a surface is seen from there, so that this many rays need not be made. `false` says nothing.
    fn show<S: BlockSource>(
        &mut self,
        (index, light): (u32, &Light),
        surface: &Surface,
        rays: u32,
        source: &mut S,
        searched: &mut u32,
    ) -> bool {
        let Self { known, searches, asked } = self;
        *asked = asked.saturating_add(1);
        let is_free = |last: u64| asked.saturating_sub(last) > KEPT;
        let place = (index as usize).checked_rem(N).and_then(|at| searches.get_mut(at));
        let place = place.filter(|place| place.light == index || is_free(place.last));
        let Some(searches) = place else { return false };
        if searches.light != index {
            *searches = Searches::of(index);
        }
        searches.last = *asked;
        let holds =
            |clearing: &&mut Clearing| clearing.light == index && clearing.holds(surface.above);
        if let Some(clearing) = known.iter_mut().find(holds) {
            clearing.last = *asked;
            searches.earn(rays);
            return true;
        }
        // A search in vain may cost a part of the tracing at most.
        searches.earn(rays / 4);
        // In place of the one that has been of no use for longest.
        let place = known.iter_mut().min_by_key(|clearing| clearing.last);
        let place = place.filter(|place| place.light == index || is_free(place.last));
        let Some(place) = place else { return false };
        if !searches.pay() {
            return false;
        }
        *searched = searched.saturating_add(1);
        let found = Clearing::around(surface, searches.reach, light, source);
        searches.learn(found.is_some());
        if let Some(found) = found {
            *place = Clearing { light: index, last: *asked, ..found };
        }
        found.is_some()
    }
}

/// How often others must be asked for until what has been of no use makes room for another light's.
const KEPT: u64 = 32;

/// The searches for clearings of a light: how far they reach, and whether they are worth while.
#[derive(Debug, Clone, Copy)]
struct Searches {
    light: u32,
    /// When it was last asked for.
    last: u64,
    /// Half the size of the next box, in parts of the distance to the eye.
    reach: f32,
    /// What they may cost: see [`SEARCH`].
    purse: u32,
}

const REACH_FIRST: f32 = 1.0 / 32.0;
const REACH_MAX: f32 = 0.5;
const REACH_MIN: f32 = 1.0 / 128.0;
/// The price of a search, about that of so many shadow rays that nothing is in the way of.
const SEARCH: u32 = 64;
/// What can be laid by: for searches in vain, each for half the size, before there are few.
const PURSE_MAX: u32 = 4 * SEARCH;

impl Searches {
    const fn of(light: u32) -> Self {
        Self { light, last: 0, reach: REACH_FIRST, purse: PURSE_MAX }
    }

    /// So many rays need not be made, or may be laid out on a search.
    fn earn(&mut self, rays: u32) {
        self.purse = self.purse.saturating_add(rays).min(PURSE_MAX);
    }

    /// Pays for a search, if there is enough.
    fn pay(&mut self) -> bool {
        let left = self.purse.checked_sub(SEARCH);
        self.purse = left.unwrap_or(self.purse);
        left.is_some()
    }

    /// The next box is larger after each that was found, smaller after each in vain.
    fn learn(&mut self, found: bool) {
        let factor = if found { 2.0 } else { 0.5 };
        self.reach = (self.reach * factor).clamp(REACH_MIN, REACH_MAX);
    }
}

/// Places from which a light is seen whole: whoever shades a point there need not ask.
///
/// A search finds one around the point that it is for. Surfaces come in runs of neighbours, so the next points mostly lie in it as well.
///
/// What is known is a box and a few planes: the pyramid from the box to the light touches nothing but triangles in these planes, and the light
/// is off all of them. So no ray to the light, from a point of the box that lies on the light's side of each, hits anything. (For such a triangle: if
/// its test were to find a hit, the ray would come within `TRIANGLE_ERROR * R` of its plane at a `t` of the ray, by the argument of
/// [`SurfacePoint::spawn`](crate::geometry::SurfacePoint::spawn); but both its ends lie farther off than that, on the same side.)
#[derive(Debug, Clone, Copy)]
struct Clearing {
    light: u32,
    /// So many planes are behind the points: the first.
    len: u32,
    /// When it was last of use.
    last: u64,
    bounds: Aabb,
    behind: [FacePlane; BEHIND_MAX],
}

/// Planes that may lie behind the points: of their own surface and of what is beside it.
const BEHIND_MAX: usize = 4;
/// Thickness of the box, in parts of its width.
const THICKNESS: f32 = 1.0 / 16.0;

impl Clearing {
    /// Of no light.
    const NOWHERE: Self = Self {
        light: u32::MAX,
        len: 0,
        last: 0,
        bounds: Aabb::EMPTY,
        behind: [FacePlane::NOWHERE; BEHIND_MAX],
    };

    /// Whether it is known of this place.
    fn holds(&self, from: Vec3) -> bool {
        self.bounds.contains(&Aabb::EMPTY.with(from))
            && self.behind.iter().take(self.len as usize).all(|plane| plane.is_before(from))
    }

    /// Looks round a point, so far: whether it is free to see the light.
    fn around<S: BlockSource>(
        surface: &Surface,
        reach: f32,
        light: &Light,
        source: &mut S,
    ) -> Option<Self> {
        let from = surface.above;
        let size = reach * surface.distance;
        // Flat along the surface.
        let half = (Vec3::ONE - surface.normal.abs()).max(Vec3::splat(THICKNESS)) * size;
        let bounds = Aabb { min: from - half, max: from + half };
        let mut behind = [FacePlane::NOWHERE; BEHIND_MAX];
        let mut len = 0_u32;
        let clear = holds_only(Pyramid::to_light(&bounds, light), source, |primitive| {
            let is_behind =
                |plane: &FacePlane| plane.is_before(from) && is_before_light(plane, light, &bounds);
            for plane in behind.iter_mut().take(len as usize) {
                if plane.take_in(primitive) {
                    return is_behind(plane);
                }
            }
            let plane = FacePlane::new(primitive).and_then(|plane| plane.facing(from));
            let (Some(plane), Some(place)) = (plane, behind.get_mut(len as usize)) else {
                return false;
            };
            *place = plane;
            len = len.saturating_add(1);
            is_behind(&plane)
        });
        clear.then_some(Self { len, bounds, behind, ..Self::NOWHERE })
    }
}

/// Whether all shadow rays to a light end in front of a plane, from wherever in a box they come.
fn is_before_light(plane: &FacePlane, light: &Light, bounds: &Aabb) -> bool {
    let [position, u, v] = [light.position, light.u, light.v].map(|v| Vec3::from(v).as_dvec3());
    let (corners, radius): (&[DVec3], f64) = match LightKind::from_u32(light.kind) {
        Some(LightKind::Parallelogram) => {
            (&[position, position + u, position + v, position + u + v], 0.0)
        }
        Some(LightKind::Triangle) => (&[position, position + u, position + v], 0.0),
        Some(LightKind::Sphere) => (&[position], u.x),
        _ => return false,
    };
    // Rays end before the light, by a clearance in parts of all lengths, and are rounded: far less than this.
    let of_plane = plane.bounds();
    let lengths =
        [bounds.min, bounds.max, of_plane.min, of_plane.max].map(|v| v.abs().max_element());
    let of_light = corners.iter().map(|c| c.abs().max_element() + radius);
    let all: f64 = lengths.into_iter().map(f64::from).chain(of_light).sum();
    let least = radius + 1024.0 * f64::from(UNIT_ROUNDOFF) * all;
    corners.iter().all(|corner| plane.is_below(*corner, least))
}

#[cfg(test)]
mod tests;
