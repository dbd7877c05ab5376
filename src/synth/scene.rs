//! A scenario with a seed: frames and truth.

use super::arc::{ArcLight, add_cover, add_smoke};
use super::base::Base;
use super::bead::Beads;
use super::canvas::Canvas;
use super::draw::{Drawn, drawn};
use super::noise::{Component, SmoothNoise};
use super::obstacles::Obstacles;
use super::preparation::Prepared;
use super::profile::{Branch, branches, second_below_px, truth_below_base_px, truth_gap_px};
use super::projection::Projection;
use super::rivals::{other_stripe, reflection};
use super::scenario::{Joint, Scenario, ScenarioError, Shape, Tack};
use super::sensor::{expose, read_out};
use super::spatter::add_spatter;
use super::stripe::Illumination;
use super::surface::{OnPlates, Surface};
use super::timeline::{Moment, Timeline, simulate};
use crate::calib::PlanePoint;
use crate::frame::GrayFrame;
use crate::units::{PixelPoint, StripeAxis};

/// How close a joint may come to the image's border \[px\].
const MARGIN_PX: f64 = 12.0;
/// How far the path's middle is moved from the image's middle at most, as a fraction of the room there is.
const OFFSET_SHARE: f64 = 0.35;

/// How far from a pipe's axis a joint may lie at most, as a share of its radius (chosen: 50° of its side).
const PIPE_SHARE: f64 = 0.76;

/// A scenario and a seed, ready to render any frame in any order from any thread.
#[derive(Debug, Clone)]
pub struct Scene {
    drawn: Drawn,
    seed: u64,
    /// Extent along and across the stripe \[px\].
    along_px: usize,
    across_px: usize,
    base_row_px: f64,
    stripe_centre_px: f64,
    arc: ArcLight,
    surface: Surface,
    obstacles: Obstacles,
    timeline: Timeline,
    projection: Option<Projection>,
}

/// What is true in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Image coordinates of the seam centre \[px\]; none where there is no joint.
    pub seam: Option<PixelPoint>,
    /// Whether the seam is hidden: by a cover, or under a tack weld.
    pub occluded: bool,
    /// Visible opening \[px\] of a butt joint or a V-groove's root.
    pub gap_px: Option<f64>,
    /// Outermost toes of the beads of earlier passes, along the stripe \[px\]; none where there is no bead.
    pub bead_toes_px: Option<[f64; 2]>,
    /// Image coordinates of a second seam's centre \[px\].
    pub second: Option<PixelPoint>,
    /// The seam in the plane of the laser \[mm\], where the scenario has a camera.
    pub plane: Option<PlanePoint>,
}

impl Scene {
    /// The scene of a scenario and a seed.
    ///
    /// # Errors
    /// When a number of the scenario lies outside its range, or the joint would leave the image.
    pub fn new(scenario: &Scenario, seed: u64) -> Result<Self, ScenarioError> {
        scenario.check()?;
        let drawn = drawn(scenario, seed);
        let s = &drawn.scenario;
        let (along_px, across_px) = match s.image.stripe {
            StripeAxis::Horizontal => (s.image.width_px, s.image.height_px),
            StripeAxis::Vertical => (s.image.height_px, s.image.width_px),
        };
        let middle = 0.5 * along_px as f64;
        let reach = s.stripe.length_px.map_or(middle, |length| middle.min(0.5 * length)) - MARGIN_PX;
        let reach = s.plates.shape.radius_px.map_or(reach, |radius| reach.min(PIPE_SHARE * radius.abs()));
        let (low, high) = simulate(&drawn, seed, 0.0).along.range_px();
        let room = reach - 0.5 * (high - low);
        let has_joint = !matches!(s.joint, Joint::Flat);
        if has_joint && room < 0.0 {
            return Err(ScenarioError::Invalid {
                description: s.description.clone(),
                problem: format!(
                    "the path is {:.0} px long with this seed, but only {:.0} px of stripe are in the image: make the image or the stripe longer, or the path shorter",
                    high - low,
                    2.0 * reach
                ),
            });
        }
        let offset = (drawn.along_offset * OFFSET_SHARE * room.max(0.0)).clamp(-0.15 * middle, 0.15 * middle);
        let timeline = simulate(&drawn, seed, middle + offset);
        let base_row_px = 0.5 * across_px as f64 - 0.5 * truth_below_base_px(&s.joint)
            + centring_px(&s.joint, along_px)
            + shape_centring_px(&s.plates.shape, along_px, middle + offset)
            + 0.08 * across_px as f64 * drawn.across_offset;
        let arc = ArcLight::new(&drawn.disturbances.arc, s.image.stripe, along_px, across_px, middle + offset);
        let travel_px = travel_px_per_frame(s);
        let line = |tick: f64| timeline.along.at(tick);
        let surface = Surface::new(&s.plates, travel_px, seed, timeline.ticks, along_px, line);
        let obstacles = Obstacles::new(&s.view, seed, along_px, across_px, base_row_px);
        let projection = Projection::new(s, along_px, across_px)?;
        Ok(Self {
            projection,
            stripe_centre_px: middle,
            drawn,
            seed,
            along_px,
            across_px,
            base_row_px,
            arc,
            surface,
            obstacles,
            timeline,
        })
    }

