/// Names a slot of a [`Pool`]. It means nothing once the slot is released.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct Slot(pub u16);

impl Slot {
    /// No slot.
    pub const NONE: Self = Self(u16::MAX);

    /// Its index.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// Reusable slots. The slot released last is acquired first, so that the memory in use stays small.
#[derive(Debug)]
pub struct Pool<'a, T> {
    items: &'a mut [T],
    /// By slot: the next free one, or itself while in use.
    next: &'a mut [Slot],
    free: Slot,
    len: usize,
    peak: usize,
}

impl<'a, T: Copy> Pool<'a, T> {
    /// A pool with all slots free; its capacity is the lesser length of the two, at most 65,535.
    #[must_use]
    pub fn new(items: &'a mut [T], next: &'a mut [Slot]) -> Self {
        let capacity = items.len().min(next.len()).min(usize::from(u16::MAX));
        let (items, next) = match (items.get_mut(..capacity), next.get_mut(..capacity)) {
            (Some(items), Some(next)) => (items, next),
            _ => (<&mut [T]>::default(), <&mut [Slot]>::default()),
        };
        for (slot, link) in (1..=u16::MAX).zip(next.iter_mut()) {
            *link = Slot(slot);
        }
        if let Some(last) = next.last_mut() {
            *last = Slot::NONE;
        }
        let free = if items.is_empty() { Slot::NONE } else { Slot(0) };
        Self { items, next, free, len: 0, peak: 0 }
    }

    /// Takes a free slot if more than `reserve` are free, and stores `value` in it.
    ///
    /// The reserve is what later work may still need to finish: a point at bounce `d` of `b` leaves
    /// `b - 1 - d`, one for each deeper bounce, and so never keeps its own children from a slot.
    pub fn acquire(&mut self, value: T, reserve: usize) -> Option<Slot> {
        if self.free_len() <= reserve {
            return None;
        }
        let slot = self.free;
        let item = self.items.get_mut(slot.index())?;
        let link = self.next.get_mut(slot.index())?;
        *item = value;
        self.free = core::mem::replace(link, slot);
        self.len = self.len.saturating_add(1);
        self.peak = self.peak.max(self.len);
        Some(slot)
    }

    /// Gives a slot back. One that is not in use is left alone, and the answer is `false`.
    pub fn release(&mut self, slot: Slot) -> bool {
        match self.next.get_mut(slot.index()) {
            Some(link) if *link == slot => {
                *link = self.free;
                self.free = slot;
                self.len = self.len.saturating_sub(1);
                true
            }
            _ => false,
        }
    }

    /// The value of a slot in use.
    #[must_use]
    #[inline]
    pub fn get(&self, slot: Slot) -> Option<&T> {
        self.items.get(slot.index())
    }

    /// The value of a slot in use.
    #[inline]
    pub fn get_mut(&mut self, slot: Slot) -> Option<&mut T> {
        self.items.get_mut(slot.index())
    }

    /// Slots in use.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Whether none is in use.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Slots that are free.
    #[must_use]
    pub const fn free_len(&self) -> usize {
        self.items.len().saturating_sub(self.len)
    }

    /// All slots.
    #[must_use]
    pub const fn capacity(&self) -> usize {
        self.items.len()
    }

    /// Most slots that were ever in use at once.
    #[must_use]
    pub const fn peak(&self) -> usize {
        self.peak
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn behaves_as_a_map_of_slots(
            capacity in 0_usize..7,
            steps in prop::collection::vec((0_u8..3, any::<u8>(), 0_usize..4), 0..200),
        ) {
            let mut items = vec![0_u8; capacity];
            let mut next = vec![Slot::NONE; capacity];
            let mut pool = Pool::new(&mut items, &mut next);
            let mut model: std::collections::HashMap<Slot, u8> = std::collections::HashMap::new();
            let mut order: Vec<Slot> = Vec::new();
            let mut peak = 0;
            for (what, value, n) in steps {
                if what > 0 {
                    let got = pool.acquire(value, n);
                    prop_assert_eq!(got.is_some(), capacity - model.len() > n);
                    if let Some(slot) = got {
                        prop_assert!(model.insert(slot, value).is_none(), "taken twice");
                        order.push(slot);
                    }
                } else if !order.is_empty() {
                    let slot = order.swap_remove(n % order.len());
                    prop_assert!(pool.release(slot));
                    prop_assert!(!pool.release(slot), "released twice");
                    model.remove(&slot);
                }
                peak = peak.max(model.len());
                prop_assert_eq!((pool.len(), pool.peak()), (model.len(), peak));
                for (&slot, value) in &model {
                    prop_assert_eq!(pool.get(slot), Some(value));
                }
            }
        }
    }

    #[test]
    fn the_greatest_pool_hands_out_every_slot_once() {
        let mut items = vec![0_u16; 70_000];
        let mut next = vec![Slot::NONE; 70_000];
        let mut pool = Pool::new(&mut items, &mut next);
        assert_eq!(pool.capacity(), 65_535);
        for slot in 0..u16::MAX {
            assert_eq!(pool.acquire(slot, 0), Some(Slot(slot)));
        }
        assert_eq!(pool.acquire(0, 0), None);
    }

    #[test]
    fn the_reserve_is_kept_for_deeper_bounces() {
        let (mut items, mut next) = ([0_u8; 3], [Slot::NONE; 3]);
        let mut pool = Pool::new(&mut items, &mut next);
        assert!(pool.acquire(0, 2).is_some());
        assert!(pool.acquire(0, 2).is_none());
        assert!(pool.acquire(1, 1).is_some());
        assert!(pool.acquire(2, 0).is_some());
        assert_eq!(pool.free_len(), 0);
    }
}
