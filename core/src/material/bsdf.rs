use super::Surface;
#[cfg(feature = "specular")]
use super::{ROUGHNESS_MIN, Ward, fresnel, pass::index, passing::Passing};
use crate::real::{Real, Vector};
use crate::scene::{Material, MaterialKind};
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;

/// What a material does with light at a surface, seen from one direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bsdf {
    /// Diffuse reflectance.
    pub diffuse: Vec3,
    /// Diffuse transmittance.
    pub through: Vec3,
    /// Light that leaves in or about one direction.
    #[cfg(feature = "specular")]
    pub gloss: Gloss,
}

/// Specular reflection and transmission.
#[cfg(feature = "specular")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gloss {
    /// Reflected part.
    pub reflect: Vec3,
    /// Transmitted part.
    pub transmit: Vec3,
    /// Roughness of both; 0 for a perfect mirror and a clear view.
    pub alpha: f32,
    /// Direction of transmitted light, where `alpha` is 0.
    pub ahead: Vec3,
    /// The transmitted ray changes from outside to inside, or back.
    pub crosses: bool,
    /// What a smooth highlight of plastic, metal or trans leaves to all else, seen from here; 1 where there is none.
    pub left: f32,
}

/// Light from one direction in each lane, after the surface: see [`Bsdf::evaluate`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response<R: Real = f32> {
    /// Diffuse part of the BSDF times the cosine.
    pub diffuse: Vector<R>,
    /// Glossy part of the BSDF times the cosine, and the density [1/sr] with which the glossy lobe on that side finds the direction; `None` if there is
    /// no such lobe: of a perfect mirror there is nothing.
    pub gloss: Option<(Vector<R>, R)>,
}

/// Which of the two glossy lobes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Reflected: the side that the ray came from.
    Front,
    /// Transmitted.
    Back,
}

#[cfg(feature = "specular")]
impl Gloss {
    const NONE: Self = Self {
        reflect: Vec3::ZERO,
        transmit: Vec3::ZERO,
        alpha: 0.0,
        ahead: Vec3::ZERO,
        crosses: false,
        left: 1.0,
    };

    /// Whether what passes goes straight on, as shadow rays do.
    #[must_use]
    pub(crate) fn is_straight(&self) -> bool {
        self.alpha <= 0.0 && !self.crosses
    }

    /// Whether it takes more from what comes aslant.
    #[inline(always)]
    pub(crate) fn is_polished(&self) -> bool {
        self.left < 1.0
    }

    #[cfg_attr(feature = "bundles", inline(always))]
    fn new(material: &Material, kind: MaterialKind, surface: &Surface) -> Self {
        let none = Self { ahead: -surface.outgoing, ..Self::NONE };
        match kind {
            MaterialKind::Opaque => {
                let reflect = Vec3::from(material.specular);
                let transmit = Vec3::from(material.transmit) * material.transmit_specular;
                // The roughness of nothing costs nothing.
                let glossy = reflect != Vec3::ZERO || transmit != Vec3::ZERO;
                let rough = glossy && material.roughness >= ROUGHNESS_MIN;
                if rough {
                    return Self { reflect, transmit, alpha: material.roughness, ..none };
                }
                let taken = fresnel::taken(reflect, || surface.shading.dot(surface.outgoing));
                let left = 1.0 - taken;
                let reflect = reflect + (Vec3::ONE - reflect) * taken;
                Self { reflect, transmit: transmit * left, left, ..none }
            }
            MaterialKind::Mirror => Self { reflect: material.specular.into(), ..none },
            MaterialKind::Dielectric => {
                let index = index(material);
                let ratio = if surface.front { 1.0 / index } else { index };
                let found = fresnel::interface(surface.outgoing, surface.shading, ratio);
                // A pencil of light changes its solid angle at the interface: radiance over the index squared is kept.
                let transmit = if found.refracted.is_some() {
                    Vec3::splat((1.0 - found.reflected) * ratio * ratio)
                } else {
                    Vec3::ZERO
                };
                Self {
                    reflect: Vec3::splat(found.reflected),
                    transmit,
                    ahead: found.refracted.unwrap_or(none.ahead),
                    crosses: true,
                    ..none
                }
            }
            MaterialKind::Glass => {
                let cos = surface.shading.dot(surface.outgoing);
                let (reflect, transmit) =
                    fresnel::pane(cos, index(material), material.transmit.into());
                Self { reflect, transmit, ..none }
            }
            MaterialKind::Void => Self { transmit: Vec3::ONE, ..none },
            MaterialKind::Light => none,
        }
    }
}

impl Bsdf {
    /// What the material does at the surface.
    #[must_use]
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn new(material: &Material, surface: &Surface) -> Self {
        let kind = MaterialKind::from_u32(material.kind).unwrap_or(MaterialKind::Light);
        let (diffuse, through) = if kind == MaterialKind::Opaque {
            let part = 1.0 - material.transmit_specular;
            (material.diffuse.into(), Vec3::from(material.transmit) * part)
        } else {
            (Vec3::ZERO, Vec3::ZERO)
        };
        #[cfg(not(feature = "specular"))]
        let _ = surface;
        #[cfg(feature = "specular")]
        let gloss = Gloss::new(material, kind, surface);
        #[cfg(feature = "specular")]
        let (diffuse, through): (Vec3, Vec3) = (diffuse * gloss.left, through * gloss.left);
        Self {
            diffuse,
            through,
            #[cfg(feature = "specular")]
            gloss,
        }
    }

