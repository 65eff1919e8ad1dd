//! Golden values are of Radiance's own programs (as of pyradiance 1.3), by the command that stands
//! with them.

use glam::{DVec3, dvec3};
use kiloray_core::scene::{LightKind, MaterialKind};

use crate::import::tests::{Files, notes};
use crate::model::{Emitter, Model};

const GREY: &str = "void plastic m 0 0 5 .5 .5 .5 0 0\n";

fn load(text: &str) -> Model {
    Files::new(&[("a.rad", text)]).load("a.rad").unwrap()
}

fn corners(model: &Model) -> Vec<[DVec3; 3]> {
    model.triangles.iter().map(|t| t.vertices.map(|i| model.vertices[i as usize])).collect()
}

fn assert_near(found: DVec3, expected: [f64; 3]) {
    assert!((found - DVec3::from(expected)).length() < 1e-11, "{found} {expected:?}");
}

/// `xform OPTIONS p.rad`
#[test]
fn xform_places_as_radiance() {
    let p = format!("{GREY}m sphere s 0 0 4 1 2 3 .5\nm polygon p 0 0 9 0 0 0 1 0 0 0 2 0\n");
    type Golden = (&'static str, [f64; 3], f64, bool, [[f64; 3]; 3]);
    let golden: [Golden; 6] = [
        (
            "-rx 30 -ry 40 -rz 50 -t 1 2 3",
            [2.80128106192, 4.50769014719, 5.11349867794],
            0.5,
            false,
            [
                [1.0, 2.0, 3.0],
                [1.49240387651, 2.58682408883, 2.35721239031],
                [0.0863480148287, 3.60574467496, 3.76604444312],
            ],
        ),
        (
            "-t 1 2 3 -s 2 -rz 90 -my",
            [-8.0, -4.0, 12.0],
            1.0,
            false,
            [[-8.0, -2.0, 6.0], [-4.0, -4.0, 6.0], [-4.0, -2.0, 6.0]],
        ),
        (
            "-mx -rx 90 -s .5",
            [-0.5, -1.5, 1.0],
            0.25,
            false,
            [[0.0, 0.0, 1.0], [-0.5, 0.0, 0.0], [0.0, 0.0, 0.0]],
        ),
        (
            "-i 3 -t 1 0 0 -i 2 -rz 45",
            [-2.0, 4.0, 3.0],
            0.5,
            false,
            [[0.0, 3.0, 0.0], [0.0, 4.0, 0.0], [-2.0, 3.0, 0.0]],
        ),
        (
            "-n x -s -2 -t 1 1 1",
            [-1.0, -3.0, -5.0],
            1.0,
            false,
            [[1.0, -3.0, 1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, 1.0]],
        ),
        (
            "-I -mz -ry 10",
            [0.463863220011, 2.0, -3.1280714367],
            0.5,
            true,
            [[0.0, 0.0, 0.0], [0.984807753012, 0.0, -0.173648177667], [0.0, 2.0, 0.0]],
        ),
    ];
    for (options, center, radius, inward, points) in golden {
        let all = format!("!xform {options} p.rad\n");
        let model = Files::new(&[("p.rad", &p), ("a.rad", &all)]).load("a.rad").unwrap();
        let [sphere] = model.spheres[..] else { panic!("{options}") };
        assert_near(sphere.center, center);
        assert_eq!((sphere.radius, sphere.inward), (radius, inward), "{options}");
        let [found] = corners(&model)[..] else { panic!("{options}") };
        for (found, expected) in found.into_iter().zip(points) {
            assert_near(found, expected);
        }
    }
}

/// `xform -rz 90 -a 2 -t 2 0 0 -a 3 -t 0 1.5 0 -i 1 -t 0 0 10 p.rad`, the sphere's centres.
#[test]
fn arrays_repeat_in_radiances_order() {
    let p = format!("{GREY}m sphere s 0 0 4 1 2 3 .5\n");
    let all = "!xform -rz 90 -a 2 -t 2 0 0 -a 3 -t 0 1.5 0 -i 1 -t 0 0 10 p.rad\n";
    let model = Files::new(&[("p.rad", &p), ("a.rad", all)]).load("a.rad").unwrap();
    let found: Vec<_> = model.spheres.iter().map(|s| s.center).collect();
    let expected = [
        [-2.0, 1.0, 13.0],
        [-2.0, 2.5, 13.0],
        [-2.0, 4.0, 13.0],
        [0.0, 1.0, 13.0],
        [0.0, 2.5, 13.0],
        [0.0, 4.0, 13.0],
    ];
    assert_eq!(found, expected.map(DVec3::from));
    assert_eq!(model.materials.len(), 1, "each copy defines the same material");
}

/// `xform pipe.rad`: number, sum, least and greatest of the vertices.
#[test]
fn pipes_pass_through_xform() {
    let model =
        load(&format!("{GREY}!genbox m b 1 2 3 | xform -t 1 0 0 -a 2 -rz 90 | xform -s 2\n"));
    assert_eq!((model.vertices.len(), model.triangles.len()), (48, 24));
    let sum: DVec3 = model.vertices.iter().sum();
    assert_near(sum, [24.0, 120.0, 144.0]);
    let lo = model.vertices.iter().copied().reduce(DVec3::min).unwrap();
    let hi = model.vertices.iter().copied().reduce(DVec3::max).unwrap();
    assert_near(lo, [-4.0, 0.0, 0.0]);
    assert_near(hi, [4.0, 4.0, 6.0]);
    let twice = load(&format!("{GREY}!genbox m a 1 1 1; genbox m b 2 2 2|xform -t 3 0 0 # ok\n"));
    assert_eq!(twice.triangles.len(), 24);
}

/// `genbox m b 1 2 3 [-b .1] [-i]`: number of vertices, and the sum of axis × coordinate².
#[test]
fn boxes_have_radiances_vertices_and_face_out_or_in() {
    for (options, vertices, squares, volume) in [
        ("", 24, 432.0, 6.0),
        ("-i", 24, 432.0, -6.0),
        // Less half a square of .1 along 21.6 of edges, and 5/6 of the cube at each corner.
        ("-b .1", 96, 1642.24, 6.0 - 0.108 - 0.02 / 3.0),
        ("-b .1 -i", 96, 1642.24, -6.0 + 0.108 + 0.02 / 3.0),
    ] {
        let model = load(&format!("{GREY}!genbox m b 1 2 3 {options}\n"));
        assert_eq!(model.vertices.len(), vertices, "{options}");
        let found: f64 = model.vertices.iter().map(|v| (*v * *v).dot(dvec3(1.0, 2.0, 3.0))).sum();
        assert!((found - squares).abs() < 1e-9, "{options}: {found}");
        let inside: f64 = corners(&model).iter().map(|[a, b, c]| a.dot(b.cross(*c)) / 6.0).sum();
        let close = 1e-12;
        assert!((inside - volume).abs() < close, "{options}: {inside}");
        let notes = notes(&model);
        assert!(notes.is_empty(), "{notes:?}");
    }
    let round = load(&format!("{GREY}!genbox m b 1 2 3 -r .1\n"));
    assert_eq!(round.spheres.len(), 8);
    assert_eq!(round.triangles.len(), 12 + 12 * 2 * crate::model::SIDES as usize);
}

/// A scene of all surfaces, plain, inverted and mirrored, and the rays that were traced:
/// `rtrace -h -ab 0 -ov front.oct`: whether a `glow` is seen, thus the front.
#[test]
fn fronts_are_those_of_radiance() {
    let front = "void glow g 0 0 4 1 1 1 0
g polygon a 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0
g ring b 0 0 8 3 .5 0 0 0 1 .2 .5
g ring c 0 0 8 5 .5 0 0 0 -1 0 .5
g cone d 0 0 8 7 .5 0 7 .5 1 .5 .2
g cup e 0 0 8 9 .5 0 9 .5 1 .5 .2
g cylinder f 0 0 7 11 .5 0 11 .5 1 .5
g tube h 0 0 7 13 .5 0 13 .5 1 .5
g sphere i 0 0 4 15 .5 .5 .5
g bubble j 0 0 4 17 .5 .5 .5
g sphere k 0 0 4 19 .5 .5 -.5
g cone l 0 0 8 21 .5 0 21 .5 1 -.5 -.2
";
    let all = "!xform front.rad
!xform -I -t 0 2 0 front.rad
!xform -my -t 0 5 0 front.rad
!xform -I -mz -t 0 6 1 front.rad
!xform -s -1 -rz 180 -t 0 8 1 front.rad
";
    let golden = "1010011001100110010101010110011001100110101010100110011001100101011010010110011001\
                  1010100101101001100110010101";
    let model = Files::new(&[("front.rad", front), ("a.rad", all)]).load("a.rad").unwrap();
    let mut found = String::new();
    for (row, thing) in (0..5).flat_map(|row| (0..11).map(move |thing| (row, thing))) {
        let y = 2.0 * f64::from(row) + 0.5;
        let x = if thing == 0 { 0.5 } else { f64::from(2 * thing + 1) };
        let rays = if thing < 3 {
            // From above and from below.
            [(dvec3(x + 0.3, y, 2.0), -DVec3::Z), (dvec3(x + 0.3, y, -2.0), DVec3::Z)]
        } else {
            // From outside and from inside.
            [(dvec3(x - 0.9, y + 0.05, 0.5), DVec3::X), (dvec3(x, y + 0.05, 0.5), DVec3::X)]
        };
        for (origin, direction) in rays {
            found.push(if sees_front(&model, origin, direction) { '1' } else { '0' });
        }
    }
    assert_eq!(found, golden);
}

/// The nearest surface along the ray shows its front.
fn sees_front(model: &Model, origin: DVec3, direction: DVec3) -> bool {
    let mut best = (f64::INFINITY, false);
    for [a, b, c] in corners(model) {
        let normal = (b - a).cross(c - a);
        let t = (a - origin).dot(normal) / direction.dot(normal);
        let p = origin + direction * t;
        let inside = [(a, b), (b, c), (c, a)]
            .into_iter()
            .all(|(a, b)| (b - a).cross(p - a).dot(normal) >= 0.0);
        if inside && t > 0.0 && t < best.0 {
            best = (t, direction.dot(normal) < 0.0);
        }
    }
    for s in &model.spheres {
        let to = s.center - origin;
        let middle = to.dot(direction);
        let half = (s.radius * s.radius - to.length_squared() + middle * middle).sqrt();
        for t in [middle - half, middle + half] {
            if t > 0.0 && t < best.0 {
                let out = origin + direction * t - s.center;
                best = (t, (direction.dot(out) < 0.0) != s.inward);
            }
        }
    }
    best.1
}

/// A sun of `light 1e5`, half a degree wide, at 45° on a plane:
/// `rtrace -w -h -ab 0 -dc 1 -dt 0 -st 0`, seen from above.
#[test]
fn coated_materials_split_light_as_radiance() {
    let sun = 1.346_229_38; // Irradiance / π, by Radiance's 2π(1 - cos .25°) for the solid angle.
    let golden = [
        ("plastic m 0 0 5 .5 .4 .3 0 0", [0.673_114_7, 0.538_491_8, 0.403_868_8], 0.0),
        ("plastic m 0 0 5 .5 .4 .3 .2 .05", [0.538_491_8, 0.430_793_4, 0.323_095_1], 0.0),
        ("metal m 0 0 5 .5 .4 .3 .2 .05", [0.538_491_8, 0.430_793_4, 0.323_095_1], 0.0),
        ("trans m 0 0 7 .5 .4 .3 .1 .05 .3 .25", [0.424_062_2, 0.339_249_8, 0.254_437_4], 1.0),
    ];
    for (text, expected, thin) in golden {
        let model = load(&format!("void {text}\nm sphere s 0 0 4 0 0 0 1\n"));
        let [m] = &model.materials[..] else { panic!() };
        assert_eq!(m.kind, MaterialKind::Opaque);
        let error = (m.diffuse * sun - DVec3::from(expected)).length();
        assert!(error < 1e-6, "{text}: {error}");
        // The same with the sun behind the plane.
        let through = m.transmit * (1.0 - m.transmit_specular) * sun;
        let expected = dvec3(0.136_305_7, 0.109_044_6, 0.081_783_44) * thin;
        assert!((through - expected).length() < 1e-6, "{text}: {through}");
    }
    let model = load(
        "void plastic a 0 0 5 .5 .4 .3 .2 .05\nvoid metal b 0 0 5 .5 .4 .3 .2 .05\n\
                      a sphere s 0 0 4 0 0 0 1\nb sphere s 0 0 4 0 0 0 1\n",
    );
    assert_eq!(model.materials[0].specular, DVec3::splat(0.2));
    assert_near(model.materials[1].specular, [0.1, 0.08, 0.06]);
    assert_eq!(model.materials[0].roughness, 0.05);
}

/// Through a box two units thick, of index 1.0001, before a sky of 1:
/// `rtrace -w -h -ab 0` says .25, .0625, .81; and `xform -s 2` makes .5 to .707107.
#[test]
fn a_dielectric_absorbs_by_length() {
    let p = "void dielectric d 0 0 5 .5 .25 .9 1.5 0\nd sphere s 0 0 4 0 0 0 1\n";
    let one = load(p);
    let two = one.materials[0].absorption * -2.0;
    let left = two.to_array().map(f64::exp);
    assert_near(left.into(), [0.25, 0.0625, 0.81]);
    let files = Files::new(&[("p.rad", p), ("a.rad", "!xform -s 2 p.rad\n")]);
    let scaled = files.load("a.rad").unwrap().materials[0].absorption.x;
    assert!((scaled - 0.5f64.ln().abs() / 2.0).abs() < 1e-15);
    let black = load("void dielectric d 0 0 5 0 1 1 1.5 0\nd sphere s 0 0 4 0 0 0 1\n");
    assert!(black.materials[0].absorption.x > 1e6 && black.materials[0].absorption.y == 0.0);
}

#[test]
fn lights_of_every_kind() {
    let model = load(
        "void light l 0 0 3 1 2 3
void glow near 0 0 4 1 1 1 2
void glow seen 0 0 4 1 1 1 0
void glow never 0 0 4 1 1 1 -1
void spotlight spot 0 0 7 1 1 1 60 0 0 -3
l sphere a 0 0 4 0 0 0 1
near sphere b 0 0 4 0 0 5 1
seen sphere c 0 0 4 0 0 9 1
never sphere d 0 0 4 0 0 12 1
spot ring e 0 0 8 5 5 5 0 0 -1 0 1
l source f 0 0 4 0 3 4 10
near source g 0 0 4 0 0 1 180
",
    );
    let kinds: Vec<_> = model.lights.iter().map(|l| (l.kind, l.reach)).collect();
    let far = f64::INFINITY;
    assert_eq!(
        kinds,
        [
            (LightKind::Sphere, far),
            (LightKind::Sphere, 2.0),
            (LightKind::Disc, far),
            (LightKind::Distant, far),
            (LightKind::Distant, 0.0),
        ]
    );
    let cone = model.lights[2].cone.unwrap();
    assert_eq!((cone.axis, cone.focus), (-DVec3::Z, 3.0));
    assert!((cone.half_angle.to_degrees() - 30.0).abs() < 1e-12, "the angle is the full one");
    assert_near(model.lights[3].u, [0.0, 0.6, 0.8]);
    assert!((model.lights[3].v.x - 5f64.to_radians().cos()).abs() < 1e-15);
    assert_eq!(model.spheres.len(), 4, "what only glows is seen");
}

#[test]
fn an_illum_is_seen_as_its_alternate() {
    let model = load(
        "void glass pane 0 0 3 .9 .9 .9
void illum window 1 pane 0 3 5 5 5
void illum hidden 0 0 3 7 7 7
void mirror front 1 pane 0 3 .8 .8 .8
window polygon a 0 0 12 0 0 0 1 0 0 1 1 0 0 1 0
hidden polygon b 0 0 12 0 0 5 1 0 5 1 1 5 0 1 5
front polygon c 0 0 12 0 0 8 1 0 8 1 1 8 0 1 8
",
    );
    assert_eq!(model.triangles.len(), 4, "an illum without alternate is not seen");
    let kind = |t: usize| model.materials[usize::from(model.triangles[t].material)].kind;
    assert_eq!((kind(0), kind(2)), (MaterialKind::Glass, MaterialKind::Glass));
    let found: Vec<_> = model.lights.iter().map(|l| (l.radiance.x, l.material.is_some())).collect();
    assert_eq!(found, [(5.0, true), (7.0, false)]);
    let m = &model.materials[usize::from(model.lights[0].material.unwrap())];
    assert!(matches!(m.emitter, Emitter::Illum { .. }) && m.emission == DVec3::ZERO);
}

#[test]
fn the_copies_of_an_array_have_the_materials_of_the_first() {
    let part = "void plastic a 0 0 5 .5 .5 .5 0 0\na sphere s 0 0 4 0 0 0 .2\n\
                void plastic a 0 0 5 .9 .1 .1 0 0\na sphere s 0 0 4 0 0 .5 .2\n";
    let files = Files::new(&[("all.rad", "!xform -a 20 -t 1 0 0 part.rad\n"), ("part.rad", part)]);
    let model = files.load("all.rad").unwrap();
    assert_eq!((model.spheres.len(), model.materials.len()), (40, 2));
    let used: Vec<_> = model.spheres.iter().take(4).map(|s| s.material).collect();
    assert_eq!(used, [0, 1, 0, 1]);
}

#[test]
fn names_resolve_through_patterns_mixtures_and_aliases() {
    let model = load(
        "void plastic red 0 0 5 .9 0 0 0 0
void plastic blue 0 0 5 0 0 .9 0 0
red brightfunc dirty 2 dirt dirt.cal 0 1 .4
dirty texfunc rough 4 a b c x.cal 0 0
void mixfunc both 4 blue void f x.cal 0 0
red alias rot red
inherit alias rouge rot
rough sphere a 0 0 4 0 0 0 1
both sphere b 0 0 4 0 0 0 1
rouge sphere c 0 0 4 0 0 0 1
void sphere d 0 0 4 0 0 0 1
void plastic red 0 0 5 0 .9 0 0 0
red sphere e 0 0 4 0 0 0 1
rouge sphere f 0 0 4 0 0 0 1
",
    );
    let colors: Vec<_> =
        model.spheres.iter().map(|s| model.materials[usize::from(s.material)].diffuse).collect();
    let [r, g, b] = [DVec3::X, DVec3::Y, DVec3::Z].map(|c| c * 0.9);
    assert_eq!(colors, [r, b, r, g, r], "the last definition counts, an alias keeps its own");
    let told = notes(&model);
    assert_eq!(
        told,
        [
            ("a pattern or texture: left out, the plain material is used", 2),
            ("a mixture: only its foreground is used", 1),
            ("a surface whose modifier is void: not seen, as in Radiance", 1),
        ]
    );
}

#[test]
fn xform_replaces_modifiers_from_outside_in() {
    let p = "void plastic a 0 0 5 .1 .1 .1 0 0\na sphere s 0 0 4 0 0 0 1\n";
    let q = "void plastic b 0 0 5 .2 .2 .2 0 0\n!xform -m b -t 9 0 0 p.rad\n";
    let all = "void plastic c 0 0 5 .3 .3 .3 0 0\n!xform q.rad\n!xform -m c sub/../q.rad\n";
    let files = Files::new(&[("p.rad", p), ("q.rad", q), ("a.rad", all), ("sub/x", "")]);
    let model = files.load("a.rad").unwrap();
    let grey: Vec<_> =
        model.spheres.iter().map(|s| model.materials[usize::from(s.material)].diffuse.x).collect();
    assert_eq!(grey, [0.2, 0.3]);
}

#[test]
fn files_are_sought_beside_the_file_that_names_them() {
    let files = Files::new(&[
        ("a.rad", "!xform lib/b.rad\n"),
        ("lib/b.rad", "!xform -t 1 0 0 deep/c.rad\n"),
        ("lib/deep/c.rad", &format!("{GREY}m sphere s 0 0 4 0 0 0 1\nm sphere t 0 0 4 x\n")),
    ]);
    let error = files.error("a.rad");
    assert!(error.contains("c.rad:3: sphere `t`: number 1 of 4: `x`"), "{error}");
    assert!(error.contains("(included at lib/b.rad:1)"), "{error}");
}

#[test]
fn quotes_comments_and_odd_spacing_are_read() {
    let text = "# a comment\r\nvoid plastic \"my paint\"\r\n0\r\n0\r\n5 .5 .5 .5 # grey\r\n 0 0\r\n\
         'my paint'\tsphere s 0 0 4 0 0 0 1\n!xform \\\n -t 1 0 0 \\\n 'b c.rad'";
    let files = Files::new(&[("a.rad", text), ("b c.rad", GREY)]);
    let model = files.load("a.rad").unwrap();
    assert_eq!(model.spheres.len(), 1);
}

/// A comment ends a number, as in `fgetval`; in names and strings it is a sign as any other.
#[test]
fn a_comment_ends_a_number() {
    let model = load(
        "void brightfunc p#1 1 b#right 0#two\n0# none\n\
         void plastic m#1\n0\n0#grey\n5#five\n.5 .5 .5#grey\n0 0#smooth\n\
         m#1 sphere s#1 0 1 7#one\n4 0 0 0 1#\n",
    );
    assert_eq!((model.spheres.len(), &model.materials[0].name[..]), (1, "m#1"));
}

#[test]
fn an_index_of_refraction_makes_sense_or_is_refused_where_it_stands() {
    let load = |line: &str| {
        let text = format!("# glass\n{line}\ng sphere s 0 0 4 0 0 0 1\n");
        let files = Files::new(&[("a.rad", &text)]);
        files.load("a.rad").map(|model| model.materials[0].ior).map_err(|_| files.error("a.rad"))
    };
    for (line, found) in [
        ("void dielectric g 0 0 5 1 1 1 0 0", "dielectric `g`: an index of refraction of 0:"),
        ("void dielectric g 0 0 5 1 1 1 -1.5 0", "an index of refraction of -1.5:"),
        ("void dielectric g 0 0 5 1 1 1 1e29 0", "an index of refraction of 1"),
        ("void dielectric g 0 0 5 1 1 1 nan 0", "`nan` is not a finite number"),
        ("void glass g 0 0 4 1 1 1 0", "glass `g`: an index of refraction of 0:"),
        ("void interface g 0 0 8 1 1 1 1.5 1 1 1 0", "an index of refraction of inf:"),
        ("void interface g 0 0 8 1 1 1 0 1 1 1 0", "an index of refraction of NaN:"),
    ] {
        let error = load(line).expect_err(line);
        assert!(error.starts_with("a.rad:2: ") && error.contains(found), "{line}: {error}");
    }
    // A bubble in glass.
    assert_eq!(load("void interface g 0 0 8 1 1 1 1 1 1 1 1.6"), Ok(0.625));
}

#[test]
fn what_is_not_built_in_is_named() {
    let text = "void BSDF a 0 0 0\nvoid ashik2 b 0 0 0\na sphere s 0 0 4 0 0 0 1\n\
                a cone c 0 0 8 0 0 0 0 0 1 -1 2\na ring r 0 0 8 0 0 0 0 0 1 -1 2\n";
    let told: Vec<_> = load(text).notes.iter().map(ToString::to_string).collect();
    let ends = [
        "a.rad:1: a material that is not built in: grey instead: `BSDF a`, `ashik2 b` (2 times in all)",
        "a.rad:4: a cone or cylinder with a radius below zero: dropped",
        "a.rad:5: a ring with a radius below zero: dropped",
    ];
    assert_eq!(told.len(), ends.len());
    for (told, end) in told.iter().zip(ends) {
        assert!(told.ends_with(end), "{told}");
    }
}

#[test]
fn values_without_sense_are_refused_where_the_material_is_defined() {
    for (line, says) in [
        ("void plastic m 0 0 5 .5 -1 .5 0 0", "plastic `m`: number 2 of 5 is -1, below zero"),
        ("void plastic m 0 0 5 .5 .5 .5 -.1 0", "number 4 of 5 is -0.1, below zero"),
        ("void metal m 0 0 5 .5 .5 .5 .1 -2", "number 5 of 5 is -2, below zero"),
        ("void metal2 m 0 0 6 .5 .5 .5 .1 -2 -2", "number 5 of 6 is -2, below zero"),
        ("void trans m 0 0 7 .5 .5 .5 .1 0 .5 -1", "number 7 of 7 is -1, below zero"),
        ("void dielectric m 0 0 5 -1 1 1 1.5 0", "number 1 of 5 is -1, below zero"),
        ("void mirror m 0 0 3 .5 .5 -.5", "mirror `m`: number 3 of 3 is -0.5, below zero"),
        ("void light m 0 0 3 1e40 1 1", "material `m`: a value is no number or beyond"),
        ("void illum m 0 0 3 1e40 1 1", "material `m`: a value is no number or beyond"),
    ] {
        let text = format!("{GREY}{line}\nm sphere s 0 0 4 0 0 0 1\n");
        let error = Files::new(&[("a.rad", &text)]).error("a.rad");
        assert!(error.starts_with("a.rad:2: ") && error.contains(says), "{line}: {error}");
    }
    // What is above 1 is cut, and said at its line.
    let model = load(&format!("{GREY}void metal m 0 0 5 2 .5 .5 3 0\nm sphere s 0 0 4 0 0 0 1\n"));
    let told: Vec<_> = model.notes.iter().map(|n| (n.first.line, n.count, &n.text[..])).collect();
    assert_eq!(told, [(2, 2, "a reflectance or transmittance above 1: taken as 1")]);
}

#[test]
fn a_light_that_shines_into_a_sphere_is_said_to_light_nothing() {
    let model = load(
        "void light l 0 0 3 1 1 1
l bubble a 0 0 4 0 0 0 1
l sphere b 0 0 4 5 0 0 -1
l bubble c 0 0 4 9 0 0 -1
",
    );
    let inward: Vec<_> = model.spheres.iter().map(|s| s.inward).collect();
    assert_eq!((inward, model.lights.len()), (vec![true, true, false], 1));
    assert_eq!(
        notes(&model),
        [
            ("a light that shines inward from a sphere: seen, but lights nothing directly", 2),
            ("a radius below zero: turned inside out, as in Radiance", 2),
        ]
    );
}

/// A lamp as `ies2rad` writes it, a sky as `gensky`, and a pattern over a light.
#[test]
fn lights_with_patterns_are_said_not_to_have_their_brightness() {
    let model = load(
        "void texfunc bumps 4 a b c x.cal 0 0
bumps light smooth 0 0 3 1 1 1
void brightdata dist 5 flatcorr lamp.dat source.cal src_phi4 src_theta 0 1 1
dist plastic paint 0 0 5 .5 .5 .5 0 0
dist alias same dist
same light lamp 0 0 3 2 2 2
lamp sphere a 0 0 4 0 0 3 1
void brightfunc skyfunc 2 skybr skybright.cal 0 1 1
bumps texfunc more 4 a b c x.cal 0 0
skyfunc texfunc both 4 a b c x.cal 0 0
both glow sky 0 0 4 1 1 1 0
sky source b 0 0 4 0 0 1 180
smooth colorfunc tint 4 r g b x.cal 0 0
void mixfunc mix 4 dist void f x.cal 0 0
mix illum pane 1 paint 0 3 1 1 1
dist light off 0 0 3 0 0 0
dist sphere c 0 0 4 0 0 9 1
",
    );
    let told: Vec<_> = model.notes.iter().map(ToString::to_string).collect();
    let light = told.iter().find(|told| told.contains("light")).unwrap();
    let ends = "a.rad:6: a light with a pattern: its brightness is not the real one, \
                as the pattern is left out: `lamp`, `sky`, `smooth`, `pane` (4 times in all)";
    assert!(light.ends_with(ends), "{told:?}");
    assert_eq!(model.notes.count("a surface whose modifier is void: not seen, as in Radiance"), 1);
}

/// An alias that is modified by a pattern, and names a light.
#[test]
fn a_light_behind_the_alias_of_a_pattern_is_said_to_be_plain() {
    let scene = |modifier: &str| {
        let scene = format!(
            "void brightdata dist 5 flatcorr lamp.dat source.cal src_phi4 src_theta 0 1 1\n\
             void light bulb 0 0 3 2 2 2\n{modifier} alias lamp bulb\nlamp sphere a 0 0 4 0 0 3 1\n"
        );
        let model = load(&scene);
        let told: Vec<_> = model.notes.iter().map(ToString::to_string).collect();
        told.iter()
            .filter(|told| told.contains("a light with a pattern"))
            .cloned()
            .collect::<Vec<_>>()
    };
    let told = scene("dist");
    assert!(told.len() == 1 && told[0].ends_with("left out: `bulb`"), "{told:?}");
    assert!(["void", "inherit"].iter().all(|modifier| scene(modifier).is_empty()));
}

#[test]
fn a_source_that_emits_nothing_is_said_to_be_left_out() {
    let sources = "m source a 0 0 4 0 0 1 1\nvoid glow g 0 0 4 0 0 0 0\ng source b 0 0 4 0 0 1 1\n";
    let model = load(&format!("{GREY}{sources}m sphere s 0 0 4 0 0 0 1\n"));
    assert!(model.lights.is_empty());
    assert_eq!(notes(&model), [("a source whose material emits nothing: left out", 2)]);
    assert_eq!(model.notes.iter().next().map(|note| note.first.line), Some(2));
}

#[test]
fn a_mirror_beside_lights_is_said_to_throw_no_light_on() {
    let mirror = "void mirror m 0 0 3 .8 .8 .8\nm sphere s 0 0 4 0 0 0 1\n";
    assert!(notes(&load(mirror)).is_empty());
    let lit = load(&format!("{mirror}void light l 0 0 3 1 1 1\nl sphere t 0 0 4 5 0 0 1\n"));
    let told: Vec<_> = lit.notes.iter().map(ToString::to_string).collect();
    let [one] = &told[..] else { panic!("{told:?}") };
    assert!(one.starts_with("a mirror in a scene") && one.ends_with("lights): `m`"), "{one}");
}

#[test]
fn facets_of_round_edges_are_said_to_be_left_out() {
    let model = load(&format!("{GREY}!genbox m b 1 1 1 -r .1 -n 3 -s; genbox m b 1 1 1 -s\n"));
    let note = "genbox -n or -s: left out, round edges are cylinders and spheres";
    assert_eq!(notes(&model), [(note, 2)]);
}
