//! The median against OpenCV's, on random pictures and on the demonstration's.
#![cfg(feature = "opencv")]
#![expect(clippy::disallowed_types, reason = "OpenCV is what is compared with")]

use opencv::core::{Mat, MatTraitConstManual};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use seamtrack::GrayFrame;
use seamtrack::imgproc::{MedianKernel, median};

fn of_opencv(frame: &GrayFrame, side_px: i32) -> opencv::Result<Vec<u8>> {
    let (rows, columns) = (frame.height_px() as i32, frame.width_px() as i32);
    let picture = Mat::new_rows_cols_with_data(rows, columns, frame.pixels())?;
    let mut filtered = Mat::default();
    opencv::imgproc::median_blur(&picture, &mut filtered, side_px)?;
    Ok(filtered.data_typed::<u8>()?.to_vec())
}

fn is_the_same(frame: &GrayFrame) {
    for (kernel, side_px) in [(MedianKernel::Three, 3), (MedianKernel::Five, 5)] {
        let size_px = (frame.width_px(), frame.height_px());
        assert!(
            median(frame, kernel).pixels() == of_opencv(frame, side_px).ok().as_deref().unwrap_or_default(),
            "{side_px} px on {size_px:?}"
        );
    }
}

#[test]
fn random_pictures_of_any_size_give_the_same_bytes() {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    for _ in 0..300 {
        let (width, height) = (random.random_range(1..80), random.random_range(1..40));
        // Few grey levels make many equal neighbours.
        let levels = random.random_range(1..=255u8);
        let pixels = (0..width * height).map(|_| random.random_range(0..=levels)).collect();
        is_the_same(&GrayFrame::new(width, height, pixels).unwrap());
    }
}

#[test]
fn pictures_of_a_stripe_give_the_same_bytes() {
    let mut recording = seamtrack::source::open("fixtures/demo-butt".as_ref(), 0.2).unwrap();
    for _ in 0..10 {
        is_the_same(&recording.next_frame().unwrap().picture.unwrap());
    }
}
