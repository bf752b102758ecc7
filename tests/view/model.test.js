// Tests of the model of a run; `tests/view/test_model.py` runs them with `node --test`.

const assert = require("node:assert/strict");
const test = require("node:test");
const { CHECKPOINT, Run, readTrace } = require("../../rapc/view/page/model.js");

/** Return a run of events; each is [cycle, time, kind, keys]. */
function runOf(rows, more = {}) {
  const all = [[0, 0, "run-started", { format: 2, spec: {} }], ...rows];
  const lines = all.map(([cycle, time, event, keys], n) =>
    JSON.stringify({ event, n, cycle, time, ...keys }));
  return new Run(readTrace(`${lines.join("\n")}\n`).events, more);
}

const created = (task, goal, parent = null, family = task) =>
  [0, 0, "task-created", { task, goal, parent, family, priority: 0, step: parent ? "t1" : null }];

test("a damaged line ends the run before it", () => {
  const first = '{"event":"run-started","n":0,"cycle":0,"time":0,"spec":{}}';
  const found = readTrace(`${first}\n{"event":"task-cre`);
  assert.equal(found.events.length, 1);
  assert.match(found.note, /line 2 is damaged/);
  assert.match(readTrace(`${first}\n{"event":"x","n":7,"cycle":0,"time":0}\n`).note, /out of order/);
  assert.match(readTrace(`${first}\n{"event":"x","n":1,"cycle":0,"time":"1"}\n`).note, /no time/);
  for (const text of ["", "nothing", "[]", "null\n", '{"event":"x","n":0,"cycle":0,"time":0}'])
    assert.throws(() => readTrace(text), /not a trace/);
});

test("memory has the facts of each moment, also across checkpoints", () => {
  const rows = [];
  for (let at = 0; at < 3 * CHECKPOINT; at++) {
    const event = at % 3 === 2 ? "fact-erased" : "fact-asserted";
    rows.push([at, at, event, { fact: `(at ${at % 7})`, by: "handler" }]);
  }
  const run = runOf(rows);
  const facts = new Map();
  const expected = new Map();
  run.events.forEach((event, at) => {
    if (event.event === "fact-asserted") facts.set(event.fact, at);
    if (event.event === "fact-erased") facts.delete(event.fact);
    if (at % 997 === 0) expected.set(at, new Map(facts));
  });
  const moments = [...expected.keys()];
  for (const at of [...moments, ...moments.reverse(), moments[3], moments[9]])
    assert.deepEqual(new Map(run.memoryAt(at)), expected.get(at));
});

test("the tree has live tasks, and those that ended in the cycle", () => {
  const run = runOf([
    created(1, "(whole)"),
    [1, 1, "task-selected", { task: 1, goal: "(whole)" }],
    [1, 1, "method-chosen", { task: 1, rap: "whole", method: "#1", bindings: {} }],
    [1, 1, "task-created", { task: 2, goal: "(part)", parent: 1, family: 1, step: "t1" }],
    [2, 2, "task-failed", { task: 2, goal: "(part)", reason: "no-method", result: "bad" }],
    [3, 3, "task-blocked", { task: 1, on: "wheels", holder: 2 }],
  ]);
  const tree = (at) => run.treeAt(at).map(({ task, depth }) => [task.number, depth]);
  assert.deepEqual(tree(4), [[1, 0], [2, 1]]);
  assert.deepEqual(tree(5), [[1, 0], [2, 1]]);
  assert.deepEqual(tree(6), [[1, 0]]);
  assert.deepEqual(run.treeAt(6, run.tasks.get(2)).length, 2);
  assert.equal(run.stateAt(run.tasks.get(1), 4).kind, "active");
  assert.equal(run.stateAt(run.tasks.get(1), 6).text, "waits for wheels, held by [2]");
  assert.equal(run.stateAt(run.tasks.get(2), 5).kind, "failed");
  assert.equal(run.stateAt(run.tasks.get(2), 4).kind, "new");
  assert.equal(run.firstFailed(), null);
});

