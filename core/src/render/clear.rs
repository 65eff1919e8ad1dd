use crate::block::format::{Child, DEPTH_MAX, Record};
use crate::block::{BlockSource, BlockView};
use crate::geometry::{Aabb, Planes, PreparedRay, Primitive, Pyramid};
use crate::scene::Light;
use crate::shade::Shadow;
use crate::trace::{ClipFrame, primitives};
use glam::{DVec3, Vec3};

/// Boxes that are looked at before a bundle is taken for hidden and traced: the search may cost a fraction of the tracing at most.
const BOXES_MAX: u32 = 64;
/// Bundles of fewer rays are traced at once.
const RAYS_MIN: usize = 8;

/// Whether nothing lies between a bundle of shadow rays and its light, so that none of them need be traced.
///
/// The pyramid of the bundle ([`Pyramid::to_light`]) is clipped against the tree. What it touches may still
/// be the surface that the rays leave: a triangle is no obstacle if every ray begins off its plane by more than the triangle test's
/// error and goes away from it. `false` says nothing: something may be in the way, or the search became too long.
///
/// # Why no hit is lost
///
/// The pyramid touches every box and primitive that a ray of the bundle hits. A triangle that is left out is hit by none by the argument of
/// [`SurfacePoint::spawn`](crate::geometry::SurfacePoint::spawn), which holds for any triangle: the line of a ray that passes
/// the test comes within `TRIANGLE_ERROR * R` of it at a `t` that is less than zero here. It is checked for each
/// ray, in f64, where the rounding is 2⁻²⁹ of that.
pub(crate) fn is_clear<'a, S: BlockSource>(
    rays: impl ExactSizeIterator<Item = &'a Shadow> + Clone,
    light: &Light,
    source: &mut S,
) -> bool {
    if rays.len() < RAYS_MIN {
        return false;
    }
    let from = rays.clone().fold(Aabb::EMPTY, |from, ray| from.with(ray.ray().origin));
    let is_behind = |primitive: &Primitive| is_left_behind(rays.clone(), &from, primitive);
    holds_only(Pyramid::to_light(&from, light), source, is_behind)
}

/// Whether all that a pyramid touches is behind the rays in it. `false` says nothing.
pub(super) fn holds_only<S: BlockSource>(
    pyramid: Pyramid,
    source: &mut S,
    is_behind: impl FnMut(&Primitive) -> bool,
) -> bool {
    Search { pyramid, is_behind, boxes: 0 }.run(source).unwrap_or(false)
}

struct Search<F> {
    pyramid: Pyramid,
    is_behind: F,
    boxes: u32,
}

/// A node on the way down.
#[derive(Clone, Copy)]
struct Level {
    block: u32,
    node: u16,
    /// How many slots have been visited.
    next: u8,
    planes: Planes,
}

/// Why the search leaves a block.
enum Leave {
    /// For another one.
    Block,
    /// With an answer.
    Answer(bool),
}

impl<F: FnMut(&Primitive) -> bool> Search<F> {
    /// The answer; `None` if a block cannot be had or is not sound, which tracing will find out.
    fn run<S: BlockSource>(&mut self, source: &mut S) -> Option<bool> {
        let root = Level { block: 0, node: 0, next: 0, planes: Planes::ALL };
        let mut levels = [root; DEPTH_MAX];
        let mut depth = 0;
        loop {
            let block = levels.get(depth)?.block;
            let view = source.block(block).ok()?;
            match self.in_block(&view, &mut levels, &mut depth)? {
                Leave::Block => {}
                Leave::Answer(clear) => return Some(clear),
            }
        }
    }

    /// Goes on, depth first, as far as the block reaches.
    fn in_block(
        &mut self,
        view: &BlockView<'_>,
        levels: &mut [Level; DEPTH_MAX],
        depth: &mut usize,
    ) -> Option<Leave> {
        let frame = ClipFrame::new(view, &self.pyramid);
        let block = levels.get(*depth)?.block;
        loop {
            let level = levels.get_mut(*depth)?;
            if level.block != block {
                return Some(Leave::Block);
            }
            if level.next == 8 {
                match depth.checked_sub(1) {
                    Some(up) => *depth = up,
                    None => return Some(Leave::Answer(true)),
                }
                continue;
            }
            let node = view.node(level.node)?;
            let slot = level.next;
            level.next = level.next.saturating_add(1);
            let child = Child::decode(*node.child.get(usize::from(slot))?);
            if child == Child::Empty {
                continue;
            }
            self.boxes = self.boxes.saturating_add(1);
            if self.boxes > BOXES_MAX {
                return Some(Leave::Answer(false));
            }
            let (lo, hi) = frame.slot(node, slot)?;
            let Some(planes) = self.pyramid.clip_relative(lo, hi, frame.reach, level.planes) else {
                continue;
            };
            let below = match child {
                Child::Node(node) => Level { block, node, next: 0, planes },
                Child::Ref(index) => {
                    let to = view.reference(index)?;
                    Level { block: to.block, node: to.node, next: 0, planes }
                }
                Child::Leaf { at, count } => {
                    if self.is_obstructed(view, view.leaf(at, count), planes) {
                        return Some(Leave::Answer(false));
                    }
                    continue;
                }
                Child::Empty => continue,
            };
            *depth = depth.saturating_add(1);
            *levels.get_mut(*depth)? = below;
        }
    }

