//! The choice among very many lights, by their tree.
//!
//! The line on which the [comb](super::Direct) lies is one of nodes that look small, and of single lights: nodes that look large are entered. Where teeth
//! fall on a node, the part of each child is that of its estimate in both; so a light below has a part of the line as well, and is chosen with a probability
//! that is known, at the cost of the nodes on the way to it. (Conty & Kulla 2018 choose likewise, with a number for each light that is asked.)

use super::direct::{Asked, leave_out};
use super::{Bundle, Counts, Direct, Point, Shader};
use crate::light::{Aim, Look, Seen};
use crate::scene::LightNode;
use crate::trace::Tracer;

/// A part of the line.
struct Part {
    node: u32,
    begin: f32,
    len: f32,
}

impl Shader<'_> {
    /// The length of the line.
    #[inline(never)]
    pub(super) fn length_of_tree(&self, point: &Point, answers: [bool; 2]) -> f32 {
        let (mut next, mut length) = (0, 0.0);
        while let Some(node) = self.node(next) {
            match self.look_at(node, point, answers) {
                Seen::Near => next = next.saturating_add(1),
                Seen::Dark(_) => next = node.end(next),
                Seen::Far(estimate) => {
                    length += estimate;
                    next = node.end(next);
                }
            }
        }
        length
    }

    /// [`Shader::next_bundle`] of a scene that has a tree.
    #[inline(never)]
    pub(super) fn next_of_tree<T: Tracer>(
        &self,
        tracer: T,
        point: &Point,
        direct: &mut Direct,
        counts: &mut Counts,
    ) -> Option<Bundle> {
        let answers = direct.answers;
        while let Some(node) = self.node(direct.next) {
            let seen = self.look_at(node, point, answers);
            let leaves = node.end(direct.next).saturating_sub(direct.next).saturating_add(1) / 2;
            let len = match seen {
                Seen::Far(estimate) => estimate,
                Seen::Near => {
                    direct.next = direct.next.saturating_add(1);
                    continue;
                }
                Seen::Dark(dark) => {
                    leave_out(dark, leaves, counts);
                    direct.next = node.end(direct.next);
                    continue;
                }
            };
            let end = direct.at + len;
            if end > direct.tooth {
                let whole = Part { node: direct.next, begin: direct.at, len };
                let part = self.below(whole, direct.tooth, point, answers);
                direct.pass(part.begin + part.len);
                let chosen = self.node(part.node).and_then(|node| {
                    let index = node.light()?;
                    let light = self.tables.lights.get(index as usize)?;
                    let aim = Aim::new(light, &point.surface, answers).ok()?;
                    Some((index, light, aim))
                });
                if let Some((index, light, mut aim)) = chosen {
                    direct.asked = direct.asked.saturating_add(1);
                    let asked = Asked {
                        probability: (part.len / direct.spacing).min(1.0),
                        part: (part.len / direct.total).min(1.0),
                    };
                    return Some(self.bundle(tracer, point, (index, light), &mut aim, asked));
                }
                continue;
            }
            let passed = leaves.saturating_sub(direct.asked);
            counts.lights_by_chance = counts.lights_by_chance.saturating_add(passed.into());
            (direct.next, direct.at, direct.asked) = (node.end(direct.next), end, 0);
        }
        None
    }

    /// The light below a part of the line on which a place of it falls, or a node whose lights are dark.
    fn below(&self, mut part: Part, place: f32, point: &Point, answers: [bool; 2]) -> Part {
        while let Some(node) = self.node(part.node)
            && node.light().is_none()
        {
            let first = part.node.saturating_add(1);
            let second = self.node(first).map_or(first, |node| node.end(first));
            let [a, b] = [first, second].map(|child| {
                let Some(node) = self.node(child) else { return 0.0 };
                match self.look_at(node, point, answers) {
                    Seen::Far(estimate) => estimate,
                    Seen::Near => node.near(&point.surface),
                    Seen::Dark(_) => 0.0,
                }
            });
            let both = a + b;
            let is_dark = both.is_nan() || both <= 0.0;
            if is_dark {
                break;
            }
            let len = part.len * (a / both);
            let is_first = b <= 0.0 || a > 0.0 && place < part.begin + len;
            part = if is_first {
                Part { node: first, len, ..part }
            } else {
                Part { node: second, begin: part.begin + len, len: part.len * (b / both) }
            };
        }
        part
    }

    fn node(&self, index: u32) -> Option<&LightNode> {
        self.tables.tree.get(index as usize)
    }

    /// What a node shows; of a leaf what it is worth.
    fn look_at(&self, node: &LightNode, point: &Point, answers: [bool; 2]) -> Seen {
        let surface = &point.surface;
        let Some(light) = node.light() else { return node.look(surface, answers) };
        let Some(light) = self.tables.lights.get(light as usize) else {
            return Seen::Dark(crate::light::Dark::Void);
        };
        match Look::new(light, surface, answers).seen() {
            Seen::Near => match Aim::new(light, surface, answers) {
                Ok(aim) => Seen::Far(aim.estimate),
                Err(dark) => Seen::Dark(dark),
            },
            seen => seen,
        }
    }
}
