//! What a machine makes of the suite, for people (HTML) and for programs (JSON).

mod html;

use crate::golden::{Changed, Golden};
use crate::suite::{Failed, Failure, Suite};
use crate::variants::{Missing, Variant, driver, shaders};
use rtrt_core::backend::Description;
use rtrt_core::compare::Place;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::Path;

/// What came of everything.
#[derive(Debug, Serialize)]
pub struct Report {
    /// Of rtrt.
    pub version: &'static str,
    /// SHA-256 of the shaders; empty without the feature `gpu`.
    pub shaders: String,
    /// Operating system and processor architecture.
    pub system: String,
    /// What the others are compared with.
    pub reference: String,
    /// Whether nothing differs, and nothing that is required is missing.
    pub passed: bool,
    /// Where the reference's hashes are not those of the repository.
    pub golden: Vec<Changed>,
    /// The ways to run.
    pub variants: Vec<Ran>,
    /// A picture of each case, as PNG.
    #[serde(skip)]
    pictures: Vec<(&'static str, &'static str, Vec<u8>)>,
}

/// What came of one way to run.
#[derive(Debug, Serialize)]
pub struct Ran {
    /// What it is.
    pub variant: String,
    /// The processor or adapter.
    pub device: String,
    /// The adapter's driver.
    pub driver: String,
    /// Lanes and threads; 0 where that is not the backend's choice.
    pub lanes_and_threads: [u32; 2],
    /// Why it did not run, if it did not.
    pub skipped: Option<String>,
    /// Whether that is a failure here.
    pub is_missing: bool,
    /// Its cases.
    pub cases: Vec<CaseRan>,
}

/// What came of a case.
#[derive(Debug, Serialize)]
pub struct CaseRan {
    /// The case.
    pub case: &'static str,
    /// How it ended.
    pub result: Verdict,
    /// Milliseconds.
    pub ms: f64,
    /// What differs first, or why there is no picture.
    pub detail: Option<String>,
    /// Why it is known to differ, if it is.
    pub known: Option<&'static str>,
    /// The stage to blame.
    pub stage: Option<&'static str>,
    /// Column and row of the first pixel that differs.
    pub pixel: Option<[u32; 2]>,
    /// The pictures that were expected and found, and where they differ, as PNG.
    #[serde(skip)]
    pictures: Vec<(&'static str, Vec<u8>)>,
}

/// How a case ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Every buffer has the same bits.
    Equal,
    /// It does not.
    Differs,
    /// It does not, as is known of this device.
    Known,
}

impl Report {
    /// Runs the suite on every variant. `golden` holds the hashes of the repository, `hashes` those of the
    /// reference here; `requires_gpu` says that a missing GPU is a failure.
    pub fn new(
        suite: &Suite,
        variants: Vec<Variant>,
        golden: &Golden,
        hashes: &Golden,
        requires_gpu: bool,
    ) -> io::Result<Self> {
        let golden = golden.changes(hashes);
        let ran = variants.into_iter().map(|variant| Ran::new(suite, variant, requires_gpu));
        let variants = ran.collect::<io::Result<Vec<_>>>()?;
        let differs = |ran: &Ran| ran.is_missing || ran.cases.iter().any(|c| c.result == Verdict::Differs);
        let mut pictures = vec![];
        for (case, _, picture) in suite.pictures() {
            pictures.push((case.name, case.claim, crate::image::png(picture)?.unwrap_or_default()));
        }
        Ok(Self {
            version: env!("CARGO_PKG_VERSION"),
            shaders: shaders(),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            reference: "the CPU, 1 lane, 1 thread".into(),
            passed: golden.is_empty() && !variants.iter().any(differs),
            golden,
            variants,
            pictures,
        })
    }

    /// Writes `report.html`, which needs no other file, and `report.json`.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        std::fs::create_dir_all(folder)?;
        std::fs::write(folder.join("report.html"), self.html())?;
        std::fs::write(folder.join("report.json"), serde_json::to_string_pretty(self)?)
    }
}

impl Ran {
    fn new(suite: &Suite, Variant { name, backend }: Variant, requires_gpu: bool) -> io::Result<Self> {
        let none = Self {
            variant: name.into(),
            device: String::new(),
            driver: String::new(),
            lanes_and_threads: [0; 2],
            skipped: None,
            is_missing: false,
            cases: vec![],
        };
        let mut backend = match backend {
            Ok(backend) => backend,
            Err(Missing { reason, is_required }) => {
                let is_missing = is_required && requires_gpu;
                return Ok(Self { skipped: Some(reason), is_missing, ..none });
            }
        };
        let Description { adapter, lanes, threads, .. } = backend.describe();
        let outcome = match suite.run(backend.as_mut()) {
            Ok(outcome) => outcome,
            Err(itself) => {
                return Ok(Self { skipped: Some(itself.to_string()), is_missing: true, ..none });
            }
        };
        let driver = driver(&adapter);
        let mut cases = vec![];
        for ((case, ..), ms) in suite.pictures().zip(outcome.times_ms) {
            let is_this = |failed: &&Failed| failed.case.name == case.name;
            let failed = outcome.failures.iter().find(is_this).map(|failed| (Verdict::Differs, failed));
            let known = outcome.known.iter().find(is_this).map(|failed| (Verdict::Known, failed));
            cases.push(CaseRan::new(case.name, ms, failed.or(known))?);
        }
        Ok(Self { device: adapter, driver, lanes_and_threads: [lanes, threads], cases, ..none })
    }
}

impl CaseRan {
    fn new(case: &'static str, ms: f64, failed: Option<(Verdict, &Failed)>) -> io::Result<Self> {
        let Some((result, failed)) = failed else {
            return Ok(Self {
                case,
                result: Verdict::Equal,
                ms,
                detail: None,
                known: None,
                stage: None,
                pixel: None,
                pictures: vec![],
            });
        };
        let (stage, pixel) = match &failed.failure {
            Failure::Different(difference) => (
                Some(difference.stage),
                match difference.place {
                    Place::Ray { pixel, .. } => Some(pixel),
                    _ => None,
                },
            ),
            _ => (None, None),
        };
        let mut pictures = vec![];
        for (name, picture) in crate::image::pictures(failed) {
            pictures.extend(crate::image::png(&picture)?.map(|png| (name, png)));
        }
        let known = failed.case.known.map(|known| known.why).filter(|_| result == Verdict::Known);
        let detail = Some(failed.failure.to_string());
        Ok(Self { case, result, ms, detail, known, stage, pixel, pictures })
    }
}
