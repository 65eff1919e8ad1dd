use std::borrow::Cow;

use kiloray_core::block::KiloView;
use kiloray_core::node::Work;
use kiloray_core::real::LANES;
use kiloray_core::shade::FEW_LIGHTS;
use serde::{Deserialize, Serialize};

use crate::NodeTime;

/// How long the operations of a node take on a machine \[ns\].
///
/// `pc` is measured: one core of the machine named at [`Profile::PC`], rendering some scenes with one thread, and the least squares of what a simulated
/// node counts for the same pictures. `kiloray calibrate` does it on another machine, and writes a profile that is read by [`serde`].
///
/// `stm32f4` and `rp2350` are instructions of the firmware, counted under an emulator (`node-board/instructions`), times what the machine's
/// papers say of one; an emulator does not know how long they take. Expect them to be right within a half, where most is not spheres.
///
/// `t800` is worked out: operations of the scalar code, counted in its source (with the early outs of an average visit), times what its
/// data sheet says of an operation. Compilers need several times as many instructions: expect no more than its ratio of computing to links.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Profile {
    /// What it is called.
    pub name: Cow<'static, str>,
    /// What its figures are from, in words.
    pub source: Cow<'static, str>,
    /// A tree node: eight boxes.
    pub node: f64,
    /// A leaf record: up to four triangles.
    pub leaf: f64,
    /// Entering a block.
    pub block: f64,
    /// Beginning, or going on with, a closest-hit ray.
    pub ray: f64,
    /// Beginning, or going on with, a shadow ray.
    pub shadow_ray: f64,
    /// Whether rays are traced together. Where not, each goes alone.
    pub together: bool,
    /// Beginning a ray in a bundle.
    pub bundle_ray: f64,
    /// A tree node for a bundle.
    pub bundle_node: f64,
    /// Eight rays of a bundle against a box.
    pub bundle_box: f64,
    /// A ray of a bundle against eight boxes.
    pub bundle_ray_box: f64,
    /// Eight rays of a bundle against a triangle.
    pub bundle_triangle: f64,
    /// A ray of a bundle against the triangles of a record.
    pub bundle_ray_triangle: f64,
    /// Shading a hit.
    pub shading: f64,
    /// Estimating what a light brings to a hit: all lights are looked at, of many eight together where there are lanes ([`estimates`]).
    pub light: f64,
    /// Asking a light: beginning a bundle of shadow rays to it.
    pub light_bundle: f64,
    /// Making a shadow ray.
    pub light_sample: f64,
    /// Clipping a bundle.
    pub clip: f64,
    /// Handling a message, in or out.
    pub message: f64,
    /// Copying a byte.
    pub copy: f64,
    /// Checking a byte of a block.
    pub check: f64,
    /// Passing a packet on from link to link, where the node does that itself, and copies it twice; 0 where routers stand beside the nodes.
    #[serde(default)]
    pub forward: f64,
}

impl Profile {
    /// One core of a PC (Intel Xeon with AVX-512 and 480 MiB of third cache, 2026), by `kiloray calibrate`; the time of a message is that of writing, routing and
    /// reading a short one.
    pub const PC: Self = Self {
        name: Cow::Borrowed("pc"),
        source: Cow::Borrowed(
            "measured: one core of an Intel Xeon with AVX-512, fitted to pictures rendered by one thread",
        ),
        node: 4.2,
        leaf: 39.2,
        block: 9.5,
        ray: 105.7,
        shadow_ray: 17.7,
        together: true,
        bundle_ray: 7.9,
        bundle_node: 29.9,
        bundle_box: 19.5,
        bundle_ray_box: 6.8,
        bundle_triangle: 6.6,
        bundle_ray_triangle: 10.5,
        shading: 35.5,
        light: 83.3,
        light_bundle: 169.4,
        light_sample: 31.9,
        clip: 693.0,
        message: 33.0,
        copy: 0.037,
        check: 0.107,
        forward: 0.0,
    };

    /// INMOS T800 at 20 MHz: 1.5 million floating-point operations and 10 million instructions a second (data sheet), with memory
    /// off chip (330 ns a word, as in the transputer systems of the dissertation's time) a third slower.
    pub const T800: Self = Machine { name: "t800", float: 667.0, other: 150.0 }.profile();

    /// RP2350, a Cortex-M33 at 150 MHz: one and a half cycles for an instruction (loads take two, taken branches up to three), a fifth more,
    /// as code comes through a cache from serial flash.
    pub const RP2350: Self = cortex_m("rp2350", 12.0);

    /// STM32F407, a Cortex-M4F at 168 MHz: cycles as for the M33 (technical reference manual, table of instructions), a tenth more for
    /// flash with five wait states behind its accelerator.
    pub const STM32F4: Self = cortex_m("stm32f4", 9.8);

    /// All profiles.
    pub const ALL: [Self; 4] = [Self::PC, Self::T800, Self::RP2350, Self::STM32F4];

