//! GVSP, the double's pictures: each a leader, its bytes in packets, and a trailer.

use std::collections::VecDeque;

use super::control::IP_AND_UDP;
use super::registers::MONO_8;
use crate::frame::GrayFrame;

/// Header of a packet \[bytes\].
const HEADER: usize = 8;
/// Kinds of packets.
const LEADER: u32 = 1;
const TRAILER: u32 = 2;
const PAYLOAD: u32 = 3;
/// What a block is: a picture.
const PICTURE: u16 = 1;
/// Pictures whose packets can be asked for again. Chosen: a tenth of a second of a quick camera.
const REMEMBERED: usize = 8;

/// The packets of one picture. `size` is that of a packet with all headers \[bytes\].
pub fn packets(block: u16, stamp_ns: u64, size: usize, picture: &GrayFrame) -> Vec<Vec<u8>> {
    let (width, height) = (picture.width_px() as u32, picture.height_px() as u32);
    let head = |kind: u32, number: u32| {
        let mut packet = vec![0, 0];
        packet.extend(block.to_be_bytes());
        packet.extend((kind << 24 | number).to_be_bytes());
        packet
    };
    let mut leader = head(LEADER, 0);
    leader.extend([0, 0]);
    leader.extend(PICTURE.to_be_bytes());
    leader.extend(stamp_ns.to_be_bytes());
    // Format, size, offset, padding.
    leader.extend([MONO_8, width, height, 0, 0, 0].iter().flat_map(|word| word.to_be_bytes()));
    let mut all = vec![leader];
    let room = size.saturating_sub(IP_AND_UDP + HEADER).max(1);
    for part in picture.pixels().chunks(room) {
        let mut packet = head(PAYLOAD, all.len() as u32);
        packet.extend(part);
        all.push(packet);
    }
    let mut trailer = head(TRAILER, all.len() as u32);
    trailer.extend([0, 0]);
    trailer.extend(PICTURE.to_be_bytes());
    trailer.extend(height.to_be_bytes());
    all.push(trailer);
    all
}

/// The last pictures' packets.
#[derive(Default)]
pub struct Sent {
    blocks: VecDeque<(u16, Vec<Vec<u8>>)>,
}

impl Sent {
    /// Remembers a picture; the oldest is forgotten.
    pub fn push(&mut self, block: u16, packets: Vec<Vec<u8>>) {
        if self.blocks.len() == REMEMBERED {
            self.blocks.pop_front();
        }
        self.blocks.push_back((block, packets));
    }

    /// Packets to be sent again; those that are not remembered are passed over.
    pub fn again(&self, block: u16, first: u32, last: u32) -> impl Iterator<Item = &[u8]> {
        let packets = self.blocks.iter().find(|(number, _)| *number == block).map_or(&[][..], |(_, packets)| packets);
        let upto = (last as usize).saturating_add(1).min(packets.len());
        packets.get(first as usize..upto).unwrap_or_default().iter().map(Vec::as_slice)
    }

    /// After power-on.
    pub fn clear(&mut self) {
        self.blocks.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_cut_into_numbered_packets_that_can_be_had_again() {
        let picture = GrayFrame::new(4, 3, (0..12).collect()).unwrap();
        let all = packets(7, 0x0102, 41, &picture);
        assert_eq!(all.len(), 1 + 3 + 1);
        assert_eq!(all[0][..12], [0, 0, 0, 7, 1, 0, 0, 0, 0, 0, 0, 1]);
        assert_eq!(all[0][12..28], [0, 0, 0, 0, 0, 0, 1, 2, 1, 8, 0, 1, 0, 0, 0, 4]);
        assert_eq!(all[2], [0, 0, 0, 7, 3, 0, 0, 2, 5, 6, 7, 8, 9]);
        assert_eq!(all[4], [0, 0, 0, 7, 2, 0, 0, 4, 0, 0, 0, 1, 0, 0, 0, 3]);
        let mut sent = Sent::default();
        sent.push(7, all.clone());
        assert_eq!(sent.again(7, 2, 3).collect::<Vec<_>>(), [&all[2][..], &all[3][..]]);
        for (block, first, last) in [(8, 0, 1), (7, 9, 12), (7, 3, 2), (7, 0xff_ffff, 0xff_ffff)] {
            assert_eq!(sent.again(block, first, last).count(), 0);
        }
        (8..40).for_each(|block| sent.push(block, vec![]));
        assert_eq!((sent.blocks.len(), sent.again(7, 0, 9).count()), (REMEMBERED, 0));
    }
}
