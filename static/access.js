// Asks people to sign in: over the page, in real form fields, so that password managers and on-screen keyboards work. What was typed into the client below stays.

const dialog = document.getElementById("sign-in");
const form = document.getElementById("sign-in-form");
const title = document.getElementById("sign-in-title");
const hint = document.getElementById("sign-in-hint");
const problem = document.getElementById("sign-in-problem");
const button = document.getElementById("sign-in-button");
const account = document.getElementById("sign-in-account");
const password = document.getElementById("sign-in-password");
const repeated = document.getElementById("sign-in-repeated");
const repeatedRow = document.getElementById("sign-in-repeated-row");

/** Secret of the link that makes the first admin, if the page was opened with it. */
let firstAdminSecret = null;
/** Who wait until somebody has signed in. */
let waiting = [];

function takeSecretOfLink() {
  const secret = new URLSearchParams(location.hash.slice(1)).get("first-admin");
  if (secret) {
    firstAdminSecret = secret;
    // It is not to stay in the address bar or the history.
    history.replaceState(null, "", location.pathname + location.search);
  }
}

/** Who is signed in here, or null if the server does not answer. */
async function session() {
  try {
    const response = await fetch("api/v1/session", { cache: "no-store" });
    return response.ok ? await response.json() : null;
  } catch {
    return null;
  }
}

function show(isFirstAdmin, needsFirstAdmin) {
  title.textContent = isFirstAdmin ? "Make the first admin" : "Sign in";
  button.textContent = isFirstAdmin ? "Make the account" : "Sign in";
  hint.textContent = isFirstAdmin
    ? "This account may do everything, and makes those of others. Choose a password of 12 characters or more; several words are easy to remember."
    : needsFirstAdmin
      ? "There is no account yet. The robot's console shows an address that makes the first admin: autoinspect account link."
      : "";
  hint.hidden = !hint.textContent;
  repeatedRow.hidden = !isFirstAdmin;
  repeated.required = isFirstAdmin;
  password.autocomplete = isFirstAdmin ? "new-password" : "current-password";
  problem.hidden = true;
  if (!dialog.open) {
    // Modal: the client below keeps what was typed into it, and neither Tab nor a finger reaches it.
    dialog.showModal();
    (account.value ? password : account).focus();
  }
}

function refuse(sentence) {
  problem.textContent = sentence;
  problem.hidden = false;
}

async function submit(event) {
  event.preventDefault();
  const isFirstAdmin = !repeatedRow.hidden;
  if (isFirstAdmin && password.value !== repeated.value) {
    refuse("The two passwords differ. Type them again.");
    repeated.focus();
    return;
  }
  button.disabled = true;
  const entered = { account: account.value, password: password.value };
  try {
    const response = await fetch(isFirstAdmin ? "api/v1/first-admin" : "api/v1/session", {
      method: "POST",
      headers: { "content-type": "application/json" },
      body: JSON.stringify(isFirstAdmin ? { ...entered, link: firstAdminSecret } : entered),
    });
    if (!response.ok) {
      const { detail } = await response.json().catch(() => ({}));
      refuse(detail ?? `The robot's server answered with error ${response.status}. Try again in a moment.`);
      password.select();
      return;
    }
    firstAdminSecret = null;
    password.value = "";
    repeated.value = "";
    const resumed = waiting;
    waiting = [];
    dialog.close();
    resumed.forEach((resume) => resume());
  } catch {
    refuse("The robot's server does not answer. Check the network, then try again.");
  } finally {
    button.disabled = false;
  }
}

/** Resolves once somebody is signed in, or nobody needs to. Without an answer of the server it resolves too: the client shows that there is no connection. */
export async function signedIn() {
  const now = await session();
  if (now && !now.is_demo && !now.account) {
    const signed = new Promise((resolve) => waiting.push(resolve));
    show(now.needs_first_admin && firstAdminSecret !== null, now.needs_first_admin);
    await signed;
  }
}

async function signOut() {
  await fetch("api/v1/session", { method: "DELETE" }).catch(() => {});
  await signedIn();
}

takeSecretOfLink();
form.addEventListener("submit", submit);
// Escape does not sign in.
dialog.addEventListener("cancel", (event) => event.preventDefault());
dialog.addEventListener("close", () => waiting.length > 0 && dialog.showModal());
addEventListener("autoinspect-sign-out", signOut);
addEventListener("autoinspect-manage-people", () => open("people.html", "_blank", "noopener"));
// Without a control socket. The client says that the stop may not arrive, and sends it again once it is connected.
addEventListener("autoinspect-stop", () => fetch("api/v1/stop", { method: "POST" }).catch(() => {}));
addEventListener("autoinspect-change-password", () => open("password.html", "_blank", "noopener"));
// The client says so when it has lost its connection: perhaps the session has ended.
addEventListener("autoinspect-disconnected", () => !dialog.open && signedIn());
