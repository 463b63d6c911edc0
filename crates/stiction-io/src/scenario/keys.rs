//! All keys of each table, for any kind.

use crate::fields::Known;

pub const SCENARIO: Known = "title sample_time duration input start valve controller process \
    operating_point resolution set_point noise measurement load manual master";
pub const VALVE: Known = "model S J fs fd K rest_tolerance limits lag";
pub const CONTROLLER: Known = "kc ti td kp ki kd filter set_point_weight derivative_on form \
    handover limits anti_windup tracking_time";
pub const PROCESS: Known = "type gain tau tau2 num den delay dead_time";
pub const OPERATING_POINT: Known = "op pv";
pub const RESOLUTION: Known = "op pv";
pub const SIGNAL: Known = "signal value mean amplitude period phase steps start slope from step \
    dwell stairs sd tau seed file column";
pub const MANUAL: Known = "from until change";
pub const NOISE: Known = "sd tau seed";
pub const MASTER: Known = "every operating_point set_point controller process noise measurement";
