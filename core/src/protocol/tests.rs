use super::*;
use crate::network::{Channel, NodeId};
use crate::path::PathKey;
use crate::shade::Sum;
use bytemuck::{AnyBitPattern, bytes_of};
use proptest::prelude::*;

/// Any bits of a plain type: its fields are private here, and any of them may come over a link.
fn any_bits<T: AnyBitPattern + core::fmt::Debug>() -> impl Strategy<Value = T> {
    prop::collection::vec(any::<u8>(), size_of::<T>())
        .prop_map(|bytes| bytemuck::pod_read_unaligned(&bytes))
}

/// A message that owns its bytes.
#[derive(Debug, Clone)]
enum Any {
    Plain(Message<'static>),
    Part(u32, u32, Vec<u8>),
    Pixels(u32, u32, Vec<u8>),
}

impl Any {
    fn get(&self) -> Message<'_> {
        match self {
            Self::Plain(message) => *message,
            Self::Part(block, offset, bytes) => {
                Message::Part { block: *block, offset: *offset, bytes }
            }
            Self::Pixels(tile, first, sums) => Message::Pixels { tile: *tile, first: *first, sums },
        }
    }
}

fn messages() -> impl Strategy<Value = Any> {
    let bytes = || prop::collection::vec(any::<u8>(), 0..300);
    let to = any_bits::<ReturnAddress>;
    let plain = prop_oneof![
        any::<[u32; 2]>().prop_map(|[block, offset]| Message::Fetch { block, offset }),
        any::<[u32; 2]>().prop_map(|[number, count]| Message::Ask { number, count }),
        any::<[u32; 4]>().prop_map(|[number, first, count, wait]| Message::Grant {
            number,
            first,
            count,
            wait
        }),
        any::<u32>().prop_map(|tile| Message::Accepted { tile }),
        any::<u32>().prop_map(|block| Message::Lost { block }),
        any_bits().prop_map(Message::Ray),
        (to(), any::<[i64; 3]>()).prop_map(|(to, sum)| Message::Answer { to, sum: Sum(sum) }),
        to().prop_map(|to| Message::Refusal { to }),
        to().prop_map(|to| Message::AtWork { to }),
    ];
    let words = any::<[u32; 2]>();
    prop_oneof![
        9 => plain.prop_map(Any::Plain),
        1 => (words, bytes()).prop_map(|([a, b], bytes)| Any::Part(a, b, bytes)),
        1 => (words, bytes()).prop_map(|([a, b], bytes)| Any::Pixels(a, b, bytes)),
    ]
}

/// All of them in a payload.
fn payload(messages: &[Any]) -> Vec<u8> {
    let mut bytes = vec![0xa5; 1 << 16];
    let len =
        messages.iter().fold(0, |len, message| write(&mut bytes, len, &message.get()).unwrap());
    bytes.truncate(len);
    bytes
}

