use embassy_futures::select::{Either, select, select_array};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embedded_io_async::{Read, Write};
use kiloray_core::network::{PacketHeader, Port};
use kiloray_core::node::{Clock, Joint, Receive, Setup, Time, Transmit};

use crate::{Receiver, Sender, Tally};

/// The first byte of a frame that asks for the setup: none of a packet.
const ASK: u8 = PacketHeader::CONTROL + 1;
/// The first byte of a frame that holds it.
const SETUP: u8 = ASK + 1;
/// A frame with a setup.
const SETUP_BYTES: usize = 1 + Setup::BYTES;

/// A serial link: both halves, and room for a packet in each direction.
///
/// `B` is room for a [frame](crate::frame::frame_bytes) of the longest packet, and of a setup.
#[derive(Debug)]
pub struct Link<'t, R, W, B> {
    receiver: Receiver<'t, R>,
    sender: Shared<Sender<'t, W, B>>,
    incoming: B,
    outgoing: B,
}

impl<'t, R: Read, W: Write, B: AsMut<[u8]>> Link<'t, R, W, B> {
    /// A link over a reader and a writer.
    pub fn new(reader: R, writer: W, rooms: [B; 3], tally: &'t Tally) -> Self {
        let [incoming, outgoing, frame] = rooms;
        let sender = Shared(Mutex::new(Sender::new(writer, frame, tally)));
        Self { receiver: Receiver::new(reader, tally), sender, incoming, outgoing }
    }

    /// The link at a port of an actor. Whoever asks for the setup gets it.
    pub fn joint<'s>(
        &'s mut self,
        port: Port,
        setup: &'s Setup,
    ) -> Joint<'s, impl Receive, impl Transmit> {
        let Self { receiver, sender, incoming, outgoing } = self;
        let (incoming, outgoing) = (incoming.as_mut(), outgoing.as_mut());
        let receive = Answering { receiver, sender, setup };
        Joint { port, receive, transmit: &*sender, incoming, outgoing }
    }
}

/// Asks over all links, at intervals of `every`, until one brings a setup. All other packets are dropped.
pub async fn ask<R: Read, W: Write, B: AsMut<[u8]>, const N: usize>(
    links: [&mut Link<'_, R, W, B>; N],
    clock: &impl Clock,
    every: Time,
) -> Setup {
    let mut senders = [const { None }; N];
    let mut next = senders.iter_mut();
    let answers = select_array(links.map(|link| {
        let Link { receiver, sender, incoming, .. } = link;
        if let Some(place) = next.next() {
            *place = Some(&*sender);
        }
        answer(receiver, incoming.as_mut())
    }));
    let questions = async {
        loop {
            for mut link in senders.iter().copied().flatten() {
                link.transmit(&[ASK]).await;
            }
            clock.wait(clock.now().after(every)).await;
        }
    };
    match select(answers, questions).await {
        Either::First((setup, _)) => setup,
        Either::Second(never) => never,
    }
}

/// Waits for a setup.
async fn answer(link: &mut impl Receive, room: &mut [u8]) -> Setup {
    loop {
        let len = link.receive(room).await;
        if let Some((&SETUP, setup)) = room.get(..len).and_then(<[u8]>::split_first)
            && let Some(setup) = Setup::parse(setup)
        {
            return setup;
        }
    }
}

/// The sending half of a link, which the actor and the answers to questions share.
#[derive(Debug)]
struct Shared<T>(Mutex<NoopRawMutex, T>);

impl<T: Transmit> Transmit for &Shared<T> {
    async fn transmit(&mut self, packet: &[u8]) {
        self.0.lock().await.transmit(packet).await;
    }
}

/// The receiving half of a link of somebody who has the setup, and gives it to whoever asks.
struct Answering<'s, R, T> {
    receiver: &'s mut R,
    sender: &'s Shared<T>,
    setup: &'s Setup,
}

impl<R: Receive, T: Transmit> Receive for Answering<'_, R, T> {
    async fn receive(&mut self, into: &mut [u8]) -> usize {
        loop {
            let len = self.receiver.receive(into).await;
            match into.first() {
                Some(&ASK) if len == 1 => {
                    let mut sender = self.sender;
                    sender.transmit(&frame(self.setup)).await;
                }
                // It is known already.
                Some(&SETUP) if len == SETUP_BYTES => {}
                _ => return len,
            }
        }
    }
}

fn frame(setup: &Setup) -> [u8; SETUP_BYTES] {
    let mut frame = [SETUP; SETUP_BYTES];
    if let Some(place) = frame.last_chunk_mut::<{ Setup::BYTES }>() {
        place.copy_from_slice(bytemuck::bytes_of(setup));
    }
    frame
}
