//! Surfaces, placed into the model.

use glam::DVec3;

use super::kinds::Shape;
use super::names::{Modifier, Names};
use super::xform::Xform;
use crate::import::Cause;
use crate::import::error::syntax;
use crate::model::Model;

/// How what is read is placed: by all the `xform`s around it.
#[derive(Debug, Clone)]
pub(super) struct Context {
    pub(super) xform: Xform,
    /// Surfaces are turned inside out.
    pub(super) invert: bool,
    /// The modifier of all surfaces, given by the outermost `xform -m`.
    pub(super) modifier: Option<Vec<u8>>,
}

impl Context {
    pub(super) const TOP: Self = Self { xform: Xform::IDENTITY, invert: false, modifier: None };
}

/// Enters a surface.
pub(super) fn add(
    model: &mut Model,
    names: &mut Names,
    context: &Context,
    modifier: Modifier,
    shape: Shape,
    numbers: &[f64],
) -> Result<(), Cause> {
    check(shape, numbers.len())?;
    let Some(material) = names.index(modifier, model)? else {
        model.note("a surface whose modifier is void: not seen, as in Radiance");
        return Ok(());
    };
    let x = &context.xform;
    let size = x.scale.abs();
    let vec = |v: &[f64]| v.first_chunk::<3>().map_or(DVec3::ZERO, |&v| v.into());
    let point = |at: usize| x.point(vec(numbers.get(at..).unwrap_or_default()));
    match (shape, numbers) {
        (Shape::Polygon, _) => {
            let mut points: Vec<DVec3> = numbers.chunks_exact(3).map(|p| x.point(vec(p))).collect();
            // A mirror image turns its winding round.
            if context.invert != (x.scale < 0.0) {
                points.reverse();
            }
            model.add_polygon(material, &points)?;
        }
        (Shape::Sphere { inward }, &[_, _, _, radius]) => {
            if radius < 0.0 {
                model.note("a radius below zero: turned inside out, as in Radiance");
            }
            let inward = inward ^ context.invert ^ (radius < 0.0);
            model.add_sphere(material, point(0), radius.abs() * size, inward)?;
        }
        (Shape::Cylinder { inward }, &[.., radius]) => {
            cone(model, context, material, [point(0), point(3)], [radius; 2], inward)?;
        }
        (Shape::Cone { inward }, &[.., r0, r1]) => {
            cone(model, context, material, [point(0), point(3)], [r0, r1], inward)?;
        }
        (Shape::Ring, &[_, _, _, dx, dy, dz, r0, r1]) => {
            let normal = x.vector(DVec3::new(dx, dy, dz));
            let normal = if context.invert { -normal } else { normal };
            model.add_ring(material, point(0), normal, [r0 * size, r1 * size])?;
        }
        (Shape::Source, &[dx, dy, dz, angle]) => {
            let known = model.lights.len();
            model.add_source(material, x.vector(DVec3::new(dx, dy, dz)), angle)?;
            let glow = names.definition(modifier).is_some_and(|d| d.glow);
            if let Some(light) = model.lights.get_mut(known) {
                // What only glows lights nothing from afar, as in Radiance's direct calculation.
                if glow {
                    light.reach = 0.0;
                    model.note("a glow as a source: seen, but lights nothing directly");
                } else if light.cone.take().is_some() {
                    model.note("a spotlight as a source: lights everywhere, not only its beam");
                }
            }
        }
        _ => {}
    }
    Ok(())
}

fn cone(
    model: &mut Model,
    context: &Context,
    material: u16,
    ends: [DVec3; 2],
    radius: [f64; 2],
    inward: bool,
) -> Result<(), Cause> {
    let [r0, r1] = radius;
    let turned = r0.min(r1) < 0.0 && r0.max(r1) <= 0.0;
    if turned {
        model.note("a radius below zero: turned inside out, as in Radiance");
    }
    let sign = if turned { -1.0 } else { 1.0 } * context.xform.scale.abs();
    let inward = inward ^ context.invert ^ turned;
    Ok(model.add_cone(material, ends, [r0 * sign, r1 * sign], inward)?)
}

/// The number of numbers is right.
fn check(shape: Shape, found: usize) -> Result<(), Cause> {
    let (right, needs) = match shape {
        Shape::Polygon => {
            (found.is_multiple_of(3) && found >= 9, "three for each of at least three corners")
        }
        Shape::Sphere { .. } => (found == 4, "4 (centre and radius)"),
        Shape::Cone { .. } => (found == 8, "8 (two ends and two radii)"),
        Shape::Cylinder { .. } => (found == 7, "7 (two ends and a radius)"),
        Shape::Ring => (found == 8, "8 (centre, direction and two radii)"),
        Shape::Source => (found == 4, "4 (direction and angle)"),
    };
    if right { Ok(()) } else { Err(syntax(format!("{found} numbers where it takes {needs}"))) }
}
