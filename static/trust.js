// Shows the fingerprint of the robot's certificate authority. This page is shown over plain http too, before a browser trusts the robot.

const problem = document.getElementById("problem");
const shown = document.getElementById("fingerprint");

try {
  const response = await fetch("api/v1/authority", { cache: "no-store" });
  const answer = await response.json();
  if (response.ok) {
    shown.textContent = answer.sha256;
  } else {
    problem.textContent = answer.detail;
    problem.hidden = false;
    for (const section of document.querySelectorAll("section")) {
      section.hidden = true;
    }
  }
} catch {
  problem.textContent = "The robot's server does not answer. Check the network, then try again.";
  problem.hidden = false;
}
// The client itself is reached over https only.
document.getElementById("client").href = `https://${location.host}/`;