/// Whether two messages are the same, floats to the bit.
fn same(a: &Message<'_>, b: &Message<'_>) -> bool {
    match (a, b) {
        (Message::Ray(a), Message::Ray(b)) => bytes_of(a) == bytes_of(b),
        _ => a == b,
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read(messages in prop::collection::vec(messages(), 0..12)) {
        let bytes = payload(&messages);
        let mut items = Items::new(&bytes);
        for message in &messages {
            prop_assert!(items.next().is_some_and(|read| same(&read, &message.get())));
        }
        prop_assert!(items.next().is_none() && !items.is_damaged() && items.rest_len() == 0);
    }

    #[test]
    fn a_message_without_room_leaves_what_is_there(
        before in messages(), message in messages(), room in 0_usize..700,
    ) {
        let mut bytes = payload(core::slice::from_ref(&before));
        let (len, copy) = (bytes.len(), bytes.clone());
        bytes.resize(len + room, 0);
        let needs = payload(core::slice::from_ref(&message)).len();
        let after = write(&mut bytes, len, &message.get());
        prop_assert_eq!(after, (needs <= room).then_some(len + needs));
        prop_assert_eq!(&bytes[..len], &copy[..]);
        prop_assert!(write(&mut bytes, usize::MAX - 2, &message.get()).is_none());
    }

    /// What stands before the cut is read; the rest is damage.
    #[test]
    fn a_cut_payload_gives_its_whole_messages(
        messages in prop::collection::vec(messages(), 1..6), at: prop::sample::Index,
    ) {
        let bytes = payload(&messages);
        let cut = at.index(bytes.len());
        let ends: Vec<_> = (0..=messages.len()).map(|n| payload(&messages[..n]).len()).collect();
        let whole = ends.iter().filter(|&&end| end <= cut).count() - 1;
        let mut items = Items::new(&bytes[..cut]);
        for message in &messages[..whole] {
            prop_assert!(items.next().is_some_and(|read| same(&read, &message.get())));
        }
        prop_assert!(items.next().is_none());
        prop_assert_eq!(items.is_damaged(), ends[whole] != cut);
        prop_assert!(items.next().is_none() && items.rest_len() == 0);
    }

    /// Whatever is read of a changed payload stands in it: written again it gives the same bytes, but for the byte of an item's
    /// head that says nothing.
    #[test]
    fn a_changed_payload_gives_what_it_holds(
        messages in prop::collection::vec(messages(), 1..6),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
    ) {
        let mut bytes = payload(&messages);
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        let mut items = Items::new(&bytes);
        let mut again = vec![0; bytes.len()];
        let (mut len, mut count) = (0, 0);
        for message in &mut items {
            let end = write(&mut again, len, &message).unwrap();
            again[len + 1] = bytes[len + 1];
            len = end;
            count += 1;
        }
        prop_assert_eq!(&again[..len], &bytes[..len]);
        prop_assert_eq!(items.is_damaged(), len < bytes.len());
        prop_assert!(count <= bytes.len() / Item::BYTES);
    }

    #[test]
    fn any_bytes_are_read_to_their_end(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut items = Items::new(&bytes);
        let count = items.by_ref().count();
        prop_assert!(count <= bytes.len() / Item::BYTES && items.rest_len() == 0);
    }

    #[test]
    fn an_address_is_what_it_was_made_of(node: u16, slot: u16, path: u64, sample: u32) {
        let key = PathKey { path, sample };
        let to = ReturnAddress::new(NodeId(node), slot, key);
        prop_assert_eq!((to.node(), to.slot(), to.key()), (NodeId(node), slot, key));
    }
}

/// The bytes of each message, as they go over a link: a change of these is a change of the protocol.
#[test]
fn messages_are_these_bytes() {
    let to = ReturnAddress::new(
        NodeId(0x0201),
        0x0403,
        PathKey { path: 0x0c0b_0a09_0807_0605, sample: 0x100f_0e0d },
    );
    let address: Vec<u8> = (1..=16).collect();
    let bytes = [0xee, 0xff];
    let words = |kind: u8, words: &[u32]| {
        let fields = words.iter().flat_map(|w| w.to_le_bytes());
        [kind, 0, 4 * words.len() as u8, 0].into_iter().chain(fields).collect::<Vec<_>>()
    };
    let run = |kind: u8| [kind, 0, 10, 0, 7, 0, 0, 0, 0, 1, 0, 0, 0xee, 0xff].to_vec();
    let reply = |kind: u8, more: &[u8]| {
        let len = [kind, 0, (16 + more.len()) as u8, 0];
        [&len[..], &address, more].concat()
    };
    let sum = [&[1_u8][..], &[0; 7], &[255; 8], &[0; 7], &[0x80]].concat();
    for (message, expected) in [
        (Message::Fetch { block: 7, offset: 8 }, words(1, &[7, 8])),
        (Message::Part { block: 7, offset: 256, bytes: &bytes }, run(2)),
        (Message::Ask { number: 1, count: 2 }, words(3, &[1, 2])),
        (Message::Grant { number: 1, first: 2, count: 3, wait: 4 }, words(4, &[1, 2, 3, 4])),
        (Message::Pixels { tile: 7, first: 256, sums: &bytes }, run(5)),
        (Message::Accepted { tile: 7 }, words(6, &[7])),
        (Message::Lost { block: u32::MAX }, words(7, &[u32::MAX])),
        (Message::Answer { to, sum: Sum([1, -1, i64::MIN]) }, reply(9, &sum)),
        (Message::Refusal { to }, reply(10, &[])),
        (Message::AtWork { to }, reply(11, &[])),
    ] {
        let mut out = [0; 64];
        let len = write(&mut out, 0, &message).unwrap();
        assert_eq!(out[..len], expected, "{message:?}");
    }
    assert_eq!(Item::RAY_BYTES, 4 + size_of::<RayMessage>());
    assert_eq!(Item::PART_BYTES + bytes.len(), run(2).len());
}

#[test]
fn what_is_too_long_for_an_item_is_not_written() {
    let bytes = vec![0; 1 << 16];
    let mut out = vec![0; 1 << 17];
    let part = |len: usize| Message::Part { block: 0, offset: 0, bytes: &bytes[..len] };
    assert_eq!(write(&mut out, 0, &part(65_527)), Some(4 + 65_535));
    assert_eq!(write(&mut out, 0, &part(65_528)), None);
}

/// Answers travel as replies, so that they never wait behind requests (the first rule of progress).
#[test]
fn what_answers_is_a_reply() {
    let to = ReturnAddress::new(NodeId(0), 0, PathKey { path: 0, sample: 0 });
    let replies = [
        Message::Part { block: 0, offset: 0, bytes: &[] },
        Message::Grant { number: 0, first: 0, count: 0, wait: 0 },
        Message::Accepted { tile: 0 },
        Message::Answer { to, sum: Sum::ZERO },
        Message::Refusal { to },
        Message::AtWork { to },
    ];
    assert!(replies.iter().all(|m| m.channel() == Channel::Reply));
    let requests = [
        Message::Fetch { block: 0, offset: 0 },
        Message::Ask { number: 0, count: 0 },
        Message::Pixels { tile: 0, first: 0, sums: &[] },
        Message::Lost { block: 0 },
        Message::Ray(bytemuck::Zeroable::zeroed()),
    ];
    assert!(requests.iter().all(|m| m.channel() == Channel::Request));
}
