//! The conformance suite, a case at a time.

use crate::{Page, error, json};
use conformance::proof::{Proof, ProofRun, judge, questions};
use conformance::report::Verdict;
use rtrt_core::backend::Backend;
use rtrt_gpu::Gpu;
use wasm_bindgen::JsError;
use wasm_bindgen::prelude::wasm_bindgen;
use web_time::Instant;

#[wasm_bindgen]
impl Page {
    /// The names of all cases.
    pub fn cases(&self) -> Vec<String> {
        questions().map(|case| case.name.to_owned()).collect()
    }

    /// Begins the suite, on the processor or the GPU. Gives the device.
    pub fn begin(&mut self, on_gpu: bool) -> Result<String, JsError> {
        let driver = self.gpu.as_ref().map(Gpu::driver);
        let (device, driver, route) = match (on_gpu, driver) {
            (true, Some(driver)) => (self.gpu_name.clone(), driver, "naga, WebGPU"),
            (true, None) => return Err(error("there is no GPU")),
            (false, _) => {
                let processor = self.cpu.describe();
                (
                    format!("{}, {} lanes", processor.adapter, processor.lanes),
                    String::new(),
                    "WebAssembly, simd128",
                )
            }
        };
        let (name, route) = (device.clone(), route.into());
        self.runs[usize::from(on_gpu)] =
            Some(ProofRun { device, driver, route, cases: vec![], hashes: vec![] });
        Ok(name)
    }

    /// Asks a case. Gives nothing if it is equal, else what differs.
    pub async fn ask(&mut self, on_gpu: bool, name: &str) -> Result<Option<String>, JsError> {
        let case =
            questions().find(|case| case.name == name).ok_or_else(|| error("there is no such case"))?;
        let Self { cpu, gpu, picture, runs, .. } = self;
        let scene = (case.scene)();
        let start = Instant::now();
        let rendered = match (on_gpu, gpu) {
            (false, _) => cpu.render(&scene, &case.request(), picture),
            (true, Some(gpu)) => gpu.render_async(&scene, &case.request(), picture).await,
            (true, None) => return Err(error("there is no GPU")),
        };
        let ms = start.elapsed().as_secs_f64() * 1e3;
        let run = runs[usize::from(on_gpu)].as_mut().ok_or_else(|| error("the suite has not begun"))?;
        let rendered = rendered.map(|()| &*picture).map_err(|why| why.to_string());
        let verdict = judge(run, case, rendered, ms)?;
        let detail = run.cases.last().and_then(|ran| ran.detail.clone());
        Ok(detail.filter(|_| verdict != Verdict::Equal))
    }

    /// The file that `conformance -- --accept FILE` takes.
    pub fn proof(&self, browser: &str) -> Result<String, JsError> {
        json(&Proof {
            version: env!("CARGO_PKG_VERSION").into(),
            shaders: rtrt::hash::of(rtrt_gpu::SHADERS),
            browser: browser.into(),
            runs: self.runs.iter().flatten().cloned().collect(),
        })
    }
}
