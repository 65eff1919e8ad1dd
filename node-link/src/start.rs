use core::fmt;

use embassy_futures::select::{Either, select, select_array};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embedded_io_async::{Read, Write};
use kiloray_core::network::{PacketHeader, Port};
use kiloray_core::node::{Clock, Joint, Receive, Setup, Time, Transmit};

use crate::{Receiver, Sender, Tally};

/// The first byte of a frame that asks for the setup: none of a packet. Behind it is the version that is asked for; version 1 had none.
const ASK: u8 = PacketHeader::CONTROL + 1;
/// The first byte of a frame that holds it, or only its version where another was asked for.
const SETUP: u8 = ASK + 1;
/// A frame with a setup.
const SETUP_BYTES: usize = 1 + Setup::BYTES;
/// What both ends understand, whatever their versions.
const VERSION_BYTES: usize = size_of::<u32>();

/// Why a node that has asked has no setup.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NoSetup {
    /// Those that run use another version of it.
    Version(u32),
    /// It has a number that cannot be.
    Unsound,
}

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
///
/// # Errors
/// [`NoSetup`]: to ask again is of no use.
pub async fn ask<R: Read, W: Write, B: AsMut<[u8]>, const N: usize>(
    links: [&mut Link<'_, R, W, B>; N],
    clock: &impl Clock,
    every: Time,
) -> Result<Setup, NoSetup> {
    let mut senders = [const { None }; N];
    let mut next = senders.iter_mut();
    let answers = select_array(links.map(|link| {
        let Link { receiver, sender, incoming, .. } = link;
        if let Some(place) = next.next() {
            *place = Some(&*sender);
        }
        answer(receiver, incoming.as_mut())
    }));
    let question = with_version(ASK);
    let questions = async {
        loop {
            for mut link in senders.iter().copied().flatten() {
                link.transmit(&question).await;
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
async fn answer(link: &mut impl Receive, room: &mut [u8]) -> Result<Setup, NoSetup> {
    loop {
        let len = link.receive(room).await;
        if let Some((&SETUP, setup)) = room.get(..len).and_then(<[u8]>::split_first)
            && let Some(version) = version(setup)
        {
            return match version {
                Setup::VERSION => Setup::parse(setup).ok_or(NoSetup::Unsound),
                other => Err(NoSetup::Version(other)),
            };
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
struct Answering<'s, 't, R, T> {
    receiver: &'s mut Receiver<'t, R>,
    sender: &'s Shared<T>,
    setup: &'s Setup,
}

impl<R: Read, T: Transmit> Receive for Answering<'_, '_, R, T> {
    async fn receive(&mut self, into: &mut [u8]) -> usize {
        loop {
            let len = self.receiver.receive(into).await;
            let mut sender = self.sender;
            match into.get(..len).and_then(<[u8]>::split_first) {
                Some((&ASK, asked)) => match version(asked).unwrap_or(1) {
                    Setup::VERSION => sender.transmit(&frame(self.setup)).await,
                    other => {
                        let tally = self.receiver.tally();
                        tally.update(|counts| counts.other_version = Some(other));
                        sender.transmit(&with_version(SETUP)).await;
                    }
                },
                // It is known already.
                Some((&SETUP, _)) => {}
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

/// A frame of a first byte and our version.
fn with_version(first: u8) -> [u8; 1 + VERSION_BYTES] {
    let [a, b, c, d] = Setup::VERSION.to_le_bytes();
    [first, a, b, c, d]
}

/// The version behind the first byte: a setup begins with it.
fn version(bytes: &[u8]) -> Option<u32> {
    bytes.first_chunk().map(|version| u32::from_le_bytes(*version))
}

impl fmt::Display for NoSetup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Version(other) => {
                let own = Setup::VERSION;
                write!(f, "the mesh has version {other} of it, and this node version {own}")
            }
            Self::Unsound => f.write_str("it is of a mesh that cannot be"),
        }
    }
}

impl core::error::Error for NoSetup {}
