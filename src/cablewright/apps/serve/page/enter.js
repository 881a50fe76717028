// The token goes to the server once, in the body of a request, and is then in a cookie that no script can read.
const told = document.getElementById("told"), form = document.getElementById("enter"), field = document.getElementById("token");

async function enter(token) {
  const answer = await fetch("/enter", { method: "POST", body: token }).catch(() => null);
  if (answer?.ok) location.replace("/");
  else told.textContent = answer ? await answer.text() : "The server does not answer.";
}

form.addEventListener("submit", (event) => { event.preventDefault(); enter(field.value.trim()); });
if (location.hash.length > 1) {
  const token = decodeURIComponent(location.hash.slice(1));
  history.replaceState(null, "", "/enter"); // not in the history
  enter(token);
} else field.focus();
