// Loads the client: finds the current build, shows the progress of its download, starts it, and shows the reason if it cannot start.
// Uses only what a page at a plain http:// address may use.

import { signedIn } from "./access.js";

const loading = document.getElementById("loading");
const progress = document.getElementById("loading-progress");
const text = document.getElementById("loading-text");
const retry = document.getElementById("loading-retry");

// The browser makes a graphics context in another process, while this one downloads and compiles the client. The client requests the same
// context and gets this one. If it may draw with WebGPU, no context is made: a canvas has one kind of context only.
function createContextEarly() {
  const requested = new URLSearchParams(location.search).get("gpu");
  let stored = null;
  try {
    stored = localStorage.getItem("autoinspect.gpu");
  } catch {
    // Without storage the client draws with WebGL2.
  }
  if ((requested ?? stored) !== "webgpu") {
    document.getElementById("scene").getContext("webgl2", { antialias: false });
  }
}

/** An error whose message is shown to the operator. */
class OperatorError extends Error {}

function fail(message) {
  loading.hidden = false;
  loading.classList.add("failed");
  loading.setAttribute("aria-busy", "false");
  progress.hidden = true;
  text.textContent = message;
  retry.hidden = false;
}

/** Throws if the browser cannot draw. Called only after the client could not start, because the first context of a page takes a second on a
 * software device. */
async function requireGraphics() {
  const context = document.createElement("canvas").getContext("webgl2");
  // Some browsers offer WebGPU and then have no adapter for it.
  if (!context && !(await navigator.gpu?.requestAdapter().catch(() => null))) {
    throw new OperatorError(
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
    throw new OperatorError("The robot's server does not answer. Check the network, then try again.");
  }
  if (!response.ok) {
    throw new OperatorError(
      response.status === 404
        ? "This server has no client to hand out. Build it with `cargo xtask web`, then try again."
        : `The robot's server answered with error ${response.status}. Try again in a moment.`,
    );
  }
  return response;
}

/** Delay of the progress display, ms: a client that is loaded sooner shows none. */
const PROGRESS_DELAY_MS = 400;

/** Shows the progress of a download. It reads a copy of the response, because the browser caches compiled code only for the original. */
async function showProgress(copy, bytesTotal) {
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
  // An error of the copy is an error of the response too, which reports it.
  const slow = setTimeout(() => showProgress(copy, manifest.wasm_bytes).catch(() => {}), PROGRESS_DELAY_MS);
  await client.default({ module_or_path: response });
  clearTimeout(slow);
  text.textContent = "Starting…";
  performance.mark("autoinspect: client compiled");
  return client;
}

async function load() {
  // The client is downloaded while somebody signs in.
  const [client] = await Promise.all([compile(), signedIn()]);
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

// After a trap in the client the image no longer changes. On a screen that shows a robot that is worse than an error.
function onError(event) {
  if ((event.error ?? event.reason) instanceof WebAssembly.RuntimeError) {
    fail("The client has stopped because of a fault in it. The robot is not affected. Try again to reload the page.");
  }
}
addEventListener("error", onError);
addEventListener("unhandledrejection", onError);

createContextEarly();
load().catch((error) => {
  console.error(error);
  fail(error instanceof OperatorError ? error.message : `The client could not start: ${error.message ?? error}`);
});
