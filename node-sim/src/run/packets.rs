/// Packets on links. Their number is bounded by the credit of the links; what is freed is used again.
#[derive(Debug)]
pub(crate) struct Packets {
    /// Greatest packet \[bytes\].
    size: usize,
    bytes: Vec<u8>,
    lens: Vec<u16>,
    free: Vec<u32>,
}

impl Packets {
    /// None yet, of at most so many bytes each.
    pub(crate) fn new(size: u16) -> Self {
        Self { size: usize::from(size), bytes: Vec::new(), lens: Vec::new(), free: Vec::new() }
    }

    /// A packet that `write` writes; `None` if it writes none.
    pub(crate) fn make(&mut self, write: impl FnOnce(&mut [u8]) -> Option<usize>) -> Option<u32> {
        let index = self.free.pop().unwrap_or_else(|| {
            self.bytes.resize(self.bytes.len() + self.size, 0);
            self.lens.push(0);
            (self.lens.len() - 1) as u32
        });
        let at = index as usize * self.size;
        match write(&mut self.bytes[at..at + self.size]) {
            Some(len) => {
                self.lens[index as usize] = len as u16;
                Some(index)
            }
            None => {
                self.free.push(index);
                None
            }
        }
    }

    /// A copy of a packet.
    pub(crate) fn copy(&mut self, packet: u32) -> Option<u32> {
        let original = self.get(packet).to_vec();
        self.make(|out| {
            out[..original.len()].copy_from_slice(&original);
            Some(original.len())
        })
    }

    /// A packet.
    pub(crate) fn get(&self, packet: u32) -> &[u8] {
        let at = packet as usize * self.size;
        &self.bytes[at..at + usize::from(self.lens[packet as usize])]
    }

    /// It is not needed any more.
    pub(crate) fn free(&mut self, packet: u32) {
        self.free.push(packet);
    }
}
