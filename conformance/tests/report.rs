//! The report, and that it is red when it has to be.

use conformance::golden::{self, Golden};
use conformance::report::{Report, Verdict};
use conformance::variants::{Missing, Variant};
use conformance::{Suite, cases, reference};
use rtrt_core::backend::{Backend, Description, Picture, RenderError, Request};
use rtrt_core::scene::Scene;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

const CASE: &str = "shadow/point";

/// Renders as the reference does, but for one bit of one ray's light.
struct OneBitOff(rtrt_cpu::Cpu);

impl Backend for OneBitOff {
    fn describe(&self) -> Description {
        Description { kind: "off".into(), adapter: "one <bit> off".into(), ..self.0.describe() }
    }
    fn render(
        &mut self,
        scene: &Scene,
        request: &Request<'_>,
        picture: &mut Picture,
    ) -> Result<(), RenderError> {
        self.0.render(scene, request, picture)?;
        let lit = &mut picture.deferred.as_mut().unwrap().lit[400];
        lit.diffuse[1] = f32::from_bits(lit.diffuse[1].to_bits() ^ 1);
        picture.pixels[7] ^= 1;
        Ok(())
    }
}

fn variants() -> Vec<Variant> {
    let missing = Missing { reason: "there is none".into(), is_required: true };
    vec![
        Variant { name: "off", backend: Ok(Box::new(OneBitOff(reference()))) },
        Variant { name: "gone", backend: Err(missing) },
    ]
}

#[test]
fn a_difference_is_red_and_names_its_stage_and_pixel() {
    let suite = Suite::new(cases::named(CASE));
    let none = Golden::default();
    let report = Report::new(&suite, variants(), &none, &none, false).unwrap();
    assert!(!report.passed);
    let case = &report.variants[0].cases[0];
    assert_eq!((case.result, case.stage), (Verdict::Differs, Some("light")));
    let html = report.html();
    let [x, y] = case.pixel.unwrap();
    for part in [
        CASE,
        "First different stage: <b>light</b>",
        &format!("lit.diffuse.g at pixel {x},{y} "),
        "one &lt;bit&gt; off",
        "skipped: there is none",
        "<figcaption>difference</figcaption>",
        "data:image/png;base64,",
    ] {
        assert!(html.contains(part), "{part} is not in the report");
    }
    assert!(!html.contains("http") && !html.contains("src='/") && !html.contains("<script"));
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report");
    report.write(&folder).unwrap();
    let json: Value = serde_json::from_slice(&std::fs::read(folder.join("report.json")).unwrap()).unwrap();
    assert_eq!(json["passed"], false);
    assert_eq!(json["variants"][0]["cases"][0]["stage"], "light");
    assert_eq!(json["variants"][1]["skipped"], "there is none");
}

#[test]
fn what_is_missing_is_red_where_it_is_required() {
    let suite = Suite::new(cases::named(CASE));
    let none = Golden::default();
    let passed = |variant: usize, requires_gpu| {
        let variants = variants().into_iter().skip(variant).take(1).collect();
        Report::new(&suite, variants, &none, &none, requires_gpu).unwrap().passed
    };
    assert_eq!([passed(1, false), passed(1, true), passed(0, false)], [true, false, false]);
}

#[test]
fn the_hashes_in_the_repository_are_the_references() {
    let mut hashes = Golden::default();
    for (case, _, picture) in Suite::new(golden::scenes()).pictures() {
        hashes.add(case.name, picture);
    }
    let committed = Golden::parse(Golden::committed()).unwrap();
    let changes = committed.changes(&hashes);
    assert!(changes.is_empty(), "after a change that is meant to be seen: --regenerate\n{changes:#?}");
    assert_eq!(Golden::committed(), hashes.text());
    assert_eq!(Golden::parse("a b\n").unwrap_err().line, 1);
}

#[test]
fn another_hash_is_exit_code_5_and_names_its_stage() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("golden");
    std::fs::create_dir_all(&folder).unwrap();
    // Hits of another machine, and the buffers that depend on them.
    let file = folder.join("other.txt");
    let other = ["hits", "colors", "pixels"].iter().fold(Golden::committed().to_owned(), |text, buffer| {
        let place = format!("shadow/point {buffer} ");
        text.replace(&place, &format!("{place}0"))
    });
    std::fs::write(&file, other).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_conformance"));
    command.arg("--golden").arg(&file).arg("--report").arg(&folder).args(["--case", "shadow/point"]);
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(5), "{said}");
    assert!(said.contains("golden: shadow/point: visibility: hits has another hash"), "{said}");
    let html = std::fs::read_to_string(folder.join("report.html")).unwrap();
    assert!(html.contains("<tr><td>shadow/point<td class=differs>visibility<td>hits"));
}
