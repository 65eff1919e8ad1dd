use serde_json::{Value, json};

use super::{End, Run, told::Told};
use crate::{
    command::{
        mesh::{add_counts, greatest},
        report::{Head, options_json},
    },
    picture,
};

impl Run<'_> {
    /// The fields that scripts rely on.
    pub(super) fn as_json(&self) -> Value {
        let done = self.done;
        let size = (self.options.width, self.options.height);
        let (common, scenes) = (&self.board.common, &self.board.scene.scenes);
        let mut options = options_json(common, scenes, self.scene, size, self.saved.exposure);
        options["nodes"] = json!(self.nodes);
        options["topology"] = json!(self.board.topology);
        options["machine"] = json!(self.board.machine);
        options["processes"] = json!(self.board.processes);
        options["block_replicas"] = json!(self.board.block_replicas);
        options["serial"] = json!(self.board.serial);
        options["baud"] = json!(self.board.baud);
        options["noise"] = json!(self.board.noise.map(f64::from));
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
        let head = Head {
            scene: self.scene,
            options,
            picture: self.picture,
            image_hash: &picture::hash(self.picture),
            nodes: self.nodes.into(),
            time_s: self.time_s,
            fetched: node.cache.fetched,
            overflows: done.ledger.overflows(),
        };
        let mut json = head.with(json!({
            "complete": done.end == End::Complete,
            "lost_block": if let End::Lost(block) = done.end { Some(block) } else { None },
            "mesh_s": self.render_s,
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
        }));
        json["blocks"]["owned_max"] = json!(self.owned);
        add_counts(&mut json, node);
        json
    }
}
