use std::fmt::Write as _;
use std::fs;
use std::io::{self, Write as _};
use std::path::Path;

use glam::DVec3;
use kiloray_core::scene::{LightKind, MaterialKind, ViewKind};
use kiloray_scene::model::{Model, View};

use super::{is_lamp, polygon_of};

/// Writes `scene.xml` and a mesh per material into `folder`. Size and
/// sampler are parameters of the file, the integrator is left to whoever loads it.
///
/// # Errors
/// What the file system says; `InvalidInput` for what Mitsuba has no form for.
pub fn mitsuba(model: &Model, view: &View, folder: &Path) -> io::Result<()> {
    let mut out = String::from(
        "<scene version=\"3.0.0\">\n<default name=\"width\" value=\"128\"/>\n\
         <default name=\"height\" value=\"128\"/>\n\
         <default name=\"sampler\" value=\"independent\"/>\n",
    );
    sensor(&mut out, view)?;
    for (index, _) in model.materials.iter().enumerate() {
        bsdf(&mut out, model, index);
    }
    lights(&mut out, model, folder)?;
    for index in 0..model.materials.len() {
        let corners: Vec<_> = model
            .triangles
            .iter()
            .filter(|t| usize::from(t.material) == index && !is_lamp(model, t.material))
            .map(|t| t.vertices.map(|v| model.vertices[v as usize]))
            .collect();
        if corners.is_empty() || model.materials[index].kind == MaterialKind::Void {
            continue;
        }
        let name = format!("m{index}.ply");
        ply(&folder.join(&name), &corners)?;
        let _ = writeln!(
            out,
            "<shape type=\"ply\"><string name=\"filename\" value=\"{name}\"/>\
             <boolean name=\"face_normals\" value=\"true\"/><ref id=\"b{index}\"/>{}</shape>",
            emitter(model, index)
        );
    }
    for sphere in &model.spheres {
        let index = usize::from(sphere.material);
        let _ = writeln!(
            out,
            "<shape type=\"sphere\"><point name=\"center\" {}/><float name=\"radius\" \
             value=\"{}\"/><boolean name=\"flip_normals\" value=\"{}\"/><ref id=\"b{index}\"/>{}\
             </shape>",
            xyz(sphere.center),
            sphere.radius,
            sphere.inward,
            emitter(model, index)
        );
    }
    out.push_str("</scene>\n");
    fs::write(folder.join("scene.xml"), out)
}

fn sensor(out: &mut String, view: &View) -> io::Result<()> {
    if view.kind != ViewKind::Perspective || view.offset != [0.0; 2] {
        return refuse("only a centred perspective view");
    }
    let _ = writeln!(
        out,
        "<sensor type=\"perspective\"><float name=\"fov\" value=\"{}\"/>\
         <string name=\"fov_axis\" value=\"x\"/>\
         <float name=\"near_clip\" value=\"0.001\"/><float name=\"far_clip\" value=\"100000\"/>\
         <transform name=\"to_world\"><lookat origin=\"{}\" target=\"{}\" up=\"{}\"/></transform>\
         <sampler type=\"$sampler\"/><film type=\"hdrfilm\"><integer name=\"width\" value=\"$width\"/>\
         <integer name=\"height\" value=\"$height\"/><string name=\"pixel_format\" value=\"rgb\"/>\
         <string name=\"component_format\" value=\"float32\"/><rfilter type=\"box\"/></film>\
         </sensor>",
        view.size[0],
        list(view.position),
        list(view.position + view.direction),
        list(view.up)
    );
    Ok(())
}

