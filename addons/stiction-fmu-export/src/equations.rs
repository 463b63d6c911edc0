//! The equations of a model for its page.

use stiction_model::stem::friction::LAWS;
use stiction_model::valve::Model as Law;

/// Text about the laws: equations and their source.
pub struct Equations {
    /// Line by line.
    pub text: &'static str,
    /// The symbols.
    pub symbols: String,
    /// Source.
    pub source: &'static str,
}

const VALVE: &str = "u = OP and x = VP at sample k, fd = (S - J)/2, fs = (S + J)/2, d the direction of motion (+1 or -1)";
const STEM: &str = "p0 and p100 air pressure at 0 and 100 % OP, x position, v velocity, p air pressure, M mass, k spring, A area of the diaphragm, F0 preload, Fs static, Fc \
     Coulomb and Fv viscous friction, vs Stribeck velocity";

/// The balance of forces of every stem.
pub const BALANCE: &str = "\
M dv/dt = A p - k x - F0 - F,   dx/dt = v
tau dp/dt = demand - p, or p = demand without an air lag
demand = min(p0 + OP/100 (p100 - p0), supply)";

/// Controller and process around a valve in a loop.
pub const LOOP: &str = "\
OP = Kc (e + integral of e / Ti - Td dPV/dt),   e = SP - PV,   sampled
tau dy/dt = -y + gain (VP + load)(t - dead time),   PV = y + noise
a second lag follows if tau2 is given";

/// The equations of a law of a valve or of friction.
pub fn of(model: &str, law: &str) -> Equations {
    let text = match law {
        "chen" => {
            "moving, u goes on in direction d    x = u - d fd\n\
             moving, otherwise                   x stays; it is stuck from the next sample\n\
             stuck, |u - x| > fs                 d = sgn(u - x),  x = u - d fd   it slips\n\
             stuck, otherwise                    x stays"
        }
        "two-phase" | "kano" => {
            "moving, u goes on in direction d    x = u - d fd\n\
             otherwise, |u - x| > fs             d = sgn(u - x),  x = u - d fd   it slips\n\
             otherwise                           x stays                         it is stuck"
        }
        "choudhury" => {
            "moving, u goes on in direction d    x = u - d fd\n\
             turning, |u - x| > fs               breaks away\n\
             stuck, going on, |u - us| > J       breaks away   (us: u at which it stopped)\n\
             breaking away                       x = u - d fd;   otherwise x stays"
        }
        "he" => "|u - x| > fs    x = u - sgn(u - x) fd\notherwise       x stays",
        "he-wang" => "|u - x| > fs    x = x + K (u - x - sgn(u - x) fd)\notherwise       x stays",
        "stenman" => "|u - x| > J    x = u\notherwise      x stays",
        "play" => "x = x limited to u - S/2 ... u + S/2",
        "ideal" => "x = u",
        "classical" => {
            "moving     F = [Fc + (Fs - Fc) exp(-(v/vs)^2)] sgn v + Fv v\n\
             at rest    F = the force that acts, up to Fs"
        }
        "karnopp" => {
            "moving        F = [Fc + (Fs - Fc) exp(-(v/vs)^2)] sgn v + Fv v\n\
             |v| < band    at rest, F = the force that acts, up to Fs"
        }
        "dahl" => "dz/dt = v - s0 |v| z / Fc,   F = s0 z + Fv v",
        "lugre" => {
            "dz/dt = v - |v| z / g,   g = [Fc + (Fs - Fc) exp(-(v/vs)^2)] / s0\n\
             F = s0 z + s1 dz/dt + Fv v"
        }
        "gms" => {
            "F = sum of Fi + Fv v,   Fi = ki zi + ni dzi/dt,   s = Fc + (Fs - Fc) exp(-(v/vs)^2)\n\
             element i sticks    dzi/dt = v, until Fi sgn v > ai s\n\
             element i slips     dzi/dt = C ai / ki (sgn v - Fi / (ai s)), until v changes its sign"
        }
        _ => {
            "presliding    F = kt (x - anchor), until |F| > Fc + Fs(t2) after a rest of t2\n\
             sliding       F = {Fc + Fv |v| + Fs(t2) / (1 + [v(t - tL) / vs]^2)} sgn v"
        }
    };
    let symbols = match law {
        "dahl" | "lugre" => "; z deflection of the bristles, s0 their stiffness, s1 their damping",
        "gms" => {
            "; zi deflection of element i, ki its stiffness, ni its damping, ai its share, C attraction"
        }
        "armstrong" => "; kt presliding stiffness, tL frictional memory",
        _ => "",
    };
    let (of_model, source) = if model == "stem" {
        let entry = LAWS.iter().find(|entry| entry.name == law);
        (STEM, entry.map_or("", |entry| entry.source))
    } else {
        (VALVE, Law::by_name(law).map_or("", |law| law.describe().citation))
    };
    Equations { text, symbols: format!("{of_model}{symbols}"), source }
}
