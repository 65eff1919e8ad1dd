use crate::tally::tally;

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
        tally!(self, other, Self {
            sum primary, shadow, specular, lights_below, lights_facing_away, lights_out_of_reach,
                lights_by_chance, shadow_dark, shadow_clear, specular_by_chance, specular_too_deep;
        });
    }
}
