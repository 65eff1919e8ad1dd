use std::f64::consts::{PI, TAU};

use glam::{DVec3, dvec3};
use kiloray_core::scene::{LightKind, MaterialKind, ViewKind};

use super::*;

fn lamp(model: &mut Model) -> u16 {
    let emitter = Emitter::Sampled { reach: f64::INFINITY, cone: None };
    let emission = dvec3(1.0, 2.0, 3.0);
    let kind = MaterialKind::Light;
    model.add_material(Material { kind, emission, emitter, ..Material::default() }).unwrap()
}

fn grey(model: &mut Model) -> u16 {
    model.add_material(Material::default()).unwrap()
}

fn corners(model: &Model, t: &Triangle) -> [DVec3; 3] {
    t.vertices.map(|i| model.vertices[i as usize])
}

/// Twice the area, along the front.
fn cross([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

fn area(model: &Model) -> f64 {
    model.triangles.iter().map(|t| cross(corners(model, t)).length() / 2.0).sum()
}

fn polygon(points: &[[f64; 3]]) -> Model {
    let mut model = Model::default();
    let m = grey(&mut model);
    let points: Vec<DVec3> = points.iter().copied().map(DVec3::from).collect();
    model.add_polygon(m, &points).unwrap();
    model
}

#[test]
fn a_square_is_two_triangles_and_one_light() {
    let mut model = Model::default();
    let m = lamp(&mut model);
    let points = [[1.0, 0.0, 0.0], [1.0, 2.0, 0.0], [1.0, 2.0, 3.0], [1.0, 0.0, 3.0]];
    model.add_polygon(m, &points.map(DVec3::from)).unwrap();
    assert_eq!((model.triangles.len(), model.vertices.len()), (2, 4));
    let [light] = model.lights[..] else { panic!("{:?}", model.lights) };
    assert_eq!(light.kind, LightKind::Parallelogram);
    assert_eq!(light.position, dvec3(1.0, 0.0, 0.0));
    assert_eq!(light.u.cross(light.v), dvec3(6.0, 0.0, 0.0), "its front is the polygon's");
    assert_eq!(light.radiance, dvec3(1.0, 2.0, 3.0));
    for t in &model.triangles {
        assert!(cross(corners(&model, t)).x > 0.0);
    }
}

#[test]
fn a_trapezoid_that_emits_is_two_lights() {
    let mut model = Model::default();
    let m = lamp(&mut model);
    let points = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    model.add_polygon(m, &points.map(DVec3::from)).unwrap();
    assert_eq!(model.lights.len(), 2);
    assert!(model.lights.iter().all(|l| l.kind == LightKind::Triangle));
    let area: f64 = model.lights.iter().map(|l| l.u.cross(l.v).z / 2.0).sum();
    assert_eq!(area, 2.5);
}

#[test]
fn concave_polygons_are_covered_once_from_every_side() {
    // An arrow head, a U and a comb, in every plane and turned both ways.
    let shapes: [(&[[f64; 2]], f64); 3] = [
        (&[[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]], 4.0),
        (
            &[
                [0.0, 0.0],
                [3.0, 0.0],
                [3.0, 2.0],
                [2.0, 2.0],
                [2.0, 1.0],
                [1.0, 1.0],
                [1.0, 2.0],
                [0.0, 2.0],
            ],
            5.0,
        ),
        (
            &[
                [0.0, 0.0],
                [5.0, 0.0],
                [5.0, 3.0],
                [4.0, 1.0],
                [3.0, 3.0],
                [2.0, 1.0],
                [1.0, 3.0],
                [0.0, 1.0],
            ],
            // 5 × 1, and three teeth: 1, 2 and 2.
            5.0 + 1.0 + 2.0 + 2.0,
        ),
    ];
    for (shape, expected) in shapes {
        for turn in 0..6 {
            let point = |&[u, v]: &[f64; 2]| match turn {
                0 => [u, v, 7.0],
                1 => [7.0, u, v],
                2 => [v, 7.0, u],
                3 => [v, u, 7.0],
                4 => [7.0, v, u],
                _ => [u, 7.0, v],
            };
            let points: Vec<[f64; 3]> = shape.iter().map(point).collect();
            let model = polygon(&points);
            assert_eq!(area(&model), expected, "{turn}");
            assert_eq!(model.triangles.len(), shape.len() - 2);
            assert!(model.notes.is_empty(), "{:?}", model.notes);
            let axis = [2, 0, 1, 2, 0, 1][turn];
            let sign = if turn < 3 { 1.0 } else { -1.0 };
            for t in &model.triangles {
                assert!(cross(corners(&model, t))[axis] * sign > 0.0, "{turn}");
            }
        }
    }
}

#[test]
fn a_hole_is_joined_by_a_seam() {
    let model = polygon(&[
        [0.0, 0.0, 0.0],
        [4.0, 0.0, 0.0],
        [4.0, 4.0, 0.0],
        [0.0, 4.0, 0.0],
        [0.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [1.0, 3.0, 0.0],
        [3.0, 3.0, 0.0],
        [3.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
    ]);
    assert!((area(&model) - 12.0).abs() < 1e-12, "{}", area(&model));
    assert!(model.notes.is_empty(), "{:?}", model.notes);
    let covers = |p: [f64; 2]| {
        let p = dvec3(p[0], p[1], 0.0);
        model.triangles.iter().any(|t| {
            let [a, b, c] = corners(&model, t);
            [[a, b, p], [b, c, p], [c, a, p]].into_iter().all(|t| cross(t).z > 0.0)
        })
    };
    assert!(!covers([2.1, 1.7]));
    assert!(covers([0.4, 1.7]) && covers([3.6, 1.7]) && covers([2.1, 3.5]) && covers([2.1, 0.3]));
}

/// Several holes, which hang on the outline and on each other.
#[test]
fn holes_may_hang_on_holes() {
    let points = [
        [0.0, 0.0, 0.0],
        [0.75, 0.25, 0.0],
        [0.25, 0.25, 0.0],
        [0.25, 0.75, 0.0],
        [2.6055, 0.8606, 0.0],
        [2.8804, 0.3887, 0.0],
        [2.378, 0.0832, 0.0],
        [2.1908, 0.5905, 0.0],
        [2.6055, 0.8606, 0.0],
        [0.25, 0.75, 0.0],
        [0.75, 0.75, 0.0],
        [0.75, 0.25, 0.0],
        [0.0, 0.0, 0.0],
        [4.0, 0.0, 0.0],
        [3.1565, 0.235, 0.0],
        [3.4716, 0.7112, 0.0],
        [2.75, 2.25, 0.0],
        [2.25, 2.25, 0.0],
        [1.8276, 2.2885, 0.0],
        [1.629, 2.0819, 0.0],
        [1.4064, 2.2779, 0.0],
        [1.1825, 2.3371, 0.0],
        [2.2799, 1.166, 0.0],
        [2.3274, 1.8442, 0.0],
        [2.7715, 1.484, 0.0],
        [2.2799, 1.166, 0.0],
        [1.1825, 2.3371, 0.0],
        [1.1591, 2.5778, 0.0],
        [0.6235, 2.0751, 0.0],
        [0.3061, 2.2978, 0.0],
        [0.3114, 2.5463, 0.0],
        [0.3769, 2.9237, 0.0],
        [0.679, 2.6867, 0.0],
        [0.8227, 2.4208, 0.0],
        [0.6235, 2.0751, 0.0],
        [1.1591, 2.5778, 0.0],
        [1.2286, 2.8582, 0.0],
        [1.5164, 2.8297, 0.0],
        [1.7126, 2.7292, 0.0],
        [1.7481, 2.5311, 0.0],
        [1.8276, 2.2885, 0.0],
        [2.25, 2.25, 0.0],
        [2.25, 2.75, 0.0],
        [2.4352, 3.2919, 0.0],
        [2.1667, 3.4248, 0.0],
        [2.2685, 3.7508, 0.0],
        [2.5908, 3.7916, 0.0],
        [2.902, 3.5906, 0.0],
        [2.7653, 3.2126, 0.0],
        [2.4352, 3.2919, 0.0],
        [2.25, 2.75, 0.0],
        [2.75, 2.75, 0.0],
        [2.75, 2.25, 0.0],
        [3.4716, 0.7112, 0.0],
        [3.8832, 0.3424, 0.0],
        [3.1565, 0.235, 0.0],
        [4.0, 0.0, 0.0],
        [4.0, 4.0, 0.0],
        [1.8279, 3.7103, 0.0],
        [1.6028, 3.3397, 0.0],
        [1.2877, 3.3638, 0.0],
        [1.3586, 3.7205, 0.0],
        [1.8279, 3.7103, 0.0],
        [4.0, 4.0, 0.0],
        [0.0, 4.0, 0.0],
        [0.25, 1.25, 0.0],
        [0.25, 1.75, 0.0],
        [0.75, 1.75, 0.0],
        [0.75, 1.25, 0.0],
        [0.25, 1.25, 0.0],
        [0.0, 4.0, 0.0],
    ];
    let model = polygon(&points);
    let next = points.iter().skip(1).chain(&points[..1]);
    let whole = points.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() / 2.0;
    assert!((area(&model) - whole).abs() < 1e-9, "{} of {whole}", area(&model));
    assert!(model.notes.is_empty(), "{:?}", model.notes);
}

#[test]
fn corners_in_a_row_lose_nothing() {
    let corners = [[1, 2], [1, 0], [4, 2], [4, 3], [2, 1], [4, 4], [3, 4]];
    let model = polygon(&corners.map(|[x, y]| [f64::from(x), f64::from(y), 0.0]));
    assert!(model.notes.is_empty(), "{:?}", model.notes);
    let next = corners.iter().skip(1).chain(&corners[..1]);
    let whole: i32 = corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum();
    assert!((area(&model) - f64::from(whole) / 2.0).abs() < 1e-12, "{}", area(&model));
}

#[test]
fn bad_surfaces_are_dropped_and_counted_with_their_place() {
    let mut model = Model::default();
    let m = grey(&mut model);
    model.notes.set_place(Place { file: Some("a.obj".into()), line: 7 });
    let p = |x: f64| dvec3(x, 0.0, 0.0);
    model.add_triangle(m, [p(0.0), p(1.0), dvec3(0.0, f64::NAN, 0.0)]).unwrap();
    model.add_triangle(m, [p(0.0), p(1.0), dvec3(0.0, f64::INFINITY, 0.0)]).unwrap();
    model.add_triangle(m, [p(0.0), p(1.0), dvec3(0.0, 2e100, 0.0)]).unwrap();
    model.add_triangle(m, [p(0.0), p(1.0), p(2.0)]).unwrap();
    // Collinear but for the rounding of decimals.
    let q = |i: f64| dvec3(0.1 * i, 0.7 * i, 0.3 * i);
    model.add_triangle(m, [q(1.0), q(3.0), q(7.0)]).unwrap();
    model.add_triangle(m + 1, [p(0.0), p(1.0), DVec3::Y]).unwrap();
    model.add_face(m, [0, 1, 2], [NO_NORMAL; 3]).unwrap();
    model.add_polygon(m, &[p(0.0), p(1.0)]).unwrap();
    model.add_polygon(m, &[p(0.0), p(1.0), p(2.0), p(1.0)]).unwrap();
    model.add_sphere(m, p(0.0), 0.0, false).unwrap();
    model.add_sphere(m, p(f64::NAN), 1.0, false).unwrap();
    model.add_ring(m, p(0.0), DVec3::ZERO, [0.0, 1.0]).unwrap();
    model.add_cone(m, [p(0.0), p(0.0)], [1.0, 0.0], false).unwrap();
    model.add_cone(m, [p(0.0), p(1.0)], [1.0, -1.0], false).unwrap();
    assert!(model.triangles.is_empty() && model.spheres.is_empty() && model.vertices.is_empty());
    assert_eq!(model.notes.iter().map(|n| n.count).sum::<u64>(), 14);
    assert_eq!(model.notes.count("a face without area: dropped"), 3);
    let first = model.notes.iter().next().unwrap().to_string();
    assert!(first.starts_with("a.obj:7: ") && first.contains("no number"), "{first}");
}

#[test]
fn slivers_and_extreme_scales_are_kept() {
    for scale in [1e-90, 1e-20, 1.0, 1e20, 1e90] {
        let mut model = Model::default();
        let m = grey(&mut model);
        let points = [DVec3::ZERO, DVec3::X, dvec3(0.5, 1e-12, 0.0)];
        model.add_triangle(m, points.map(|p| p * scale)).unwrap();
        let quad = [DVec3::ZERO, DVec3::X, dvec3(1.0, 1e-9, 0.0), dvec3(0.0, 1e-9, 0.0)];
        model.add_polygon(m, &quad.map(|p| p * scale)).unwrap();
        assert_eq!(model.triangles.len(), 3, "{scale}: {:?}", model.notes);
    }
}

#[test]
fn bent_and_crossing_polygons_are_noted() {
    let bent = polygon(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.1], [0.0, 1.0, 0.0]]);
    assert_eq!(bent.triangles.len(), 2);
    assert_eq!(bent.notes.count("a polygon that is not flat: cut along its mean plane"), 1);
    let bow = polygon(&[[0.0, 0.0, 0.0], [3.0, 3.0, 0.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
    assert_eq!(bow.notes.count("a polygon that crosses itself: cut as well as it goes"), 1);
}

#[test]
fn a_ring_has_the_area_of_its_polygon_and_faces_its_normal() {
    let n = f64::from(SIDES);
    let share = n / 2.0 * (TAU / n).sin();
    for (inner, kinds) in [(0.0, LightKind::Disc), (1.0, LightKind::Triangle)] {
        for normal in [DVec3::X, dvec3(1.0, -2.0, 3.0), -DVec3::Z] {
            let mut model = Model::default();
            let m = lamp(&mut model);
            model.add_ring(m, DVec3::ONE, normal, [inner, 2.0]).unwrap();
            let expected = share * (4.0 - inner * inner);
            assert!((area(&model) - expected).abs() < 1e-12, "{} {expected}", area(&model));
            for t in &model.triangles {
                let along = cross(corners(&model, t)).normalize().dot(normal.normalize());
                assert!(along > 1.0 - 1e-9, "{along}");
            }
            assert!(model.lights.iter().all(|l| l.kind == kinds));
            for l in &model.lights {
                assert!(l.u.cross(l.v).dot(normal) > 0.0);
            }
            if inner == 0.0 {
                let [l] = model.lights[..] else { panic!() };
                assert!(l.u.dot(l.v).abs() < 1e-12 && (l.v.length() - 2.0).abs() < 1e-12);
                assert_eq!(l.position, DVec3::ONE);
            }
        }
    }
}

#[test]
fn a_cone_lies_on_its_surface_and_its_normals_are_true() {
    // Half a cone: radius 2 at z = 0, 1 at z = 3.
    for inward in [false, true] {
        for (ra, rb) in [(2.0, 1.0), (1.0, 2.0), (2.0, 0.0), (0.0, 2.0), (1.5, 1.5)] {
            let mut model = Model::default();
            let m = grey(&mut model);
            let ends = [DVec3::ZERO, dvec3(0.0, 0.0, 3.0)];
            model.add_cone(m, ends, [ra, rb], inward).unwrap();
            let sides = if ra.min(rb) == 0.0 { 1 } else { 2 };
            assert_eq!(model.triangles.len(), (SIDES * sides) as usize);
            // The lateral area of a frustum.
            let lateral = PI * (ra + rb) * (9.0 + (ra - rb) * (ra - rb)).sqrt();
            assert!((area(&model) / lateral - 1.0).abs() < 1e-3, "{} {lateral}", area(&model));
            let sign = if inward { -1.0 } else { 1.0 };
            for t in &model.triangles {
                let points = corners(&model, t);
                let center = (points[0] + points[1] + points[2]) / 3.0;
                let front = cross(points).normalize();
                let out = dvec3(center.x, center.y, 0.0);
                assert!(front.dot(out) * sign > 0.0, "front");
                for (p, n) in points.iter().zip(t.normals) {
                    let n = model.normals[n as usize];
                    assert!(n.dot(front) > 0.99, "{n} {front}");
                    let r = ra + (rb - ra) * p.z / 3.0;
                    assert!((p.truncate().length() - r).abs() < 1e-12);
                    // Perpendicular to the slant, which runs through the apex line of p.
                    let slant =
                        dvec3(0.0, 0.0, 3.0) + dvec3(n.x, n.y, 0.0).normalize() * sign * (rb - ra);
                    assert!(n.dot(slant).abs() < 1e-9, "{}", n.dot(slant));
                }
            }
        }
    }
}

#[test]
fn spheres_sources_and_views() {
    let mut model = Model::default();
    let m = lamp(&mut model);
    model.add_sphere(m, DVec3::Y, 2.0, false).unwrap();
    model.add_sphere(m, DVec3::Y, 9.0, true).unwrap();
    assert_eq!(model.lights.len(), 1, "a light that shines inward is not sampled");
    assert_eq!((model.lights[0].kind, model.lights[0].u.x), (LightKind::Sphere, 2.0));
    model.add_source(m, dvec3(0.0, 0.0, 5.0), 0.5).unwrap();
    let sun = model.lights[1];
    assert_eq!((sun.kind, sun.u), (LightKind::Distant, DVec3::Z));
    // cos(0.25°)
    assert!((sun.v.x - 0.999_990_480_720_734).abs() < 1e-15);
    assert!(model.add_source(m, DVec3::ZERO, 0.5).is_err());
    assert!(model.add_source(m, DVec3::Z, 361.0).is_err());
    let view = View {
        kind: ViewKind::Perspective,
        name: String::new(),
        position: DVec3::ZERO,
        direction: dvec3(0.0, 3.0, 0.0),
        up: DVec3::Z,
        size: [45.0, 45.0],
        offset: [0.0; 2],
        clip: [0.0; 2],
    };
    model.add_view(view.clone()).unwrap();
    assert_eq!(model.views[0].direction, DVec3::Y);
    let bad = [
        View { up: DVec3::Y, ..view.clone() },
        View { size: [180.0, 45.0], ..view.clone() },
        View { direction: DVec3::ZERO, ..view.clone() },
        View { position: DVec3::NAN, ..view.clone() },
        View { clip: [2.0, 1.0], ..view.clone() },
    ];
    for view in bad {
        assert!(model.add_view(view.clone()).is_err(), "{view:?}");
    }
}

#[test]
fn materials_are_checked_and_bounded() {
    let mut model = Model::default();
    let bad = Material { diffuse: DVec3::NAN, ..Material::default() };
    assert!(matches!(model.add_material(bad), Err(ModelError::Material { .. })));
    let bad = Material { ior: -1.0, ..Material::default() };
    assert!(matches!(model.add_material(bad), Err(ModelError::Material { .. })));
    for i in 0..MATERIALS_MAX {
        assert_eq!(model.add_material(Material::default()), Ok(i as u16));
    }
    assert_eq!(model.add_material(Material::default()), Err(ModelError::Materials));
}
