//! 1,000 valves, 10,000 samples each: what FMI costs beside the library itself.
//!
//! An importer in a few lines loads the library's file and, sample by sample and valve by valve, sets OP,
//! takes a step and gets VP. Its peer steps the same valves in a vector. The machine is shared: rounds
//! alternate, and the best of each is printed.
#![allow(unsafe_code)]

#[path = "../tests/common/library.rs"]
mod library;

use std::ffi::{CString, c_char, c_int, c_void};
use std::hint::black_box;
use std::ptr::null_mut;
use std::time::Instant;

use library::Library;
use stiction::Bands;
use stiction::valve::{Assembly, Model, Start, Valve};
use stiction_fmu::{Fmu, fmi2};

const INSTANCES: usize = 1_000;
const SAMPLES: usize = 10_000;
const ROUNDS: usize = 7;

type C = *mut c_void;
type Text = *const c_char;

/// Sets OP, takes the step that begins at this time, and gets VP.
trait Importer {
    fn step(&self, instance: C, time: f64, op: f64) -> f64;
}

struct Two {
    set: unsafe extern "C" fn(C, *const u32, usize, *const f64) -> c_int,
    step: unsafe extern "C" fn(C, f64, f64, c_int) -> c_int,
    get: unsafe extern "C" fn(C, *const u32, usize, *mut f64) -> c_int,
}

impl Importer for Two {
    #[inline(always)]
    fn step(&self, instance: C, time: f64, op: f64) -> f64 {
        let mut vp = f64::NAN;
        // SAFETY: the instance is alive, and arrays hold one value.
        let status = unsafe {
            (self.set)(instance, &1, 1, &op)
                | (self.step)(instance, time, 1.0, 1)
                | (self.get)(instance, &2, 1, &mut vp)
        };
        assert_eq!(status, 0);
        vp
    }
}

struct Three {
    set: unsafe extern "C" fn(C, *const u32, usize, *const f64, usize) -> c_int,
    step:
        unsafe extern "C" fn(C, f64, f64, bool, *mut bool, *mut bool, *mut bool, *mut f64) -> c_int,
    get: unsafe extern "C" fn(C, *const u32, usize, *mut f64, usize) -> c_int,
}

impl Importer for Three {
    #[inline(always)]
    fn step(&self, instance: C, time: f64, op: f64) -> f64 {
        let (mut vp, mut last) = (f64::NAN, f64::NAN);
        let [mut events, mut end, mut early] = [false; 3];
        // SAFETY: the instance is alive, and arrays hold one value.
        let status = unsafe {
            (self.set)(instance, &1, 1, &op, 1)
                | (self.step)(
                    instance,
                    time,
                    1.0,
                    true,
                    &mut events,
                    &mut end,
                    &mut early,
                    &mut last,
                )
                | (self.get)(instance, &2, 1, &mut vp, 1)
        };
        assert!(status == 0 && !end && !early);
        vp
    }
}

/// What three calls cost that do the same and check nothing.
struct Bare {
    op: f64,
    vp: f64,
    valve: Assembly,
}

unsafe extern "C" fn bare_set(c: C, _: *const u32, _: usize, value: *const f64) -> c_int {
    // SAFETY: this program calls it with a `Bare` and a value.
    unsafe { (*c.cast::<Bare>()).op = *value };
    0
}

unsafe extern "C" fn bare_step(c: C, _: f64, _: f64, _: c_int) -> c_int {
    // SAFETY: see above.
    let bare = unsafe { &mut *c.cast::<Bare>() };
    bare.vp = bare.valve.step(bare.op);
    0
}

unsafe extern "C" fn bare_get(c: C, _: *const u32, _: usize, value: *mut f64) -> c_int {
    // SAFETY: see above.
    unsafe { *value = (*c.cast::<Bare>()).vp };
    0
}

/// Seconds that all steps take, and the sum of all VP.
fn imported(importer: &impl Importer, instances: &[C], op: &[f64]) -> (f64, f64) {
    let began = Instant::now();
    let mut sum = 0.0;
    for (k, op) in op.iter().enumerate() {
        for instance in instances {
            sum += importer.step(*instance, k as f64, *op);
        }
    }
    (began.elapsed().as_secs_f64(), sum)
}

fn valve() -> Assembly {
    let bands = Bands::from_s_j(5.0, 2.0).unwrap();
    let mut valve = Assembly::new(Model::TwoPhase.build(bands).unwrap());
    valve.restart(Start::at_rest(0.0));
    valve
}

/// The same by the library itself.
fn direct(op: &[f64]) -> (f64, f64) {
    let mut valves = vec![valve(); INSTANCES];
    let began = Instant::now();
    let mut sum = 0.0;
    for op in op {
        for valve in &mut valves {
            sum += valve.step(black_box(*op));
        }
    }
    (began.elapsed().as_secs_f64(), sum)
}

