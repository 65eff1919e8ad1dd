/// What the type word of an object means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Surface(Shape),
    Material(Stuff),
    /// Changes the colour: passes on what it modifies.
    Pattern,
    /// Changes the normal: passes on what it modifies.
    Texture,
    /// Mixes two modifiers.
    Mixture,
    Alias,
    /// Holds surfaces in a form that is not read.
    Refused(&'static str),
}

/// A surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Polygon,
    Sphere { inward: bool },
    Cone { inward: bool },
    Cylinder { inward: bool },
    Ring,
    Source,
}

/// A material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stuff {
    Plastic,
    Metal,
    Trans,
    /// The same with a roughness for each of two directions.
    Plastic2,
    Metal2,
    Trans2,
    Dielectric,
    Interface,
    Glass,
    Mirror,
    Light,
    Illum,
    Glow,
    Spotlight,
    /// Not there (`antimatter`, `mist`).
    Nothing,
    /// Known to Radiance, not to us.
    Other,
}

impl Kind {
    /// The meaning of a type word.
    pub(super) fn of(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"polygon" => Self::Surface(Shape::Polygon),
            b"sphere" => Self::Surface(Shape::Sphere { inward: false }),
            b"bubble" => Self::Surface(Shape::Sphere { inward: true }),
            b"cone" => Self::Surface(Shape::Cone { inward: false }),
            b"cup" => Self::Surface(Shape::Cone { inward: true }),
            b"cylinder" => Self::Surface(Shape::Cylinder { inward: false }),
            b"tube" => Self::Surface(Shape::Cylinder { inward: true }),
            b"ring" => Self::Surface(Shape::Ring),
            b"source" => Self::Surface(Shape::Source),
            b"plastic" => Self::Material(Stuff::Plastic),
            b"metal" => Self::Material(Stuff::Metal),
            b"trans" => Self::Material(Stuff::Trans),
            b"plastic2" => Self::Material(Stuff::Plastic2),
            b"metal2" => Self::Material(Stuff::Metal2),
            b"trans2" => Self::Material(Stuff::Trans2),
            b"dielectric" => Self::Material(Stuff::Dielectric),
            b"interface" => Self::Material(Stuff::Interface),
            b"glass" => Self::Material(Stuff::Glass),
            b"mirror" => Self::Material(Stuff::Mirror),
            b"light" => Self::Material(Stuff::Light),
            b"illum" => Self::Material(Stuff::Illum),
            b"glow" => Self::Material(Stuff::Glow),
            b"spotlight" => Self::Material(Stuff::Spotlight),
            b"antimatter" | b"mist" => Self::Material(Stuff::Nothing),
            b"plasfunc" | b"metfunc" | b"transfunc" | b"BRTDfunc" | b"plasdata" | b"metdata"
            | b"transdata" | b"BSDF" | b"aBSDF" | b"prism1" | b"prism2" | b"ashik2"
            | b"WGMDfunc" => Self::Material(Stuff::Other),
            b"colorfunc" | b"brightfunc" | b"colordata" | b"brightdata" | b"colorpict"
            | b"colortext" | b"brighttext" | b"spectrum" | b"specfile" | b"specfunc"
            | b"specdata" | b"specpict" => Self::Pattern,
            b"texfunc" | b"texdata" => Self::Texture,
            b"mixfunc" | b"mixdata" | b"mixpict" | b"mixtext" => Self::Mixture,
            b"alias" => Self::Alias,
            b"instance" => Self::Refused("an octree; name the .rad file that it was made from"),
            b"mesh" => Self::Refused("a compiled mesh; name the .obj file that it was made from"),
            _ => return None,
        })
    }
}
