// The page in a real browser. Started by `bindings/web/test`.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, statSync, readdirSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join } from "node:path";
import { after, before, test } from "node:test";
import { gzipSync } from "node:zlib";
import { chromium } from "playwright-core";

const { PAGE, RTRT, SCREENSHOTS, GOLDEN, CHROMIUM } = process.env;
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm" };
// SwiftShader compiles each stage for seconds, on a busy machine longer.
const PATIENCE = 600_000;
let server, url;

before(() => {
  server = createServer((request, response) => {
    const path = new URL(request.url, "http://localhost").pathname;
    try {
      const file = readFileSync(join(PAGE, path === "/" ? "index.html" : path));
      response.writeHead(200, { "content-type": TYPES[extname(path)] ?? "text/html" }).end(file);
    } catch {
      response.writeHead(404).end();
    }
  }).listen(0, "127.0.0.1");
  url = () => `http://127.0.0.1:${server.address().port}/`;
});
after(() => server.close());

async function opened(webgpu, query, work) {
  const args = ["--no-sandbox"];
  if (webgpu) args.push("--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader");
  const ignoreDefaultArgs = webgpu ? ["--disable-gpu"] : [];
  if (!webgpu) args.push("--disable-features=WebGPU");
  const browser = await chromium.launch({ executablePath: CHROMIUM, args, ignoreDefaultArgs });
  try {
    const page = await browser.newPage({ viewport: { width: 1000, height: 1000 } });
    page.setDefaultTimeout(PATIENCE);
    const errors = [];
    page.on("pageerror", (error) => errors.push(error.message));
    await page.goto(url() + query);
    await work(page);
    assert.deepEqual(errors, []);
  } finally {
    await browser.close();
  }
}

const text = (page, id) => page.locator(`#${id}`).textContent();
const waits = (page, id, pattern) =>
  page.waitForFunction(
    ([id, source]) => new RegExp(source).test(document.getElementById(id).textContent),
    [id, pattern],
    { polling: 200 },
  );

// The words of a command line: the page quotes nothing.
function printed(command) {
  const [, ...words] = command.split(" ");
  return execFileSync(RTRT, words, { encoding: "utf8" });
}

test("the size of what is loaded", () => {
  let all = 0, zipped = 0;
  for (const name of readdirSync(PAGE)) {
    all += statSync(join(PAGE, name)).size;
    zipped += gzipSync(readFileSync(join(PAGE, name)), { level: 9 }).length;
  }
  console.log(`loaded: ${all} bytes, ${zipped} compressed by gzip`);
  assert.ok(zipped < 6_000_000);
});

test("without WebGPU the processor draws, moves and proves", { timeout: PATIENCE }, () =>
  opened(false, "?cases=visibility/one,shadow/point", async (page) => {
    await waits(page, "hash-cpu", "^[0-9a-f]{64}$");
    const first = await page.evaluate(() => performance.getEntriesByName("picture-cpu")[0].duration);
    console.log(`the first picture: ${first.toFixed(0)} ms after the page was asked for`);
    await waits(page, "gpu-note", "No GPU");
    assert.ok(await page.locator("input[value=gpu]").isDisabled());
    const hash = await text(page, "hash-cpu");
    assert.ok(printed(await text(page, "command")).includes(hash), "the command prints another hash");
    await page.locator("#picture").focus();
    await page.keyboard.press("ArrowLeft");
    await waits(page, "command", "--eye");
    const moved = await text(page, "hash-cpu");
    assert.notEqual(moved, hash);
    assert.ok(printed(await text(page, "command")).includes(moved), "the moved camera is another one there");
    await page.locator("#shadows").selectOption("off");
    await waits(page, "command", "shadows off");
    // A file is dropped: a triangle in OBJ.
    const obj = Buffer.from("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    await page.locator("#file").setInputFiles({ name: "one.obj", mimeType: "model/obj", buffer: obj });
    await waits(page, "scene-note", "1 objects, 1 triangles");
    await page.locator("#file").setInputFiles({ name: "bad.glb", mimeType: "x", buffer: Buffer.from("no") });
    await waits(page, "scene-note", "bad.glb");
    await page.locator("#run").click();
    await waits(page, "verdict", "all equal");
  }));

test("with WebGPU both give the same picture and pass the scenes with hashes", { timeout: 3 * PATIENCE }, () =>
  opened(true, `?cases=${process.env.CASES ?? "visibility/one,shadow/point,light/spot"}`, async (page) => {
    await waits(page, "gpu-note", "GPU:");
    console.log(await text(page, "gpu-note"));
    assert.match(await text(page, "gpu-note"), /^GPU: .*swiftshader/i);
    const start = Date.now();
    await page.locator("input[value=gpu]").check();
    await waits(page, "hash-gpu", "^[0-9a-f]{64}$");
    console.log(`the first picture of the GPU, shaders included: ${Date.now() - start} ms`);
    assert.equal(await text(page, "hash-gpu"), await text(page, "hash-cpu"));
    await page.screenshot({ path: join(SCREENSHOTS, "try.png") });
    await page.locator("#run").click();
    await waits(page, "verdict", "all equal|DIFFER");
    assert.match(await text(page, "verdict"), /and on .*all equal/);
    await page.screenshot({ path: join(SCREENSHOTS, "prove.png"), fullPage: true });
    const [download] = await Promise.all([page.waitForEvent("download"), page.locator("#save").click()]);
    const proof = JSON.parse(readFileSync(await download.path(), "utf8"));
    assert.equal(proof.runs.length, 2);
    const golden = readFileSync(GOLDEN, "utf8").split("\n");
    for (const run of proof.runs) {
      assert.ok(run.hashes.length > 0);
      for (const line of run.hashes) assert.ok(golden.includes(line), line);
    }
    assert.match(proof.runs[1].device, /swiftshader/i);
    // A hash that is wrong is not in the file: the comparison can fail.
    assert.ok(!golden.includes(proof.runs[0].hashes[0].replace(/.$/, "x")));
  }));