test("a request ends also if the name of its item has changed", () => {
  const run = runOf([
    created(1, "(look rock-2)"),
    [1, 1, "primitive-requested", { task: 1, request: "(examine rock-2)", sent: "(examine s9)" }],
    [1, 2, "primitive-ended", { task: 1, request: "(examine rock-1)", result: "okay", data: [] }],
  ], { sensors: ["examine"] });
  assert.deepEqual(run.requests.map(({ kind, start, stop }) => [kind, start, stop]),
    [["sensing", 2, 3]]);
  assert.equal(run.underWay(2).length, 1);
  assert.equal(run.underWay(3).length, 0);
});

test("cycles, failures and times lead to moments", () => {
  const run = runOf([
    created(1, "(a)"),
    [1, 1, "task-selected", { task: 1, goal: "(a)" }],
    [1, 2, "task-failed", { task: 1, goal: "(a)", reason: "no-method", result: "bad" }],
    [2, 5, "fact-asserted", { fact: "(x)", by: "user" }],
    [2, 5, "run-ended", { reason: "done", results: [{ task: 1, background: true }], waiting: [] }],
  ]);
  assert.equal(run.cycleFrom(0, 1), 1);
  assert.equal(run.cycleFrom(1, 1), 3);
  assert.equal(run.cycleFrom(3, 1), 5);
  assert.equal(run.cycleFrom(5, 1), 5);
  assert.equal(run.cycleFrom(5, -1), 3);
  assert.equal(run.cycleFrom(1, -1), 0);
  assert.equal(run.atTime(4), 3);
  assert.equal(Run.next(run.failures, 0, 1), 3);
  assert.equal(Run.next(run.failures, 3, 1), -1);
  assert.equal(Run.next(run.failures, 5, -1), 3);
  assert.equal(run.firstFailed().number, 1);
  assert.equal(run.firstFailed().background, true);
});

test("a change of memory has its source", () => {
  const run = runOf([
    created(1, "(a)"),
    [1, 1, "task-selected", { task: 1, goal: "(a)" }],
    [1, 2, "fact-asserted", { fact: "(x)", by: "handler" }],
    [1, 2, "primitive-ended", { task: 1, request: "(go)", result: "okay", data: [] }],
    [1, 2, "rule-run", { task: 1, what: "okay", at: "a.rap:3", bindings: {} }],
    [1, 2, "fact-asserted", { fact: "(y)", by: "rule" }],
    [1, 2, "fact-asserted", { fact: "(z)", by: "user" }],
  ]);
  assert.equal(run.sourceOf(3).text, "(go) of [1]");
  assert.deepEqual(run.sourceOf(6), { text: "rule for okay", place: "a.rap:3", at: 5 });
  assert.equal(run.sourceOf(7).text, "user");
  assert.deepEqual([...run.changesAt(7).keys()], ["(x)", "(y)", "(z)"]);
});

test("waits and suspensions are intervals of the family", () => {
  const run = runOf([
    created(1, "(a)"),
    created(2, "(b)", 1, 1),
    [1, 1, "task-blocked", { task: 2, on: "(door open)" }],
    [2, 4, "task-woken", { task: 2, on: "(door open)" }],
    [3, 5, "method-suspended", { task: 2, method: "#1", for: "wheels", by: 1 }],
  ]);
  assert.deepEqual(run.families[0].waits.map(({ kind, start, stop }) => [kind, start, stop]),
    [["waiting", 3, 4], ["suspended", 5, -1]]);
});

