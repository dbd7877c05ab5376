//! A camera from and to other programs' files: OpenCV's YAML, ROS' `camera_info`, Kalibr's camchain (read only).

use super::intrinsics::Intrinsics;
use super::laser_camera::LaserCamera;
use super::yaml::Yaml;

/// Names that OpenCV's examples and users give the camera's matrix and its distortion.
const MATRICES: [&str; 6] =
    ["camera_matrix.data", "K.data", "M.data", "Camera_Matrix.data", "cameraMatrix.data", "M1.data"];
const DISTORTIONS: [&str; 7] = [
    "distortion_coefficients.data",
    "D.data",
    "Distortion_Coefficients.data",
    "distCoeffs.data",
    "dist_coeffs.data",
    "D1.data",
    "distortion.data",
];

/// A camera from another program.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The camera.
    pub intrinsics: Intrinsics,
    /// Columns and rows of its pictures, where the file says so.
    pub size_px: Option<(usize, usize)>,
    /// Whose file it was.
    pub dialect: &'static str,
}

/// Reads a camera.
///
/// # Errors
/// In one line, what is missing or of another kind.
pub fn import_camera(text: &str) -> Result<Imported, String> {
    let yaml = Yaml::parse(text)?;
    if let Some(intrinsics) = yaml.numbers(&["cam0.intrinsics"])? {
        return kalibr(&yaml, &intrinsics);
    }
    let matrix = yaml.numbers(&MATRICES)?.ok_or("holds no camera matrix of OpenCV or ROS and no cam0 of Kalibr")?;
    let &[fx, skew, cx, zero_a, fy, cy, zero_b, zero_c, one] = matrix.as_slice() else {
        return Err(format!("its camera matrix has {} numbers, not 9", matrix.len()));
    };
    if skew != 0.0 || zero_a != 0.0 || zero_b != 0.0 || zero_c != 0.0 || one != 1.0 {
        return Err("its camera matrix is not fx 0 cx, 0 fy cy, 0 0 1".into());
    }
    if let Some(model) =
        yaml.word("distortion_model").filter(|model| !["plumb_bob", "rational_polynomial", "radtan"].contains(model))
    {
        return Err(format!("its distortion model {model} is another than the one with k1 k2 p1 p2 k3"));
    }
    let distortion = yaml.numbers(&DISTORTIONS)?.unwrap_or_default();
    let ros = yaml.word("camera_name").is_some() || yaml.word("distortion_model").is_some();
    let size = |name: &str| Ok::<_, String>(yaml.numbers(&[name])?.and_then(|n| n.first().copied()));
    let size_px = match (size("image_width")?, size("image_height")?) {
        (Some(w), Some(h)) if w >= 1.0 && h >= 1.0 => Some((w as usize, h as usize)),
        _ => None,
    };
    let intrinsics = with_distortion([fx, fy, cx, cy], &distortion)?;
    Ok(Imported { intrinsics, size_px, dialect: if ros { "ROS" } else { "OpenCV" } })
}

fn kalibr(yaml: &Yaml, intrinsics: &[f64]) -> Result<Imported, String> {
    let model =
        (yaml.word("cam0.camera_model").unwrap_or("pinhole"), yaml.word("cam0.distortion_model").unwrap_or("radtan"));
    if model.0 != "pinhole" || !["radtan", "none"].contains(&model.1) {
        return Err(format!("its camera is {} with {}: only pinhole with radtan is read", model.0, model.1));
    }
    let &[fx, fy, cx, cy] = intrinsics else { return Err("cam0.intrinsics must be fx, fy, cx, cy".into()) };
    let distortion = yaml.numbers(&["cam0.distortion_coeffs"])?.unwrap_or_default();
    let size_px = yaml
        .numbers(&["cam0.resolution"])?
        .filter(|size| size.len() == 2)
        .map(|size| (size[0] as usize, size[1] as usize));
    Ok(Imported { intrinsics: with_distortion([fx, fy, cx, cy], &distortion)?, size_px, dialect: "Kalibr" })
}

