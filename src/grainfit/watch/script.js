// Fill the page with the state whenever a new one comes in. Texts are always set as text.
(() => {
  "use strict";

  const at = (id) => document.getElementById(id);
  const make = (tag, attributes = {}, ...children) => {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (name === "class") {
        element.className = value;
      } else if (value !== null && value !== undefined && value !== false) {
        element.setAttribute(name, value);
      }
    }
    element.append(...children.filter((child) => child !== null && child !== undefined));
    return element;
  };
  const drawn = (tag, attributes) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
    Object.entries(attributes).forEach(([name, value]) => element.setAttribute(name, value));
    return element;
  };
  const counted = (count, noun) => `${count} ${noun}${count === 1 ? "" : "s"}`;

  // --- Times: those of the server, whose clock may differ from this one's -----------------------

  let clock = 0;
  const now = () => clock + performance.now() / 1000;
  const two = (value) => String(value).padStart(2, "0");
  const duration = (seconds) => {
    const whole = Math.max(0, Math.round(seconds));
    const [hours, minutes, rest] = [
      Math.floor(whole / 3600), Math.floor((whole % 3600) / 60), whole % 60,
    ];
    if (hours) {
      return `${hours} h ${two(minutes)} min`;
    }
    return minutes ? `${minutes} min ${two(rest)} s` : `${rest} s`;
  };
  // Without seconds where they would feign precision.
  const roughly = (seconds) => {
    if (seconds < 90) {
      return `${Math.max(1, Math.round(seconds))} s`;
    }
    if (seconds < 5400) {
      return `${Math.round(seconds / 60)} min`;
    }
    return seconds < 36000
      ? `${Math.floor(seconds / 3600)} h ${two(Math.round((seconds % 3600) / 60) % 60)} min`
      : `${Math.round(seconds / 3600)} h`;
  };
  // Texts that change with time alone.
  const ticking = new Map();
  const tick = () => {
    for (const [element, words] of ticking) {
      if (element.isConnected) {
        const text = words();
        if (element.textContent !== text) {
          element.textContent = text;
        }
      } else {
        ticking.delete(element);
      }
    }
  };
  const ticks = (element, words) => {
    ticking.set(element, words);
    element.textContent = words();
    return element;
  };
  setInterval(tick, 1000);

  // --- Parts of the page: written again only when they change -----------------------------------

  const written = new Map();
  const fill = (id, key, ...children) => {
    const section = at(id);
    const place = section.querySelector(":scope > .content") ?? section;
    if (written.get(id) === key) {
      return;
    }
    written.set(id, key);
    const open = new Set(
      [...place.querySelectorAll("details[open]")].map((one) => one.dataset.key),
    );
    section.hidden = children.length === 0;
    place.replaceChildren(...children);
    window.grainfitScrolls(place);
    for (const details of place.querySelectorAll("details")) {
      details.open = open.has(details.dataset.key);
    }
  };
  // Head of a column that is clear to the eye.
  const unseen = (words) => make("span", { class: "visually-hidden" }, words);
  const table = (heads, rows) =>
    make("div", { class: "table-wrap" },
      make("table", { class: "data" },
        make("thead", {}, make("tr", {}, ...heads.map((head) => make("th", { scope: "col" }, head)))),
        make("tbody", {}, ...rows.map((cells) =>
          make("tr", {}, ...cells.map((cell, column) => {
            const tag = column === 0 ? "th" : "td";
            const shown = cell instanceof Array ? cell : [cell];
            const label = typeof heads[column] === "string" ? heads[column] : "";
            const given = column === 0 ? { scope: "row" } : { "data-label": label };
            const wide = shown.some((one) => one instanceof SVGElement);
            return make(tag, { ...given, class: wide ? "wide" : "" }, ...shown);
          })),
        )),
      ),
    );
  const named = (row) =>
    row.words === row.name ? row.words : make("abbr", { title: row.name }, row.words);
  // The box at the top says by what it is biased.
  const determined = ({ determination, bias }) =>
    bias ? [make("abbr", { title: bias }, determination)] : determination;
  // A long number may break before its error, and nowhere else.
  const unit = (text, sign) => {
    const whole = sign ? `${text}${sign === "°" ? "" : "\u00a0"}${sign}` : text;
    return text ? whole.replace(" ± ", " ±\u00a0") : text;
  };
  const GRADES = { met: "good", "in doubt": "warn", missed: "bad" };
  const SIGNS = { met: "✓ ", "in doubt": "? ", missed: "✗ " };
  const judged = (text) => {
    const word = Object.keys(GRADES).find((one) => text.startsWith(one));
    return word ? make("span", { class: `mark ${GRADES[word]}` }, SIGNS[word] + text) : text;
  };

  const responseBar = (bar, words) => {
    const svg = drawn("svg", {
      class: "watch-bar", viewBox: "0 0 100 22", preserveAspectRatio: "none", role: "img",
      "aria-label": words,
    });
    const line = (kind, x1, x2, y1, y2) => drawn("line", { class: kind, x1, x2, y1, y2 });
    const width = bar.to - bar.from;
    svg.append(
      line("axis", 0, 100, 11, 11),
      drawn("rect", { class: "within", x: bar.from, y: 2, width, height: 18 }),
      line("axis", 50, 50, 2, 20),
      line("expected", bar.low, bar.high, 11, 11),
      line("place", bar.value, bar.value, 11, 11),
    );
    return svg;
  };

  const showVerdict = ({ verdict, progress, started, state, run_counts: runs }) => {
    const box = make("div", { class: `verdict ${verdict.grade}` },
      make("p", { class: "verdict-line" },
        make("span", { class: "mark", "aria-hidden": "true" }, verdict.mark), ` ${verdict.line}`),
      ...verdict.details.map((words) => make("p", {}, words)));
    const parts = [box];
    if (progress) {
      const steps = make("dl", { class: "watch-steps" });
      const step = (name, ...value) =>
        steps.append(make("div", {}, make("dt", {}, name), make("dd", {}, ...value)));
      step("Runs ended", String(progress.done));
      if (state === "running") {
        const waiting = (runs.waiting ?? 0) + (runs.again ?? 0) + (runs.elsewhere ?? 0);
        const begun = (runs.running ?? 0) + (runs.submitted ?? 0);
        step("Under way", `${begun}${waiting ? `, ${waiting} waiting` : ""}`);
        if (progress.left) {
          const [low, high] = progress.left;
          step("To come", low === high ? `about ${high}` : `${low} to ${high}`);
        }
        const left = make("span");
        step("Time left", ticks(left, () => timeLeft(progress)));
        const elapsed = make("span");
        step("Running for", ticks(elapsed, () => duration(now() - started)));
      }
      if (progress.stage) {
        parts.push(make("p", {}, `${progress.stage}.`));
      }
      parts.push(steps);
      if (progress.left) {
        const whole = progress.done + (progress.left[0] + progress.left[1]) / 2;
        parts.push(make("progress", {
          class: "watch-done", max: whole || 1, value: progress.done,
          "aria-label": "Share of the runs that have ended",
        }));
      }
    }
    fill("verdict", JSON.stringify([verdict, progress, started, state, runs]), ...parts);
  };

  const timeLeft = ({ seconds_left: left, estimated }) => {
    if (!left) {
      return "not known yet";
    }
    const gone = now() - estimated;
    const [low, high] = left.map((seconds) => Math.max(0, seconds - gone));
    if (high <= 0) {
      return "longer than expected";
    }
    const [first, last] = [roughly(low), roughly(high)];
    return low < 1 || first === last ? `at most ${last}` : `${first} to ${last}`;
  };

  const showFailures = ({ failures, failed, several }) => {
    const more = failed - failures.length;
    const parts = failures.map((run) =>
      make("div", { class: "watch-failure" },
        make("p", {}, make("strong", {}, `Run ${run.number}${several ? `, ${run.test}` : ""}: `),
          run.reason),
        run.folder ? make("p", { class: "quiet" }, make("code", {}, run.folder)) : null,
        run.log
          ? make("details", { "data-key": run.key },
            make("summary", {}, "End of its log"), make("pre", {}, run.log))
          : null,
      ));
    if (more > 0) {
      parts.push(make("p", { class: "quiet" }, `And ${counted(more, "earlier one")}.`));
    }
    const first = parts.slice(0, 3);
    const rest = parts.slice(3);
    if (rest.length) {
      first.push(make("details", { "data-key": "older" },
        make("summary", {}, `${counted(failed - 3, "earlier failure")}`), ...rest));
    }
    fill("failures", JSON.stringify([failures, failed]), ...first);
    at("failures-title").textContent = `${counted(failed, "run")} failed`;
  };

  const showResponses = ({ responses, provisional }) => {
    const rows = responses.map((row) => [
      [named(row)],
      unit(row.measured, row.unit),
      unit(row.expected, row.unit),
      row.bar ? responseBar(row.bar, `${row.name}: ${row.expected}, measured ${row.measured}`) : "",
      row.deviation,
      judged(row.verdict),
    ]);
    const parts = rows.length
      ? [table(
        ["response", "measured", "expected", unseen("drawn"), "deviation", unseen("verdict")], rows,
      )]
      : [];
    if (responses.some((row) => row.bar)) {
      const by = provisional ? " by the runs so far" : "";
      parts.push(make("p", { class: "quiet" },
        `Measured ± tolerance (box); expected${by} ± half of the 95 % interval (line).`));
    }
    fill("responses", JSON.stringify([responses, provisional]), ...parts);
  };

  const showParameters = ({ parameters, provisional }) => {
    const known = parameters.some((row) => row.value);
    const intervals = parameters.some((row) => row.interval);
    const heads = ["parameter", known ? (provisional ? "so far" : "value") : null,
      intervals ? "95 % interval" : null, intervals ? "by the runs" : null, "searched"];
    const rows = parameters.map((row) => [
      [named(row)], known ? unit(row.value, row.unit) : null,
      intervals ? unit(row.interval, row.unit) : null, intervals ? determined(row) : null,
      unit(row.searched, row.unit),
    ]);
    const keep = (cells) => cells.filter((cell) => cell !== null);
    const parts = rows.length ? [table(keep(heads), rows.map(keep))] : [];
    fill("parameters", JSON.stringify([parameters, provisional]), ...parts);
  };

  const STATES = {
    running: "running", submitted: "submitted", waiting: "waiting for a worker",
    again: "to be tried again", elsewhere: "by another process",
  };
  const showRuns = ({ runs, run_counts: counts, several, shown, state }) => {
    const rows = runs.map((run) => {
      const since = make("span");
      const usual = run.usual ? `, usually ${roughly(run.usual)}` : "";
      if (run.since) {
        ticks(since, () => `${duration(now() - run.since)}${run.state === "running" ? usual : ""}`);
      }
      const again = run.tries > 1 ? `, try ${run.tries}` : "";
      const cells = [
        `Run ${run.number ?? run.key}`,
        `${STATES[run.state]}${again}`,
        [since],
        run.stage,
        run.parameters,
      ];
      if (several) {
        cells.splice(1, 0, run.test);
      }
      return cells;
    });
    const heads = [unseen("run"), "state", "for", "stage", "parameters"];
    if (several) {
      heads.splice(1, 0, "test");
    }
    const all = Object.values(counts).reduce((sum, count) => sum + count, 0);
    const parts = rows.length ? [table(heads, rows)] : [];
    if (all > shown) {
      parts.push(make("p", { class: "quiet" }, `And ${counted(all - shown, "more run")}.`));
    }
    if (!parts.length && state === "running") {
      parts.push(make("p", { class: "quiet" }, "The next run is being chosen."));
    }
    fill("runs", JSON.stringify([runs, counts, state]), ...parts);
  };

  const showJobs = ({ jobs }) => {
    const rows = jobs.map((job) => [job.number, job.state, job.words]);
    fill("jobs", JSON.stringify(jobs), ...(rows.length ? [table(["job", "state", unseen("more")], rows)] : []));
  };

  const showNotices = ({ notices }) => {
    const list = make("ul", {}, ...notices.map((words) => make("li", {}, words)));
    fill("notices", JSON.stringify(notices), ...(notices.length ? [list] : []));
  };

  // --- Particles --------------------------------------------------------------------------------

  const drawings = new Map();
  const showDrawings = ({ drawings: newest }) => {
    for (const [key, { section }] of drawings) {
      if (!newest.some((about) => about.key === key)) {
        section?.remove();
        drawings.delete(key);
      }
    }
    for (const about of newest) {
      const known = drawings.get(about.key);
      if (known?.run !== about.run) {
        drawings.set(about.key, { ...known, run: about.run });
        fetchDrawing(about);
      }
    }
  };
  const fetchDrawing = async (about) => {
    const known = drawings.get(about.key);
    let content = null;
    try {
      const answer = await fetch(`drawing/${encodeURIComponent(about.key)}`);
      content = answer.ok ? await answer.json() : null;
    } catch {
      content = null;
    }
    if (content === null || drawings.get(about.key)?.run !== about.run) {
      return;
    }
    const section = make("section", { class: "section" }, make("h2", {}, about.title),
      about.words ? make("p", {}, `${about.words}.`) : null);
    const place = () =>
      known.section ? known.section.replaceWith(section) : at("drawings").append(section);
    if (about.kind === "picture") {
      section.append(make("img", { class: "particles-picture", src: content, alt: about.words }));
      place();
    } else if (about.kind === "page") {
      // Of the report: every value in it is escaped, and no script of a page like this one runs.
      section.append(...new DOMParser().parseFromString(content, "text/html").body.childNodes);
      place();
    } else {
      const canvas = make("canvas", {
        class: "particles-3d", tabindex: "0", role: "img",
        "aria-label": `${about.title} in three dimensions, coloured by height`,
      });
      section.append(canvas, make("p", { class: "quiet" },
        `${counted(about.particles, "particle")}. Turn with the mouse, a finger, or the arrow keys; + and − zoom.`));
      place();
      known.draw = window.grainfitParticles(canvas, content, known.draw?.view());
    }
    known.section = section;
    drawings.set(about.key, known);
  };

  // --- The whole state --------------------------------------------------------------------------

  let ended = false;
  const show = (state) => {
    clock = state.now - performance.now() / 1000;
    ended = state.ended;
    at("name").textContent = state.name;
    at("folder").textContent = `${state.folder}.`;
    document.title = `${state.verdict.mark} ${state.title}: ${state.name} – grainfit`;
    showVerdict(state);
    showFailures(state);
    showResponses(state);
    showParameters(state);
    showRuns(state);
    showJobs(state);
    showNotices(state);
    showDrawings(state);
    showStop(state);
    showConnection(state);
  };

  let report = null;
  const showConnection = (state) => {
    const words = ended
      ? "The run has ended, and this page with it: grainfit watch shows it again."
      : state.state === "running" ? "Live" : "Nothing is running";
    at("connection").textContent = words;
    if (state.report && !ended && !report) {
      report = make("a", { href: "report", target: "_blank", rel: "noopener" }, "Report");
      at("connection").after(report);
    } else if (report && (!state.report || ended)) {
      report.remove();
      report = null;
    }
  };

  // --- Stop --------------------------------------------------------------------------------------

  let stopping = false;
  const button = at("stop");
  const showStop = ({ state, stop }) => {
    stopping &&= state === "running";
    button.hidden = state !== "running" || ended;
    button.disabled = stopping || !stop.possible;
    button.textContent = stopping ? "Stopping …" : "Stop …";
    button.title = stop.possible ? "" : stop.why;
    if (!button.hidden && !stop.possible && stop.why) {
      fill("stop-reason", stop.why, `Cannot be stopped from here: ${stop.why}`);
    } else {
      fill("stop-reason", "");
    }
  };
  at("verdict").after(make("p", { id: "stop-reason", class: "note", hidden: "" }));
  button.addEventListener("click", () => at("confirm").showModal());
  at("confirm-not").addEventListener("click", () => at("confirm").close());
  at("confirm-stop").addEventListener("click", async () => {
    at("confirm").close();
    stopping = true;
    button.disabled = true;
    button.textContent = "Stopping …";
    let why = "";
    try {
      const answer = await fetch("stop", { method: "POST" });
      why = answer.ok ? "" : ((await answer.json()).why ?? "it was refused.");
    } catch {
      why = "the server does not answer.";
    }
    if (why) {
      stopping = false;
      button.disabled = false;
      button.textContent = "Stop …";
      fill("stop-reason", why, `It could not be stopped: ${why}`);
    }
  });

  // --- Events ------------------------------------------------------------------------------------

  const source = new EventSource("events");
  source.addEventListener("message", (event) => show(JSON.parse(event.data)));
  source.addEventListener("error", () => {
    if (ended) {
      source.close();
      return;
    }
    at("connection").textContent =
      "No connection: what is shown may be old. Trying again …";
    button.disabled = true;
    document.title = `? ${document.title.replace(/^\? /, "")}`;
  });
})();
