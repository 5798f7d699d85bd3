// The ray tracer, away from the page: one message after another, each answered with its number.
import init, { Page, openGpu } from "./rtrt_web.js";

const page = init({ module_or_path: new URL("rtrt_web_bg.wasm", import.meta.url) }).then(() => new Page());

const calls = {
  async take({ gpu, name }) {
    (await page).takeGpu(gpu, name);
    return name;
  },
  async show({ name, file, width, height }) {
    return (await page).show(name, new Uint8Array(file ?? 0), width, height);
  },
  async home({ width, height }) {
    (await page).home(width, height);
  },
  async render({ gpu, width, height, samples, exposure, shadows, yaw, pitch, nearer }) {
    const here = await page;
    if (yaw || pitch || nearer) here.orbit(yaw, pitch, nearer);
    const frame = await here.render(gpu, width, height, samples, exposure, shadows);
    const { pixels, hash, ms, command } = frame;
    frame.free();
    return { pixels, hash, ms, command, width, height };
  },
  async cases() {
    return (await page).cases();
  },
  async begin({ gpu }) {
    return (await page).begin(gpu);
  },
  async ask({ gpu, name }) {
    return (await (await page).ask(gpu, name)) ?? null;
  },
  async proof() {
    return (await page).proof(navigator.userAgent);
  },
};

let last = Promise.resolve();
const next = (call, args) => {
  const result = last.then(() => calls[call](args));
  last = result.catch(() => {});
  return result;
};

// Frames go on while the GPU opens.
async function gpu() {
  if (!navigator.gpu) throw new Error("this browser has no WebGPU");
  await page;
  const gpu = await openGpu();
  // What wgpu tells is the description, which browsers leave empty.
  const { vendor, architecture, device, description } = (await navigator.gpu.requestAdapter()).info;
  const name = [vendor, architecture, device, description].filter(Boolean).join(" ") || "a GPU without a name";
  return next("take", { gpu, name });
}

onmessage = async ({ data: { id, call, args } }) => {
  try {
    postMessage({ id, result: await (call === "gpu" ? gpu() : next(call, args)) });
  } catch (error) {
    postMessage({ id, error: error.message ?? String(error) });
  }
};
