//! The page of a calibration: what each view leaves over, how sure a projection is over the picture, what is weak and which
//! view to add. It stands alone, without script, and opens without a network.

mod drawing;

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::head::{WITHOUT_SCRIPT, head};
use crate::calib::camera::CameraFit;
use crate::calib::error::GOOD_VIEWS;
use crate::calib::file::CalibrationFile;
use crate::calib::intrinsics::INTRINSIC_NAMES;
use crate::calib::laser::LaserFit;
use crate::calib::laser_camera::PlanePoint;
use crate::calib::uncertainty::{UncertaintyMap, uncertainty_map};

const OWN_STYLE: &str = include_str!("calibration.css");
/// A view left out that is off by more than this factor over all views is worth a look.
const CONSPICUOUS: f64 = 1.5;
/// Heights at which the sensor's uncertainty is listed.
const HEIGHTS: usize = 5;

/// The camera's uncertainty over the picture, for the depths in which its boards stood.
#[must_use]
pub fn camera_map(fit: &CameraFit) -> Option<UncertaintyMap> {
    let depths = || fit.views.iter().map(|view| view.pose.translation_mm.z);
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let extent = |values: &mut dyn Iterator<Item = f64>| values.fold(none, |[a, b], x| [a.min(x), b.max(x)]);
    let corners = || fit.views.iter().flat_map(|view| &view.sighting.corners);
    let seen = [extent(&mut corners().map(|c| c.x)), extent(&mut corners().map(|c| c.y))];
    uncertainty_map(&fit.intrinsics, &fit.replicates, fit.size_px, extent(&mut depths()), seen)
}

/// The page of a camera.
#[must_use]
pub fn camera_page(input: &str, file: &CalibrationFile, fit: &CameraFit) -> String {
    let map = camera_map(fit);
    let body = html! {
        (headline("calibrate camera", input, &fit.advice, &fit.left_out, &format!(
            "{:.3} px over {} views, {:.3} px on views left out", fit.rms_px, fit.views.len(), fit.left_out_rms_px)))
        section.pair {
            figure {
                h2 { "What is left at the corners" }
                (PreEscaped(drawing::residuals(fit)))
                figcaption { "Strokes are 200 × as long as the residuals. They should point anywhere: a pattern that many boards share is a lens that the model does not have, one board's own pattern a board that is not flat." }
            }
            @if let Some(map) = &map {
                figure {
                    h2 { "How sure a projection is" }
                    (PreEscaped(drawing::uncertainty(map, fit.size_px)))
                    figcaption { "One σ in pixels, by leaving out one pose after another, with the rigid motion taken off. Dark: no board came there." }
                }
            }
        }
        section {
            h2 { "Views" }
            div.scroll { table {
                thead { tr { th {} @for head in ["rms [px]", "left out [px]", "tilt [°]", "distance [mm]", "corners"] { th scope="col" { (head) } } } }
                tbody { @for view in &fit.views {
                    tr.conspicuous[view.left_out_rms_px > CONSPICUOUS * fit.left_out_rms_px] {
                        th scope="row" { (view.sighting.name) }
                        @for cell in [
                            format!("{:.3}", view.rms_px), format!("{:.3}", view.left_out_rms_px), format!("{:.1}", view.tilt_deg),
                            format!("{:.0}", view.pose.translation_mm.z),
                            format!("{} of {}", view.sighting.used_corners(), view.sighting.corners.len()),
                        ] { td { (cell) } }
                    }
                } }
            } }
            p.note { "Left out: the view took no part in the fit, only its pose is its own. A calibration is as good as these, not as the first column." }
        }
        section {
            h2 { "Camera" }
            (parameters(&fit.intrinsics.to_array(), &std::array::from_fn::<f64, 9, _>(|i| fit.covariance[(i, i)].max(0.0).sqrt()), &fit.formal_sigma))
            p.note { "σ: by leaving out one pose after another. Formal: as if all corners were independent; on real boards it is far too small." }
        }
        (foot(file))
    };
    page(&format!("{input} – camera – seamtrack"), &body)
}

