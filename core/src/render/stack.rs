/// Last in, first out, over a slice; full is an answer.
#[derive(Debug)]
pub(super) struct Stack<'a, T> {
    items: &'a mut [T],
    len: usize,
    peak: usize,
}

impl<'a, T: Copy> Stack<'a, T> {
    pub(super) const fn new(items: &'a mut [T]) -> Self {
        Self { items, len: 0, peak: 0 }
    }

    /// Puts a value on top; `false` if there is no room.
    #[inline]
    pub(super) fn push(&mut self, value: T) -> bool {
        let Some(place) = self.items.get_mut(self.len) else { return false };
        *place = value;
        self.len = self.len.saturating_add(1);
        self.peak = self.peak.max(self.len);
        true
    }

    /// Takes the top value.
    pub(super) fn pop(&mut self) -> Option<T> {
        self.len = self.len.checked_sub(1)?;
        self.items.get(self.len).copied()
    }

    pub(super) fn clear(&mut self) {
        self.len = 0;
    }

    /// The values, the oldest first.
    #[inline]
    pub(super) fn items(&self) -> &[T] {
        self.items.get(..self.len).unwrap_or_default()
    }

    pub(super) fn items_mut(&mut self) -> &mut [T] {
        self.items.get_mut(..self.len).unwrap_or_default()
    }

    pub(super) const fn len(&self) -> usize {
        self.len
    }

    pub(super) const fn capacity(&self) -> usize {
        self.items.len()
    }

    pub(super) const fn is_full(&self) -> bool {
        self.len >= self.items.len()
    }

    /// Most values it ever held.
    pub(super) const fn peak(&self) -> usize {
        self.peak
    }
}
