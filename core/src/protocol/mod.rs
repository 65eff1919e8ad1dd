//! What nodes and the host say to each other.
//!
//! A packet's payload is a row of *items*, one message each: four bytes ([`Item`]) that say what it is and how long, then the fields as plain
//! little-endian data. So a message has one size and one form on all machines, is written by a
//! copy, and is read by a checked one; nothing in it is trusted beyond that (slots and blocks are looked up, keys compared).
//!
//! | message | channel | priority | says |
//! | --- | --- | --- | --- |
//! | [`Fetch`](Message::Fetch) | request | 1 | send me this block |
//! | [`Part`](Message::Part) | reply | 2 | a piece of a block |
//! | [`Ask`](Message::Ask) | request | 3 | I can take tiles (to a master) |
//! | [`Grant`](Message::Grant) | reply | 3 | render these tiles; or none now |
//! | [`Idle`](Message::Idle) | request | 3 | I would take some of your work |
//! | [`Pixels`](Message::Pixels) | request | 3 | sums of a tile (to the host) |
//! | [`Accepted`](Message::Accepted) | reply | 3 | a tile is complete |
//! | [`Lost`](Message::Lost) | request | 1 | no copy of this block answers (to the host) |
//! | [`Ray`](Message::Ray) | request | 4 | go on with this ray, and answer |
//! | [`Answer`](Message::Answer) | reply | 4 | what the ray brought |
//! | [`Refusal`](Message::Refusal) | reply | 4 | no room for the ray: ask again, or run it yourself |
//! | [`AtWork`](Message::AtWork) | reply | 4 | the ray was here before, and is not done |
//! | [`Gone`](Message::Gone) | reply | 1 | I am dead (the router of a dead node) |
//! | [`Tell`](Message::Tell) | request | 3 | what have you done? (from the host) |
//! | [`Told`](Message::Told) | reply | 3 | my memory by line, and counts |
//!
//! Answers and refusals name what they answer by slot *and* path key, and count once; a block by its number. That makes late,
//! doubled and repeated ones harmless.

mod codec;
mod message;
mod sums;

pub use codec::{Item, Items, write};
pub(crate) use codec::{join, split};
pub use message::{Message, RayMessage, ReturnAddress};
pub use sums::{WIDTH_MAX, pack, unpack};
