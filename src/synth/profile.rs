//! What the laser plane meets: for each column of the image the rows at which the stripe appears.

use super::base::Base;
use super::bead::Beads;
use super::draw::Drawn;
use super::noise::{Component, SmoothNoise};
use super::preparation::Prepared;
use super::scenario::{Butt, Fillet, Hairline, Joint, Lap, PlateEnd, Tack, Vgroove};
use super::timeline::Moment;

/// One continuous line of light, a value for each column.
#[derive(Debug, Clone)]
pub(super) struct Branch {
    /// Row of the ridge \[px\].
    pub(super) row_px: Vec<f32>,
    /// Brightness relative to the stripe's amplitude; 0 where there is no light.
    pub(super) gain: Vec<f32>,
    /// Width relative to the stripe's.
    pub(super) width: Vec<f32>,
    /// Whether it lies on the plates, and not below or beside them.
    pub(super) on_plates: bool,
}

/// Blur of an edge along the stripe by the optics, standard deviation \[px\] (chosen: a lens with a good focus).
const EDGE_BLUR_PX: f64 = 0.7;
/// Width of a V-groove's flanks relative to the plates' stripe: read off a real frame.
const FLANK_WIDTH: f64 = 0.75;

/// 0 before the edge, 1 behind it: the logistic approximation of an edge blurred by `blur_px`.
pub(super) fn edge(inside_px: f64, blur_px: f64) -> f64 {
    1.0 / (1.0 + (-1.702 * inside_px / blur_px).exp())
}

/// The same for the optics' own blur.
fn beyond(distance_px: f64) -> f64 {
    edge(distance_px, EDGE_BLUR_PX)
}

/// A smooth ramp: 0 before, `x` behind, rounded over `round`.
fn softplus(x: f64, round: f64) -> f64 {
    if round <= 0.0 { x.max(0.0) } else { round * ((-(x / round).abs()).exp().ln_1p()) + x.max(0.0) }
}

/// A line of light of `columns` columns: row, gain and width at each.
pub(super) fn branch(columns: usize, at: impl Fn(f64) -> (f64, f64, f64)) -> Branch {
    let mut branch =
        Branch { row_px: vec![0.0; columns], gain: vec![0.0; columns], width: vec![1.0; columns], on_plates: true };
    for x in 0..columns {
        let (row, gain, width) = at(x as f64);
        branch.row_px[x] = row as f32;
        branch.gain[x] = gain as f32;
        branch.width[x] = width as f32;
    }
    branch
}

/// The joint's branches of a frame. `fraction` is how much of the recording has passed, the joint is `Flat` outside its
/// extent.
pub(super) fn branches(
    drawn: &Drawn,
    joint: &Prepared,
    tack: Option<&Tack>,
    base: &Base,
    moment: &Moment,
    fraction: f64,
    seed: u64,
) -> Vec<Branch> {
    let beads = Beads { beads: &drawn.scenario.plates.beads, tick: moment.plates_tick, seed };
    let finish = &drawn.scenario.plates.finish;
    let frame = Frame {
        base,
        u: moment.along_px,
        ragged: moment.raggedness_px,
        gains: drawn.plate_gains,
        brighter_right: finish.right_brightness / finish.left_brightness,
        fraction,
        beads: (!beads.beads.is_empty()).then_some(beads),
    };
    let mut branches = frame.joint(joint, tack, moment.plates_tick, seed);
    if let (Some(second), None) = (drawn.scenario.rivals.second_seam, tack)
        && *joint.joint != Joint::Flat
    {
        let raggedness = |number: u64| {
            let wander = SmoothNoise::new(seed, Component::Rivals, 1000 + number);
            drawn.scenario.edges.raggedness_px * f64::from(wander.at(moment.plates_tick as f64, 0.0, 0.0))
        };
        let other =
            Frame { u: frame.u + second.beside_px, ragged: [raggedness(0), raggedness(1)], beads: None, ..frame };
        branches = side_by_side(
            branches,
            other.joint(joint, None, moment.plates_tick, seed),
            frame.u + 0.5 * second.beside_px,
            second.beside_px.signum(),
            second_below_px(&joint.joint, fraction, second.beside_px),
        );
    }
    for end in &drawn.scenario.rivals.plate_ends {
        branches = frame.ended(branches, end);
    }
    if let Some(stripe) = &drawn.scenario.false_stripe {
        let copies: Vec<Branch> = branches
            .iter()
            .map(|original| {
                branch(base.columns, |x| {
                    let source = (x - stripe.shift_px).round().clamp(0.0, base.columns as f64 - 1.0) as usize;
                    let row = f64::from(original.row_px[source]) + stripe.offset_px;
                    (row, stripe.strength * f64::from(original.gain[source]), 1.2)
                })
            })
            .collect();
        branches.extend(copies);
    }
    branches
}

