use super::beam::{BeamFrame, Planes};
use super::group::{Corners, Crossings, Group, Sides, Verdict};
use super::stack::{Met, Places};
use super::turn::Turn;
use crate::block::format::{BlockHeader, Node, Record};
use crate::block::{ExpandedNode, Vertices};
use crate::geometry::{PreparedRay, Ray};

/// A part of a search. (A closure would be compiled without the instructions of the lanes.)
pub trait Part {
    /// What comes of it.
    type Result;

    /// Does it. Is inlined, so that all of it is compiled for the instructions of its caller.
    fn run(self) -> Self::Result;
}

/// How boxes and triangles are tested: one by one, or as many at once as a vector unit takes.
///
/// An implementation is a value of no size that proves that the machine can do it. All operations
/// are small and inlined into the traversal.
pub trait Lanes: Copy {
    /// A ray in the frame of a block: a [`BoxFrame`](super::BoxFrame) in the form that [`Lanes::visit`] wants.
    type Frame: Copy;
    /// What is prepared of a ray once.
    type Ray: Copy;

    /// What these lanes want of a ray.
    fn ray(self, ray: &PreparedRay) -> Self::Ray;

    /// Prepares a ray in its place, by [`PreparedRay::of`], and what these lanes want of it. `None`: it can hit nothing.
    #[inline(always)]
    fn prepare(self, ray: &Ray, to: &mut PreparedRay) -> Option<Self::Ray> {
        *to = PreparedRay::of(ray)?;
        Some(self.ray(to))
    }

    /// The ray in the frame of the block with this header: [`BoxFrame::new`](super::BoxFrame::new), but for the last bits.
    fn frame(self, ray: &Self::Ray, header: &BlockHeader) -> Self::Frame;

    /// Puts down the children that the ray meets between the two of `span`, in the order of its turn, at the end of the eight places: where it
    /// enters each, and its bits, its place in the order from bit 16 on, and `tag`.
    ///
    /// Children may be among them needlessly; none may be missing, by the argument of [`BoxFrame`](super::BoxFrame), and none of an empty slot.
    fn visit(
        self,
        frame: &Self::Frame,
        node: &Node,
        turn: Turn,
        span: (f32, f32),
        tag: u32,
        to: Places<'_>,
    ) -> Met;

    /// [`Lanes::visit`] of an expanded node, in the frame [`ExpandedTop::FRAME`](crate::block::ExpandedTop::FRAME): its children are put down as they
    /// are.
    fn visit_expanded(
        self,
        frame: &Self::Frame,
        node: &ExpandedNode,
        turn: Turn,
        span: (f32, f32),
        to: Places<'_>,
    ) -> Met;

    /// The triangles of a record that a ray hits, by place, and those that must ask [`PreparedRay::triangle`].
    #[inline(always)]
    fn record(
        self,
        _: &Self::Ray,
        _: Vertices<'_>,
        _: &Record,
        _t_max: f32,
        _: &mut Crossings,
    ) -> Verdict {
        Verdict { accepted: 0, doubtful: 0b1111 }
    }

    /// Does a part in a function of its own, so that what it needs takes no registers of what goes on around it.
    #[inline(always)]
    fn apart<P: Part>(self, part: P) -> P::Result {
        part.run()
    }

    /// Does what doubtful triangles take. Lanes for which they are rare keep it out of the traversal.
    #[inline(always)]
    fn in_doubt<R>(self, task: impl FnOnce() -> R) -> R {
        task()
    }

    /// The mask of a node's slots that any ray of a bundle may meet between `t_min` and `t_max`; `planes` get all slots. No slot may be missing, by the
    /// argument of [`Beam`](super::Beam).
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
