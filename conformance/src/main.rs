//! Runs every case on every variant that this machine has.
//!
//! A line a variant: cases run and failed, or why it was skipped. Exit code 5 where a
//! backend differs from the reference, the reference from the hashes in the repository, or one is
//! missing that `RTRT_REQUIRE_GPU=1` demands.

use conformance::golden::{self, Golden};
use conformance::report::{Report, Verdict};
use conformance::variants::{all, requires_gpu};
use conformance::{Suite, cases, proof};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const USAGE: &str = "\
Runs every conformance case on everything that is present.

Options:
  --report DIR     write DIR/report.html and DIR/report.json
  --case TEXT      only cases whose names contain this
  --golden FILE    compare with these hashes instead of conformance/golden.txt
  --accept FILE    add the machine that saved FILE on the page (bindings/web) to NUMERICS.md, and run nothing else
  --regenerate     write conformance/golden.txt and run nothing else

Exit codes: 0 all equal, 1 a file cannot be read or written, 2 wrong usage, 5 something differs";

/// The arguments.
#[derive(Default)]
struct Options {
    report: Option<PathBuf>,
    case: Option<String>,
    golden: Option<PathBuf>,
    accept: Option<PathBuf>,
    regenerate: bool,
}

fn main() -> ExitCode {
    let Some(options) = options(std::env::args().skip(1)) else {
        println!("{USAGE}");
        let asked = std::env::args().any(|argument| argument == "--help");
        return ExitCode::from(if asked { 0 } else { 2 });
    };
    match run(&options) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(5),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(1)
        }
    }
}

fn options(mut arguments: impl Iterator<Item = String>) -> Option<Options> {
    let mut options = Options::default();
    while let Some(argument) = arguments.next() {
        match &argument[..] {
            "--report" => options.report = Some(arguments.next()?.into()),
            "--case" => options.case = Some(arguments.next()?),
            "--golden" => options.golden = Some(arguments.next()?.into()),
            "--accept" => options.accept = Some(arguments.next()?.into()),
            "--regenerate" => options.regenerate = true,
            _ => return None,
        }
    }
    // Hashes of some scenes alone are no golden file.
    (!options.regenerate || options.case.is_none()).then_some(options)
}

/// Adds the machine of a saved file to the repository's table of devices.
fn accept(file: &Path) -> Result<(), Box<dyn Error>> {
    let read =
        |path: &Path| std::fs::read_to_string(path).map_err(|why| format!("{}: {why}", path.display()));
    let numerics = golden::path().with_file_name("../NUMERICS.md");
    let text = proof::accepted(&read(file)?, &read(&numerics)?);
    std::fs::write(&numerics, text.map_err(|why| format!("{}: {why}", file.display()))?)?;
    println!("NUMERICS.md has the devices of {}", file.display());
    Ok(())
}

/// Whether nothing differs.
fn run(options: &Options) -> Result<bool, Box<dyn Error>> {
    if let Some(file) = &options.accept {
        return accept(file).map(|()| true);
    }
    let golden = match &options.golden {
        Some(path) => std::fs::read_to_string(path).map_err(|why| format!("{}: {why}", path.display()))?,
        None => Golden::committed().into(),
    };
    let part = options.case.as_deref().unwrap_or("");
    let (golden, mut hashes) = (Golden::parse(&golden)?.only(part), Golden::default());
    let scenes = golden::scenes().iter().filter(|scene| scene.name.contains(part));
    for (scene, _, picture) in Suite::new(scenes).pictures() {
        hashes.add(scene.name, picture);
    }
    if options.regenerate {
        std::fs::write(golden::path(), hashes.text())?;
        println!("{}: {} scenes", golden::path().display(), golden::scenes().len());
        return Ok(true);
    }
    let demos = golden::scenes().iter().filter(|case| cases::named(case.name).is_none());
    let suite = Suite::new(cases::all().chain(demos).filter(|case| case.name.contains(part)));
    if suite.pictures().next().is_none() {
        return Err(format!("no case has {part} in its name").into());
    }
    let report = Report::new(&suite, all(), &golden, &hashes, requires_gpu())?;
    print(&report);
    if let Some(folder) = &options.report {
        report.write(folder)?;
        println!("see {}", folder.join("report.html").display());
    }
    Ok(report.passed)
}

/// A line a variant, and its differences.
fn print(report: &Report) {
    for ran in &report.variants {
        if let Some(why) = &ran.skipped {
            println!("{}: {}: {why}", ran.variant, if ran.is_missing { "MISSING" } else { "skipped" });
            continue;
        }
        let count = |verdict| ran.cases.iter().filter(|case| case.result == verdict).count();
        let [failed, known] = [Verdict::Differs, Verdict::Known].map(count);
        let (variant, device, cases) = (&ran.variant, &ran.device, ran.cases.len());
        println!("{variant} ({device}): {cases} cases, {failed} failed, {known} failed as known");
        for case in ran.cases.iter().filter(|case| case.result != Verdict::Equal) {
            println!("  {}: {}", case.case, case.detail.as_deref().unwrap_or(""));
        }
    }
    for changed in &report.golden {
        println!("golden: {}: {}: {} has another hash", changed.scene, changed.stage, changed.buffer);
    }
    println!("{}", if report.passed { "all equal" } else { "something differs" });
}
