// The page: what is pressed and dragged becomes messages to the worker.
const at = (id) => document.getElementById(id);
const worker = new Worker("worker.js", { type: "module" });
const open = new Map();
let messages = 0;

worker.onmessage = ({ data: { id, result, error } }) => {
  const { resolve, reject } = open.get(id);
  open.delete(id);
  error === undefined ? resolve(result) : reject(new Error(error));
};
worker.onerror = (event) => say(`The ray tracer cannot start: ${event.message}`);

function call(name, args = {}, transfer = []) {
  const id = messages++;
  worker.postMessage({ id, call: name, args }, transfer);
  return new Promise((resolve, reject) => open.set(id, { resolve, reject }));
}

function say(text) {
  at("status").textContent = text;
}

const canvas = at("picture");
const size = { width: canvas.width, height: canvas.height };
const chosen = () => document.querySelector("input[name=on]:checked").value;
// Moves of the camera that no frame has yet.
let move = { yaw: 0, pitch: 0, nearer: 0 };
let isWanted = false;
let isDrawing = false;
let isProving = false;

async function draw() {
  isWanted = true;
  if (isDrawing || isProving) return;
  isDrawing = true;
  while (isWanted && !isProving) {
    isWanted = false;
    const on = chosen();
    const args = {
      ...size,
      ...move,
      gpu: on === "gpu",
      samples: Number(at("samples").value),
      exposure: Number(at("exposure").value),
      shadows: at("shadows").value,
    };
    move = { yaw: 0, pitch: 0, nearer: 0 };
    if (on === "gpu" && at("hash-gpu").textContent === "–") say("The GPU compiles its shaders.");
    try {
      const frame = await call("render", args);
      canvas.getContext("2d").putImageData(new ImageData(frame.pixels, frame.width, frame.height), 0, 0);
      show(on, frame);
    } catch (error) {
      say(error.message);
    }
  }
  isDrawing = false;
}

// The hash of the other backend stays as long as the picture is the same.
function show(on, { hash, ms, command }) {
  const other = on === "gpu" ? "cpu" : "gpu";
  if (at("command").textContent !== command) at(`hash-${other}`).textContent = "–";
  at(`hash-${on}`).textContent = hash;
  at("command").textContent = command;
  const hashes = [at("hash-cpu").textContent, at("hash-gpu").textContent];
  const same = hashes.includes("–") ? "" : hashes[0] === hashes[1] ? " Both hashes are equal." : " THE HASHES DIFFER.";
  say(`${ms.toFixed(1)} ms on the ${on === "gpu" ? "GPU" : "processor"}.${same}`);
  performance.measure(`picture-${on}`, { start: 0 });
}

async function scene(name, file) {
  say("Loading.");
  try {
    const facts = JSON.parse(await call("show", { ...size, name, file }, file ? [file] : []));
    const warnings = facts.warnings.length ? ` Not as in the file: ${facts.warnings.join("; ")}` : "";
    at("scene-note").textContent =
      `${facts.objects} objects, ${facts.triangles} triangles, ${facts.lights} lights.${warnings}`;
  } catch (error) {
    at("scene-note").textContent = error.message;
  }
  move = { yaw: 0, pitch: 0, nearer: 0 };
  return draw();
}

async function take(file) {
  if (file) await scene(file.name, await file.arrayBuffer());
}

at("scene").onchange = () => scene(at("scene").value);
at("file").onchange = () => take(at("file").files[0]);
for (const id of ["shadows", "samples"]) at(id).onchange = draw;
at("exposure").oninput = () => {
  at("stops").textContent = at("exposure").value;
  draw();
};
at("home").onclick = async () => {
  await call("home", size);
  draw();
};
for (const radio of document.querySelectorAll("input[name=on]")) radio.onchange = draw;

function moved(yaw, pitch, nearer) {
  move = { yaw: move.yaw + yaw, pitch: move.pitch + pitch, nearer: move.nearer + nearer };
  draw();
}
canvas.onpointerdown = (event) => canvas.setPointerCapture(event.pointerId);
canvas.onpointermove = (event) => {
  if (event.buttons) moved(-event.movementX * 0.01, -event.movementY * 0.01, 0);
};
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  moved(0, 0, event.deltaY < 0 ? 0.1 : -0.1);
}, { passive: false });
const KEYS = {
  ArrowLeft: [0.1, 0, 0],
  ArrowRight: [-0.1, 0, 0],
  ArrowUp: [0, -0.1, 0],
  ArrowDown: [0, 0.1, 0],
  "+": [0, 0, 0.1],
  "-": [0, 0, -0.1],
};
canvas.onkeydown = (event) => {
  if (KEYS[event.key]) {
    event.preventDefault();
    moved(...KEYS[event.key]);
  }
};
canvas.ondragover = (event) => {
  event.preventDefault();
  canvas.classList.add("drop");
};
canvas.ondragleave = () => canvas.classList.remove("drop");
canvas.ondrop = (event) => {
  event.preventDefault();
  canvas.classList.remove("drop");
  take(event.dataTransfer.files[0]);
};

// Prove it. `?cases=TEXT` asks only cases whose names contain one of the words: a shorter test of the page itself.
async function prove() {
  isProving = true;
  at("run").disabled = at("save").disabled = true;
  const words = new URLSearchParams(location.search).get("cases")?.split(",") ?? [""];
  const names = (await call("cases")).filter((name) => words.some((word) => name.includes(word)));
  const backends = document.querySelector("input[value=gpu]").disabled ? [false] : [false, true];
  at("cases").replaceChildren(...names.map((name) => {
    const row = document.createElement("tr");
    row.append(...[name, "–", "–"].map((text) => Object.assign(document.createElement("td"), { textContent: text })));
    return row;
  }));
  document.querySelector("table").hidden = at("progress").hidden = false;
  at("progress").max = names.length * backends.length;
  at("progress").value = 0;
  let different = 0;
  const devices = [];
  for (const gpu of backends) {
    devices.push(await call("begin", { gpu }));
    for (const [row, name] of names.entries()) {
      let detail;
      try {
        detail = await call("ask", { gpu, name });
      } catch (error) {
        detail = error.message;
      }
      const cell = at("cases").rows[row].cells[gpu ? 2 : 1];
      cell.textContent = detail ?? "equal";
      cell.className = detail === null ? "equal" : "differs";
      different += detail === null ? 0 : 1;
      at("progress").value += 1;
      at("verdict").textContent = `${devices.at(-1)}: ${row + 1} of ${names.length}`;
    }
  }
  const asked = `${names.length} cases on ${devices.join(" and on ")}`;
  at("verdict").textContent = different === 0 ? `${asked}: all equal.` : `${asked}: ${different} DIFFER.`;
  at("verdict").className = different === 0 ? "equal" : "differs";
  at("run").disabled = at("save").disabled = false;
  isProving = false;
  draw();
}
at("run").onclick = prove;
at("save").onclick = async () => {
  const text = await call("proof");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
  link.download = "rtrt-proof.json";
  link.click();
  URL.revokeObjectURL(link.href);
};

await scene(at("scene").value);
try {
  at("gpu-note").textContent = `GPU: ${await call("gpu")}`;
  document.querySelector("input[value=gpu]").disabled = false;
} catch (error) {
  at("gpu-note").textContent = `No GPU: ${error.message}. Everything works on the processor.`;
}
at("run").disabled = false;
