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
    let model = load(&format!(
        "{CORNERS}vt 0 0\nvt 1 0\nvt 0 1 0\nf 1 2 3\nf -4/1 -2/2 -1/3\nv 0 0 5\nf 1//  2 -1\n"
    ));
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
    let (m, model) = material("Kd .9 .9 .9\nKs .4 .4 .4\nmap_Kd brick.png");
    assert_eq!(m.diffuse, DVec3::splat(0.6));
    assert_eq!(notes(&model).len(), 2);
}

#[test]
fn what_is_not_read_of_a_material_or_is_beyond_its_range_is_noted() {
    for (lines, note) in [
        ("Pr .3\nPm 1\nKa 0 0 0", ("a statement about a material that is not read: left out", 2)),
        ("Kd 2 .5 .5", ("a share of light above 1 (Kd, Ks, Tf, d or Tr): taken as 1", 1)),
        ("d 5", ("a share of light above 1 (Kd, Ks, Tf, d or Tr): taken as 1", 1)),
        ("Tr 1.5", ("a share of light above 1 (Kd, Ks, Tf, d or Tr): taken as 1", 1)),
        ("illum 99", ("an illumination model above 10: taken as 2", 1)),
        ("Ka 1 1 1", ("an ambient colour (Ka): left out, all light comes from lights", 1)),
        ("Kd 1 1 1 9\nNs 3 x", ("words behind all that a statement takes: left out", 2)),
        ("d .5\nTr .1", ("`d` and `Tr` of a material that do not add up to 1: `d` counts", 1)),
        ("d -halo .5", ("`d -halo` (more clear where seen face on): as clear from all sides", 1)),
        ("Kd .5 .5 .5\nillum 5", ("the diffuse colour (Kd) of a mirror (illum 5): left out", 1)),
        ("xyz 1 1 1", ("a statement about a material that is not read: left out", 1)),
        ("Kd xyz 1 1 1", ("a colour by spectrum or CIE xyz: left out", 1)),
    ] {
        let (_, model) = material(lines);
        assert_eq!(notes(&model), [note], "{lines}");
    }
    let (_, model) = material("map_Kd -s 1 1 1 a.png\nbump b.png\nPr 1\nPm 1");
    let told: Vec<_> = model.notes.iter().map(ToString::to_string).collect();
    assert!(
        told[0].ends_with("plain colour is used: `map_Kd`, `bump` (2 times in all)"),
        "{told:?}"
    );
    assert!(told[1].ends_with("m.mtl:5: a statement about a material that is not read: left out: `Pr`, `Pm` (2 times in all)"), "{told:?}");
}

#[test]
fn a_dissolved_surface_keeps_its_colour_and_lets_the_rest_straight_through() {
    for lines in ["Kd .8 .4 .2\nd .25\nTf 1 .5 0", "Kd .8 .4 .2\nTr .75\nNi 1.45\nTf 1 .5 0"] {
        let (m, model) = material(lines);
        assert_eq!(m.kind, MaterialKind::Opaque, "{lines}");
        assert_eq!((m.diffuse, m.specular), (dvec3(0.2, 0.1, 0.05), DVec3::ZERO));
        assert_eq!((m.transmit, m.transmit_specular), (dvec3(0.75, 0.375, 0.0), 1.0));
        // Else shadow rays would stop at it.
        assert_eq!(m.roughness, 0.0);
        assert!(notes(&model).is_empty());
    }
    // A mirror stays one in part, a highlight would be a mirror.
    let (m, model) = material("illum 5\nKs .8 .8 .8\nd .5");
    assert_eq!((m.kind, m.specular, m.roughness), (MaterialKind::Opaque, DVec3::splat(0.4), 0.0));
    assert_eq!((m.diffuse, m.transmit), (DVec3::ZERO, DVec3::splat(0.5)));
    assert!(notes(&model).is_empty());
    let (m, model) = material("Kd .4 .4 .4\nKs .5 .5 .5\nNs 50\nd .5");
    assert_eq!((m.diffuse, m.specular), (DVec3::splat(0.2), DVec3::ZERO));
    assert!(notes(&model)[0].0.starts_with("the highlight (Ks)"), "{:?}", notes(&model));
    // Nothing is made: what is reflected and let through is at most all.
    let (m, _) = material("Kd 1 1 1\nKs 1 1 1\nd .3");
    assert!((m.diffuse + m.specular + m.transmit).max_element() <= 1.0);
}

