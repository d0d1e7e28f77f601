// People and tokens, for admins. Everything goes through the same interface that programs use.

const problem = document.getElementById("problem");
const done = document.getElementById("done");

function tell(element, sentence) {
  for (const other of [problem, done]) {
    other.hidden = other !== element || !sentence;
  }
  element.textContent = sentence;
  if (sentence) {
    element.scrollIntoView({ block: "nearest" });
  }
}

/** Answer of the server, or null after an error, which is shown. */
async function ask(method, path, document) {
  let response;
  try {
    response = await fetch(`api/v1/${path}`, {
      method,
      headers: document ? { "content-type": "application/json" } : {},
      body: document && JSON.stringify(document),
    });
  } catch {
    tell(problem, "The robot's server does not answer. Check the network, then try again.");
    return null;
  }
  if (response.status === 401) {
    // The page of the robot asks people to sign in.
    location.assign("./");
    return null;
  }
  if (!response.ok) {
    const { detail, errors } = await response.json().catch(() => ({}));
    tell(problem, errors?.[0]?.detail ?? detail ?? `The robot's server answered with error ${response.status}.`);
    return null;
  }
  return response.status === 204 ? {} : await response.json();
}

function when(nanoseconds) {
  return nanoseconds === null ? "never" : new Date(nanoseconds / 1e6).toLocaleString();
}

function cell(row, content) {
  const element = row.insertCell();
  element.append(content);
  // On a phone each row is a card, and names its own columns.
  element.dataset.label = row.closest("table").tHead.rows[0].cells[element.cellIndex].textContent;
}

function button(text, label, action) {
  const element = document.createElement("button");
  element.type = "button";
  element.textContent = text;
  element.setAttribute("aria-label", label);
  element.addEventListener("click", action);
  return element;
}

async function change(sentence, ...request) {
  if (await ask(...request)) {
    tell(done, sentence);
    await show();
  }
}

function personRow(row, person) {
  const path = `accounts/${encodeURIComponent(person.account)}`;
  const role = document.createElement("select");
  role.setAttribute("aria-label", `Role of ${person.account}`);
  role.append(...["viewer", "operator", "admin"].map((name) => new Option(name, name, false, name === person.role)));
  role.addEventListener("change", () => change(`${person.account} is ${role.value} now.`, "PATCH", path, { role: role.value }));
  cell(row, person.is_enabled ? person.account : `${person.account} (disabled)`);
  cell(row, role);
  cell(row, String(person.sessions));
  cell(row, when(person.last_used));
  const actions = document.createElement("span");
  actions.className = "actions";
  actions.append(
    button("End sessions", `End sessions of ${person.account}`, () =>
      change(`${person.account} has to sign in again.`, "PATCH", path, { end_sessions: true })),
    button(person.is_enabled ? "Disable" : "Enable", `${person.is_enabled ? "Disable" : "Enable"} ${person.account}`, () =>
      change(`${person.account} is changed.`, "PATCH", path, { is_enabled: !person.is_enabled })),
    button("Remove", `Remove ${person.account}`, () => {
      if (confirm(`Remove the account ${person.account}? What it has done stays in the audit log.`)) {
        change(`${person.account} is removed.`, "DELETE", path);
      }
    }),
  );
  cell(row, actions);
}

function tokenRow(row, token) {
  cell(row, token.name);
  cell(row, token.role);
  cell(row, when(token.expires));
  cell(row, when(token.last_used));
  cell(row, button("End", `End token ${token.name}`, () => change(`${token.name} has ended.`, "DELETE", `tokens/${token.id}`)));
}

async function show() {
  const [people, tokens] = await Promise.all([ask("GET", "accounts"), ask("GET", "tokens")]);
  for (const [id, entries, fill] of [["people", people, personRow], ["tokens", tokens, tokenRow]]) {
    const body = document.getElementById(id);
    body.replaceChildren();
    for (const entry of entries ?? []) {
      fill(body.insertRow(), entry);
    }
  }
}

document.getElementById("add-person").addEventListener("submit", async (event) => {
  event.preventDefault();
  const entered = Object.fromEntries(new FormData(event.target));
  if (await ask("POST", "accounts", entered)) {
    event.target.reset();
    tell(done, `${entered.account} can sign in now.`);
    await show();
  }
});

document.getElementById("add-token").addEventListener("submit", async (event) => {
  event.preventDefault();
  const entered = Object.fromEntries(new FormData(event.target));
  const issued = await ask("POST", "tokens", { ...entered, days: Number(entered.days) });
  if (issued) {
    event.target.reset();
    document.getElementById("secret").value = issued.secret;
    document.getElementById("secret-row").hidden = false;
    tell(done, "The token is made. Copy its secret now: it is never shown again.");
    await show();
  }
});

/** What the audit log shows: entries with `containing`, and from where the next page begins. */
const audit = { containing: "", next: null };

function auditRow(row, entry) {
  cell(row, when(entry.at));
  cell(row, entry.account ?? "—");
  cell(row, entry.address ?? "this robot");
  cell(row, entry.command);
  cell(row, entry.outcome);
  row.cells[3].className = row.cells[4].className = "wraps";
}

function auditPath(more) {
  return `audit?${new URLSearchParams({ containing: audit.containing, ...more })}`;
}

/** Shows the newest entries, or the page after those that are shown. */
async function showAudit(isNextPage) {
  const page = await ask("GET", auditPath(isNextPage ? { before: audit.next } : {}));
  if (!page) {
    return;
  }
  const body = document.getElementById("audit");
  if (!isNextPage) {
    body.replaceChildren();
  }
  for (const entry of page.items) {
    auditRow(body.insertRow(), entry);
  }
  audit.next = page.next;
  document.getElementById("audit-more").hidden = page.next === null;
  document.getElementById("audit-empty").hidden = body.rows.length > 0;
  document.getElementById("audit-csv").href = `api/v1/${auditPath({ format: "csv" })}`;
}

document.getElementById("search-audit").addEventListener("submit", async (event) => {
  event.preventDefault();
  audit.containing = document.getElementById("containing").value.trim();
  await showAudit(false);
});
document.getElementById("audit-more").addEventListener("click", () => showAudit(true));

document.getElementById("copy-secret").addEventListener("click", async () => {
  const secret = document.getElementById("secret");
  secret.select();
  // Browsers offer the clipboard to encrypted pages only. Elsewhere the secret is selected, for Ctrl-C.
  await navigator.clipboard?.writeText(secret.value).then(() => tell(done, "The secret is copied."), () => {});
});

show();
showAudit(false);
