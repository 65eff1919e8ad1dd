//! The hull of a bundle in f64: its support function, and the normals worth asking it for.

use crate::geometry::rounding::{UNIT_ROUNDOFF, max};
use crate::geometry::spawn::{CLEARANCE, TARGET_ERROR};
use crate::geometry::{Aabb, Ray};
use crate::light::versine;
use crate::scene::{Light, LightKind};
use glam::{DVec2, DVec3, Vec3, Vec3Swizzles};

/// Points that a hull can have: eight where rays begin, eight where they end.
const POINTS_MAX: usize = 16;
const BOX_CORNERS: usize = 8;
/// Vertices of the rim that the sides go through.
const RIM_MAX: usize = 8;
/// A regular octagon around the unit circle: tan(π / 8).
const OCTAGON: f64 = 0.414_213_562_373_095_1;
/// Directions within this of a half-space, in parts of their length, count as in it: they are not exact themselves.
const DIRECTION_TOLERANCE: f64 = 1e-7;

/// The convex hull of points, and of the rays from them in some directions, and of a ball's cap. Relative to `origin`.
pub(super) struct Hull {
    pub(super) origin: Vec3,
    /// Greatest coordinate of a point where a ray begins.
    pub(super) spread: f64,
    pub(super) axis: DVec3,
    points: List<POINTS_MAX>,
    /// How many of the points are where rays begin; the others are where they end. If they are eight, they are the corners of a box: of number `i`,
    /// bit `k` tells whether it is the upper one along axis `k`.
    starts: usize,
    /// Directions in which the hull is unbounded.
    directions: List<RIM_MAX>,
    cap: Option<Cap>,
    /// What the hull is seen to end in, in order around it: places, or directions if `rim_is_far`.
    rim: List<RIM_MAX>,
    rim_is_far: bool,
    /// A half-space that holds the hull, though its points do not tell: the least `normal · x`.
    floor: Option<(DVec3, f64)>,
    /// The normal of the surface through the origin that all rays leave.
    pub(super) surface: Option<DVec3>,
    /// What is added to the hull on all sides.
    inflate: f64,
}

/// The points `x` of a ball with `axis · (x - center) <= height`.
struct Cap {
    center: DVec3,
    radius: f64,
    axis: DVec3,
    height: f64,
}

impl Cap {
    fn support(&self, normal: DVec3, length: f64) -> f64 {
        let along = normal.dot(self.axis);
        if -along * self.radius <= self.height * length {
            // The ball's own point in this direction is in the cap.
            return normal.dot(self.center) - self.radius * length;
        }
        let disc = libm::sqrt((self.radius * self.radius - self.height * self.height).max(0.0));
        let across = libm::sqrt((length * length - along * along).max(0.0));
        normal.dot(self.center) + along * self.height - across * disc
    }
}

#[derive(Clone, Copy)]
struct List<const N: usize> {
    items: [DVec3; N],
    len: usize,
}

impl<const N: usize> List<N> {
    const EMPTY: Self = Self { items: [DVec3::ZERO; N], len: 0 };

    fn push(&mut self, item: DVec3) {
        if let Some(place) = self.items.get_mut(self.len) {
            *place = item;
            self.len += 1;
        }
    }

    fn iter(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        self.items.iter().take(self.len).copied()
    }

    /// Each item and the one behind it, around.
    fn edges(&self) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        self.iter().zip(self.iter().cycle().skip(1))
    }
}

impl Hull {
    fn new(origin: Vec3) -> Self {
        Self {
            origin,
            spread: 0.0,
            axis: DVec3::Z,
            points: List::EMPTY,
            starts: 0,
            directions: List::EMPTY,
            cap: None,
            rim: List::EMPTY,
            rim_is_far: false,
            floor: None,
            surface: None,
            inflate: 0.0,
        }
    }