    /// The profile of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|profile| profile.name == name)
    }

    /// Each operation in words, and its time \[ns\].
    #[must_use]
    pub fn operations(&self) -> [(&'static str, f64); 20] {
        [
            ("a node of the tree: eight boxes", self.node),
            ("a record of a leaf: up to four triangles", self.leaf),
            ("entering a block", self.block),
            ("a ray, begun or gone on with", self.ray),
            ("a shadow ray, begun or gone on with", self.shadow_ray),
            ("beginning a ray among others", self.bundle_ray),
            ("a node of the tree, for rays together", self.bundle_node),
            ("eight rays together against a box", self.bundle_box),
            ("a ray among others against eight boxes", self.bundle_ray_box),
            ("eight rays together against a triangle", self.bundle_triangle),
            ("a ray among others against a record", self.bundle_ray_triangle),
            ("shading a hit", self.shading),
            ("estimating a light", self.light),
            ("asking a light", self.light_bundle),
            ("making a shadow ray", self.light_sample),
            ("clipping a bundle", self.clip),
            ("a message, in or out", self.message),
            ("copying a byte", self.copy),
            ("checking a byte of a block", self.check),
            ("passing a packet on", self.forward),
        ]
    }

    /// The same in a scene: `light` is the time of all estimates that a hit takes.
    pub(crate) fn in_scene(self, scene: &KiloView<'_>) -> Self {
        let estimates = estimates(scene, self.together);
        Self { light: self.light * estimates as f64, ..self }
    }

    /// The time of an amount of work [in a scene](Self::in_scene), by what it is, for a node that is slower by a factor.
    pub(crate) fn time(&self, work: &Work, slow: f64) -> NodeTime {
        let ns = |terms: &[(u32, f64)]| {
            // Most steps are of one kind.
            if terms.iter().fold(0, |all, (count, _)| all | count) == 0 {
                return 0;
            }
            let sum: f64 = terms.iter().map(|&(count, each)| f64::from(count) * each).sum();
            (sum * slow + 0.5) as u64
        };
        NodeTime {
            trace: ns(&[
                (work.nodes, self.node),
                (work.leaves, self.leaf),
                (work.blocks, self.block),
                (work.rays, self.ray),
                (work.shadow_rays, self.shadow_ray),
                (work.bundle_rays, self.bundle_ray),
                (work.bundle_nodes, self.bundle_node),
                (work.bundle_boxes, self.bundle_box),
                (work.bundle_ray_boxes, self.bundle_ray_box),
                (work.bundle_triangles, self.bundle_triangle),
                (work.bundle_ray_triangles, self.bundle_ray_triangle),
            ]),
            shade: ns(&[
                (work.shadings, self.shading + self.light),
                // Its lights have been estimated before.
                (work.shadings_again, self.shading),
                (work.lights, self.light_bundle),
                (work.light_samples, self.light_sample),
            ]),
            clip: ns(&[(work.clips, self.clip)]),
            messages: ns(&[(work.messages, self.message)]),
            copies: ns(&[(work.copied, self.copy)]),
            checks: ns(&[(work.checked, self.check)]),
            ..NodeTime::default()
        }
    }

    /// The time of passing on a packet of so many bytes.
    pub(crate) fn forwarding(&self, bytes: usize, slow: f64) -> u64 {
        let copies = if self.forward > 0.0 { 2.0 * self.copy * bytes as f64 } else { 0.0 };
        ((self.forward + copies) * slow + 0.5) as u64
    }

    /// Of one ray that is traced and shaded, with its part of shadow rays: what a node does between two looks at its messages is
    /// some of these.
    pub(crate) fn typical_ray(&self) -> f64 {
        let traced = self.ray + 12.0 * self.node + 6.0 * self.leaf + 4.0 * self.block;
        traced + self.shading + self.light_sample
    }
}

/// A Cortex-M with a floating-point unit for single precision, by the time of an instruction \[ns\].
///
/// The instructions of each operation are those that `node-board/instructions` counts for an M4F and firmware made for size: the fit is 7 and 10 % above
/// colour-cube:6 and sinc:24, 1 % below cornell, and 24 % below glass, whose spheres are tested in double precision, in software. Clips are not among them: they are worked out, of
/// 3000 operations in double precision of 80 instructions each.
const fn cortex_m(name: &'static str, ns: f64) -> Profile {
    Profile {
        name: Cow::Borrowed(name),
        source: Cow::Borrowed(
            "instructions of the firmware counted under an emulator, times what the machine's papers say of one; right within a half",
        ),
        node: 941.0 * ns,
        leaf: 1028.0 * ns,
        block: 455.0 * ns,
        ray: 1411.0 * ns,
        shadow_ray: 761.0 * ns,
        together: false,
        bundle_ray: 0.0,
        bundle_node: 0.0,
        bundle_box: 0.0,
        bundle_ray_box: 0.0,
        bundle_triangle: 0.0,
        bundle_ray_triangle: 0.0,
        shading: 5418.0 * ns,
        light: 545.0 * ns,
        // It is in the others: pictures of few lights do not tell them apart.
        light_bundle: 0.0,
        light_sample: 1356.0 * ns,
        clip: 240_000.0 * ns,
        message: 2120.0 * ns,
        copy: 1.3 * ns,
        check: 14.5 * ns,
        // What the router has of a message: half of it.
        forward: 1060.0 * ns,
    }
}

