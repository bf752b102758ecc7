// The events around a moment, as lines.

const AROUND = 60;

/** The keys that the line of an event does not repeat. */
const OF_ALL = new Set(["event", "n", "cycle", "time", "task", "spec", "because", "results"]);

/** The keys whose values stand without the name of the key. */
const BARE = new Set(["goal", "fact", "request", "what", "on", "data", "result", "method"]);

/** Return the line of an event: its own keys, the goal of its task first. */
function eventText(run, event) {
  const parts = [];
  for (const [key, value] of Object.entries(event)) {
    if (OF_ALL.has(key) || value === null || value === "") continue;
    if (Array.isArray(value) && !value.length) continue;
    const bare = BARE.has(key);
    if (key === "sent" && value === event.request) continue;
    if (event.event === "plan-made" && key === "text") continue;
    if (key === "bindings" || key === "outputs") {
      const pairs = Object.entries(value && typeof value === "object" ? value : {});
      parts.push(...pairs.map(([name, one]) => `${name} ${asText(one)}`));
    } else if (key === "steps" && Array.isArray(value)) parts.push(plural(value.length, "step"));
    else parts.push(bare ? asText(value) : `${key} ${asText(value)}`);
  }
  return parts.join(" ");
}

/** Return the row of an event. */
function eventRow(app, index, now) {
  const { run } = app;
  const event = run.events[index];
  const task = run.tasks.get(event.task);
  const bad = event.event === "task-failed"
    || (event.event === "primitive-ended" && event.result !== "okay");
  return el(
    now ? "div.row.now" : "div.row",
    choosable("option", `e${index}`, now, () => app.go(index, task ? { task: task.number } : {})),
    el("span.t", {}, readable(event.time)),
    oneLine(el(bad ? "span.failed" : "span", {}, event.event),
      el("span.dim", {}, ` ${eventText(run, event)}${task ? ` [${task.number}]` : ""}`)),
  );
}

/** Show the events around the moment, or the events of the selected task around it. */
function showEvents(app) {
  const { run, at, task } = app;
  const own = byId("own").checked && task;
  let shown = [];
  if (own) {
    const here = search(task.log.length, (index) => task.log[index] > at);
    shown = task.log.slice(Math.max(here - AROUND, 0), here + AROUND);
  } else {
    const first = Math.max(at - AROUND / 2, 0);
    const last = Math.min(at + AROUND / 2, run.last);
    for (let index = first; index <= last; index++) shown.push(index);
  }
  const body = byId("events");
  fill(body, reachable(shown.map((index) => eventRow(app, index, index === at))));
  reveal(body, body.querySelector(".now"));
}
