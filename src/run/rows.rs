//! From estimates to rows of `path.csv` and marks of the overlay.

use crate::calib::Ruler;
use crate::report::marks::{FrameMarks, RoiBox};
use crate::report::results::{PathRow, Status as RowStatus};
use crate::tracker::{CrossSection, Estimate, Measure, Measures, SeamEstimate, Status, roi};
use crate::units::PixelPoint;

/// The row of one frame; without an estimate it was unreadable. Without a ruler nothing is known but pixels.
pub fn row(frame: usize, file: String, time_s: f64, estimate: Option<&Estimate>, ruler: Option<&Ruler>) -> PathRow {
    let Some(estimate) = estimate else { return PathRow::empty(frame, file, time_s, RowStatus::Unreadable) };
    let status = match estimate.status {
        Status::Seeking => RowStatus::Seeking,
        Status::Tracked => RowStatus::Tracked,
        Status::Coasting => RowStatus::Coasting,
        Status::Lost => RowStatus::Lost,
    };
    let (kcf, seam, section) = (estimate.kcf, estimate.seam, estimate.section);
    let shoulder = |side: usize| section.and_then(|section| section.sides[side].shoulder);
    let row = PathRow {
        kcf_u_px: kcf.map(|k| k.peak.u_px),
        kcf_v_px: kcf.map(|k| k.peak.v_px),
        psr: kcf.map(|k| k.psr),
        template_updated: kcf.is_some_and(|k| k.template_updated),
        u_px: seam.map(|s| s.centre.u_px),
        v_px: seam.map(|s| s.centre.v_px),
        along_std_px: seam.map(|s| s.std_px),
        nis: estimate.nis,
        gap_px: section.and_then(|section| section.gap_px),
        mismatch_px: section.and_then(|section| section.mismatch_px),
        shoulder_before_u_px: shoulder(0).map(|point| point.u_px),
        shoulder_before_v_px: shoulder(0).map(|point| point.v_px),
        shoulder_behind_u_px: shoulder(1).map(|point| point.u_px),
        shoulder_behind_v_px: shoulder(1).map(|point| point.v_px),
        ..PathRow::empty(frame, file, time_s, status)
    };
    let Some(ruler) = ruler else { return row };
    let row = match section {
        Some(section) => measured(row, &section, ruler),
        None => row,
    };
    match seam {
        Some(seam) => positioned(row, &seam, ruler),
        None => row,
    }
}

/// What a welder buys.
fn measured(row: PathRow, section: &CrossSection, ruler: &Ruler) -> PathRow {
    let measures = Measures::of(&section.profile, &ruler.sensor, ruler.axis);
    let value = |measure: Option<Measure>| measure.map(|measure| measure.value);
    let std = |measure: Option<Measure>| measure.map(|measure| measure.std);
    PathRow {
        gap_mm: value(measures.gap_mm),
        gap_std_mm: std(measures.gap_mm),
        hi_lo_mm: value(measures.hi_lo_mm),
        hi_lo_std_mm: std(measures.hi_lo_mm),
        groove_width_mm: value(measures.groove_width_mm),
        groove_width_std_mm: std(measures.groove_width_mm),
        depth_mm: value(measures.depth_mm),
        depth_std_mm: std(measures.depth_mm),
        opening_angle_deg: value(measures.opening_angle_deg),
        opening_angle_std_deg: std(measures.opening_angle_deg),
        root_opening_mm: value(measures.root_opening_mm),
        root_opening_std_mm: std(measures.root_opening_mm),
        area_mm2: value(measures.area_mm2),
        area_std_mm2: std(measures.area_mm2),
        ..row
    }
}

/// The seam in millimetres; in the plane of a calibrated laser with the two errors that are never one.
fn positioned(row: PathRow, seam: &SeamEstimate, ruler: &Ruler) -> PathRow {
    let noise = noise_std_mm(ruler, seam);
    let row = PathRow { x_mm: ruler.position_mm(seam.centre), x_std_mm: noise[0], ..row };
    let Some(sensor) = ruler.sensor.laser_camera() else { return row };
    let (point, calibration) = (sensor.point(seam.centre), sensor.calibration_covariance_mm2(seam.centre));
    PathRow {
        lateral_mm: point.map(|point| point.lateral_mm),
        height_mm: point.map(|point| point.height_mm),
        lateral_std_mm: noise[0],
        height_std_mm: noise[1],
        calib_lateral_std_mm: calibration.map(|covariance| covariance[(0, 0)].sqrt()),
        calib_height_std_mm: calibration.map(|covariance| covariance[(1, 1)].sqrt()),
        calibrated: Some(sensor.is_calibrated(seam.centre)),
        ..row
    }
}

/// σ of (lateral, height) that the pictures' noise makes \[mm\].
fn noise_std_mm(ruler: &Ruler, seam: &SeamEstimate) -> [Option<f64>; 2] {
    let noise = ruler.noise_mm2(seam.centre, seam.std_px, seam.std_across_px);
    [0, 1].map(|i| noise.map(|noise| noise[(i, i)].sqrt()))
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
pub fn fill_smoothed(rows: &mut [PathRow], smoothed: &[Option<SeamEstimate>], ruler: &Ruler) {
    for (row, seam) in rows.iter_mut().zip(smoothed) {
        let Some(seam) = seam else { continue };
        (row.smooth_u_px, row.smooth_v_px) = (Some(seam.centre.u_px), Some(seam.centre.v_px));
        row.smooth_along_std_px = Some(seam.std_px);
        row.smooth_x_mm = ruler.position_mm(seam.centre);
        row.smooth_x_std_mm = noise_std_mm(ruler, seam)[0];
    }
}
