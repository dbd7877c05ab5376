//! A results directory as `track` would leave it, from a made-up run: a stripe with a gap that wanders on a sine,
//! covered twice, with a KCF that strays while it is covered.
#![expect(clippy::unwrap_used, reason = "a test that cannot make its input must fail")]

use std::f64::consts::TAU;
use std::path::Path;

use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64;
use seamtrack::eval::Errors;
use seamtrack::frame::GrayFrame;
use seamtrack::report::marks::{FrameMarks, RoiBox};
use seamtrack::report::results::{PathRow, Status, write_path_csv};
use seamtrack::report::summary::{
    Calibration, ErrorTable, FrameCounts, Input, Joint, Limits, Percentiles, SCHEMA_VERSION, Summary, Timing,
    write_summary,
};
use seamtrack::report::thumbnails::{DEFAULT_BUDGET_BYTES, ThumbnailStore};
use seamtrack::units::{LengthUnit, MmPerPx, PixelPoint, StripeAxis};

const WIDTH_PX: usize = 640;
const HEIGHT_PX: usize = 480;
const SCALE: f64 = 0.073;
const STRIPE_V_PX: f64 = 236.0;

/// How good the made-up filter is.
#[derive(Clone, Copy, PartialEq)]
pub struct Noise {
    pub kcf_px: f64,
    pub filtered_px: f64,
    pub smoothed_px: f64,
}

pub const GOOD: Noise = Noise { kcf_px: 0.9, filtered_px: 0.32, smoothed_px: 0.15 };

fn true_u_px(frame: usize) -> f64 {
    let t = frame as f64;
    250.0 + 0.02 * (t % 5000.0) + 41.0 * (TAU * t / 131.0).sin() + 6.0 * (TAU * t / 47.0).sin()
}

fn status(frame: usize, frames: usize) -> Status {
    let cycle = frame % 900;
    match (frame, cycle) {
        (0..3, _) => Status::Seeking,
        (_, 77) => Status::Unreadable,
        (_, 120..126 | 199..202) => Status::Coasting,
        (_, 126..138) if frame + 20 < frames => Status::Lost,
        _ => Status::Tracked,
    }
}

/// Centred noise of standard deviation `sd`: the sum of four uniform numbers.
fn noise(random: &mut Pcg64, sd: f64) -> f64 {
    let sum: f64 = (0..4).map(|_| random.random_range(-1.0..1.0)).sum();
    sum * sd * (3.0_f64 / 4.0).sqrt()
}

pub fn rows(frames: usize, quality: Noise) -> Vec<PathRow> {
    let mut random = Pcg64::seed_from_u64(8);
    let origin_px = true_u_px(3);
    let mut straying = 0.0;
    let mut filter_error_px = 0.0;
    let mut smooth_error_px = 0.0;
    (0..frames)
        .map(|frame| {
            let status = status(frame, frames);
            let truth = true_u_px(frame);
            let v_px = Some(STRIPE_V_PX + 12.0);
            let mut row = PathRow::empty(frame, format!("{frame:05}.png"), frame as f64 * 0.2, status);
            if matches!(status, Status::Seeking | Status::Unreadable) {
                return row;
            }
            straying = if status == Status::Tracked { straying * 0.6 } else { straying + 4.0 };
            let kcf = truth + straying + noise(&mut random, quality.kcf_px);
            (row.kcf_u_px, row.kcf_v_px) = (Some(kcf), v_px);
            let psr = 11.2 - 0.8 * straying.min(8.0) + noise(&mut random, 0.7);
            row.psr = Some(psr.max(2.0));
            row.template_updated = status == Status::Tracked && psr > 8.0;
            filter_error_px = 0.6 * filter_error_px + noise(&mut random, 0.8 * quality.filtered_px);
            smooth_error_px = 0.9 * smooth_error_px + noise(&mut random, 0.43 * quality.smoothed_px);
            if status != Status::Lost {
                let grown = if status == Status::Coasting { 3.0 } else { 1.0 };
                let u_px = truth + grown * filter_error_px;
                (row.u_px, row.v_px) = (Some(u_px), v_px);
                row.x_mm = Some(SCALE * (u_px - origin_px));
                row.x_std_mm = Some(SCALE * grown * quality.filtered_px);
                let z = noise(&mut random, 1.0);
                row.nis = (status == Status::Tracked).then_some(z * z + straying);
            }
            let u_px = truth + smooth_error_px;
            (row.smooth_u_px, row.smooth_v_px) = (Some(u_px), v_px);
            row.smooth_x_mm = Some(SCALE * (u_px - origin_px));
            row.smooth_x_std_mm = Some(SCALE * quality.smoothed_px);
            row
        })
        .collect()
}

