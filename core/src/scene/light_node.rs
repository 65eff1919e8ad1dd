use bytemuck::{Pod, Zeroable};

/// A node of the light tree, which scenes of many lights have (Conty & Kulla 2018): what lies below it, as one light.
///
/// Nodes are in the order of a walk that comes to each before what is below it: the first child of a node that is no leaf comes next, the second where the first
/// one ends, and there all of the node ends, too. There may be several roots, one behind the other. A leaf is one light, and each light has one.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LightNode {
    /// Centre of a sphere that holds all lights below.
    pub center: [f32; 3],
    /// Its radius \[scene units\]; infinite of a distant light.
    pub radius: f32,
    /// The sum of what they send in the directions in which they send most \[W/sr, in scene units\]: the greatest component of radiance times area, or the
    /// intensity of points.
    pub power: f32,
    /// Axis of a cone that holds the normals of all surfaces below.
    pub axis: [f32; 3],
    /// What is sent along that axis, of the power: the mean cosine between the normals and it, by power; 0 if they shine in all directions.
    pub mean_cos: f32,
    /// Cosine of the half angle of that cone; -1 if they shine in all directions.
    pub cone_cos: f32,
    /// Greatest [reach](super::Light::reach) of a light below \[scene units\].
    pub reach: f32,
    /// Of a leaf [`LightNode::LEAF`] and the index of its light; else the index of the node behind the last one below.
    pub next: u32,
}

impl LightNode {
    /// Marks a leaf.
    pub const LEAF: u32 = 1 << 31;

    /// The index of the light, of a leaf.
    #[must_use]
    pub const fn light(&self) -> Option<u32> {
        if self.next & Self::LEAF != 0 { Some(self.next & !Self::LEAF) } else { None }
    }

    /// Where node `index`, which is this one, ends.
    #[must_use]
    pub const fn end(&self, index: u32) -> u32 {
        if self.next & Self::LEAF != 0 { index.saturating_add(1) } else { self.next }
    }
}

const _: () = assert!(size_of::<LightNode>() == 48);
