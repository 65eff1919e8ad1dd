use super::Path;
use crate::geometry::Ray;
use crate::material::{Bsdf, Surface};
use crate::real::Real;

/// An intersection point: where a path met a surface that answers light. It waits for shadow rays and children.
///
/// All of it follows from the path, the ray and the hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// The place.
    pub surface: Surface,
    /// What its material does.
    pub bsdf: Bsdf,
    /// The path that ends here; its throughput has lost what the medium on the way took.
    pub path: Path,
    /// The probability of a reflected and of a transmitted child.
    #[cfg(feature = "specular")]
    pub(super) chance: [f32; 2],
    /// The ray that ended here, behind it: it goes straight on, and keeps its origin.
    #[cfg(feature = "specular")]
    pub(super) ahead: Ray,
}

/// A child that would bring less than this part of the pixel is sent with a probability in proportion, and stands for
/// those that are not.
#[cfg(feature = "specular")]
const IMPORTANCE_MIN: f32 = 1.0 / 80.0;

/// Up to this depth a point may send both its children; beyond, one at most, so that a path has at most four ends.
pub const SPLITS: u8 = 2;

impl Point {
    #[cfg_attr(feature = "bundles", inline(always))]
    pub(super) fn new(surface: Surface, bsdf: Bsdf, path: Path, bounces: u8, ahead: Ray) -> Self {
        #[cfg(feature = "specular")]
        let part = |albedo: glam::Vec3| f32::max((path.throughput * albedo).max_element(), 0.0);
        #[cfg(feature = "specular")]
        let kept = |part: f32| (part / IMPORTANCE_MIN).min(1.0);
        #[cfg(feature = "specular")]
        let chance = if path.depth < bounces {
            let (front, back) = (part(bsdf.gloss.reflect), part(bsdf.gloss.transmit));
            if path.depth < SPLITS {
                [kept(front), kept(back)]
            } else {
                let both = front + back;
                let each = if both > 0.0 { kept(both) / both } else { 0.0 };
                [front * each, back * each]
            }
        } else if path.shares_light() && bsdf.gloss.is_straight() {
            // Shadow rays pass as many panes as there are: so does the ray that shares their light.
            [0.0, kept(part(bsdf.gloss.transmit))]
        } else {
            [0.0; 2]
        };
        #[cfg(not(feature = "specular"))]
        let _ = (bounces, ahead);
        Self {
            surface,
            bsdf,
            path,
            #[cfg(feature = "specular")]
            chance,
            #[cfg(feature = "specular")]
            ahead,
        }
    }

    /// Whether it is of a flat surface without a highlight that takes of it, in clear air: what light brings to it from one direction is a cosine.
    #[inline(always)]
    pub(super) fn is_matt(&self) -> bool {
        let Self { surface, path, .. } = self;
        let is_matt = surface.shading == surface.normal && path.medium == Path::AIR;
        #[cfg(feature = "specular")]
        let is_matt = is_matt && self.bsdf.gloss.alpha <= 0.0 && !self.bsdf.gloss.is_polished();
        is_matt
    }

    /// Whether all that it has to do is to pass on what one ray brings: it asks no light, and sends one ray at most.
    #[must_use]
    pub fn passes_on(&self) -> bool {
        #[cfg(feature = "specular")]
        let splits = self.path.depth < SPLITS && !self.chance.contains(&0.0);
        #[cfg(not(feature = "specular"))]
        let splits = false;
        self.bsdf.answers() == [false; 2] && !splits
    }

    /// The density, over all its chances, with which this point itself sends a ray in a direction of this lobe density.
    #[inline(always)]
    pub(super) fn ray_density<R: Real>(&self, above: R::Mask, lobe: R) -> R {
        #[cfg(feature = "specular")]
        {
            let [front, back] = self.chance;
            lobe * R::select(above, lobe.same(front), lobe.same(back))
        }
        #[cfg(not(feature = "specular"))]
        {
            let _ = above;
            lobe.same(0.0)
        }
    }
}
