//! dev only
#[path = "../tests/real/mod.rs"]
#[allow(dead_code)]
mod real;
use seamtrack::tracker::{HairlineEstimate, HairlineTracker, SeamPresence};
use std::io::{Read, Write};
fn main() {
    let folder = real::folder().unwrap();
    let cache = std::path::PathBuf::from("/tmp/hl/cache");
    std::fs::create_dir_all(&cache).unwrap();
    let verbose = std::env::var("VV").ok();
    let only = std::env::var("ONLY").unwrap_or_default();
    let levels = ["clean", "mild", "medium", "severe"];
    let mut jobs = Vec::new();
    for level in levels {
        for seed in 1..=3u64 {
            if level == "clean" && seed > 1 {
                continue;
            }
            for name in ["abb-butt-scan1", "abb-butt-scan4"] {
                jobs.push((level, seed, name));
            }
        }
    }
    let shots1 = real::scan(&folder, "abb-butt-scan1");
    let shots4 = real::scan(&folder, "abb-butt-scan4");
    let mut tot = std::collections::BTreeMap::<&str, (f64, f64, u32, u32, f64, f64, f64, u32, f64)>::new();
    for (level, seed, name) in jobs {
        let key = format!("{name}_{level}_{seed}");
        if !key.contains(&only) {
            continue;
        }
        let shots = if name.ends_with('1') { &shots1 } else { &shots4 };
        let mut line = format!("{level:7} {seed} {}", &name[9..]);
        for control in [false, true] {
            let file = cache.join(format!("{key}_{control}.raw"));
            let use_: Vec<&real::Shot> =
                shots.iter().filter(|s| !s.repeated && (!control || s.reference_px.is_some())).collect();
            if !file.exists() {
                let scene = (level != "clean").then(|| {
                    let mut scenario = seamtrack::synth::builtin::scenario(&format!("hairline-{level}")).unwrap();
                    scenario.image.stripe = seamtrack::units::StripeAxis::Horizontal;
                    (scenario.image.width_px, scenario.image.height_px) = (448, 384);
                    scenario.path.clear();
                    scenario.recorder.repeated = 0.0;
                    scenario.frames = shots.len();
                    seamtrack::synth::Scene::new(&scenario, seed).unwrap()
                });
                let mut out = std::io::BufWriter::new(std::fs::File::create(&file).unwrap());
                for (tick, s) in use_.iter().enumerate() {
                    let f = if control {
                        real::paint::without_seam(
                            &s.frame,
                            s.reference_px.unwrap(),
                            [real::paint::Paint::Mirrored, real::paint::Paint::Moved, real::paint::Paint::Smooth]
                                [seed as usize - 1],
                        )
                    } else {
                        s.frame.clone()
                    };
                    let f = scene.as_ref().map_or(f.clone(), |sc| sc.composite(tick, &f));
                    out.write_all(f.pixels()).unwrap();
                }
            }
            let mut input = std::io::BufReader::new(std::fs::File::open(&file).unwrap());
            let mut tracker = HairlineTracker::default();
            let mut rows = Vec::new();
            let mut ests: Vec<(u32, Option<HairlineEstimate>, Option<f64>)> = Vec::new();
            let mut buf = vec![0; 448 * 384];
            for s in &use_ {
                input.read_exact(&mut buf).unwrap();
                let f = seamtrack::frame::GrayFrame::new(448, 384, buf.clone()).unwrap();
                let e = tracker.step(&f);
                if verbose.is_some()
                    && let Some(e) = e
                    && !control
                {
                    let ev = tracker.evidence();
                    let r = s.reference_px.unwrap_or(e.seam.u_px).round() as usize;
                    let at =
                        |u: usize| ev.log_ratio[u.saturating_sub(2)..u + 3].iter().copied().fold(f32::MIN, f32::max);
                    println!(
                        "  {:3} u {:7.2} sd {:.2} conf {:.3} P {:.4} {:?} err {:?} l(ref) {:.1} l(u) {:.1}",
                        s.number,
                        e.seam.u_px,
                        e.grid.sd_px,
                        e.grid.confidence,
                        e.grid.presence,
                        e.presence,
                        s.reference_px.map(|r| ((e.seam.u_px - r) * 100.).round() / 100.),
                        at(r),
                        at((e.seam.u_px as usize).min(444))
                    );
                }
                rows.push(tracker.evidence().clone());
                ests.push((s.number, e, s.reference_px));
            }
            let valid: Vec<f64> = ests
                .iter()
                .filter_map(|(_, e, r)| match (e, r) {
                    (Some(e), Some(r)) if e.presence == SeamPresence::Present => Some((e.seam.u_px - r).abs()),
                    _ => None,
                })
                .collect();
            let visible = ests.iter().filter(|e| e.2.is_some()).count();
            let most = ests.iter().filter_map(|e| e.1).map(|e| e.grid.presence).fold(0.0, f64::max);
            let entry = tot.entry(level).or_default();
            if control {
                let falsely = ests.iter().filter(|e| e.1.is_some_and(|e| e.presence == SeamPresence::Present)).count();
                line += &format!(" | control most {most:.4} present {falsely}");
                entry.7 += falsely as u32;
                entry.8 = entry.8.max(most);
            } else {
                let first = ests
                    .iter()
                    .position(|e| e.1.is_some_and(|e| e.presence == SeamPresence::Present))
                    .map_or(999, |i| ests[i].0);
                let mean = valid.iter().sum::<f64>() / valid.len().max(1) as f64;
                let worst = valid.iter().copied().fold(0.0, f64::max);
                let wrong = valid.iter().filter(|e| **e > 10.0).count();
                let sm = seamtrack::tracker::smooth(&rows);
                let se: Vec<f64> = sm.iter().zip(&ests).filter_map(|(s, e)| e.2.map(|r| (s.u_px - r).abs())).collect();
                let smean = se.iter().sum::<f64>() / se.len() as f64;
                let sworst = se.iter().copied().fold(0.0, f64::max);
                let post = ests.iter().filter(|e| e.0 >= first && e.2.is_some()).count();
                line += &format!(
                    " mean {mean:.2} worst {worst:5.2} wrong {wrong} valid {}/{visible} (after conf {}/{post}) first {first} | smooth {smean:.2} {sworst:.2}",
                    valid.len(),
                    valid.len()
                );
                entry.0 += mean;
                entry.1 = entry.1.max(worst);
                entry.2 += wrong as u32;
                entry.3 += 1;
                entry.4 += valid.len() as f64 / post.max(1) as f64;
                entry.5 += smean;
                entry.6 = entry.6.max(sworst);
            }
        }
        if std::env::var_os("Q").is_none() {
            println!("{line}");
        }
    }
    for level in levels {
        let Some(t) = tot.get(level) else { continue };
        let n = t.3 as f64;
        println!(
            "TOTAL {level:7} mean {:.2} worst {:.2} wrong {} avail {:.3} | smooth {:.2} {:.2} | control present {} most {:.4}",
            t.0 / n,
            t.1,
            t.2,
            t.4 / n,
            t.5 / n,
            t.6,
            t.7,
            t.8
        );
    }
}
