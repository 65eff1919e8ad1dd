use std::collections::BTreeSet;

use glam::DVec3;

use super::{shape::Shaper, *};
use crate::model::{Model, NO_NORMAL};

/// Every scene in its least size and in a small one.
fn small() -> Vec<(String, Model)> {
    let mut names = Vec::new();
    for entry in list() {
        match entry.size {
            None => names.push(entry.name.to_owned()),
            Some(Size { min, .. }) => {
                names.push(format!("{}:{min}", entry.name));
                names.push(format!("{}:{}", entry.name, min + 5));
            }
        }
    }
    names.into_iter().map(|name| (name.clone(), build(&name).unwrap())).collect()
}

#[test]
fn the_catalogue_counts_what_is_built() {
    for (name, model) in small() {
        let (entry, size) = find(&name).unwrap();
        let built = (model.triangles.len() + model.spheres.len()) as u64;
        assert_eq!(entry.surfaces(size), built, "{name}");
    }
}

#[test]
fn every_scene_is_sound() {
    for (name, model) in small() {
        assert!(!model.lights.is_empty() && model.views.len() == 1, "{name}");
        let named: BTreeSet<_> = model.materials.iter().map(|m| &m.name).collect();
        assert_eq!(named.len(), model.materials.len(), "{name}: materials share a name");
        assert!(model.vertices.iter().chain(&model.normals).all(|v| v.is_finite()), "{name}");
        assert!(model.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-12), "{name}");
        for triangle in &model.triangles {
            assert!(usize::from(triangle.material) < model.materials.len(), "{name}");
            let [a, b, c] = triangle.vertices.map(|i| model.vertices[i as usize]);
            let normal = (b - a).cross(c - a);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            assert!(normal.length() > 1e-6 * longest * longest, "{name}: a flat triangle");
            for index in triangle.normals.into_iter().filter(|&i| i != NO_NORMAL) {
                let shading = model.normals[index as usize];
                assert!(shading.dot(normal) > 0.0, "{name}: a normal on the wrong side");
            }
        }
    }
}

/// Of closed shapes the volume by the divergence theorem is positive if fronts face outward.
#[test]
fn solids_face_outward() {
    type Make = fn(&mut Shaper);
    let solids: [(&str, Make, f64); 6] = [
        ("cuboid", |s| s.cuboid(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0), 0), 6.0),
        ("ball", |s| s.ball(1.0, 64, 0), 4.0 / 3.0 * core::f64::consts::PI),
        ("torus", |s| s.torus(2.0, 0.5, [64, 64], 0), core::f64::consts::PI.powi(2)),
        ("post", |s| s.post(1.0, [1.0, 3.0], 64, 0), core::f64::consts::TAU),
        (
            "rod",
            |s| s.rod(DVec3::ONE, DVec3::new(1.0, 1.0, 3.0), 1.0, 64, 0),
            core::f64::consts::TAU,
        ),
        ("plate", |s| s.plate([1.0, 2.0], 0.01, [0.0, 1.0], 0), 8.0),
    ];
    for (name, make, expected) in solids {
        let mut shaper = Shaper::default();
        make(&mut shaper);
        let volume = volume(&shaper.finish());
        assert!((volume / expected - 1.0).abs() < 0.01, "{name}: {volume}, not {expected}");
    }
}

fn volume(model: &Model) -> f64 {
    let part = |t: &crate::model::Triangle| {
        let [a, b, c] = t.vertices.map(|i| model.vertices[i as usize]);
        a.dot(b.cross(c)) / 6.0
    };
    model.triangles.iter().map(part).sum()
}

#[test]
fn the_furnace_is_convex() {
    let model = build("furnace:2").unwrap();
    for triangle in &model.triangles {
        let [a, b, c] = triangle.vertices.map(|i| model.vertices[i as usize]);
        let normal = (b - a).cross(c - a);
        assert!(model.vertices.iter().all(|v| (*v - a).dot(normal) < 1e-12));
    }
}

#[test]
fn the_cornell_box_faces_inward_and_its_blocks_outward() {
    let mut model = build("cornell").unwrap();
    let blocks: Vec<_> = model.triangles.drain(16..36).collect();
    let centre = DVec3::new(-2.78, 2.8, 2.7);
    for triangle in &model.triangles {
        let [a, b, c] = triangle.vertices.map(|i| model.vertices[i as usize]);
        assert!((b - a).cross(c - a).dot(centre - a) > 0.0);
    }
    // The missing bottoms lie in the plane z = 0 and have no part in the sum. By the data sheet
    // the bases (shoelace formula) times the heights are 4.5594 and 9.1167.
    model.triangles = blocks;
    assert!((volume(&model) - 13.6762).abs() < 1e-3, "{}", volume(&model));
}

#[test]
fn scenes_are_the_same_each_time() {
    let (a, b) = (build("studio:30").unwrap(), build("studio:30").unwrap());
    assert_eq!(a.vertices, b.vertices);
}

#[test]
fn absurd_sizes_are_refused_with_the_greatest() {
    for name in ["sinc:0", "sinc:99999", "sinc:-3", "sinc:+3", "sinc:x", "sinc:", "sinc:4294967299"]
    {
        let message = build(name).unwrap_err().to_string();
        assert!(message.contains("2 to 2236"), "{message}");
    }
    assert!(build("cornell:3").unwrap_err().to_string().contains("one size"));
    let message = build("teapot").unwrap_err().to_string();
    for entry in list() {
        assert!(message.contains(entry.name));
    }
}

#[test]
fn the_greatest_sizes_have_about_ten_million_surfaces() {
    for entry in list() {
        if let Some(Size { default, max, .. }) = entry.size {
            assert!((10..1_000_000).contains(&entry.surfaces(default)), "{}", entry.name);
            let most = entry.surfaces(max);
            assert!((2_000_000..16_000_000).contains(&most), "{}: {most}", entry.name);
        }
    }
}
