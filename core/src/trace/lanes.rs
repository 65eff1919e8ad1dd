use super::beam::Beam;
use super::group::{Crossings, Filled, GROUP, Group, Kind, Octet, Quad, Row, Verdict};
use super::stack::{Met, Places};
use super::turn::Turn;
use crate::block::format::{BlockHeader, Node, Record};
use crate::block::{BlockView, ExpandedNode, Vertices};
use crate::geometry::{PreparedRay, Ray};
use crate::real::{LANES, Part, Real};

/// What any lanes can compute.
pub trait Kernel {
    /// Does it. Is inlined, so that all of it is compiled for the instructions of its caller.
    fn run<L: Lanes>(self, lanes: L);
}

/// How boxes and triangles are tested: one by one, or as many at once as a vector unit takes.
///
/// An implementation is a value of no size that proves that the machine can do it. All operations
/// are small and inlined into the traversal.
pub trait Lanes: Copy {
    /// A ray in the frame of a block: a [`BoxFrame`](super::BoxFrame) in the form that [`Lanes::visit`] wants.
    type Frame: Copy;
    /// A frame in registers, as [`Lanes::visit_expanded`] wants it.
    type Spread: Copy;
    /// What is prepared of a ray once.
    type Ray: Copy;
    /// What samples of light are computed with.
    type Real: Real;

    /// Numbers of a row, from `first` on, which is a multiple of how many lanes there are.
    fn read(self, row: &[f32; LANES], first: usize) -> Self::Real;

    /// As [`read`](Self::read).
    fn read_whole(self, row: &[u32; LANES], first: usize) -> <Self::Real as Real>::Bits;

    /// `first` in the first lane, and one more in each.
    fn count_from(self, first: u32) -> <Self::Real as Real>::Bits;

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

    /// Takes a frame into registers, for the nodes from one leaf to the next: a leaf needs them all for itself.
    fn spread(self, frame: &Self::Frame) -> Self::Spread;

    /// Whether memory can be read ahead of what is done. Where not, nobody needs to find out what.
    const READS_AHEAD: bool = false;

    /// Has read what will probably be asked for, and goes on meanwhile.
    #[inline(always)]
    fn fetch<T>(self, _: &T) {}

    /// The same of so many [lines](ExpandedNode::LINE_BYTES) of a block, from one on.
    #[inline(always)]
    fn fetch_lines<const COUNT: usize>(self, _: &BlockView<'_>, _from: usize) {}

    /// Makes a frame anew after a call, where that takes less than to save it each time that there might be one.
    #[inline(always)]
    fn renew(self, _: &mut Self::Frame, _: &PreparedRay, _: &BlockHeader) {}

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
    /// are, and one that is met alone need not be: nothing asks for it but as [`Met::first`].
    fn visit_expanded(
        self,
        frame: &Self::Spread,
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

    /// Does a part in a function of its own, so that what it needs takes no registers of what goes on around it, and is not optimised with it; or else, if not
    /// so, where it stands.
    #[inline(always)]
    fn apart<P: Part>(self, so: bool, part: P) -> P::Result {
        #[inline(never)]
        fn outlined<P: Part>(part: P) -> P::Result {
            part.run()
        }
        // Where flash is dear, a function of its own takes more of it.
        if so && cfg!(feature = "bundles") { outlined(part) } else { part.run() }
    }

    /// Does what doubtful triangles take. Lanes for which they are rare keep it out of the traversal.
    #[inline(always)]
    fn in_doubt<R>(self, task: impl FnOnce() -> R) -> R {
        task()
    }

    /// So many rays of a group, at least, are tested against a triangle together, rather than each against the four of a record.
    const TOGETHER: usize = GROUP + 1;

    /// The kind of a ray, whatever it is.
    #[inline(always)]
    fn kind(self, ray: &Ray) -> Kind {
        Kind::of(ray)
    }

    /// Puts rays of a kind into the lanes of a group, in their order.
    #[inline(always)]
    fn fill(self, rays: &[Ray], members: &[u16], _: Kind, group: &mut Group) -> Filled {
        group.fill(rays, members)
    }

    /// Tests the first `count` rays of a list, lanes counted through all groups, against eight boxes, of which the planes are `near` and `far` that the
    /// rays meet first and last, by axis. `met` gets the slots that each ray meets; the slots that any meets are returned.
    ///
    /// Slots may be among them needlessly; none may be missing, by the argument of [`Group`].
    #[inline(always)]
    fn boxes(
        self,
        groups: &[Group],
        list: &[Octet],
        count: usize,
        (near, far): ([&Row; 3], [&Row; 3]),
        met: &mut [Octet],
    ) -> u8 {
        let mut all = 0;
        let places = met.as_flattened_mut().iter_mut();
        for (&id, met) in list.as_flattened().iter().take(count).zip(places) {
            let (group, lane) = (usize::from(id) / GROUP, usize::from(id) % GROUP);
            *met = groups.get(group).map_or(0, |group| group.slots(lane, near, far));
            all |= *met;
        }
        all
    }

    /// Puts those of the first `count` rays of a list into another that meet a slot. How many.
    #[inline(always)]
    fn select(
        self,
        list: &[Octet],
        met: &[Octet],
        count: usize,
        slot: usize,
        to: &mut [Octet],
    ) -> usize {
        let mut selected = 0;
        let to = to.as_flattened_mut();
        for (&id, met) in list.as_flattened().iter().zip(met.as_flattened()).take(count) {
            if let Some(to) = to.get_mut(selected) {
                *to = id;
            }
            selected += usize::from(met >> (slot & 7) & 1);
        }
        selected
    }

    /// A mask of slots by place, in a node of this order.
    #[inline(always)]
    fn by_place(self, turn: Turn, order: u32, slots: u8) -> u8 {
        turn.by_place(order, slots.into()) as u8
    }

    /// Decodes a record of triangles. `false`: it is not sound, or these lanes have no use for it.
    #[inline(always)]
    fn quad(self, _: Vertices<'_>, _: &Record, _: &mut Quad) -> bool {
        false
    }

    /// [`Lanes::record`] of a record that was decoded, for a lane of a group.
    #[inline(always)]
    fn quad_of(self, _: &Quad, _: &Group, _lane: usize, _: Kind, _: &mut Crossings) -> Verdict {
        Verdict { accepted: 0, doubtful: 0b1111 }
    }

    /// The lanes of a group of this kind that hit the triangle in a place of a record that was decoded, and those that must ask [`PreparedRay::triangle`].
    #[inline(always)]
    fn triangle(self, _: &Quad, _place: usize, _: &Group, _: Kind, _: &mut Crossings) -> Verdict {
        Verdict { accepted: 0, doubtful: 0xff }
    }

    /// The boxes that any ray of a beam may meet, by slot, and where the first ray enters each. None may be missing, by the argument of [`Beam`].
    #[inline(always)]
    fn beam(self, beam: &Beam, planes: ([&Row; 3], [&Row; 3]), enter: &mut Row) -> u8 {
        beam.meets(planes, enter)
    }

    /// The lanes of a group that meet the box of a slot. Lanes may be among them needlessly; none may be missing.
    #[inline(always)]
    fn meets(self, group: &Group, (near, far): ([&Row; 3], [&Row; 3]), slot: usize) -> u8 {
        let at = |rows: [&Row; 3]| rows.map(|row| row.get(slot & 7).copied().unwrap_or(0.0));
        group.meets(at(near), at(far))
    }
}
