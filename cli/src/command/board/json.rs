use serde_json::{Value, json};

use super::{End, Run, told::Told};
use crate::{
    command::mesh::{add_counts, greatest},
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
        let mut report = json!({
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
            "position_error": header.frame.position_error,
            "blocks": {
                "count": header.blocks,
                "bytes": u64::from(header.blocks) * u64::from(header.block_bytes),
                "fetched": node.cache.fetched,
                "owned_max": self.owned,
            },
            "memory": {
                "limit": fullest.map(|(_, figures)| figures.memory),
                "peak": fullest.map(|(_, figures)| figures.peak_bytes()),
                "peak_node": fullest.map(|(node, _)| node),
                "lines": greatest(told.lines()),
            },
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
        });
        add_counts(&mut report, node);
        report
    }
}
