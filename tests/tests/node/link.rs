use kiloray_core::node::{Receive, Transmit};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::future::poll_fn;
use std::task::{Poll, Waker};

/// How often something happens.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Chance(u32);

impl Chance {
    pub(crate) const NEVER: Self = Self(0);

    pub(crate) const fn one_in(count: u32) -> Self {
        Self(count)
    }

    fn happens(self, random: &mut fastrand::Rng) -> bool {
        self.0 > 0 && random.u32(..self.0) == 0
    }
}

/// One direction of a link: it takes a packet when the last one has come.
#[derive(Debug)]
pub(crate) struct Link(RefCell<State>);

#[derive(Debug)]
struct State {
    packets: VecDeque<Vec<u8>>,
    sender: Option<Waker>,
    receiver: Option<Waker>,
    random: fastrand::Rng,
    loss: Chance,
    double: Chance,
}

impl Link {
    pub(crate) fn new(seed: u64, loss: Chance, double: Chance) -> Self {
        Self(RefCell::new(State {
            packets: VecDeque::new(),
            sender: None,
            receiver: None,
            random: fastrand::Rng::with_seed(seed),
            loss,
            double,
        }))
    }
}

impl Receive for &Link {
    async fn receive(&mut self, into: &mut [u8]) -> usize {
        poll_fn(|cx| {
            let mut state = self.0.borrow_mut();
            let Some(packet) = state.packets.pop_front() else {
                state.receiver = Some(cx.waker().clone());
                return Poll::Pending;
            };
            state.sender.take().into_iter().for_each(Waker::wake);
            into[..packet.len()].copy_from_slice(&packet);
            Poll::Ready(packet.len())
        })
        .await
    }
}

impl Transmit for &Link {
    async fn transmit(&mut self, packet: &[u8]) {
        let copies = {
            let State { random, loss, double, .. } = &mut *self.0.borrow_mut();
            if loss.happens(random) { 0 } else { 1 + usize::from(double.happens(random)) }
        };
        for _ in 0..copies {
            poll_fn(|cx| {
                let mut state = self.0.borrow_mut();
                if !state.packets.is_empty() {
                    state.sender = Some(cx.waker().clone());
                    return Poll::Pending;
                }
                state.packets.push_back(packet.to_vec());
                state.receiver.take().into_iter().for_each(Waker::wake);
                Poll::Ready(())
            })
            .await;
        }
    }
}
