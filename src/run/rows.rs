//! From estimates to rows of `path.csv` and marks of the overlay.

use crate::calib::ScaleCalibration;
use crate::report::marks::{FrameMarks, RoiBox};
use crate::report::results::{PathRow, Status as RowStatus};
use crate::tracker::{CrossSection, Estimate, SeamEstimate, Status, roi};
use crate::units::{PixelPoint, StripeAxis};

/// The row of one frame; without an estimate it was unreadable.
pub fn row(
    frame: usize,
    file: String,
    time_s: f64,
    estimate: Option<&Estimate>,
    axis: StripeAxis,
    calibration: Option<ScaleCalibration>,
) -> PathRow {
    let Some(estimate) = estimate else { return PathRow::empty(frame, file, time_s, RowStatus::Unreadable) };
    let status = match estimate.status {
        Status::Seeking => RowStatus::Seeking,
        Status::Tracked => RowStatus::Tracked,
        Status::Coasting => RowStatus::Coasting,
        Status::Lost => RowStatus::Lost,
    };
    let (kcf, seam, section) = (estimate.kcf, estimate.seam, estimate.section);
    let gap_px = section.and_then(|section| section.gap_px);
    let shoulder = |side: usize| section.and_then(|section| section.sides[side].shoulder);
    PathRow {
        kcf_u_px: kcf.map(|k| k.peak.u_px),
        kcf_v_px: kcf.map(|k| k.peak.v_px),
        psr: kcf.map(|k| k.psr),
        template_updated: kcf.is_some_and(|k| k.template_updated),
        u_px: seam.map(|s| s.centre.u_px),
        v_px: seam.map(|s| s.centre.v_px),
        x_mm: seam.zip(calibration).map(|(s, c)| c.mm_from_px(axis.along_px(s.centre))),
        x_std_mm: seam.zip(calibration).map(|(s, c)| s.std_px * c.mm_per_px.get()),
        nis: estimate.nis,
        gap_px,
        gap_mm: gap_px.zip(calibration).map(|(gap_px, c)| gap_px * c.mm_per_px.get()),
        mismatch_px: section.and_then(|section| section.mismatch_px),
        shoulder_before_u_px: shoulder(0).map(|point| point.u_px),
        shoulder_before_v_px: shoulder(0).map(|point| point.v_px),
        shoulder_behind_u_px: shoulder(1).map(|point| point.u_px),
        shoulder_behind_v_px: shoulder(1).map(|point| point.v_px),
        ..PathRow::empty(frame, file, time_s, status)
    }
}

/// What overlays show of one frame.
pub fn marks(estimate: Option<&Estimate>) -> FrameMarks {
    let Some(estimate) = estimate else { return FrameMarks::default() };
    FrameMarks {
        stripe: estimate.section.map(|section| stripe(&section)).unwrap_or_default(),
        roi: roi(estimate).map(|roi| RoiBox {
            u_px: roi.centre.u_px - 0.5 * roi.width_px,
            v_px: roi.centre.v_px - 0.5 * roi.height_px,
            width_px: roi.width_px,
            height_px: roi.height_px,
        }),
    }
}

/// The stripe as it was fitted, from one end to the other.
fn stripe(section: &CrossSection) -> Vec<PixelPoint> {
    let [before, behind] = section.sides;
    before.points().chain(behind.points().rev()).collect()
}

/// Writes the smoothed path into the rows.
pub fn fill_smoothed(
    rows: &mut [PathRow],
    smoothed: &[Option<SeamEstimate>],
    axis: StripeAxis,
    calibration: ScaleCalibration,
) {
    for (row, seam) in rows.iter_mut().zip(smoothed) {
        let Some(seam) = seam else { continue };
        (row.smooth_u_px, row.smooth_v_px) = (Some(seam.centre.u_px), Some(seam.centre.v_px));
        row.smooth_x_mm = Some(calibration.mm_from_px(axis.along_px(seam.centre)));
        row.smooth_x_std_mm = Some(seam.std_px * calibration.mm_per_px.get());
    }
}
