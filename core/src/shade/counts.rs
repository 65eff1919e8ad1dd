/// What was traced, and what was not: for the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Counts {
    /// Camera rays.
    pub primary: u64,
    /// Shadow rays.
    pub shadow: u64,
    /// Specular rays.
    pub specular: u64,
    /// Lights not asked, as they lie behind the surface.
    pub lights_below: u64,
    /// Lights not asked, as they shine to another side.
    pub lights_facing_away: u64,
    /// Lights not asked, as they are out of reach.
    pub lights_out_of_reach: u64,
    /// Lights not asked by chance, as they bring little; others stand for them.
    pub lights_by_chance: u64,
    /// Shadow rays not traced, as their light would not count: below the horizon, or beside the light.
    pub shadow_dark: u64,
    /// Shadow rays not traced, as nothing lies between their bundle and its light.
    pub shadow_clear: u64,
    /// Specular rays not traced by chance, as they bring little; others stand for them.
    pub specular_by_chance: u64,
    /// Specular rays not traced, as the path is as long as allowed.
    pub specular_too_deep: u64,
}

impl Counts {
    /// All that were traced.
    #[must_use]
    pub const fn rays(&self) -> u64 {
        self.primary.saturating_add(self.shadow).saturating_add(self.specular)
    }

    /// Adds what another has counted.
    pub fn add(&mut self, other: &Self) {
        let pairs = [
            (&mut self.primary, other.primary),
            (&mut self.shadow, other.shadow),
            (&mut self.specular, other.specular),
            (&mut self.lights_below, other.lights_below),
            (&mut self.lights_facing_away, other.lights_facing_away),
            (&mut self.lights_out_of_reach, other.lights_out_of_reach),
            (&mut self.lights_by_chance, other.lights_by_chance),
            (&mut self.shadow_dark, other.shadow_dark),
            (&mut self.shadow_clear, other.shadow_clear),
            (&mut self.specular_by_chance, other.specular_by_chance),
            (&mut self.specular_too_deep, other.specular_too_deep),
        ];
        for (mine, others) in pairs {
            *mine = mine.saturating_add(others);
        }
    }
}
