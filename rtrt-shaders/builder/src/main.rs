//! Rebuilds `rtrt.spv` and `rtrt.manifest`; with `--check`, compares them with a rebuild instead.
//!
//! The compiler is, in this order:
//!
//! 1. what `RTRT_RUST_GPU` names: an install script, or a `librustc_codegen_spirv.so` whose toolchain is
//!    linked in rustup as `rust-gpu`;
//! 2. the install script `../shared/rust-gpu/install`, where it exists;
//! 3. upstream's: cargo-gpu fetches the nightly that rust-gpu 0.10.0 is pinned to, through rustup, and builds
//!    the compiler with it, once.
//!
//! An install script links the rustup toolchain `rust-gpu` and prints, as its last line, the path of
//! `librustc_codegen_spirv.so`.

mod finish;
#[path = "../../src/lint.rs"]
mod lint;
#[path = "../../src/manifest.rs"]
mod manifest;
mod pointers;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::{env, fs, io, process};

use anyhow::{Context, Result, bail, ensure};
use cargo_gpu_install::install::Install;
use spirv_builder::{Capability, SpirvBuilder};

/// SPIR-V 1.3, which every device of Vulkan 1.1 and later accepts.
const TARGET: &str = "spirv-unknown-vulkan1.1";

/// The environment variable of the compiler's stack, bytes.
const STACK: &str = "RUST_MIN_STACK";
/// The environment variable that names the compiler.
const COMPILER: &str = "RTRT_RUST_GPU";

fn main() -> Result<()> {
    if env::var_os(STACK).is_none() {
        // The compiler recurses along a kernel, and all that a kernel calls is inlined.
        let mut again = Command::new(env::current_exe()?);
        let status = again.args(env::args_os().skip(1)).env(STACK, "268435456").status()?;
        process::exit(status.code().unwrap_or(1));
    }
    let check = match env::args().skip(1).collect::<Vec<_>>().as_slice() {
        [] => false,
        [argument] if argument == "--check" => true,
        _ => bail!("usage: builder [--check]"),
    };
    let here = env::var_os("CARGO_MANIFEST_DIR").context("start it with `cargo run`")?;
    let root = Path::new(&here).join("../..").canonicalize()?;
    let spirv = finish::finish(&compile(&root)?)?;
    // Kept, so that a module that is refused can be looked at.
    let finished = root.join("rtrt-shaders/builder/target/finished.spv");
    fs::write(&finished, &spirv)?;
    let wrong = lint::lint(&spirv);
    ensure!(wrong.is_empty(), "{} breaks the rules of lint.rs:\n{}", finished.display(), wrong.join("\n"));
    validate(&finished)?;
    let manifest = manifest::manifest(&root, &spirv)?;

    for (name, bytes) in [("rtrt.spv", spirv.as_slice()), ("rtrt.manifest", manifest.as_bytes())] {
        let path = root.join("rtrt-shaders").join(name);
        if !check {
            fs::write(&path, bytes)?;
        } else if fs::read(&path).with_context(|| format!("{name} is missing"))? != bytes {
            bail!("the committed {name} is not what the sources give; run the builder without --check");
        }
    }
    println!("rtrt.spv: {} bytes, {}", spirv.len(), if check { "as committed" } else { "written" });
    Ok(())
}

/// The module as rust-gpu emits it, unoptimized.
fn compile(root: &Path) -> Result<Vec<u8>> {
    let crate_dir = root.join("rtrt-shaders");
    let mut builder = match install_script(root)? {
        Some(codegen) => {
            let mut builder = SpirvBuilder::new(&crate_dir, TARGET);
            builder.rustc_codegen_spirv_location = Some(codegen);
            builder.toolchain_overwrite = Some("rust-gpu".into());
            builder
        }
        None => Install::from_shader_crate(crate_dir.clone()).run()?.to_spirv_builder(&crate_dir, TARGET),
    };
    builder.build_script.defaults = false;
    builder.target_dir_path = Some(crate_dir.join("builder/target/spirv"));
    // Atomics ask for it under rust-gpu's memory model, which `finish` replaces.
    builder.capabilities.push(Capability::VulkanMemoryModelDeviceScope);
    // spirv-opt would rewrite float operations that are not decorated yet.
    builder.extra_args.push("--no-spirv-opt".into());
    Ok(fs::read(builder.build()?.module.unwrap_single())?)
}

/// The `librustc_codegen_spirv.so` of an offline compiler, or `None` if there is none here.
fn install_script(root: &Path) -> Result<Option<PathBuf>> {
    let named = env::var_os(COMPILER).map(PathBuf::from);
    let script = named.clone().unwrap_or_else(|| root.join("../shared/rust-gpu/install"));
    if !script.is_file() {
        ensure!(named.is_none(), "{COMPILER}={} is not a file", script.display());
        return Ok(None);
    }
    if script.extension().is_some_and(|extension| extension == env::consts::DLL_EXTENSION) {
        return Ok(Some(script));
    }
    let output = Command::new(&script).stderr(Stdio::inherit()).output().context("install script")?;
    ensure!(output.status.success(), "{} failed", script.display());
    let printed = String::from_utf8(output.stdout)?;
    Ok(Some(printed.lines().last().context("the install script printed nothing")?.into()))
}

/// Runs spirv-val on the finished module, where it is installed.
fn validate(finished: &Path) -> Result<()> {
    match Command::new("spirv-val").args(["--target-env", "vulkan1.1"]).arg(finished).status() {
        Ok(status) => ensure!(status.success(), "spirv-val refuses {}", finished.display()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            println!("spirv-val is not installed: not validated after the last pass");
        }
        Err(error) => return Err(error).context("spirv-val"),
    }
    Ok(())
}
