//! How a node learns what run it is part of, where the far end is of the same version, and where it is not.

use std::cell::RefCell;
use std::convert::Infallible;
use std::future::{pending, poll_fn};
use std::mem::offset_of;
use std::pin::pin;
use std::task::Poll;
use std::vec::Vec;

use bytemuck::Zeroable;
use embassy_futures::block_on;
use embedded_io_async::{ErrorType, Read, Write};
use kiloray_core::network::{PacketHeader, Port, Topology};
use kiloray_core::node::{Clock, Joint, Receive, Setup, Time};

use crate::frame::{CRC_BYTES, Decoder, encode, frame_bytes};
use crate::{Link, NoSetup, Tally, ask};

const ASK: u8 = PacketHeader::CONTROL + 1;
const SETUP: u8 = ASK + 1;
const ROOM: usize = frame_bytes(1 + Setup::BYTES);

/// A line that brings these bytes and then nothing, and keeps what is sent.
struct Line<'a> {
    brings: Vec<u8>,
    sent: &'a RefCell<Vec<u8>>,
}

impl ErrorType for Line<'_> {
    type Error = Infallible;
}

impl Read for Line<'_> {
    async fn read(&mut self, into: &mut [u8]) -> Result<usize, Infallible> {
        let len = self.brings.len().min(into.len());
        if len == 0 {
            pending::<()>().await;
        }
        into[..len].copy_from_slice(&self.brings[..len]);
        self.brings.drain(..len);
        Ok(len)
    }
}

impl Write for Line<'_> {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        self.sent.borrow_mut().extend(bytes);
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// No time passes.
struct Stopped;

impl Clock for Stopped {
    fn now(&self) -> Time {
        Time(0)
    }

    async fn wait(&self, _: Time) {
        pending().await
    }
}

fn framed(packet: &[u8]) -> Vec<u8> {
    let mut frame = vec![0; frame_bytes(packet.len())];
    let len = encode(packet, &mut frame).expect("there is room");
    frame.truncate(len);
    frame
}

fn packets(stream: &[u8]) -> Vec<Vec<u8>> {
    let (mut decoder, mut into) = (Decoder::new(), vec![0; ROOM + CRC_BYTES]);
    let ends = stream.iter().filter_map(|&byte| {
        let len = decoder.push(byte, &mut into)?.expect("it is sound");
        Some(into[..len].to_vec())
    });
    ends.collect()
}

fn setup() -> Setup {
    let setup = Setup { version: Setup::VERSION, width: 7, ..Setup::zeroed() };
    setup.with_topology(&Topology::parse("ring", 4).expect("a ring"))
}

fn with_version(first: u8, version: u32) -> Vec<u8> {
    [&[first], &version.to_le_bytes()[..]].concat()
}

/// What comes of asking a far end that says this, and what is sent to it.
fn asked(answer: &[u8]) -> (Result<Setup, NoSetup>, Vec<Vec<u8>>) {
    let (sent, tally) = (RefCell::new(Vec::new()), Tally::new());
    let line = |brings| Line { brings, sent: &sent };
    let rooms = [(); 3].map(|()| vec![0; ROOM]);
    let mut link = Link::new(line(framed(answer)), line(Vec::new()), rooms, &tally);
    let got = block_on(ask([&mut link], &Stopped, Time(1)));
    let sent = packets(&sent.borrow());
    (got, sent)
}

/// What somebody who runs answers, and which other version was asked for.
fn answers(question: &[u8]) -> (Vec<Vec<u8>>, Option<u32>) {
    let (sent, tally, setup) = (RefCell::new(Vec::new()), Tally::new(), setup());
    let line = |brings| Line { brings, sent: &sent };
    let rooms = [(); 3].map(|()| vec![0; ROOM]);
    let mut link = Link::new(line(framed(question)), line(Vec::new()), rooms, &tally);
    let Joint { mut receive, incoming, .. } = link.joint(Port(0), &setup);
    // No question is a packet for the actor.
    block_on(async {
        let mut packet = pin!(receive.receive(incoming));
        poll_fn(|cx| {
            assert!(packet.as_mut().poll(cx).is_pending());
            Poll::Ready(())
        })
        .await;
    });
    (packets(&sent.borrow()), tally.get().other_version)
}

#[test]
fn a_setup_that_cannot_be_is_none() {
    let tree = |nodes, arity| setup().with_topology(&Topology::Tree { nodes, arity });
    let full = |nodes| setup().with_topology(&Topology::Full { nodes });
    let other = Setup { version: Setup::VERSION + 1, ..setup() };
    for setup in [other, tree(0, 1), tree(9, 0), tree(9, 10), full(0)] {
        assert!(Setup::parse(bytemuck::bytes_of(&setup)).is_none(), "{:?}", setup.mesh());
    }
    assert!(Setup::parse(bytemuck::bytes_of(&tree(9, 9))).is_some());
}

#[test]
fn a_setup_of_the_same_version_is_asked_for_and_given() {
    let question = with_version(ASK, Setup::VERSION);
    let answer = [&[SETUP], bytemuck::bytes_of(&setup())].concat();
    assert_eq!(answers(&question), (vec![answer.clone()], None));
    let (got, _) = asked(&answer);
    assert_eq!(got, Ok(setup()));
}

#[test]
fn ends_of_different_versions_both_find_out() {
    for other in [Setup::VERSION - 1, Setup::VERSION + 1, u32::MAX] {
        // Whatever its length is.
        for behind in [0, 3, Setup::BYTES - 4] {
            let answer = [with_version(SETUP, other), vec![1; behind]].concat();
            assert_eq!(asked(&answer).0, Err(NoSetup::Version(other)));
        }
        let answer = with_version(SETUP, Setup::VERSION);
        assert_eq!(answers(&with_version(ASK, other)), (vec![answer], Some(other)));
    }
    // The first version said nothing of itself.
    assert_eq!(answers(&[ASK]).1, Some(1));
}

#[test]
fn a_setup_that_cannot_be_is_an_error_too() {
    let unsound = Setup { topology: 9, ..setup() };
    let answer = [&[SETUP], bytemuck::bytes_of(&unsound)].concat();
    assert_eq!(asked(&answer).0, Err(NoSetup::Unsound));
    assert_eq!(asked(&answer[..40]).0, Err(NoSetup::Unsound));
}

/// Another layout is another version: whoever changes one changes the other, here too.
#[test]
fn a_version_is_a_layout() {
    let places = [offset_of!(Setup, seed), offset_of!(Setup, width), offset_of!(Setup, camera)];
    assert_eq!((Setup::VERSION, Setup::BYTES, places), (14, 176, [40, 72, 100]));
}
