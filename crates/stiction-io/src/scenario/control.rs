//! `[controller]` and `[process]`.

use crate::fields::{Fields, Wrong};
use stiction_model::closed_loop::{
    AntiWindup, Controller, DeadTime, DerivativeOn, Form, Handover, Process,
};

pub fn controller(fields: Fields<'_, '_>) -> Result<Controller, Wrong> {
    let parallel = ["kp", "ki", "kd"].iter().any(|key| fields.has(key));
    let (kc, ti) = (fields.number("kc")?, fields.number("ti")?);
    let (td, filter) = (fields.number("td")?, fields.number("filter")?);
    let gains = (fields.number("kp")?, fields.number("ki")?, fields.number("kd")?);
    let refused = |e: stiction_model::Error| fields.refused(e);
    let mut controller = if parallel {
        if kc.or(ti).or(td).is_some() {
            return Err(fields.wrong_table(
                "give either kc, ti, td (ISA form) or kp, ki, kd (parallel form), not both",
            ));
        }
        let (kp, ki, kd) = gains;
        Controller::parallel(kp.unwrap_or(0.0), ki.unwrap_or(0.0), kd.unwrap_or(0.0))
    } else {
        let kc = kc.ok_or_else(|| fields.wrong("kc", "is missing; give the gain"))?;
        match (ti, td) {
            (None, None) => Controller::p(kc),
            (None, Some(_)) => {
                return Err(fields.wrong("ti", "is missing, but td is given"));
            }
            (Some(ti), td) => Controller::pid(kc, ti, td.unwrap_or(0.0)),
        }
    }
    .map_err(refused)?;
    if let Some(filter) = filter {
        controller = controller.with_filter(filter).map_err(refused)?;
    }
    if let Some(weight) = fields.number("set_point_weight")? {
        controller = controller.with_set_point_weight(weight).map_err(refused)?;
    }
    let derivative_on = fields
        .choice("derivative_on", &[("pv", DerivativeOn::Pv), ("error", DerivativeOn::Error)])?;
    let form =
        fields.choice("form", &[("positional", Form::Positional), ("velocity", Form::Velocity)])?;
    let handover =
        fields.choice("handover", &[("cold", Handover::Cold), ("bumpless", Handover::Bumpless)])?;
    controller =
        controller.with_derivative_on(derivative_on).with_form(form).with_handover(handover);
    let limits = fields.two("limits")?;
    let tracking = fields.number("tracking_time")?;
    let ways = [
        ("clamping", Some(AntiWindup::Clamping)),
        ("back-calculation", tracking.map(AntiWindup::BackCalculation)),
        ("none", Some(AntiWindup::None)),
    ];
    let anti_windup = fields.choice("anti_windup", &ways)?.ok_or_else(|| {
        fields.wrong("tracking_time", "is missing, but back-calculation needs a tracking time")
    })?;
    if let Some((low, high)) = limits {
        controller = controller.with_limits(low, high, anti_windup).map_err(refused)?;
    } else if fields.has("anti_windup") || fields.has("tracking_time") {
        return Err(fields.wrong("limits", "is missing; anti-windup needs limits"));
    }
    fields.finish()?;
    Ok(controller)
}

pub fn process(fields: Fields<'_, '_>) -> Result<(Process, DeadTime), Wrong> {
    let kind = fields.choice(
        "type",
        &[
            ("first-order", "first-order"),
            ("second-order", "second-order"),
            ("integrator", "integrator"),
            ("transfer-function", "transfer-function"),
        ],
    )?;
    let delay = fields.number_or("delay", 0.0)?;
    let dead_time = fields
        .choice("dead_time", &[("exact", DeadTime::Exact), ("nearest", DeadTime::Nearest)])?;
    let process = match kind {
        "first-order" => {
            let (gain, tau) = (fields.required_number("gain")?, fields.required_number("tau")?);
            Process::first_order(gain, tau, delay)
        }
        "second-order" => {
            let (gain, tau) = (fields.required_number("gain")?, fields.required_number("tau")?);
            Process::second_order(gain, tau, fields.required_number("tau2")?, delay)
        }
        "integrator" => Process::integrator(fields.required_number("gain")?, delay),
        _ => {
            let list = |key| {
                let missing =
                    || fields.wrong(key, "is missing; list coefficients, highest power of s first");
                fields.numbers(key)?.ok_or_else(missing)
            };
            Process::transfer_function(&list("num")?, &list("den")?, delay)
        }
    }
    .map_err(|e| fields.refused(e))?;
    fields.finish()?;
    Ok((process, dead_time))
}
