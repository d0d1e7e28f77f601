// Changes the password of whoever has signed in. All other sessions of the account end.

const form = document.getElementById("password");
const problem = document.getElementById("problem");
const done = document.getElementById("done");

function tell(element, sentence) {
  problem.hidden = element !== problem;
  done.hidden = element !== done;
  element.textContent = sentence;
}

form.addEventListener("submit", async (event) => {
  event.preventDefault();
  const { current, new: next, again } = Object.fromEntries(new FormData(form));
  if (next !== again) {
    tell(problem, "The two new passwords differ. Type them again.");
    return;
  }
  try {
    const response = await fetch("api/v1/session/password", {
      method: "PUT",
      headers: { "content-type": "application/json" },
      body: JSON.stringify({ current, new: next }),
    });
    if (response.ok) {
      form.reset();
      tell(done, "The password is changed. Other browsers have to sign in again.");
    } else {
      const { detail } = await response.json().catch(() => ({}));
      tell(problem, detail ?? `The robot's server answered with error ${response.status}.`);
    }
  } catch {
    tell(problem, "The robot's server does not answer. Check the network, then try again.");
  }
});

// Password managers want to know whose password it is.
fetch("api/v1/session").then((response) => response.json()).then(({ account }) => {
  document.getElementById("account").value = account ?? "";
});
