#[cfg(feature = "bundles")]
use super::LightRows;
use super::path::is_seen;
use super::{Path, Point, SPLITS, Settings, Sum, Unit};
use crate::block::KiloView;
use crate::elementary::exp2;
use crate::geometry::{Hit, Ray};
use crate::light::Aim;
use crate::material::{Anew, Bsdf, Surface, Surfacing};
use crate::real::{Part, Real, Vector};
#[cfg(feature = "many-lights")]
use crate::scene::LightNode;
use crate::scene::{Light, LightKind, Material, MaterialKind, Needs};
use crate::store::{Arena, ArenaFull};
use core::f32::consts::LOG2_E;
use glam::Vec3;

/// The tables of a scene that shading reads.
#[derive(Debug, Clone, Copy)]
pub struct Tables<'a> {
    /// Materials; hits name them.
    pub materials: &'a [Material],
    /// Lights.
    pub lights: &'a [Light],
    /// Their tree, if they are very many.
    #[cfg(feature = "many-lights")]
    pub tree: &'a [LightNode],
    /// What the scene needs.
    pub needs: Needs,
}

impl<'a> Tables<'a> {
    /// The tables of a file.
    #[must_use]
    pub fn of(file: &KiloView<'a>) -> Self {
        let tables = Self::new(file.materials(), file.lights(), *file.needs());
        #[cfg(feature = "many-lights")]
        let tables = Self { tree: file.light_tree(), ..tables };
        tables
    }

    /// Tables of lights without a tree.
    #[must_use]
    pub const fn new(materials: &'a [Material], lights: &'a [Light], needs: Needs) -> Self {
        Self {
            materials,
            lights,
            #[cfg(feature = "many-lights")]
            tree: &[],
            needs,
        }
    }

    /// What [`copied`](Self::copied) takes of an arena \[bytes\].
    #[must_use]
    pub fn arena_bytes(&self) -> usize {
        let materials = Arena::bytes_of::<Material>(self.materials.len());
        let bytes = materials.saturating_add(Arena::bytes_of::<Light>(self.lights.len()));
        #[cfg(feature = "many-lights")]
        let bytes = bytes.saturating_add(Arena::bytes_of::<LightNode>(self.tree.len()));
        bytes
    }

    /// The same tables in the arena, as on a machine that has no other memory.
    ///
    /// # Errors
    /// [`ArenaFull`] if they do not fit.
    pub fn copied<'m>(&self, arena: &mut Arena<'m>) -> Result<Tables<'m>, ArenaFull> {
        let materials: &'m mut [Material] = arena.carve(self.materials.len())?;
        materials.iter_mut().zip(self.materials).for_each(|(to, from)| *to = *from);
        let lights: &'m mut [Light] = arena.carve(self.lights.len())?;
        lights.iter_mut().zip(self.lights).for_each(|(to, from)| *to = *from);
        let tables = Tables::new(materials, lights, self.needs);
        #[cfg(feature = "many-lights")]
        let tables = {
            let tree: &'m mut [LightNode] = arena.carve(self.tree.len())?;
            tree.iter_mut().zip(self.tree).for_each(|(to, from)| *to = *from);
            Tables { tree, ..tables }
        };
        Ok(tables)
    }
}

/// Shades what rays have hit. Holds nothing of its own: two of the same tables and settings are the same.
#[derive(Debug, Clone, Copy)]
pub struct Shader<'a> {
    pub(super) tables: Tables<'a>,
    pub(super) settings: Settings,
    unit: Unit,
    #[cfg(feature = "bundles")]
    pub(super) rows: Option<&'a LightRows>,
}

impl<'a> Shader<'a> {
    /// A shader of these tables.
    #[must_use]
    pub fn new(tables: Tables<'a>, settings: Settings) -> Self {
        Self {
            tables,
            settings,
            unit: Unit::new(tables.needs.radiance_max),
            #[cfg(feature = "bundles")]
            rows: None,
        }
    }

    /// The same shader, which looks at the lights of these rows together. They are those of its table.
    #[cfg(feature = "bundles")]
    #[must_use]
    pub const fn with_rows(self, rows: &'a LightRows) -> Self {
        Self { rows: Some(rows), ..self }
    }

