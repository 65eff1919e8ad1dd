use super::{Message, RayMessage, ReturnAddress};
use crate::shade::Sum;
use bytemuck::{Pod, Zeroable, bytes_of};

/// What stands before each message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Item {
    kind: u8,
    /// Of a block: which request; of pixels: bytes of a channel. Else 0.
    extra: u8,
    /// Bytes that follow.
    len: u16,
}

impl Item {
    /// Its length.
    pub const BYTES: usize = size_of::<Self>();
    /// What a [`Message::Ray`] takes of a packet.
    pub const RAY_BYTES: usize = Self::BYTES + RayMessage::BYTES;
    /// What a [`Message::Part`] takes beside its bytes, and a [`Message::Pixels`] beside its sums.
    pub const PART_BYTES: usize = Self::BYTES + 8;
}

const FETCH: u8 = 1;
const PART: u8 = 2;
const ASK: u8 = 3;
const GRANT: u8 = 4;
const PIXELS: u8 = 5;
const ACCEPTED: u8 = 6;
const LOST: u8 = 7;
const RAY: u8 = 8;
const ANSWER: u8 = 9;
const REFUSAL: u8 = 10;
const AT_WORK: u8 = 11;
const IDLE: u8 = 12;
const GONE: u8 = 13;
const TELL: u8 = 14;
const TOLD: u8 = 15;

/// Writes a message behind the first `len` bytes of `out`: the new length, or `None` if there is no room.
#[must_use]
pub fn write(out: &mut [u8], len: usize, message: &Message<'_>) -> Option<usize> {
    let mut words = [0_u32; 4];
    let extra = match message {
        Message::Fetch { request: extra, .. }
        | Message::Part { request: extra, .. }
        | Message::Pixels { width: extra, .. } => *extra,
        _ => 0,
    };
    let (kind, fields, rest): (u8, &[u8], &[u8]) = match message {
        Message::Fetch { block, offset, .. } => {
            (FETCH, words_of(&mut words, &[*block, *offset]), &[])
        }
        Message::Part { block, offset, bytes, .. } => {
            (PART, words_of(&mut words, &[*block, *offset]), bytes)
        }
        Message::Ask { number, count } => (ASK, words_of(&mut words, &[*number, *count]), &[]),
        Message::Grant { number, first, count, wait } => {
            (GRANT, words_of(&mut words, &[*number, *first, *count, *wait]), &[])
        }
        Message::Pixels { tile, first, sums, .. } => {
            (PIXELS, words_of(&mut words, &[*tile, *first]), sums)
        }
        Message::Accepted { tile } => (ACCEPTED, words_of(&mut words, &[*tile]), &[]),
        Message::Lost { block } => (LOST, words_of(&mut words, &[*block]), &[]),
        Message::Ray(ray) => (RAY, &ray[..], &[]),
        Message::Answer { to, sum } => {
            return put(out, len, (ANSWER, 0), bytes_of(to), bytes_of(&split(*sum)));
        }
        Message::Refusal { to } => (REFUSAL, bytes_of(to), &[]),
        Message::AtWork { to } => (AT_WORK, bytes_of(to), &[]),
        Message::Idle => (IDLE, &[], &[]),
        Message::Gone => (GONE, &[], &[]),
        Message::Tell => (TELL, &[], &[]),
        Message::Told { figures } => (TOLD, &[], figures),
    };
    put(out, len, (kind, extra), fields, rest)
}

/// The halves of a sum's channels, low one first.
pub(crate) fn split(sum: Sum) -> [[u32; 2]; 3] {
    sum.0.map(|x| [x as u32, (x as u64 >> 32) as u32])
}

/// The sum of these halves.
pub(crate) fn join(halves: [[u32; 2]; 3]) -> Sum {
    Sum(halves.map(|[low, high]| (u64::from(high) << 32 | u64::from(low)) as i64))
}