#[test]
fn illumination_models_of_glass_make_glass() {
    for illum in [4, 6, 7, 9] {
        let (m, model) = material(&format!("illum {illum}\nNi 1.33"));
        assert_eq!((m.kind, m.ior), (MaterialKind::Dielectric, 1.33), "{illum}");
        assert!(notes(&model).is_empty());
        let (m, _) = material(&format!("illum {illum}\nTf .5 1 1"));
        assert_eq!((m.kind, m.transmit), (MaterialKind::Glass, dvec3(0.5, 1.0, 1.0)), "{illum}");
    }
    let (m, _) = material("illum 4\nTf .5 1 1\nd .5");
    assert_eq!((m.kind, m.transmit), (MaterialKind::Glass, dvec3(0.25, 0.5, 0.5)));
    let (m, model) = material("illum 7\nNi 1.5\nKd .5 .5 .5\nTf .9 1 1");
    assert_eq!(m.kind, MaterialKind::Dielectric);
    assert_eq!(
        notes(&model),
        [
            ("the diffuse colour (Kd) of glass (illum 4, 6, 7 or 9): left out", 1),
            ("a filter (Tf or d) of glass that refracts: left out, it is clear", 1),
        ]
    );
}

#[test]
fn emission_makes_a_light() {
    let (m, model) = material("Ke 5 4 3");
    assert_eq!((m.kind, m.emission), (MaterialKind::Light, dvec3(5.0, 4.0, 3.0)));
    let [light] = model.lights[..] else { panic!() };
    assert_eq!((light.kind, light.radiance), (LightKind::Parallelogram, m.emission));
    assert!(notes(&model).is_empty());
    for lost in ["Kd .8 .8 .8", "Kd 0 0 0\nKs .1 0 0", "d .5", "illum 7"] {
        let (m, model) = material(&format!("Ke 5 4 3\n{lost}"));
        assert_eq!((m.kind, m.diffuse), (MaterialKind::Light, DVec3::ZERO), "{lost}");
        let note = "what a material that emits (Ke) reflects or lets through (Kd, Ks, d): left out";
        assert_eq!(notes(&model), [(note, 1)], "{lost}");
    }
}

#[test]
fn an_index_of_refraction_without_sense_is_not_used() {
    for ni in ["0", "0.001", "1e29"] {
        let (m, model) = material(&format!("illum 6\nNi {ni}"));
        let note = "an index of refraction (Ni) that is not from 0.01 to 100: taken as not given";
        assert_eq!((m.kind, m.ior), (MaterialKind::Glass, 1.5), "{ni}");
        assert_eq!(notes(&model), [(note, 1)], "{ni}");
    }
    let (m, model) = material("illum 6\nNi 1.7");
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
    assert_eq!(told[1], ("points or lines: left out", 2));
    assert_eq!((told.len(), told[2].1), (4, 1));
}

#[test]
fn what_is_lost_of_a_mesh_is_counted_with_its_first_line() {
    let model = load(
        "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 1 .5 .5 .5\nv 0 1 0\nvn 0 0 1\nvn 0 0 1 7\n\
         f 1 2 3\ns 1\nf 1 2 3\nf 1 3 4\nf 1//1 2//1 3//1\nf 1//1 2 3\ns off\nf 1 2 3\ns 0\n\
         f 1 2 3\nusemap x\nbevel on\nv 1 2 3 4 5\n",
    );
    let told: Vec<_> =
        model.notes.iter().map(|n| (n.text.as_str(), n.count, n.first.line)).collect();
    let [color, _, grey, smooth, half, attribute] = told[..] else { panic!("{told:?}") };
    assert_eq!(
        color,
        (
            "a colour of a vertex (numbers 4 to 6 of `v`): left out, the colour is the material's",
            3,
            1
        )
    );
    assert_eq!(told[1], ("words behind all that a statement takes: left out", 2, 6));
    assert!(grey.0.starts_with("faces without a material"));
    assert_eq!((smooth.1, smooth.2), (2, 9), "{smooth:?}");
    assert!(smooth.0.starts_with("a face of a smoothing group"));
    assert_eq!(half, ("a face of which only some corners name a normal: flat", 1, 12));
    assert_eq!(attribute, ("an attribute of faces that is not read: left out", 2, 17));
    assert_eq!(model.vertices[2], dvec3(1.0, 1.0, 0.0));
}

#[test]
fn comments_line_ends_and_a_byte_order_mark_change_nothing() {
    let plain = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
    let mtl = "newmtl a\nKd .1 .2 .3\n";
    let bare = "# C:\\scenes\\\n#";
    let commented = "mtllib m.mtl # the paint\nv 0 0 0 # one\nv 1 0 0 #two\nv 0 1 0\t# 3\n\
                     # C:\\scenes\\\nusemtl a # red\nf 1 2 3 # tri\n";
    let mtl_commented = format!("{bare}\nnewmtl a # paint\nKd .1 .2 \\\n.3 # grey\nNs 3 # 4\n");
    let ends = |text: &str, end: &str| text.replace('\n', end);
    let mut cases = vec![(plain.to_owned(), mtl.to_owned()), (commented.to_owned(), mtl_commented)];
    for end in ["\r\n", "\r"] {
        cases.push((ends(commented, end), ends(mtl, end)));
    }
    cases.push((format!("\u{feff}{plain}"), format!("\u{feff}{mtl}")));
    for (obj, mtl) in cases {
        let model = Files::new(&[("a.obj", &obj), ("m.mtl", &mtl)]).load("a.obj").unwrap();
        let [triangle] = model.triangles[..] else { panic!("{obj:?}") };
        assert_eq!(triangle.vertices, [0, 1, 2], "{obj:?}");
        assert_eq!(model.materials[0].diffuse, dvec3(0.1, 0.2, 0.3), "{obj:?}");
        assert!(notes(&model).is_empty(), "{obj:?}: {:?}", notes(&model));
    }
    // Lines count where carriage returns alone end them.
    let files = Files::new(&[("a.obj", "v 0 0 0\r\rv 0 0 x\r")]);
    assert!(files.error("a.obj").starts_with("a.obj:3: "), "{}", files.error("a.obj"));
}

