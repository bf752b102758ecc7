// A run that goes on: its events as they arrive, and its control by the reader.

/** The least number of milliseconds between two pictures of a run that goes on. */
const REFRESH = 250;

/** Show further events. A reader at the last event stays at the last event. */
function grow(events) {
  const { run, whole, view } = app;
  const atEnd = app.at === run.last;
  const isWhole = view.to - view.from >= whole.to - whole.from;
  const known = run.events.length;
  run.append(events);
  app.pictures[0].append(changesOf(run, {}, known));
  whole.to = Math.max(whole.to, run.timeOf(run.last));
  if (isWhole) Object.assign(view, whole);
  app.timelines[0].grow();
  byId("verdict").replaceChildren();
  app.begin();
  app.go(atEnd ? run.last : app.at);
  document.documentElement.dataset.events = run.events.length;
}

/** Show a run that goes on. */
function follow(more) {
  let events = [];
  let timer = 0;
  let cost = 0;
  const refresh = () => {
    const arrived = events;
    events = [];
    timer = 0;
    const begun = performance.now();
    if (app) grow(arrived);
    else start([new Run(arrived, more)], [more], null);
    cost = performance.now() - begun;
  };
  const source = new EventSource("events");
  source.addEventListener("message", (message) => {
    for (const event of JSON.parse(`[${message.data.replaceAll("\n", ",")}]`)) events.push(event);
    timer = timer || setTimeout(refresh, Math.max(REFRESH, 4 * cost));
  });
  source.addEventListener("end", () => source.close());
  if (more.commands.length) control(more.commands, source);
}

// --- control --------------------------------------------------------------------------

/** The words of the states of a run. */
const STATES = { running: "running", paused: "paused at", ended: "ended" };

/** Send a request to the run; return its answer. */
async function request(name, text = "") {
  const answer = await fetch("control", { method: "POST", body: JSON.stringify({ name, text }) });
  if (!answer.ok) throw new Error(`${answer.status} ${answer.statusText}`);
  return answer.json();
}

/** Let the reader control the run. */
function control(commands, source) {
  const bar = byId("control");
  let state = "running";
  let busy = false;
  const enable = () => {
    const over = state === "ended";
    byId("pause").disabled = over || (busy && state !== "running");
    for (const id of ["step", "command", "argument", "perform"]) byId(id).disabled = over || busy;
  };
  const perform = async (name, text) => {
    busy = true;
    enable();
    let answer;
    try {
      answer = await request(name, text);
    } catch (error) {
      answer = { failed: true, said: `cannot reach the run: ${error.message}` };
    }
    busy = false;
    enable();
    byId("answer").textContent = visible(answer.said);
    byId("answer").classList.toggle("failed", answer.failed);
    return !answer.failed;
  };
  const chosen = () => commands.find((one) => one.name === byId("command").value);
  const choose = () => {
    const { takes, doc } = chosen();
    byId("argument").placeholder = takes === "[TASK]" ? "TASK: default the selected task" : takes;
    byId("command").title = doc;
  };
  const keys = {
    p: () => byId("pause").click(),
    s: () => byId("step").click(),
    t: () => byId("argument").focus(),
  };
  source.addEventListener("status", (message) => {
    const status = JSON.parse(message.data);
    state = status.state;
    byId("pause").textContent = state === "paused" ? "Continue" : "Pause";
    byId("status").textContent = visible(`${STATES[state]} ${status.moment}`.trim());
    bar.dataset.state = state;
    enable();
  });
  byId("pause").addEventListener("click", () =>
    perform(state === "paused" ? "continue" : "pause"));
  byId("step").addEventListener("click", () => perform("step"));
  byId("act").addEventListener("submit", async (event) => {
    event.preventDefault();
    const { name, takes } = chosen();
    const selected = takes === "[TASK]" && app && app.task ? String(app.task.number) : "";
    const done = await perform(name, byId("argument").value || selected);
    if (done) byId("argument").value = "";
    byId("argument").focus();
  });
  byId("command").replaceChildren(...commands.map(({ name }) => el("option", { value: name }, name)));
  byId("command").addEventListener("change", choose);
  choose();
  Object.assign(KEYS, keys);
  byId("live-keys").hidden = bar.hidden = false;
}