/// The page of a laser plane.
#[must_use]
pub fn laser_page(input: &str, file: &CalibrationFile, fit: &LaserFit) -> String {
    let n = fit.sensor.plane().normal();
    let body = html! {
        (headline("calibrate laser", input, &fit.advice, &fit.left_out, &format!(
            "{:.3} mm over the stripes of {} poses", fit.rms_mm, fit.poses)))
        section.pair {
            figure {
                h2 { "Each view against the plane" }
                (PreEscaped(drawing::plane_residuals(fit)))
                figcaption { "Mean distance of a view's stripe from the plane that the other poses give [mm]; filled: contradicts the others." }
            }
            figure {
                h2 { "Where the stripes lay" }
                (PreEscaped(drawing::coverage(fit)))
                figcaption { "In the laser's plane: lateral to the right, height upwards, mm. Outside the frame nothing was calibrated." }
            }
        }
        section {
            h2 { "Views" }
            div.scroll { table {
                thead { tr { th {} @for head in ["mean [mm]", "left out [mm]", "as height [mm]", "rms [mm]", "scatter [px]", "rows", "independent", "weight"] { th scope="col" { (head) } } } }
                tbody { @for view in &fit.views {
                    tr.conspicuous[view.flagged] {
                        th scope="row" { (view.seen.board.name) }
                        @for cell in [
                            format!("{:+.3}", view.mean_mm), format!("{:+.3}", view.left_out_mm),
                            format!("{:.2}", (view.left_out_mm * view.height_per_mm).abs()), format!("{:.3}", view.rms_mm),
                            format!("{:.2}", view.seen.stripe.scatter_px), view.seen.stripe.pixels.len().to_string(),
                            format!("{:.0}", view.seen.stripe.independent_rows), format!("{:.2}", view.weight),
                        ] { td { (cell) } }
                    }
                } }
            } }
        }
        section {
            h2 { "How sure a point is" }
            div.scroll { table {
                thead { tr { th {} @for head in ["lateral σ [mm]", "height σ [mm]", "lateral [mm/px]", "height [mm/px]"] { th scope="col" { (head) } } } }
                tbody { @for (height_mm, cells) in heights(fit) {
                    tr { th scope="row" { "height " (format!("{height_mm:.0}")) " mm" } @for cell in cells { td { (cell) } } }
                } }
            } }
            p.note { "σ is the calibration's own error: the same in every frame, so it does not average out. A distance between two points is known far better than either." }
        }
        section {
            h2 { "Plane and camera" }
            p { "normal (" (format!("{:.6}, {:.6}, {:.6}", n.x, n.y, n.z)) "), distance " (format!("{:.4}", fit.sensor.plane().distance_mm())) " mm, "
                @if fit.jointly { "fitted together with the camera." } @else { "under the camera as it was given." } }
            (parameters(&fit.sensor.intrinsics().to_array(), &std::array::from_fn::<f64, 9, _>(|i| fit.sensor.covariance().map_or(0.0, |c| c[(i, i)].max(0.0).sqrt())), &[0.0; 9]))
        }
        (foot(file))
    };
    page(&format!("{input} – laser plane – seamtrack"), &body)
}

/// σ and scale at heights over the calibrated range.
fn heights(fit: &LaserFit) -> Vec<(f64, [String; 4])> {
    let Some(range) = fit.sensor.range() else { return vec![] };
    let lateral_mm = 0.5 * (range.lateral_mm[0] + range.lateral_mm[1]);
    let at = |i: usize| {
        let height_mm =
            range.height_mm[1] - (range.height_mm[1] - range.height_mm[0]) * i as f64 / (HEIGHTS - 1) as f64;
        let pixel = fit.sensor.pixel(PlanePoint { lateral_mm, height_mm })?;
        let (covariance, jacobian) = (fit.sensor.calibration_covariance_mm2(pixel)?, fit.sensor.jacobian(pixel)?);
        let values =
            [covariance[(0, 0)].sqrt(), covariance[(1, 1)].sqrt(), jacobian.row(0).norm(), jacobian.row(1).norm()];
        Some((height_mm, values.map(|x| format!("{x:.3}"))))
    };
    (0..HEIGHTS).filter_map(at).collect()
}

fn headline(command: &str, input: &str, advice: &[String], left_out: &[String], sentence: &str) -> Markup {
    let trust = if advice.is_empty() { "good" } else { "check" };
    html! {
        header class={ "headline " (trust) } {
            p.program { "seamtrack " (command) " · " (input) }
            h1 { span.light { (trust) } " " (sentence) }
            @if advice.is_empty() {
                ul.facts { li { "Nothing is missing: " (GOOD_VIEWS) " views or more, tilts to all sides, depth and picture covered." } }
            } @else {
                ul.doubts { @for sentence in advice { li { (sentence) } } }
            }
            @if !left_out.is_empty() { ul.facts { @for reason in left_out { li { "left out: " (reason) } } } }
        }
    }
}

fn parameters(values: &[f64; 9], sigma: &[f64; 9], formal: &[f64; 9]) -> Markup {
    let has_formal = formal.iter().any(|sigma| *sigma > 0.0);
    html! {
        div.scroll { table {
            thead { tr { th {} th { "value" } th { "σ" } @if has_formal { th { "formal" } } } }
            tbody { @for (i, name) in INTRINSIC_NAMES.iter().enumerate().filter(|(i, _)| *i + 1 < INTRINSIC_NAMES.len() || values[*i] != 0.0) {
                @let decimals = if i < 4 { 3 } else { 6 };
                tr {
                    th scope="row" { (name) @if i < 4 { " [px]" } }
                    td { (format!("{:.decimals$}", values[i])) }
                    td { (format!("{:.decimals$}", sigma[i])) }
                    @if has_formal { td { (format!("{:.decimals$}", formal[i])) } }
                }
            } }
        } }
    }
}

fn foot(file: &CalibrationFile) -> Markup {
    html! {
        section {
            h2 { "Pictures" }
            details {
                summary { (file.images.len()) " pictures and their SHA-256" }
                pre { @for image in &file.images { (image.sha256) "  " (image.file) "\n" } }
            }
            p.note { "Calibration " (file.id) " of " (file.date) ", schema version " (file.schema_version) ", seamtrack " (env!("CARGO_PKG_VERSION")) "." }
        }
    }
}

fn page(title: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (head(title, WITHOUT_SCRIPT, &html! { style { (PreEscaped(OWN_STYLE)) } }))
            body { (body) }
        }
    };
    page.into_string()
}
