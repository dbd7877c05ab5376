//! The hairline tracker on real stripes.

mod real;

use seamtrack::tracker::{HairlineEstimate, HairlineTracker, SeamPresence};

#[test]
fn look() {
    let Some(folder) = real::folder() else { return };
    for name in ["abb-butt-scan1", "abb-butt-scan4"] {
        let shots = real::scan(&folder, name);
        let mut tracker = HairlineTracker::default();
        let mut last: Option<HairlineEstimate> = None;
        let started = std::time::Instant::now();
        let mut steps = 0;
        let mut rows = Vec::new();
        let (mut sum, mut n, mut worst) = (0.0, 0, 0.0_f64);
        for shot in &shots {
            if !shot.repeated {
                last = tracker.step(&shot.frame);
                steps += 1;
                rows.push(tracker.evidence().clone());
            }
            let Some(e) = last else { continue };
            let error = shot.reference_px.map(|r| e.seam.u_px - r);
            if e.presence == SeamPresence::Present
                && let Some(error) = error
            {
                sum += error.abs();
                n += 1;
                worst = worst.max(error.abs());
            }
            if std::env::var_os("V").is_some() {
                println!(
                    "ROW {} {} {:?}",
                    shot.number,
                    u8::from(!shot.repeated),
                    tracker.evidence().log_ratio.iter().map(|v| (v * 100.0).round() / 100.0).collect::<Vec<_>>()
                );
                println!(
                    "{:3} u {:7.2} sd {:.2} v {:5.2} conf {:.3} P {:.4} {:?} err {:?}",
                    shot.number,
                    e.seam.u_px,
                    e.grid.sd_px,
                    e.grid.velocity_px,
                    e.grid.confidence,
                    e.grid.presence,
                    e.presence,
                    error.map(|e| (e * 100.).round() / 100.)
                );
            }
        }
        let started2 = std::time::Instant::now();
        let smoothed = seamtrack::tracker::smooth(&rows);
        let ms = started2.elapsed().as_secs_f64() * 1e3 / rows.len() as f64;
        let mut it = smoothed.iter();
        let mut current = smoothed[0];
        let (mut ssum, mut sn, mut sworst) = (0.0, 0, 0.0_f64);
        for shot in &shots {
            if !shot.repeated {
                current = *it.next().unwrap();
            }
            if let Some(r) = shot.reference_px {
                if std::env::var_os("V").is_some() {
                    println!("S {} {} {:.2} {:.4}", shot.number, current.u_px, current.u_px - r, current.presence);
                }
                ssum += (current.u_px - r).abs();
                sn += 1;
                sworst = sworst.max((current.u_px - r).abs());
            }
        }
        println!("{name}: smoothed mean {:.2} worst {:.2} over {sn}, {ms:.2} ms a frame", ssum / sn as f64, sworst);
        println!(
            "{name}: mean {:.2} worst {worst:.2} over {n}; {:.2} ms a step",
            sum / n as f64,
            started.elapsed().as_secs_f64() * 1e3 / steps as f64
        );
    }
}

#[test]
fn controls() {
    let Some(folder) = real::folder() else { return };
    for name in ["abb-butt-scan1", "abb-butt-scan4"] {
        let shots = real::scan(&folder, name);
        for paint in [real::paint::Paint::Moved, real::paint::Paint::Mirrored, real::paint::Paint::Smooth] {
            let mut tracker = HairlineTracker::default();
            let (mut most, mut present, mut n) = (0.0_f64, 0, 0);
            for shot in shots.iter().filter(|s| !s.repeated || s.number == 5) {
                let Some(seam) = shot.reference_px else { continue };
                let frame = real::paint::without_seam(&shot.frame, seam, paint);
                if shot.number % 40 == 21 && paint == real::paint::Paint::Moved && std::env::var_os("V").is_some() {
                    image::GrayImage::from_raw(
                        frame.width_px() as u32,
                        frame.height_px() as u32,
                        frame.pixels().to_vec(),
                    )
                    .unwrap()
                    .save(format!("/tmp/hl/c{}_{}.png", name, shot.number))
                    .unwrap();
                }
                let e = tracker.step(&frame).unwrap();
                most = most.max(e.grid.presence);
                present += u32::from(e.presence == SeamPresence::Present);
                n += 1;
            }
            println!("control {name} {paint:?}: most {most:.4}, present on {present} of {n}");
        }
    }
}

