// Loads the client: finds the current build, shows how far it has come, starts it, and says plainly what is wrong when
// it cannot start. Needs nothing that a plain http:// address lacks.

const loading = document.getElementById("loading");
const progress = document.getElementById("loading-progress");
const text = document.getElementById("loading-text");
const retry = document.getElementById("loading-retry");

// The browser makes a graphics context in a process of its own, which has time while the client is fetched and compiled. The client
// asks for the same and gets this one. Not where it may draw with WebGPU: a canvas has one kind of context only.
function makeContextEarly() {
  const asked = new URLSearchParams(location.search).get("gpu");
  let kept = null;
  try {
    kept = localStorage.getItem("autoinspect.gpu");
  } catch {
    // A browser that stores nothing draws with WebGL2.
  }
  if ((asked ?? kept) !== "webgpu") {
    document.getElementById("scene").getContext("webgl2", { antialias: false });
  }
}

/** A failure whose message is meant for the operator as it is. */
class Problem extends Error {}

function fail(message) {
  loading.hidden = false;
  loading.classList.add("failed");
  loading.setAttribute("aria-busy", "false");
  progress.hidden = true;
  text.textContent = message;
  retry.hidden = false;
}

/** Says so where the browser cannot draw. Asked only of a client that could not start: the first picture of a page costs
 * a second where the processor draws, and this would be one more. */
async function requireGraphics() {
  const context = document.createElement("canvas").getContext("webgl2");
  // Some browsers offer WebGPU and then have no adapter for it.
  if (!context && !(await navigator.gpu?.requestAdapter().catch(() => null))) {
    throw new Problem(
      "This browser cannot draw the 3D map: WebGL 2 is missing or switched off. " +
        "Turn on hardware acceleration in the browser's settings, or open this address in a current Chrome, Edge, " +
        "Firefox or Safari.",
    );
  }
}

async function get(url, options) {
  let response;
  try {
    response = await fetch(url, options);
  } catch {
    throw new Problem("The robot's server does not answer. Check the network, then try again.");
  }
  if (!response.ok) {
    throw new Problem(
      response.status === 404
        ? "This server has no client to hand out. Build it with `cargo xtask web`, then try again."
        : `The robot's server answered with error ${response.status}. Try again in a moment.`,
    );
  }
  return response;
}

/** A client that is here sooner needs no progress shown, milliseconds. */
const PROGRESS_AFTER = 400;

/** Shows how much of a response has come. Reads a copy: the browser keeps compiled code only with a response as it came. */
async function watch(copy, bytesTotal) {
  const reader = copy.body.getReader();
  let bytes = 0;
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    bytes += part.value.byteLength;
    progress.value = Math.min(1, bytes / bytesTotal);
    text.textContent = `Loading… ${Math.round(100 * progress.value)} %`;
  }
}

async function compile() {
  const manifest = await (await get("pkg/manifest.json", { cache: "no-cache" })).json();
  const bundle = {
    js: new URL(`pkg/${manifest.js}`, document.baseURI).href,
    wasm: new URL(`pkg/${manifest.wasm}`, document.baseURI).href,
  };
  // The client's workers load the same two files.
  globalThis.autoinspectBundle = bundle;
  const [response, client] = await Promise.all([get(bundle.wasm), import(bundle.js)]);
  const copy = response.clone();
  // What ends the copy early ends the response as well, which says so.
  const slow = setTimeout(() => watch(copy, manifest.wasm_bytes).catch(() => {}), PROGRESS_AFTER);
  await client.default({ module_or_path: response });
  clearTimeout(slow);
  text.textContent = "Starting…";
  performance.mark("autoinspect: client compiled");
  return client;
}

async function load() {
  const client = await compile();
  try {
    await client.start("scene");
  } catch (error) {
    await requireGraphics();
    throw error;
  }
  loading.setAttribute("aria-busy", "false");
  loading.hidden = true;
}

retry.addEventListener("click", () => location.reload());

// A trap inside the client leaves a picture that no longer changes: worse than none on a screen that shows a robot.
function stopped(event) {
  if ((event.error ?? event.reason) instanceof WebAssembly.RuntimeError) {
    fail("The client has stopped because of a fault in it. The robot is not affected. Try again to reload the page.");
  }
}
addEventListener("error", stopped);
addEventListener("unhandledrejection", stopped);

makeContextEarly();
load().catch((error) => {
  console.error(error);
  fail(error instanceof Problem ? error.message : `The client could not start: ${error.message ?? error}`);
});
