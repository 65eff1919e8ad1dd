//! Spheres, distant sources and views.

use glam::DVec3;
use kiloray_core::scene::{LightKind, ViewKind};

use super::mesh::{direction, is_valid, push};
use super::{COORDINATE_MAX, Emitter, Light, Model, ModelError, Sphere, View};

impl Model {
    /// Enters a sphere, whose front is inside if `inward`. A bad one is dropped and counted.
    ///
    /// # Errors
    /// If there are too many.
    pub fn add_sphere(
        &mut self,
        material: u16,
        center: DVec3,
        radius: f64,
        inward: bool,
    ) -> Result<(), ModelError> {
        if !self.has_material(material) {
            return Ok(());
        }
        if !(is_valid(center) && radius > 0.0 && radius <= COORDINATE_MAX) {
            self.note("a sphere without radius, or with a value that is no number: dropped");
            return Ok(());
        }
        if !self.is_void(material) {
            push(&mut self.spheres, Sphere { center, radius, material, inward }, "spheres")?;
        }
        if !inward {
            self.light(material, LightKind::Sphere, center, DVec3::X * radius, DVec3::ZERO);
        } else if self.is_sampled(material) {
            self.note(
                "a light that shines inward from a sphere: seen, but lights nothing directly",
            );
        }
        Ok(())
    }

    /// Enters a source infinitely far in `towards`, of any length, that appears as a disc of full
    /// angle `angle` \[degrees\], up to 360 for a sky all around. Its radiance is the material's
    /// emission: without any it is dropped and counted. If the material does not light others it is
    /// only seen (reach 0).
    ///
    /// # Errors
    /// If direction or angle cannot be rendered.
    pub fn add_source(
        &mut self,
        material: u16,
        towards: DVec3,
        angle: f64,
    ) -> Result<(), ModelError> {
        let Some(u) = direction(towards) else {
            return Err(ModelError::Source { what: "the direction has no length" });
        };
        if !(angle > 0.0 && angle <= 360.0) {
            return Err(ModelError::Source { what: "the angle must be above 0 and at most 360" });
        }
        if !self.has_material(material) {
            return Ok(());
        }
        let Some(m) = self.materials.get(usize::from(material)) else { return Ok(()) };
        let radiance = m.radiance();
        if radiance == DVec3::ZERO {
            self.note("a source whose material emits nothing: left out");
            return Ok(());
        }
        let (reach, cone) = match m.emitter {
            Emitter::None => (0.0, None),
            Emitter::Sampled { reach, cone } => (reach, cone),
            Emitter::Illum { .. } => (f64::INFINITY, None),
        };
        self.lights.push(Light {
            kind: LightKind::Distant,
            material: None,
            reach,
            position: DVec3::ZERO,
            u,
            v: DVec3::X * libm::cos(angle.to_radians() / 2.0),
            radiance,
            cone,
        });
        Ok(())
    }

    /// Enters a view; its direction may have any length.
    ///
    /// # Errors
    /// If it shows nothing.
    pub fn add_view(&mut self, mut view: View) -> Result<(), ModelError> {
        let fault = |what| Err(ModelError::View { what });
        if !is_valid(view.position) {
            return fault("the eye is no point, or beyond 1e100");
        }
        let (Some(ahead), Some(up)) = (direction(view.direction), direction(view.up)) else {
            return fault("the direction or the up vector has no length");
        };
        if ahead.cross(up).abs().max_element() < 1e-9 {
            return fault("the up vector is parallel to the direction");
        }
        let limit = match view.kind {
            ViewKind::Perspective => 179.9,
            ViewKind::Parallel => COORDINATE_MAX,
        };
        if !view.size.into_iter().all(|s| s > 0.0 && s <= limit) {
            return fault(match view.kind {
                ViewKind::Perspective => "an angle must be above 0 and below 180 degrees",
                ViewKind::Parallel => "a size must be above 0",
            });
        }
        if !view.offset.into_iter().all(|o| o.abs() <= 1e6) {
            return fault("shift or lift is no number, or beyond a million images");
        }
        let [fore, aft] = view.clip;
        if !(fore >= 0.0 && aft >= 0.0 && fore <= COORDINATE_MAX && aft <= COORDINATE_MAX) {
            return fault("a clipping distance is below zero or no number");
        }
        if aft > 0.0 && aft <= fore {
            return fault("the aft clipping distance is not beyond the fore one");
        }
        view.direction = ahead;
        self.views.push(view);
        Ok(())
    }
}
