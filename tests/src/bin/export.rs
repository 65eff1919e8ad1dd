//! `export SCENE FOLDER`: a built-in scene for Kiloray, Radiance and Mitsuba alike, reduced to what
//! they agree on: `scene.rad`, `scene.vf`, `scene.xml` and its meshes.

use std::path::Path;
use std::process::ExitCode;
use std::{env, fs};

use kiloray_core::scene::MaterialKind;
use kiloray_tests::export;

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [scene, folder] = arguments.as_slice() else {
        eprintln!("usage: export SCENE FOLDER");
        return ExitCode::from(2);
    };
    match run(scene, Path::new(folder)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("export: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(scene: &str, folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut model = kiloray_scene::builtin::build(scene)?;
    for note in export::common(&mut model) {
        eprintln!("{scene}: {note}");
    }
    let view = model.views.first().ok_or("the scene has no view")?;
    fs::create_dir_all(folder)?;
    fs::write(folder.join("scene.rad"), export::radiance(&model)?)?;
    fs::write(folder.join("scene.vf"), export::view_file(view))?;
    export::mitsuba(&model, view, folder)?;
    let specular = model.materials.iter().any(|m| {
        matches!(m.kind, MaterialKind::Mirror | MaterialKind::Dielectric | MaterialKind::Glass)
    });
    println!(
        "{{\"triangles\": {}, \"spheres\": {}, \"lights\": {}, \"specular\": {specular}, \
         \"aspect\": {}}}",
        model.triangles.len(),
        model.spheres.len(),
        model.lights.len(),
        (view.size[0].to_radians() / 2.0).tan() / (view.size[1].to_radians() / 2.0).tan()
    );
    Ok(())
}
