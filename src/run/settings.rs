//! What a session needs of a configuration and of what is known of the sensor, and what must not contradict in them: the same for
//! recordings, live runs and Python.

use super::RunError;
use crate::calib::KnownSensor;
use crate::config::Config;
use crate::tracker::SessionSettings;

/// The session's settings.
///
/// # Errors
/// When the configuration is wrong, or says of the stripe what the calibration does not.
pub fn session_settings(config: &Config, known: &KnownSensor) -> Result<SessionSettings, RunError> {
    let (given, calibrated) = (config.stripe.axis(), known.stripe_axis());
    if let Some((given, calibrated)) = given.zip(calibrated).filter(|(given, calibrated)| given != calibrated) {
        return Err(RunError::OtherStripe { source_name: known.source.clone(), calibrated, given });
    }
    Ok(SessionSettings {
        method: config.method()?,
        axis: given.or(calibrated),
        seed_at: config.seed_at(),
        sensor: known.sensor.clone(),
        roi: config.roi(),
        lag: config.fixed_lag,
    })
}

/// Refuses a calibration of pictures of another size.
///
/// # Errors
/// When there is one, and frames are not of its pictures' size.
pub fn expect_calibrated_size(known: &KnownSensor, size_px: (usize, usize)) -> Result<(), RunError> {
    let Some(sensor) = known.sensor.laser_camera() else { return Ok(()) };
    let other = |sizes| RunError::OtherImageSize { source_name: known.source.clone(), sizes };
    sensor.expect_size(size_px).map_err(other)
}
