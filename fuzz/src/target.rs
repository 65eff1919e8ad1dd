use std::fs;
use std::path::Path;

use kiloray_scene::compile::{Options, compile};
use kiloray_scene::import::{self, ImportOptions, Limits};
use kiloray_scene::kilo::KiloFile;

use crate::{host, link, mesh, node, picture};

/// A parser, and how it is fed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// A Radiance scene, which may include itself and another file.
    Rad,
    /// A Wavefront mesh, with a file of materials at hand.
    Obj,
    /// The materials of a Wavefront mesh.
    Mtl,
    /// A file of view options.
    Vf,
    /// View options of the command line.
    View,
    /// A compiled scene.
    Kilo,
    /// A Radiance scene, read and compiled.
    Compile,
    /// A packet of a mesh, at a node and at the host.
    Packet,
    /// A ray of another node, with its best hit and trail.
    Ray,
    /// All that a node of a mesh is told while it renders.
    Node,
    /// Bytes of a serial line.
    Frame,
    /// The setup of a run and a node's share of the scene.
    Begin,
    /// Bytes of a serial line, to one that asks for the setup and to one that has it.
    Start,
    /// What comes over a link of processes.
    Wire,
    /// What a process says of itself.
    Identity,
    /// What a process says that it did.
    Report,
    /// The configuration of a mesh of processes.
    Config,
    /// A picture: OpenEXR.
    Exr,
    /// A picture: Radiance's RGBE.
    Hdr,
    /// A picture: PNG.
    Png,
    /// How fast a machine is.
    Profile,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 21] = [
        Self::Rad,
        Self::Obj,
        Self::Mtl,
        Self::Vf,
        Self::View,
        Self::Kilo,
        Self::Compile,
        Self::Packet,
        Self::Ray,
        Self::Node,
        Self::Frame,
        Self::Begin,
        Self::Start,
        Self::Wire,
        Self::Identity,
        Self::Report,
        Self::Config,
        Self::Exr,
        Self::Hdr,
        Self::Png,
        Self::Profile,
    ];

    /// Its name on the command line and in the corpus.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Rad => "rad",
            Self::Obj => "obj",
            Self::Mtl => "mtl",
            Self::Vf => "vf",
            Self::View => "view",
            Self::Kilo => "kilo",
            Self::Compile => "compile",
            Self::Packet => "packet",
            Self::Ray => "ray",
            Self::Node => "node",
            Self::Frame => "frame",
            Self::Begin => "begin",
            Self::Start => "start",
            Self::Wire => "wire",
            Self::Identity => "identity",
            Self::Report => "report",
            Self::Config => "config",
            Self::Exr => "exr",
            Self::Hdr => "hdr",
            Self::Png => "png",
            Self::Profile => "profile",
        }
    }

    /// Whether its inputs are words.
    #[must_use]
    pub const fn is_text(self) -> bool {
        !matches!(
            self,
            Self::Kilo
                | Self::Packet
                | Self::Ray
                | Self::Node
                | Self::Frame
                | Self::Begin
                | Self::Start
                | Self::Wire
                | Self::Exr
                | Self::Hdr
                | Self::Png
        )
    }

    /// The target of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|t| t.name() == name)
    }

    /// Feeds the parser once, and tells its answer: the kinds of errors and notes.
    pub(crate) fn feed(self, input: &[u8], dir: &Path) -> String {
        match self {
            Self::Rad => load(dir, "a.rad", input),
            Self::Obj => load(dir, "a.obj", input),
            Self::Vf => load(dir, "a.vf", input),
            Self::Mtl => {
                // A mesh that uses them stands beside it.
                write(dir, "a.mtl", input);
                load(dir, "b.obj", b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")
            }
            Self::View => {
                // A leading dash: options, never the name of a file.
                let text = format!("-vp {}", String::from_utf8_lossy(input));
                import::view(&text, None)
                    .map_or_else(|e| e.to_string(), |(view, _)| format!("{:?}", view.kind))
            }
            Self::Kilo => match KiloFile::from_bytes(input) {
                Err(error) => error.to_string(),
                Ok(file) => format!("{:?}", file.view().check_blocks()),
            },
            Self::Packet => mesh::feed_packet(input),
            Self::Ray => mesh::feed_ray(input),
            Self::Node => node::feed(input),
            Self::Frame => link::feed_frames(input),
            Self::Begin => link::feed_begin(input),
            Self::Start => link::feed_start(input),
            Self::Wire => host::feed_wire(input),
            Self::Identity => host::feed_identity(input),
            Self::Report => host::feed_report(input),
            Self::Config => host::feed_config(input),
            Self::Exr | Self::Hdr => picture::feed(input),
            Self::Png => picture::feed_png(input),
            Self::Profile => picture::feed_profile(input),
            Self::Compile => {
                write(dir, "a.rad", input);
                let options = ImportOptions { limits: limits(), ..ImportOptions::default() };
                match import::load(&[dir.join("a.rad")], &options) {
                    Err(error) => error.to_string(),
                    Ok(model) => match compile(&model, &Options::default(), &mut |_, _, _| {}) {
                        Err(error) => error.to_string(),
                        Ok(compiled) => {
                            let again =
                                KiloFile::from_bytes(KiloFile::from_compiled(compiled).bytes());
                            assert!(again.is_ok(), "what is compiled can be opened: {again:?}");
                            "compiled".to_owned()
                        }
                    },
                }
            }
        }
    }
}

/// Reads a file within small limits.
fn load(dir: &Path, name: &str, input: &[u8]) -> String {
    write(dir, name, input);
    let options = ImportOptions { limits: limits(), ..ImportOptions::default() };
    match import::load(&[dir.join(name)], &options) {
        Err(error) => {
            let line = error.to_string();
            assert!(!line.contains(['\n', '\r']), "an error is one line: {line:?}");
            line
        }
        Ok(model) => {
            let finite = model.vertices.iter().all(|v| !v.is_nan());
            assert!(finite, "no vertex is NaN");
            let count = model.vertices.len() as u32;
            assert!(model.triangles.iter().flat_map(|t| t.vertices).all(|i| i < count));
            model.notes.iter().map(|note| format!("{}\n", note.text)).collect()
        }
    }
}

/// Small enough that an input is read in milliseconds.
fn limits() -> Limits {
    Limits {
        file_bytes: 1 << 20,
        text_bytes: 1 << 22,
        surfaces: 20_000,
        corners: 1 << 10,
        copies: 1 << 10,
        depth: 8,
    }
}

fn write(dir: &Path, name: &str, input: &[u8]) {
    fs::write(dir.join(name), input).expect("the directory of the run can be written");
}
