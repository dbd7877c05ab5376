#![allow(missing_docs, clippy::unwrap_used, reason="scratch")]
use seamtrack::calib::{detect::*, camera::*, laser::*, pairs::*, stripes::*};
use seamtrack::frame::GrayFrame;
use std::path::PathBuf;
struct F(Vec<PathBuf>);
impl Pictures for F {
    fn count(&self)->usize{self.0.len()}
    fn name(&self,i:usize)->String{self.0[i].file_name().unwrap().to_string_lossy().into()}
    fn read(&self,i:usize)->Result<Picture,String>{
        let im=image::open(&self.0[i]).map_err(|e|e.to_string())?.into_luma8();
        Ok(Picture{name:self.name(i),sha256:self.name(i),frame:GrayFrame::new(im.width() as usize,im.height() as usize,im.into_raw()).unwrap()})
    }
}

fn files(d:&str)->F{let mut p:Vec<PathBuf>=std::fs::read_dir(d).unwrap().map(|e|e.unwrap().path()).collect(); p.sort();F(p)}
fn main(){
    let a:Vec<String>=std::env::args().collect();
    let t=std::time::Instant::now();
    let det=match detect(&files(&a[1]),None) {Ok(d)=>d,Err(e)=>{println!("{e}");return}};
    println!("{} {:?} found {} left out {:?} {:?}",det.board,det.size_px,det.sightings.iter().flatten().count(),det.left_out,t.elapsed());
    let f=fit_camera(det,30.0).unwrap();
        println!("{:?} {:?}\nrms {:.4} left {:.4} spread {:.1} poses {} advice {:?} out {:?}",f.intrinsics,t.elapsed(),f.rms_px,f.left_out_rms_px,f.tilt_spread_deg,f.poses,f.advice,f.left_out);
        println!("formal {:?}",f.formal_sigma); println!("boot {:?}",f.covariance.diagonal().map(f64::sqrt));
        for v in &f.views {println!("{} rms {:.3} out {:.3} tilt {:.1} z {:.0} used {} pose {}",v.sighting.name,v.rms_px,v.left_out_rms_px,v.tilt_deg,v.pose.translation_mm.z,v.sighting.used_corners(),v.pose_number)}
    let l=files(&a[2]); let names:Vec<String>=(0..l.count()).map(|i|l.name(i)).collect();
    let mut pairs=pair_by_name(&names).unwrap(); if std::env::var("ALONE").is_ok(){for p in &mut pairs{p.dark=None}}
    if let Ok(only)=std::env::var("ONLY"){let n:Vec<usize>=only.split(',').map(|x|x.parse().unwrap()).collect(); pairs=n.into_iter().map(|i|pairs[i-1]).collect();}
    let (views,out)=find_stripes(&l,&pairs,f.board,&f.intrinsics,f.size_px).unwrap(); println!("{:?} out {:?} {:?}",views.len(),out,t.elapsed());
    for v in &views{println!("{} px {} scatter {:.2} indep {:.0} used {} sig {:.3} at {:.0?} {:.0?}",v.board.name,v.stripe.pixels.len(),v.stripe.scatter_px,v.stripe.independent_rows,v.board.used_corners(),v.stripe.supports[0].sigma_px,v.stripe.supports[0].pixel,v.stripe.supports[1].pixel)}
    let cam=KnownCamera{size_px:f.size_px,intrinsics:f.intrinsics,covariance:Some(f.covariance),views:if std::env::var("FIXED").is_ok(){vec![]}else{f.views.iter().map(|v|v.sighting.clone()).collect()},rms_px:Some(f.rms_px)};
    let n=pairs.len(); let r=fit_laser(&cam,(f.board,30.0),views,out,n).unwrap();
    println!("{:?} {:?}\n{:?} rms {:.4} poses {} {:?}\n{:?} {:?}",r.sensor.plane(),t.elapsed(),r.sensor.intrinsics(),r.rms_mm,r.poses,r.advice,r.sensor.range(),r.sensor.covariance().unwrap().diagonal().map(f64::sqrt));
    for v in &r.views{println!("{} mean {:.3} rms {:.3} out {:.3} w {:.2} flag {} h/mm {:.1} {:.0?}",v.seen.board.name,v.mean_mm,v.rms_mm,v.left_out_mm,v.weight,v.flagged,v.height_per_mm,v.height_mm)}
    for h in [-350.,-400.,-450.,-500.,-550.]{ let p=r.sensor.pixel(seamtrack::calib::laser_camera::PlanePoint{lateral_mm:(r.sensor.range().unwrap().lateral_mm[0]+r.sensor.range().unwrap().lateral_mm[1])/2.,height_mm:h}).unwrap(); let c=r.sensor.calibration_covariance_mm2(p).unwrap(); println!("{h} {:?} sd lat {:.3} height {:.3}",p,c[(0,0)].sqrt(),c[(1,1)].sqrt())}
}
