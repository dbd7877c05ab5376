//! How far a log may be handed to its reader, which believes every length that the log claims.

use std::fs::File;
use std::io::{self, BufReader, Read};

/// Bytes of the magic that a log begins with.
const MAGIC_BYTES: u64 = 8;
/// Opcode of a chunk (<https://mcap.dev/spec>).
const CHUNK: u8 = 0x06;
/// Bytes of a chunk before the name of its compression (two times, a size, a check sum, the name's length), and of the size that
/// stands behind it.
const CHUNK_HEAD_BYTES: usize = 8 + 8 + 8 + 4 + 4;
const SIZE_BYTES: u64 = 8;

/// Bytes up to the first record that reaches beyond the end of the file or of its uncompressed chunk; all of them where there
/// is none. For the one the reader would take memory, the other's length it would take off what is left of the chunk.
pub fn readable_bytes(file: File) -> io::Result<u64> {
    let end = file.metadata()?.len();
    let mut walk = Walk { log: BufReader::new(file), at: 0 };
    // What ends within the length of a record, the reader takes for what it is.
    let found = walk.pass_over(MAGIC_BYTES).and_then(|()| walk.first_beyond(end));
    Ok(found.ok().flatten().unwrap_or(end))
}

/// A log that is gone through from record to record.
struct Walk {
    log: BufReader<File>,
    at: u64,
}

impl Walk {
    fn first_beyond(&mut self, end: u64) -> io::Result<Option<u64>> {
        while self.at < end {
            let begins = self.at;
            let (opcode, bytes) = self.record_head()?;
            let behind = self.at.saturating_add(bytes);
            if opcode == CHUNK {
                if let Some(records_end) = self.uncompressed_records(behind)?
                    && let Some(beyond) = self.first_beyond_in_chunk(records_end, end)?
                {
                    // Of a chunk that is whole but wrong nothing is believed.
                    return Ok(Some(if behind <= end { begins } else { beyond }));
                }
                // The decompressor reads a chunk piece by piece, whatever its length.
            } else if behind > end {
                return Ok(Some(begins));
            }
            self.pass_over(behind.saturating_sub(self.at))?;
        }
        Ok(None)
    }

    /// Where the records of an uncompressed chunk end, of which the head was read; none of another chunk.
    fn uncompressed_records(&mut self, chunk_end: u64) -> io::Result<Option<u64>> {
        let [.., a, b, c, d] = self.array::<CHUNK_HEAD_BYTES>()?;
        if u32::from_le_bytes([a, b, c, d]) > 0 || self.at.saturating_add(SIZE_BYTES) > chunk_end {
            return Ok(None);
        }
        let bytes = u64::from_le_bytes(self.array()?);
        Ok(Some(self.at.saturating_add(bytes)))
    }

    fn first_beyond_in_chunk(&mut self, records_end: u64, end: u64) -> io::Result<Option<u64>> {
        while self.at < records_end {
            let begins = self.at;
            let (_, bytes) = self.record_head()?;
            let behind = self.at.saturating_add(bytes);
            if behind > records_end.min(end) {
                return Ok(Some(begins));
            }
            self.pass_over(bytes)?;
        }
        Ok(None)
    }

    fn record_head(&mut self) -> io::Result<(u8, u64)> {
        let [opcode] = self.array()?;
        Ok((opcode, u64::from_le_bytes(self.array()?)))
    }

    fn array<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.log.read_exact(&mut bytes)?;
        self.at += N as u64;
        Ok(bytes)
    }

    fn pass_over(&mut self, bytes: u64) -> io::Result<()> {
        self.log.seek_relative(i64::try_from(bytes).map_err(io::Error::other)?)?;
        self.at += bytes;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(opcode: u8, claimed: u64, content: &[u8]) -> Vec<u8> {
        [&[opcode][..], &claimed.to_le_bytes(), content].concat()
    }

    fn chunk(claimed: u64, records: &[u8]) -> Vec<u8> {
        let head = [0; CHUNK_HEAD_BYTES];
        let content = [&head[..], &claimed.to_le_bytes(), records].concat();
        record(CHUNK, content.len() as u64, &content)
    }

    fn readable(records: &[u8]) -> u64 {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        std::fs::write(&path, [&[0; 8][..], records].concat()).unwrap();
        readable_bytes(File::open(path).unwrap()).unwrap() - MAGIC_BYTES
    }

    #[test]
    fn a_whole_log_is_read_whole_and_one_with_a_record_beyond_its_end_up_to_that() {
        let whole = [record(1, 4, b"abcd"), chunk(13, &record(5, 4, b"abcd")), record(2, 0, b"")].concat();
        assert_eq!(readable(&whole), whole.len() as u64);
        let before = record(1, 4, b"abcd");
        for claimed in [5, 1 << 28, u64::MAX] {
            assert_eq!(readable(&[before.clone(), record(1, claimed, b"abcd")].concat()), before.len() as u64);
        }
    }

    #[test]
    fn a_chunk_whose_records_reach_beyond_it_is_not_read_and_one_that_was_cut_up_to_there() {
        let before = record(1, 4, b"abcd");
        for (claimed, records) in [(12, record(5, 4, b"abcd")), (13, record(5, u64::MAX, b"abcd"))] {
            assert_eq!(readable(&[before.clone(), chunk(claimed, &records)].concat()), before.len() as u64);
        }
        let two = chunk(26, &[record(5, 4, b"abcd"), record(5, 4, b"abcd")].concat());
        assert_eq!(readable(&two[..two.len() - 2]), two.len() as u64 - 13);
    }
}
