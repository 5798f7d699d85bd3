//! Builds the page: `cargo run --release --manifest-path bindings/web/builder/Cargo.toml [FOLDER]`. The files in the
//! folder (`target/page` by default) are all that a server of static files needs.

use anyhow::{Context, Result, bail, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};
use wasm_bindgen_cli_support::Bindgen;

const TARGET: &str = "wasm32-unknown-unknown";
/// Packages that are compiled for speed: they build trees and textures, and render. Of others the size counts.
const FAST: [&str; 4] = ["libm", "rtrt", "rtrt-core", "rtrt-cpu"];

fn main() -> Result<()> {
    let here = env::var_os("CARGO_MANIFEST_DIR").context("start it with `cargo run`")?;
    let root = Path::new(&here).join("../../..").canonicalize()?;
    let target = env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    let out = match env::args_os().skip(1).collect::<Vec<_>>().as_slice() {
        [] => target.join("page"),
        [folder] => PathBuf::from(folder),
        _ => bail!("usage: builder [FOLDER]"),
    };
    // rustup has it, or the toolchain came with it.
    let _ = Command::new("rustup").args(["target", "add", TARGET]).current_dir(&root).status();
    let fast = FAST.map(|package| format!("--config=profile.release.package.{package}.opt-level=3"));
    let built = Command::new("cargo")
        .args(["build", "--release", "--locked", "-p", "rtrt-web", "--target", TARGET])
        .arg("--config=profile.release.opt-level=\"s\"")
        .args(fast)
        .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS", "-C target-feature=+simd128")
        .env("CARGO_TARGET_DIR", &target)
        .current_dir(&root)
        .status()?;
    ensure!(built.success(), "cargo could not build rtrt-web");
    fs::create_dir_all(&out)?;
    let module = target.join(TARGET).join("release/rtrt_web.wasm");
    let mut bindgen = Bindgen::new();
    // Names of functions are half of the file.
    bindgen.remove_name_section(true).remove_producers_section(true);
    bindgen.input_path(module).web(true)?.typescript(false).generate(&out)?;
    for file in fs::read_dir(root.join("bindings/web/page"))? {
        let file = file?;
        fs::copy(file.path(), out.join(file.file_name()))?;
    }
    for file in fs::read_dir(&out)? {
        let file = file?;
        println!("{:>9} bytes  {}", file.metadata()?.len(), file.path().display());
    }
    Ok(())
}