fn errors(rows: &[PathRow], of: impl Fn(&PathRow) -> Option<f64>, sigma: impl Fn(&PathRow) -> Option<f64>) -> Errors {
    let signed: Vec<f64> = rows.iter().filter_map(|row| Some(SCALE * (of(row)? - true_u_px(row.frame)))).collect();
    let n = signed.len() as f64;
    let mut absolute: Vec<f64> = signed.iter().map(|e| e.abs()).collect();
    absolute.sort_by(f64::total_cmp);
    let mae = absolute.iter().sum::<f64>() / n;
    let inside =
        rows.iter().filter_map(|row| Some((SCALE * (of(row)? - true_u_px(row.frame))).abs() < 2.0 * sigma(row)?));
    let inside: Vec<bool> = inside.collect();
    Errors {
        unit: LengthUnit::Mm,
        frames: signed.len(),
        mae,
        max: absolute[absolute.len() - 1],
        std: (absolute.iter().map(|e| (e - mae).powi(2)).sum::<f64>() / n).sqrt(),
        rmse: (signed.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
        p95: absolute[(0.95 * n) as usize],
        bias: signed.iter().sum::<f64>() / n,
        coverage_2sigma: (!inside.is_empty())
            .then(|| inside.iter().filter(|&&inside| inside).count() as f64 / inside.len() as f64),
        wrong_frames: absolute.iter().filter(|&&e| e > 1.0).count(),
        unavailable_frames: rows.iter().skip(3).filter(|row| of(row).is_none()).count(),
    }
}

fn summary(rows: &[PathRow], with_truth: bool) -> Summary {
    let count = |status| rows.iter().filter(|row| row.status == status).count();
    let config = serde_json::json!({
        "preset": "robust", "kcf": { "learning_rate": 0.03, "psr_threshold": 8.0, "padding": 2.5 },
        "filter": { "period_s": 0.2, "sigma_px": 0.32 },
    });
    Summary {
        schema_version: SCHEMA_VERSION,
        program: "seamtrack 0.1.0".into(),
        input: Input {
            path: "recordings/butt-sine".into(),
            width_px: WIDTH_PX,
            height_px: HEIGHT_PX,
            more: serde_json::Map::new(),
        },
        config,
        calibration: Calibration {
            mm_per_px: Some(MmPerPx::DU_2022),
            origin_px: Some(true_u_px(3)),
            source: "default of Du 2022".into(),
            ..Calibration::unknown(StripeAxis::Horizontal)
        },
        limits: Limits { psr: Some(8.0), nis: Some(9.0), max_unavailable_pct: Some(5.0), tolerance_mm: None },
        frames: FrameCounts {
            total: rows.len(),
            seeking: count(Status::Seeking),
            tracked: count(Status::Tracked),
            coasting: count(Status::Coasting),
            lost: count(Status::Lost),
            unreadable: count(Status::Unreadable),
            repeated: 4,
            saturated: 0,
            frozen: 0,
            bad_stamps: 0,
        },
        joint: Joint {
            kind: "butt".into(),
            decided_at_frame: Some(3),
            reason: "two facing edges with a 13 px gap".into(),
            doubt: None,
            contradicted_by: None,
            later: vec![],
        },
        timing: Timing {
            decode_ms: Percentiles { p50: 1.9, p99: 3.2, max: 6.4 },
            track_ms: Percentiles { p50: 4.1, p99: 7.7, max: 15.0 },
            frames_per_second: 162.0,
        },
        plane_errors: None,
        errors: with_truth.then(|| ErrorTable {
            kcf: Some(errors(rows, |row| row.kcf_u_px, |_| None)),
            filtered: Some(errors(rows, |row| row.u_px, |row| row.x_std_mm)),
            smoothed: Some(errors(rows, |row| row.smooth_u_px, |row| row.smooth_x_std_mm)),
        }),
        tolerance: None,
    }
}

/// The stripe with its gap at `u_px`, speckled.
pub fn picture(u_px: f64, random: &mut Pcg64) -> GrayFrame {
    let mut frame = GrayFrame::filled(WIDTH_PX, HEIGHT_PX, 9).unwrap();
    random.fill(frame.pixels_mut());
    frame.pixels_mut().iter_mut().for_each(|grey| *grey = 6 + *grey % 7);
    for v in STRIPE_V_PX as usize - 10..STRIPE_V_PX as usize + 35 {
        for u in 0..WIDTH_PX {
            let in_gap = (u as f64 - u_px).abs() < 6.5;
            let (centre, amplitude) = if in_gap { (STRIPE_V_PX + 24.0, 70.0) } else { (STRIPE_V_PX, 200.0) };
            let across = (v as f64 - centre) / 2.4;
            let light = amplitude * random.random_range(0.6..1.4) * (-0.5 * across * across).exp();
            let grey = &mut frame.pixels_mut()[v * WIDTH_PX + u];
            *grey = (f64::from(*grey) + light).clamp(0.0, 255.0) as u8;
        }
    }
    frame
}

pub fn marks(row: &PathRow) -> FrameMarks {
    let centre = row.u_px.or(row.smooth_u_px).unwrap_or(320.0);
    FrameMarks {
        stripe: (0..=32).map(|i| PixelPoint::new(f64::from(i) * 20.0, STRIPE_V_PX)).collect(),
        roi: Some(RoiBox { u_px: centre - 100.0, v_px: STRIPE_V_PX - 63.0, width_px: 200.0, height_px: 150.0 }),
    }
}

/// Write a run of `frames` frames into `dir`, calling the library as `track` does.
pub fn write_run(dir: &Path, frames: usize, quality: Noise, with_truth: bool) {
    std::fs::create_dir_all(dir).unwrap();
    let rows = rows(frames, quality);
    let mut random = Pcg64::seed_from_u64(1);
    // A period of the slow sine rendered once is enough to look at.
    let pictures: Vec<GrayFrame> = (0..frames.min(131)).map(|frame| picture(true_u_px(frame), &mut random)).collect();
    let mut thumbnails = ThumbnailStore::new(DEFAULT_BUDGET_BYTES, Some(frames));
    for row in rows.iter().filter(|row| row.status != Status::Unreadable) {
        thumbnails.offer(row, &pictures[row.frame % pictures.len()], &marks(row));
    }
    thumbnails.write(dir).unwrap();
    write_path_csv(&dir.join("path.csv"), &rows).unwrap();
    write_summary(&dir.join("summary.json"), &summary(&rows, with_truth)).unwrap();
    if with_truth {
        let lines = (0..frames).map(|frame| format!("{frame},{:.4},,,0\n", true_u_px(frame)));
        let text: String = std::iter::once("frame,u_px,v_px,x_mm,occluded\n".to_owned()).chain(lines).collect();
        std::fs::write(dir.join("truth.csv"), text).unwrap();
    }
}
