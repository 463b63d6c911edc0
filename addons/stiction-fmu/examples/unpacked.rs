//! Writes the unpacked FMU of a model: `unpacked DIRECTORY 2|3 MODEL LAW [NAME=VALUE...]`.

use std::{env, fs, path::Path};

use stiction_fmu::{Fmi, Fmu};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [directory, version, model, law, settings @ ..] = &arguments[..] else {
        return Err("usage: unpacked DIRECTORY 2|3 MODEL LAW [NAME=VALUE...]".into());
    };
    let mut fmu = Fmu::new(model, law)?;
    for setting in settings {
        let (name, value) = setting.split_once('=').ok_or("a setting is NAME=VALUE")?;
        fmu = fmu.with(name, value.parse()?)?;
    }
    fmu.check()?;
    let version = if version == "2" { Fmi::V2 } else { Fmi::V3 };
    let directory = Path::new(directory);
    fs::create_dir_all(directory.join("resources"))?;
    fs::write(directory.join("modelDescription.xml"), fmu.xml(version, None))?;
    fs::write(directory.join("resources/stiction.json"), fmu.json())?;
    let binary =
        fmu.binary(version, env::consts::ARCH, env::consts::OS).ok_or("no such platform")?;
    println!("{}", directory.join(binary).display());
    Ok(())
}
