use super::deal::Deal;
use super::memo::Memo;
use super::path::is_seen;
use super::{Counts, Point, Shader};
use crate::light::{Aim, Dark, Look, Seen};
use crate::random::{Purpose, Sequence};
use crate::scene::Light;
use crate::trace::Tracer;
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;

/// The light sampling of a point: its bundles of shadow rays, one after the other.
///
/// # Which lights
///
/// A light that cannot reach the point is skipped. The others are given their
/// [estimates](Aim::estimate), laid end to end on a line, and a comb with a random offset (the systematic sampling of surveys) is laid over it: a light
/// longer than the spacing of the teeth is always taken, a shorter one if a tooth falls on it, and then stands for the others. The line has
/// [`Settings::lights`](super::Settings::lights)` × importance of the path` teeth: so a point asks at most about that many small lights, however many
/// there are.
///
/// Very many lights have a tree, and the line is one of its nodes ([`Tables::tree`](super::Tables)).
///
/// It is a small state, to be carried on or made again at will.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direct {
    /// The next light of the table, or node of the tree.
    pub(super) next: u32,
    pub(super) answers: [bool; 2],
    /// The sum of all estimates.
    pub(super) total: f32,
    /// Between teeth.
    pub(super) spacing: f32,
    /// The place of the next tooth on the line.
    pub(super) tooth: f32,
    /// The place on the line.
    pub(super) at: f32,
    /// Lights below the next node of the tree that have been asked.
    #[cfg(feature = "many-lights")]
    pub(super) asked: u32,
}

/// The shadow rays from one point to one light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bundle {
    /// Index of the light.
    pub light: u32,
    /// How many rays.
    pub len: u32,
    /// How many of them are samples, the first: a power of two. One more takes the rest of a known light.
    pub(super) samples: u32,
    pub(super) aim: Aim,
    pub(super) sequence: Sequence,
    /// One over the number of rays and the probability of the bundle.
    pub(super) scale: f32,
    pub(super) seen: bool,
    pub(super) deal: Deal,
}

/// So few lights are looked at whole, as most of them will be asked.
pub const FEW_LIGHTS: usize = 4;

/// A light that is asked.
pub(super) struct Asked {
    /// With which probability it was chosen.
    pub(super) probability: f32,
    /// Its part of all estimates.
    pub(super) part: f32,
}

