//! The report as a page that needs no other file.

use super::{CaseRan, Ran, Report, Verdict};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

const STYLE: &str = "\
body { font: 15px/1.45 system-ui, sans-serif; margin: 2em auto; max-width: 72em; padding: 0 1em; color: #222; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin-top: 2em; }
table { border-collapse: collapse; } td, th { padding: .25em .7em; text-align: left; vertical-align: top; }
tr + tr td { border-top: 1px solid #ddd; } th { border-bottom: 2px solid #888; }
img { image-rendering: pixelated; width: 9em; height: 6em; instance-fit: contain; display: block; }
figure { display: inline-block; margin: .5em 1em .5em 0; } figcaption { font-size: .85em; color: #555; }
code { font-size: .9em; } .equal { color: #17692f; } .differs, .missing { color: #b3261e; font-weight: 600; }
.known, .skipped { color: #8a6100; } .number { text-align: right; font-variant-numeric: tabular-nums; }";

impl Report {
    /// The page.
    pub fn html(&self) -> String {
        let verdict = if self.passed { ("equal", "All equal") } else { ("differs", "Something differs") };
        let mut page = format!(
            "<!doctype html>\n<html lang=en><meta charset=utf-8><title>rtrt conformance</title>\n\
             <style>{STYLE}</style>\n<h1>rtrt conformance: <span class={}>{}</span></h1>\n\
             <p>rtrt {}, {}, shaders <code>{}</code>.<br>Every buffer of every case is compared bit for bit with \
             {}.</p>\n",
            verdict.0,
            verdict.1,
            escaped(self.version),
            escaped(&self.system),
            &self.shaders[..16],
            escaped(&self.reference)
        );
        self.summary(&mut page);
        self.failures(&mut page);
        self.golden(&mut page);
        self.cases(&mut page);
        page
    }

    fn summary(&self, page: &mut String) {
        table(page, &["variant", "device", "driver", "lanes", "threads", "cases", "differ", "known", "ms"]);
        for ran in &self.variants {
            let Ran { variant, device, driver, lanes_and_threads: [lanes, threads], .. } = ran;
            let [variant, device, driver] = [variant, device, driver].map(|text| escaped(text));
            if let Some(why) = &ran.skipped {
                let (class, why) = (if ran.is_missing { "missing" } else { "skipped" }, escaped(why));
                _ = writeln!(page, "<tr><td>{variant}<td colspan=8 class={class}>{class}: {why}");
                continue;
            }
            let count = |verdict| ran.cases.iter().filter(|case| case.result == verdict).count();
            let (differ, known) = (count(Verdict::Differs), count(Verdict::Known));
            let class = if differ == 0 { "equal" } else { "differs" };
            let ms: f64 = ran.cases.iter().map(|case| case.ms).sum();
            let or_none = |number: u32| if number == 0 { "–".into() } else { number.to_string() };
            _ = writeln!(
                page,
                "<tr><td>{variant}<td>{device}<td>{driver}<td class=number>{}<td class=number>{}\
                 <td class=number>{}<td class='number {class}'>{differ}<td class='number known'>{known}\
                 <td class=number>{ms:.0}",
                or_none(*lanes),
                or_none(*threads),
                ran.cases.len()
            );
        }
        page.push_str("</table>\n");
    }

    fn failures(&self, page: &mut String) {
        for ran in &self.variants {
            for case in ran.cases.iter().filter(|case| case.result != Verdict::Equal) {
                let class = if case.result == Verdict::Known { "known" } else { "differs" };
                let [name, variant] = [case.case, &ran.variant].map(escaped);
                _ = writeln!(page, "<h2><span class={class}>{name}</span> on {variant}</h2>");
                if let Some(why) = case.known {
                    _ = writeln!(page, "<p class=known>Known: {}</p>", escaped(why));
                }
                if let Some(stage) = case.stage {
                    _ = writeln!(page, "<p>First different stage: <b>{stage}</b>.</p>");
                }
                _ = writeln!(page, "<p><code>{}</code></p>", escaped(case.detail.as_deref().unwrap_or("")));
                for (name, png) in &case.pictures {
                    _ = writeln!(page, "<figure>{}<figcaption>{name}</figcaption></figure>", image(png));
                }
            }
        }
    }

    fn golden(&self, page: &mut String) {
        page.push_str("<h2>Hashes in the repository</h2>\n");
        if self.golden.is_empty() {
            let count = crate::golden::scenes().len();
            _ = writeln!(page, "<p class=equal>The reference's hashes of {count} scenes are those.</p>");
            return;
        }
        table(page, &["scene", "first different stage", "buffer", "repository", "here"]);
        for changed in &self.golden {
            let [scene, expected, actual] =
                [&changed.scene, &changed.expected, &changed.actual].map(|text| escaped(text));
            let short = |hash: &str| hash.chars().take(16).collect::<String>();
            _ = writeln!(
                page,
                "<tr><td>{scene}<td class=differs>{}<td>{}<td><code>{}</code><td><code>{}</code>",
                changed.stage,
                changed.buffer,
                short(&expected),
                short(&actual)
            );
        }
        page.push_str("</table>\n");
    }

    fn cases(&self, page: &mut String) {
        page.push_str("<h2>Cases, and milliseconds on each variant</h2>\n");
        let ran: Vec<&Ran> = self.variants.iter().filter(|ran| ran.skipped.is_none()).collect();
        let mut head = vec!["reference", "case"];
        head.extend(ran.iter().map(|ran| &ran.variant[..]));
        table(page, &head);
        for (number, (name, claim, png)) in self.pictures.iter().enumerate() {
            let [name, claim] = [name, claim].map(|text| escaped(text));
            _ = write!(page, "<tr><td>{}<td><b>{name}</b><br>{claim}", image(png));
            for CaseRan { result, ms, .. } in ran.iter().filter_map(|ran| ran.cases.get(number)) {
                let (class, mark) = match result {
                    Verdict::Equal => ("equal", "="),
                    Verdict::Differs => ("differs", "≠"),
                    Verdict::Known => ("known", "≠, known"),
                };
                _ = write!(page, "<td class='number {class}'>{mark} {ms:.1}");
            }
            page.push('\n');
        }
        page.push_str("</table>\n");
    }
}

/// The head of a table.
fn table(page: &mut String, columns: &[&str]) {
    let head: String = columns.iter().map(|column| format!("<th>{}", escaped(column))).collect();
    _ = writeln!(page, "<table><tr>{head}");
}

/// A picture within the page.
fn image(png: &[u8]) -> String {
    format!("<img alt='' src='data:image/png;base64,{}'>", STANDARD.encode(png))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