    /// Whether light from the surface's own side, and from behind, can matter to light sampling.
    #[must_use]
    #[cfg_attr(not(feature = "bundles"), inline(never))]
    pub fn answers(&self) -> [bool; 2] {
        let (front, back) = (self.diffuse, self.through);
        #[cfg(feature = "specular")]
        let (front, back) = if self.gloss.alpha > 0.0 {
            (front + self.gloss.reflect, back + self.gloss.transmit)
        } else {
            (front, back)
        };
        [front.max_element() > 0.0, back.max_element() > 0.0]
    }

    /// What becomes of light that comes from the unit directions `incoming`.
    #[inline(always)]
    #[must_use]
    pub fn evaluate<R: Real>(&self, surface: &Surface, incoming: Vector<R>) -> Response<R> {
        let above = incoming.on(surface.normal);
        let (none, front) = (above.same(0.0), above.is_positive());
        // Both horizons count: the real one so that nothing leaks, the shaded one so that the shading is that of the smooth surface.
        let cos = incoming.on(surface.shading);
        let cos = R::select(front, cos, -cos);
        let is_lit = (front | none.above(above)) & cos.is_positive();
        let cos = R::select(is_lit, cos, none);
        let faded = cos * terminator(surface, above.abs(), cos) * FRAC_1_PI;
        let diffuse = of_side(front, self.diffuse, self.through, none) * faded;
        #[cfg(feature = "specular")]
        if self.gloss.alpha > 0.0 {
            let ward = Ward { normal: surface.shading, alpha: self.gloss.alpha };
            let (mut value, mut density) = ward.evaluate(incoming, surface.outgoing);
            if self.gloss.transmit != Vec3::ZERO {
                let passing = Passing { ahead: -surface.outgoing, alpha: self.gloss.alpha };
                // Its BSDF times the cosine is its density.
                let through = passing.density(incoming);
                value = R::select(front, value, through);
                density = R::select(front, density, through);
            } else {
                value = R::select(front, value, none);
                density = R::select(front, density, none);
            }
            let (value, density) =
                (R::select(is_lit, value, none), R::select(is_lit, density, none));
            let albedo = of_side(front, self.gloss.reflect, self.gloss.transmit, none);
            return Response { diffuse, gloss: Some((albedo * value, density)) };
        }
        #[cfg(feature = "specular")]
        if self.gloss.is_polished() {
            return Response { diffuse: diffuse * fresnel::polish(cos).complement(), gloss: None };
        }
        Response { diffuse, gloss: None }
    }
}

/// What [`Bsdf::evaluate`] says of a flat surface that only reflects diffusely, another one in each lane, for light from so far above.
#[cfg(feature = "bundles")]
#[inline(always)]
pub(crate) fn lambert<R: Real>(diffuse: Vector<R>, above: R) -> Vector<R> {
    diffuse * (above.at_least(0.0) * FRAC_1_PI)
}

/// One of two vectors by lane.
#[inline(always)]
fn of_side<R: Real>(front: R::Mask, one: Vec3, other: Vec3, like: R) -> Vector<R> {
    Vector::select(front, Vector::same(like, one), Vector::same(like, other))
}

/// Fades light out near the real horizon, where the shaded one lies lower: Chiang, Li, Burley 2019, "Taming the shadow
/// terminator", eq. 1-2. It is 1 for flat surfaces, and never more.
#[inline(always)]
fn terminator<R: Real>(surface: &Surface, above: R, cos: R) -> R {
    if surface.shading == surface.normal {
        return cos.same(1.0);
    }
    let g = above / (cos * surface.shading.dot(surface.normal));
    let g = g.at_most(1.0).at_least(0.0);
    (g.complement() * g + 1.0) * g
}

/// The direction on the other side of the plane.
#[cfg(feature = "specular")]
fn mirrored(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - normal * (2.0 * normal.dot(direction))
}

#[cfg(feature = "specular")]
impl Bsdf {
    /// A direction that the lobe on a side sends light from, for two numbers in [0, 1), of which a rough lobe alone asks: with its weight (the BSDF times the
    /// cosine over the density) and its density [1/sr], infinite for a perfect mirror or a clear view.
    #[must_use]
    pub fn sample(
        &self,
        surface: &Surface,
        side: Side,
        numbers: impl FnOnce() -> [f32; 2],
    ) -> Option<(Vec3, Vec3, f32)> {
        let gloss = &self.gloss;
        let albedo = match side {
            Side::Front => gloss.reflect,
            Side::Back => gloss.transmit,
        };
        let (direction, weight, density) = if gloss.alpha > 0.0 && side == Side::Back {
            let passing = Passing { ahead: -surface.outgoing, alpha: gloss.alpha };
            let direction = passing.sample(numbers());
            if direction.dot(surface.shading) >= 0.0 {
                return None;
            }
            (direction, albedo, passing.density(Vector::<f32>::from(direction)))
        } else if gloss.alpha > 0.0 {
            let ward = Ward { normal: surface.shading, alpha: gloss.alpha };
            let (direction, weight) = ward.sample(numbers(), surface.outgoing)?;
            let (_, density) = ward.evaluate(Vector::<f32>::from(direction), surface.outgoing);
            (direction, albedo * weight, density)
        } else {
            let direction = match side {
                Side::Front => -mirrored(surface.outgoing, surface.shading),
                Side::Back => gloss.ahead,
            };
            (direction, albedo, f32::INFINITY)
        };
        let above = surface.normal.dot(direction);
        let beyond = match side {
            Side::Front => above <= 0.0,
            Side::Back => above >= 0.0,
        };
        if !beyond {
            return Some((direction, weight, density));
        }
        if density.is_finite() {
            // The rough lobe is cut at the real horizon, for light sampling alike.
            return None;
        }
        // A mirror's ray that a bent normal sends into the surface is thrown back by the real one: smoothly, with all its energy.
        let direction = mirrored(direction, surface.normal);
        (direction.dot(surface.normal) != 0.0).then_some((direction, weight, density))
    }
}
