//! The median filter, by minima and maxima of whole blocks of columns, which the compiler turns into vector instructions.
//!
//! The columns of a neighbourhood are sorted once for all pixels beside one another. Once its rows are sorted as well, the value at
//! rank i of column j has i·j values that are not above it, itself counted, and as many that are not below it, counted from the
//! other end: of 5 × 5 values 13 places may hold the median.

use crate::frame::GrayFrame;

/// The side of a median's square neighbourhood \[px\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MedianKernel {
    /// No filter.
    Off,
    /// 3 × 3.
    Three,
    /// 5 × 5. Larger ones are much slower, and no better on a stripe of a few pixels.
    Five,
}

/// The median of `frame` over `kernel`; the border is continued outwards.
#[must_use]
pub fn median(frame: &GrayFrame, kernel: MedianKernel) -> GrayFrame {
    let mut filtered = frame.clone();
    let (width, height) = (frame.width_px(), frame.height_px());
    let mut filter = MedianFilter::new(kernel);
    let radius = kernel.radius_px();
    let gather = |padded: &mut [u8]| {
        for (v, target) in padded.chunks_exact_mut(width + 2 * radius).enumerate() {
            let row = frame.row(v.saturating_sub(radius).min(height - 1));
            target[radius..radius + width].copy_from_slice(row);
            target[..radius].fill(row[0]);
            target[radius + width..].fill(row[width - 1]);
        }
    };
    filter.block((width, height), gather, filtered.pixels_mut(), width);
    filtered
}

impl MedianKernel {
    /// How far its neighbourhood reaches from its middle \[px\].
    #[must_use]
    pub const fn radius_px(self) -> usize {
        match self {
            Self::Off => 0,
            Self::Three => 1,
            Self::Five => 2,
        }
    }
}

/// The filter at work on blocks of frames; it keeps its buffers.
#[derive(Debug)]
pub struct MedianFilter {
    kernel: MedianKernel,
    padded: Vec<u8>,
    ranks: Vec<u8>,
}

impl MedianFilter {
    /// A filter by `kernel`.
    pub const fn new(kernel: MedianKernel) -> Self {
        Self { kernel, padded: vec![], ranks: vec![] }
    }

    /// How far a pixel's neighbourhood reaches \[px\].
    pub const fn radius_px(&self) -> usize {
        self.kernel.radius_px()
    }

    /// Filters a block of `width` × `height` pixels into `target`, whose rows are `stride` pixels apart. `gather` puts the block with
    /// [`Self::radius_px`] more pixels on each side into a buffer of just that size, row by row.
    pub fn block(
        &mut self,
        (width, height): (usize, usize),
        gather: impl FnOnce(&mut [u8]),
        target: &mut [u8],
        stride: usize,
    ) {
        let radius = self.radius_px();
        self.padded.resize((width + 2 * radius) * (height + 2 * radius), 0);
        gather(&mut self.padded);
        let (padded, ranks) = (&self.padded, &mut self.ranks);
        match self.kernel {
            MedianKernel::Off => {
                for (row, target) in padded.chunks_exact(width).zip(target.chunks_mut(stride)) {
                    target[..width].copy_from_slice(row);
                }
            }
            MedianKernel::Three => {
                filter::<3, 32>(padded, (width, height), (target, stride), ranks, sort_3, middle_of_9)
            }
            MedianKernel::Five => {
                filter::<5, 16>(padded, (width, height), (target, stride), ranks, sort_5, middle_of_25)
            }
        }
    }
}

/// Each pair of values in order, the smaller one first.
macro_rules! exchange {
    ($values:ident; $($a:literal $b:literal),*) => {$(
        let (a, b) = ($values[$a], $values[$b]);
        for i in 0..a.len() {
            $values[$a][i] = a[i].min(b[i]);
            $values[$b][i] = a[i].max(b[i]);
        }
    )*};
}

/// Takes `LANES` pixels of a row at a time, as many as measured fastest. `middle` is given the sorted columns of their
/// neighbourhoods: first by rank, then by place from the left.
fn filter<const SIDE: usize, const LANES: usize>(
    padded: &[u8],
    (width, height): (usize, usize),
    (target, stride): (&mut [u8], usize),
    ranks: &mut Vec<u8>,
    sort: impl Fn(&mut [[u8; LANES]; SIDE]),
    middle: impl Fn([[[u8; LANES]; SIDE]; SIDE]) -> [u8; LANES],
) {
    let padded_width = width + SIDE - 1;
    // Blocks of columns begin every LANES columns, and the last one's neighbourhood goes on beyond the last column.
    let rank_len = width.next_multiple_of(LANES) + LANES;
    ranks.resize(SIDE * rank_len, 0);
    for (v, target) in target.chunks_mut(stride).take(height).enumerate() {
        let rows: [&[u8]; SIDE] = std::array::from_fn(|dv| &padded[(v + dv) * padded_width..][..padded_width]);
        sort_columns(&rows, &sort, ranks, rank_len);
        for (block, target) in target[..width].chunks_mut(LANES).enumerate() {
            let place = |rank: usize, du: usize| {
                let mut values = [0; LANES];
                values.copy_from_slice(&ranks[rank * rank_len + block * LANES + du..][..LANES]);
                values
            };
            let columns = std::array::from_fn(|rank| std::array::from_fn(|du| place(rank, du)));
            target.copy_from_slice(&middle(columns)[..target.len()]);
        }
    }
}