    /// Number of recorded frames.
    #[must_use]
    pub fn frame_count(&self) -> usize {
        self.timeline.moments.len()
    }

    /// How the stripe runs.
    #[must_use]
    pub fn axis(&self) -> StripeAxis {
        self.drawn.scenario.image.stripe
    }

    /// The scenario in this seed's own numbers.
    #[must_use]
    pub fn drawn_scenario(&self) -> &Scenario {
        &self.drawn.scenario
    }

    /// Time stamp of a frame \[s\].
    ///
    /// # Panics
    /// When `frame` is not below [`Self::frame_count`].
    #[must_use]
    pub fn timestamp_s(&self, frame: usize) -> f64 {
        self.timeline.moments[frame].timestamp_s
    }

    /// Whether a frame repeats its predecessor.
    ///
    /// # Panics
    /// When `frame` is not below [`Self::frame_count`].
    #[must_use]
    pub fn is_repeated(&self, frame: usize) -> bool {
        frame > 0 && self.timeline.moments[frame].tick == self.timeline.moments[frame - 1].tick
    }

    /// What is true in a frame.
    ///
    /// # Panics
    /// When `frame` is not below [`Self::frame_count`].
    #[must_use]
    pub fn truth(&self, frame: usize) -> Truth {
        let moment = &self.timeline.moments[frame];
        if !self.has_joint(moment) {
            return Truth { seam: None, occluded: false, gap_px: None, bead_toes_px: None, second: None, plane: None };
        }
        let joint = self.prepared(moment).joint;
        let drawn = self.seam_in_section(moment);
        let seam = self.picture(drawn);
        let hidden = self.obstacles.hide(seam.u_px, seam.v_px, moment.tick as f64);
        Truth {
            seam: Some(self.axis().image_from_stripe(seam)),
            occluded: moment.cover.is_some() || self.tack_at(moment).is_some() || hidden,
            gap_px: truth_gap_px(&joint, self.fraction(moment)),
            bead_toes_px: self.bead_toes_px(moment, &joint),
            second: self.second_in_stripe_frame(moment, &joint).map(|second| self.axis().image_from_stripe(second)),
            plane: self.projection.as_ref().map(|projection| projection.plane(drawn)),
        }
    }

    /// Renders a frame: the same bytes on any thread in any order.
    ///
    /// # Panics
    /// When `frame` is not below [`Self::frame_count`].
    #[must_use]
    pub fn render(&self, frame: usize) -> GrayFrame {
        let moment = &self.timeline.moments[frame];
        let s = &self.drawn.scenario;
        let mut canvas = Canvas::filled(self.along_px, self.across_px, s.sensor.background_grey as f32);
        self.add_ambient(moment, &mut canvas);
        let branches = self.branches(moment);
        // Where the plates stand still, so does their speckle.
        Illumination { stripe: &s.stripe, centre_px: self.stripe_centre_px, tick: moment.plates_tick, seed: self.seed }
            .paint(&branches, &mut canvas);
        self.disturb(moment, &mut canvas);
        expose(&s.sensor, moment.exposure, &mut canvas);
        #[expect(clippy::expect_used, reason = "a checked scenario's image has pixels")]
        let mut picture =
            read_out(&s.sensor, self.axis(), self.seed, moment.tick, &canvas).expect("the canvas has pixels");
        self.obstacles.kill(self.axis(), &mut picture);
        picture
    }

    /// All lines of light of a frame.
    fn branches(&self, moment: &Moment) -> Vec<Branch> {
        let s = &self.drawn.scenario;
        let (base, fraction, tick) = (self.base(moment), self.fraction(moment), moment.plates_tick as f64);
        let joint = if self.has_joint(moment) { self.prepared(moment) } else { Prepared::flat() };
        let mut branches = branches(&self.drawn, &joint, self.tack_at(moment), &base, moment, fraction, self.seed);
        if s.plates.shape != Shape::default() {
            for branch in &mut branches {
                branch.gain.iter_mut().enumerate().for_each(|(x, gain)| *gain *= base.light(x as f64) as f32);
            }
        }
        let shake_px = moment.along_px - self.timeline.along.at(tick);
        self.surface.mark(&mut branches, OnPlates { tick, shake_px, seam_px: moment.along_px });
        if self.has_joint(moment) {
            let seam = self.seam_in_section(moment);
            for (number, rival) in (0..).zip(&s.rivals.reflections) {
                branches.push(reflection(rival, number, self.along_px, seam, tick, self.seed));
            }
        }
        if let Some(projection) = &self.projection {
            branches.iter_mut().for_each(|branch| *branch = projection.branch(branch));
        }
        branches.extend(s.rivals.stripes.iter().map(|stripe| other_stripe(stripe, self.along_px, self.base_row_px)));
        self.obstacles.dim(&mut branches, moment.tick as f64);
        branches
    }

