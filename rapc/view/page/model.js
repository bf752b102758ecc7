// The model of a run: its events, and what they show of any moment.
//
// A moment is the index of an event: the state of the run after this event. Nothing here
// touches the document. A trace is data of strangers: damaged lines end the run early,
// and values of unexpected types count as text.

/** The number of events between two copies of memory. */
const CHECKPOINT = 5000;

/** The events that end a task, with its outcome. */
const ENDS = new Map([
  ["task-succeeded", "succeeded"],
  ["task-failed", "failed"],
  ["task-removed", "removed"],
]);

/** The events that end a wait of a task. */
const WAKES = new Set([
  "task-woken",
  "method-chosen",
  "method-ended",
  "method-suspended",
  "task-blocked",
  ...ENDS.keys(),
]);

/** The events with which a run ends, or the tasks that are left. */
const LEAVING = new Set([
  "run-ended",
  "task-removed",
  "primitive-cancelled",
  "skill-disabled",
  "pictured",
]);

/** Return a value of a trace as text. */
function asText(value) {
  if (typeof value === "string") return value;
  return value === null || value === undefined ? "" : JSON.stringify(value);
}

/** Return a list of a trace; anything else counts as no element. */
function asList(value) {
  return Array.isArray(value) ? value : [];
}

/** Return the first word of a list that is given as text. */
function firstWord(text) {
  const found = /^\(?([^\s()]*)/.exec(text);
  return found ? found[1] : "";
}

/** Return the index of the first element that `after` accepts; all later ones are too. */
function search(length, after) {
  let low = 0;
  let high = length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (after(middle)) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** Return what is wrong with an event after another, or an empty text. */
function wrongEvent(event, last) {
  if (event === null || typeof event !== "object" || typeof event.event !== "string")
    return "is not an event";
  if (!Number.isFinite(event.time) || !Number.isFinite(event.cycle)) return "has no time";
  if (!Number.isInteger(event.n) || (last && event.n !== last.n + 1) || (last && (event.cycle < last.cycle || event.time < last.time)))
    return "is out of order";
  return "";
}

/**
 * Return the events of a trace, and a note on what was left out.
 *
 * Throws an Error if the text is not a trace from the start of a run.
 */
function readTrace(text) {
  let events = [];
  let note = "";
  try {
    events = JSON.parse(`[${text.trimEnd().replaceAll("\n", ",")}]`);
  } catch {
    events = [];
    for (const line of text.split("\n")) {
      try {
        events.push(JSON.parse(line));
      } catch {
        if (line) note = `line ${events.length + 1} is damaged; the page ends before it`;
        break;
      }
    }
  }
  for (let row = 0; row < events.length; row++) {
    const wrong = wrongEvent(events[row], events[row - 1]);
    if (wrong) {
      note = `line ${row + 1} ${wrong}; the page ends before it`;
      events.length = row;
      break;
    }
  }
  if (!events.length || events[0].event !== "run-started")
    throw new Error("the file is not a trace from the start of a run");
  return { events, note };
}

/** A run with its tasks, requests, waits and memory. */
class Run {
  /**
   * @param events the events, from `readTrace`
   * @param more what `rapc view` knows beside the trace: `sensors`, `sources`, `raps`,
   *   `beliefs`, `pictures`; each may be missing
   */
  constructor(events, more = {}) {
    this.events = [];
    this.spec = events[0].spec && typeof events[0].spec === "object" ? events[0].spec : {};
    this.sensors = new Set(asList(more.sensors));
    this.beliefs = asList(more.beliefs);
    /** The tasks by number, and the top-level tasks in the order of their arrival. */
    this.tasks = new Map();
    this.families = [];
    /** The indices of all failures of tasks. */
    this.failures = [];
    /** The indices of the changes of each fact. */
    this.facts = new Map();
    /** The intervals of skills and requests, each with its family. */
    this.requests = [];
    /** The index of each plan, by `RAP METHOD`. */
    this.plans = new Map();
    this.end = null;
    /** Memory and the live tasks before each event at a multiple of CHECKPOINT. */
    this._copies = [{ facts: new Map(), tasks: [] }];
    this._order = [];
    this._tree = null;
    this._states = { at: -1, known: new Map() };
    this._memory = { at: -1, facts: new Map() };
    /** At the last event: the facts, the live tasks, the open pieces, and the waits. */
    this._present = { facts: new Map(), live: new Set(), open: [], waits: new Map() };
    this.append(events);
  }

  get last() {
    return this.events.length - 1;
  }

  /** Return the last event before the tasks that are left are removed at the end. */
  get lastLive() {
    const after = (event) => LEAVING.has(event.event);
    return this.end ? Math.max(this.events.findLastIndex((one) => !after(one)), 0) : this.last;
  }

  timeOf(at) {
    return this.events[at].time;
  }

  // --- building ---------------------------------------------------------------------

  /** Add the next events. A piece or wait under way has the stop -1. */
  append(events) {
    const { facts, live, open, waits } = this._present;
    for (const event of events) {
      const at = this.events.push(event) - 1;
      const task = this.tasks.get(event.task);
      if (task) {
        task.log.push(at);
        if (typeof event.goal === "string") task.goal = event.goal;
      }
      if (task && WAKES.has(event.event)) this._endWait(waits, task, at);
      switch (event.event) {
        case "fact-asserted":
        case "fact-erased":
          this._change(facts, asText(event.fact), at);
          break;
        case "task-created":
          this._create(event, at);
          if (this._order.at(-1)?.made === at) live.add(this._order.at(-1));
          break;
        case "plan-made":
          this.plans.set(`${firstWord(asText(event.goal))} ${asText(event.method)}`, at);
          break;
        case "task-failed":
          this.failures.push(at);
          if (task) {
            this._end(task, at);
            this.familyOf(task).failures.push(at);
          }
          break;
        case "task-succeeded":
        case "task-removed":
          if (task) this._end(task, at);
          break;
        case "task-blocked":
        case "method-suspended":
          if (task) this._wait(waits, task, at);
          break;
        case "primitive-requested":
          if (task) open.push(this._begin(task, asText(event.request), at));
          break;
        case "skill-enabled":
          if (task) open.push(this._begin(task, asText(event.what), at));
          break;
        case "primitive-ended":
        case "primitive-cancelled":
        case "request-refused":
        case "skill-disabled":
          this._finish(open, event, at);
          break;
        case "deadline-missed":
        case "deadlock":
          if (task) this.familyOf(task).marks.push(at);
          break;
        case "run-ended":
          this.end = event;
          for (const one of asList(event.results)) {
            const given = this.tasks.get(one && one.task);
            if (given) given.background = one.background === true;
          }
          break;
      }
      if (task && task.ended === at) live.delete(task);
      if ((at + 1) % CHECKPOINT === 0)
        this._copies.push({ facts: new Map(facts), tasks: [...live] });
    }
  }

  _create(event, at) {
    const parent = this.tasks.get(event.parent) || null;
    if (!Number.isInteger(event.task) || this.tasks.has(event.task)) return;
    const task = {
      number: event.task,
      goal: asText(event.goal),
      parent,
      step: asText(event.step),
      made: at,
      ended: -1,
      outcome: "",
      background: false,
      log: [at],
    };
    this.tasks.set(task.number, task);
    this._order.push(task);
    if (parent === null) {
      Object.assign(task, { pieces: [], waits: [], failures: [], marks: [] });
      this.families.push(task);
    }
  }

  familyOf(task) {
    let above = task;
    while (above.parent) above = above.parent;
    return above;
  }

  _end(task, at) {
    if (task.ended >= 0) return;
    task.ended = at;
    task.outcome = ENDS.get(this.events[at].event);
    if (this.events[at].cause === "run-over") task.outcome = "unfinished";
  }

  _change(memory, fact, at) {
    const known = this.facts.get(fact);
    if (known) known.push(at);
    else this.facts.set(fact, [at]);
    if (this.events[at].event === "fact-asserted") memory.set(fact, at);
    else memory.delete(fact);
  }

  _begin(task, request, at) {
    const event = this.events[at];
    const skill = event.event === "skill-enabled";
    const sensing = this.sensors.has(firstWord(request));
    const piece = {
      kind: sensing ? "sensing" : "acting",
      skill,
      background: event.background === true,
      task: task.number,
      request,
      start: at,
      stop: -1,
      result: "",
    };
    this.requests.push(piece);
    this.familyOf(task).pieces.push(piece);
    return piece;
  }

  /** End a request or skill; the names of its items may have changed since its start. */
  _finish(open, event, at) {
    const skill = event.event === "skill-disabled";
    const request = asText(skill ? event.what : event.request);
    const own = (one) =>
      one.skill === skill && (event.task === null || one.task === event.task);
    let found = open.findIndex((one) => own(one) && one.request === request);
    if (found < 0)
      found = open.findIndex((one) => own(one) && firstWord(one.request) === firstWord(request));
    if (found < 0) return;
    const [piece] = open.splice(found, 1);
    piece.stop = at;
    if (event.event === "primitive-ended") piece.result = asText(event.result);
    else if (event.event !== "skill-disabled")
      piece.result = event.event === "request-refused" ? "refused" : "cancelled";
  }

  _wait(waits, task, at) {
    const kind = this.events[at].event === "method-suspended" ? "suspended" : "waiting";
    const wait = { kind, task: task.number, start: at, stop: -1 };
    waits.set(task.number, wait);
    this.familyOf(task).waits.push(wait);
  }

  _endWait(waits, task, at) {
    const wait = waits.get(task.number);
    if (wait === undefined) return;
    waits.delete(task.number);
    wait.stop = at;
  }

  // --- moments ----------------------------------------------------------------------

  /** Return the last event up to a time. */
  atTime(time) {
    const found = search(this.events.length, (at) => this.events[at].time > time);
    return Math.max(found - 1, 0);
  }

  /** Return the last event of the cycle that is `step` cycles away. */
  cycleFrom(at, step) {
    const cycle = this.events[at].cycle;
    const ofEvent = (index) => this.events[index].cycle;
    if (step < 0) {
      const first = search(this.events.length, (index) => ofEvent(index) >= cycle);
      return Math.max(first - 1, 0);
    }
    const after = search(this.events.length, (index) => ofEvent(index) > cycle);
    if (after - 1 > at) return after - 1;
    if (after >= this.events.length) return this.last;
    const next = ofEvent(after);
    return search(this.events.length, (index) => ofEvent(index) > next) - 1;
  }

  /** Return the first event of the cycle of an event. */
  startOfCycle(at) {
    const cycle = this.events[at].cycle;
    return search(this.events.length, (index) => this.events[index].cycle >= cycle);
  }

  /** Return the next element of sorted indices, or the one before; -1 without one. */
  static next(indices, at, step) {
    const found =
      step > 0
        ? search(indices.length, (index) => indices[index] > at)
        : search(indices.length, (index) => indices[index] >= at) - 1;
    return found >= 0 && found < indices.length ? indices[found] : -1;
  }

  /** Return the failed top-level task to look at first: foreground before background. */
  firstFailed() {
    const failed = this.families.filter((task) => task.outcome === "failed");
    failed.sort((one, other) => one.background - other.background || one.ended - other.ended);
    return failed[0] || null;
  }

  // --- tasks ------------------------------------------------------------------------

  /** Return the ancestors of a task, the parent first. */
  ancestors(task) {
    const found = [];
    for (let one = task.parent; one; one = one.parent) found.push(one);
    return found;
  }

  /**
   * Return the tasks of a moment, parents before children, each with its depth.
   *
   * These are the live tasks, those that have ended in the cycle of the moment, and one
   * more with its ancestors.
   */
  treeAt(at, also = null) {
    const known = this._tree;
    if (known && known.at === at && known.also === also) return known.rows;
    const since = this.startOfCycle(at);
    const shown = new Set();
    const add = (task) => {
      for (let one = task; one && !shown.has(one); one = one.parent) shown.add(one);
    };
    for (const task of this._candidates(since, at)) {
      if (task.ended < 0 || task.ended > at || task.ended >= since) add(task);
    }
    if (also && also.made <= at) add(also);
    const children = new Map();
    for (const task of shown) {
      const siblings = children.get(task.parent);
      if (siblings) siblings.push(task);
      else children.set(task.parent, [task]);
    }
    const rows = [];
    const stack = (children.get(null) || []).map((task) => ({ task, depth: 0 }));
    stack.sort((one, other) => other.task.made - one.task.made);
    while (stack.length) {
      const { task, depth } = stack.pop();
      rows.push({ task, depth });
      const below = (children.get(task) || []).map((one) => ({ task: one, depth: depth + 1 }));
      below.sort((one, other) => other.task.made - one.task.made);
      stack.push(...below);
    }
    this._tree = { at, also, rows };
    return rows;
  }

  /** Return all tasks that were live between two moments, and some that ended before. */
  _candidates(since, at) {
    const copy = Math.floor(since / CHECKPOINT);
    const first = search(this._order.length, (one) => this._order[one].made >= copy * CHECKPOINT);
    const last = search(this._order.length, (one) => this._order[one].made > at);
    return [...this._copies[copy].tasks, ...this._order.slice(first, last)];
  }

  /** Return the events of a task up to a moment, as indices. */
  logOf(task, at) {
    return task.log.slice(0, search(task.log.length, (index) => task.log[index] > at));
  }

  /**
   * Return the state of a task at a moment.
   *
   * `kind` is new, selected, ready, waiting, suspended, acting, sensing, active,
   * succeeded, failed, removed or unfinished; `method` is the choice under way (an
   * index, or -1); `text` says for what the task waits or what it does.
   */
  stateAt(task, at) {
    if (this._states.at !== at) this._states = { at, known: new Map() };
    const { known } = this._states;
    if (!known.has(task)) known.set(task, this._stateOf(task, at));
    return known.get(task);
  }

  _stateOf(task, at) {
    const state = { kind: "new", since: task.made, method: -1, wait: -1, text: "" };
    const log = this.logOf(task, at);
    // A choice of a method leaves nothing of the state before it.
    const chosen = log.findLastIndex((one) => this.events[one].event === "method-chosen");
    for (const index of chosen < 0 ? log : log.slice(chosen)) {
      const event = this.events[index];
      switch (event.event) {
        case "task-selected":
          Object.assign(state, { kind: "selected", since: index, wait: -1 });
          break;
        case "method-chosen":
          Object.assign(state, { kind: "active", since: index, method: index, wait: -1, text: "" });
          break;
        case "method-ended":
          Object.assign(state, { kind: "ready", since: index, method: -1, text: "" });
          break;
        case "method-suspended":
          Object.assign(state, { kind: "suspended", since: index, method: -1, wait: index });
          state.text = `suspended by [${asText(event.by)}] for ${asText(event.for)}`;
          break;
        case "task-blocked":
          Object.assign(state, { kind: "waiting", since: index, wait: index });
          state.text = `waits for ${asText(event.on)}`;
          if (Number.isInteger(event.holder)) state.text += `, held by [${event.holder}]`;
          break;
        case "task-woken":
          Object.assign(state, { kind: "ready", since: index, wait: -1, text: "" });
          break;
        case "primitive-requested": {
          const request = asText(event.request);
          const kind = this.sensors.has(firstWord(request)) ? "sensing" : "acting";
          Object.assign(state, { kind, since: index, text: request });
          break;
        }
        case "primitive-ended":
        case "primitive-cancelled":
          if (state.method >= 0) state.kind = "active";
          break;
        case "task-succeeded":
        case "task-failed":
        case "task-removed":
          if (index !== task.ended) break;
          Object.assign(state, { kind: task.outcome, since: index, wait: -1 });
          state.text = asText(event.result || event.cause);
          break;
      }
    }
    if (state.kind === "selected" && state.method >= 0) state.kind = "active";
    return state;
  }

  /** Return the choices of a task up to a moment, each with the end of the method. */
  triesOf(task, at) {
    const tries = [];
    for (const index of this.logOf(task, at)) {
      const event = this.events[index];
      const last = tries[tries.length - 1];
      if (event.event === "method-chosen") tries.push({ chosen: index, ended: -1 });
      else if (event.event === "method-ended" || event.event === "method-suspended")
        if (last && last.ended < 0) last.ended = index;
    }
    return tries;
  }

  /**
   * Return the plan that a task has chosen last up to a moment; or null.
   *
   * `made` is the index of its event. Each step has its task, or null before it begins.
   */
  planOf(task, at) {
    const chosen = this.logOf(task, at).findLast((one) =>
      this.events[one].event === "method-chosen");
    const event = chosen === undefined ? {} : this.events[chosen];
    const made = this.plans.get(`${asText(event.rap)} ${asText(event.method)}`);
    if (made === undefined || made > at) return null;
    const begun = new Map();
    let next = search(this._order.length, (one) => this._order[one].made > chosen);
    for (; next < this._order.length && this._order[next].made <= at; next++) {
      const other = this._order[next];
      if (other.parent === task) begun.set(other.step, other);
    }
    const steps = asList(this.events[made].steps).filter((one) => one && typeof one === "object");
    return {
      made,
      steps: steps.map((one) => ({
        tag: asText(one.tag),
        goal: asText(one.goal),
        links: asList(one.links).filter((to) => to && typeof to === "object").map((to) =>
          ({ step: asText(to.step), fact: asText(to.fact) })),
        before: asList(one.before).map(asText),
        task: begun.get(asText(one.tag)) || null,
      })),
    };
  }

  /** Return the last request of a task up to a moment that did not end okay; or null. */
  badRequest(task, at) {
    const bad = (one) =>
      one.task === task.number && one.stop >= 0 && one.stop <= at && one.result !== "okay";
    return this.familyOf(task).pieces.findLast((one) => !one.skill && bad(one)) || null;
  }

  /** Return the requests and skills under way at a moment. */
  underWay(at) {
    const found = [];
    for (const family of this.families)
      for (const one of family.pieces)
        if (one.start <= at && (one.stop < 0 || one.stop > at)) found.push(one);
    return found;
  }

  // --- memory -----------------------------------------------------------------------

  /** Return memory at a moment: each fact with the index of its last assertion. */
  memoryAt(at) {
    const near = this._memory;
    if (near.at > at || at - near.at > CHECKPOINT) {
      const copy = Math.floor((at + 1) / CHECKPOINT);
      near.facts = new Map(this._copies[copy].facts);
      near.at = copy * CHECKPOINT - 1;
    }
    for (near.at++; near.at <= at; near.at++) {
      const event = this.events[near.at];
      if (event.event === "fact-asserted") near.facts.set(asText(event.fact), near.at);
      else if (event.event === "fact-erased") near.facts.delete(asText(event.fact));
    }
    near.at = at;
    return near.facts;
  }

  /** Return the changes of memory in the cycle of a moment, up to it: the last of each. */
  changesAt(at) {
    const found = new Map();
    for (let index = this.startOfCycle(at); index <= at; index++) {
      const event = this.events[index];
      if (event.event === "fact-asserted" || event.event === "fact-erased")
        found.set(asText(event.fact), index);
    }
    return found;
  }

  /** Return the source of a change of memory: a text, and a place in a file if known. */
  sourceOf(at) {
    const by = asText(this.events[at].by);
    if (by === "handler") {
      for (let index = at + 1; index <= this.last; index++) {
        const event = this.events[index];
        if (event.event === "primitive-ended") {
          const task = Number.isInteger(event.task) ? ` of [${event.task}]` : "";
          return { text: `${asText(event.request)}${task}`, place: "", at: index };
        }
        if (event.event === "data-received")
          return { text: `datum ${asText(event.data)}`, place: "", at: index };
        if (event.event === "task-selected") break;
      }
    } else if (by === "rule" || by === "notation") {
      const wanted = by === "rule" ? "rule-run" : "task-selected";
      const cycle = this.events[at].cycle;
      for (let index = at - 1; index >= 0 && this.events[index].cycle === cycle; index--) {
        const event = this.events[index];
        if (event.event === wanted && by === "rule")
          return { text: `rule for ${asText(event.what)}`, place: asText(event.at), at: index };
        if (event.event === wanted)
          return { text: `notation of [${asText(event.task)}]`, place: "", at: index };
      }
    }
    return { text: by, place: "", at: -1 };
  }

  // --- searching --------------------------------------------------------------------

  /** Return at most `most` tasks, facts and requests whose text contains a text. */
  find(text, most = 60) {
    const wanted = text.toLowerCase();
    const found = [];
    const add = (kind, name, at, task) => {
      if (found.length < most && name.toLowerCase().includes(wanted))
        found.push({ kind, name, at, task });
    };
    const number = Number(text.replace(/^\[(\d+)\]$/, "$1"));
    if (text.trim() && Number.isFinite(number)) {
      const task = this.tasks.get(number);
      const own = task && { kind: "task", name: `[${number}] ${task.goal}`, at: task.made, task };
      const time = { kind: "time", name: `time ${number}`, at: this.atTime(number), task: null };
      found.push(...(text.startsWith("[") ? [own, time] : [time, own]).filter(Boolean));
      if (Number.isInteger(number) && number >= 0 && number <= this.last)
        found.push({ kind: "event", name: `event ${number}`, at: number, task: null });
    }
    for (const task of this.tasks.values())
      add(task.outcome === "failed" ? "failed" : "task", task.goal, task.made, task);
    for (const [fact, changes] of this.facts) add("fact", fact, changes[0], null);
    for (const one of this.requests)
      add("request", one.result ? `${one.request} - ${one.result}` : one.request, one.start,
        this.tasks.get(one.task));
    return found;
  }
}

/** Return the facts, sources and tasks of a cause, and of those below, as a flat list. */
function causesOf(because) {
  const found = [];
  for (let one = because; one && typeof one === "object" && found.length < 100; )
    found.push(one), (one = one.because);
  return found;
}

if (typeof module !== "undefined")
  module.exports = { CHECKPOINT, Run, asList, asText, causesOf, firstWord, readTrace, search };
