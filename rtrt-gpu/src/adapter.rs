//! Which adapters there are, and which to take.

use crate::canary;
use crate::device::Device;
use crate::error::Error;
use crate::info::{Kind, Route, has_passthrough, label};
use crate::instance::windowless;
use crate::wait::Waiting;

/// Which adapter to open, and how.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// A part of the adapter's name, in any case, or its number among [`adapters`]; `None` for the first that
    /// can be used.
    pub adapter: Option<String>,
    /// How the module gets to it.
    pub route: Route,
    /// The most bytes that a buffer of per-ray results may have, if that is to be less than what the device
    /// allows.
    pub band_bytes: Option<u64>,
}

/// An adapter that is there. It is not opened yet, and may turn out to be of no use.
#[derive(Debug)]
pub struct Adapter {
    raw: wgpu::Adapter,
    /// Its name.
    pub name: String,
    /// The interface it is reached through.
    pub api: String,
    /// What it is.
    pub kind: Kind,
    /// The driver and its version.
    pub driver: String,
    /// Whether it takes unchanged SPIR-V, which keeps every rounding in place.
    pub passthrough: bool,
}

impl Adapter {
    fn new(raw: wgpu::Adapter) -> Self {
        let info = raw.get_info();
        Self {
            api: info.backend.to_string(),
            kind: Kind::new(info.device_type),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
            passthrough: has_passthrough(&info, raw.features()),
            name: info.name,
            raw,
        }
    }

    /// Opens it, by the route that [`Route::Auto`] takes, and asks it the canary.
    pub(crate) async fn device(&self, waiting: Waiting) -> Result<Device, Error> {
        open(&self.raw, Route::Auto, waiting).await
    }
}

/// All adapters in the order in which [`crate::Gpu::new`] would try them; none is opened.
/// `WGPU_BACKEND` and `WGPU_POWER_PREF` in the environment have the meaning that wgpu gives them. Their
/// position here is their number in [`Options::adapter`].
#[cfg(not(target_arch = "wasm32"))]
pub fn adapters() -> Vec<Adapter> {
    pollster::block_on(adapters_async())
}

/// [`adapters`] without blocking. In a browser it is one at most: the one that the browser gives.
pub async fn adapters_async() -> Vec<Adapter> {
    enumerate(wanted()).await.into_iter().map(Adapter::new).collect()
}

/// Adapters that are there, but not among [`adapters`], each with why: `WGPU_BACKEND` in the environment
/// leaves them out.
#[cfg(not(target_arch = "wasm32"))]
pub fn left_out() -> Vec<String> {
    pollster::block_on(excluded())
}

/// [`left_out`] without blocking.
async fn excluded() -> Vec<String> {
    let Ok(value) = std::env::var("WGPU_BACKEND") else { return Vec::new() };
    let Some(wanted) = wgpu::Backends::from_env() else { return Vec::new() };
    let adapters = enumerate(KNOWN - wanted).await;
    let label = |adapter: &wgpu::Adapter| label(&adapter.get_info());
    adapters.iter().map(|adapter| format!("WGPU_BACKEND={value} leaves out {}", label(adapter))).collect()
}

/// Opens the adapter that the options ask for, or else the first that can be used.
pub(crate) async fn choose(options: &Options, waiting: Waiting) -> Result<Device, Error> {
    let adapters = enumerate(wanted()).await;
    let Some(wanted) = &options.adapter else {
        let mut tried = Vec::new();
        for adapter in &adapters {
            match open(adapter, options.route, waiting).await {
                Ok(device) => return Ok(device),
                Err(error) => tried.push(error.to_string()),
            }
        }
        tried.extend(excluded().await);
        return Err(Error::NoAdapter { tried });
    };
    let named =
        |adapter: &&wgpu::Adapter| label(&adapter.get_info()).to_lowercase().contains(&wanted.to_lowercase());
    let numbered = wanted.parse().ok().and_then(|number: usize| adapters.get(number));
    match numbered.or_else(|| adapters.iter().find(named)) {
        Some(adapter) => open(adapter, options.route, waiting).await,
        None => {
            let names = adapters.iter().map(|adapter| label(&adapter.get_info()));
            Err(Error::AdapterNotFound {
                wanted: wanted.clone(),
                names: names.chain(excluded().await).collect(),
            })
        }
    }
}

/// Opens the adapter and asks it the canary.
async fn open(adapter: &wgpu::Adapter, route: Route, waiting: Waiting) -> Result<Device, Error> {
    let device = Device::open(adapter, route, waiting).await?;
    canary::check(&device).await?;
    Ok(device)
}

/// The interfaces that a renderer may use.
const KNOWN: wgpu::Backends = wgpu::Backends::VULKAN
    .union(wgpu::Backends::METAL)
    .union(wgpu::Backends::DX12)
    .union(wgpu::Backends::BROWSER_WEBGPU);

/// Those of them that `WGPU_BACKEND` in the environment names, or all.
fn wanted() -> wgpu::Backends {
    wgpu::Backends::from_env().map_or(KNOWN, |wanted| wanted & KNOWN)
}

/// All adapters that are reached through one of these, the most promising first. With `WGPU_POWER_PREF=low` in
/// the environment, integrated GPUs come before discrete ones.
async fn enumerate(backends: wgpu::Backends) -> Vec<wgpu::Adapter> {
    let mut adapters = windowless(backends).enumerate_adapters(backends).await;
    let saves_power = wgpu::PowerPreference::from_env() == Some(wgpu::PowerPreference::LowPower);
    adapters.sort_by_key(|adapter| match Kind::new(adapter.get_info().device_type) {
        kind @ (Kind::Discrete | Kind::Integrated) => {
            (Kind::Discrete, saves_power == (kind == Kind::Discrete))
        }
        kind => (kind, false),
    });
    adapters
}