/// A processor without lanes \[ns\].
struct Machine {
    name: &'static str,
    /// A floating-point operation, with its operand.
    float: f64,
    /// Any other instruction.
    other: f64,
}

impl Machine {
    /// Floating-point operations and other instructions of each operation.
    const fn profile(self) -> Profile {
        let Self { name, float, other } = self;
        Profile {
            name: Cow::Borrowed(name),
            source: Cow::Borrowed(
                "worked out: operations counted in the source, times what the machine's papers say of one; right within a factor of two",
            ),
            // Six children, of which some are left after one or two axes: 8 and 5 for each axis; two are put on the stack.
            node: 85.0 * float + 150.0 * other,
            // Three triangles: 24 to shear the vertices, 9 for the signs, and some go on to their box.
            leaf: 135.0 * float + 180.0 * other,
            // The frame's scale and pad; the table of blocks.
            block: 40.0 * float + 120.0 * other,
            // Three reciprocals, shear, signs; the path is taken from its slot and put back.
            ray: 100.0 * float + 200.0 * other,
            shadow_ray: 100.0 * float + 150.0 * other,
            // Without lanes there is nothing in it.
            together: false,
            bundle_ray: 0.0,
            bundle_node: 0.0,
            bundle_box: 0.0,
            bundle_ray_box: 0.0,
            bundle_triangle: 0.0,
            bundle_ray_triangle: 0.0,
            // The point with the bounds of its error, the material, the specular rays.
            shading: 350.0 * float + 500.0 * other,
            // Scrambled numbers, a place on the light, the material's answer, the start beside the surface.
            light: 60.0 * float + 60.0 * other,
            // It is in those of its samples.
            light_bundle: 0.0,
            light_sample: 150.0 * float + 150.0 * other,
            // The hull of 64 rays, and some tens of boxes against its planes.
            clip: 3000.0 * float + 3000.0 * other,
            message: 400.0 * other,
            // Three instructions for four bytes.
            copy: 0.75 * other,
            // A checksum by table: seven; and the look at what the bytes mean.
            check: 8.0 * other,
            // Processes of two links are woken, and one is told of the other's packet: half of what a message takes.
            forward: 200.0 * other,
        }
    }
}

/// How many estimates of a light a hit in a scene takes. Where lanes are, eight of many lights that are looked at together take as long as one of few.
///
/// By a tree it is some 300 of 20,000: those of its line, and two at each level for each light that is asked.
#[must_use]
pub fn estimates(scene: &KiloView<'_>, lanes: bool) -> usize {
    let lights = scene.lights().len();
    if !scene.light_tree().is_empty() {
        64 + 16 * lights.ilog2() as usize
    } else if lanes && lights > FEW_LIGHTS {
        lights.div_ceil(LANES)
    } else {
        lights
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found() {
        for profile in Profile::ALL {
            assert_eq!(Profile::named(&profile.name), Some(profile));
        }
        assert_eq!(Profile::named("abacus"), None);
    }

    #[test]
    fn time_is_what_was_done_times_what_it_takes() {
        let work = Work { nodes: 3, shadings: 2, copied: 1000, ..Work::default() };
        let profile = Profile { node: 10.0, shading: 7.0, light: 3.0, copy: 0.5, ..Profile::PC };
        let time = profile.time(&work, 2.0);
        assert_eq!((time.trace, time.shade, time.copies), (60, 40, 1000));
        assert_eq!(time.busy(), 1100);
        let again = Work { shadings_again: 5, ..work };
        assert_eq!(profile.time(&again, 2.0).shade, 40 + 70);
        let asked = Work { lights: 3, light_samples: 4, ..Work::default() };
        let time =
            Profile { light_bundle: 5.0, light_sample: 2.0, ..Profile::PC }.time(&asked, 1.0);
        assert_eq!(time.shade, 23);
        let slow = Profile { forward: 100.0, copy: 0.5, ..Profile::PC };
        assert_eq!((slow.forwarding(50, 2.0), Profile::PC.forwarding(50, 2.0)), (300, 0));
    }

    #[test]
    fn machines_keep_their_order() {
        let [pc, t800, rp2350, stm32f4] = Profile::ALL.map(|profile| profile.typical_ray());
        assert!(pc < stm32f4 && stm32f4 < rp2350 && rp2350 < t800);
    }
}
