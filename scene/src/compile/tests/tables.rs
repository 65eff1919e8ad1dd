//! What the tables hold, by hand.

use glam::DVec3;
use kiloray_core::scene::{LightKind, ViewKind};

use super::shapes::soup;
use crate::compile::{Options, compile};
use crate::kilo::KiloFile;
use crate::model::{Cone, Light, Material, View};

/// A triangle of size 8 at 100: the frame's centre is (104, 104, 100), its unit 4.
fn model() -> crate::model::Model {
    let at = |x, y| DVec3::new(100.0 + x, 100.0 + y, 100.0);
    soup(vec![[at(0.0, 0.0), at(8.0, 0.0), at(0.0, 8.0)]])
}

#[test]
fn lengths_shrink_by_the_unit_and_the_rest_stays() {
    let mut model = model();
    model.materials[0] = Material {
        absorption: DVec3::splat(0.25),
        emission: DVec3::splat(3.0),
        ior: 1.4,
        ..Material::default()
    };
    let at = DVec3::new(104.0, 104.0, 108.0);
    let light = |kind, u, v| Light {
        kind,
        material: None,
        reach: 80.0,
        position: at,
        u,
        v,
        radiance: DVec3::splat(32.0),
        cone: None,
    };
    let axis = DVec3::NEG_Z;
    model.lights = vec![
        light(LightKind::Sphere, DVec3::X * 2.0, DVec3::ZERO),
        light(LightKind::Spot, axis, DVec3::X * 0.5),
        light(LightKind::Distant, axis, DVec3::X * (1.0 - 1e-9)),
        Light {
            cone: Some(Cone { axis, half_angle: std::f64::consts::FRAC_PI_3, focus: 10.0 }),
            ..light(LightKind::Parallelogram, DVec3::Y, DVec3::X)
        },
    ];
    let view = |kind| View {
        kind,
        name: "a name that is longer than twenty bytes".into(),
        position: at,
        direction: axis * 3.0,
        up: DVec3::Y,
        size: [40.0, 20.0],
        offset: [0.5, 0.0],
        clip: [4.0, 0.0],
    };
    model.views = vec![view(ViewKind::Perspective), view(ViewKind::Parallel)];
    let looks_nowhere = View { direction: DVec3::ZERO, ..view(ViewKind::Perspective) };
    model.views.push(looks_nowhere);

    let file = KiloFile::from_compiled(compile(&model, &Options::default(), &mut ()).unwrap());
    let file = file.view();
    let frame = file.header().frame;
    assert_eq!((frame.center, frame.exponent), ([104.0, 104.0, 100.0], 2));
    assert_eq!(frame.position_error, 0.0);
    let material = &file.materials()[0];
    assert_eq!((material.absorption, material.emission), ([1.0; 3], [3.0; 3]));
    assert_eq!(material.ior, 1.4);
    let [sphere, spot, distant, area] = file.lights() else { panic!("four lights") };
    assert_eq!((sphere.position, sphere.u, sphere.reach), ([0.0, 0.0, 2.0], [0.5, 0.0, 0.0], 20.0));
    assert_eq!((sphere.radiance, sphere.cone_cos), ([32.0; 3], -1.0));
    assert_eq!((spot.u, spot.v, spot.radiance), ([0.0, 0.0, -1.0], [0.5, 0.0, 0.0], [2.0; 3]));
    assert_eq!((distant.u, distant.radiance), ([0.0, 0.0, -1.0], [32.0; 3]));
    assert!((distant.v[1] - 1e-9).abs() < 1e-15);
    assert_eq!((area.u, area.v), ([0.0, 0.25, 0.0], [0.25, 0.0, 0.0]));
    assert!((area.cone_cos - 0.5).abs() < 1e-7);
    assert_eq!((area.cone, area.focus, spot.focus), ([0.0, 0.0, -1.0], 2.5, 0.0));
    let [perspective, parallel] = file.views() else { panic!("two views") };
    assert_eq!(&perspective.name, b"a name that is longe");
    assert_eq!((perspective.size, parallel.size), ([40.0, 20.0], [10.0, 5.0]));
    assert_eq!((perspective.clip, perspective.direction), ([1.0, 0.0], [0.0, 0.0, -1.0]));
    assert_eq!(perspective.position, [0.0, 0.0, 2.0]);
}

#[test]
fn a_spotlight_that_faces_away_keeps_its_cone_where_it_is_seen() {
    let mut model = model();
    model.materials[0].emission = DVec3::ONE;
    let plain = Light {
        kind: LightKind::Parallelogram,
        material: Some(0),
        reach: f64::INFINITY,
        position: DVec3::new(104.0, 104.0, 200.0),
        u: DVec3::X,
        v: DVec3::Y,
        radiance: DVec3::ONE,
        cone: None,
    };
    let cone = Some(Cone { axis: DVec3::Z, half_angle: 0.2, focus: 0.0 });
    let unseen = Light { material: None, cone, ..plain };
    let lights = |light: Light| {
        let model = crate::model::Model { lights: vec![light], ..model.clone() };
        let file = KiloFile::from_compiled(compile(&model, &Options::default(), &mut ()).unwrap());
        (file.view().lights().len(), file.view().materials()[0].light)
    };
    assert_eq!(lights(plain), (0, 0));
    assert_eq!(lights(unseen), (0, 0));
    assert_eq!(lights(Light { cone, ..plain }), (1, 1));
}

#[test]
fn what_leads_nowhere_is_named() {
    let error = |change: fn(&mut crate::model::Model)| {
        let mut model = model();
        change(&mut model);
        compile(&model, &Options::default(), &mut ()).unwrap_err().to_string()
    };
    assert_eq!(error(|m| m.triangles[0].material = 7), "material 7 is missing: the model has 1");
    assert_eq!(error(|m| m.triangles[0].vertices[1] = 70), "vertex 70 is missing: the model has 3");
    assert_eq!(error(|m| m.triangles[0].normals[1] = 0), "normal 0 is missing: the model has 0");
    for block_bytes in [0, 512, 3000, 1 << 17] {
        let refused = compile(&model(), &Options::blocks_of(block_bytes), &mut ()).unwrap_err();
        assert!(refused.to_string().starts_with(&format!("a block of {block_bytes} bytes")));
    }
}
