//! The hairline tracker on real stripes.

mod real;

use seamtrack::tracker::hairline::{HairlineEstimate, HairlineTracker, SeamPresence};

#[test]
fn look() {
    let Some(folder) = real::folder() else { return };
    for name in ["abb-butt-scan1", "abb-butt-scan4"] {
        let shots = real::scan(&folder, name);
        let mut tracker = HairlineTracker::default();
        let mut last: Option<HairlineEstimate> = None;
        let started = std::time::Instant::now();
        let mut steps = 0;
        let (mut sum, mut n, mut worst) = (0.0, 0, 0.0_f64);
        for shot in &shots {
            if !shot.repeated {
                last = tracker.step(&shot.frame);
                steps += 1;
            }
            let Some(e) = last else { continue };
            let error = shot.reference_px.map(|r| e.seam.u_px - r);
            if e.presence == SeamPresence::Present && let Some(error) = error {
                sum += error.abs();
                n += 1;
                worst = worst.max(error.abs());
            }
            if std::env::var_os("V").is_some() {
                println!("{:3} u {:7.2} sd {:.2} v {:5.2} conf {:.3} P {:.4} {:?} err {:?}", shot.number, e.seam.u_px, e.grid.sd_px, e.grid.velocity_px, e.grid.confidence, e.grid.presence, e.presence, error.map(|e| (e*100.).round()/100.));
            }
        }
        println!("{name}: mean {:.2} worst {worst:.2} over {n}; {:.2} ms a step", sum / n as f64, started.elapsed().as_secs_f64() * 1e3 / steps as f64);
    }
}
