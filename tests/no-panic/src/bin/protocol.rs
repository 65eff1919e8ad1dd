//! Any message written behind any other, and payloads of any bytes read to their end.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::network::{NodeId, PacketHeader};
use kiloray_core::path::PathKey;
use kiloray_core::protocol::{Items, Message, RayMessage, ReturnAddress, write};
use kiloray_no_panic::{any, any_bytes, any_room, entry};

#[inline(never)]
fn message() -> Message<'static> {
    let to: ReturnAddress = any();
    match any::<u8>() {
        0 => Message::Fetch { block: any(), offset: any(), request: any() },
        1 => Message::Part { block: any(), offset: any(), request: any(), bytes: any_bytes() },
        2 => Message::Ask { number: any(), count: any() },
        12 => Message::Idle,
        13 => Message::Gone,
        14 => Message::Tell,
        15 => Message::Told { figures: any_bytes() },
        3 => Message::Grant { number: any(), first: any(), count: any(), wait: any() },
        4 => Message::Pixels { tile: any(), first: any(), width: any(), sums: any_bytes() },
        5 => Message::Accepted { tile: any() },
        6 => Message::Lost { block: any() },
        7 => Message::Ray(any_bytes().first_chunk().unwrap_or(&[0; RayMessage::BYTES])),
        8 => Message::Answer { to, sum: any() },
        9 => Message::Refusal { to },
        _ => Message::AtWork { to },
    }
}

entry!({
    let mut room = [0; 256];
    let room = any_room(&mut room);
    let mut len = any();
    for _ in 0..any::<u32>() {
        let message = message();
        black_box((message.channel(), message.priority()));
        len = write(room, len, &message).unwrap_or_else(any);
    }
    if let Some((header, payload)) = PacketHeader::split(any_bytes()) {
        black_box((header.to(), header.from()));
        let mut items = Items::new(payload);
        for message in items.by_ref() {
            if let Message::Ray(ray) = message {
                let ray = RayMessage::read(ray);
                black_box((ray.reply.key(), ray.ray.path(), ray.best.get(), ray.trail.block()));
            }
            black_box(message);
        }
        black_box((items.is_damaged(), items.rest_len()));
    }
    let key = PathKey { path: any(), sample: any() };
    black_box(ReturnAddress::new(NodeId(any()), any(), key));
});
