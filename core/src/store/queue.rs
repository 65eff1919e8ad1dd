/// First in, first out, in the slice it is lent.
#[derive(Debug)]
pub struct Queue<'a, T> {
    items: &'a mut [T],
    first: usize,
    len: usize,
}

impl<'a, T: Copy> Queue<'a, T> {
    /// An empty queue; its capacity is the length of `items`, whose content does not matter.
    #[must_use]
    pub const fn new(items: &'a mut [T]) -> Self {
        Self { items, first: 0, len: 0 }
    }

    /// Appends a value; `false` if there is no room.
    #[must_use]
    pub fn enqueue(&mut self, value: T) -> bool {
        let at = self.wrap(self.first.saturating_add(self.len));
        let full = self.is_full();
        match self.items.get_mut(at) {
            Some(place) if !full => {
                *place = value;
                self.len = self.len.saturating_add(1);
                true
            }
            _ => false,
        }
    }

    /// Takes the oldest value.
    pub fn dequeue(&mut self) -> Option<T> {
        if self.len == 0 {
            return None;
        }
        let value = self.items.get(self.first).copied();
        self.first = self.wrap(self.first.saturating_add(1));
        self.len = self.len.saturating_sub(1);
        value
    }

    /// All values in one piece, to be put in another order: the first is the next.
    pub(crate) fn as_mut_slice(&mut self) -> &mut [T] {
        let wraps = self.first.saturating_add(self.len) > self.items.len();
        if wraps && let Some((behind, front)) = self.items.split_at_mut_checked(self.first) {
            // Turned round by reversals: `rotate_left` takes two KiB of a board's flash, with what moves memory.
            behind.reverse();
            front.reverse();
            self.items.reverse();
            self.first = 0;
        }
        let end = self.first.saturating_add(self.len);
        self.items.get_mut(self.first..end).unwrap_or_default()
    }

    /// The oldest value.
    #[must_use]
    pub fn front(&self) -> Option<&T> {
        if self.len == 0 { None } else { self.items.get(self.first) }
    }

    /// The values, the oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &T> + Clone {
        let (behind, front) = self.items.split_at_checked(self.first).unwrap_or_default();
        front.iter().chain(behind).take(self.len)
    }

    /// Number of values.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Whether there is no room.
    #[must_use]
    pub const fn is_full(&self) -> bool {
        self.len == self.items.len()
    }

    /// Its values; they lie at the front afterwards.
    #[cfg(test)]
    pub(crate) fn snapshot(&mut self, snapshot: &mut crate::tests::snapshot::Snapshot)
    where
        T: bytemuck::Pod,
    {
        if !snapshot.reads() && self.first > 0 {
            self.items.rotate_left(self.first);
        }
        self.first = 0;
        snapshot.len(&mut self.len);
        snapshot.all(&mut self.items[..self.len]);
    }

    /// An index below twice the capacity, brought back below it.
    const fn wrap(&self, at: usize) -> usize {
        if at >= self.items.len() { at.saturating_sub(self.items.len()) } else { at }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn behaves_as_a_bounded_deque(
            capacity in 0_usize..6,
            steps in prop::collection::vec(any::<Option<u8>>(), 0..200),
        ) {
            let mut items = vec![0_u8; capacity];
            let mut queue = Queue::new(&mut items);
            let mut model = std::collections::VecDeque::new();
            for step in steps {
                match step {
                    Some(200..) => {
                        queue.as_mut_slice().reverse();
                        model.make_contiguous().reverse();
                    }
                    Some(x) if model.len() < capacity => {
                        model.push_back(x);
                        prop_assert!(queue.enqueue(x));
                    }
                    Some(x) => prop_assert!(!queue.enqueue(x)),
                    None => prop_assert_eq!(queue.dequeue(), model.pop_front()),
                }
                prop_assert_eq!(queue.len(), model.len());
                prop_assert_eq!(queue.front(), model.front());
                prop_assert_eq!(queue.is_full(), model.len() == capacity);
            }
            let rest: Vec<_> = core::iter::from_fn(|| queue.dequeue()).collect();
            prop_assert_eq!(rest, Vec::from(model));
        }
    }
}