fn with_distortion([fx, fy, cx, cy]: [f64; 4], distortion: &[f64]) -> Result<Intrinsics, String> {
    if distortion.iter().skip(5).any(|term| *term != 0.0) {
        return Err(
            "its distortion has terms beyond k1 k2 p1 p2 k3 (rational or thin prism): calibrate with five terms".into(),
        );
    }
    let term = |i: usize| distortion.get(i).copied().unwrap_or(0.0);
    let intrinsics = Intrinsics::from_array([fx, fy, cx, cy, term(0), term(1), term(2), term(3), term(4)]);
    intrinsics.problem().map_or(Ok(intrinsics), Err)
}

/// The camera, and the laser's plane where there is one, as OpenCV's `FileStorage` reads it.
#[must_use]
pub fn to_opencv(camera: &Intrinsics, size_px: (usize, usize), sensor: Option<&LaserCamera>) -> String {
    let [fx, fy, cx, cy, k1, k2, p1, p2, k3] = camera.to_array();
    let matrix = |name: &str, rows: usize, cols: usize, data: &[f64]| {
        let data: Vec<String> = data.iter().map(|x| format!("{x:e}")).collect();
        format!(
            "{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {} ]\n",
            data.join(", ")
        )
    };
    let mut text = format!("%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\n", size_px.0, size_px.1);
    text += &matrix("camera_matrix", 3, 3, &[fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]);
    text += &matrix("distortion_coefficients", 5, 1, &[k1, k2, p1, p2, k3]);
    if let Some(sensor) = sensor {
        let n = sensor.plane().normal();
        text += "# normal * X = distance, camera frame, mm\n";
        text += &matrix("laser_plane", 4, 1, &[n.x, n.y, n.z, sensor.plane().distance_mm()]);
    }
    text
}

/// The camera as ROS' `camera_info_manager` reads it.
#[must_use]
pub fn to_ros(camera: &Intrinsics, size_px: (usize, usize), name: &str) -> String {
    let [fx, fy, cx, cy, k1, k2, p1, p2, k3] = camera.to_array();
    let name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    format!(
        "image_width: {}\nimage_height: {}\ncamera_name: {name}\n\
         camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{fx:?}, 0.0, {cx:?}, 0.0, {fy:?}, {cy:?}, 0.0, 0.0, 1.0]\n\
         distortion_model: plumb_bob\n\
         distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [{k1:?}, {k2:?}, {p1:?}, {p2:?}, {k3:?}]\n\
         rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\n\
         projection_matrix:\n  rows: 3\n  cols: 4\n  data: [{fx:?}, 0.0, {cx:?}, 0.0, 0.0, {fy:?}, {cy:?}, 0.0, 0.0, 0.0, 1.0, 0.0]\n",
        size_px.0, size_px.1
    )
}

#[cfg(test)]
mod tests {
    use super::super::intrinsics::tests::LENS;
    use super::*;

    #[test]
    fn what_is_exported_is_imported_again() {
        for (text, dialect) in
            [(to_opencv(&LENS, (1000, 750), None), "OpenCV"), (to_ros(&LENS, (1000, 750), "left cam"), "ROS")]
        {
            let imported = import_camera(&text).unwrap();
            assert_eq!(imported, Imported { intrinsics: LENS, size_px: Some((1000, 750)), dialect });
        }
    }

    #[test]
    fn a_camchain_of_kalibr_is_read_and_a_fisheye_is_refused() {
        let text = "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [-0.1, 0.2, 0.001, -0.002]\n  distortion_model: radtan\n  intrinsics: [460.0, 461.0, 370.0, 240.0]\n  resolution: [752, 480]\n";
        let imported = import_camera(text).unwrap();
        assert_eq!(imported.size_px, Some((752, 480)));
        assert_eq!(imported.intrinsics.to_array(), [460.0, 461.0, 370.0, 240.0, -0.1, 0.2, 0.001, -0.002, 0.0]);
        assert!(import_camera(&text.replace("radtan", "equidistant")).unwrap_err().contains("equidistant"));
        assert!(import_camera("a: 1\n").unwrap_err().contains("no camera matrix"));
    }
}
