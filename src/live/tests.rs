//! The guide in virtual time: a robot that executes late, a camera ahead of the torch, and what happens to both.

use std::collections::VecDeque;

use proptest::prelude::*;

use super::*;

/// Robot, camera and guide on one clock. Times in whole milliseconds, so that nothing is left to rounding.
struct World {
    guide: Guide,
    settings: GuideSettings,
    seam_mm: fn(f64) -> f64,
    is_visible: fn(f64) -> bool,
    speed_mm_s: f64,
    cycle_ms: u64,
    now_ms: u64,
    path_mm: f64,
    lateral_mm: f64,
    /// Steps that the robot has not executed yet.
    ordered: VecDeque<(u64, f64)>,
    /// Sightings on their way.
    seen: VecDeque<(u64, Sighting)>,
    camera_runs: bool,
    noise_mm: f64,
    answers: Vec<(f64, Answer)>,
    errors_mm: Vec<f64>,
}

/// Time passes in steps of this; the robot's cycle is one or three of them.
const TICK_MS: u64 = 4;
const FRAME_MS: u64 = 16;
const TRACKING_MS: u64 = 10;
const DELAY_MS: u64 = 12;

fn sine(path_mm: f64) -> f64 {
    3.0 * (std::f64::consts::TAU * path_mm / 200.0).sin()
}

impl World {
    fn new(settings: GuideSettings, seam_mm: fn(f64) -> f64) -> Self {
        Self {
            guide: Guide::new(settings).unwrap(),
            settings,
            seam_mm,
            is_visible: |_| true,
            speed_mm_s: 30.0,
            cycle_ms: 4,
            now_ms: 1000,
            path_mm: 0.0,
            lateral_mm: 0.0,
            ordered: VecDeque::new(),
            seen: VecDeque::new(),
            camera_runs: true,
            noise_mm: 0.0,
            answers: vec![],
            errors_mm: vec![],
        }
    }

    /// The robot's next cycle, and all that happens before it.
    fn cycle(&mut self) -> Answer {
        while !self.now_ms.is_multiple_of(self.cycle_ms) {
            self.tick();
        }
        let answer = self.guide.cycle(self.now_ms as f64 * 1e-3, self.pose());
        if let Correction::Step(step_mm) = answer.correction {
            self.ordered.push_back((self.now_ms + DELAY_MS, step_mm));
        }
        self.answers.push((self.path_mm, answer));
        self.tick();
        answer
    }

    fn pose(&self) -> Pose {
        Pose { path_mm: self.path_mm, lateral_mm: self.lateral_mm }
    }

    fn tick(&mut self) {
        self.now_ms += TICK_MS;
        self.path_mm += self.speed_mm_s * TICK_MS as f64 * 1e-3;
        let now_s = self.now_ms as f64 * 1e-3;
        while self.ordered.front().is_some_and(|(at_ms, _)| *at_ms <= self.now_ms) {
            self.lateral_mm += self.ordered.pop_front().unwrap().1;
        }
        if self.camera_runs && self.now_ms.is_multiple_of(FRAME_MS) {
            let place_mm = self.path_mm + self.settings.ahead_mm;
            // Noise that repeats itself is noise enough, and needs no seed.
            let noise_mm = self.noise_mm * (1.7 * self.now_ms as f64).sin();
            let seam = (self.is_visible)(place_mm)
                .then(|| Offset { lateral_mm: (self.seam_mm)(place_mm) - self.lateral_mm + noise_mm, std_mm: 0.02 });
            self.seen.push_back((self.now_ms + TRACKING_MS, Sighting { exposed_s: now_s, is_live: true, seam }));
        }
        while self.seen.front().is_some_and(|(at_ms, _)| *at_ms <= self.now_ms) {
            self.guide.see(&self.seen.pop_front().unwrap().1);
        }
        if self.path_mm > self.settings.ahead_mm + 10.0 {
            self.errors_mm.push(self.lateral_mm - (self.seam_mm)(self.path_mm));
        }
    }

    fn drive_to(&mut self, path_mm: f64) -> Answer {
        let mut last = self.cycle();
        while self.path_mm < path_mm {
            last = self.cycle();
        }
        last
    }

    fn rms_and_max_mm(&self) -> (f64, f64) {
        let squares: f64 = self.errors_mm.iter().map(|error_mm| error_mm * error_mm).sum();
        let max_mm = self.errors_mm.iter().fold(0.0, |most: f64, error_mm| most.max(error_mm.abs()));
        ((squares / self.errors_mm.len() as f64).sqrt(), max_mm)
    }

