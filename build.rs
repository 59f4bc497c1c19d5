//! Finds the machine's Embree, binds the header that is installed there, and compiles the shim.
//!
//! * `GONIO_EMBREE=require` makes a missing Embree an error, `off` does not look for it, `3` or `4` takes that
//!   version only. Default: 4, else 3, else none.
//! * `EMBREE_DIR` (or `GONIO_EMBREE_DIR`) is a prefix with `include/` and `lib/`.
//!
//! Emits `cfg(has_embree)` when the backend can be built.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(has_embree)");
    #[cfg(feature = "embree")]
    embree::build();
}

#[cfg(feature = "embree")]
mod embree {
    use std::path::{Path, PathBuf};
    use std::{env, fs, panic};

    const HOW_TO_INSTALL: &str = "apt-get install libembree-dev libclang-dev";
    /// Files that change when the system installs something (Debian, Fedora, Arch).
    const PACKAGE_LISTS: [&str; 3] =
        ["/var/lib/dpkg/status", "/usr/lib/sysimage/rpm/rpmdb.sqlite", "/var/lib/pacman/local"];
    /// Oldest version the shim is written for.
    const OLDEST: u32 = 31300;

    /// What `GONIO_EMBREE` asks for.
    #[derive(PartialEq)]
    enum Wish {
        Auto,
        Require,
        Off,
        Major(u32),
    }

    struct Installed {
        major: u32,
        version: u32,
        include: PathBuf,
        lib: Option<PathBuf>,
    }

    pub fn build() {
        for name in ["GONIO_EMBREE", "EMBREE_DIR", "GONIO_EMBREE_DIR", "CPATH", "LIBCLANG_PATH"] {
            println!("cargo::rerun-if-env-changed={name}");
        }
        for file in ["build.rs", "ffi/bare.c", "ffi/shim.c", "ffi/shim.h"] {
            println!("cargo::rerun-if-changed={file}");
        }
        let wish = wish();
        if wish == Wish::Off {
            return without("GONIO_EMBREE=off", false);
        }
        let required = wish != Wish::Auto;
        match find(&wish).and_then(|found| bind(&found).map(|()| found)) {
            Ok(found) => link(&found),
            Err(why) => without(&why, required),
        }
    }

    fn wish() -> Wish {
        match env::var("GONIO_EMBREE").as_deref() {
            Err(_) | Ok("" | "auto") => Wish::Auto,
            Ok("require") => Wish::Require,
            Ok("off") => Wish::Off,
            Ok("3") => Wish::Major(3),
            Ok("4") => Wish::Major(4),
            Ok(other) => fail(&format!("GONIO_EMBREE={other}: expected require, off, 3 or 4")),
        }
    }

    /// Goes on without Embree where another backend is there and none was demanded.
    fn without(why: &str, required: bool) {
        let fallback = env::var_os("CARGO_FEATURE_OBVHS").is_some();
        if !fallback {
            fail(&format!("{why}; {HOW_TO_INSTALL}, or build with the feature obvhs"));
        }
        if required {
            fail(&format!("{why}; {HOW_TO_INSTALL}, or unset GONIO_EMBREE to build without"));
        }
        if why != "GONIO_EMBREE=off" {
            println!("cargo::warning=building without Embree ({why}); for the faster backend: {HOW_TO_INSTALL}");
            look_again_after_installations();
        }
    }

    /// Without this, whoever follows the warning would have to touch a source file too.
    fn look_again_after_installations() {
        for list in PACKAGE_LISTS.iter().filter(|list| Path::new(list).exists()) {
            println!("cargo::rerun-if-changed={list}");
        }
    }

    fn fail(message: &str) -> ! {
        println!("cargo::error={message}");
        std::process::exit(1);
    }

    /// Looks for a header in the usual places. Neither Debian package has a pkg-config file.
    fn find(wish: &Wish) -> Result<Installed, String> {
        let majors: &[u32] = match wish {
            Wish::Major(m) => &[*m],
            _ => &[4, 3],
        };
        let prefixes = prefixes();
        for &major in majors {
            for (include, lib) in &prefixes {
                let config = include.join(format!("embree{major}/rtcore_config.h"));
                let Ok(text) = fs::read_to_string(&config) else { continue };
                let version = version(&text).ok_or_else(|| format!("no RTC_VERSION in {}", config.display()))?;
                if version < OLDEST {
                    return Err(format!("{} is Embree {version}, older than {OLDEST}", config.display()));
                }
                println!("cargo::rerun-if-changed={}", config.display());
                return Ok(Installed { major, version, include: include.clone(), lib: lib.clone() });
            }
        }
        let headers: Vec<String> = majors.iter().map(|major| format!("embree{major}/rtcore.h")).collect();
        Err(format!("no {} found", headers.join(" or ")))
    }

