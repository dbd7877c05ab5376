//! The commands of the README run as they stand there, one after the other, in an empty folder.

use std::path::Path;
use std::process::Command;

#[test]
fn every_command_of_the_readme_runs_when_it_is_pasted() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).unwrap();
    let blocks = text.split("```").skip(1).step_by(2).filter_map(|block| block.strip_prefix("sh\n"));
    let folder = tempfile::tempdir().unwrap();
    let program = Path::new(env!("CARGO_BIN_EXE_seamtrack")).parent().unwrap();
    let path = std::env::join_paths(
        std::iter::once(program.to_owned()).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
    );
    let path = path.unwrap();
    let mut commands = 0;
    for command in blocks.flat_map(str::lines).filter(|line| !line.trim().is_empty()) {
        let run =
            Command::new("sh").args(["-c", command]).current_dir(folder.path()).env("PATH", &path).output().unwrap();
        assert!(run.status.success(), "{command}: {}", String::from_utf8_lossy(&run.stderr));
        commands += 1;
    }
    assert!(commands >= 15, "{commands} commands");
}

#[test]
fn what_the_readme_shows_and_names_is_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("README.md")).unwrap();
    for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()).filter(|link| !link.contains("://"))
    {
        let file = link.split('#').next().unwrap();
        assert!(root.join(file).exists(), "{link}");
    }
}
