//! Scores a method on rendered scenes: `lab SCENES SEEDS PRESET` (development).
#![allow(missing_docs, clippy::unwrap_used)]
use rayon::prelude::*;
use seamtrack::config::{Config, Joint, Preset};
use seamtrack::synth::{self, Scene};
use seamtrack::tracker::{Status, Tracker};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let seeds: Vec<u64> = {
        let p: Vec<u64> = args[2].split('-').map(|x| x.parse().unwrap()).collect();
        (p[0]..=p[1]).collect()
    };
    let preset = if args.get(3).is_some_and(|p| p == "paper") { Preset::Paper } else { Preset::Robust };
    let verbose = args.len() > 4;
    for name in args[1].split(',') {
        let scenario = synth::builtin::scenario(name).unwrap();
        let joint = match format!("{:?}", scenario.joint).split([' ', '{', '(']).next().unwrap() {
            "Lap" => Joint::Lap,
            "VGroove" | "Vgroove" => Joint::Vgroove,
            "Fillet" => Joint::Fillet,
            _ => Joint::Butt,
        };
        let joint = if std::env::var_os("AUTO").is_some() { Joint::Auto } else { joint };
        let results: Vec<_> = seeds
            .par_iter()
            .map(|&seed| {
                let scene = Scene::new(&scenario, seed).unwrap();
                let config = Config { preset, joint, ..Config::default() };
                let mut tracker = Tracker::new(&config.method().unwrap(), Some(scene.axis()), None).unwrap();
                let (mut f, mut k, mut un, mut wrong, mut cov, mut ms) = (vec![], vec![], 0, 0, 0, vec![]);
                let mut started = false;
                let mut truths = vec![];
                let mut scov = 0;
                let mut invented = 0;
                for i in 0..scene.frame_count() {
                    let frame = scene.render(i);
                    let t0 = std::time::Instant::now();
                    let e = tracker.step(&frame, scene.timestamp_s(i)).unwrap();
                    ms.push(t0.elapsed().as_secs_f64() * 1e3);
                    let truth = scene.truth(i).seam.map(|p| scene.axis().along_px(p));
                    truths.push(truth);
                    started |= e.status == Status::Tracked;
                    if truth.is_none() && e.seam.is_some() {
                        invented += 1;
                    }
                    if let Some(t) = truth {
                        match e.seam {
                            Some(s) => {
                                let d = scene.axis().along_px(s.centre) - t;
                                f.push(d * 0.073);
                                wrong += u32::from((d * 0.073).abs() > 1.0);
                                cov += u32::from(d.abs() <= 2.0 * s.std_px);
                                if verbose {
                                    println!(
                                        "  {seed} {i} {:?} {} err {:.2} sd {:.2} nis {:?} occl {} psr {:?}",
                                        e.status,
                                        e.observation.name(),
                                        d,
                                        s.std_px,
                                        e.nis.map(|n| (n * 10.).round() / 10.),
                                        scene.truth(i).occluded,
                                        e.kcf.map(|k| (k.psr_ratio * 100.).round() / 100.)
                                    );
                                }
                            }
                            None => {
                                un += 1;
                                if verbose {
                                    println!("  {seed} {i} {:?} {}", e.status, e.observation.name());
                                }
                            }
                        }
                        if let Some(kc) = e.kcf {
                            k.push((scene.axis().along_px(kc.peak) - t) * 0.073);
                        }
                    }
                }
                let mut s = vec![];
                for (sm, t) in tracker.smoothed().unwrap().iter().zip(&truths) {
                    if let (Some((u, v)), Some(t)) = (sm, t) {
                        s.push((u - t) * 0.073);
                        scov += u32::from((u - t).abs() <= 2.0 * v.sqrt());
                    }
                }
                let kind =
                    tracker.joint().map(|j| format!("{} at {}: {}", j.kind, j.frame, j.reason)).unwrap_or_default();
                if std::env::var_os("AUTO").is_some() {
                    println!("   {seed}: {kind} invented {invented}");
                }
                ms.sort_by(f64::total_cmp);
                let st = |x: &Vec<f64>| {
                    let n = x.len().max(1) as f64;
                    (x.iter().map(|a| a.abs()).sum::<f64>() / n, x.iter().fold(0.0f64, |m, a| m.max(a.abs())))
                };
                (
                    seed,
                    st(&f),
                    st(&s),
                    st(&k),
                    un,
                    wrong,
                    f64::from(cov) / f.len().max(1) as f64,
                    f64::from(scov) / s.len().max(1) as f64,
                    ms[ms.len() / 2],
                )
            })
            .collect();
        let n = results.len() as f64;
        let mean = |g: &dyn Fn(&(u64, (f64, f64), (f64, f64), (f64, f64), u32, u32, f64, f64, f64)) -> f64| {
            results.iter().map(g).sum::<f64>() / n
        };
        let max = |g: &dyn Fn(&(u64, (f64, f64), (f64, f64), (f64, f64), u32, u32, f64, f64, f64)) -> f64| {
            results.iter().map(g).fold(0.0, f64::max)
        };
        println!(
            "{name:20} causal {:.3}/{:.2} smooth {:.3}/{:.2} kcf {:.3}/{:.2} unavail {} wrong {} cov {:.2}/{:.2} ms {:.2}",
            mean(&|r| r.1.0),
            max(&|r| r.1.1),
            mean(&|r| r.2.0),
            max(&|r| r.2.1),
            mean(&|r| r.3.0),
            max(&|r| r.3.1),
            results.iter().map(|r| r.4).sum::<u32>(),
            results.iter().map(|r| r.5).sum::<u32>(),
            mean(&|r| r.6),
            mean(&|r| r.7),
            mean(&|r| r.8)
        );
        if results.len() < 12 {
            for r in &results {
                println!(
                    "   seed {} causal {:.3}/{:.2} smooth {:.3}/{:.2} un {} wrong {} cov {:.2}",
                    r.0, r.1.0, r.1.1, r.2.0, r.2.1, r.4, r.5, r.6
                );
            }
        }
    }
}