#[test]
fn a_mtllib_names_one_file_or_several() {
    let one = "newmtl a\nKd .1 .1 .1\nnewmtl b\nKd .2 .2 .2\n";
    let two = "newmtl b\nKd .3 .3 .3\nnewmtl #c d\nKd .4 .4 .4\n";
    let grey = |list: &str| {
        let obj = format!(
            "mtllib {list}\n{CORNERS}usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl #c d\nf 1 2 3\n"
        );
        let names = [("a.obj", &obj[..]), ("x y.mtl", one), ("z.MTL", two), ("x", one), ("z", two)];
        let model = Files::new(&names).load("a.obj").unwrap();
        let grey =
            model.triangles.iter().map(|t| model.materials[usize::from(t.material)].diffuse.x);
        (grey.collect::<Vec<_>>(), model.notes.len())
    };
    assert_eq!(grey("x y.mtl z.MTL"), (vec![0.1, 0.2, 0.4], 0), "the first file counts");
    assert_eq!(grey("z.MTL x y.mtl"), (vec![0.1, 0.3, 0.4], 0));
    assert_eq!(grey("x z"), (vec![0.1, 0.2, 0.4], 0));
    assert_eq!(grey("x y.mtl"), (vec![0.1, 0.2, 0.5], 1));
    assert_eq!(grey("no.mtl x no"), (vec![0.1, 0.2, 0.5], 2));
}

#[test]
fn a_mtllib_that_is_named_again_counts_again() {
    let obj = format!(
        "{CORNERS}mtllib a.mtl\nusemtl m\nf 1 2 3\nmtllib b.mtl\nusemtl m\nf 1 2 3\nmtllib a.mtl\nusemtl m\nf 1 2 3\n"
    );
    let files = [
        ("x.obj", &obj[..]),
        ("a.mtl", "newmtl m\nKd .1 0 0\n"),
        ("b.mtl", "newmtl m\nKd .2 0 0\n"),
    ];
    let model = Files::new(&files).load("x.obj").unwrap();
    let used: Vec<_> = model.triangles.iter().map(|t| t.material).collect();
    assert_eq!((used, model.materials.len()), (vec![0, 1, 0], 2));
}

#[test]
fn a_material_may_be_defined_behind_its_use() {
    let one = "newmtl a\nKd .1 .1 .1\n";
    let two = "newmtl a\nKd .2 .2 .2\nnewmtl b\nKd .3 .3 .3\n";
    let obj = format!(
        "{CORNERS}usemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\nmtllib one.mtl\nusemtl a\n\
         f 1 2 3\nmtllib two.mtl\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n"
    );
    let files = [("a.obj", &obj[..]), ("one.mtl", one), ("two.mtl", two)];
    let model = Files::new(&files).load("a.obj").unwrap();
    let grey: Vec<_> = model
        .triangles
        .iter()
        .map(|t| model.materials[usize::from(t.material)].diffuse.x)
        .collect();
    // What was defined last before its use, else the first behind it.
    assert_eq!(grey, [0.1, 0.3, 0.5, 0.1, 0.2, 0.3]);
    assert_eq!(model.materials.len(), 4, "what was found early is not entered twice");
    assert_eq!(notes(&model), [("a material is not defined: grey instead", 1)]);
    let bad = Files::new(&[("a.obj", &obj), ("one.mtl", "newmtl x\nKd\n")]).error("a.obj");
    assert_eq!(bad, "one.mtl:2: a colour needs one number or three (included at a.obj:11)");
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
        (
            "#\nnewmtl a\nKd 1 1 1\nKe 1e35 0 0\nd 1\n",
            "m.mtl:2: material `a`: a value is no number",
        ),
        ("newmtl a\nKa 1 x 1\n", "m.mtl:2: `x` is not a number"),
    ] {
        let obj = format!("{CORNERS}mtllib m.mtl\nf 1 2 3\n");
        let files = Files::new(&[("a.obj", &obj), ("m.mtl", mtl)]);
        let line = files.error("a.obj");
        assert!(line.contains(says), "{mtl}: {line}");
        assert!(line.ends_with("(included at a.obj:5)"), "{line}");
    }
}
