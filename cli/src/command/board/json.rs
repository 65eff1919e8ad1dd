use serde_json::{Value, json};

use super::{End, Run, told::Told};
use crate::{
    command::mesh::{dropped_json, greatest},
    picture,
};

impl Run<'_> {
    /// The fields that scripts rely on.
    pub(super) fn as_json(&self) -> Value {
        let (options, done) = (self.options, self.done);
        let file = self.scene.file.view();
        let header = file.header();
        let mut common = json!(self.board.common);
        common["scenes"] = json!(self.board.scene.scenes);
        common["width"] = json!(options.width);
        common["height"] = json!(options.height);
        common["block"] = json!(header.block_bytes);
        common["nodes"] = json!(self.nodes);
        common["topology"] = json!(self.board.topology);
        common["machine"] = json!(self.board.machine);
        common["processes"] = json!(self.board.processes);
        common["block_replicas"] = json!(self.board.block_replicas);
        common["serial"] = json!(self.board.serial);
        common["baud"] = json!(self.board.baud);
        common["noise"] = json!(self.board.noise.map(f64::from));
        let counts = done.ledger.counts();
        let told = Told::of(&done.ledger);
        let fullest = told.fullest();
        let node = &told.counts;
        let links = done.links.iter().map(|link| {
            json!({
                "sent": { "frames": link.sent, "bytes": link.sent_bytes },
                "received": { "frames": link.received, "bytes": link.received_bytes },
                "damaged": link.damaged,
            })
        });
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "options": common,
            "complete": done.end == End::Complete,
            "lost_block": if let End::Lost(block) = done.end { Some(block) } else { None },
            "image_hash": picture::hash(self.picture),
            "image_hash_kind": "blake3",
            "width": options.width,
            "height": options.height,
            "nodes": self.nodes,
            "time_s": self.time_s,
            "mesh_s": self.render_s,
            "surfaces": header.primitives,
            "blocks": {
                "count": header.blocks,
                "bytes": u64::from(header.blocks) * u64::from(header.block_bytes),
                "fetched": node.cache.fetched,
                "owned_max": self.owned,
            },
            "rays": {
                "primary": node.shade.primary,
                "shadow": node.shade.shadow,
                "specular": node.shade.specular,
                "ambient": 0,
            },
            "memory": {
                "limit": fullest.map(|(_, figures)| figures.memory),
                "peak": fullest.map(|(_, figures)| figures.peak_bytes()),
                "peak_node": fullest.map(|(node, _)| node),
                "lines": greatest(told.lines()),
            },
            "cache": {
                "hits": node.cache.hits,
                "misses": node.cache.misses,
                "evictions": node.cache.evictions,
            },
            "migrated": node.migrated,
            "retries": node.rays_again + node.fetches_again + node.tiles_again,
            "retries_by_cause": {
                "rays": node.rays_again,
                "fetches": node.fetches_again,
                "tiles": node.tiles_again,
            },
            "refusals": node.refused,
            "run_at_home": node.run_at_home,
            "dropped": dropped_json(node),
            "per_node": told.per_node(),
            "untold": told.missing(self.nodes),
            "faults": { "died": self.dead.iter().map(|node| node.0).collect::<Vec<_>>() },
            "said": self.said,
            "host_links": links.collect::<Vec<_>>(),
            "messages": { "count": counts.messages },
            "tiles": { "given": counts.given, "given_again": counts.given_again },
            "duplicates": counts.duplicates,
            "differing": counts.differing,
            "overflows": done.ledger.overflows(),
            "notes": self.scene.notes,
        })
    }
}
