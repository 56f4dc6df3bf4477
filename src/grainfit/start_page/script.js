// Questions of the interview; every answer is checked and kept by the server. Texts are set as text.
(() => {
  "use strict";

  const at = (id) => document.getElementById(id);
  const start = JSON.parse(at("start").textContent);
  let state = start.state;
  const element = (tag, properties = {}, ...children) => {
    const made = Object.assign(document.createElement(tag), properties);
    made.append(...children);
    return made;
  };
  const ENDED = "The page has ended: start it again";
  const ask = async (what, body = {}) => {
    try {
      const answer = await fetch(what, { method: "POST", body: JSON.stringify(body) });
      return answer.ok ? await answer.json() : { refused: (await answer.text()).trim() };
    } catch {
      return { refused: `${ENDED}.` };
    }
  };
  const idOf = (key) => `q-${key.replace(/[^\w-]/g, "-")}`;
  const isMeasured = (question) => question.key.includes(".targets.");

  // --- What is typed and not kept yet: a reload brings it back ------------------------------------

  const DRAFTS = "grainfit-drafts";
  const drafts = (() => {
    try {
      const kept = JSON.parse(sessionStorage.getItem(DRAFTS) || "{}");
      return kept.file === state.file ? kept.values : {};
    } catch {
      return {};
    }
  })();
  const keepDrafts = () => {
    sessionStorage.setItem(DRAFTS, JSON.stringify({ file: state.file, values: drafts }));
  };
  // Why the file cannot have a draft, by its key.
  const refused = new Map();
  const forget = (key) => {
    delete drafts[key];
    refused.delete(key);
    keepDrafts();
  };
  const sayKept = () => {
    const kept = state.text ? "Kept in the file" : "";
    at("saved").textContent = Object.keys(drafts).length ? "Not kept" : kept;
  };

  // --- Questions ----------------------------------------------------------------------------------

  const GROUPS = { material: "Material", laboratory: "Laboratory", simulation: "Simulation" };
  const say = (key, kind, text) => {
    const [field, line] = [at(idOf(key)), at(`${idOf(key)}-said`)];
    if (!line) {
      return;
    }
    line.className = kind;
    line.textContent = text;
    if (field && field.tagName === "INPUT") {
      field.setAttribute("aria-invalid", String(kind === "refused"));
    }
  };
  const sayRefused = (key, why) => {
    at("saved").textContent = "Not kept";
    say(key, "refused", why);
    if (key in drafts) {
      refused.set(key, why);
    }
  };
  const keep = async (key, given) => {
    at("saved").textContent = "Checking …";
    const found = await ask("answer", { key, given });
    if (found.refused) {
      sayRefused(key, found.refused);
      return false;
    }
    // More may have been typed since.
    if (drafts[key] === given) {
      forget(key);
    }
    show(found);
    sayKept();
    refresh();
    return true;
  };
  const trying = new Map();
  const tryOut = (key, given) => {
    clearTimeout(trying.get(key));
    const kept = (state.questions || []).find((one) => one.key === key);
    if (kept && kept.answer === given) {
      forget(key);
      say(key, "implies", kept.implies);
      sayKept();
      estimateKept();
      return;
    }
    drafts[key] = given;
    keepDrafts();
    trying.set(key, setTimeout(async () => {
      const found = await ask("try", { key, given });
      if (drafts[key] !== given) {
        return;
      }
      if (found.refused) {
        sayRefused(key, found.refused);
        return;
      }
      refused.delete(key);
      say(key, "implies", found.implies);
      if (key.includes(".targets.")) {
        estimate({ key, given });
      }
    }, 350));
  };

  // What does not fit into the field is said above it.
  const LONGEST = 24;
  const usual = ({ usual: words }) => (words ? `usual: ${words}` : "");
  const isLong = (question) => usual(question).length > LONGEST;
  const textField = (question) => {
    const id = idOf(question.key);
    const field = element("input", {
      id, type: "text", autocomplete: "off", spellcheck: false,
      value: drafts[question.key] ?? question.answer,
      placeholder: isMeasured(question) ? question.usual : isLong(question) ? "" : usual(question),
    });
    if (question.key === "material") {
      field.setAttribute("list", "materials");
    }
    field.setAttribute("aria-describedby", `${id}-help ${id}-said`);
    field.addEventListener("input", () => tryOut(question.key, field.value));
    field.addEventListener("change", () => {
      clearTimeout(trying.get(question.key));
      keep(question.key, field.value);
    });
    return field;
  };
  const selection = (question) => {
    const field = element("select", { id: idOf(question.key) });
    field.setAttribute("aria-describedby", `${field.id}-help ${field.id}-said`);
    if (!question.answer) {
      field.append(element("option", { value: "", textContent: question.usual || "–" }));
    }
    if (question.answer && !(question.answer in question.options)) {
      field.append(element("option", { value: question.answer, textContent: question.answer }));
    }
    Object.entries(question.options).forEach(([value, words]) => {
      field.append(element("option", { value, textContent: words ? `${value}: ${words}` : value }));
    });
    field.value = question.answer;
    field.addEventListener("change", async () => {
      if (!await keep(question.key, field.value)) {
        field.value = question.answer;
      }
    });
    return field;
  };
  const choices = (question) => {
    const chosen = new Set(question.answer.split(",").map((name) => name.trim()));
    const box = element("div", {});
    const things = element("div", { className: "choices" });
    const instruments = element("div", { className: "choices" });
    const named = start.instruments.filter((name) => question.key === "at_hand"
      && name in question.options);
    box.append(things);
    if (named.length) {
      box.append(element("details", { open: named.some((name) => chosen.has(name)) },
        element("summary", { textContent: "Instruments by name" }), instruments));
    }
    Object.entries(question.options).forEach(([value, words]) => {
      const id = `${idOf(question.key)}-${value}`;
      const tick = element("input", { type: "checkbox", id, value, checked: chosen.has(value) });
      tick.addEventListener("change", async () => {
        const ticked = [...box.querySelectorAll("input:checked")].map((one) => one.value);
        if (!await keep(question.key, ticked.join(", "))) {
          tick.checked = chosen.has(value);
        }
      });
      const shown = question.key === "tests" ? `${value}: ${words}` : words;
      (named.includes(value) ? instruments : things).append(
        element("label", { htmlFor: id }, tick, element("span", { textContent: shown })));
    });
    return box;
  };
  const read = (file) => new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(reader.result.slice(reader.result.indexOf(",") + 1));
    reader.onerror = () => reject(reader.error);
    reader.readAsDataURL(file);
  });
  const addPictures = async (key, files) => {
    const [many, faults] = [files.length, []];
    for (const [number, file] of files.entries()) {
      at("saved").textContent = `Measuring picture ${number + 1} of ${many} …`;
      try {
        const body = { key, name: file.name, content: await read(file) };
        const found = await ask("picture", body);
        if (found.refused) {
          const isNamed = found.refused.includes(file.name);
          faults.push(isNamed ? found.refused : `${file.name}: ${found.refused}`);
        } else {
          forget(key);
          show(found);
        }
      } catch {
        faults.push(`${file.name} cannot be read.`);
      }
    }
    sayKept();
    if (faults.length) {
      if (faults.length === many) {
        at("saved").textContent = "Not kept";
      }
      const kept = state.questions.find((one) => one.key === key);
      say(key, "refused", `Not kept: ${faults.join(" ")} ${(kept && kept.implies) || ""}`);
    }
    refresh();
  };
  const pictured = (question) => {
    const id = `${idOf(question.key)}-pictures`;
    const field = element("input", { id, type: "file", multiple: true, accept: "image/*,.heic" });
    field.addEventListener("change", () => addPictures(question.key, [...field.files]));
    const shown = question.overlays.map((_, number) => element("img", {
      src: `overlay/${number}/${encodeURIComponent(question.key)}`,
      alt: `What was measured on picture ${number + 1}`,
    }));
    return element("div", { className: "pictures" },
      element("label", { htmlFor: id, textContent: "Add pictures" }), field, ...shown);
  };
  const drawn = (question) => {
    const id = idOf(question.key);
    const said = element("p", { id: `${id}-said`, className: "implies", textContent: question.implies });
    said.setAttribute("aria-live", "polite");
    const isTyped = !question.several && !Object.keys(question.options).length;
    const more = isTyped && !isMeasured(question) && isLong(question)
      ? ` ${usual(question).replace(/^u/, "U")}.` : "";
    const help = element("p", {
      id: `${id}-help`, className: "help", textContent: `${question.help}${more}`,
    });
    const title = question.text;
    if (question.several) {
      const box = element("fieldset", { className: "question" },
        element("legend", { textContent: title }), help, choices(question), said);
      if (question.key === "tests") {
        const result = element("div", { id: "comparison", className: "wide" });
        const button = element("button", {
          type: "button", id: "compare", textContent: "Compare these tests by the atlas",
        });
        button.addEventListener("click", () => compare(button, result));
        box.append(button, result);
      }
      return box;
    }
    const pictures = question.takes_pictures ? [pictured(question)] : [];
    const field = Object.keys(question.options).length ? selection(question) : textField(question);
    const label = element("label", { htmlFor: id, textContent: title });
    return element("div", { className: "question" }, label, help, field, ...pictures, said);
  };

  const rebuild = () => {
    const focused = document.activeElement && document.activeElement.id;
    const sections = new Map();
    (state.questions || []).forEach((question) => {
      if (!sections.has(question.group)) {
        const title = GROUPS[question.group] || `Test: ${question.group}`;
        const id = `group-${idOf(question.group)}`;
        const section = element("section", { className: "section" },
          element("h2", { id, textContent: title }));
        section.setAttribute("aria-labelledby", id);
        const steps = state.steps[question.group] || [];
        if (steps.length) {
          section.append(element("details", {}, element("summary", { textContent: "How to measure" }),
            element("ol", {}, ...steps.map((step) => element("li", { textContent: step })))));
        }
        const drawing = state.drawings[question.group];
        if (drawing) {
          const box = element("div", { className: "wide", tabIndex: 0 }, element("img", {
            src: `data:image/svg+xml,${encodeURIComponent(drawing)}`,
            alt: "The apparatus, with its dimensions and what is measured", className: "apparatus",
          }));
          box.setAttribute("role", "region");
          box.setAttribute("aria-label", `Drawing of the test ${question.group}`);
          section.append(box);
        }
        sections.set(question.group, section);
      }
      const section = sections.get(question.group);
      if (question.entry && !section.querySelector(".entry")) {
        section.append(element("p", { className: "entry help", textContent: question.entry }));
      }
      section.append(drawn(question));
      const remark = { material: state.remark, tests: state.enlargement }[question.key];
      if (remark) {
        section.append(element("p", { className: "note", textContent: remark }));
      }
    });
    at("questions").replaceChildren(...sections.values());
    const again = focused && at(focused);
    if (again) {
      again.focus();
    }
  };
  // What is said below each field, and not kept.
  const sayAll = () => {
    (state.questions || []).filter(({ key }) => !(key in drafts)).forEach(({ key, implies }) => {
      say(key, "implies", implies);
    });
    Object.entries(drafts).forEach(([key, given]) => {
      if (refused.has(key)) {
        say(key, "refused", refused.get(key));
      }
      tryOut(key, given);
    });
  };

  // --- What follows from them ---------------------------------------------------------------------

  const parts = (found) => found.map((part) => {
    if (typeof part === "string") {
      return element("p", { textContent: part });
    }
    const row = (cells, tag) => element("tr", {}, ...cells.map((cell) => {
      const made = element(tag, { textContent: cell });
      if (tag === "th") {
        made.scope = "col";
      }
      return made;
    }));
    const table = element("table", {}, element("thead", {}, row(part.header, "th")),
      element("tbody", {}, ...part.rows.map((cells) => row(cells, "td"))));
    const box = element("div", { className: "wide", tabIndex: 0 }, table);
    box.setAttribute("role", "region");
    box.setAttribute("aria-label", part.header.filter(Boolean).join(", "));
    return element("div", {}, box, element("p", { className: "quiet", textContent: part.caption }));
  });
  const hasValues = () => (state.questions || []).some((one) => isMeasured(one) && one.answer);

  let asking = false;
  // What was typed last; null where nothing is asked.
  let newest = null;
  const estimate = async (typed = {}) => {
    newest = typed;
    at("estimate-box").hidden = false;
    if (asking) {
      return;
    }
    asking = true;
    while (newest) {
      const current = newest;
      newest = null;
      at("estimate-state").textContent = "Asking the atlas …";
      const found = await ask("estimate", current);
      if (newest || at("estimate-box").hidden) {
        continue;
      }
      at("estimate-state").textContent = "";
      document.body.classList.toggle("estimated", !found.refused);
      at("estimate").replaceChildren(...(found.refused
        ? [element("p", { className: "quiet", textContent: `None yet: ${found.refused}` })]
        : parts(found.parts)));
    }
    asking = false;
  };
  const estimateKept = () => {
    if (hasValues()) {
      estimate();
      return;
    }
    newest = null;
    at("estimate-box").hidden = true;
    document.body.classList.remove("estimated");
  };
  const compare = async (button, result) => {
    button.disabled = true;
    result.replaceChildren(element("p", { className: "quiet", textContent: "Asking the atlas …" }));
    const found = await ask("compare");
    result.replaceChildren(...(found.refused
      ? [element("p", { className: "refused", textContent: found.refused })]
      : parts(found.parts)));
    button.disabled = false;
  };
  const list = (title, lines, kinds = []) => (lines.length
    ? [element("h3", { textContent: title }),
      element("ul", {}, ...lines.map((line, number) => element("li", {
        className: kinds[number] || "", textContent: line.trim(),
      })))]
    : []);
  let planned = 0;
  let canStart = false;
  const offerStart = () => {
    at("run").hidden = !canStart || isRunning();
  };
  const plan = async () => {
    planned += 1;
    const mine = planned;
    canStart = false;
    offerStart();
    if (!state.questions || state.left.length) {
      at("plan").replaceChildren();
      at("plan-state").textContent = "";
      return;
    }
    at("plan-state").textContent = "Working out cost and forecast …";
    const found = await ask("plan");
    if (mine !== planned) {
      return;
    }
    at("plan-state").textContent = "";
    if (found.refused) {
      at("plan").replaceChildren(element("p", { className: "note", textContent: found.refused }));
      return;
    }
    const main = found.lines.filter((line) => /^(DEM runs|Time):/.test(line));
    const rest = found.lines.filter((line) => !main.includes(line));
    at("plan").replaceChildren(
      ...main.map((line) => element("p", {}, element("strong", { textContent: line }))),
      ...list("In the way", found.problems),
      ...list("Notes", found.notes.map((note) => note.text), found.notes.map((note) => note.check)),
      element("details", {}, element("summary", { textContent: "All that is planned" }),
        ...list("Plan", rest)),
      ...list("A start executes, with your rights", found.executes));
    canStart = !found.problems.length;
    offerStart();
  };
  const isRunning = () => Boolean(state.run && state.run.running);
  const refresh = () => {
    estimateKept();
    plan();
  };

  // --- The calibration ----------------------------------------------------------------------------

  const follow = () => {
    const run = state.run || {};
    offerStart();
    at("full-size").hidden = run.state !== "predicted" || Boolean(run.earlier);
    const shown = [];
    if (run.watch) {
      const words = isRunning() ? "It runs. Follow it" : `Open the calibration in ${run.folder}`;
      shown.push(element("p", {}, element("a", {
        href: run.watch, id: "watch", target: "_blank", rel: "noopener", textContent: words,
      })));
    }
    const ended = isRunning() ? "" : run.ended || (run.code ? `exit code ${run.code}` : "");
    if (ended) {
      const what = run.earlier ? "The calibration of the earlier file" : "It";
      shown.push(element("p", { textContent: `${what} has ended: ${ended}. Its page leads to the report.` }));
    }
    if (run.said) {
      const pre = element("pre", { textContent: run.said, tabIndex: 0 });
      pre.setAttribute("role", "region");
      pre.setAttribute("aria-label", "End of its output");
      shown.push(pre);
    }
    const text = shown.map((one) => one.textContent).join("\n");
    if (at("followed").textContent !== shown.map((one) => one.textContent).join("") || !text) {
      at("followed").replaceChildren(...shown);
    }
  };
  const handOver = () => {
    const run = state.run || {};
    const offers = Object.entries(run.offers || {});
    at("hand-box").hidden = !offers.length;
    at("earlier").hidden = !run.earlier;
    at("earlier").textContent = run.earlier || "";
    if (at("offers").children.length !== offers.length) {
      at("offers").replaceChildren(...offers.map(([name, title]) => element("li", {},
        element("a", { href: `hand-over/${name}`, textContent: title }))));
    }
  };
  // Seldom before it runs: it may be started in a terminal.
  const [LOOK, LOOK_SELDOM] = [1000, 5000];
  const look = async () => {
    // Nobody sees a hidden page; it looks again once it is shown.
    if (document.hidden) {
      return;
    }
    try {
      const run = await (await fetch("run")).json();
      const was = isRunning();
      state.run = run;
      follow();
      handOver();
      if (was && !isRunning()) {
        plan();
      }
    } catch {
      at("saved").textContent = ENDED;
      return;
    }
    lookSoon();
  };
  let looking = 0;
  const lookSoon = () => {
    clearTimeout(looking);
    looking = setTimeout(look, isRunning() ? LOOK : LOOK_SELDOM);
  };
  document.addEventListener("visibilitychange", () => {
    clearTimeout(looking);
    look();
  });
  // What is typed is in the file before a start, or the start is not made.
  const keepAll = async () => {
    for (const [key, given] of Object.entries(drafts)) {
      await keep(key, given);
    }
    const [open] = (state.questions || []).filter((one) => one.key in drafts);
    if (open) {
      at("plan-state").textContent = `Not started: correct or empty “${open.text}” first.`;
      at(idOf(open.key)).focus();
    }
    return !open;
  };
  const begin = async (given) => {
    if (!await keepAll()) {
      return;
    }
    at("run").hidden = true;
    at("full-size").hidden = true;
    at("plan-state").textContent = "Starting …";
    const found = await ask("run", { given });
    at("plan-state").textContent = found.refused || "";
    if (found.refused) {
      look();
      return;
    }
    show(found);
    at("watch").focus();
    lookSoon();
  };
  at("run").addEventListener("click", () => begin(""));
  at("full-size").addEventListener("click", () => begin("--full-size"));

  // --- All of it ----------------------------------------------------------------------------------

  const show = (found) => {
    const shape = (of) => JSON.stringify([of.remark, of.enlargement, (of.questions || [])
      .map((one) => [one.key, one.options, one.answer, one.overlays])]);
    const isOther = shape(found) !== shape(state) || !at("questions").children.length;
    state = found;
    const asked = state.questions && state.questions.map((one) => one.key);
    Object.keys(drafts).filter((key) => asked && !asked.includes(key)).forEach(forget);
    at("fault").hidden = !state.fault;
    at("fault").textContent = state.fault
      ? `${state.fault} Mend it in an editor, then reload this page.` : "";
    const [material] = state.questions || [];
    const name = material && material.answer;
    at("title").textContent = name || "New calibration";
    document.title = `${name || "New calibration"} – grainfit`;
    at("file-name").textContent = state.file;
    at("file-text").textContent = state.text || "";
    at("file-details").hidden = !state.text;
    at("left").textContent = (state.left || []).join(" ");
    at("sheet-line").hidden = !(state.questions || [])
      .some((one) => one.key === "tests" && one.answer);
    if (isOther) {
      rebuild();
    }
    sayAll();
    follow();
    handOver();
  };
  start.materials.forEach(({ name, title }) => {
    at("materials").append(element("option", { value: name, textContent: title }));
  });
  show(state);
  refresh();
  lookSoon();
})();