test("searching finds tasks, facts, requests, times and events", () => {
  const run = runOf([
    created(1, "(Deliver linen)"),
    [1, 1, "fact-asserted", { fact: "(linen here)", by: "user" }],
    [1, 1, "primitive-requested", { task: 1, request: "(take linen)", sent: "(take linen)" }],
  ]);
  assert.deepEqual(run.find("LINEN").map((one) => one.kind), ["task", "fact", "request"]);
  assert.deepEqual(run.find("1").map((one) => one.kind), ["time", "task", "event"]);
  assert.deepEqual(run.find("[1]").map((one) => one.kind), ["task", "time", "event"]);
  assert.deepEqual(run.find("linen", 1).length, 1);
});

test("events that are added later give the same run", () => {
  const rows = [created(1, "(a)"), created(2, "(b)", 1, 1)];
  for (let at = 1; at < CHECKPOINT; at++)
    rows.push(
      [at, at, "task-blocked", { task: 2, on: "(door open)" }],
      [at, at + 0.5, "task-woken", { task: 2, on: "(door open)" }],
      [at, at + 0.5, "primitive-requested", { task: 1, request: `(take ${at})` }],
      [at, at + 0.5, "fact-asserted", { fact: `(at ${at % 7})`, by: "user" }]);
  rows.push([CHECKPOINT, CHECKPOINT, "run-ended",
    { reason: "done", results: [{ task: 1, background: true }] }]);
  const whole = runOf(rows);
  for (const size of [1, 7, CHECKPOINT - 1]) {
    const run = new Run(whole.events.slice(0, 1));
    for (let at = 1; at < whole.events.length; at += size) {
      run.append(whole.events.slice(at, at + size));
      if (at % 5 === 0) run.memoryAt(run.last), run.treeAt(run.last);
    }
    for (const at of [0, 17, CHECKPOINT, whole.last]) {
      assert.deepEqual(run.memoryAt(at), whole.memoryAt(at));
      assert.deepEqual(run.treeAt(at), whole.treeAt(at));
    }
    for (const key of ["families", "requests", "facts", "failures", "end", "_copies"])
      assert.deepEqual(run[key], whole[key]);
  }
});

test("a plan has its steps with their tasks", () => {
  const steps = [
    { tag: "t1", goal: "(go hall)", links: [{ step: "t2", fact: "(at hall)" }], before: [] },
    { tag: "t2", goal: "(take box)", links: [{ step: null, fact: "(held box)" }], before: [] },
  ];
  const plan = { task: 1, goal: "(fetch box)", outcome: "solved", method: "plan-1", steps };
  const chosen = { task: 1, rap: "fetch", method: "plan-1", bindings: {} };
  const run = runOf([
    created(1, "(fetch box)"),
    [1, 1, "plan-made", plan],
    [1, 1, "method-chosen", chosen],
    [1, 1, "task-created", { task: 2, goal: "(go hall)", parent: 1, family: 1, step: "t1" }],
    [2, 2, "method-ended", { task: 1, method: "plan-1", result: "bad" }],
    [3, 3, "method-chosen", { ...chosen, method: "#1" }],
    [4, 4, "plan-made", { ...plan, method: null, steps: [] }],
    [5, 5, "plan-made", { ...plan, method: "plan-2", steps: [7, { links: "?" }] }],
    [5, 5, "method-chosen", { ...chosen, method: "plan-2" }],
  ]);
  const task = run.tasks.get(1);
  assert.equal(run.planOf(task, 2), null);
  const { made, steps: found } = run.planOf(task, 5);
  assert.equal(made, 2);
  assert.deepEqual(found.map((one) => [one.tag, one.goal, one.task]), [
    ["t1", "(go hall)", run.tasks.get(2)],
    ["t2", "(take box)", null],
  ]);
  assert.deepEqual(found[1].links, [{ step: "", fact: "(held box)" }]);
  assert.equal(run.planOf(task, 6), null);
  assert.deepEqual(run.planOf(task, 9).steps, [
    { tag: "", goal: "", links: [], before: [], task: null },
  ]);
  assert.equal(run.planOf(run.tasks.get(2), 9), null);
});