fn words_of<'w>(room: &'w mut [u32; 4], words: &[u32]) -> &'w [u8] {
    for (place, word) in room.iter_mut().zip(words) {
        *place = word.to_le();
    }
    bytemuck::cast_slice(room.get(..words.len()).unwrap_or_default())
}

fn put(
    out: &mut [u8],
    len: usize,
    (kind, extra): (u8, u8),
    fields: &[u8],
    rest: &[u8],
) -> Option<usize> {
    let bytes = u16::try_from(fields.len().checked_add(rest.len())?).ok()?;
    let item = Item { kind, extra, len: bytes.to_le() };
    let mut at = len;
    for part in [bytes_of(&item), fields, rest] {
        let end = at.checked_add(part.len())?;
        out.get_mut(at..end)?.copy_from_slice(part);
        at = end;
    }
    Some(at)
}

/// The messages of a payload, one after the other. What cannot be read ends it.
#[derive(Debug, Clone)]
pub struct Items<'a> {
    rest: &'a [u8],
    /// Something could not be read.
    damaged: bool,
}

impl<'a> Items<'a> {
    /// Reads a payload.
    #[must_use]
    pub const fn new(payload: &'a [u8]) -> Self {
        Self { rest: payload, damaged: false }
    }

    /// Whether reading has ended at something that is no message.
    #[must_use]
    pub const fn is_damaged(&self) -> bool {
        self.damaged
    }

    /// Bytes that have not been read.
    #[must_use]
    pub const fn rest_len(&self) -> usize {
        self.rest.len()
    }
}

impl<'a> Iterator for Items<'a> {
    type Item = Message<'a>;

    fn next(&mut self) -> Option<Message<'a>> {
        if self.rest.is_empty() {
            return None;
        }
        let message = read(&mut self.rest);
        if message.is_none() {
            self.damaged = true;
            self.rest = &[];
        }
        message
    }
}

fn read<'a>(rest: &mut &'a [u8]) -> Option<Message<'a>> {
    let item: Item = take(rest)?;
    let (mut body, after) = rest.split_at_checked(usize::from(u16::from_le(item.len)))?;
    *rest = after;
    let (body, extra) = (&mut body, item.extra);
    let message = match item.kind {
        FETCH => Message::Fetch { block: word(body)?, offset: word(body)?, request: extra },
        PART => Message::Part {
            block: word(body)?,
            offset: word(body)?,
            request: extra,
            bytes: all(body),
        },
        ASK => Message::Ask { number: word(body)?, count: word(body)? },
        GRANT => Message::Grant {
            number: word(body)?,
            first: word(body)?,
            count: word(body)?,
            wait: word(body)?,
        },
        PIXELS => {
            Message::Pixels { tile: word(body)?, first: word(body)?, width: extra, sums: all(body) }
        }
        ACCEPTED => Message::Accepted { tile: word(body)? },
        LOST => Message::Lost { block: word(body)? },
        RAY => Message::Ray(all(body).try_into().ok()?),
        ANSWER => Message::Answer { to: take::<ReturnAddress>(body)?, sum: join(take(body)?) },
        REFUSAL => Message::Refusal { to: take(body)? },
        AT_WORK => Message::AtWork { to: take(body)? },
        IDLE => Message::Idle,
        GONE => Message::Gone,
        TELL => Message::Tell,
        TOLD => Message::Told { figures: all(body) },
        _ => return None,
    };
    body.is_empty().then_some(message)
}

fn take<T: Pod>(rest: &mut &[u8]) -> Option<T> {
    let (bytes, after) = rest.split_at_checked(size_of::<T>())?;
    *rest = after;
    bytemuck::try_pod_read_unaligned(bytes).ok()
}

fn word(rest: &mut &[u8]) -> Option<u32> {
    take(rest).map(u32::from_le)
}

fn all<'a>(rest: &mut &'a [u8]) -> &'a [u8] {
    core::mem::take(rest)
}
