//! What a visitor of the page (`bindings/web`) saves: the suite on a machine that nobody here has; and how it becomes a
//! row of the table of devices in NUMERICS.md.

use crate::golden::{self, Golden};
use crate::report::Verdict;
use conformance_cases::{Case, cases};
use rtrt_core::backend::{Backend, Picture};
use serde::{Deserialize, Serialize};

/// A saved file.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Proof {
    /// Of rtrt.
    pub version: String,
    /// SHA-256 of the shaders.
    pub shaders: String,
    /// What the browser calls itself.
    pub browser: String,
    /// The backends that ran.
    pub runs: Vec<ProofRun>,
}

/// The suite on a backend.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ProofRun {
    /// The processor's instructions, or the adapter.
    pub device: String,
    /// What is known of the driver.
    pub driver: String,
    /// How the kernels get to it.
    pub route: String,
    /// The cases.
    pub cases: Vec<ProofCase>,
    /// The hashes of buffers, as lines of `golden.txt`.
    pub hashes: Vec<String>,
}

/// A case on a backend.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ProofCase {
    /// Its name.
    pub case: String,
    /// How it ended.
    pub result: Verdict,
    /// Milliseconds.
    pub ms: f64,
    /// What differs first.
    pub detail: Option<String>,
}

/// Why a file is no evidence.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Refused {
    /// It is another file.
    #[error("this is not a file that the page saves: {0}")]
    Format(#[from] serde_json::Error),
    /// It was made by another version.
    #[error("it was made with {found}, this is {needed}")]
    Version {
        /// That of the file.
        found: String,
        /// That of this program.
        needed: String,
    },
    /// Something has not run, or differs.
    #[error("{device}: {what}")]
    Run {
        /// The device.
        device: String,
        /// What is wrong.
        what: String,
    },
    /// The table is not there.
    #[error("there is no table of devices, or the row is in it")]
    Table,
}

/// What a visitor's machine renders: the cases, and the scenes with stored hashes.
pub fn questions() -> impl Iterator<Item = &'static Case> {
    let demos = golden::scenes().iter().filter(|case| cases::named(case.name).is_none());
    cases::all().chain(demos)
}

/// Judges the picture that a backend made of a case in so many milliseconds, and adds it to the run.
///
/// # Errors
/// The reference cannot render the case.
pub fn judge(
    run: &mut ProofRun,
    case: &Case,
    rendered: Result<&Picture, String>,
    ms: f64,
) -> Result<Verdict, rtrt_core::backend::RenderError> {
    let mut expected = Picture::default();
    crate::reference().render(&(case.scene)(), &case.request(), &mut expected)?;
    let detail = match rendered {
        Ok(actual) => {
            if golden::scenes().iter().any(|scene| scene.name == case.name) {
                let mut hashes = Golden::default();
                hashes.add(case.name, actual);
                run.hashes.extend(lines(&hashes.text()).map(str::to_owned));
            }
            crate::check(case, &expected, actual).err().map(|why| why.to_string())
        }
        Err(why) => Some(why),
    };
    let result = if detail.is_none() { Verdict::Equal } else { Verdict::Differs };
    run.cases.push(ProofCase { case: case.name.into(), result, ms, detail });
    Ok(result)
}

/// The hashes of a golden file.
fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|line| !line.starts_with('#') && !line.is_empty())
}

/// The text of NUMERICS.md with a row for each run of a saved file, behind the last device of its table.
///
/// # Errors
/// The file is no evidence: it is of another version, a case was not asked or differs, or a hash is not that of the
/// repository.
pub fn accepted(file: &str, numerics: &str) -> Result<String, Refused> {
    let proof: Proof = serde_json::from_str(file)?;
    let shaders = crate::variants::shaders();
    let made_with = |version: &str, shaders: &str| format!("version {version} and the shaders {shaders}");
    let is_same =
        proof.version == env!("CARGO_PKG_VERSION") && (shaders.is_empty() || proof.shaders == shaders);
    if !is_same {
        return Err(Refused::Version {
            found: made_with(&proof.version, &proof.shaders),
            needed: made_with(env!("CARGO_PKG_VERSION"), &shaders),
        });
    }
    let mut rows = String::new();
    for run in &proof.runs {
        check(run).map_err(|what| Refused::Run { device: run.device.clone(), what })?;
        let [device, driver, route] = [&run.device, &run.driver, &run.route].map(|text| cell(text));
        let browser = cell(&proof.browser);
        rows += &format!(
            "| {device} | {driver} | {route}, in {browser} | {} cases, and all hashes of `conformance/golden.txt`: equal |\n",
            run.cases.len()
        );
    }
    let table = numerics.find(TABLE).ok_or(Refused::Table)?;
    let end = numerics[table..].find("\n\n").map(|length| table + length + 1).ok_or(Refused::Table)?;
    if rows.is_empty() || numerics[table..end].contains(&rows) {
        return Err(Refused::Table);
    }
    Ok([&numerics[..end], &rows, &numerics[end..]].concat())
}

