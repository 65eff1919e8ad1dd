use glam::DVec3;
use kiloray_core::scene::MaterialKind;
use kiloray_scene::model::Model;

/// Reduces the materials to what Kiloray, Radiance and Mitsuba mean alike; returns what it changed.
///
/// Glossy lobes are dropped (each renderer has its own), as are smooth normals and light from afar;
/// panes and dielectrics become clear.
pub fn common(model: &mut Model) -> Vec<String> {
    let mut changed = Vec::new();
    let lights = model.lights.len();
    model.lights.retain(|light| light.material.is_some());
    if model.lights.len() < lights {
        changed.push(format!("without {} distant or point lights", lights - model.lights.len()));
    }
    for material in &mut model.materials {
        let mut note = |what: &str| changed.push(format!("{}: {what}", material.name));
        match material.kind {
            MaterialKind::Opaque => {
                if material.specular != DVec3::ZERO {
                    note("without its glossy lobe");
                    if material.diffuse == DVec3::ZERO {
                        material.diffuse = material.specular;
                    }
                    material.specular = DVec3::ZERO;
                    material.roughness = 0.0;
                }
                if material.transmit != DVec3::ZERO {
                    note("opaque");
                    material.transmit = DVec3::ZERO;
                    material.transmit_specular = 0.0;
                }
            }
            MaterialKind::Dielectric if material.absorption != DVec3::ZERO => {
                note("clear");
                material.absorption = DVec3::ZERO;
            }
            MaterialKind::Glass if material.transmit != DVec3::ONE => {
                note("clear");
                material.transmit = DVec3::ONE;
            }
            _ => {}
        }
    }
    for triangle in &mut model.triangles {
        triangle.normals = [kiloray_scene::model::NO_NORMAL; 3];
    }
    changed
}
