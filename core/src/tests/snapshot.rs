//! States of the mesh as bytes, for its checkers.

use bytemuck::Pod;
use std::vec::Vec;

/// The state of something, written part by part, or read back in the same order.
///
/// One function per type names its parts, so that writing and reading cannot differ. Zeros take a byte.
#[derive(Debug, Default)]
pub(crate) struct Snapshot {
    state: Vec<u8>,
    at: usize,
    reads: bool,
}

impl Snapshot {
    /// To be written.
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// To be read.
    pub(crate) fn of(bytes: Vec<u8>) -> Self {
        Self { state: bytes, at: 0, reads: true }
    }

    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.state
    }

    pub(crate) fn reads(&self) -> bool {
        self.reads
    }

    /// A value.
    pub(crate) fn pod<T: Pod>(&mut self, value: &mut T) {
        self.bytes(bytemuck::bytes_of_mut(value));
    }

    /// As many values as there are.
    pub(crate) fn all<T: Pod>(&mut self, values: &mut [T]) {
        for value in values {
            self.pod(value);
        }
    }

    pub(crate) fn bool(&mut self, value: &mut bool) {
        let mut byte = u8::from(*value);
        self.pod(&mut byte);
        *value = byte != 0;
    }

    /// A length or index.
    pub(crate) fn len(&mut self, value: &mut usize) {
        let mut number = *value as u16;
        self.pod(&mut number);
        *value = number.into();
    }

    /// A list of any length.
    pub(crate) fn list<T: Default>(
        &mut self,
        list: &mut Vec<T>,
        mut part: impl FnMut(&mut Self, &mut T),
    ) {
        let mut len = list.len();
        self.len(&mut len);
        list.resize_with(len, T::default);
        for value in list {
            part(self, value);
        }
    }

    /// As many bytes as there are.
    pub(crate) fn bytes(&mut self, part: &mut [u8]) {
        if self.reads {
            part.fill(0);
            let flag = self.state[self.at];
            self.at += 1;
            if flag != 0 {
                part.copy_from_slice(&self.state[self.at..self.at + part.len()]);
                self.at += part.len();
            }
        } else if part.iter().all(|&byte| byte == 0) {
            self.state.push(0);
        } else {
            self.state.push(1);
            self.state.extend_from_slice(part);
        }
    }
}
