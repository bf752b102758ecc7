// Two lamps with switches: a world for rapc, without packages.
//
//     rapc run lamps.rap --world 'exec:node lamps.js' --task '(light-all)'

const lit = { hall: false, attic: false };
let now = 0;

const description = {
  protocol: 1,
  name: "lamps",
  doc: "Two lamps with switches that sometimes stick.",
  primitives: {
    press: { arguments: ["lamp"], results: ["okay", "stuck"] },
    look: { arguments: ["lamp"], results: ["okay"], sensor: true },
  },
  data: { "lamp-seen": ["lamp", "state"] },
};

function perform([name, lamp]) {
  now += 2;
  if (name === "look") {
    const seen = ["lamp-seen", lamp, lit[lamp] ? "on" : "off"];
    return { reply: { result: "okay", data: [seen] } };
  }
  if (now % 5 === 0) return { reply: { result: "stuck" } };
  lit[lamp] = true;
  return { reply: { result: "okay" } };
}

const methods = {
  describe: () => description,
  open: () => ({ now, facts: [["lamp", "hall"], ["lamp", "attic"]] }),
  perform: ({ request }) => ({ ...perform(request), now }),
  advance: ({ to }) => ({ now: (now = Math.max(now, to)) }),
};

require("readline")
  .createInterface({ input: process.stdin })
  .on("line", (line) => {
    const { id, method, params } = JSON.parse(line);
    const answer = methods[method];
    const result = answer(params);
    console.log(JSON.stringify({ jsonrpc: "2.0", id, result }));
  });
