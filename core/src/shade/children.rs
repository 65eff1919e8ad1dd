use super::point::SPLITS;
use super::{Counts, Path, Point, Shader};
use crate::geometry::Ray;
use crate::material::Side;
use crate::random::{Purpose, Sequence};

/// A specular ray that a point sends, and its path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Child {
    /// The ray.
    pub ray: Ray,
    /// What it carries.
    pub path: Path,
}

impl Shader<'_> {
    /// The specular rays of a point: the reflected one, and the transmitted one.
    ///
    /// Up to the second bounce a point sends both; beyond it chooses one, in proportion to what they bring. Where that is little of the pixel it
    /// is left to chance whether they are sent at all. What is sent stands for what is not, so the mean does not change.
    #[must_use]
    pub fn children(&self, point: &Point, counts: &mut Counts) -> [Option<Child>; 2] {
        let [front, back] = point.chance;
        if front + back <= 0.0 {
            let gloss = &point.bsdf.gloss;
            let any = gloss.reflect.max_element() > 0.0 || gloss.transmit.max_element() > 0.0;
            counts.specular_too_deep += u64::from(any);
            return [None; 2];
        }
        let key = point.path.key;
        // Chances of 0 and 1 need no number.
        let certain = [front, back].iter().all(|&chance| chance <= 0.0 || chance >= 1.0);
        let [a, b] = match certain {
            true => [0.0; 2],
            false => Sequence::new(key, Purpose::Children).point(key.sample),
        };
        let sent = if point.path.depth < SPLITS {
            [a < front, b < back]
        } else {
            [a < front, a >= front && a < front + back]
        };
        let mut children = [None; 2];
        let sides = [Side::Front, Side::Back].into_iter().zip([front, back]).zip(sent);
        for (slot, ((side, chance), sent)) in children.iter_mut().zip(sides) {
            if sent {
                *slot = self.child(point, side, chance);
            } else if chance > 0.0 {
                counts.specular_by_chance += 1;
            }
        }
        children
    }

    fn child(&self, point: &Point, side: Side, chance: f32) -> Option<Child> {
        let Point { surface, bsdf, path, .. } = point;
        let (purpose, index) = match side {
            Side::Front => (Purpose::Reflect, 0),
            Side::Back => (Purpose::Transmit, 1),
        };
        let numbers = || Sequence::new(path.key, purpose).point(path.key.sample);
        let (direction, weight, density) = bsdf.sample(surface, side, numbers)?;
        let medium = match side {
            Side::Back if bsdf.gloss.crosses && surface.front => surface.material,
            Side::Back if bsdf.gloss.crosses => Path::AIR,
            _ => path.medium,
        };
        let throughput = path.throughput * weight / chance;
        if throughput.max_element().is_nan() || throughput.max_element() <= 0.0 {
            return None;
        }
        // What a ray finds that shares its light with shadow rays, it shares behind a pane as well, as they pass it: it is the same ray, from the same origin.
        let is_straight = side == Side::Back && bsdf.gloss.is_straight();
        let (ray, density) = if is_straight && path.shares_light() {
            (point.ahead, path.density)
        } else {
            let origin = surface.origin(direction);
            // What is seen through a surface ends where it would end without.
            let Ray { t_min, t_max, .. } = point.ahead;
            let t_max = match side {
                Side::Front => f32::INFINITY,
                Side::Back => (t_max - t_min).max(0.0),
            };
            (Ray { origin, direction, t_min: 0.0, t_max }, density * chance)
        };
        Some(Child {
            ray,
            path: Path {
                key: path.key.child(index),
                throughput,
                density,
                depth: path.depth.saturating_add(1),
                medium,
            },
        })
    }
}