impl Shader<'_> {
    /// Begins the light sampling of a point.
    #[must_use]
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn direct<T: Tracer>(&self, tracer: T, point: &Point, memo: &mut Memo) -> Direct {
        let lights = self.tables.lights;
        let answers = point.bsdf.answers();
        let key = point.path.key;
        let mut direct = Direct::new(answers);
        if answers == [false; 2] {
            direct.next = u32::MAX;
        } else if lights.len() > 1 {
            direct.total = self.length(tracer, point, answers, memo);
            let most = f32::from(self.settings.lights).max(1.0);
            let teeth = (most * point.path.importance()).max(1.0).min(most);
            direct.spacing = direct.total / teeth;
            let [offset, _] = Sequence::new(key, Purpose::Lights).point(key.sample);
            direct.tooth = offset * direct.spacing;
        }
        direct
    }

    /// The length of the line: the sum of all estimates.
    #[cfg_attr(feature = "bundles", inline(always))]
    fn length<T: Tracer>(
        &self,
        tracer: T,
        point: &Point,
        answers: [bool; 2],
        memo: &mut Memo,
    ) -> f32 {
        #[cfg(feature = "many-lights")]
        if !self.tables.tree.is_empty() {
            return self.length_of_tree(point, answers);
        }
        let key = point.path.key;
        if self.are_many() {
            memo.of(key);
            #[cfg(feature = "bundles")]
            if let Some(rows) = self.rows {
                rows.look(tracer, &point.surface, answers, memo);
            }
            #[cfg(not(feature = "bundles"))]
            let _ = tracer;
        }
        let known = memo.looks(key);
        let mut length = 0.0;
        for (index, light) in self.tables.lights.iter().enumerate() {
            length += match self.seen((index, light), point, answers, known) {
                Seen::Far(estimate) => estimate,
                Seen::Dark(_) => 0.0,
                Seen::Near => {
                    self.aim((index, light), point, answers, memo).map_or(0.0, |aim| aim.estimate)
                }
            };
        }
        length
    }

    /// The next bundle of a point's light sampling.
    #[must_use]
    #[cfg_attr(feature = "bundles", inline(always))]
    pub fn next_bundle<T: Tracer>(
        &self,
        tracer: T,
        point: &Point,
        direct: &mut Direct,
        memo: &Memo,
        counts: &mut Counts,
    ) -> Option<Bundle> {
        #[cfg(feature = "many-lights")]
        if !self.tables.tree.is_empty() {
            return self.next_of_tree(tracer, point, direct, counts);
        }
        let (answers, known) = (direct.answers, memo.looks(point.path.key));
        while let Some(light) = self.tables.lights.get(direct.next as usize) {
            let index = direct.next;
            direct.next += 1;
            let mut asked = None;
            match self.seen((index as usize, light), point, answers, known) {
                Seen::Near => {}
                Seen::Far(estimate) => {
                    asked = direct.draw(estimate);
                    if asked.is_none() {
                        counts.lights_by_chance += 1;
                        continue;
                    }
                }
                Seen::Dark(dark) => {
                    leave_out(dark, 1, counts);
                    continue;
                }
            }
            let mut aim = self.aim((index as usize, light), point, answers, memo);
            let aim = match &mut aim {
                Ok(aim) => aim,
                Err(dark) => {
                    leave_out(*dark, 1, counts);
                    continue;
                }
            };
            if asked.is_none() {
                asked = direct.draw(aim.estimate);
            }
            match asked {
                Some(asked) => {
                    return Some(self.bundle(tracer, point, (index, light), aim, asked));
                }
                None => counts.lights_by_chance += 1,
            }
        }
        None
    }

    /// Whether lights are looked at quickly first.
    const fn are_many(&self) -> bool {
        self.tables.lights.len() > FEW_LIGHTS
    }

    /// What a quick look at a light shows, where they are many; of the first of them it is known.
    #[cfg_attr(feature = "bundles", inline(always))]
    fn seen(
        &self,
        (index, light): (usize, &Light),
        point: &Point,
        answers: [bool; 2],
        known: &[Look],
    ) -> Seen {
        if !self.are_many() {
            return Seen::Near;
        }
        let anew = || Look::new(light, &point.surface, answers);
        known.get(index).copied().unwrap_or_else(anew).seen()
    }

    /// A light as the point sees it; of few lights it may be known.
    #[cfg_attr(feature = "bundles", inline(always))]
    fn aim(
        &self,
        (index, light): (usize, &Light),
        point: &Point,
        answers: [bool; 2],
        memo: &Memo,
    ) -> Result<Aim, Dark> {
        #[cfg(feature = "bundles")]
        if let Some(plane) = self.rows.and_then(|rows| rows.plane(index))
            && let Some(glance) = memo.glance_of(point.path.key, index)
        {
            return Aim::known(light, plane, glance, point.surface.position, answers);
        }
        #[cfg(not(feature = "bundles"))]
        let _ = (index, memo);
        Aim::new(light, &point.surface, answers)
    }

    #[cfg_attr(feature = "bundles", inline(always))]
    pub(super) fn bundle<T: Tracer>(
        &self,
        tracer: T,
        point: &Point,
        (index, light): (u32, &Light),
        aim: &mut Aim,
        Asked { probability, part }: Asked,
    ) -> Bundle {
        aim.prepare();
        let mut count = self.settings.shadow_count(aim.solid_angle);
        if self.settings.shadow_samples == 0 {
            count *= libm::sqrtf(part * point.path.importance().clamp(0.0, 1.0));
        }
        let samples = (libm::ceilf(count * 0.75) as u32).max(1).next_power_of_two();
        let deal = match unshadowed(tracer, point, aim, samples) {
            Some(light) => Deal::new(light / probability, &self.unit()),
            None => Deal::UNKNOWN,
        };
        Bundle {
            light: index,
            len: samples + u32::from(deal.is_known()),
            samples,
            aim: *aim,
            sequence: Sequence::new(point.path.key, Purpose::Light(index)),
            scale: 1.0 / (samples as f32 * probability),
            seen: is_seen(light, |material| self.emits(material)),
            deal,
        }
    }
}

