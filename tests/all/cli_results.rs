//! The commands that read a result: what they write, and what they say of files that are none.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use crate::common::synthetic::{ggx, measured, result};
use gonio_embree::output::export::Format;
use gonio_embree::output::netcdf;

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("cli_results").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn gonio(folder: &PathBuf, line: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_gonio-embree");
    Command::new(program).args(line.split_whitespace()).current_dir(folder).output().unwrap()
}

fn told(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const NM: [f64; 8] = [400.0, 440.0, 480.0, 520.0, 560.0, 600.0, 640.0, 680.0];

/// The bytes of a small result.
fn bytes(scale: f64) -> Vec<u8> {
    let f = |i: &gonio_embree::light::Incidence, o: glam::DVec3, nm: f64| {
        if o.z > 0.0 { scale * ggx(i, o, [0.6, 0.6]) * nm / 680.0 } else { 0.02 }
    };
    netcdf::to_bytes(&measured(result(2, &[(0.0, 0.0), (45.0, 0.0), (80.0, 0.0)], &NM, 0.05, f))).unwrap()
}

#[test]
fn all_formats_are_written_or_refused_with_a_reason() {
    let folder = folder("formats");
    fs::write(folder.join("a.nc"), bytes(0.5)).unwrap();
    for format in Format::all() {
        let output = gonio(&folder, &format!("export a.nc --to {}", format.name()));
        let file = folder.join(format!("a-{}.{}", format.name(), format.extension()));
        if format == Format::Pbsdf {
            assert!(output.status.code() == Some(2) && told(&output).contains("--polarization mueller"));
            assert!(!file.exists());
            continue;
        }
        assert!(output.status.success(), "{format:?}: {}", told(&output));
        assert!(fs::metadata(&file).unwrap().len() > 1000 && told(&output).contains("wrote"), "{format:?}");
    }
    let one = gonio(&folder, "export a.nc --to zemax --wavelength 560 --specular-width 0 -o b.bsdf");
    assert!(one.status.success() && told(&one).contains("the specular part, up to 0.050 of the light, is left out"));
    for (line, why) in [
        ("export a.nc --to rgl --wavelength 555", "was not measured; there are 400"),
        ("export a.nc --to rgl-rgb --wavelength 560", "one wavelength has no colour"),
        ("export a.nc --to rgl --specular-width 90", "expected 0 to 60"),
        ("export none.nc --to rgl", "none.nc: cannot be read"),
    ] {
        let output = gonio(&folder, line);
        assert!(output.status.code() == Some(2) && told(&output).contains(why), "{line}: {}", told(&output));
    }
    assert!(told(&gonio(&folder, "export a.nc --to povray")).contains("klems-full"));
}

/// Truncated, empty and foreign files are told of by name, by every command that reads results.
#[test]
fn files_that_are_no_results_are_refused() {
    let folder = folder("damaged");
    let whole = bytes(0.5);
    fs::write(folder.join("half.nc"), &whole[..whole.len() / 2]).unwrap();
    fs::write(folder.join("head.nc"), &whole[..700]).unwrap();
    fs::write(folder.join("empty.nc"), b"").unwrap();
    fs::write(folder.join("foreign.nc"), b"\x89HDF\r\n\x1a\n and so on").unwrap();
    fs::write(folder.join("text.nc"), "theta,phi\n1,2\n").unwrap();
    for file in ["half.nc", "head.nc", "empty.nc", "foreign.nc", "text.nc"] {
        for line in [
            format!("scan {file} --csv"),
            format!("export {file} --to csv"),
            format!("report {file}"),
            format!("plot {file} -o a.png"),
            format!("compare {file} {file}"),
        ] {
            let output = gonio(&folder, &line);
            let told = told(&output);
            assert_eq!(output.status.code(), Some(2), "{line}: {told}");
            assert!(
                told.starts_with(&format!("error: {file}: ")) && told.contains("no result of gonio-embree"),
                "{line}: {told}"
            );
        }
    }
    let left: Vec<_> = fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left.len(), 5, "nothing is written: {left:?}");
}