    pub(super) fn of_tile(corners: &[Ray; 4]) -> Self {
        let [first, ..] = corners;
        let mut hull = Self::new(first.origin);
        let base = first.origin.as_dvec3();
        hull.axis = corners.iter().map(|ray| ray.direction.as_dvec3().normalize_or_zero()).sum();
        for ray in corners {
            hull.start(ray.origin.as_dvec3() - base);
        }
        let bounded = corners.iter().all(|ray| ray.t_max < f32::MAX);
        for ray in corners {
            let (o, d) = (ray.origin.as_dvec3() - base, ray.direction.as_dvec3());
            if bounded {
                hull.points.push(o + d * f64::from(ray.t_max));
            } else {
                hull.directions.push(d);
            }
            hull.rim.push(d);
        }
        hull.rim_is_far = true;
        // Origins that differ are rounded in the scene's coordinates, not in the tile's.
        if hull.spread > 0.0 {
            let greatest = corners.iter().map(|ray| ray.origin.abs().max_element());
            hull.inflate = 8.0 * f64::from(greatest.fold(0.0, max) * UNIT_ROUNDOFF);
        }
        hull
    }

    pub(super) fn to_light(from: &Aabb, light: &Light) -> Self {
        let origin = from.center();
        let base = origin.as_dvec3();
        let mut hull = Self::new(origin);
        let (lo, hi) = (from.min.as_dvec3() - base, from.max.as_dvec3() - base);
        let corners = if lo == hi { 1 } else { BOX_CORNERS };
        for corner in 0..corners {
            let pick = |bit: usize, lo: f64, hi: f64| if corner >> bit & 1 == 0 { lo } else { hi };
            hull.start(DVec3::new(pick(0, lo.x, hi.x), pick(1, lo.y, hi.y), pick(2, lo.z, hi.z)));
        }
        let [position, u, v] =
            [light.position, light.u, light.v].map(|v| Vec3::from_array(v).as_dvec3());
        let c = position - base;
        match LightKind::from_u32(light.kind) {
            Some(LightKind::Parallelogram) => {
                hull.ends([c, c + u, c + u + v, c + v]);
            }
            Some(LightKind::Triangle) => hull.ends([c, c + u, c + v]),
            Some(LightKind::Disc) => hull.ends(octagon(c, u, v)),
            Some(LightKind::Sphere) => hull.end_in_ball(c, u.x),
            Some(LightKind::Point | LightKind::Spot) => hull.ends([c]),
            Some(LightKind::Distant) => hull.end_far_away(u, versine(light.v.into()).into()),
            None => hull.axis = DVec3::NAN,
        }
        hull.end_before(light, c, u, v);
        hull
    }

