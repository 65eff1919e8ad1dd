//! Choices of the core that can be typed, by the names that files have for them.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use kiloray_core::node::{Dealing, PointHome, Schedule, ShadowPolicy, TaskOrder};
use serde::de::{DeserializeOwned, value};

/// One of a few values, each with a name and what the help says of it.
pub(super) trait Choice: DeserializeOwned + Clone + Send + Sync + 'static {
    const NAMES: &'static [(&'static str, &'static str)];
}

/// Reads a name.
pub(super) fn choice<T: Choice>() -> ValueParser {
    let names = T::NAMES.iter().map(|&(name, help)| PossibleValue::new(name).help(help));
    ValueParser::new(PossibleValuesParser::new(names).try_map(|name| named::<T>(&name)))
}

fn named<T: Choice>(name: &str) -> Result<T, value::Error> {
    T::deserialize(value::StrDeserializer::new(name))
}

/// Which rays go where.
impl Choice for Schedule {
    const NAMES: &'static [(&'static str, &'static str)] = &[
        ("hybrid", "Camera and shadow rays fetch blocks, specular rays go to them"),
        ("demand", "All rays fetch blocks"),
        ("data", "All rays go to the blocks"),
    ];
}

/// Which node owns which blocks.
impl Choice for Dealing {
    const NAMES: &'static [(&'static str, &'static str)] = &[
        ("subtrees", "Subtrees of equal bytes"),
        ("round-robin", "One block to each node in turn"),
    ];
}

/// Who traces shadow rays.
impl Choice for ShadowPolicy {
    const NAMES: &'static [(&'static str, &'static str)] = &[
        ("keep", "The node that found what they start from"),
        ("offer", "Also idle nodes, which the master sends to those that still render"),
        ("steal", "Also idle nodes, which ask others by chance"),
    ];
}

/// Where intersection points live.
impl Choice for PointHome {
    const NAMES: &'static [(&'static str, &'static str)] = &[
        ("finder", "With the node that has found them"),
        ("owner", "With the owner of the block that was hit"),
    ];
}

/// Which of the waiting rays goes on first.
impl Choice for TaskOrder {
    const NAMES: &'static [(&'static str, &'static str)] =
        &[("made", "That of the path that was begun first"), ("ready", "As their blocks arrive")];
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each name is one of the core's, and its own.
    #[track_caller]
    fn is_known<T: Choice + serde::Serialize>() {
        for (name, _) in T::NAMES {
            let value = named::<T>(name).expect(name);
            assert_eq!(serde_json::json!(value), *name);
        }
    }

    #[test]
    fn names_are_those_of_the_core() {
        is_known::<Schedule>();
        is_known::<Dealing>();
        is_known::<ShadowPolicy>();
        is_known::<PointHome>();
        is_known::<TaskOrder>();
    }
}