    /// A recorded `image` as it would look in the arc, smoke and spatter of this scene's `frame`, the image's border
    /// continued where the scene is larger. The seam and covers stay the image's own.
    ///
    /// # Panics
    /// When `frame` is not below [`Self::frame_count`].
    #[must_use]
    pub fn composite(&self, frame: usize, image: &GrayFrame) -> GrayFrame {
        let moment = &self.timeline.moments[frame];
        let axis = self.axis();
        let mut canvas = Canvas::filled(self.along_px, self.across_px, 0.0);
        canvas.change(|along, across, light| {
            let (u, v) = match axis {
                StripeAxis::Horizontal => (along, across),
                StripeAxis::Vertical => (across, along),
            };
            *light = f32::from(image.at_clamped(u as isize, v as isize));
        });
        self.disturb(&Moment { cover: None, ..moment.clone() }, &mut canvas);
        expose(&self.drawn.scenario.sensor, moment.exposure, &mut canvas);
        #[expect(clippy::expect_used, reason = "a checked scenario's image has pixels")]
        read_out(&self.drawn.scenario.sensor, axis, self.seed, moment.tick, &canvas).expect("the canvas has pixels")
    }

    /// Smoke, cover, glare and spatter over what is on the canvas.
    fn disturb(&self, moment: &Moment, canvas: &mut Canvas) {
        let (d, tick) = (&self.drawn.disturbances, moment.tick);
        add_smoke(&d.smoke, moment.opacity, moment.flicker, self.seed, tick, canvas);
        if let Some(number) = moment.cover {
            let seam = self.seam_in_stripe_frame(moment);
            add_cover(d.covers.half_width_px, number, seam, self.seed, tick, canvas);
        }
        self.obstacles.hang(tick as f64, canvas);
        self.arc.add_glare(moment.flicker, canvas);
        if moment.flicker > 0.0 {
            add_spatter(&d.spatter, moment.burst, self.arc.position, self.seed, tick, canvas);
        }
        self.obstacles.soil(d.arc.glare_grey * moment.flicker, canvas);
    }

    /// How much of the recording has passed, 0 to 1.
    fn fraction(&self, moment: &Moment) -> f64 {
        moment.plates_tick as f64 / (self.timeline.ticks.max(2) - 1) as f64
    }