    /// Include directories with the library directory that goes with them, if it is not the linker's own.
    fn prefixes() -> Vec<(PathBuf, Option<PathBuf>)> {
        let mut out = Vec::new();
        let mut add_prefix = |p: &Path| {
            let lib = ["lib64", "lib"].iter().map(|d| p.join(d)).find(|d| d.is_dir());
            out.push((p.join("include"), lib));
        };
        for name in ["GONIO_EMBREE_DIR", "EMBREE_DIR"] {
            if let Some(dir) = env::var_os(name) {
                add_prefix(Path::new(&dir));
            }
        }
        let opt = fs::read_dir("/opt").into_iter().flatten().flatten();
        let mut opt: Vec<PathBuf> = opt.map(|e| e.path()).filter(|p| p.join("include").is_dir()).collect();
        opt.sort();
        opt.iter().for_each(|p| add_prefix(p));
        let searched = env::var_os("CPATH").map(|v| env::split_paths(&v).collect::<Vec<_>>()).unwrap_or_default();
        let usual = ["/usr/include", "/usr/local/include", "/opt/homebrew/include"].map(PathBuf::from);
        out.extend(searched.into_iter().chain(usual).map(|include| (include, None)));
        out
    }

    fn version(config: &str) -> Option<u32> {
        let line = config.lines().find_map(|l| l.strip_prefix("#define RTC_VERSION "))?;
        line.trim().parse().ok()
    }

    /// Runs bindgen over the installed header. libclang is loaded at run time and may be missing; bindgen
    /// panics then.
    fn bind(found: &Installed) -> Result<(), String> {
        let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR")).join("embree.rs");
        let builder = bindgen::Builder::default()
            .header("ffi/shim.h")
            .clang_arg(format!("-DGONIO_EMBREE_MAJOR={}", found.major))
            .clang_arg(format!("-I{}", found.include.display()))
            .allowlist_function("rtc(New|Release|Commit)(Device|Scene|Geometry)")
            .allowlist_function("rtc(SetDeviceErrorFunction|GetDeviceError|GetDeviceProperty)")
            .allowlist_function("rtcSetScene(Flags|BuildQuality)|rtcAttachGeometryByID")
            .allowlist_function("rtcSetGeometry(UserPrimitiveCount|UserData|BoundsFunction|IntersectFunction)")
            .allowlist_function("gonio_.*")
            .allowlist_type("RTC(Bounds|RayHit|RayHit4|RayHit8|RayHit16)|gonio_context")
            .allowlist_var("RTC_VERSION")
            .prepend_enum_name(false)
            .derive_default(true)
            .generate_comments(false);
        let silent = panic::take_hook();
        panic::set_hook(Box::new(|_| {}));
        let generated = panic::catch_unwind(panic::AssertUnwindSafe(|| builder.generate()));
        panic::set_hook(silent);
        let bindings = match generated {
            Ok(Ok(bindings)) => bindings,
            Ok(Err(e)) => return Err(format!("bindgen cannot read the Embree header: {e}")),
            Err(_) => return Err("libclang, which reads the Embree header, was not found".into()),
        };
        bindings.write_to_file(&out).map_err(|e| format!("{}: {e}", out.display()))
    }

    fn link(found: &Installed) {
        cc::Build::new()
            .files(["ffi/shim.c", "ffi/bare.c"])
            .include(&found.include)
            .define("GONIO_EMBREE_MAJOR", found.major.to_string().as_str())
            .warnings(true)
            .extra_warnings(true)
            .compile("gonio_embree_shim");
        if let Some(lib) = &found.lib {
            println!("cargo::rustc-link-search=native={}", lib.display());
            println!("cargo::rustc-link-arg=-Wl,-rpath,{}", lib.display());
        }
        println!("cargo::rustc-link-lib=dylib=embree{}", found.major);
        println!("cargo::rustc-cfg=has_embree");
        println!("cargo::rustc-env=GONIO_EMBREE_HEADER={}", found.version);
    }
}