fn main() {
    let mut op = 50.0;
    // About 50 %, with reversals and pauses.
    let wandering = |k: usize| {
        op += if k.is_multiple_of(7) { 0.0 } else { (0.05 * k as f64).sin() - 0.01 * (op - 50.0) };
        op
    };
    let op: Vec<f64> = (0..SAMPLES).map(wandering).collect();

    let fmu = Fmu::new("valve", "two-phase").unwrap();
    let resources = std::env::temp_dir().join(format!("stiction-fmu-{}", std::process::id()));
    std::fs::create_dir_all(&resources).unwrap();
    std::fs::write(resources.join("stiction.json"), fmu.json()).unwrap();
    let path = resources.display().to_string();
    let [name, token, path, uri] =
        ["valve".to_owned(), fmu.token(), path.clone(), format!("file://{path}")]
            .map(|text| CString::new(text).unwrap());
    let library = Library::own();
    // SAFETY: functions have the types of the standard; instances are alive until they are freed.
    unsafe {
        let functions = fmi2::CallbackFunctions {
            logger: None,
            allocate_memory: null_mut(),
            free_memory: null_mut(),
            step_finished: null_mut(),
            environment: null_mut(),
        };
        type Instantiate2 = unsafe extern "C" fn(
            Text,
            c_int,
            Text,
            Text,
            *const fmi2::CallbackFunctions,
            c_int,
            c_int,
        ) -> C;
        type Instantiate3 = unsafe extern "C" fn(
            Text,
            Text,
            Text,
            bool,
            bool,
            bool,
            bool,
            *const u32,
            usize,
            C,
            C,
            C,
        ) -> C;
        type Call = unsafe extern "C" fn(C) -> c_int;
        let instantiate2: Instantiate2 = library.function("fmi2Instantiate");
        let instantiate3: Instantiate3 = library.function("fmi3InstantiateCoSimulation");
        let setup: unsafe extern "C" fn(C, c_int, f64, f64, c_int, f64) -> c_int =
            library.function("fmi2SetupExperiment");
        let enter2: Call = library.function("fmi2EnterInitializationMode");
        let exit2: Call = library.function("fmi2ExitInitializationMode");
        let enter3: unsafe extern "C" fn(C, bool, f64, f64, bool, f64) -> c_int =
            library.function("fmi3EnterInitializationMode");
        let exit3: Call = library.function("fmi3ExitInitializationMode");
        let free2: unsafe extern "C" fn(C) = library.function("fmi2FreeInstance");
        let free3: unsafe extern "C" fn(C) = library.function("fmi3FreeInstance");
        let (name, token) = (name.as_ptr(), token.as_ptr());
        let two = || {
            let c = instantiate2(name, 1, token, uri.as_ptr(), &functions, 0, 0);
            assert_eq!(setup(c, 0, 0.0, 0.0, 0, 0.0) | enter2(c) | exit2(c), 0);
            c
        };
        let three = || {
            let (no, none): (bool, C) = (false, null_mut());
            let location = path.as_ptr();
            let c = instantiate3(
                name,
                token,
                location,
                no,
                no,
                no,
                no,
                none.cast(),
                0,
                none,
                none,
                none,
            );
            assert_eq!(enter3(c, no, 0.0, 0.0, no, 0.0) | exit3(c), 0);
            c
        };
        let calls2 = black_box(Two {
            set: library.function("fmi2SetReal"),
            step: library.function("fmi2DoStep"),
            get: library.function("fmi2GetReal"),
        });
        let calls3 = black_box(Three {
            set: library.function("fmi3SetFloat64"),
            step: library.function("fmi3DoStep"),
            get: library.function("fmi3GetFloat64"),
        });
        let unchecked = black_box(Two { set: bare_set, step: bare_step, get: bare_get });
        let mut best = [f64::INFINITY; 4];
        for _ in 0..ROUNDS {
            let instances2: Vec<C> = (0..INSTANCES).map(|_| two()).collect();
            let instances3: Vec<C> = (0..INSTANCES).map(|_| three()).collect();
            let mut bares: Vec<_> =
                (0..INSTANCES).map(|_| Bare { op: 0.0, vp: 0.0, valve: valve() }).collect();
            let bares: Vec<C> =
                bares.iter_mut().map(|bare| std::ptr::from_mut(bare).cast()).collect();
            let found = [
                direct(&op),
                imported(&unchecked, &bares, &op),
                imported(&calls2, &instances2, &op),
                imported(&calls3, &instances3, &op),
            ];
            for (best, (seconds, sum)) in best.iter_mut().zip(found) {
                assert_eq!(sum, found[0].1);
                *best = best.min(seconds);
            }
            instances2.into_iter().for_each(|c| free2(c));
            instances3.into_iter().for_each(|c| free3(c));
        }
        std::fs::remove_dir_all(&resources).unwrap();
        let each = 1e9 / (INSTANCES * SAMPLES) as f64;
        for (name, seconds) in ["library", "3 calls", "FMI 2.0", "FMI 3.0"].into_iter().zip(best) {
            println!("{name}  {:5.1} ns a step  {:.2} x", seconds * each, seconds / best[0]);
        }
    }
}
