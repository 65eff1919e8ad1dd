use glam::Vec3;

/// A ray: the points `origin + t * direction` with `t_min <= t <= t_max`.
///
/// `direction` need not have unit length; `t` is in units of it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Ray {
    /// Where it starts, in scene coordinates.
    pub origin: Vec3,
    /// Where it goes.
    pub direction: Vec3,
    /// Least accepted `t`, at least 0.
    pub t_min: f32,
    /// Greatest accepted `t`; infinity for a ray without end.
    pub t_max: f32,
}

/// What a ray hit, with all that shading needs of it: the block it lies in may leave its frame.
///
/// Two hits are equal wherever they lie: what a hit is does not depend on how the scene is cut into blocks.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// Where on the ray.
    pub t: f32,
    /// Weights of vertices 1 and 2; vertex 0 has `1 - b1 - b2`. Zero for a sphere.
    pub b1: f32,
    /// See `b1`.
    pub b2: f32,
    /// Index into the scene's material table.
    pub material: u16,
    /// The primitive itself.
    pub primitive: Primitive,
    /// The block that it lies in.
    pub block: u32,
}

impl PartialEq for Hit {
    fn eq(&self, other: &Self) -> bool {
        let Self { t, b1, b2, material, primitive, block: _ } = self;
        (*t, *b1, *b2, *material, *primitive)
            == (other.t, other.b1, other.b2, other.material, other.primitive)
    }
}

/// A primitive by its own data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Primitive {
    /// A triangle, counter-clockwise seen from its front; normals per vertex as
    /// [octahedral](crate::block::octahedral) codes, `None` for a flat one.
    Triangle {
        /// The vertices in the order of the input.
        vertices: [Vec3; 3],
        /// Shading normals at the vertices.
        normals: Option<[u32; 3]>,
    },
    /// A sphere.
    Sphere {
        /// Its centre.
        center: Vec3,
        /// Its radius, above zero.
        radius: f32,
        /// The surface faces the centre (Radiance's bubble).
        inward: bool,
    },
}
