//! The trackers a user would otherwise take, on the same frames and with the same figures: `make peers`.
//!
//! `cargo run --features peers --example peers -- [--seeds N] [SCENE]...`. Each is started at the true centre of frame 0
//! with a box of 80 × 60 px and runs on one thread. Their answers are OpenCV's boxes: the centre moves by what the box
//! moves, so that rounding the first box costs nothing.
#![expect(clippy::disallowed_types, reason = "OpenCV's trackers take a Mat; it stays in this file")]

use std::time::Instant;

use anyhow::{Context, Result, anyhow};
use opencv::core::{Mat, MatTraitConst, Ptr, Rect, Rect2d, set_num_threads};
use opencv::prelude::{LegacyTracker, TrackerTrait};
use opencv::tracking::{TrackerCSRT, TrackerKCF, legacy_TrackerMOSSE};
use opencv::video::TrackerMIL;
use seamtrack::eval::Estimate;
use seamtrack::frame::GrayFrame;
use seamtrack::regress::{Lane, run, table};
use seamtrack::synth::{Scene, builtin};
use seamtrack::units::StripeAxis;

/// Width and height of the box round the seam \[px\]: the ROI of Du 2022.
const BOX_PX: (f64, f64) = (80.0, 60.0);

fn main() -> Result<()> {
    let (mut seeds, mut names) = (3, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--seeds" {
            seeds = arguments.next().context("--seeds needs a number")?.parse().context("--seeds needs a number")?;
        } else {
            names.push(argument);
        }
    }
    if names.is_empty() {
        // Scenes A to K: the special ones have frames without a seam or no seam in frame 0.
        names = builtin::scene_names().into_iter().take(12).collect();
    }
    let scenes =
        names.into_iter().map(|name| Ok((name.clone(), builtin::scenario(&name)?))).collect::<Result<Vec<_>>>()?;
    let seeds: Vec<u64> = (1..=seeds).collect();
    set_num_threads(1)?;
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let scores = one_thread.install(|| run(&scenes, &seeds, peers)).map_err(|error| anyhow!(error))?;
    print!("{}", table(&scores));
    Ok(())
}

/// A box tracker: how it begins and how it goes on.
enum Peer {
    Box(Ptr<dyn TrackerTrait>),
    Legacy(Ptr<legacy_TrackerMOSSE>),
}

impl Peer {
    fn init(&mut self, image: &Mat, first: Rect) -> opencv::Result<()> {
        match self {
            Self::Box(tracker) => tracker.init(image, first),
            Self::Legacy(tracker) => {
                let first = Rect2d::new(first.x.into(), first.y.into(), first.width.into(), first.height.into());
                tracker.init(image, first).map(|_| ())
            }
        }
    }

    /// Centre of the box, if the tracker says it has one.
    fn update(&mut self, image: &Mat) -> opencv::Result<Option<(f64, f64)>> {
        let (mut whole, mut exact) = (Rect::default(), Rect2d::default());
        let (found, centre) = match self {
            Self::Box(tracker) => {
                let found = tracker.update(image, &mut whole)?;
                let centre = (
                    f64::from(whole.x) + 0.5 * f64::from(whole.width),
                    f64::from(whole.y) + 0.5 * f64::from(whole.height),
                );
                (found, centre)
            }
            Self::Legacy(tracker) => {
                let found = tracker.update(image, &mut exact)?;
                (found, (exact.x + 0.5 * exact.width, exact.y + 0.5 * exact.height))
            }
        };
        Ok(found.then_some(centre))
    }
}

/// All peers on a scene.
fn peers(scene: &Scene) -> opencv::Result<Vec<Lane>> {
    let start = scene.truth(0).seam.ok_or_else(|| opencv::Error::new(0, "the scene has no seam in frame 0"))?;
    let corner = (start.u_px - 0.5 * BOX_PX.0, start.v_px - 0.5 * BOX_PX.1);
    let first = Rect::new(corner.0.round() as i32, corner.1.round() as i32, BOX_PX.0 as i32, BOX_PX.1 as i32);
    let mut trackers = [
        ("OpenCV KCF", Peer::Box(Ptr::from(TrackerKCF::create_def()?))),
        ("CSRT", Peer::Box(TrackerCSRT::create_def()?.into())),
        ("MOSSE", Peer::Legacy(legacy_TrackerMOSSE::create()?)),
        ("MIL", Peer::Box(TrackerMIL::create_def()?.into())),
    ];
    let mut lanes: Vec<Lane> = trackers
        .iter()
        .map(|(name, _)| Lane { name: (*name).to_owned(), estimates: vec![], frame_ms: vec![] })
        .collect();
    for i in 0..scene.frame_count() {
        let image = image_of(&scene.render(i))?;
        for ((_, tracker), lane) in trackers.iter_mut().zip(&mut lanes) {
            let began = Instant::now();
            let estimate = if i == 0 {
                tracker.init(&image, first)?;
                Some(0.0)
            } else {
                let offset = |centre: (f64, f64)| match scene.axis() {
                    StripeAxis::Horizontal => centre.0 - (f64::from(first.x) + 0.5 * BOX_PX.0),
                    StripeAxis::Vertical => centre.1 - (f64::from(first.y) + 0.5 * BOX_PX.1),
                };
                tracker.update(&image)?.map(offset)
            };
            lane.frame_ms.push(began.elapsed().as_secs_f64() * 1e3);
            let start_px = scene.axis().along_px(start);
            lane.estimates.push(estimate.map(|offset| Estimate { position_px: start_px + offset, std_px: None }));
        }
    }
    Ok(lanes)
}

/// The frame as the three-channel image that these trackers want.
fn image_of(frame: &GrayFrame) -> opencv::Result<Mat> {
    let grey = Mat::from_slice(frame.pixels())?;
    let grey = grey.reshape(1, frame.height_px() as i32)?;
    let mut colour = Mat::default();
    opencv::imgproc::cvt_color_def(&grey, &mut colour, opencv::imgproc::COLOR_GRAY2BGR)?;
    Ok(colour)
}
