//! Blocks of whole statements, so that a long file is never in memory as a whole.

use std::io::{self, Read};

use crate::text::{decode, is_utf8, last_statement_end, statement_end};

/// Bytes per read.
const BLOCK: usize = 4 << 20;

/// Bytes per parsing task; the cuts depend on the file alone.
const CHUNK: usize = 256 << 10;

/// Reads a text block by block.
pub(super) struct Blocks<R> {
    reader: R,
    buffer: Vec<u8>,
    /// Start of the next block in the buffer.
    start: usize,
    /// True until the first read.
    fresh: bool,
}

impl<R: Read> Blocks<R> {
    pub(super) fn new(reader: R) -> Self {
        Self { reader, buffer: Vec::new(), start: 0, fresh: true }
    }

    /// Returns the next block, which ends with a statement; empty at the end of the text.
    pub(super) fn next(&mut self) -> io::Result<&[u8]> {
        self.buffer.drain(..self.start);
        self.start = 0;
        let mut size = BLOCK;
        loop {
            let missing = size.saturating_sub(self.buffer.len());
            let read = self.reader.by_ref().take(missing as u64).read_to_end(&mut self.buffer)?;
            let decoded = std::mem::take(&mut self.fresh) && !is_utf8(&self.buffer);
            if decoded {
                self.reader.read_to_end(&mut self.buffer)?;
                self.buffer = decode(std::mem::take(&mut self.buffer));
            }
            let all = decoded || read < missing;
            let end = if all { Some(self.buffer.len()) } else { last_statement_end(&self.buffer) };
            if let Some(end) = end {
                self.start = end;
                return Ok(&self.buffer[..end]);
            }
            size = size.saturating_mul(2);
        }
    }
}

/// Cuts a block into chunks of whole statements.
pub(super) fn chunks(mut block: &[u8]) -> Vec<&[u8]> {
    let mut chunks = Vec::new();
    while !block.is_empty() {
        let (chunk, rest) = block.split_at(statement_end(block, CHUNK.min(block.len())));
        chunks.push(chunk);
        block = rest;
    }
    chunks
}
