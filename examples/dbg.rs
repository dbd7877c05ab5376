//! dbg
#![allow(missing_docs, clippy::unwrap_used)]
use seamtrack::imgproc::geometry::*;
use seamtrack::imgproc::*;
use seamtrack::units::PixelPoint;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let img = image::open(&a[1]).unwrap().to_luma8();
    let f = seamtrack::frame::GrayFrame::new(img.width() as usize, img.height() as usize, img.into_raw()).unwrap();
    let f = median(&f, MedianKernel::Three).unwrap();
    let path = stripe_path(&f).unwrap();
    let line = extract_along(&f, &CentrelineSettings::default(), &path);
    for u in (0..f.width_px()).step_by(20) {
        print!("{u}:{}/{:.0} ", path[u], line.at(u).unwrap_or(-1.0));
    }
    println!();
    if a.len() > 3 {
        let p = PixelPoint::new(a[2].parse().unwrap(), a[3].parse().unwrap());
        for kind in [JointKind::VGroove, JointKind::Fillet] {
            let m = learn(&f, p, kind);
            println!("{m:?}");
            if let Some(m) = m {
                println!("{:?}", m.fit(&f, p.u_px, 0.0, 12.0).map(|f| (f, f.refusal(), f.shoulders(), f.is_clear())));
            }
        }
    }
}