    fn states(&self) -> Vec<State> {
        let mut states: Vec<State> = self.answers.iter().map(|(_, answer)| answer.state).collect();
        states.dedup();
        states
    }
}

#[test]
fn the_torch_follows_a_sine_of_three_millimetres_at_both_cycles_of_the_robot() {
    for cycle_ms in [4, 12] {
        let mut world = World { cycle_ms, noise_mm: 0.05, ..World::new(GuideSettings::default(), sine) };
        world.drive_to(600.0);
        let (rms_mm, max_mm) = world.rms_and_max_mm();
        assert!(rms_mm < 0.03 && max_mm < 0.08, "{cycle_ms} ms: rms {rms_mm:.4}, max {max_mm:.4}");
        assert_eq!(world.states(), [State::Wait, State::Ok]);
    }
}

#[test]
fn a_robot_that_tells_no_pose_is_led_by_its_speed() {
    let mut guide = Guide::new(GuideSettings::default()).unwrap();
    let (mut lateral_mm, mut errors_mm) = (0.0, vec![]);
    for i in 0..5000_u32 {
        let (now_s, path_mm) = (1.0 + 0.004 * f64::from(i), 0.12 * f64::from(i));
        if i % 4 == 0 {
            let seam = Some(Offset { lateral_mm: sine(path_mm + 20.0) - lateral_mm, std_mm: 0.02 });
            guide.see(&Sighting { exposed_s: now_s, is_live: true, seam });
        }
        lateral_mm = guide.cycle_at_speed(now_s, 30.0).total_mm;
        if path_mm > 30.0 {
            errors_mm.push((lateral_mm - sine(path_mm)).abs());
        }
    }
    assert!(errors_mm.iter().all(|error_mm| *error_mm < 0.15), "{:?}", errors_mm.iter().copied().fold(0.0, f64::max));
}

#[test]
fn a_tack_weld_is_crossed_on_the_line_between_its_ends() {
    let mut world = World::new(GuideSettings::default(), sine);
    world.is_visible = |place_mm| !(100.0..112.0).contains(&place_mm);
    world.drive_to(300.0);
    assert_eq!(world.states(), [State::Wait, State::Ok, State::Coast, State::Ok]);
    let over_tack = world.answers.iter().filter(|(path_mm, _)| (102.0..108.0).contains(path_mm));
    assert!(over_tack.clone().all(|(_, answer)| answer.why == Why::Bridging && answer.remaining_mm.is_some()));
    assert!(world.rms_and_max_mm().1 < 0.2, "{:?}", world.rms_and_max_mm());
}

#[test]
fn a_seam_that_is_not_seen_any_more_coasts_then_is_lost_then_stops_by_distance() {
    let mut world = World::new(GuideSettings::default(), sine);
    world.is_visible = |place_mm| place_mm < 100.0;
    world.drive_to(200.0);
    assert_eq!(world.states(), [State::Wait, State::Ok, State::Coast, State::Lost, State::Stop]);
    let at_mm = |state| world.answers.iter().find(|(_, answer)| answer.state == state).unwrap().0;
    // The target is read a little ahead of the torch, and the last was a picture before 100 mm.
    assert!((98.0..100.0).contains(&at_mm(State::Coast)), "{}", at_mm(State::Coast));
    assert!((at_mm(State::Lost) - at_mm(State::Coast) - 5.0).abs() < 0.3);
    assert!((at_mm(State::Stop) - at_mm(State::Coast) - 15.0).abs() < 0.3);
    let unseen = world.answers.iter().filter(|(path_mm, _)| *path_mm > 100.0);
    assert!(
        unseen.clone().all(|(_, answer)| answer.correction == Correction::Hold),
        "nothing is known, so nothing is sent"
    );
}

#[test]
fn a_dead_camera_coasts_then_is_lost_then_stops_by_age_however_slow_the_robot() {
    let mut world = World { speed_mm_s: 2.0, ..World::new(GuideSettings::default(), |_| 1.0) };
    world.drive_to(40.0);
    world.camera_runs = false;
    world.answers.clear();
    world.drive_to(50.0);
    assert_eq!(world.states(), [State::Ok, State::Coast, State::Lost, State::Stop]);
    assert_eq!(world.answers.last().unwrap().1.why, Why::CameraSilent);
    let in_time = |(_, answer): &&(f64, Answer)| answer.age_s.unwrap() > 0.76;
    assert!(world.answers.iter().filter(in_time).all(|(_, answer)| answer.correction == Correction::Hold));
}

