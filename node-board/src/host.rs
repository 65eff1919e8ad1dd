//! The host beside a mesh on the same board: it gives tiles, takes sums, and writes the pixels.

use kiloray_core::network::{Channel, HOST, Mesh, Router, RouterSize};
use kiloray_core::protocol::{Items, Message, unpack, write};
use kiloray_core::render::Tiling;
use kiloray_core::shade::{Shader, Sum};
use kiloray_core::store::{Arena, ArenaFull};

use crate::picture::{Pixels, SIZE};

/// Replies to a packet: none is longer than twice what it replies to, and few packets are full of short requests.
const REPLIES_BYTES: usize = 64;

/// Tiles of the picture, at most.
const TILES: usize = 64;

/// The host of a mesh whose links lose nothing: then each pixel comes once, in any order.
pub(crate) struct Host<'a> {
    router: Router<'a>,
    shader: Shader<'a>,
    tiling: Tiling,
    pixels: &'a mut Pixels,
    /// Pixels that are there, by tile.
    there: [u32; TILES],
    /// Tiles that were given, and those that are complete.
    given: u32,
    done: u32,
    /// A block that no node has, or what else went wrong.
    failed: bool,
}

impl<'a> Host<'a> {
    /// A host with its packets in `arena`, as many and as long as `size` says.
    pub(crate) fn new(
        arena: &mut Arena<'a>,
        mesh: Mesh,
        size: RouterSize,
        shader: Shader<'a>,
        tiling: Tiling,
        pixels: &'a mut Pixels,
    ) -> Result<Self, ArenaFull> {
        Ok(Self {
            router: Router::new(arena, mesh, HOST, size)?,
            shader,
            tiling,
            pixels,
            there: [0; TILES],
            given: 0,
            done: 0,
            failed: false,
        })
    }

    /// Its end of the links.
    pub(crate) const fn router(&mut self) -> &mut Router<'a> {
        &mut self.router
    }

    /// Whether all pixels are there.
    pub(crate) const fn is_complete(&self) -> bool {
        self.done == self.tiling.len()
    }

    /// Whether they never will be.
    pub(crate) const fn has_failed(&self) -> bool {
        self.failed
    }

    /// Takes the requests that have arrived, as long as there is room to reply.
    pub(crate) fn poll(&mut self) {
        let Self { router, shader, tiling, pixels, there, given, done, failed } = self;
        while router.room(Channel::Reply) > 0 {
            let Some((from, payload)) = router.arrived(Channel::Request) else { return };
            let mut replies = [0; REPLIES_BYTES];
            let mut len = 0;
            for message in Items::new(payload) {
                let reply = match message {
                    Message::Ask { number, count } => {
                        let (first, count) = (*given, count.min(tiling.len() - *given));
                        *given += count;
                        Message::Grant { number, first, count, wait: 0 }
                    }
                    Message::Pixels { tile, first, width, sums } => {
                        let sums = unpack(sums, width);
                        match sums.and_then(|sums| {
                            enter(tiling, shader, pixels, there, (tile, first), sums)
                        }) {
                            Some(true) => {
                                *done += 1;
                                Message::Accepted { tile }
                            }
                            Some(false) => continue,
                            None => {
                                *failed = true;
                                return;
                            }
                        }
                    }
                    _ => {
                        *failed = true;
                        return;
                    }
                };
                match write(&mut replies, len, &reply) {
                    Some(end) => len = end,
                    None => *failed = true,
                }
            }
            router.consume(Channel::Request);
            let replies = replies.get(..len).unwrap_or_default();
            *failed |= len > 0 && router.inject(from, Channel::Reply, 3, replies).is_err();
        }
    }
}

/// Writes a run of pixels of a tile: whether the tile is complete then. `None` if there is no such run.
fn enter(
    tiling: &Tiling,
    shader: &Shader<'_>,
    pixels: &mut Pixels,
    there: &mut [u32; TILES],
    (place, first): (u32, u32),
    sums: impl Iterator<Item = Sum>,
) -> Option<bool> {
    let settings = shader.settings();
    let tile = tiling.shuffled(place, settings.seed)?;
    let mut next = first;
    for sum in sums {
        let (x, y) = (tile.x + next % tile.width, tile.y + next / tile.width);
        let pixel = pixels.get_mut((y * SIZE + x) as usize)?;
        *pixel = shader.unit().resolve(sum, settings.samples).to_array();
        next += 1;
    }
    let there = there.get_mut(place as usize)?;
    *there += next - first;
    Some(*there == tile.width * tile.height)
}
