//! Some windows in a row, in which parts of the mesh wait for their neighbours alone.

use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, TryLockError};

use kiloray_core::network::{HOST, NodeId};
use rayon::prelude::*;

use super::journal::{Departure, Journal};
use super::{Actor, Place};

/// A part of the mesh, that one thread at a time takes through a window: some nodes that follow one another, or the host.
#[derive(Debug, Default)]
pub(super) struct Part {
    /// Windows of this round that it has gone through.
    done: AtomicU32,
    /// The parts that packets come from, and go to.
    neighbours: Vec<u32>,
    /// What departed for here in an even window, and in an odd one: neighbours are a window ahead at most.
    mail: [Mutex<Vec<Departure>>; 2],
}

/// All parts, the host's behind those of the nodes.
#[derive(Debug)]
pub(super) struct Parts {
    all: Vec<Part>,
    /// Nodes of a part.
    size: usize,
}

/// The places of a part.
pub(super) enum Places<'a, 'm, N, H> {
    Nodes(&'a mut [Place<'m, N>]),
    Host(&'a mut Place<'m, H>),
}

/// A part, for the length of a round.
pub(super) struct Task<'a, 'm, N, H> {
    pub(super) places: Places<'a, 'm, N, H>,
    /// When the next thing happens, by place.
    pub(super) due: &'a mut [u64],
    pub(super) journal: &'a mut Journal,
}

/// So many windows, one behind the other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Round<'r> {
    pub(super) parts: &'r Parts,
    /// \[ns\]
    pub(super) begin: u64,
    /// The length of a window \[ns\].
    pub(super) window: u64,
    pub(super) windows: u32,
}

/// Looks for work in vain before a thread lets others have its processor.
const PATIENCE: u32 = 64;

impl Parts {
    /// At most so many parts of nodes, which have the neighbours that `links` tells of, and that of the host.
    pub(super) fn new(
        nodes: usize,
        most: usize,
        links: impl Iterator<Item = (NodeId, NodeId)>,
    ) -> Self {
        let size = nodes.div_ceil(most).max(1);
        let count = nodes.div_ceil(size);
        let mut parts = Self { all: Vec::new(), size };
        parts.all.resize_with(count + 1, Part::default);
        for (from, to) in links {
            let [from, to] = [from, to].map(|place| parts.of(place));
            for (one, other) in [(from, to), (to, from)] {
                let neighbours = &mut parts.all[one].neighbours;
                if one != other && !neighbours.contains(&(other as u32)) {
                    neighbours.push(other as u32);
                }
            }
        }
        parts
    }

    /// The number of parts, that of the host included.
    pub(super) fn len(&self) -> usize {
        self.all.len()
    }

    /// Nodes of a part.
    pub(super) const fn size(&self) -> usize {
        self.size
    }

    /// The part of a place.
    fn of(&self, place: NodeId) -> usize {
        if place == HOST { self.all.len() - 1 } else { usize::from(place.0) / self.size }
    }
}

impl<'m, N: Actor<'m>, H: Actor<'m>> Task<'_, 'm, N, H> {
    /// Takes in what departed for here. Of one time, packets of lower places come first, whatever thread was faster.
    fn receive(&mut self, mail: &Mutex<Vec<Departure>>, size: usize) {
        let mut mail = mail.lock().expect("no thread has panicked");
        mail.sort_by_key(|departure| departure.from.0);
        for departure in mail.drain(..) {
            let at = match self.places {
                Places::Nodes(_) => usize::from(departure.to.0) % size,
                Places::Host(_) => 0,
            };
            self.due[at] = departure.arrival.min(self.due[at]);
            match &mut self.places {
                Places::Nodes(nodes) => nodes[at].receive(departure),
                Places::Host(host) => host.receive(departure),
            }
        }
    }

    fn advance(&mut self, end: u64) {
        fn all<'m, A: Actor<'m>>(
            places: &mut [Place<'m, A>],
            due: &mut [u64],
            end: u64,
            journal: &mut Journal,
        ) {
            for (place, due) in places.iter_mut().zip(due).filter(|(_, due)| **due < end) {
                place.advance(end, journal);
                *due = place.due();
            }
        }
        match &mut self.places {
            Places::Nodes(nodes) => all(nodes, self.due, end, self.journal),
            Places::Host(host) => all(std::slice::from_mut(*host), self.due, end, self.journal),
        }
    }
}

