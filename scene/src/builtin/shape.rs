use glam::{DAffine3, DVec3};
use kiloray_core::scene::{LightKind, MaterialKind, ViewKind};

use crate::model::{Emitter, Light, Material, Model, NO_NORMAL, Sphere, Triangle, View};

/// Puts shapes into a model. What is made stands in the current [`Shaper::place`].
#[derive(Debug, Default)]
pub(super) struct Shaper {
    model: Model,
    place: DAffine3,
}

/// A grid of points with normals: the common form of all curved shapes.
pub(super) struct Patch {
    /// Cells along and across.
    pub(super) cells: [u32; 2],
    /// The last column is the first, the last row is the first.
    pub(super) closed: [bool; 2],
}

impl Shaper {
    pub(super) fn finish(self) -> Model {
        self.model
    }

    /// Triangles and spheres of what `make` makes.
    pub(super) fn count(make: impl FnOnce(&mut Self)) -> u64 {
        let mut shaper = Self::default();
        make(&mut shaper);
        (shaper.model.triangles.len() + shaper.model.spheres.len()) as u64
    }

    /// Runs `make` with everything moved by `by` first.
    pub(super) fn at(&mut self, by: DAffine3, make: impl FnOnce(&mut Self)) {
        let before = self.place;
        self.place = before * by;
        make(self);
        self.place = before;
    }

    /// The index that the next material gets.
    pub(super) fn next_material(&self) -> u16 {
        self.model.materials.len() as u16
    }

    pub(super) fn material(&mut self, material: Material) -> u16 {
        let index = self.model.materials.len() as u16;
        self.model.materials.push(material);
        index
    }

    fn vertex(&mut self, local: DVec3) -> u32 {
        let index = self.model.vertices.len() as u32;
        self.model.vertices.push(self.place.transform_point3(local));
        index
    }

    fn triangle(&mut self, vertices: [u32; 3], normals: [u32; 3], material: u16) {
        self.model.triangles.push(Triangle { vertices, normals, material });
    }

    /// The parallelogram `corner + a u + b v`; its front is the side of `u × v`.
    pub(super) fn quad(&mut self, corner: DVec3, u: DVec3, v: DVec3, material: u16) {
        let [a, b, c, d] = [corner, corner + u, corner + u + v, corner + v].map(|p| self.vertex(p));
        self.triangle([a, b, c], [NO_NORMAL; 3], material);
        self.triangle([a, c, d], [NO_NORMAL; 3], material);
    }

    /// A parallelogram that shines to its front.
    pub(super) fn lamp(&mut self, corner: DVec3, u: DVec3, v: DVec3, material: u16) {
        self.quad(corner, u, v, material);
        let radiance = self.model.materials[usize::from(material)].emission;
        self.model.lights.push(Light {
            kind: LightKind::Parallelogram,
            material: Some(material),
            reach: f64::INFINITY,
            position: self.place.transform_point3(corner),
            u: self.place.transform_vector3(u),
            v: self.place.transform_vector3(v),
            radiance,
            cone: None,
        });
    }

    /// Light from far away: all directions within the half angle `angle` of `towards`.
    pub(super) fn distant(&mut self, towards: DVec3, angle: f64, radiance: DVec3) {
        self.model.lights.push(Light {
            kind: LightKind::Distant,
            material: None,
            reach: f64::INFINITY,
            position: DVec3::ZERO,
            u: towards.normalize(),
            v: DVec3::X * libm::cos(angle),
            radiance,
            cone: None,
        });
    }

