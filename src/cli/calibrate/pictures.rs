//! A folder of pictures, and a recording with its robot's poses.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use nalgebra::Vector3;
use seamtrack::calib::detect::{Picture, Pictures};
use seamtrack::calib::file::sha256_hex;
use seamtrack::calib::travel::StillLight;
use seamtrack::source;

const EXTENSIONS: [&str; 6] = ["png", "jpg", "jpeg", "bmp", "tif", "tiff"];

/// The pictures of a folder in the natural order of their names.
pub struct Folder(Vec<PathBuf>);

impl Folder {
    pub fn open(folder: &Path) -> anyhow::Result<Self> {
        let entries =
            std::fs::read_dir(folder).with_context(|| format!("cannot open the folder {}", folder.display()))?;
        let is_picture = |path: &PathBuf| {
            let extension = path.extension().and_then(|e| e.to_str());
            let hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
            !hidden
                && path.is_file()
                && extension.is_some_and(|e| EXTENSIONS.iter().any(|known| e.eq_ignore_ascii_case(known)))
        };
        let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_picture).collect();
        paths.sort_by(|a, b| natord::compare(&name_of(a), &name_of(b)).then_with(|| a.cmp(b)));
        if paths.is_empty() {
            bail!("{} holds no png, jpg, bmp or tif picture: name the folder with the boards", folder.display());
        }
        Ok(Self(paths))
    }

    pub fn names(&self) -> Vec<String> {
        self.0.iter().map(|path| name_of(path)).collect()
    }
}

impl Pictures for Folder {
    fn count(&self) -> usize {
        self.0.len()
    }

    fn name(&self, index: usize) -> String {
        self.0.get(index).map(|path| name_of(path)).unwrap_or_default()
    }

    fn read(&self, index: usize) -> Result<Picture, String> {
        let path = &self.0[index];
        let name = name_of(path);
        let unreadable = || format!("{name} cannot be read: copy or take it again");
        let bytes = std::fs::read(path).map_err(|_| unreadable())?;
        let mut source = source::open(path, 1.0).map_err(|error| error.to_string())?;
        let frame = source.next_frame().ok_or_else(unreadable)?.picture.map_err(|error| error.to_string())?;
        Ok(Picture { name, sha256: sha256_hex(&bytes), frame })
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The light of a recording that does not move.
pub fn still_light(recording: &Path) -> anyhow::Result<StillLight> {
    let mut still = StillLight::default();
    let mut source = source::open(recording, 1.0)?;
    std::iter::from_fn(|| source.next_frame())
        .filter_map(|frame| frame.picture.ok())
        .for_each(|picture| still.add(&picture));
    Ok(still)
}

/// The positions of a robot, one a frame: the columns x, y, z by name, else the first three numbers of a line [mm].
pub fn read_poses(path: &Path) -> anyhow::Result<Vec<Vector3<f64>>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let mut places = [0, 1, 2];
    let mut poses = vec![];
    for (i, line) in text.lines().enumerate() {
        let line = line.trim().trim_start_matches('\u{feff}');
        let cells: Vec<&str> =
            line.split([',', ';', '\t', ' ']).map(str::trim).filter(|cell| !cell.is_empty()).collect();
        if cells.is_empty() || line.starts_with('#') {
            continue;
        }
        let number = |place: usize| cells.get(place)?.parse::<f64>().ok().filter(|x| x.is_finite());
        match (number(places[0]), number(places[1]), number(places[2])) {
            (Some(x), Some(y), Some(z)) => poses.push(Vector3::new(x, y, z)),
            _ if poses.is_empty() && cells.iter().all(|cell| cell.parse::<f64>().is_err()) => {
                let named = |axis: &str| {
                    let fits = |cell: &&str| {
                        [axis.to_owned(), format!("{axis}_mm"), format!("t{axis}")].contains(&cell.to_lowercase())
                    };
                    cells.iter().position(fits)
                };
                if let (Some(x), Some(y), Some(z)) = (named("x"), named("y"), named("z")) {
                    places = [x, y, z];
                }
            }
            _ => bail!("{}: line {} has no three numbers x, y, z in mm", path.display(), i + 1),
        }
    }
    if poses.len() < 2 {
        bail!("{} has {} poses: one a frame is needed, x, y, z in mm", path.display(), poses.len());
    }
    Ok(poses)
}
