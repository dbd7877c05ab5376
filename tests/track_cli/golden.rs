//! The paper's method against its recorded path.
//!
//! `SEAMTRACK_BLESS=1 cargo test --test track_cli golden` records it anew; look at the difference before committing.

use std::path::{Path, PathBuf};

use seamtrack::report::results::{PathRow, read_path_csv};

use crate::program::{demo, rows, track};

/// How far a path may lie from the recorded one. Processors with other vector units add up the transforms' 32-bit
/// numbers in another order: relative differences of 1e-6 in the response, which move the vertex of its parabola (label
/// of 6.9 px, curvature 1/48 per px²) by up to 5e-5 px. The recorded digits are rounded to 0.001 px on both sides. 0.005 px
/// is five of those digits, and a tenth of the smallest error reported anywhere.
const POSITION_PX: f64 = 0.005;
/// [`POSITION_PX`] at 0.073 mm/px, and a rounded digit.
const POSITION_MM: f64 = 0.0005;
/// The standard deviations do not depend on what is measured: only their last digit may differ.
const STD_MM: f64 = 0.0001;
/// A relative 1e-4 of PSRs about 10: the sidelobe's deviation is a difference of large sums.
const PSR: f64 = 0.002;
/// 2·ν·[`POSITION_PX`]/S for innovations ν up to 10 px and S of 5 px² or more (R of the paper).
const NIS: f64 = 0.02;

fn golden() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/golden/demo-butt-paper.csv")
}

fn close(ours: Option<f64>, recorded: Option<f64>, tolerance: f64) -> bool {
    match (ours, recorded) {
        (Some(ours), Some(recorded)) => (ours - recorded).abs() <= tolerance,
        (None, None) => true,
        _ => false,
    }
}

fn same(ours: &PathRow, recorded: &PathRow) -> bool {
    let exact = |row: &PathRow| (row.frame, row.file.clone(), row.status, row.template_updated);
    exact(ours) == exact(recorded)
        && close(Some(ours.time_s), Some(recorded.time_s), 0.0)
        && close(ours.kcf_u_px, recorded.kcf_u_px, POSITION_PX)
        && close(ours.kcf_v_px, recorded.kcf_v_px, POSITION_PX)
        && close(ours.psr, recorded.psr, PSR)
        && close(ours.u_px, recorded.u_px, POSITION_PX)
        && close(ours.v_px, recorded.v_px, POSITION_PX)
        && close(ours.x_mm, recorded.x_mm, POSITION_MM)
        && close(ours.x_std_mm, recorded.x_std_mm, STD_MM)
        && close(ours.nis, recorded.nis, NIS)
        && close(ours.smooth_u_px, recorded.smooth_u_px, POSITION_PX)
        && close(ours.smooth_v_px, recorded.smooth_v_px, POSITION_PX)
        && close(ours.smooth_x_mm, recorded.smooth_x_mm, POSITION_MM)
        && close(ours.smooth_x_std_mm, recorded.smooth_x_std_mm, STD_MM)
}

/// A PSR at the threshold or a peak half way between two pixels would let rounding decide what the template learns.
fn assert_off_the_edge(row: &PathRow) {
    let to_threshold = row.psr.map_or(1.0, |psr| (psr - 8.0).abs());
    let to_half = |peak: Option<f64>| peak.map_or(0.5, |px| (px.rem_euclid(1.0) - 0.5).abs());
    assert!(to_threshold > PSR, "{row:?}");
    assert!(to_half(row.kcf_u_px).min(to_half(row.kcf_v_px)) > 5e-4, "{row:?}");
}

#[test]
fn the_papers_method_walks_the_recorded_path() {
    let folder = tempfile::tempdir().unwrap();
    track(&demo(), folder.path()).args(["--preset", "paper"]).assert().success();
    if std::env::var_os("SEAMTRACK_BLESS").is_some_and(|value| value == "1") {
        std::fs::copy(folder.path().join("path.csv"), golden()).unwrap();
    }
    let (ours, recorded) = (rows(folder.path()), read_path_csv(&golden()).unwrap());
    assert_eq!(ours.len(), recorded.len());
    recorded.iter().for_each(assert_off_the_edge);
    for (ours, recorded) in ours.iter().zip(&recorded) {
        assert!(same(ours, recorded), "now      {ours:?}\nrecorded {recorded:?}");
    }
}
