use super::{Next, Node, Time, World};
use crate::network::{Port, Router};
use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use core::future::{Future, poll_fn};
use core::pin::pin;
use core::task::Poll;
use embassy_futures::join::{join, join_array};
use embassy_futures::yield_now;

/// What [`run`] drives: a [`Node`], or the host beside the mesh.
pub trait Actor<'m> {
    /// Takes a step, and says when the next may be.
    fn poll(&mut self, now: Time) -> Next;

    /// Its end of the network.
    fn router(&mut self) -> &mut Router<'m>;
}

impl<'m, W: World> Actor<'m> for Node<'m, W> {
    fn poll(&mut self, now: Time) -> Next {
        Node::poll(self, now).next
    }

    fn router(&mut self) -> &mut Router<'m> {
        Node::router(self)
    }
}

/// The half of a link that packets come from.
#[allow(async_fn_in_trait, reason = "an actor and its links are one task: they need not be `Send`")]
pub trait Receive {
    /// Waits for a packet, writes it to `into` and gives its length.
    ///
    /// A link may lose packets, double them, or let one overtake another, but must know damaged ones and drop them. One that is broken waits for
    /// ever.
    async fn receive(&mut self, into: &mut [u8]) -> usize;
}

/// The half of a link that takes packets.
#[allow(async_fn_in_trait, reason = "an actor and its links are one task: they need not be `Send`")]
pub trait Transmit {
    /// Sends a packet, and waits until the link takes another.
    async fn transmit(&mut self, packet: &[u8]);
}

/// A node's clock.
#[allow(async_fn_in_trait, reason = "an actor and its links are one task: they need not be `Send`")]
pub trait Clock {
    /// The time since its start.
    fn now(&self) -> Time;

    /// Waits until a moment; for ever if it is [`Time::NEVER`]. It may be dropped before.
    async fn wait(&self, until: Time);
}

/// What is joined to a port: a link, and room for a packet in each direction, header included.
#[derive(Debug)]
pub struct Joint<'b, R, T> {
    /// The port.
    pub port: Port,
    /// Where packets come from.
    pub receive: R,
    /// Where packets go.
    pub transmit: T,
    /// The packet that is coming.
    pub incoming: &'b mut [u8],
    /// The packet that is leaving.
    pub outgoing: &'b mut [u8],
}

/// Runs an actor over its links: forever, until it is dropped.
///
/// The actor takes a step when a packet has come or left its buffers, when its own time limit has passed, or while it has work; between
/// two steps each link goes on. At intervals of `reminder` credit that is overdue is asked for ([`Router::remind`]): what a round trip
/// takes some times over, or [`Time::NEVER`] where links lose nothing.
///
/// All is one task: no part of it wakes another, but has the whole polled again ([`yield_now`]).
pub async fn run<'m, A: Actor<'m>, R: Receive, T: Transmit, const N: usize>(
    actor: &mut A,
    joints: [Joint<'_, R, T>; N],
    clock: &impl Clock,
    reminder: Time,
) -> Infallible {
    let shared = Shared { actor: RefCell::new(actor), news: Cell::new(false) };
    let links = joints.map(|Joint { port, receive, transmit, incoming, outgoing }| {
        join(shared.receive(port, receive, incoming), shared.transmit(port, transmit, outgoing))
    });
    join(shared.step(clock, reminder), join_array(links)).await.0
}

/// The actor, as steps and links share it: none holds it while it waits.
struct Shared<'s, A> {
    actor: RefCell<&'s mut A>,
    /// A packet has come, or made room, since the last step began.
    news: Cell<bool>,
}

impl<'m, A: Actor<'m>> Shared<'_, A> {
    /// What `f` makes of the actor.
    fn with<X>(&self, f: impl FnOnce(&mut A) -> X) -> Option<X> {
        let actor = self.actor.try_borrow_mut();
        debug_assert!(actor.is_ok(), "nobody holds the actor while it waits");
        actor.ok().map(|mut actor| f(&mut actor))
    }

    async fn step(&self, clock: &impl Clock, reminder: Time) -> Infallible {
        let mut remind = clock.now().after(reminder);
        loop {
            let now = clock.now();
            self.news.set(false);
            if now >= remind {
                self.with(|actor| actor.router().remind());
                remind = now.after(reminder);
            }
            let next = self.with(|actor| actor.poll(now));
            // What it has made may leave.
            yield_now().await;
            if let Some(Next::Wait { until, .. }) = next {
                let mut late = pin!(clock.wait(until.min(remind)));
                poll_fn(|cx| match late.as_mut().poll(cx) {
                    Poll::Pending if !self.news.get() => Poll::Pending,
                    _ => Poll::Ready(()),
                })
                .await;
            }
        }
    }

    async fn receive(&self, port: Port, mut link: impl Receive, packet: &mut [u8]) -> Infallible {
        loop {
            let len = link.receive(packet).await;
            let packet = packet.get(..len).unwrap_or_default();
            self.with(|actor| actor.router().receive(port, packet, |_| false));
            self.tell().await;
        }
    }

    async fn transmit(&self, port: Port, mut link: impl Transmit, packet: &mut [u8]) -> Infallible {
        loop {
            let len = poll_fn(|_| {
                let len = self.with(|actor| actor.router().transmit(port, packet)).flatten();
                len.map_or(Poll::Pending, Poll::Ready)
            });
            let len = len.await;
            self.tell().await;
            link.transmit(packet.get(..len).unwrap_or_default()).await;
        }
    }

    /// Lets the actor know.
    async fn tell(&self) {
        self.news.set(true);
        yield_now().await;
    }
}