impl Round<'_> {
    /// Takes all through the round: on all threads of the pool, if there are several parts of nodes.
    ///
    /// A round of one window ends with the run, if the host sees its end.
    pub(super) fn run<'m, N: Actor<'m> + Send, H: Actor<'m> + Send>(
        mut self,
        mut tasks: Vec<Task<'_, 'm, N, H>>,
    ) {
        for part in &self.parts.all {
            part.done.store(0, Ordering::Relaxed);
        }
        if self.windows == 1
            && let Some(task) = tasks.last_mut()
        {
            self.step(self.parts.len() - 1, task);
            if let Places::Host(host) = &task.places
                && host.actor.has_ended()
            {
                // Of what happens now all shall have happened.
                self.window = host.now.saturating_add(1) - self.begin;
            }
        }
        let tasks: Vec<_> = tasks.into_iter().map(Mutex::new).collect();
        if tasks.len() <= 2 {
            self.work(&tasks, 0, 1);
        } else {
            let threads = rayon::current_num_threads();
            (0..threads).into_par_iter().with_max_len(1).for_each(|_| {
                self.work(&tasks, rayon::current_thread_index().unwrap_or(0), threads);
            });
        }
        let last = self.windows - 1;
        for (task, part) in tasks.into_iter().zip(&self.parts.all) {
            let mut task = task.into_inner().expect("no thread has panicked");
            task.receive(part.mail(last), self.parts.size);
        }
    }

    /// Works until the round is over, as one of so many threads: on the parts whose turn it is, first on its own, which lie in its caches.
    fn work<'m, N: Actor<'m>, H: Actor<'m>>(
        &self,
        tasks: &[Mutex<Task<'_, 'm, N, H>>],
        thread: usize,
        threads: usize,
    ) {
        let count = tasks.len();
        let own = count.div_ceil(threads);
        let first = thread * own % count;
        let (mut left, mut vain) = (true, 0);
        while std::mem::take(&mut left) {
            let mut moved = false;
            // Of the others' parts the last first: they begin with the others.
            for at in (0..own).chain((own..count).rev()) {
                let is_own = at < own;
                if moved && !is_own {
                    left = true;
                    break;
                }
                let at = (first + at) % count;
                left |= !self.is_done(at);
                if !self.is_ready(at) {
                    continue;
                }
                match tasks[at].try_lock() {
                    Ok(mut task) if self.is_ready(at) => {
                        self.step(at, &mut task);
                        moved = true;
                    }
                    Ok(_) | Err(TryLockError::WouldBlock) => {}
                    Err(TryLockError::Poisoned(_)) => panic!("another thread has panicked"),
                }
            }
            vain = if moved { 0 } else { vain + 1 };
            match vain {
                0 => {}
                1..PATIENCE => std::hint::spin_loop(),
                _ => std::thread::yield_now(),
            }
        }
    }

    fn is_done(&self, at: usize) -> bool {
        self.parts.all[at].done.load(Ordering::Acquire) >= self.windows
    }

    /// Whether a part can go on: its neighbours have gone through the window before its next.
    fn is_ready(&self, at: usize) -> bool {
        let done = |part: &Part| part.done.load(Ordering::Acquire);
        let part = &self.parts.all[at];
        let next = done(part);
        let mut neighbours = part.neighbours.iter().map(|&at| &self.parts.all[at as usize]);
        next < self.windows && neighbours.all(|part| done(part) >= next)
    }

    /// Takes a part through its next window.
    fn step<'m, N: Actor<'m>, H: Actor<'m>>(&self, at: usize, task: &mut Task<'_, 'm, N, H>) {
        let Self { parts, begin, window, .. } = *self;
        let part = &parts.all[at];
        let number = part.done.load(Ordering::Acquire);
        task.receive(part.mail(number.wrapping_sub(1)), parts.size);
        task.advance(begin.saturating_add(window.saturating_mul(u64::from(number) + 1)));
        let mut open = None;
        for departure in task.journal.departures.drain(..) {
            let to = parts.of(departure.to);
            if open.as_ref().is_none_or(|(at, _)| *at != to) {
                // One at a time.
                drop(open.take());
                let mail = parts.all[to].mail(number).lock().expect("no thread has panicked");
                open = Some((to, mail));
            }
            if let Some((_, mail)) = &mut open {
                mail.push(departure);
            }
        }
        drop(open);
        part.done.store(number + 1, Ordering::Release);
    }
}

impl Part {
    /// What departs for here in a window.
    fn mail(&self, window: u32) -> &Mutex<Vec<Departure>> {
        let [even, odd] = &self.mail;
        if window.is_multiple_of(2) { even } else { odd }
    }
}
