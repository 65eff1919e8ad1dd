use super::beam::{BeamFrame, Planes};
use super::group::{Corners, Crossings, Group, Sides, Verdict};
use super::octant::Octants;
use crate::block::ExpandedNode;
use crate::block::format::{BlockHeader, Node, Record};
use crate::geometry::PreparedRay;

/// How boxes and triangles are tested: one by one, or as many at once as a vector unit takes.
///
/// An implementation is a value of no size that proves that the machine can do it. All operations
/// are small and inlined into the traversal.
pub trait Lanes: Copy {
    /// A ray in the frame of a block: a [`BoxFrame`](super::BoxFrame) in the form that [`Lanes::slots`] wants.
    type Frame: Copy;
    /// What is prepared of a ray once.
    type Ray: Copy;

    /// Prepares a ray.
    fn ray(self, ray: &PreparedRay) -> Self::Ray;

    /// The ray in the frame of the block with this header: [`BoxFrame::new`](super::BoxFrame::new), but for the last bits.
    fn frame(self, ray: &Self::Ray, header: &BlockHeader) -> Self::Frame;

    /// The mask of a node's slots that the ray meets between `t_min` and `t_max`; `near` gets where, by
    /// slot, for those that are in the mask.
    ///
    /// Slots may be in the mask needlessly, empty ones too; none may be missing, by the argument
    /// of [`BoxFrame`](super::BoxFrame).
    fn slots(
        self,
        frame: &Self::Frame,
        node: &Node,
        t_min: f32,
        t_max: f32,
        near: &mut [f32; 8],
    ) -> u32;

    /// [`Lanes::slots`] of an expanded node, in the frame [`ExpandedTop::FRAME`](crate::block::ExpandedTop::FRAME).
    fn expanded_slots(
        self,
        frame: &Self::Frame,
        node: &ExpandedNode,
        t_min: f32,
        t_max: f32,
        near: &mut [f32; 8],
    ) -> u32;

    /// The flip of a node: bits of the slot whose axis the ray descends.
    fn flip(self, octants: &Octants, node: &Node) -> u8;

    /// The triangles of a record that a ray hits, by place, and those that must ask [`PreparedRay::triangle`].
    ///
    /// `words` are the [vertices of the block](crate::block::BlockView::vertex_words).
    #[inline(always)]
    fn record(
        self,
        _: &Self::Ray,
        _: &[f32],
        _: &Record,
        _t_max: f32,
        _: &mut Crossings,
    ) -> Verdict {
        Verdict { accepted: 0, doubtful: 0b1111 }
    }

    /// Does what doubtful triangles take. Lanes for which they are rare keep it out of the traversal.
    #[inline(always)]
    fn in_doubt<R>(self, task: impl FnOnce() -> R) -> R {
        task()
    }

    /// The mask of a node's slots that any ray of a bundle may meet between `t_min` and `t_max`, as [`Lanes::slots`]; `planes` get
    /// all slots.
    #[inline(always)]
    fn beam(
        self,
        beam: &BeamFrame,
        node: &Node,
        t_min: f32,
        t_max: f32,
        planes: &mut Planes,
    ) -> u32 {
        beam.slots(node, t_min, t_max, planes)
    }

    /// The lanes of a group that meet a box. Lanes may be in it needlessly.
    #[inline(always)]
    fn meets(self, group: &Group, sides: &Sides) -> u32 {
        group.meets(sides)
    }

    /// The lanes of a group that hit a triangle, and those that must ask [`PreparedRay::triangle`].
    #[inline(always)]
    fn triangle(self, _: &Group, _: &Corners, _: &mut Crossings) -> Verdict {
        Verdict { accepted: 0, doubtful: 0xff }
    }
}
