//! Thermal recordings outside the repository, reached through `SEAMTRACK_REAL_DATA`.

use std::path::PathBuf;

use seamtrack::report::pool::read_pool_csv;

use super::command::meltpool;

#[test]
fn the_width_of_real_thermal_pools_is_measured_or_refused_frame_by_frame() {
    let Some(data) = std::env::var_os("SEAMTRACK_REAL_DATA") else {
        eprintln!("SKIPPED: set SEAMTRACK_REAL_DATA to measure the real thermal recordings");
        return;
    };
    let folder = PathBuf::from(data).join("weldpool-thermal-npy");
    if !folder.is_dir() {
        eprintln!("SKIPPED: {} does not exist", folder.display());
        return;
    }
    for (name, frames) in [("TF031", 1966), ("TF035", 1460), ("TF050", 1331)] {
        let output = tempfile::tempdir().unwrap();
        let stack = folder.join(format!("crop_heatmaps_{name}.npy"));
        // The picture cuts most pools, and a width may be filtered below 0 where one comes and goes: a BAD verdict, code 3.
        let run = meltpool(&stack, "width", output.path()).args(["--max-unavailable", "100"]).output().unwrap();
        assert!(matches!(run.status.code(), Some(0 | 3)) && run.stderr.is_empty(), "{name}: {run:?}");
        let rows = read_pool_csv(&output.path().join("path.csv")).unwrap();
        assert_eq!(rows.len(), frames);
        // The frames are 30 px wide: a width in them lies below that.
        let measured: Vec<f64> = rows.iter().filter_map(|row| row.measured_px).collect();
        assert!(measured.iter().all(|width| (2.0..30.0).contains(width)), "{name}");
        eprintln!("{name}: measured in {} of {frames} frames", measured.len());
        assert!(8 * measured.len() > frames, "{name}: {}", measured.len());
    }
}