fn bsdf(out: &mut String, model: &Model, index: usize) {
    let m = &model.materials[index];
    let inner = match m.kind {
        MaterialKind::Opaque => format!(
            "<bsdf type=\"twosided\" id=\"b{index}\"><bsdf type=\"diffuse\">{}</bsdf></bsdf>",
            rgb("reflectance", m.diffuse)
        ),
        MaterialKind::Mirror => format!(
            "<bsdf type=\"twosided\" id=\"b{index}\"><bsdf type=\"conductor\">\
             <string name=\"material\" value=\"none\"/>{}</bsdf></bsdf>",
            rgb("specular_reflectance", m.specular)
        ),
        MaterialKind::Dielectric => format!(
            "<bsdf type=\"dielectric\" id=\"b{index}\"><float name=\"int_ior\" value=\"{}\"/>\
             <float name=\"ext_ior\" value=\"1\"/></bsdf>",
            m.ior
        ),
        MaterialKind::Glass => format!(
            "<bsdf type=\"thindielectric\" id=\"b{index}\"><float name=\"int_ior\" value=\"{}\"/>\
             <float name=\"ext_ior\" value=\"1\"/></bsdf>",
            m.ior
        ),
        MaterialKind::Light | MaterialKind::Void => {
            format!(
                "<bsdf type=\"diffuse\" id=\"b{index}\">{}</bsdf>",
                rgb("reflectance", DVec3::ZERO)
            )
        }
    };
    let _ = writeln!(out, "{inner}");
}

/// A lamp that is a parallelogram is one `rectangle`: Mitsuba samples that best.
fn lights(out: &mut String, model: &Model, folder: &Path) -> io::Result<()> {
    for (number, light) in model.lights.iter().enumerate() {
        let Some(material) = light.material else {
            return refuse("a light without a surface");
        };
        let index = usize::from(material);
        let tail = format!("<ref id=\"b{index}\"/>{}</shape>", emitter(model, index));
        let (p, u, v) = (light.position, light.u, light.v);
        match light.kind {
            LightKind::Sphere => {} // With the other spheres.
            LightKind::Parallelogram if u.dot(v).abs() < 1e-9 * u.length() * v.length() => {
                let (c, u, v) = (p + (u + v) * 0.5, u * 0.5, v * 0.5);
                let n = u.cross(v).normalize();
                let rows: Vec<String> =
                    (0..3).map(|i| format!("{} {} {} {}", u[i], v[i], n[i], c[i])).collect();
                let _ = writeln!(
                    out,
                    "<shape type=\"rectangle\"><transform name=\"to_world\">\
                     <matrix value=\"{} 0 0 0 1\"/></transform>{tail}",
                    rows.join(" ")
                );
            }
            _ => {
                let Some(c) = polygon_of(light) else {
                    return refuse("a light that is no polygon and no sphere");
                };
                let fan: Vec<_> = (1..c.len() - 1).map(|i| [c[0], c[i], c[i + 1]]).collect();
                let name = format!("light{number}.ply");
                ply(&folder.join(&name), &fan)?;
                let _ = writeln!(
                    out,
                    "<shape type=\"ply\"><string name=\"filename\" value=\"{name}\"/>{tail}"
                );
            }
        }
    }
    Ok(())
}

fn emitter(model: &Model, index: usize) -> String {
    let m = &model.materials[index];
    if m.kind != MaterialKind::Light {
        return String::new();
    }
    format!("<emitter type=\"area\">{}</emitter>", rgb("radiance", m.emission))
}

/// A binary PLY of separate triangles.
fn ply(path: &Path, triangles: &[[DVec3; 3]]) -> io::Result<()> {
    let mut out = io::BufWriter::new(fs::File::create(path)?);
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float \
         y\nproperty float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        triangles.len() * 3,
        triangles.len()
    )?;
    for corner in triangles.iter().flatten() {
        for x in corner.as_vec3().to_array() {
            out.write_all(&x.to_le_bytes())?;
        }
    }
    for i in 0..triangles.len() as u32 {
        out.write_all(&[3])?;
        for corner in [3 * i, 3 * i + 1, 3 * i + 2] {
            out.write_all(&corner.to_le_bytes())?;
        }
    }
    out.flush()
}

fn refuse<T>(what: &str) -> io::Result<T> {
    Err(io::Error::new(io::ErrorKind::InvalidInput, format!("not for Mitsuba: {what}")))
}

fn rgb(name: &str, v: DVec3) -> String {
    format!("<rgb name=\"{name}\" value=\"{}\"/>", list(v))
}

fn list(v: DVec3) -> String {
    format!("{}, {}, {}", v.x, v.y, v.z)
}

fn xyz(v: DVec3) -> String {
    format!("x=\"{}\" y=\"{}\" z=\"{}\"", v.x, v.y, v.z)
}
