use super::Dark;
use super::aim::{Aim, takes};
use crate::material::Surface;
#[cfg(feature = "bundles")]
use crate::real::{self, LANES};
use crate::real::{Real, Vector};
use crate::scene::{Light, LightKind};
#[cfg(feature = "bundles")]
use crate::trace::Lanes;
use core::f32::consts::PI;
use glam::Vec3;

/// Parallelograms, triangles and discs, one in each lane, for a quick look at them from points for which they are small.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Far<R: Real> {
    center: Vector<R>,
    /// Of the plane.
    position: Vector<R>,
    /// At right angles to it, on the side that shines, of any length.
    normal: Vector<R>,
    /// Of a sphere round the centre that holds it, squared.
    radius2: R,
    /// Its area, in areas of the parallelogram of its sides.
    part: R,
    reach: R,
    /// The greatest component of its radiance.
    brightest: R,
}

/// What a quick look at a light shows: a number, which lanes can put down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Look(pub(crate) f32);

/// What there is to a [`Look`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Seen {
    /// Nothing: it is to be looked at closely.
    Near,
    /// Its [estimate](Aim::estimate), roughly.
    Far(f32),
    /// Why it cannot light the point.
    Dark(Dark),
}

const FACES_AWAY: f32 = -1.0;
const OUT_OF_REACH: f32 = -2.0;
const BELOW: f32 = -3.0;

impl Look {
    /// Nothing.
    pub(crate) const NEAR: Self = Self(f32::NAN);

    /// At a light from a point of a surface that answers light from its sides or not.
    #[inline(always)]
    pub(crate) fn new(light: &Light, surface: &Surface, answers: [bool; 2]) -> Self {
        let look = |far: Far<f32>| Self(far.look(surface.position, surface.normal, answers));
        Far::new(light).map_or(Self::NEAR, look)
    }

    /// What it shows.
    #[inline(always)]
    pub(crate) fn seen(self) -> Seen {
        match self.0 {
            estimate if estimate >= 0.0 => Seen::Far(estimate),
            FACES_AWAY => Seen::Dark(Dark::FacesAway),
            OUT_OF_REACH => Seen::Dark(Dark::OutOfReach),
            BELOW => Seen::Dark(Dark::Below),
            _ => Seen::Near,
        }
    }
}

impl Far<f32> {
    /// This light, if it is one of these.
    #[inline(always)]
    pub(crate) fn new(light: &Light) -> Option<Self> {
        let (part, sides) = match LightKind::from_u32(light.kind)? {
            _ if light.focus > 0.0 => return None,
            LightKind::Parallelogram => (1.0, 0.5),
            LightKind::Triangle => (0.5, 1.0),
            LightKind::Disc => (PI, 1.0),
            _ => return None,
        };
        let brightest = Vec3::from(light.radiance).max_element();
        if brightest.is_nan() || brightest <= 0.0 {
            return None;
        }
        let (u, v) = (Vec3::from(light.u), Vec3::from(light.v));
        Some(Self {
            center: Aim::center(light).into(),
            position: Vec3::from(light.position).into(),
            normal: u.cross(v).into(),
            radius2: sides * (u.dot(u) + v.dot(v)),
            part,
            reach: light.reach,
            brightest,
        })
    }
}

impl<R: Real> Far<R> {
    /// A [`Look`] from a point of a surface of this normal, that [takes](Aim::new) light from its sides or not.
    ///
    /// It is near where it may not look small, or numbers are too large or small for this.
    #[inline(always)]
    pub(crate) fn look(&self, from: Vec3, normal: Vec3, answers: [bool; 2]) -> R {
        let like = self.part;
        let to = self.center - from;
        let square = to.dot(to);
        // Height above its plane, times the length of the normal.
        let facing = (Vector::same(like, from) - self.position).dot(self.normal);
        let quotient = like * facing / (square * square);
        let is_far = square.above(self.radius2 * 4.0)
            & like.same(f32::MAX).above(square)
            & quotient.abs().above(like.same(f32::MIN_POSITIVE.next_down()));
        let (radius, distance) = (self.radius2.sqrt(), square.sqrt());
        let height = to.on(normal);
        let is_taken = takes(answers, height, radius, distance);
        let estimate = self.brightest * (quotient * (height.abs() + radius).lesser(distance));
        let dark = |is_dark, why, or| R::select(is_dark, like.same(why), or);
        let look = dark(!is_taken, BELOW, estimate);
        let look = dark(square.above(self.reach * self.reach), OUT_OF_REACH, look);
        let look = dark(!facing.is_positive(), FACES_AWAY, look);
        R::select(is_far, look, like.same(f32::NAN))
    }
}

/// The numbers of as many of them as there are lanes, a row each.
#[cfg(feature = "bundles")]
pub(crate) type FarRows = [[f32; LANES]; NUMBERS];

/// Numbers of one.
#[cfg(feature = "bundles")]
const NUMBERS: usize = 13;

#[cfg(feature = "bundles")]
impl Far<f32> {
    /// Puts it down in a lane; `None` is near to everything.
    pub(crate) fn put(this: Option<Self>, rows: &mut FarRows, lane: usize) {
        let numbers = this.map_or([f32::NAN; NUMBERS], |this| {
            let Self { center: c, position: p, normal: n, radius2, part, reach, brightest } = this;
            [c.x, c.y, c.z, p.x, p.y, p.z, n.x, n.y, n.z, radius2, part, reach, brightest]
        });
        for (row, number) in rows.iter_mut().zip(numbers) {
            real::set(row, lane, number);
        }
    }
}

#[cfg(feature = "bundles")]
impl<R: Real> Far<R> {
    /// Those from lane `first` on.
    #[inline(always)]
    pub(crate) fn read<L: Lanes<Real = R>>(lanes: L, rows: &FarRows, first: usize) -> Self {
        let row = |row| lanes.read(row, first);
        let vector = |x, y, z| Vector { x: row(x), y: row(y), z: row(z) };
        let [cx, cy, cz, px, py, pz, nx, ny, nz, radius2, part, reach, brightest] = rows;
        Self {
            center: vector(cx, cy, cz),
            position: vector(px, py, pz),
            normal: vector(nx, ny, nz),
            radius2: row(radius2),
            part: row(part),
            reach: row(reach),
            brightest: row(brightest),
        }
    }
}