#[test]
fn a_dead_camera_is_named_though_the_way_without_a_value_ends_before_the_time_does() {
    let mut world = World::new(GuideSettings::default(), |_| 1.0);
    world.drive_to(100.0);
    world.camera_runs = false;
    world.drive_to(160.0);
    let answer = world.answers.last().unwrap().1;
    assert!(answer.age_s.unwrap() < 2.0 + 1e-9 && answer.state == State::Stop, "{answer:?}");
    assert_eq!(answer.why, Why::CameraSilent);
}

#[test]
fn a_camera_that_stalls_for_half_a_second_leaves_no_step_behind() {
    let mut world = World::new(GuideSettings::default(), sine);
    world.drive_to(150.0);
    world.camera_runs = false;
    world.drive_to(165.0);
    world.camera_runs = true;
    world.drive_to(400.0);
    let (rms_mm, max_mm) = world.rms_and_max_mm();
    assert!(rms_mm < 0.1 && max_mm < 0.6, "rms {rms_mm:.4}, max {max_mm:.4}");
    assert!(!world.states().contains(&State::Stop), "{:?}", world.states());
}

#[test]
fn a_process_that_was_stopped_finds_itself_in_stop_when_it_goes_on() {
    let mut world = World::new(GuideSettings::default(), sine);
    world.drive_to(100.0);
    world.now_ms += 800;
    world.path_mm += 24.0;
    let answer = world.cycle();
    assert_eq!((answer.state, answer.why, answer.correction), (State::Stop, Why::RobotSilent, Correction::Hold));
    assert_eq!(world.drive_to(200.0).state, State::Stop, "and stays there");
    world.guide.reset();
    world.drive_to(300.0);
    assert_eq!(world.drive_to(301.0).state, State::Ok);
}

#[test]
fn after_a_pause_longer_than_a_targets_age_nothing_old_is_steered_to() {
    let mut world = World::new(GuideSettings { target_age_s: 3.0, ..GuideSettings::default() }, sine);
    world.drive_to(100.0);
    world.speed_mm_s = 0.0;
    for _ in 0..1000 {
        world.cycle();
    }
    let answer = world.cycle();
    assert_eq!((answer.state, answer.why, answer.correction), (State::Coast, Why::SeamUnseen, Correction::Hold));
}

#[test]
fn a_frozen_picture_is_no_picture() {
    let mut guide = Guide::new(GuideSettings::default()).unwrap();
    let mut last = State::Wait;
    for i in 0..1000_u32 {
        let now_s = 0.004 * f64::from(i);
        let seam = Some(Offset { lateral_mm: 0.0, std_mm: 0.01 });
        guide.see(&Sighting { exposed_s: now_s, is_live: i < 300, seam });
        last = guide.cycle(now_s, Pose { path_mm: 0.12 * f64::from(i), lateral_mm: 0.0 }).state;
    }
    assert_eq!(last, State::Stop);
}

#[test]
fn a_seam_is_waited_for_from_the_start_and_given_up_when_it_does_not_come() {
    let mut world = World::new(GuideSettings::default(), sine);
    world.is_visible = |_| false;
    assert_eq!(world.drive_to(29.0).state, State::Wait);
    let answer = world.drive_to(32.0);
    assert_eq!((answer.state, answer.why), (State::Stop, Why::NotFound));
}

#[test]
fn behind_the_stated_length_nothing_is_missed() {
    let mut world = World::new(GuideSettings { seam_mm: Some(100.0), ..GuideSettings::default() }, sine);
    world.is_visible = |place_mm| (30.0..131.0).contains(&place_mm);
    world.drive_to(300.0);
    assert_eq!(world.states(), [State::Wait, State::Ok, State::Done]);
}

#[test]
fn a_seam_beyond_the_reach_of_corrections_stops() {
    let mut world = World::new(GuideSettings::default(), |path_mm| 0.05 * path_mm);
    let answer = world.drive_to(200.0);
    assert_eq!((answer.state, answer.why), (State::Stop, Why::OutOfReach));
    assert!(answer.total_mm <= 5.0 && world.lateral_mm > 4.5, "{}", world.lateral_mm);
}

