//! Boxes, as Radiance's `genbox` makes them: plain, bevelled or rounded, from the origin upwards.

use glam::DVec3;

use super::kinds::Shape;
use crate::import::Cause;
use crate::import::error::syntax;
use crate::import::scan::{number, shown};

/// A box to make.
#[derive(Debug)]
pub(super) struct Box {
    pub(super) modifier: Vec<u8>,
    size: DVec3,
    inward: bool,
    edge: Edge,
    /// How round edges are cut was given (`-n`, `-s`): here they are round.
    pub(super) facets: bool,
}

/// Takes a surface: its shape and its numbers.
type Emit<'a> = &'a mut dyn FnMut(Shape, &[f64]) -> Result<(), Cause>;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Edge {
    Sharp,
    Bevelled(f64),
    Round(f64),
}

impl Box {
    /// Takes the arguments of a `genbox` command.
    pub(super) fn parse(arguments: &[Vec<u8>]) -> Result<Self, Cause> {
        let usage = "genbox takes: material name x y z [-i] [-b bevel | -r round]";
        let [modifier, _, x, y, z, options @ ..] = arguments else { return Err(syntax(usage)) };
        let size = DVec3::new(number(x)?, number(y)?, number(z)?);
        if size.min_element() <= 0.0 {
            return Err(syntax("genbox: a size is not above zero"));
        }
        let (mut inward, mut edge, mut facets) = (false, Edge::Sharp, false);
        let mut rest = options.iter();
        while let Some(option) = rest.next() {
            let mut value = || number(rest.next().ok_or_else(|| syntax(usage))?);
            match option.as_slice() {
                b"-i" => inward = true,
                b"-b" => edge = Edge::Bevelled(value()?),
                b"-r" => edge = Edge::Round(value()?),
                b"-n" => {
                    value()?;
                    facets = true;
                }
                b"-s" => facets = true,
                b"-o" => {
                    return Err(syntax(
                        "genbox -o writes a Wavefront mesh: leave it out, or save the mesh as an .obj file and name that",
                    ));
                }
                other => {
                    return Err(syntax(format!(
                        "genbox: the option `{}` is not known",
                        shown(other)
                    )));
                }
            }
        }
        if let Edge::Bevelled(r) | Edge::Round(r) = edge {
            if r == 0.0 {
                edge = Edge::Sharp;
            } else if !(r > 0.0 && r * 2.0 <= size.min_element()) {
                return Err(syntax("genbox: the edge is below zero, or more than half of a side"));
            } else if inward && matches!(edge, Edge::Round(_)) {
                return Err(syntax("genbox: -i with -r is not built in; use -b, or leave one out"));
            }
        }
        Ok(Self { modifier: modifier.clone(), size, inward, edge, facets })
    }

    /// Makes the surfaces, as shapes and their numbers.
    pub(super) fn make(&self, emit: Emit<'_>) -> Result<(), Cause> {
        let inset = match self.edge {
            Edge::Sharp => 0.0,
            Edge::Bevelled(r) | Edge::Round(r) => r,
        };
        for [a, u, v] in TURNS {
            for side in SIDES {
                let corner = |su, sv| self.at([(a, side, 0.0), (u, su, inset), (v, sv, inset)]);
                let corners =
                    [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                self.polygon(&corners, DVec3::AXES[a] * side, emit)?;
            }
        }
        match self.edge {
            Edge::Sharp => Ok(()),
            Edge::Bevelled(r) => self.bevels(r, emit),
            Edge::Round(r) => self.rounds(r, emit),
        }
    }

    fn bevels(&self, r: f64, emit: Emit<'_>) -> Result<(), Cause> {
        for [a, u, v] in TURNS {
            for (su, sv) in SIDES.into_iter().flat_map(|u| SIDES.map(|v| (u, v))) {
                let on_u = |end| self.at([(a, end, r), (u, su, 0.0), (v, sv, r)]);
                let on_v = |end| self.at([(a, end, r), (u, su, r), (v, sv, 0.0)]);
                let corners = [on_u(-1.0), on_u(1.0), on_v(1.0), on_v(-1.0)];
                self.polygon(&corners, DVec3::AXES[u] * su + DVec3::AXES[v] * sv, emit)?;
            }
        }
        for out in corners() {
            let tip = |a: usize| {
                let part = |i: usize| (i, out[i], if i == a { 0.0 } else { r });
                self.at([part(0), part(1), part(2)])
            };
            self.polygon(&[tip(0), tip(1), tip(2)], out, emit)?;
        }
        Ok(())
    }

    fn rounds(&self, r: f64, emit: Emit<'_>) -> Result<(), Cause> {
        for [a, u, v] in TURNS {
            for (su, sv) in SIDES.into_iter().flat_map(|u| SIDES.map(|v| (u, v))) {
                let end = |side| self.at([(a, side, r), (u, su, r), (v, sv, r)]);
                let (p, q) = (end(-1.0), end(1.0));
                // A side of twice the radius leaves no edge between the corners.
                if p != q {
                    emit(Shape::Cylinder { inward: false }, &[p.x, p.y, p.z, q.x, q.y, q.z, r])?;
                }
            }
        }
        for out in corners() {
            let c = self.at([(0, out.x, r), (1, out.y, r), (2, out.z, r)]);
            emit(Shape::Sphere { inward: false }, &[c.x, c.y, c.z, r])?;
        }
        Ok(())
    }

    /// A point by axis, side and distance from that side.
    fn at(&self, parts: [(usize, f64, f64); 3]) -> DVec3 {
        let mut point = DVec3::ZERO;
        for (axis, side, inset) in parts {
            point[axis] = if side < 0.0 { inset } else { self.size[axis] - inset };
        }
        point
    }

    /// A polygon that faces `out`, or away from it if the box faces inward.
    fn polygon(&self, corners: &[DVec3], out: DVec3, emit: Emit<'_>) -> Result<(), Cause> {
        let &[a, b, c, ..] = corners else { return Ok(()) };
        let front = (b - a).cross(c - a).dot(out) > 0.0;
        let numbers: Vec<f64> = if front == self.inward {
            corners.iter().rev().flat_map(|p| p.to_array()).collect()
        } else {
            corners.iter().flat_map(|p| p.to_array()).collect()
        };
        emit(Shape::Polygon, &numbers)
    }
}

/// The axes, each first once.
const TURNS: [[usize; 3]; 3] = [[0, 1, 2], [1, 2, 0], [2, 0, 1]];
const SIDES: [f64; 2] = [-1.0, 1.0];

/// The directions of the eight corners.
fn corners() -> impl Iterator<Item = DVec3> {
    let pairs = SIDES.into_iter().flat_map(|x| SIDES.map(|y| (x, y)));
    pairs.flat_map(|(x, y)| SIDES.map(|z| DVec3::new(x, y, z)))
}