#[test]
fn results_are_compared() {
    let folder = folder("compare");
    fs::write(folder.join("a.nc"), bytes(0.5)).unwrap();
    fs::write(folder.join("b.nc"), bytes(0.6)).unwrap();
    let same = gonio(&folder, "compare a.nc a.nc");
    assert!(same.status.success() && String::from_utf8_lossy(&same.stdout).contains("the results agree"));
    let other = gonio(&folder, "compare a.nc b.nc --json");
    assert_eq!(other.status.code(), Some(1));
    let document: serde_json::Value = serde_json::from_slice(&other.stdout).unwrap();
    assert!(document["agrees"] == false && document["schema"] == "gonio-comparison-1");
    assert!(document["colours"][0]["daylight"].as_f64().unwrap() > 1.0, "{document}");
}

#[test]
fn pictures_are_svg_or_png_by_their_name() {
    let folder = folder("pictures");
    fs::write(folder.join("a.nc"), bytes(0.5)).unwrap();
    for what in ["overview", "scan", "colours"] {
        for (ending, start) in [("svg", &b"<svg"[..]), ("png", b"\x89PNG")] {
            let output = gonio(&folder, &format!("plot a.nc --what {what} -o {what}.{ending}"));
            assert!(output.status.success(), "{}", told(&output));
            assert!(fs::read(folder.join(format!("{what}.{ending}"))).unwrap().starts_with(start));
        }
    }
    let output = gonio(&folder, "plot a.nc -o a.pdf");
    assert!(output.status.code() == Some(2) && told(&output).contains(".svg or .png"));
}

/// What the program itself reads at some angles, told as a measurement, has no residuals.
#[test]
fn measured_scans_lie_on_the_simulated_one() {
    let folder = folder("overlay");
    fs::write(folder.join("a.nc"), bytes(0.5)).unwrap();
    let scan = gonio(&folder, "scan a.nc --incident 45 --wavelength 560 --exit -60:60:10 --csv");
    fs::write(folder.join("own.csv"), &scan.stdout).unwrap();
    let output = gonio(&folder, "scan a.nc --incident 45 --wavelength 560 --overlay own.csv -o a.png");
    assert!(output.status.success() && told(&output).contains("χ² 0.0 of 13 points"), "{}", told(&output));
    assert!(fs::read(folder.join("a.png")).unwrap().starts_with(b"\x89PNG"));
    fs::write(folder.join("plain.csv"), "# laboratory\n10;0.3\n20;0.2\n").unwrap();
    let plain = gonio(&folder, "scan a.nc --incident 45 --wavelength 560 --overlay plain.csv --csv");
    assert!(told(&plain).contains("rms of 2 points") && String::from_utf8_lossy(&plain.stdout).contains("\n20,"));
    fs::write(folder.join("bad.csv"), "angle,value\n10,0.3\n20,much\n").unwrap();
    fs::write(folder.join("twice.csv"), "10,0.3\n10,0.4\n").unwrap();
    fs::write(folder.join("none.csv"), "# nothing\n").unwrap();
    for (line, why) in [
        ("--incident 45 --wavelength 560 --overlay bad.csv", "bad.csv:3: `much` is no number"),
        ("--incident 45 --wavelength 560 --overlay twice.csv", "twice.csv:2: there is a second value at 10°"),
        ("--incident 45 --wavelength 560 --overlay none.csv", "expected lines of angle,value"),
        ("--overlay own.csv", "one incidence and one wavelength"),
        ("--overlay gone.csv", "gone.csv: cannot be read"),
    ] {
        let output = gonio(&folder, &format!("scan a.nc {line}"));
        assert!(output.status.code() == Some(2) && told(&output).contains(why), "{line}: {}", told(&output));
    }
}