#[test]
fn arcs() {
    let Some(folder) = real::folder() else { return };
    let seed: u64 = std::env::var("SEED").map_or(1, |v| v.parse().unwrap());
    for name in ["abb-butt-scan1", "abb-butt-scan4"] {
        let shots = real::scan(&folder, name);
        for level in ["mild", "medium", "severe"] {
            let mut scenario = seamtrack::synth::builtin::scenario(&format!("hairline-{level}")).unwrap();
            scenario.image.stripe = seamtrack::units::StripeAxis::Horizontal;
            (scenario.image.width_px, scenario.image.height_px) = (448, 384);
            scenario.path.clear();
            scenario.recorder.repeated = 0.0;
            scenario.frames = shots.len();
            let scene = seamtrack::synth::Scene::new(&scenario, seed).unwrap();
            for paint in [None, Some(real::paint::Paint::Mirrored)] {
                let mut tracker = HairlineTracker::default();
                let mut last: Option<HairlineEstimate> = None;
                let (mut sum, mut n, mut worst, mut wrong, mut most) = (0.0, 0, 0.0_f64, 0, 0.0_f64);
                let (mut visible, mut tick, mut hot) = (0, 0, 0);
                let mut rows = Vec::new();
                for shot in &shots {
                    if paint.is_some() && shot.reference_px.is_none() {
                        continue;
                    }
                    if !shot.repeated {
                        let frame = match paint {
                            None => shot.frame.clone(),
                            Some(paint) => real::paint::without_seam(&shot.frame, shot.reference_px.unwrap(), paint),
                        };
                        let frame = scene.composite(tick, &frame);
                        if std::env::var_os("V").is_some() && shot.number % 30 == 11 {
                            image::GrayImage::from_raw(448, 384, frame.pixels().to_vec())
                                .unwrap()
                                .save(format!("/tmp/hl/arc_{level}_{name}_{}.png", shot.number))
                                .unwrap();
                        }
                        tick += 1;
                        last = tracker.step(&frame);
                        rows.push(tracker.evidence().clone());
                    }
                    let Some(e) = last else { continue };
                    most = most.max(e.grid.presence);
                    visible += u32::from(shot.reference_px.is_some());
                    if e.presence == SeamPresence::Present
                        && let Some(r) = shot.reference_px
                    {
                        let error = e.seam.u_px - r;
                        sum += error.abs();
                        n += 1;
                        worst = worst.max(error.abs());
                        wrong += u32::from(error.abs() > 10.0);
                    }
                    if std::env::var_os("V").is_some() && paint.is_none() {
                        println!(
                            "A {level} {name} {:3} u {:7.2} sd {:.2} conf {:.3} P {:.4} {:?} err {:?}",
                            shot.number,
                            e.seam.u_px,
                            e.grid.sd_px,
                            e.grid.confidence,
                            e.grid.presence,
                            e.presence,
                            shot.reference_px.map(|r| ((e.seam.u_px - r) * 100.).round() / 100.)
                        );
                    }
                }
                if paint.is_none() {
                    let smoothed = seamtrack::tracker::smooth(&rows);
                    let mut it = smoothed.iter();
                    let mut current = smoothed[0];
                    let (mut ssum, mut sn, mut sworst) = (0.0, 0, 0.0_f64);
                    for shot in &shots {
                        if !shot.repeated {
                            current = *it.next().unwrap();
                        }
                        if let Some(r) = shot.reference_px {
                            ssum += (current.u_px - r).abs();
                            sn += 1;
                            sworst = sworst.max((current.u_px - r).abs());
                        }
                    }
                    println!(
                        "ARC {name} {level}: mean {:.2} worst {worst:.2} wrong {wrong} on {n} of {visible}; smoothed mean {:.2} worst {sworst:.2}",
                        sum / n as f64,
                        ssum / sn as f64
                    );
                } else {
                    println!("ARC {name} {level} control: most {most:.4}, present on {n} of {visible}");
                }
            }
        }
    }
}
