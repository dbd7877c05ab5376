//! What is the user's is never touched: recordings, files beside them, whatever no run has left.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use predicates::str::contains;

use crate::program::{line_with, recording, seamtrack, track, tracked};

/// Every file below a folder with its bytes, by its path; links by where they lead.
pub fn tree(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_symlink() {
            files.insert(path.clone(), fs::read_link(&path).unwrap().into_os_string().into_encoded_bytes());
        } else if path.is_dir() {
            files.extend(tree(&path));
        } else {
            files.insert(path.clone(), fs::read(&path).unwrap());
        }
    }
    files
}

/// Recordings `recs/a` and `recs/b` of three frames each.
fn two_recordings(folder: &Path) -> PathBuf {
    let recs = folder.join("recs");
    fs::create_dir(&recs).unwrap();
    for name in ["a", "b"] {
        fs::rename(recording(folder, 3), recs.join(name)).unwrap();
    }
    recs
}

#[test]
fn no_job_of_several_draws_or_writes_into_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let recs = two_recordings(folder.path());
    let before = tree(&recs);
    let out = folder.path().join("out");
    let run = |command: &str, more: &[&str], place: &str| {
        let mut run = seamtrack();
        run.arg(command).args(more).args([recs.join("a"), recs.join("b")]).arg(place).arg(&recs).arg("--force");
        if place != "-o" {
            run.arg("-o").arg(&out);
        }
        run.assert().code(1).stderr(line_with(&["recs/a", "which is read", place]));
    };
    for place in ["--overlay", "-o"] {
        run("track", &["--joint", "butt"], place);
        run("meltpool", &["--measure", "width"], place);
    }
    assert!(tree(&recs) == before && !out.exists());
}

#[test]
fn nothing_is_written_into_over_or_around_a_recording_under_whatever_name() {
    let folder = tempfile::tempdir().unwrap();
    let recs = two_recordings(folder.path());
    let (input, real) = (recs.join("a"), folder.path().canonicalize().unwrap());
    let mut names = vec![input.clone(), input.join("new/deep"), recs.clone(), recs.join("b/../a"), recs.join("./a/")];
    #[cfg(unix)]
    {
        for (target, link) in [(real.join("recs/a"), "link"), (real.join("recs"), "above")] {
            std::os::unix::fs::symlink(target, folder.path().join(link)).unwrap();
        }
        names.extend([folder.path().join("link"), folder.path().join("link/new"), folder.path().join("above/a")]);
    }
    let before = tree(folder.path());
    for name in &names {
        track(&input, name).arg("--force").assert().code(1).stderr(line_with(&["which is read", "-o"]));
        let out = real.join("out");
        let drawn = track(&input, &out).arg("--force").arg("--overlay").arg(name).assert();
        drawn.code(1).stderr(line_with(&["which is read", "--overlay"]));
    }
    // A truth, a configuration and a manifest are read too.
    let mine = folder.path().join("mine");
    fs::create_dir(&mine).unwrap();
    fs::write(mine.join("truth.csv"), "frame,u_px\n0,185\n").unwrap();
    let judged = track(&input, &mine).arg("--force").arg("--truth").arg(mine.join("truth.csv")).assert();
    judged.code(1).stderr(line_with(&["truth.csv", "which is read"]));
    fs::remove_dir_all(mine).unwrap();
    assert!(tree(folder.path()) == before);
}

#[test]
fn a_folder_of_the_users_is_not_taken_for_results_with_or_without_force() {
    for file in ["thumbnails/family.jpg", "report.html", "summary.json", "trace.csv", "truth.csv", "filtered.tum"] {
        let folder = tempfile::tempdir().unwrap();
        let (input, output) = (recording(folder.path(), 3), folder.path().join("mine"));
        let path = output.join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "mine").unwrap();
        let name = file.split('/').next().unwrap();
        for force in [&["--trace"][..], &["--trace", "--force"]] {
            track(&input, &output).args(force).assert().code(1).stderr(line_with(&[name, "move it away"]));
        }
        assert!(fs::read(&path).unwrap() == b"mine" && tree(&output).len() == 1);
    }
}