/// The head of the table of devices.
const TABLE: &str = "| device | driver | route | result |";

/// Whether all was asked, and all is equal.
fn check(run: &ProofRun) -> Result<(), String> {
    for case in questions() {
        match run.cases.iter().find(|ran| ran.case == case.name) {
            None => return Err(format!("{} was not asked", case.name)),
            Some(ran) if ran.result != Verdict::Equal => return Err(format!("{} differs", case.name)),
            Some(_) => {}
        }
    }
    match lines(Golden::committed()).find(|line| !run.hashes.iter().any(|hash| hash == line)) {
        Some(line) => Err(format!("golden.txt has {line}, the file does not")),
        None => Ok(()),
    }
}

/// A text from elsewhere, as a cell of a table: of one line, without marks, not endless; `-` for none.
fn cell(text: &str) -> String {
    let plain = |c: char| if c.is_ascii_graphic() && !"|`<>[]*_\\".contains(c) { c } else { ' ' };
    let words: String = text.chars().take(160).map(plain).collect();
    let words: Vec<_> = words.split_whitespace().collect();
    if words.is_empty() { "-".into() } else { words.join(" ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NUMERICS: &str =
        "# N\n\n| device | driver | route | result |\n|---|---|---|---|\n| a | b | c | d |\n\nText.\n";

    /// What a machine saves that passes.
    fn proof() -> Proof {
        let case =
            |case: &Case| ProofCase { case: case.name.into(), result: Verdict::Equal, ms: 1.0, detail: None };
        let run = ProofRun {
            device: "A|GPU\n<b>".into(),
            driver: String::new(),
            route: "WebGPU".into(),
            cases: questions().map(case).collect(),
            hashes: lines(Golden::committed()).map(str::to_owned).collect(),
        };
        Proof {
            version: env!("CARGO_PKG_VERSION").into(),
            shaders: crate::variants::shaders(),
            browser: "Browser/1".into(),
            runs: vec![run],
        }
    }

    fn of(proof: &Proof) -> Result<String, Refused> {
        accepted(&serde_json::to_string(proof).unwrap(), NUMERICS)
    }

    #[test]
    fn a_machine_where_all_is_equal_becomes_a_row() {
        let count = questions().count();
        let text = of(&proof()).unwrap();
        let row = format!(
            "| a | b | c | d |\n| A GPU b | - | WebGPU, in Browser/1 | {count} cases, and all hashes of `conformance/golden.txt`: equal |\n\nText.\n"
        );
        assert!(text.ends_with(&row), "{text}");
        assert!(accepted(&serde_json::to_string(&proof()).unwrap(), &text).is_err(), "it is there already");
    }

    #[test]
    fn anything_else_is_refused_with_its_reason() {
        type Change = fn(&mut Proof);
        let changes: [(Change, &str); 6] = [
            (|proof| proof.version = "0.0.0".into(), "made with version 0.0.0"),
            (|proof| proof.runs[0].cases[3].result = Verdict::Differs, "differs"),
            (|proof| _ = proof.runs[0].cases.pop(), "was not asked"),
            (|proof| _ = proof.runs[0].hashes.pop(), "the file does not"),
            (|proof| proof.runs[0].hashes[5] += "0", "the file does not"),
            (|proof| proof.runs.clear(), "no table"),
        ];
        for (change, words) in changes {
            let mut proof = proof();
            change(&mut proof);
            let why = of(&proof).unwrap_err().to_string();
            assert!(why.contains(words), "{why}");
        }
        assert!(accepted("{}", NUMERICS).unwrap_err().to_string().contains("not a file"));
    }

    #[test]
    fn a_picture_that_differs_is_judged_so() {
        let case = cases::named("visibility/one_triangle").unwrap();
        let mut picture = Picture::default();
        crate::reference().render(&(case.scene)(), &case.request(), &mut picture).unwrap();
        let mut run = proof().runs.remove(0);
        (run.cases, run.hashes) = (vec![], vec![]);
        assert_eq!(judge(&mut run, case, Ok(&picture), 1.0).unwrap(), Verdict::Equal);
        assert!(run.hashes.iter().all(|hash| lines(Golden::committed()).any(|line| line == hash)));
        picture.pixels[9] ^= 1;
        assert_eq!(judge(&mut run, case, Ok(&picture), 1.0).unwrap(), Verdict::Differs);
        assert_eq!(judge(&mut run, case, Err("lost".into()), 1.0).unwrap(), Verdict::Differs);
    }
}
