//! Rays against boxes: one against eight, or eight against one.

use kiloray_core::trace::{BoxFrame, Group, Met, Places, Row, Turn};

use super::fused::fused;

/// Where rays enter and leave boxes: they meet those that they enter no later than they leave them.
pub(super) struct Hits {
    enter: Row,
    leave: Row,
}

/// A number for each of eight. (`array::from_fn` is not made of vectors.)
#[inline(always)]
pub(super) fn each<T: Copy + Default>(of: impl Fn(usize) -> T) -> [T; 8] {
    let mut all = [T::default(); 8];
    for (i, one) in all.iter_mut().enumerate() {
        *one = of(i);
    }
    all
}

/// A ray and the boxes between these planes.
#[inline(always)]
pub(super) fn of_ray(
    frame: &BoxFrame,
    (near, far): ([&Row; 3], [&Row; 3]),
    span: (f32, f32),
) -> Hits {
    let BoxFrame { inv: [ix, iy, iz], near: [nx, ny, nz], far: [fx, fy, fz] } = *frame;
    let t = |planes: &Row, inv: f32, add: f32| each(|slot| fused(planes[slot], inv, add));
    Hits::new(
        [t(near[0], ix, nx), t(near[1], iy, ny), t(near[2], iz, nz)],
        [t(far[0], ix, fx), t(far[1], iy, fy), t(far[2], iz, fz)],
        (&[span.0; 8], &[span.1; 8]),
    )
}

/// The rays of a group and the box between these planes.
#[inline(always)]
pub(super) fn of_group(group: &Group, (near, far): ([f32; 3], [f32; 3])) -> Hits {
    let Group { inv: [ix, iy, iz], near: [nx, ny, nz], far: [fx, fy, fz], .. } = group;
    let t = |plane: f32, inv: &Row, add: &Row| each(|lane| fused(plane, inv[lane], add[lane]));
    Hits::new(
        [t(near[0], ix, nx), t(near[1], iy, ny), t(near[2], iz, nz)],
        [t(far[0], ix, fx), t(far[1], iy, fy), t(far[2], iz, fz)],
        (&group.t_min, &group.t_max),
    )
}

/// The greater as a whole number, as AVX2 lanes have it: see there.
#[inline(always)]
pub(super) fn greater(a: f32, b: f32) -> f32 {
    let whole = |x: f32| x.to_bits() as i32;
    if whole(a) > whole(b) { a } else { b }
}

/// The lesser, likewise.
#[inline(always)]
pub(super) fn lesser(a: f32, b: f32) -> f32 {
    let whole = |x: f32| x.to_bits() as i32;
    if whole(a) < whole(b) { a } else { b }
}

/// The lanes of which it is true, a bit each.
#[inline(always)]
pub(super) fn mask(count: usize, is: impl Fn(usize) -> bool) -> u32 {
    (0..count).fold(0, |mask, lane| mask | u32::from(is(lane)) << lane)
}

impl Hits {
    /// Of the `t` at which planes are met, by axis.
    #[inline(always)]
    fn new([x0, y0, z0]: [Row; 3], [x1, y1, z1]: [Row; 3], (t_min, t_max): (&Row, &Row)) -> Self {
        Self {
            enter: each(|i| greater(greater(x0[i], y0[i]), greater(z0[i], t_min[i]))),
            leave: each(|i| lesser(lesser(x1[i], y1[i]), lesser(z1[i], t_max[i]))),
        }
    }

    /// What is met.
    #[inline(always)]
    pub(super) fn mask(&self) -> u8 {
        mask(8, |lane| self.enter[lane] <= self.leave[lane]) as u8
    }

    /// The children that are met, put down in the order of a ray: `entry` is that of a slot and its place.
    #[inline(always)]
    pub(super) fn put_down(
        &self,
        turn: Turn,
        order: u32,
        mut to: Places<'_>,
        entry: impl Fn(usize, u32) -> u32,
    ) -> Met {
        let mut met = Met { count: 0, first: 0, lines: 0 };
        let slots = self.mask();
        if slots == 0 {
            return met;
        }
        // The last first, so that the first comes to lie before all others.
        for place in (0..8).rev() {
            let slot = turn.slot(order, place) & 7;
            if slots >> slot & 1 == 1 {
                let free = 7 - (met.count & 7) as usize;
                let entry = entry(slot, place);
                to.entry[free] = entry;
                if let Some(near) = &mut to.near {
                    near[free] = self.enter[slot];
                }
                met = Met { count: met.count + 1, first: entry, lines: 0 };
            }
        }
        met
    }
}
