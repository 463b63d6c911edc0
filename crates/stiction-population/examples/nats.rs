use stiction_diagnose::evidence;
use stiction_diagnose::identify::information::experiment;
use stiction_diagnose::recording::{Grid, GridOptions};
use stiction_model::valve::Model;
use stiction_population as pop;
use rayon::prelude::*;
fn main() {
    let n: u64 = std::env::args().nth(1).unwrap().parse().unwrap();
    println!("index,kind,visible,gain,slips,S,J,model,steps,rep,grid,best,best2,vp,known,shat,z,factor,noise,situ,hist,lag,dead,tau,oq,ocomp,oexc,avg,share,op_range,dt,own,opnoise");
    let rows: Vec<String> = (0..n).into_par_iter().filter_map(|i| {
        let m = pop::member(2, i).ok()?;
        let t = &m.truth;
        if !(t.kind == pop::LoopKind::Sticky && t.visible || !t.sticks && i % 4 == 0) { return None; }
        let grid = Grid::of(&m.recording, &GridOptions::default()).ok()?;
        let seg = grid.longest()?;
        let period = evidence::recorded_period(seg);
        let pv = seg.pv.as_ref()?;
        if t.vp.len() != seg.op.len() { return None; }
        let model = match t.model { Some(Model::He) => Some(Model::He), Some(Model::TwoPhase) => Some(Model::TwoPhase), _ => None };
        let r = experiment(&seg.op, pv, period, &t.vp, model.map(|m| (m, t.s, t.j)))?;
        Some(format!("{i},{},{},{:.1},{},{:.3},{:.3},{:?},{},{},{},{},{},{}", t.kind.name(), t.visible, t.gain, t.slips, t.s, t.j, t.model, t.facts.steps_per_sample,
            r.iter().map(|v| format!("{v:.2}")).collect::<Vec<_>>().join(","), t.facts.noise.name(), t.facts.situation.name(), t.facts.historian.iter().map(|h| h.name()).collect::<Vec<_>>().join("+"), { let f=&t.facts; format!("{:.3},{:.3},{:.3},{},{:.3},{:.3},{},{:.2},{:.3},{},{:.4},{:.3}", f.valve_lag_s/f.sample_time_s, f.dead_time_s/f.sample_time_s, f.tau_s/f.sample_time_s, f.op_quantum, f.op_compression, f.op_exception, f.averaged, f.faulty_share, f.op_travel, f.sample_time_s, f.own_noise, t.op_noise)}))
    }).collect();
    for r in rows { println!("{r}"); }
}
