use crate::trace::BUNDLE;

/// Whether to look if a bundle of shadow rays can be skipped, and how many bundles together.
///
/// A search that leads nowhere costs; where many did, only some bundles are looked into. Where one was of use, the next is for twice as many.
/// It decides about time only.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trust {
    /// How many searches in a row may still fail.
    left: u8,
    asked: u8,
    /// Bundles to look at together.
    together: u8,
}

/// Failed searches after which most bundles are traced unasked.
const MOST: u8 = 8;
/// Then one in so many is looked into.
const RARE: u8 = 16;
/// Bundles that are looked at together, at most.
const TOGETHER: u8 = 16;

impl Trust {
    pub(crate) const fn new() -> Self {
        Self { left: MOST, asked: 0, together: 1 }
    }

    /// How many shadow rays to look at next, at most.
    pub(crate) const fn most(&self) -> usize {
        BUNDLE.saturating_mul(self.together as usize)
    }

    /// Of so many rays to one light, how many nothing is in the way of: all, or one bundle of them, or none that is known of. `is_clear` searches for so
    /// many of them.
    pub(crate) fn clear_of(
        &mut self,
        rays: usize,
        mut is_clear: impl FnMut(usize) -> bool,
    ) -> usize {
        let mut rays = rays;
        while self.asks() {
            let clear = is_clear(rays);
            self.note(clear);
            if clear {
                return rays;
            }
            if rays <= BUNDLE {
                break;
            }
            rays = BUNDLE;
        }
        0
    }

    /// Whether the next bundle is worth a search: none where that is left out.
    fn asks(&mut self) -> bool {
        if !cfg!(feature = "clips") {
            return false;
        }
        self.asked = self.asked.wrapping_add(1);
        self.left > 0 || self.asked.is_multiple_of(RARE)
    }

    /// What the search has found.
    fn note(&mut self, clear: bool) {
        (self.left, self.together) = if clear {
            (MOST, self.together.saturating_mul(2).min(TOGETHER))
        } else {
            (self.left.saturating_sub(1), 1)
        };
    }
}
