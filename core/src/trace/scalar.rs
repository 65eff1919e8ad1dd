use super::frame::{BoxFrame, BoxRay};
use super::lanes::Lanes;
use super::stack::{Met, Places};
use super::turn::Turn;
use crate::block::format::{BlockHeader, Child, Node};
use crate::block::{ExpandedNode, ExpandedTop};
use crate::geometry::PreparedRay;
use crate::real::LANES;

/// One box and one triangle at a time, with early outs: for any machine.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Scalar;

impl Lanes for Scalar {
    type Frame = BoxFrame;
    type Spread = BoxFrame;
    type Ray = BoxRay;
    type Real = f32;

    #[inline(always)]
    fn read(self, row: &[f32; LANES], first: usize) -> f32 {
        row.get(first).copied().unwrap_or(0.0)
    }

    #[inline(always)]
    fn read_whole(self, row: &[u32; LANES], first: usize) -> u32 {
        row.get(first).copied().unwrap_or(0)
    }

    #[inline(always)]
    fn count_from(self, first: u32) -> u32 {
        first
    }

    #[inline(always)]
    fn ray(self, ray: &PreparedRay) -> BoxRay {
        BoxRay::new(ray)
    }

    #[inline(always)]
    fn frame(self, ray: &BoxRay, header: &BlockHeader) -> BoxFrame {
        BoxFrame::new(ray, header)
    }

    #[inline(always)]
    fn spread(self, frame: &BoxFrame) -> BoxFrame {
        *frame
    }

    #[inline(always)]
    fn visit(
        self,
        frame: &BoxFrame,
        node: &Node,
        turn: Turn,
        span: (f32, f32),
        tag: u32,
        to: Places<'_>,
    ) -> Met {
        let order = turn.of_node(&node.order);
        visit(frame, (&node.lo, &node.hi), f32::from, turn, order, span, to, |slot, place| {
            let child = node.child.get(slot & 7).copied().unwrap_or(Child::EMPTY);
            (child != Child::EMPTY).then_some(u32::from(child) | place << 16 | tag)
        })
    }

    #[inline(always)]
    fn visit_expanded(
        self,
        frame: &BoxFrame,
        node: &ExpandedNode,
        turn: Turn,
        span: (f32, f32),
        to: Places<'_>,
    ) -> Met {
        let order = turn.of_node(&node.order);
        visit(
            frame,
            (&node.lo, &node.hi),
            |q| q,
            turn,
            order,
            span,
            to,
            |slot, _| {
                node.child.get(slot & 7).copied().filter(|&child| child != ExpandedTop::EMPTY)
            },
        )
    }
}

#[inline(always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// [`Lanes::visit`], with bounds that `float` makes numbers of, and the entry of the child in a slot and place.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a box test of two kinds of nodes")]
fn visit<T: Copy>(
    frame: &BoxFrame,
    (lo, hi): (&[[T; 8]; 3], &[[T; 8]; 3]),
    float: impl Fn(T) -> f32,
    turn: Turn,
    order: u32,
    (t_min, t_max): (f32, f32),
    mut to: Places<'_>,
    entry: impl Fn(usize, u32) -> Option<u32>,
) -> Met {
    let planes = |axis: usize| {
        let [lo, hi] = [lo, hi].map(|p| match axis {
            0 => &p[0],
            1 => &p[1],
            _ => &p[2],
        });
        if frame.inv.get(axis).is_some_and(|&i| i < 0.0) { (hi, lo) } else { (lo, hi) }
    };
    let ((x0, x1), (y0, y1), (z0, z1)) = (planes(0), planes(1), planes(2));
    let [ix, iy, iz] = frame.inv;
    let [nx, ny, nz] = frame.near;
    let [fx, fy, fz] = frame.far;
    let mut met = Met { count: 0, first: 0, lines: 0 };
    // The last first, so that the first comes to lie before all others.
    for place in (0..8).rev() {
        let slot = turn.slot(order, place);
        let Some(entry) = entry(slot, place) else { continue };
        let at = |side: &[T; 8], inv: f32, c: f32| {
            side.get(slot & 7).map_or(f32::NAN, |&q| float(q) * inv + c)
        };
        let enter = greater(at(x0, ix, nx), t_min);
        let leave = lesser(at(x1, ix, fx), t_max);
        if enter > leave {
            continue;
        }
        let enter = greater(at(y0, iy, ny), enter);
        let leave = lesser(at(y1, iy, fy), leave);
        if enter > leave {
            continue;
        }
        let enter = greater(at(z0, iz, nz), enter);
        let leave = lesser(at(z1, iz, fz), leave);
        if enter <= leave {
            let free = 7 - (met.count & 7) as usize;
            if let Some(near) = to.near.as_mut().and_then(|near| near.get_mut(free)) {
                *near = enter;
            }
            if let Some(place) = to.entry.get_mut(free) {
                *place = entry;
            }
            met = Met { count: met.count + 1, first: entry, lines: 0 };
        }
    }
    met
}
