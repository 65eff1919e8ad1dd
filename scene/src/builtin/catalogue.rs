use super::{
    colour_cube, conference, cornell, furnace, glass, shape::Shaper, sinc, sphereflake, studio,
};
use crate::model::Model;

/// A built-in scene, or a family of them.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// Its name.
    pub name: &'static str,
    /// What it shows, in one line.
    pub about: &'static str,
    /// What `:N` behind the name means; `None` for a scene of one size.
    pub size: Option<Size>,
    /// Surfaces (triangles and spheres) at a size.
    surfaces: fn(u64) -> u64,
    make: fn(&mut Shaper, u32),
}

/// The `N` of a family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// What it counts.
    pub counts: &'static str,
    /// Without `:N`.
    pub default: u32,
    /// Least.
    pub min: u32,
    /// Greatest: about ten million surfaces.
    pub max: u32,
}

/// Why there is no such scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BuiltinError {
    /// No scene has this name.
    #[error("no built-in scene is called '{name}'; there are {known}")]
    Unknown {
        /// The name asked for.
        name: String,
        /// All names.
        known: String,
    },
    /// A scene of one size was asked for in another.
    #[error("the scene '{name}' has one size; write '{name}' without ':{size}'")]
    Sized {
        /// The scene.
        name: &'static str,
        /// What stood behind the colon.
        size: String,
    },
    /// The size is no number, or out of bounds.
    #[error("'{size}' is no size of the scene '{name}': {name}:N takes {min} to {max} ({counts})")]
    Size {
        /// The scene.
        name: &'static str,
        /// What stood behind the colon.
        size: String,
        /// Least size.
        min: u32,
        /// Greatest size.
        max: u32,
        /// What it counts.
        counts: &'static str,
    },
}

const fn family(counts: &'static str, default: u32, min: u32, max: u32) -> Option<Size> {
    Some(Size { counts, default, min, max })
}

/// In the order in which they are printed.
const ENTRIES: &[Entry] = &[
    Entry {
        name: "cornell",
        about: "the Cornell box: two blocks in a room of a white, a red and a green wall",
        size: None,
        surfaces: |_| cornell::SURFACES,
        make: |shaper, _| cornell::build(shaper),
    },
    Entry {
        name: "glass",
        about: "mirrors, solid and tinted glass, thin panes and glossy metal on a chequered floor",
        size: None,
        surfaces: |_| glass::SURFACES,
        make: |shaper, _| glass::build(shaper),
    },
    Entry {
        name: "colour-cube",
        about: "small cubes in a grid, coloured by place: even density, much occlusion",
        size: family("cubes along an edge", 12, 1, 94),
        surfaces: colour_cube::surfaces,
        make: |shaper, n| colour_cube::build(shaper, n, false),
    },
    Entry {
        name: "glass-cube",
        about: "the colour cube in thin tinted glass: every ray passes many surfaces",
        size: family("cubes along an edge", 6, 1, 94),
        surfaces: colour_cube::surfaces,
        make: |shaper, n| colour_cube::build(shaper, n, true),
    },
    Entry {
        name: "sinc",
        about: "the ripple sin(r)/r as a smooth height field",
        size: family("cells along an edge", 256, 2, 2236),
        surfaces: sinc::surfaces,
        make: sinc::build,
    },
    Entry {
        name: "studio",
        about: "an empty room with dense clutter heaped in four spots",
        size: family("objects in all", 400, 4, 12_000),
        surfaces: studio::surfaces,
        make: studio::build,
    },
    Entry {
        name: "conference",
        about: "rows of tables and chairs under many ceiling lights",
        size: family("tables", 6, 1, 600),
        surfaces: conference::surfaces,
        make: conference::build,
    },
    Entry {
        name: "furnace",
        about: "a ball of reflectance 1/2 in light of radiance 1 from everywhere: reads 1/2 all over",
        size: family("times its facets were split", 4, 0, 9),
        surfaces: furnace::surfaces,
        make: furnace::build,
    },
    Entry {
        name: "sphereflake",
        about: "a ball with nine balls on it, each with nine: spheres as themselves",
        size: family("generations", 4, 0, 7),
        surfaces: sphereflake::surfaces,
        make: sphereflake::build,
    },
];

impl Entry {
    /// Triangles and spheres of the scene at this size; what is out of bounds counts as the nearest size.
    #[must_use]
    pub fn surfaces(&self, size: u32) -> u64 {
        (self.surfaces)(u64::from(self.size.map_or(0, |s| size.clamp(s.min, s.max))))
    }

    /// `name`, or `name:N` for a family.
    #[must_use]
    pub fn usage(&self) -> String {
        if self.size.is_some() { format!("{}:N", self.name) } else { self.name.into() }
    }
}

/// All built-in scenes.
#[must_use]
pub fn list() -> &'static [Entry] {
    ENTRIES
}

/// The entry and size of `name` or `name:N`.
///
/// # Errors
/// An unknown name or an impossible size, with what is possible.
pub fn find(name_and_size: &str) -> Result<(&'static Entry, u32), BuiltinError> {
    let (name, size) = match name_and_size.split_once(':') {
        Some((name, size)) => (name, Some(size)),
        None => (name_and_size, None),
    };
    let entry = ENTRIES.iter().find(|entry| entry.name == name).ok_or_else(|| {
        let known: Vec<_> = ENTRIES.iter().map(Entry::usage).collect();
        BuiltinError::Unknown { name: name.into(), known: known.join(", ") }
    })?;
    match (entry.size, size) {
        (None, None) => Ok((entry, 0)),
        (None, Some(size)) => Err(BuiltinError::Sized { name: entry.name, size: size.into() }),
        (Some(bounds), None) => Ok((entry, bounds.default)),
        (Some(Size { counts, min, max, .. }), Some(size)) => size
            .parse()
            .ok()
            .filter(|n| (min..=max).contains(n) && size.bytes().all(|b| b.is_ascii_digit()))
            .map(|n| (entry, n))
            .ok_or(BuiltinError::Size { name: entry.name, size: size.into(), min, max, counts }),
    }
}

/// Makes the scene of `name` or `name:N`.
///
/// # Errors
/// As [`find`].
pub fn build(name_and_size: &str) -> Result<Model, BuiltinError> {
    let (entry, size) = find(name_and_size)?;
    let mut shaper = Shaper::default();
    (entry.make)(&mut shaper, size);
    Ok(shaper.finish())
}