/// Counts lights that cannot light the point.
#[inline(always)]
pub(super) fn leave_out(dark: Dark, count: u32, counts: &mut Counts) {
    match dark {
        Dark::Below => counts.lights_below += u64::from(count),
        Dark::FacesAway => counts.lights_facing_away += u64::from(count),
        Dark::OutOfReach => counts.lights_out_of_reach += u64::from(count),
        Dark::Void => {}
    }
}

/// What a light brings to the pixel if nothing is in its way, in closed form: of lights of some shapes, to flat diffuse surfaces in clear air.
///
/// Who wants one sample alone gets one.
fn unshadowed<T: Tracer>(tracer: T, point: &Point, aim: &Aim, samples: u32) -> Option<Vec3> {
    let Point { surface, bsdf, path, .. } = point;
    if samples < 2 || !point.is_matt() {
        return None;
    }
    let projected = aim.projected(tracer, surface.normal)?;
    let light = path.throughput * bsdf.diffuse * aim.radiance() * (projected * FRAC_1_PI);
    (light.max_element() > 0.0 && light.max_element() < LIGHT_MAX).then_some(light)
}

/// Brighter light could overflow while it is dealt out.
const LIGHT_MAX: f32 = 1e30;

impl Bundle {
    /// The light of all its rays together, before any is made, if it is known: what they bring if nothing is in the way of the light.
    #[must_use]
    pub fn unshadowed(&self) -> Option<Vec3> {
        self.deal.is_known().then(|| self.deal.rest())
    }

    /// The same with another number of rays, each as a sample.
    #[cfg(test)]
    pub(super) fn resized(self, samples: u32) -> Self {
        Self {
            len: samples,
            samples,
            scale: self.scale * (self.samples as f32 / samples as f32),
            deal: Deal::UNKNOWN,
            ..self
        }
    }
}

impl Direct {
    const fn new(answers: [bool; 2]) -> Self {
        Self {
            next: 0,
            answers,
            total: 0.0,
            spacing: 0.0,
            tooth: 0.0,
            at: 0.0,
            #[cfg(feature = "many-lights")]
            asked: 0,
        }
    }

    /// As plain data.
    #[must_use]
    pub fn pack(&self) -> [u32; 6] {
        let [front, back] = self.answers.map(u32::from);
        let [total, spacing, tooth, at] =
            [self.total, self.spacing, self.tooth, self.at].map(f32::to_bits);
        #[cfg(feature = "many-lights")]
        let asked = self.asked << 2;
        #[cfg(not(feature = "many-lights"))]
        let asked = 0;
        [self.next, front | back << 1 | asked, total, spacing, tooth, at]
    }

    /// What was packed.
    #[must_use]
    pub fn unpack([next, answers, total, spacing, tooth, at]: [u32; 6]) -> Self {
        let [total, spacing, tooth, at] = [total, spacing, tooth, at].map(f32::from_bits);
        Self {
            next,
            answers: [answers & 1 != 0, answers & 2 != 0],
            total,
            spacing,
            tooth,
            at,
            #[cfg(feature = "many-lights")]
            asked: answers >> 2,
        }
    }

    /// Lays the next estimate on the line, and says if a tooth falls on it. The only light there is has no line, and is always asked.
    #[cfg_attr(feature = "bundles", inline(always))]
    fn draw(&mut self, estimate: f32) -> Option<Asked> {
        self.at += estimate;
        let (is_long, has_tooth) = (estimate >= self.spacing, self.at > self.tooth);
        if !is_long && !has_tooth {
            return None;
        }
        if has_tooth {
            self.pass(self.at);
        }
        let probability = if is_long { 1.0 } else { estimate / self.spacing };
        let part = if self.total > 0.0 { (estimate / self.total).min(1.0) } else { 1.0 };
        Some(Asked { probability, part })
    }
    /// Goes on to the first tooth that is not before a place, one at least. (With no spacing it stays: the number of steps is finite.)
    #[cfg_attr(feature = "bundles", inline(always))]
    pub(super) fn pass(&mut self, place: f32) {
        self.tooth += (1.0 + ((place - self.tooth) / self.spacing) as u32 as f32) * self.spacing;
    }
}
