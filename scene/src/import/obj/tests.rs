use glam::{DVec3, dvec3};
use kiloray_core::scene::{LightKind, MaterialKind};

use crate::import::tests::{Files, notes};
use crate::model::{Material, Model, NO_NORMAL};

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn load(text: &str) -> Model {
    Files::new(&[("a.obj", text)]).load("a.obj").unwrap()
}

/// The material of a square, from the lines of a `.mtl` file.
fn material(lines: &str) -> (Material, Model) {
    let obj = format!("mtllib m.mtl\n{CORNERS}usemtl my paint\nf 1 2 3 4\n");
    let mtl = format!("# paint\nnewmtl my paint\n{lines}\n");
    let model = Files::new(&[("a.obj", &obj), ("m.mtl", &mtl)]).load("a.obj").unwrap();
    (model.materials[0].clone(), model)
}

#[test]
fn faces_name_vertices_from_both_ends() {
    let model = load(&format!("{CORNERS}f 1 2 3\nf -4/1 -2/2 -1/3\nv 0 0 5\nf 1//  2 -1\n"));
    let found: Vec<_> = model.triangles.iter().map(|t| t.vertices).collect();
    assert_eq!(found, [[0, 1, 2], [0, 2, 3], [0, 1, 4]]);
    assert_eq!(model.vertices.len(), 5, "a mesh shares its vertices");
}

#[test]
fn polygons_are_cut_and_keep_their_winding() {
    let model = load("v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nf 1 2 3 4\nf 4 3 2 1\n");
    assert_eq!(model.triangles.len(), 4);
    let cross = |t: &crate::model::Triangle| {
        let [a, b, c] = t.vertices.map(|i| model.vertices[i as usize]);
        (b - a).cross(c - a).z
    };
    let areas: Vec<f64> = model.triangles.iter().map(cross).collect();
    assert_eq!(areas[0] + areas[1], 8.0);
    assert!(areas[..2].iter().all(|a| *a > 0.0) && areas[2..].iter().all(|a| *a < 0.0));
}

#[test]
fn normals_are_kept_where_all_corners_have_one() {
    let model = load(&format!(
        "{CORNERS}vn 0 0 2\nvn 0 1 1\nvn 0 0 0\n\
         f 1//1 2//2 3//1\nf 1//1 2 3//1\nf 1//1 2//3 3//1\nf 1//-3 2//-2 3//1 4//1\n"
    ));
    let has: Vec<bool> = model.triangles.iter().map(|t| !t.normals.contains(&NO_NORMAL)).collect();
    assert_eq!(has, [true, false, false, true, true]);
    let [a, b, _] = model.triangles[0].normals.map(|i| model.normals[i as usize]);
    assert_eq!(a, DVec3::Z);
    assert!((b - dvec3(0.0, 0.5f64.sqrt(), 0.5f64.sqrt())).length() < 1e-15);
    assert_eq!(notes(&model)[0], ("a shading normal without direction: not used", 1));
}

#[test]
fn materials_become_ours() {
    let (m, _) = material("Kd .2 .3 .4\nKs .5 .5 .5\nNs 98\nillum 2");
    assert_eq!((m.kind, m.name.as_str()), (MaterialKind::Opaque, "my paint"));
    assert_eq!((m.diffuse, m.specular), (dvec3(0.2, 0.3, 0.4), DVec3::splat(0.5)));
    assert!((m.roughness - 0.02f64.sqrt()).abs() < 1e-15);
    let (m, _) = material("Kd .2 .3 .4\nKs .5 .5 .5\nillum 1");
    assert_eq!(m.specular, DVec3::ZERO, "model 1 has no highlight");
    let (m, _) = material("Kd 0 0 0\nKs .9 .8 .7\nillum 3");
    assert_eq!((m.kind, m.specular), (MaterialKind::Mirror, dvec3(0.9, 0.8, 0.7)));
    let (m, _) = material("Ni 1.33\nd .1");
    assert_eq!((m.kind, m.ior), (MaterialKind::Dielectric, 1.33));
    let (m, _) = material("Tr .5\nTf .5 1 1");
    assert_eq!((m.kind, m.transmit), (MaterialKind::Glass, dvec3(0.25, 0.5, 0.5)));
    let (m, _) = material("Kd .25\nd -halo .5");
    assert_eq!((m.kind, m.transmit), (MaterialKind::Glass, DVec3::splat(0.5)));
    let (m, model) = material("Kd .9 .9 .9\nKs .4 .4 .4\nmap_Kd brick.png");
    assert_eq!(m.diffuse, DVec3::splat(0.6));
    assert_eq!(notes(&model).len(), 2);
}

