//! `export SCENE FOLDER`: a built-in scene for Kiloray, Radiance and Mitsuba alike, reduced to what
//! they agree on: `scene.rad`, `scene.vf`, `scene.xml` and its meshes.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use kiloray_core::scene::MaterialKind;
use kiloray_tests::export;

/// A built-in scene for Kiloray, Radiance and Mitsuba alike.
#[derive(Parser)]
struct Arguments {
    /// A built-in scene.
    scene: String,
    /// Gets the files.
    folder: PathBuf,
}

fn main() -> ExitCode {
    let Arguments { scene, folder } = Arguments::parse();
    match run(&scene, &folder) {
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
