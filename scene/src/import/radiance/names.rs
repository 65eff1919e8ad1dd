use std::collections::HashMap;

use crate::model::{Material, Model, ModelError};

/// What a modifier's name stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Modifier {
    /// A material, by its place in [`Names`].
    pub(super) material: Option<usize>,
    /// A pattern changes the colours of what it modifies.
    pub(super) pattern: bool,
}

impl Modifier {
    /// Nothing.
    pub(super) const VOID: Self = Self { material: None, pattern: false };
}

/// A material that was defined.
#[derive(Debug)]
pub(super) struct Definition {
    pub(super) material: Material,
    /// A `glow`: a source of it is seen only.
    pub(super) glow: bool,
    /// Its index in the model, once a surface uses it.
    index: Option<u16>,
}

/// Definitions of a name that are compared with another of it.
const SAME_NAME_MAX: usize = 64;

/// What the names of modifiers stand for at this place of the input: the last definition counts.
#[derive(Debug, Default)]
pub(in crate::import) struct Names {
    by_name: HashMap<Vec<u8>, Modifier>,
    /// All definitions of each name.
    defined: HashMap<Vec<u8>, Vec<usize>>,
    definitions: Vec<Definition>,
}

impl Names {
    /// `void` is known to all.
    pub(super) fn get(&self, name: &[u8]) -> Option<Modifier> {
        if name == b"void" { Some(Modifier::VOID) } else { self.by_name.get(name).copied() }
    }

    /// Defines a name anew.
    pub(super) fn set(&mut self, name: &[u8], modifier: Modifier) {
        match self.by_name.get_mut(name) {
            Some(known) => *known = modifier,
            None => _ = self.by_name.insert(name.to_owned(), modifier),
        }
    }

    /// Defines a material. The same again, as each copy of an array brings it, is no new one.
    pub(super) fn define(&mut self, name: &[u8], material: Material, glow: bool) {
        let known = self.defined.get(name).map(Vec::as_slice).unwrap_or_default();
        // The latest are looked at alone: a name that is defined anew without end must not cost more each time.
        let same = known.iter().rev().take(SAME_NAME_MAX).copied().find(|&i| {
            self.definitions.get(i).is_some_and(|d| d.material == material && d.glow == glow)
        });
        let index = same.unwrap_or(self.definitions.len());
        if same.is_none() {
            self.definitions.push(Definition { material, glow, index: None });
            self.defined.entry(name.to_owned()).or_default().push(index);
        }
        self.set(name, Modifier { material: Some(index), ..Modifier::VOID });
    }

    /// The definition behind a modifier.
    pub(super) fn definition(&self, modifier: Modifier) -> Option<&Definition> {
        modifier.material.and_then(|i| self.definitions.get(i))
    }

    /// Enters the material into the model, the first time, and gives its index; `None` for void.
    pub(super) fn index(
        &mut self,
        modifier: Modifier,
        model: &mut Model,
    ) -> Result<Option<u16>, ModelError> {
        let definition = modifier.material.and_then(|i| self.definitions.get_mut(i));
        let Some(definition) = definition else { return Ok(None) };
        if definition.index.is_none() {
            definition.index = Some(model.add_material(definition.material.clone())?);
        }
        Ok(definition.index)
    }
}