#[test]
fn what_is_not_read_of_a_material_or_is_beyond_its_range_is_noted() {
    for (lines, note) in [
        ("Pr .3\nPm 1\nKa 1 1 1", ("a statement about a material that is not read: left out", 2)),
        ("Kd 2 .5 .5", ("a share of light above 1 (Kd, Ks, Tf or d): taken as 1", 1)),
        ("d 5", ("a share of light above 1 (Kd, Ks, Tf or d): taken as 1", 1)),
        ("illum 99", ("an illumination model above 10: taken as 2", 1)),
    ] {
        let (_, model) = material(lines);
        assert_eq!(notes(&model), [note], "{lines}");
    }
}

#[test]
fn emission_makes_a_light() {
    let (m, model) = material("Ke 5 4 3");
    assert_eq!((m.kind, m.emission), (MaterialKind::Light, dvec3(5.0, 4.0, 3.0)));
    let [light] = model.lights[..] else { panic!() };
    assert_eq!((light.kind, light.radiance), (LightKind::Parallelogram, m.emission));
}

#[test]
fn an_index_of_refraction_without_sense_is_not_used() {
    for ni in ["0", "0.001", "1e29"] {
        let (m, model) = material(&format!("d .5\nNi {ni}"));
        let note = "an index of refraction (Ni) that is not from 0.01 to 100: taken as not given";
        assert_eq!((m.kind, m.ior), (MaterialKind::Glass, 1.5), "{ni}");
        assert_eq!(notes(&model), [(note, 1)], "{ni}");
    }
    let (m, model) = material("d .5\nNi 1.7");
    assert_eq!((m.kind, m.ior), (MaterialKind::Dielectric, 1.7));
    assert!(notes(&model).is_empty());
}

#[test]
fn what_is_missing_is_grey_and_noted_once() {
    let text = format!("mtllib no.mtl\n{CORNERS}usemtl x\nf 1 2 3\nusemtl x\nf 1 3 4\n");
    let model = load(&text);
    assert_eq!(model.materials.len(), 1);
    assert_eq!(model.materials[0].diffuse, DVec3::splat(0.5));
    assert_eq!(
        notes(&model),
        [
            ("a file of materials is missing: grey instead", 1),
            ("a material is not defined: grey instead", 2),
        ]
    );
    let told: Vec<_> = model.notes.iter().map(ToString::to_string).collect();
    assert!(told[0].ends_with("a.obj:1: a file of materials is missing: grey instead: `no.mtl`"));
    // However many there are, one note.
    let missing = (0..500).map(|i| format!("usemtl m{i}\nf 1 2 3\n")).collect::<String>();
    let many = load(&format!("{CORNERS}{missing}"));
    assert_eq!(notes(&many), [("a material is not defined: grey instead", 500)]);
    let told = many.notes.iter().next().unwrap().to_string();
    let names = "grey instead: `m0`, `m1`, `m2`, `m3`, and others (500 times in all)";
    assert!(told.ends_with(names), "{told}");
    let plain = load(&format!("{CORNERS}f 1 2 3\nf 1 3 4\n"));
    assert_eq!(notes(&plain), [("faces without a material: grey, diffuse", 1)]);
}

#[test]
fn lines_join_and_odd_statements_are_left_out() {
    let model = load(
        "o box\r\ng a b\r\ns off\r\nv 0 0 0 1 0 0\r\nv 2 0 0 2\r\nv \\\r\n 1 1 0\r\n\
         vt 0 0\r\nl 1 2\r\np 1\r\ncurv 0 1 1 2\r\nf 1 2 \\\r\n3\r\n",
    );
    assert_eq!(model.triangles.len(), 1);
    assert_eq!(model.vertices, [DVec3::ZERO, DVec3::X, dvec3(1.0, 1.0, 0.0)]);
    let told = notes(&model);
    assert_eq!(told[0], ("points or lines: left out", 2));
    assert_eq!(told[1].1, 1);
}

#[test]
fn errors_of_a_material_file_name_its_line() {
    for (mtl, says) in [
        ("newmtl a\nKd 1 x 1\n", "m.mtl:2: `x` is not a number"),
        ("newmtl b\nKd 1 1 1\nnewmtl a\nNs nan\n", "m.mtl:4: `nan` is not a finite"),
        ("newmtl a\nKd -1 0 0\n", "m.mtl:2: `-1` is below zero"),
        ("newmtl a\nKs 1 1e999 0\n", "m.mtl:2: `1e999` is not a finite"),
        ("newmtl a\nKs\n", "m.mtl:2: a colour needs"),
        ("newmtl a\nNs\n", "m.mtl:2: a number is missing"),
        ("newmtl \n", "m.mtl:1: newmtl without a name"),
    ] {
        let obj = format!("{CORNERS}mtllib m.mtl\nf 1 2 3\n");
        let files = Files::new(&[("a.obj", &obj), ("m.mtl", mtl)]);
        let line = files.error("a.obj");
        assert!(line.contains(says), "{mtl}: {line}");
        assert!(line.ends_with("(included at a.obj:5)"), "{line}");
    }
}
