use crate::block::format::{Child, DEPTH_MAX};
use crate::block::{BlockSource, BlockView};
use crate::geometry::{Aabb, Planes, PreparedRay, Primitive, Pyramid};
use crate::scene::Light;
use crate::shade::Shadow;
use crate::trace::{ClipFrame, primitives};
use glam::Vec3;

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
    let pyramid = Pyramid::to_light(&from, light);
    let mut search = Search { pyramid, rays, boxes: 0 };
    search.run(source).unwrap_or(false)
}

struct Search<R> {
    pyramid: Pyramid,
    rays: R,
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

impl<'a, R: Iterator<Item = &'a Shadow> + Clone> Search<R> {
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
                Child::Leaf { first, count } => {
                    if self.is_obstructed(view, first, count, planes) {
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
    fn is_obstructed(&self, view: &BlockView<'_>, first: u16, count: u16, planes: Planes) -> bool {
        (first..first.saturating_add(count)).filter_map(|index| view.record(index)).any(|record| {
            primitives(view, record)
                .any(|p| self.pyramid.touches(&p, planes) && !self.is_left_behind(&p))
        })
    }

    /// Whether every ray begins off a triangle's plane and goes away from it.
    fn is_left_behind(&self, primitive: &Primitive) -> bool {
        let Primitive::Triangle { vertices, .. } = primitive else { return false };
        let [v0, v1, v2] = vertices.map(Vec3::as_dvec3);
        let normal = (v1 - v0).cross(v2 - v0);
        let length = libm::sqrt(normal.length_squared());
        let error = f64::from(PreparedRay::TRIANGLE_ERROR) * 1.01;
        length > 0.0
            && self.rays.clone().all(|shadow| {
                let ray = shadow.ray();
                let o = ray.origin.as_dvec3();
                let far = (v0 - o).abs().max((v1 - o).abs()).max((v2 - o).abs()).max_element();
                let height = normal.dot(o - v0);
                let along = normal.dot(ray.direction.as_dvec3());
                // On the same side, and no NaN.
                height.abs() > error * far * length
                    && (height > 0.0 && along > 0.0 || height < 0.0 && along < 0.0)
            })
    }
}