/// The branches of two joints in one picture: the `other`'s on the side of `sign` beyond `middle_px`, its plates continuing
/// the first one's, `below_px` deeper.
fn side_by_side(first: Vec<Branch>, other: Vec<Branch>, middle_px: f64, sign: f64, below_px: f64) -> Vec<Branch> {
    let cut = |mut branch: Branch, sign: f64, below_px: f64| {
        for (x, gain) in branch.gain.iter_mut().enumerate() {
            *gain *= beyond(sign * (x as f64 - middle_px)) as f32;
        }
        branch.row_px.iter_mut().for_each(|row| *row += below_px as f32);
        branch
    };
    let first = first.into_iter().map(|branch| cut(branch, -sign, 0.0));
    first.chain(other.into_iter().map(|branch| cut(branch, sign, below_px))).collect()
}

/// How far a second joint `beside_px` from the first lies below it, for its plates to continue the first one's \[px\].
pub(super) fn second_below_px(joint: &Joint, fraction: f64, beside_px: f64) -> f64 {
    let down_to_the_right = match joint {
        Joint::Butt(j) => -j.hi_lo_px.at(fraction),
        Joint::Vgroove(j) => -j.hi_lo_px.at(fraction),
        Joint::Lap(j) => j.step_px.at(fraction) * if j.upper_on_right { -1.0 } else { 1.0 },
        Joint::Fillet(_) | Joint::Hairline(_) | Joint::Flat => 0.0,
    };
    beside_px.signum() * down_to_the_right
}

/// Where the seam's row lies below the base line \[px\]: the truth of v.
pub(super) fn truth_below_base_px(joint: &Joint) -> f64 {
    match joint {
        Joint::Vgroove(j) => j.depth_px,
        Joint::Butt(_) | Joint::Lap(_) | Joint::Fillet(_) | Joint::Hairline(_) | Joint::Flat => 0.0,
    }
}

/// Visible opening of the joint \[px\], where it has one: the truth of the gap.
pub(super) fn truth_gap_px(joint: &Joint, fraction: f64) -> Option<f64> {
    match joint {
        Joint::Butt(j) => Some(j.gap_px.at(fraction)),
        Joint::Vgroove(j) => Some(j.root_gap_px.at(fraction)),
        Joint::Lap(_) | Joint::Fillet(_) | Joint::Hairline(_) | Joint::Flat => None,
    }
}

#[derive(Clone, Copy)]
struct Frame<'a> {
    base: &'a Base<'a>,
    u: f64,
    ragged: [f64; 2],
    gains: [f64; 2],
    /// Brightness of the right plate relative to the left where no joint separates them.
    brighter_right: f64,
    fraction: f64,
    beads: Option<Beads<'a>>,
}