/// The values of each column of `rows`, sorted into `ranks`, each of `rank_len` values.
fn sort_columns<const SIDE: usize, const LANES: usize>(
    rows: &[&[u8]; SIDE],
    sort: impl Fn(&mut [[u8; LANES]; SIDE]),
    ranks: &mut [u8],
    rank_len: usize,
) {
    let width = rows[0].len();
    for first in (0..width).step_by(LANES) {
        let count = LANES.min(width - first);
        let mut values = [[0; LANES]; SIDE];
        for (values, row) in values.iter_mut().zip(rows) {
            values[..count].copy_from_slice(&row[first..first + count]);
        }
        sort(&mut values);
        for (values, rank) in values.iter().zip(ranks.chunks_exact_mut(rank_len)) {
            rank[first..][..LANES].copy_from_slice(values);
        }
    }
}

/// The median of three by three: the middle of the largest minimum, the middle median and the least maximum of the columns.
#[inline(always)]
fn middle_of_9<const LANES: usize>([mut low, middle, mut high]: [[[u8; LANES]; 3]; 3]) -> [u8; LANES] {
    exchange!(low; 0 1, 1 2);
    exchange!(high; 1 2, 0 1);
    middle_of_3([low[2], middle_of_3(middle), high[0]])
}

#[inline(always)]
fn middle_of_3<const LANES: usize>(mut values: [[u8; LANES]; 3]) -> [u8; LANES] {
    sort_3(&mut values);
    values[1]
}

#[inline(always)]
fn sort_3<const LANES: usize>(values: &mut [[u8; LANES]; 3]) {
    exchange!(values; 0 1, 1 2, 0 1);
}

#[inline(always)]
fn middle_of_25<const LANES: usize>(mut ranks: [[[u8; LANES]; 5]; 5]) -> [u8; LANES] {
    ranks.iter_mut().for_each(sort_5);
    let [a, b, c, d, e] = ranks;
    // All others have more than twelve values on one side of them.
    middle_of_13([a[3], a[4], b[2], b[3], b[4], c[1], c[2], c[3], d[0], d[1], d[2], e[0], e[1]])
}

/// Of eight of thirteen values the least and the largest cannot lie in the middle: they are dropped, the next value takes the place of
/// the largest, and so on.
#[inline(always)]
fn middle_of_13<const LANES: usize>(mut p: [[u8; LANES]; 13]) -> [u8; LANES] {
    exchange!(p; 0 4, 1 5, 2 6, 3 7, 0 1, 2 3, 0 2, 4 5, 6 7, 5 7);
    p[7] = p[8];
    exchange!(p; 1 4, 2 5, 3 6, 1 2, 1 3, 1 7, 4 5, 5 6, 6 7);
    p[7] = p[9];
    exchange!(p; 2 5, 3 6, 4 7, 2 3, 2 4, 5 6, 6 7);
    p[7] = p[10];
    exchange!(p; 3 5, 4 6, 3 4, 3 7, 5 6, 6 7);
    p[7] = p[11];
    exchange!(p; 4 5, 6 7, 4 6, 5 7);
    p[7] = p[12];
    exchange!(p; 5 6, 6 7, 5 6);
    p[6]
}

#[inline(always)]
fn sort_5<const LANES: usize>(values: &mut [[u8; LANES]; 5]) {
    exchange!(values; 0 1, 3 4, 2 4, 2 3, 1 4, 0 3, 0 2, 1 3, 1 2);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn naive(frame: &GrayFrame, radius_px: isize) -> Vec<u8> {
        let mut out = vec![];
        for v in 0..frame.height_px() as isize {
            for u in 0..frame.width_px() as isize {
                let mut values: Vec<u8> = (-radius_px..=radius_px)
                    .flat_map(|dv| (-radius_px..=radius_px).map(move |du| (du, dv)))
                    .map(|(du, dv)| frame.at_clamped(u + du, v + dv))
                    .collect();
                values.sort_unstable();
                out.push(values[values.len() / 2]);
            }
        }
        out
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]
        #[test]
        fn the_median_is_the_middle_of_the_sorted_neighbourhood(
            (width, height, pixels) in (1usize..40, 1usize..24)
                .prop_flat_map(|(w, h)| (Just(w), Just(h), proptest::collection::vec(any::<u8>(), w * h)))
        ) {
            let frame = GrayFrame::new(width, height, pixels).unwrap();
            let (three, five) = (median(&frame, MedianKernel::Three), median(&frame, MedianKernel::Five));
            prop_assert_eq!(three.pixels(), naive(&frame, 1));
            prop_assert_eq!(five.pixels(), naive(&frame, 2));
        }
    }

    /// A network of comparisons that is right for all zeros and ones is right for all values; the neighbourhood of the one pixel
    /// in the middle takes every pattern here.
    #[test]
    fn every_pattern_of_dark_and_bright_neighbours_has_its_median() {
        for pattern in 0u32..1 << 9 {
            let columns = std::array::from_fn(|dv| std::array::from_fn(|du| [(pattern >> (3 * dv + du) & 1) as u8]));
            let rows: [[[u8; 1]; 3]; 3] = columns;
            let by_column: [[[u8; 1]; 3]; 3] = std::array::from_fn(|du| {
                let mut column = rows.map(|row| row[du]);
                sort_3(&mut column);
                column
            });
            let sorted = std::array::from_fn(|rank| by_column.map(|column| column[rank]));
            assert_eq!(middle_of_9(sorted)[0], u8::from(pattern.count_ones() > 4), "{pattern:b}");
        }
        // Of 5 × 5 only the number of bright pixels in each column matters, as columns are sorted first.
        for code in 0..6usize.pow(5) {
            let bright: [usize; 5] = std::array::from_fn(|du| code / 6usize.pow(du as u32) % 6);
            let columns = std::array::from_fn(|rank| std::array::from_fn(|du| [u8::from(rank + bright[du] >= 5)]));
            assert_eq!(middle_of_25(columns)[0], u8::from(bright.iter().sum::<usize>() > 12), "{bright:?}");
        }
    }
}