    /// The lights that it looks at together.
    #[cfg(feature = "bundles")]
    pub(crate) const fn rows(&self) -> Option<&'a LightRows> {
        self.rows
    }

    /// The unit of its sums.
    #[must_use]
    pub const fn unit(&self) -> Unit {
        self.unit
    }

    /// The tables.
    #[must_use]
    pub const fn tables(&self) -> Tables<'a> {
        self.tables
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> Settings {
        self.settings
    }

    /// How often paths may still split from a ray of this depth on.
    #[must_use]
    pub fn splits(&self, depth: u32) -> usize {
        if !self.tables.needs.any(Needs::SPECULAR) {
            return 0;
        }
        u32::from(SPLITS.min(self.settings.bounces)).saturating_sub(depth) as usize
    }

    /// What a ray brings where it ends: the light emitted there, and the point that goes on, if the surface answers light.
    #[must_use]
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn arrive(&self, path: &Path, ray: &Ray, hit: Option<&Hit>) -> (Sum, Option<Point>) {
        self.arrive_at(path, ray, hit, Anew)
    }

    /// The same of surfaces that come from there.
    #[cfg_attr(feature = "bundles", inline(always))]
    pub(crate) fn arrive_at(
        &self,
        path: &Path,
        ray: &Ray,
        hit: Option<&Hit>,
        surfaces: impl Surfacing,
    ) -> (Sum, Option<Point>) {
        let Some(hit) = hit else { return (self.escaped(path, ray), None) };
        let Some(material) = self.tables.materials.get(usize::from(hit.material)) else {
            return (Sum::ZERO, None);
        };
        let kind = MaterialKind::from_u32(material.kind);
        let solid = matches!(kind, Some(MaterialKind::Light | MaterialKind::Mirror))
            || kind == Some(MaterialKind::Opaque) && material.transmit == [0.0; 3];
        let surface = surfaces.surface(ray, hit, !solid);
        // A path that meets a dielectric from inside has come through it, whether it knows or not.
        let inside = kind == Some(MaterialKind::Dielectric) && !surface.front;
        let medium = if inside && path.medium == Path::AIR { hit.material } else { path.medium };
        // Of a ray that goes straight on, what lies before its beginning has been counted.
        let way = surface.distance * (1.0 - ray.t_min / hit.t.max(f32::MIN_POSITIVE)).max(0.0);
        let passed = Vec3::from(self.absorbed(medium, way));
        let path = Path { throughput: path.throughput * passed, medium, ..*path };
        let sum = if material.emission == [0.0; 3] || !surface.front {
            Sum::ZERO
        } else {
            self.unit.quantise(path.throughput * self.emitted(&path, ray, &surface, material))
        };
        if kind == Some(MaterialKind::Light) {
            return (sum, None);
        }
        // Light samples bring a light that is not seen, an illum, whole: what is seen through it is the same light.
        let is_hidden = material.light != 0
            && path.shares_light()
            && surface.front
            && material.emission == [0.0; 3]
            && self.light_at(&surface, material).is_some();
        if is_hidden {
            return (Sum::ZERO, None);
        }
        let bsdf = Bsdf::new(material, &surface);
        let ahead = Ray { t_min: hit.t.next_up(), ..*ray };
        (sum, Some(Point::new(surface, bsdf, path, self.settings.bounces, ahead)))
    }

    /// The part of a surface's own light that this ray brings.
    fn emitted(&self, path: &Path, ray: &Ray, surface: &Surface, material: &Material) -> Vec3 {
        let emission = Vec3::from(material.emission);
        // Which of very many lights it is makes no difference, without a cone: all of a material have one, or none.
        #[cfg(feature = "many-lights")]
        if path.density == f32::INFINITY {
            let first = (material.light as usize).checked_sub(1);
            let first = first.and_then(|first| self.tables.lights.get(first));
            if first.is_none_or(|light| light.cone_cos <= -1.0) {
                return emission;
            }
        }
        let Some(light) = self.light_at(surface, material) else { return emission };
        if light.cone_cos > -1.0 && surface.outgoing.dot(light.cone.into()) < light.cone_cos {
            return Vec3::ZERO;
        }
        if path.density == f32::INFINITY || self.beyond_reach(light, ray) {
            return emission;
        }
        let sampled = Aim::density(light, ray.origin, -surface.outgoing, surface.distance);
        let part = Light::focal_part(light.focus, surface.distance);
        emission * part * self.share(path.density, sampled)
    }

    /// Light from infinitely far.
    fn escaped(&self, path: &Path, ray: &Ray) -> Sum {
        let mut sum = Sum::ZERO;
        // Behind an aft clipping plane there is nothing to see.
        if !self.tables.needs.any(Needs::DISTANT) || ray.t_max < f32::INFINITY {
            return sum;
        }
        let len = libm::sqrtf(ray.direction.dot(ray.direction));
        let direction = ray.direction / len;
        let passed = Vec3::from(self.absorbed(path.medium, f32::INFINITY));
        for light in self.tables.lights {
            if light.kind == LightKind::Distant as u32 && Aim::is_towards(light, direction) {
                let sampled = Aim::density(light, ray.origin, direction, f32::INFINITY);
                // One without such a reach is found by rays alone.
                let is_sampled = light.reach == f32::INFINITY;
                let part = if is_sampled { self.share(path.density, sampled) } else { 1.0 };
                let light = path.throughput * passed * Vec3::from(light.radiance) * part;
                sum.add(self.unit.quantise(light));
            }
        }
        sum
    }

    /// The light whose visible surface this is: of those of its material the nearest, if the surface lies on it. (Others may be of the material as well: the
    /// inside of a ball lights nothing.)
    fn light_at(&self, surface: &Surface, material: &Material) -> Option<&'a Light> {
        let first = (material.light as usize).checked_sub(1)?;
        let lights = self.tables.lights.get(first..)?;
        let index = u32::from(surface.material);
        let here = lights.iter().take_while(|light| light.material == index);
        let off = |light| (light, Aim::distance_to(light, surface.position));
        let nearer = |a: (_, f32), b: (_, f32)| if b.1 < a.1 { b } else { a };
        let (light, distance) = here.map(off).reduce(nearer)?;
        (distance <= Aim::size(light) * ON_IT).then_some(light)
    }

    /// Whether light sampling leaves out this light, for a ray that begins there.
    fn beyond_reach(&self, light: &Light, ray: &Ray) -> bool {
        let to = Aim::center(light) - ray.origin;
        libm::sqrtf(to.dot(to)) > light.reach || !is_seen(light, |material| self.emits(material))
    }

    /// Whether this material is a light's visible surface.
    pub(super) fn emits(&self, material: u32) -> bool {
        self.tables.materials.get(material as usize).is_some_and(|m| m.emission != [0.0; 3])
    }

    /// What is left of light after a way through a medium (Beer and Lambert).
    #[inline(always)]
    pub(super) fn absorbed<R: Real>(&self, medium: u16, distance: R) -> Vector<R> {
        match self.tables.materials.get(usize::from(medium)) {
            Some(material) if medium != Path::AIR => R::apart(Absorption { material, distance }),
            _ => Vector::same(distance, Vec3::ONE),
        }
    }
}

/// What lies farther off a light, in parts of its size, is not its surface: f32 knows places 10⁴ sizes away so well.
const ON_IT: f32 = 1.0 / 64.0;

/// What a way through a medium takes.
struct Absorption<'a, R> {
    material: &'a Material,
    distance: R,
}

impl<R: Real> Part for Absorption<'_, R> {
    type Result = Vector<R>;

    #[inline(always)]
    fn run(self) -> Vector<R> {
        let ([x, y, z], distance) = (self.material.absorption, self.distance);
        Vector { x: left(x, distance), y: left(y, distance), z: left(z, distance) }
    }
}

/// What is left of light after a distance in what absorbs so much of it.
#[inline(always)]
fn left<R: Real>(absorption: f32, distance: R) -> R {
    // No absorption is none at any distance, an infinite one too.
    if absorption > 0.0 { exp2(distance * (-LOG2_E * absorption)) } else { distance.same(1.0) }
}