impl Frame<'_> {
    fn branch(&self, at: impl Fn(f64) -> (f64, f64, f64)) -> Branch {
        branch(self.base.columns, at)
    }

    fn joint(&self, joint: &Prepared, tack: Option<&Tack>, tick: usize, seed: u64) -> Vec<Branch> {
        let mut branches = match (tack, &*joint.joint) {
            (Some(tack), joint) => self.tack(tack, joint),
            (None, Joint::Butt(joint)) => self.butt(joint),
            (None, Joint::Lap(joint)) => self.lap(joint),
            (None, Joint::Vgroove(joint)) => self.vgroove(joint),
            (None, Joint::Fillet(joint)) => self.fillet(joint),
            (None, Joint::Hairline(joint)) => self.hairline(joint, tick, seed),
            (None, Joint::Flat) => vec![self.flat()],
        };
        if let (Some((depth_px, reflectance)), Joint::Vgroove(groove)) = (joint.floor, &*joint.joint) {
            branches.push(self.floor(0.5 * groove.root_gap_px.at(self.fraction), depth_px, reflectance));
        }
        branches
    }

    /// The branches up to where a plate ends, and what the laser meets beyond.
    fn ended(&self, mut branches: Vec<Branch>, end: &PlateEnd) -> Vec<Branch> {
        let (end_px, sign) = (self.u + end.beside_px, end.beside_px.signum());
        let column = (end_px.max(0.0) as usize).min(self.base.columns - 1);
        let plate = branches.iter().filter(|branch| branch.on_plates && branch.gain[column] > 0.0);
        let plate_px = plate.max_by(|a, b| a.gain[column].total_cmp(&b.gain[column])).map(|b| b.row_px[column]);
        for branch in &mut branches {
            for (x, gain) in branch.gain.iter_mut().enumerate() {
                *gain *= beyond(sign * (end_px - x as f64)) as f32;
            }
        }
        let level_px = plate_px.map_or(self.base.at(end_px), f64::from) - self.base.at(column as f64);
        let beyond_it = self.branch(|x| {
            let outwards_px = sign * (x - end_px);
            (
                self.base.at(x) + level_px + end.below_px + end.slope * outwards_px,
                end.brightness * beyond(outwards_px),
                1.0,
            )
        });
        branches.push(Branch { on_plates: false, ..beyond_it });
        branches
    }

    fn flat(&self) -> Branch {
        self.branch(|x| {
            let right = 1.0 + (self.brighter_right - 1.0) * beyond((x - self.u) / 2.0);
            (self.base.at(x), self.gains[0] * right, 1.0)
        })
    }

    fn floor(&self, half_gap_px: f64, depth_px: f64, reflectance: f64) -> Branch {
        let (left, right) = (self.u - half_gap_px + self.ragged[0], self.u + half_gap_px + self.ragged[1]);
        let floor =
            self.branch(|x| (self.base.at(x) + depth_px, reflectance * beyond(x - left) * beyond(right - x), 1.1));
        Branch { on_plates: false, ..floor }
    }

    fn butt(&self, joint: &Butt) -> Vec<Branch> {
        let half_gap = 0.5 * joint.gap_px.at(self.fraction);
        let half_hi_lo = 0.5 * joint.hi_lo_px.at(self.fraction);
        let left = self.u - half_gap + self.ragged[0];
        let right = self.u + half_gap + self.ragged[1];
        let droop = |distance: f64| joint.bent_edge_px * (-distance.max(0.0) / joint.bent_length_px).exp();
        vec![
            self.branch(|x| (self.base.at(x) + half_hi_lo + droop(left - x), self.gains[0] * beyond(left - x), 1.0)),
            self.branch(|x| (self.base.at(x) - half_hi_lo + droop(x - right), self.gains[1] * beyond(x - right), 1.0)),
            self.floor(half_gap, joint.depth_px, joint.floor_reflectance),
        ]
    }

    fn lap(&self, joint: &Lap) -> Vec<Branch> {
        let half_step = 0.5 * joint.step_px.at(self.fraction);
        let left = self.u - 0.5 * joint.shadow_px + self.ragged[0];
        let right = self.u + 0.5 * joint.shadow_px + self.ragged[1];
        let glint = |distance: f64| 1.0 + joint.glint * (-((distance - 1.5) / 1.5).powi(2)).exp();
        let sides = if joint.upper_on_right { [half_step, -half_step] } else { [-half_step, half_step] };
        let glints = if joint.upper_on_right { [0.0, 1.0] } else { [1.0, 0.0] };
        let lit = |side: usize, distance: f64| {
            self.gains[side] * beyond(distance) * (1.0 + glints[side] * (glint(distance) - 1.0))
        };
        vec![
            self.branch(|x| (self.base.at(x) + sides[0], lit(0, left - x), 1.0)),
            self.branch(|x| (self.base.at(x) + sides[1], lit(1, x - right), 1.0)),
        ]
    }

    fn vgroove(&self, joint: &Vgroove) -> Vec<Branch> {
        let half_root = 0.5 * joint.root_gap_px.at(self.fraction);
        let half_hi_lo = 0.5 * joint.hi_lo_px.at(self.fraction);
        // `inward` is the distance from the shoulder towards the root; each flank is shifted as a whole.
        let side = |index: usize, root: f64, sign: f64, plate: f64| {
            self.branch(|x| {
                let to_root = sign * (root - x);
                let half_width_px = joint.half_widths_px()[index];
                let inward = half_width_px - to_root;
                let slope = (joint.depth_px - plate) / half_width_px;
                let flank = beyond(inward / 2.0);
                let gain =
                    self.gains[index] * (1.0 + (joint.flank_reflectance - 1.0) * flank) * beyond(to_root - half_root);
                (self.base.at(x) + plate + slope * softplus(inward, 0.8), gain, 1.0 + (FLANK_WIDTH - 1.0) * flank)
            })
        };
        let flanks = vec![
            side(0, self.u + self.ragged[0], 1.0, half_hi_lo),
            side(1, self.u + self.ragged[1], -1.0, -half_hi_lo),
        ];
        match self.beads {
            None => flanks,
            Some(beads) => self.filled(flanks, beads),
        }
    }

    /// A groove whose beads hide what lies below them.
    fn filled(&self, mut flanks: Vec<Branch>, beads: Beads) -> Vec<Branch> {
        let bead =
            |x: f64| beads.at(x - self.u).map_or((f64::INFINITY, 0.0), |(below, gain)| (self.base.at(x) + below, gain));
        // The groove without its root gap, through which nothing is seen from above a bead.
        let groove = |x: f64, flanks: &[Branch]| f64::from(flanks[usize::from(x >= self.u)].row_px[x as usize]);
        let over: Vec<f64> =
            (0..self.base.columns).map(|x| beyond(groove(x as f64, &flanks) - bead(x as f64).0)).collect();
        let visible = self.branch(|x| {
            let (row, gain) = bead(x);
            (row, self.gains[usize::from(x >= self.u)] * gain * over[x as usize], 1.05)
        });
        for flank in &mut flanks {
            flank.gain.iter_mut().zip(&over).for_each(|(gain, over)| *gain *= (1.0 - over) as f32);
        }
        flanks.push(visible);
        flanks
    }

    fn fillet(&self, joint: &Fillet) -> Vec<Branch> {
        let corner = self.base.at(self.u);
        let row = |t: f64| {
            corner + joint.left_slope * t + (joint.right_slope - joint.left_slope) * softplus(t, joint.toe_px / 4.0)
        };
        let sag = |x: f64| self.base.at(x) - corner - self.base.tilt * (x - self.u);
        vec![
            self.branch(|x| {
                let t = x - self.u;
                let right = beyond(t / 2.0);
                (row(t) + sag(x), self.gains[0] + (self.gains[1] - self.gains[0]) * right, 1.0)
            }),
            self.branch(|x| {
                let t = x - self.u;
                (row(t) + sag(x), 0.35 * joint.inner_reflection * (-t.abs() / 25.0).exp(), 3.0)
            }),
        ]
    }

    fn hairline(&self, joint: &Hairline, tick: usize, seed: u64) -> Vec<Branch> {
        // Dip, bump, step and glint come and go within tens of frames, each on its own.
        let look = |number: u64| {
            f64::from(SmoothNoise::new(seed, Component::Hairline, number).at(tick as f64 / 17.0, 0.0, 0.0))
        };
        let dip = joint.dip * (0.75 + 0.5 * look(0)).clamp(0.15, 1.5);
        let bump = joint.bump_px * look(1);
        let step = joint.step * (0.3 + 0.7 * look(2));
        let glint = (0.8 * look(3)).max(0.0);
        vec![self.branch(|x| {
            let t = x - self.u;
            let near = (-0.5 * (t / joint.width_px).powi(2)).exp();
            let beside = (-0.5 * ((t - 2.5 * joint.width_px) / joint.width_px).powi(2)).exp();
            let log_gain = -dip * near + glint * beside + 0.5 * step * (t / 1.5).tanh();
            (self.base.at(x) + bump * near + 0.25 * bump * (t / 2.0).tanh(), self.gains[0] * log_gain.exp(), 1.0)
        })]
    }

    fn tack(&self, tack: &Tack, joint: &Joint) -> Vec<Branch> {
        // Height of the left and right plate below the base line.
        let [left, right] = match joint {
            // The bead rounds the corner out.
            Joint::Fillet(fillet) => {
                return self.fillet(&Fillet { toe_px: 1.5 * tack.half_width_px, ..fillet.clone() });
            }
            Joint::Butt(j) => [1.0, -1.0].map(|sign| sign * 0.5 * j.hi_lo_px.at(self.fraction)),
            Joint::Vgroove(j) => [1.0, -1.0].map(|sign| sign * 0.5 * j.hi_lo_px.at(self.fraction)),
            Joint::Lap(j) => {
                [-1.0, 1.0].map(|sign| sign * if j.upper_on_right { -0.5 } else { 0.5 } * j.step_px.at(self.fraction))
            }
            Joint::Hairline(_) | Joint::Flat => [0.0, 0.0],
        };
        vec![self.branch(|x| {
            let t = (x - self.u - 0.5 * (self.ragged[0] + self.ragged[1])) / tack.half_width_px;
            let bead = (1.0 - t * t).max(0.0);
            let on_bead = beyond((1.0 - t.abs()) * tack.half_width_px / 2.0);
            let across = (0.5 + 0.5 * t).clamp(0.0, 1.0);
            let plate = self.gains[0] + (self.gains[1] - self.gains[0]) * across;
            let level = left + (right - left) * across;
            (self.base.at(x) + level - tack.height_px * bead, plate * (1.0 - 0.45 * on_bead), 1.0 + 0.15 * on_bead)
        })]
    }
}