    /// Where shadow rays end is rounded, and stands off the light by the clearance of `SurfacePoint::spawn_to`: what
    /// lies farther than that from all starts is beyond all ends.
    fn end_before(&mut self, light: &Light, position: DVec3, u: DVec3, v: DVec3) {
        if self.rim_is_far {
            return;
        }
        let size = u.abs().max_element() + v.abs().max_element();
        let place = f64::from(Vec3::from_array(light.position).abs().max_element());
        let error = f64::from(TARGET_ERROR) * (place + size);
        let kind = LightKind::from_u32(light.kind);
        if matches!(kind, Some(LightKind::Point | LightKind::Spot)) {
            // A free target: only the direction to it is rounded.
            self.inflate =
                8.0 * f64::from(UNIT_ROUNDOFF) * (position.abs().max_element() + self.spread);
            return;
        }
        let disc = kind == Some(LightKind::Disc);
        // The greatest distance along an axis between the origin and the light.
        let far = if disc || kind == Some(LightKind::Sphere) {
            position.abs().max_element() + size
        } else {
            self.points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max)
        };
        self.inflate = 1.1 * CLEARANCE * (far + self.spread + 2.0 * size) + 2.0 * error;
        let flat =
            disc || kind == Some(LightKind::Parallelogram) || kind == Some(LightKind::Triangle);
        let cross = u.cross(v);
        let normal = if cross.dot(position) > 0.0 { -cross } else { cross };
        let length = libm::sqrt(normal.length_squared());
        // Each ray stands off by 160 u of its own distance to the light's farthest corner, which is at least this, less
        // its roundings, and by `error`, of which the sample took half; the other half is the surface's in the blocks.
        let reached = if disc { far - 0.5 * size } else { far };
        let own = (CLEARANCE - 4.0 * f64::from(UNIT_ROUNDOFF)) * (reached - self.spread);
        let least = normal.dot(position) + (own + 0.5 * error) * length;
        if flat && own > 0.0 && normal.dot(self.first_start(normal)) > least {
            self.floor = Some((normal, least));
        }
    }

    fn start(&mut self, point: DVec3) {
        self.points.push(point);
        self.starts = self.points.len;
        self.spread = self.spread.max(point.abs().max_element());
    }

    fn ends<const N: usize>(&mut self, points: [DVec3; N]) {
        self.axis = points.iter().sum();
        for point in points {
            self.points.push(point);
            self.rim.push(point);
        }
    }

    fn end_in_ball(&mut self, center: DVec3, radius: f64) {
        self.axis = center;
        let distance = libm::sqrt(center.length_squared());
        // What a start can see of the ball lies on the near side of the plane through the points where its
        // tangents touch: (x - center) · (start - center) >= radius².
        let away = self.starts().fold(0.0, |most: f64, s| most.max(libm::sqrt(s.length_squared())));
        let height = if distance > radius { -radius * (radius - away) / distance } else { radius };
        let axis = center / if distance > 0.0 { distance } else { 1.0 };
        self.cap = Some(Cap { center, radius, axis, height: height.min(radius) });
        // From nearby, or from inside, the sphere has no rim: its bounds have to do.
        if distance > radius * 1.001 {
            let (u, v) = (center / distance).any_orthonormal_pair();
            let tangent = radius / distance;
            let rim = radius / libm::sqrt(1.0 - tangent * tangent);
            for point in octagon(center, u * rim, v * rim) {
                self.rim.push(point);
            }
        }
    }

    fn end_far_away(&mut self, axis: DVec3, versine: f64) {
        let cos = 1.0 - versine;
        self.axis = axis;
        self.rim_is_far = true;
        // Wider than 78 degrees it is as good as the half-space of nothing.
        if cos > 0.2 {
            let sin = libm::sqrt(versine * (2.0 - versine));
            // Directions of samples are rounded: a sun that is a point is no line.
            let tan = sin / cos + 32.0 * f64::from(UNIT_ROUNDOFF);
            let (u, v) = axis.normalize_or_zero().any_orthonormal_pair();
            for direction in octagon(axis, u * tan, v * tan) {
                self.directions.push(direction);
                self.rim.push(direction);
            }
        } else {
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                self.directions.push(axis);
                self.directions.push(-axis);
            }
        }
    }

    fn starts(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        self.points.iter().take(self.starts)
    }

    /// The one of least `normal · x` of where rays begin.
    fn first_start(&self, normal: DVec3) -> DVec3 {
        let least = |m: DVec3, s: DVec3| if normal.dot(s) < normal.dot(m) { s } else { m };
        if self.starts < BOX_CORNERS {
            return self.starts().reduce(least).unwrap_or_default();
        }
        let [x, y, z] = normal.to_array().map(|n| usize::from(n < 0.0));
        self.points.items.get(x | y << 1 | z << 2).copied().unwrap_or_default()
    }

    /// Whether there is no NaN or infinity in it.
    pub(super) fn is_finite(&self) -> bool {
        let cap = self.cap.as_ref();
        cap.is_none_or(|cap| cap.center.is_finite() && cap.radius.is_finite())
            && self.origin.is_finite()
            && self.axis.is_finite()
            && self.points.iter().all(DVec3::is_finite)
            && self.directions.iter().all(DVec3::is_finite)
    }

    /// The least `normal · x` over the hull, `None` if there is none.
    pub(super) fn support(&self, normal: DVec3) -> Option<f64> {
        if let Some((floor, least)) = self.floor
            && floor == normal
        {
            return Some(least);
        }
        if self.surface == Some(normal) {
            return Some(0.0);
        }
        let length = libm::sqrt(normal.length_squared());
        let unbounded = |d: DVec3| {
            normal.dot(d) < -DIRECTION_TOLERANCE * length * libm::sqrt(d.length_squared())
        };
        if self.directions.iter().any(unbounded) {
            return None;
        }
        let ends = self.points.iter().skip(self.starts).map(|p| normal.dot(p));
        let mut least = ends.fold(normal.dot(self.first_start(normal)), f64::min);
        if let Some(cap) = &self.cap {
            least = least.min(cap.support(normal, length));
        }
        Some(least - self.inflate * length)
    }

    /// Bounds along the axes, rounded outward.
    pub(super) fn bounds(&self) -> (Vec3, Vec3) {
        let low = |n: DVec3| self.support(n).map_or(f32::NEG_INFINITY, round_down);
        let lo = Vec3::new(low(DVec3::X), low(DVec3::Y), low(DVec3::Z));
        let hi = -Vec3::new(low(-DVec3::X), low(-DVec3::Y), low(-DVec3::Z));
        (lo, hi)
    }

    /// Gives the normals of half-spaces that may hold the hull tightly; the support says where.
    pub(super) fn normals(&self, add: &mut dyn FnMut(DVec3)) {
        if let Some(normal) = self.surface {
            add(normal);
        }
        for (i, edge) in self.rim.edges().enumerate() {
            add(self.side(i, edge));
        }
        add(self.axis);
        if let Some((normal, _)) = self.floor {
            add(normal);
        } else if self.directions.len == 0 {
            add(-self.axis);
        }
        // Planes along an axis: the hull in projection, a point of the start and one of the rim on its border.
        (0..3).for_each(|axis| self.tangents(axis, add));
    }

    /// The plane through edge `i` of the rim that has all starts and the rim on one side.
    fn side(&self, i: usize, (p, q): (DVec3, DVec3)) -> DVec3 {
        let starts = || self.starts();
        if self.rim_is_far {
            let normal = p.cross(q);
            let flat = normal.length_squared() <= 1e-24 * p.length_squared() * q.length_squared();
            let (normal, inward) = if flat && self.starts > 1 {
                // Parallel rays: the side goes through where they begin.
                let mut around = starts().cycle().skip(i);
                let start = around.next().unwrap_or_default();
                let middle = starts().sum::<DVec3>() / self.starts as f64;
                ((around.next().unwrap_or_default() - start).cross(p), middle - start)
            } else {
                (normal, self.axis)
            };
            return if normal.dot(inward) < 0.0 { -normal } else { normal };
        }
        let middle = self.rim.iter().sum::<DVec3>() / self.rim.len as f64;
        let mut at = starts().sum::<DVec3>() / self.starts as f64;
        let mut side = DVec3::ZERO;
        // The plane is turned about the edge until it touches the last of the starts.
        for _ in 0..3 {
            side = (p - at).cross(q - at);
            if side.dot(middle - p) < 0.0 {
                side = -side;
            }
            let last = self.first_start(side);
            if side.dot(last) >= side.dot(at) {
                break;
            }
            at = last;
        }
        side
    }

    /// The two lines that touch both the starts and the rim, in the projection along an axis.
    fn tangents(&self, axis: u8, add: &mut dyn FnMut(DVec3)) {
        let project = |p: DVec3| match axis {
            0 => p.yz(),
            1 => p.zx(),
            _ => p.xy(),
        };
        let lift = |n: DVec2| match axis {
            0 => DVec3::new(0.0, n.x, n.y),
            1 => DVec3::new(n.y, 0.0, n.x),
            _ => n.extend(0.0),
        };
        // Of the corners of a box, each falls together with another.
        let is_other = |i: usize| self.starts < BOX_CORNERS || i >> axis & 1 == 0;
        let starts = self.starts().enumerate().filter(|&(i, _)| is_other(i));
        let starts = starts.map(|(_, start)| project(start));
        // A direction counts from where it begins, a place as it is.
        let rim = |start: DVec2| {
            self.rim
                .iter()
                .map(move |r| if self.rim_is_far { project(r) } else { project(r) - start })
        };
        for sign in [1.0, -1.0] {
            let touches = starts.clone().filter_map(|start| {
                // All of the rim is on one side of the last of it, as seen from here, if it is so of any.
                let last = |a: DVec2, b: DVec2| if sign * a.perp_dot(b) < 0.0 { b } else { a };
                let along = rim(start).reduce(last)?;
                let normal = along.perp() * sign;
                let tolerance = 1e-12 * max_element(normal);
                let inside = |x: DVec2| normal.dot(x) >= -tolerance * max_element(x);
                let first = project(self.first_start(lift(normal)));
                (inside(first - start) && rim(start).all(inside)).then_some(normal)
            });
            if let Some(normal) = { touches }.next() {
                add(lift(normal));
            }
        }
    }
}

fn max_element(v: DVec2) -> f64 {
    v.abs().max_element()
}

/// The greatest f32 that is not above `x`.
fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// A regular octagon around the ellipse of two half axes.
fn octagon(center: DVec3, u: DVec3, v: DVec3) -> [DVec3; RIM_MAX] {
    const T: f64 = OCTAGON;
    [(1.0, T), (T, 1.0), (-T, 1.0), (-1.0, T), (-1.0, -T), (-T, -1.0), (T, -1.0), (1.0, -T)]
        .map(|(a, b)| center + u * a + v * b)
}
