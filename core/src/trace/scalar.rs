use super::frame::{BoxFrame, BoxRay};
use super::lanes::Lanes;
use super::octant::{Octants, flip_of};
use crate::block::ExpandedNode;
use crate::block::format::{BlockHeader, Child, Node};
use crate::geometry::PreparedRay;

/// One box and one triangle at a time, with early outs: for any machine.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Scalar;

/// No child, whatever the axis bit.
const EMPTY: u16 = Child::Empty.encode();

impl Lanes for Scalar {
    type Frame = BoxFrame;
    type Ray = BoxRay;

    #[inline(always)]
    fn ray(self, ray: &PreparedRay) -> BoxRay {
        BoxRay::new(ray)
    }

    #[inline(always)]
    fn frame(self, ray: &BoxRay, header: &BlockHeader) -> BoxFrame {
        BoxFrame::new(ray, header)
    }

    #[inline(always)]
    fn slots(
        self,
        frame: &BoxFrame,
        node: &Node,
        t_min: f32,
        t_max: f32,
        near: &mut [f32; 8],
    ) -> u32 {
        slots(frame, &node.lo, &node.hi, &node.child, f32::from, t_min, t_max, near)
    }

    #[inline(always)]
    fn expanded_slots(
        self,
        frame: &BoxFrame,
        node: &ExpandedNode,
        t_min: f32,
        t_max: f32,
        near: &mut [f32; 8],
    ) -> u32 {
        slots(frame, &node.lo, &node.hi, &node.child, |q| q, t_min, t_max, near)
    }

    #[inline(always)]
    fn flip(self, octants: &Octants, node: &Node) -> u8 {
        flip_of(octants, node.axis_code())
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

/// The slots that a ray meets, with bounds that `float` makes numbers of.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a box test of two kinds of nodes")]
fn slots<T: Copy>(
    frame: &BoxFrame,
    lo: &[[T; 8]; 3],
    hi: &[[T; 8]; 3],
    child_bits: &[u16; 8],
    float: impl Fn(T) -> f32,
    t_min: f32,
    t_max: f32,
    near: &mut [f32; 8],
) -> u32 {
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
    let mut mask = 0;
    let sides = x0.iter().zip(x1).zip(y0.iter().zip(y1)).zip(z0.iter().zip(z1));
    for (slot, ((((x, y), z), near), child)) in sides.zip(near).zip(child_bits).enumerate() {
        if child & 0x7fff == EMPTY {
            continue;
        }
        let at = |q: &T, inv: f32, c: f32| float(*q) * inv + c;
        let enter = greater(at(x.0, ix, nx), t_min);
        let leave = lesser(at(x.1, ix, fx), t_max);
        if enter > leave {
            continue;
        }
        let enter = greater(at(y.0, iy, ny), enter);
        let leave = lesser(at(y.1, iy, fy), leave);
        if enter > leave {
            continue;
        }
        let enter = greater(at(z.0, iz, nz), enter);
        let leave = lesser(at(z.1, iz, fz), leave);
        if enter <= leave {
            mask |= 1 << slot;
            *near = enter;
        }
    }
    mask
}