    fn base(&self, moment: &Moment) -> Base<'_> {
        let stripe = &self.drawn.scenario.stripe;
        Base {
            columns: self.along_px,
            row_px: self.base_row_px + moment.across_px,
            tilt: stripe.tilt,
            sag_px: stripe.sag_px,
            shape: &self.drawn.scenario.plates.shape,
            seam_px: moment.along_px,
        }
    }

    /// What a place of the section is in the picture, the stripe along the rows. A checked sensor sees the section.
    fn picture(&self, place: PixelPoint) -> PixelPoint {
        self.projection.as_ref().and_then(|projection| projection.stripe_frame(place)).unwrap_or(place)
    }

    fn seam_in_stripe_frame(&self, moment: &Moment) -> PixelPoint {
        self.picture(self.seam_in_section(moment))
    }

    fn seam_in_section(&self, moment: &Moment) -> PixelPoint {
        let below = truth_below_base_px(&self.prepared(moment).joint);
        PixelPoint::new(moment.along_px, self.base(moment).at(moment.along_px) + below)
    }

    fn second_in_stripe_frame(&self, moment: &Moment, joint: &Joint) -> Option<PixelPoint> {
        let beside_px = self.drawn.scenario.rivals.second_seam?.beside_px;
        let along_px = moment.along_px + beside_px;
        let below = truth_below_base_px(joint) + second_below_px(joint, self.fraction(moment), beside_px);
        Some(self.picture(PixelPoint::new(along_px, self.base(moment).at(along_px) + below)))
    }

    fn bead_toes_px(&self, moment: &Moment, joint: &Joint) -> Option<[f64; 2]> {
        let Joint::Vgroove(groove) = joint else { return None };
        let beads = Beads { beads: &self.drawn.scenario.plates.beads, tick: moment.plates_tick, seed: self.seed };
        let toes = beads.toes_px(groove, self.fraction(moment))?;
        let base = self.base(moment);
        Some(toes.map(|toe| moment.along_px + toe).map(|u| self.picture(PixelPoint::new(u, base.at(u))).u_px))
    }

    /// The joint at a camera frame, wherever it exists.
    fn prepared(&self, moment: &Moment) -> Prepared<'_> {
        let s = &self.drawn.scenario;
        Prepared::at(&s.joint, s.change.as_ref(), moment.plates_tick, self.fraction(moment))
    }

    /// Whether there is a joint under the stripe.
    fn has_joint(&self, moment: &Moment) -> bool {
        self.exists_at(moment.plates_tick as f64) && !matches!(self.drawn.scenario.joint, Joint::Flat)
    }

    fn exists_at(&self, tick: f64) -> bool {
        let extent = &self.drawn.scenario.extent;
        extent.from_frame.is_none_or(|from| tick >= from as f64) && extent.to_frame.is_none_or(|to| tick < to as f64)
    }

    fn tack_at(&self, moment: &Moment) -> Option<&Tack> {
        if !self.has_joint(moment) {
            return None;
        }
        self.drawn.scenario.tacks.iter().find(|tack| (tack.from_frame..tack.to_frame).contains(&moment.plates_tick))
    }

    /// Plates in ambient light: stains that travel, and a hairline joint before and behind the stripe.
    fn add_ambient(&self, moment: &Moment, canvas: &mut Canvas) {
        let s = &self.drawn.scenario;
        let tick = moment.plates_tick as f64;
        let travel_px = travel_px_per_frame(s);
        if s.sensor.texture_grey > 0.0 {
            let stains = SmoothNoise::new(self.seed, Component::Texture, 1);
            let texture = s.sensor.texture_grey as f32;
            let stain = |x: f64, y: f64| {
                let y = y - tick * travel_px;
                texture * stains.cloud(x / 60.0, y / 60.0, 0.0)
            };
            canvas.change_by_field(8, stain, |stain, value| *value += stain);
        }
        if let Joint::Hairline(hairline) = &s.joint {
            self.add_ambient_line(hairline.ambient_line_grey, travel_px, moment, canvas);
        }
    }

    /// The joint in ambient light: what lies `w` rows beyond the stripe passed it `w / travel` frames ago or will.
    fn add_ambient_line(&self, contrast_grey: f64, travel_px: f64, moment: &Moment, canvas: &mut Canvas) {
        let tick = moment.plates_tick as f64;
        let contrast = SmoothNoise::new(self.seed, Component::Hairline, 9);
        let shake = moment.along_px - self.timeline.along.at(tick);
        let base = self.base(moment);
        for row in 0..canvas.height_px() {
            let passed = tick - (row as f64 - base.at(moment.along_px)) / travel_px;
            if !self.exists_at(passed) {
                continue;
            }
            let line = self.timeline.along.at(passed) + shake;
            let here = contrast_grey * (0.8 + 0.6 * f64::from(contrast.at(passed / 9.0, 0.0, 0.0))).clamp(0.05, 1.6);
            for column in (line as i64 - 6)..=(line as i64 + 7) {
                let t = column as f64 - line;
                let dark = -here * (-0.5 * (t / 1.1).powi(2)).exp();
                let lip = 0.6 * here * (-0.5 * ((t - 2.6) / 1.0).powi(2)).exp();
                canvas.add(column, row as i64, (dark + lip) as f32);
            }
        }
    }
}

/// Travel of the plates between two camera frames \[px\].
fn travel_px_per_frame(scenario: &Scenario) -> f64 {
    match &scenario.joint {
        Joint::Hairline(hairline) => hairline.travel_px_per_frame,
        _ => scenario.plates.travel_px_per_frame,
    }
}

/// Moves bent plates so that they stay inside \[px\]: half of what the stripe falls or rises on the image's length.
fn shape_centring_px(shape: &Shape, columns: usize, seam_px: f64) -> f64 {
    let base = Base { columns, row_px: 0.0, tilt: 0.0, sag_px: 0.0, shape, seam_px };
    let rows = (0..columns).step_by(8).map(|x| x as f64).filter(|&x| base.light(x) > 0.2).map(|x| base.at(x));
    let (low, high) = rows.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), row| (low.min(row), high.max(row)));
    if low <= high { -0.5 * (low + high) } else { 0.0 }
}

/// Moves joints that rise towards the image's ends so that they stay inside \[px\].
fn centring_px(joint: &Joint, along_px: usize) -> f64 {
    match joint {
        Joint::Fillet(fillet) => 0.125 * (fillet.left_slope - fillet.right_slope) * along_px as f64,
        Joint::Butt(butt) => -0.5 * butt.depth_px,
        _ => 0.0,
    }
}