#[test]
fn settings_out_of_range_are_named() {
    let bad = Guide::new(GuideSettings { gain: 1.0, ..GuideSettings::default() }).unwrap_err();
    assert_eq!(bad.to_string(), "the guide's gain must be from 0.01 to 0.3, not 1");
    assert!(Guide::new(GuideSettings { coast_s: f64::NAN, ..GuideSettings::default() }).is_err());
    assert!(Guide::new(GuideSettings { tack_mm: 25.0, ..GuideSettings::default() }).is_err());
}

/// Something that happens at the torch.
#[derive(Debug, Clone)]
enum Event {
    Cycle { after_s: f64, along_mm: f64, across_mm: f64 },
    Sight { age_s: f64, is_live: bool, seam: Option<Offset> },
    Reset,
}

fn event() -> impl Strategy<Value = Event> {
    let number = prop_oneof![8 => -8.0..8.0, 1 => Just(f64::NAN), 1 => Just(1e9)];
    let seam = proptest::option::weighted(0.8, (number, prop_oneof![9 => 0.0..0.4, 1 => Just(f64::NAN)]));
    let after_s = prop_oneof![40 => Just(0.004), 5 => 0.0..0.05, 1 => Just(-0.01), 1 => Just(0.5)];
    let along_mm = prop_oneof![40 => 0.0..0.5, 2 => -1.0..3.0, 1 => Just(f64::INFINITY)];
    prop_oneof![
        30 => (after_s, along_mm, -0.1..0.1)
            .prop_map(|(after_s, along_mm, across_mm)| Event::Cycle { after_s, along_mm, across_mm }),
        10 => (prop_oneof![9 => 0.0..0.03, 1 => -1.0..9.0], proptest::bool::weighted(0.9), seam).prop_map(
            |(age_s, is_live, seam)| Event::Sight {
                age_s,
                is_live,
                seam: seam.map(|(lateral_mm, std_mm)| Offset { lateral_mm, std_mm }),
            }
        ),
        1 => Just(Event::Reset),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]
    #[test]
    fn whatever_happens_caps_hold_stale_values_are_never_sent_and_a_stop_stays(events in proptest::collection::vec(event(), 1..400)) {
        let settings = GuideSettings { ahead_mm: 2.0, tack_mm: 2.0, target_age_s: 0.3, ..GuideSettings::default() };
        let mut guide = Guide::new(settings).unwrap();
        let (mut now_s, mut pose) = (1.0, Pose::default());
        let (mut stopped, mut sum_mm, mut last_s, mut newest_s, mut seams) = (false, 0.0_f64, None::<f64>, None::<f64>, vec![]);
        for event in events {
            match event {
                Event::Reset => {
                    guide.reset();
                    (stopped, sum_mm, last_s, newest_s) = (false, 0.0, None, None);
                    seams.clear();
                    pose = Pose::default();
                }
                Event::Sight { age_s, is_live, seam } => {
                    let exposed_s = now_s - age_s;
                    guide.see(&Sighting { exposed_s, is_live, seam });
                    if is_live {
                        newest_s = Some(newest_s.map_or(exposed_s, |newest_s| newest_s.max(exposed_s)));
                        seams.extend(seam.map(|_| exposed_s));
                    }
                }
                Event::Cycle { after_s, along_mm, across_mm } => {
                    now_s += after_s;
                    pose = Pose { path_mm: pose.path_mm + along_mm, lateral_mm: pose.lateral_mm + across_mm };
                    let answer = guide.cycle(now_s, pose);
                    prop_assert!(!stopped || answer.state == State::Stop, "a stop is latched");
                    stopped = answer.state == State::Stop;
                    if let Correction::Step(step_mm) = answer.correction {
                        prop_assert!(matches!(answer.state, State::Ok | State::Coast));
                        prop_assert!(answer.remaining_mm.is_some_and(f64::is_finite));
                        prop_assert!(step_mm.abs() <= settings.step_mm + 1e-12);
                        let since_s = last_s.map_or(0.004, |last_s| now_s - last_s);
                        prop_assert!(step_mm.abs() <= settings.speed_mm_s * since_s + 1e-12);
                        sum_mm += step_mm;
                        prop_assert!(sum_mm.abs() <= settings.total_mm + 1e-9);
                        prop_assert!((sum_mm - answer.total_mm).abs() < 1e-9);
                        // Both the camera and the target that is steered to are fresh enough.
                        prop_assert!(newest_s.is_some_and(|newest_s| now_s - newest_s <= settings.coast_s + 1e-9));
                        prop_assert!(seams.iter().any(|seen_s| now_s - seen_s <= settings.target_age_s + 1e-9));
                    }
                    last_s = Some(now_s);
                }
            }
        }
    }
}