    /// The box from `lo` to `hi`: twelve triangles over eight vertices.
    pub(super) fn cuboid(&mut self, lo: DVec3, hi: DVec3, material: u16) {
        let corner = |i: usize| {
            let pick = |bit: usize, a: f64, b: f64| if i >> bit & 1 == 0 { a } else { b };
            DVec3::new(pick(0, lo.x, hi.x), pick(1, lo.y, hi.y), pick(2, lo.z, hi.z))
        };
        let v: [u32; 8] = std::array::from_fn(|i| self.vertex(corner(i)));
        for face in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            let [a, b, c, d] = face.map(|i| v[i]);
            self.triangle([a, b, c], [NO_NORMAL; 3], material);
            self.triangle([a, c, d], [NO_NORMAL; 3], material);
        }
    }

    pub(super) fn sphere(&mut self, center: DVec3, radius: f64, material: u16) {
        let center = self.place.transform_point3(center);
        let radius = radius * self.place.transform_vector3(DVec3::X).length();
        self.model.spheres.push(Sphere { center, radius, material, inward: false });
    }

    /// Triangles without shading normals, over shared vertices.
    pub(super) fn facets(&mut self, vertices: &[DVec3], triangles: &[[u32; 3]], material: u16) {
        let base = self.model.vertices.len() as u32;
        for &vertex in vertices {
            self.vertex(vertex);
        }
        for triangle in triangles {
            self.triangle(triangle.map(|i| base + i), [NO_NORMAL; 3], material);
        }
    }

    /// A smooth surface; `point(i, j)` gives place and normal (any length) at grid point `(i, j)`.
    /// The front is the side from which `i` runs right and `j` runs up.
    pub(super) fn patch(
        &mut self,
        patch: &Patch,
        material: impl Fn(u32, u32) -> u16,
        point: impl Fn(u32, u32) -> (DVec3, DVec3),
    ) {
        let [nu, nv] = patch.cells;
        let columns = nu + u32::from(!patch.closed[0]);
        let rows = nv + u32::from(!patch.closed[1]);
        let first_vertex = self.model.vertices.len() as u32;
        let first_normal = self.model.normals.len() as u32;
        // Normals turn by the inverse transpose; places here only turn and scale evenly or along their axes.
        let turn = self.place.matrix3.inverse().transpose();
        for j in 0..rows {
            for i in 0..columns {
                let (place, normal) = point(i, j);
                self.vertex(place);
                self.model.normals.push((turn * normal).normalize_or(DVec3::Z));
            }
        }
        for j in 0..nv {
            for i in 0..nu {
                let index = |i: u32, j: u32| (j % rows) * columns + i % columns;
                let cell = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
                for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                    let corners = [cell[a], cell[b], cell[c]];
                    let place =
                        |k: usize| self.model.vertices[(first_vertex + corners[k]) as usize];
                    // At a pole a side of the cell is a point.
                    if place(0) == place(1) || place(1) == place(2) || place(2) == place(0) {
                        continue;
                    }
                    self.triangle(
                        corners.map(|k| first_vertex + k),
                        corners.map(|k| first_normal + k),
                        material(i, j),
                    );
                }
            }
        }
    }

    /// The view from `eye` to `target`: the full vertical angle in degrees, and width over height.
    pub(super) fn view(&mut self, eye: DVec3, target: DVec3, degrees: f64, aspect: f64) {
        let half = libm::atan(aspect * libm::tan(degrees.to_radians() / 2.0));
        self.model.views.push(View {
            kind: ViewKind::Perspective,
            name: "default".into(),
            position: eye,
            direction: (target - eye).normalize(),
            up: DVec3::Z,
            size: [2.0 * half.to_degrees(), degrees],
            offset: [0.0; 2],
            clip: [0.0; 2],
        });
    }
}

fn named(name: &str) -> Material {
    Material { name: name.into(), ..Material::default() }
}

/// Matt paint.
pub(super) fn matt(name: &str, diffuse: [f64; 3]) -> Material {
    Material { diffuse: diffuse.into(), ..named(name) }
}

/// Paint under varnish: an uncoloured highlight of this reflectance and roughness.
pub(super) fn plastic(name: &str, diffuse: [f64; 3], specular: f64, roughness: f64) -> Material {
    Material { specular: DVec3::splat(specular), roughness, ..matt(name, diffuse) }
}

/// Metal: a coloured highlight.
pub(super) fn metal(name: &str, colour: [f64; 3], roughness: f64) -> Material {
    let colour = DVec3::from(colour);
    Material { diffuse: colour * 0.1, specular: colour * 0.85, roughness, ..named(name) }
}

/// A perfect mirror.
pub(super) fn mirror(name: &str, colour: [f64; 3]) -> Material {
    Material {
        kind: MaterialKind::Mirror,
        diffuse: DVec3::ZERO,
        specular: colour.into(),
        ..named(name)
    }
}

/// Solid glass; `absorption` per metre.
pub(super) fn solid_glass(name: &str, ior: f64, absorption: [f64; 3]) -> Material {
    Material {
        kind: MaterialKind::Dielectric,
        ior,
        diffuse: DVec3::ZERO,
        transmit: DVec3::ONE,
        absorption: absorption.into(),
        ..named(name)
    }
}

/// A thin pane.
pub(super) fn pane(name: &str, transmissivity: [f64; 3]) -> Material {
    Material {
        kind: MaterialKind::Glass,
        ior: 1.52,
        diffuse: DVec3::ZERO,
        transmit: transmissivity.into(),
        ..named(name)
    }
}

/// A lamp of this radiance [W / (m² sr)].
pub(super) fn light(name: &str, radiance: [f64; 3]) -> Material {
    Material {
        kind: MaterialKind::Light,
        diffuse: DVec3::ZERO,
        emission: radiance.into(),
        emitter: Emitter::Sampled { reach: f64::INFINITY, cone: None },
        ..named(name)
    }
}
