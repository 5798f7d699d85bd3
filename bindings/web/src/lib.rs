//! What the page calls: a viewer, and the conformance suite, on the visitor's processor and GPU.
#![cfg(all(target_family = "wasm", target_os = "unknown"))]

mod proof;
mod viewer;

use conformance::proof::ProofRun;
use rtrt_core::backend::Picture;
use rtrt_cpu::Cpu;
use rtrt_gpu::Gpu;
use viewer::Shown;
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsError, JsValue};

/// The state of the page. It lives in a worker, which calls one method after another.
#[wasm_bindgen]
pub struct Page {
    cpu: Cpu,
    gpu: Option<Gpu>,
    /// What the browser tells of the GPU.
    gpu_name: String,
    shown: Option<Shown>,
    picture: Picture,
    /// What the suite has found so far: on the processor, on the GPU.
    runs: [Option<ProofRun>; 2],
}

#[wasm_bindgen]
impl Page {
    /// A page that shows nothing yet.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Result<Page, JsError> {
        console_error_panic_hook::set_once();
        let cpu = Cpu::new(rtrt_cpu::Options::default())?;
        Ok(Self {
            cpu,
            gpu: None,
            gpu_name: String::new(),
            shown: None,
            picture: Picture::default(),
            runs: [None, None],
        })
    }

    /// Takes an opened GPU, with what the browser tells of it.
    #[wasm_bindgen(js_name = takeGpu)]
    pub fn take_gpu(&mut self, OpenedGpu(gpu): OpenedGpu, name: String) {
        (self.gpu, self.gpu_name) = (Some(gpu), name);
    }
}

/// A GPU that has passed the canary.
#[wasm_bindgen]
pub struct OpenedGpu(Gpu);

/// Opens the browser's GPU, and asks it the canary, while the page goes on.
#[wasm_bindgen(js_name = openGpu)]
pub async fn open_gpu() -> Result<OpenedGpu, JsError> {
    Ok(OpenedGpu(Gpu::new_async(rtrt_gpu::Options::default()).await?))
}

/// A value as a text in JSON.
fn json(value: &impl serde::Serialize) -> Result<String, JsError> {
    Ok(serde_json::to_string_pretty(value)?)
}

/// Words of this page, as an error.
fn error(text: impl AsRef<str>) -> JsError {
    JsError::new(text.as_ref())
}

/// Bytes for JavaScript.
fn bytes(bytes: &[u8]) -> JsValue {
    js_sys::Uint8ClampedArray::from(bytes).into()
}