#[test]
fn force_replaces_a_run_whole_but_nothing_that_was_added_or_changed_since() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (recording(folder.path(), 4), folder.path().join("out"));
    let truth = folder.path().join("mine.csv");
    fs::write(&truth, "frame,u_px\n0,185.6\n1,185.0\n2,184.7\n3,184.7\n").unwrap();
    track(&input, &output)
        .args(["--trace", "--tum", "--overlay"])
        .arg(output.join("overlay"))
        .arg("--truth")
        .arg(&truth)
        .assert()
        .success();
    for file in ["trace.csv", "filtered.tum", "truth.csv", "overlay/000003.png"] {
        assert!(output.join(file).is_file(), "{file}");
    }
    // The user's own truth in the place of our copy, and a note beside it.
    for (file, text) in [("truth.csv", "frame,u_px\n0,185.6\n"), ("notes.txt", "mine")] {
        let kept = fs::read(output.join(file)).ok();
        fs::write(output.join(file), text).unwrap();
        let before = tree(&output);
        track(&input, &output).arg("--force").assert().code(1).stderr(line_with(&[file, "move it away"]));
        assert!(tree(&output) == before);
        match kept {
            Some(bytes) => fs::write(output.join(file), bytes).unwrap(),
            None => fs::remove_file(output.join(file)).unwrap(),
        }
    }
    // A page that was made again is still ours.
    seamtrack().arg("report").arg(&output).args(["--tum", "--max-page-mb", "1"]).assert().success();
    track(&input, &output).arg("--force").assert().success();
    for file in ["trace.csv", "filtered.tum", "truth.csv", "overlay"] {
        assert!(!output.join(file).exists(), "{file} of the earlier run is gone");
    }
}

#[test]
fn an_existing_video_or_folder_of_pictures_is_drawn_over_only_with_force() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 3);
    let at = |name: &str| folder.path().join(name);
    let run = |n: usize, overlay: &str, more: &[&str]| {
        track(&input, &at(&format!("out{n}"))).arg("--overlay").arg(at(overlay)).args(more).assert()
    };
    fs::write(at("film.mp4"), "mine").unwrap();
    run(0, "film.mp4", &[]).code(1).stderr(line_with(&["film.mp4", "--force"]));
    assert_eq!(fs::read(at("film.mp4")).unwrap(), b"mine");
    run(1, "film.mp4", &["--force"]).success();
    assert!(fs::read(at("film.mp4")).unwrap().windows(4).any(|tag| tag == b"ftyp"));

    run(2, "pictures", &[]).success();
    run(3, "pictures", &[]).code(1).stderr(line_with(&["pictures", "--force"]));
    run(4, "pictures", &["--force"]).success();
    fs::write(at("pictures/000001.png"), "mine").unwrap();
    run(5, "pictures", &["--force"]).code(1).stderr(line_with(&["pictures/000001.png", "move it away"]));
    assert_eq!(fs::read(at("pictures/000001.png")).unwrap(), b"mine");
    fs::create_dir(at("photos")).unwrap();
    fs::write(at("photos/000000.png"), "mine").unwrap();
    for more in [&[][..], &["--force"]] {
        run(6, "photos", more).code(1).stderr(line_with(&["photos/000000.png"]));
    }
    run(7, "film.avi", &[]).code(1).stderr(line_with(&["film.avi", ".mp4"]));
    assert!(!at("film.avi").exists() && !at("out7").exists() && !at("out6").exists());
}

#[test]
fn results_and_drawings_of_one_run_or_of_two_never_share_a_place() {
    let folder = tempfile::tempdir().unwrap();
    let recs = two_recordings(folder.path());
    let out = folder.path().join("out");
    let run = |overlay: &Path| {
        let mut run = seamtrack();
        run.arg("track").args([recs.join("a"), recs.join("b")]).arg("-o").arg(&out).arg("--overlay").arg(overlay);
        run.assert().code(1).stderr(line_with(&["out"]));
    };
    run(&out);
    run(&out.join("a"));
    track(&recs.join("a"), &out.join("x"))
        .arg("--overlay")
        .arg(&out)
        .assert()
        .code(1)
        .stderr(line_with(&["--overlay"]));
    assert!(!out.exists());
}

#[test]
fn the_page_of_a_comparison_and_a_page_made_again_replace_no_file_of_the_users() {
    let folder = tempfile::tempdir().unwrap();
    let input = recording(folder.path(), 3);
    let at = |name: &str| folder.path().join(name);
    for name in ["a", "b"] {
        tracked(&input, &at(name));
    }
    let before = tree(&at("a"));
    let compare = |output: PathBuf| {
        let mut run = seamtrack();
        run.arg("compare").args([at("a"), at("b")]).arg("-o").arg(output).arg("--force");
        run.assert()
    };
    compare(at("a/report.html")).code(1).stderr(line_with(&["report.html", "which is read"]));
    compare(at("a/new.html")).code(1).stderr(line_with(&["which is read"]));
    compare(at("a")).code(1);
    assert!(tree(&at("a")) == before);
    fs::write(at("a/report.html"), "<title>my thesis</title>").unwrap();
    seamtrack().arg("report").arg(at("a")).assert().code(1).stderr(line_with(&["report.html", "move it away"]));
    assert_eq!(fs::read_to_string(at("a/report.html")).unwrap(), "<title>my thesis</title>");
    fs::write(at("b/kcf.tum"), "mine").unwrap();
    seamtrack().arg("report").arg(at("b")).arg("--tum").assert().code(1).stderr(contains("kcf.tum"));
    assert_eq!(fs::read(at("b/kcf.tum")).unwrap(), b"mine");
}
