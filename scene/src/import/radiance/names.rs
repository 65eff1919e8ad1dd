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

/// What the names of modifiers stand for at this place of the input: the last definition counts.
#[derive(Debug, Default)]
pub(in crate::import) struct Names {
    by_name: HashMap<Vec<u8>, Modifier>,
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
        if let Some(Modifier { material: Some(i), .. }) = self.by_name.get(name)
            && self.definitions.get(*i).is_some_and(|d| d.material == material)
        {
            return;
        }
        self.set(name, Modifier { material: Some(self.definitions.len()), ..Modifier::VOID });
        self.definitions.push(Definition { material, glow, index: None });
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