    /// Whether a primitive of a leaf may be in the way.
    fn is_obstructed(&mut self, view: &BlockView<'_>, records: &[Record], planes: Planes) -> bool {
        let Self { pyramid, is_behind, .. } = self;
        records.iter().any(|record| {
            primitives(view, record).any(|p| pyramid.touches(&p, planes) && !is_behind(&p))
        })
    }
}

/// Whether every ray, all from within a box, begins off a triangle's plane and goes away from it.
fn is_left_behind<'a>(
    mut rays: impl Iterator<Item = &'a Shadow>,
    from: &Aabb,
    primitive: &Primitive,
) -> bool {
    let Some(plane) = FacePlane::new(primitive) else { return false };
    let error = plane.error(from);
    rays.all(|shadow| {
        let ray = shadow.ray();
        let height = plane.height(ray.origin.as_dvec3());
        let away = plane.normal.dot(ray.direction.as_dvec3());
        // No NaN. What the box is too wide for, the ray's own origin may not be.
        height * away > 0.0
            && (plane.is_off(height, error)
                || plane.is_off(height, plane.error(&Aabb::EMPTY.with(ray.origin))))
    })
}

/// The plane of a triangle, or of several, and how near to it a ray may come without a chance of hitting them.
#[derive(Debug, Clone, Copy)]
pub(super) struct FacePlane {
    /// A point of it.
    point: Vec3,
    /// Of all their corners.
    bounds: Aabb,
    /// Not of unit length.
    normal: DVec3,
}

impl FacePlane {
    /// None at all.
    pub(super) const NOWHERE: Self =
        Self { point: Vec3::ZERO, bounds: Aabb::EMPTY, normal: DVec3::ZERO };

    /// `None` for other primitives, and for a triangle that is a line.
    pub(super) fn new(primitive: &Primitive) -> Option<Self> {
        let Primitive::Triangle { vertices, .. } = *primitive else { return None };
        let [v0, v1, v2] = vertices.map(Vec3::as_dvec3);
        let normal = (v1 - v0).cross(v2 - v0);
        let [point, ..] = vertices;
        let bounds = vertices.into_iter().fold(Aabb::EMPTY, Aabb::with);
        (normal.length_squared() > 0.0).then_some(Self { point, bounds, normal })
    }

    /// The same plane with its front to a point, if that lies farther off than the triangles' tests can err.
    pub(super) fn facing(self, point: Vec3) -> Option<Self> {
        let back = Self { normal: -self.normal, ..self };
        [self, back].into_iter().find(|plane| plane.is_before(point))
    }

    /// The box of the triangles.
    pub(super) const fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// How high a point stands above it, times the length of the normal.
    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.point.as_dvec3())
    }

    /// Whether a [height](Self::height), on either side, is farther off.
    fn is_off(&self, height: f64, by: f64) -> bool {
        // Of points in f32, what is squared lies between 1e-280 and 1e240.
        height * height > by * by * self.normal.length_squared()
    }

    /// Whether a point stands higher above it.
    pub(super) fn is_below(&self, point: DVec3, by: f64) -> bool {
        let height = self.height(point);
        height > 0.0 && self.is_off(height, by)
    }

    /// Takes a triangle in, if it lies in the very same plane: whether it does.
    pub(super) fn take_in(&mut self, primitive: &Primitive) -> bool {
        let Primitive::Triangle { vertices, .. } = *primitive else { return false };
        let same = vertices.iter().all(|v| self.height(v.as_dvec3()) == 0.0);
        if same {
            self.bounds = vertices.into_iter().fold(self.bounds, Aabb::with);
        }
        same
    }

    /// How far the tests of the triangles can err for rays from within a box.
    fn error(&self, from: &Aabb) -> f64 {
        const ERROR: f64 = PreparedRay::TRIANGLE_ERROR as f64 * 1.01;
        let below = from.max.as_dvec3() - self.bounds.min.as_dvec3();
        let above = self.bounds.max.as_dvec3() - from.min.as_dvec3();
        // Not less than zero: one of them is not, in each axis.
        ERROR * below.max(above).max_element()
    }

    /// Whether a point lies in front of it, farther off than the triangles' tests can err.
    pub(super) fn is_before(&self, point: Vec3) -> bool {
        self.is_below(point.as_dvec3(), self.error(&Aabb::EMPTY.with(point)))
    }
}
