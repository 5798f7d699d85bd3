// The ray tracer, away from the page: one message after another, each answered with its number.
import init, { Page } from "./rtrt_web.js";

const page = init().then(() => new Page());

const calls = {
  async start() {
    await page;
  },
  async gpu() {
    if (!navigator.gpu) throw new Error("this browser has no WebGPU");
    return (await page).openGpu();
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
onmessage = ({ data: { id, call, args } }) => {
  last = last.then(async () => {
    try {
      postMessage({ id, result: await calls[call](args) });
    } catch (error) {
      postMessage({ id, error: error.message ?? String(error) });
    }
  });
};
