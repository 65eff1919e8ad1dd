use std::fmt::Write;

use glam::DVec3;
use kiloray_core::scene::{LightKind, MaterialKind, ViewKind};
use kiloray_scene::model::{Model, View};

use super::{is_lamp, polygon_of};

/// The scene as Radiance text. Lights without a surface become `source`s or are refused.
///
/// # Errors
/// Names what Radiance has no form for.
pub fn radiance(model: &Model) -> Result<String, String> {
    let mut out = String::from("# written for comparison with other renderers\n");
    for (index, material) in model.materials.iter().enumerate() {
        let m = material;
        let _ = match m.kind {
            MaterialKind::Opaque => {
                writeln!(out, "void plastic m{index} 0 0 5 {} 0 0", rgb(m.diffuse))
            }
            // Not `mirror`: that makes virtual light sources, which lights by way of mirrors.
            MaterialKind::Mirror => {
                writeln!(out, "void metal m{index} 0 0 5 {} 1 0", rgb(m.specular))
            }
            MaterialKind::Dielectric => {
                writeln!(out, "void dielectric m{index} 0 0 5 1 1 1 {} 0", m.ior)
            }
            MaterialKind::Glass => {
                writeln!(out, "void glass m{index} 0 0 4 {} {}", rgb(m.transmit), m.ior)
            }
            MaterialKind::Light if is_lamp(model, index as u16) => {
                writeln!(out, "void light m{index} 0 0 3 {}", rgb(m.emission))
            }
            MaterialKind::Light => writeln!(out, "void glow m{index} 0 0 4 {} 0", rgb(m.emission)),
            MaterialKind::Void => Ok(()),
        };
    }
    let mut count = 0;
    let mut polygon = |material: u32, corners: &[DVec3]| {
        let _ = write!(out, "m{material} polygon p{count} 0 0 {}", corners.len() * 3);
        for corner in corners {
            let _ = write!(out, " {}", rgb(*corner));
        }
        out.push('\n');
        count += 1;
    };
    for light in &model.lights {
        let Some(material) = light.material else {
            return Err("a light without a surface".into());
        };
        if let Some(corners) = polygon_of(light) {
            polygon(u32::from(material), &corners);
        } else if light.kind != LightKind::Sphere {
            return Err(format!("a light of kind {:?}", light.kind));
        }
    }
    for triangle in &model.triangles {
        if !is_lamp(model, triangle.material) {
            polygon(
                u32::from(triangle.material),
                &triangle.vertices.map(|v| model.vertices[v as usize]),
            );
        }
    }
    for (index, sphere) in model.spheres.iter().enumerate() {
        let kind = if sphere.inward { "bubble" } else { "sphere" };
        let _ = writeln!(
            out,
            "m{} {kind} s{index} 0 0 4 {} {}",
            sphere.material,
            rgb(sphere.center),
            sphere.radius
        );
    }
    Ok(out)
}

/// A view as Radiance's `.vf` line.
#[must_use]
pub fn view_file(view: &View) -> String {
    let kind = if view.kind == ViewKind::Parallel { "l" } else { "v" };
    format!(
        "rvu -vt{kind} -vp {} -vd {} -vu {} -vh {} -vv {} -vs {} -vl {}\n",
        rgb(view.position),
        rgb(view.direction),
        rgb(view.up),
        view.size[0],
        view.size[1],
        view.offset[0],
        view.offset[1]
    )
}

fn rgb(v: DVec3) -> String {
    format!("{} {} {}", v.x, v.y, v.z)
}
