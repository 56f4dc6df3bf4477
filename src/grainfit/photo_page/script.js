// Drag what was found on the photograph; the server measures. Texts are always set as text.
(() => {
  "use strict";

  const at = (id) => document.getElementById(id);
  const start = JSON.parse(at("start").textContent);
  const [width, height] = start.size;
  const drawing = at("drawing");
  const svg = (tag, attributes, parent = drawing) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
    Object.entries(attributes).forEach(([name, value]) => element.setAttribute(name, value));
    parent.append(element);
    return element;
  };
  drawing.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg("image", { href: "picture", width, height });
  const lines = svg("g", {});
  const handles = svg("g", {});

  const PARTS = {
    plate: {
      title: "Plate line", points: ["left end", "right end", "front"],
      hint: "The upper edge of the plate: both ends, and its nearest place.",
    },
    axis: { title: "Axis", points: ["apex"], hint: "Where the axis meets the apex." },
    outline: {
      title: "Outline", points: [],
      hint: "Double-click the line for a new point, press Delete for one less.",
    },
    corners: {
      title: "Four points", points: [],
      hint: "The corners of a level rectangle that is seen wholly: a sheet, a tile.",
    },
  };
  // What is drawn by hand, and what the program has found; pixels of this picture.
  const drawn = start.drawn;
  let found = {};
  let part = "plate";
  let answer = null;
  let dragged = null;

  const usual = {
    plate: [[0.2, 0.75], [0.8, 0.75], [0.5, 0.8]],
    axis: [[0.5, 0.3]],
    outline: [[0.25, 0.7], [0.5, 0.4], [0.75, 0.7], [0.6, 0.76], [0.4, 0.76]],
    corners: [[0.3, 0.7], [0.7, 0.7], [0.8, 0.9], [0.2, 0.9]],
  };
  const points = (name) => drawn[name] || found[name]
    || usual[name].map(([x, y]) => [x * width, y * height]);

  // --- Drawing ------------------------------------------------------------------------------------

  const path = (places, closed) => `M${places.map((place) => place.join(",")).join("L")}${closed ? "Z" : ""}`;
  const ellipse = ([left, right, front]) => {
    const middle = [(left[0] + right[0]) / 2, (left[1] + right[1]) / 2];
    const across = [(right[0] - left[0]) / 2, (right[1] - left[1]) / 2];
    const half = Math.max(Math.hypot(...across), 1);
    const down = [-across[1] / half, across[0] / half];
    const depth = Math.max(
      (front[0] - middle[0]) * down[0] + (front[1] - middle[1]) * down[1], 0.5,
    );
    return Array.from({ length: 90 }, (_, index) => {
      const turn = (index * Math.PI) / 45;
      return [0, 1].map((k) => middle[k] + across[k] * Math.cos(turn)
        + down[k] * depth * Math.sin(turn));
    });
  };
  const draw = () => {
    lines.replaceChildren();
    const line = (kind, places, closed) => places.length
      && svg("path", { class: `found ${kind}`, d: path(places, closed) }, lines);
    if (drawn.outline || found.outline || part === "outline") {
      line("outline", points("outline"), true);
    }
    if (drawn.plate || found.plate || part === "plate") {
      line("plate", ellipse(points("plate")), true);
    }
    if (drawn.corners || part === "corners") {
      line("corners", points("corners"), true);
    }
    if (answer && answer.lines) {
      const [left, right, ground] = answer.lines;
      line("flank", left);
      line("flank", right);
      line("ground", ground);
    }
    if (drawn.axis || found.axis || part === "axis") {
      const [[x, y]] = points("axis");
      const lean = answer && answer.roll ? Math.tan((answer.roll * Math.PI) / 180) : 0;
      line("axis", [[x + lean * 30, y - 30], [x - lean * (height - y), height]]);
    }
  };
  const radius = () => (9 * width) / Math.max(drawing.clientWidth, 1);
  const label = (name, index) => {
    const which = PARTS[name].points[index] || `point ${index + 1}`;
    return `${PARTS[name].title}, ${which}: move it with the arrow keys`;
  };
  const drawHandles = () => {
    handles.replaceChildren();
    points(part).forEach(([cx, cy], index) => svg("circle", {
      class: "handle", cx, cy, r: radius(), tabindex: 0, role: "button",
      "aria-label": label(part, index), "data-index": index,
    }, handles));
  };

  // --- Values -------------------------------------------------------------------------------------

  const said = (text, kind) => {
    const element = document.createElement("p");
    element.className = kind;
    element.textContent = text;
    at("value").append(element);
  };
  const degrees = (value, digits = 1) => `${value.toFixed(digits)}°`;
  const show = () => {
    at("value").replaceChildren();
    if (answer.refused) {
      said(`Not measured: ${answer.refused}`, "note");
      return;
    }
    said(`${degrees(answer.angle, 2)} ± ${degrees(answer.uncertainty, 2)}`, "photo-value");
    const [left, right] = answer.flanks.map((value) => (value === null ? "none" : degrees(value)));
    said(`Flanks ${left} and ${right}, camera ${degrees(answer.elevation[0])} above, `
      + `seen ${answer.seen}`, "quiet");
    const parts = Object.entries(answer.parts).map(([name, value]) => `${name} ${degrees(value, 2)}`);
    said(`Uncertainty: ${parts.join(", ")}`, "quiet");
  };
  const post = (address, content) => fetch(address, {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(content),
  });
  let asked = false;
  let asking = false;
  const measure = async () => {
    asked = true;
    if (asking) {
      return;
    }
    asking = true;
    // While one measurement runs, only the newest wish is kept.
    while (asked) {
      asked = false;
      at("state").textContent = "Measuring …";
      try {
        const reply = await post("measure", drawn);
        if (!reply.ok) {
          throw new Error(await reply.text());
        }
        answer = await reply.json();
        found = answer.found;
        at("state").textContent = "";
        show();
      } catch (error) {
        at("state").textContent = `No value: ${error.message}`;
      }
      draw();
      if (dragged === null && !handles.contains(document.activeElement)) {
        drawHandles();
      }
    }
    asking = false;
  };

  // --- Parts --------------------------------------------------------------------------------------

  const names = {};
  const nameParts = () => Object.entries(names).forEach(([name, element]) => {
    element.textContent = ` ${PARTS[name].title}${drawn[name] ? " (by hand)" : ""}`;
  });
  Object.keys(PARTS).forEach((name) => {
    const box = document.createElement("label");
    const radio = document.createElement("input");
    Object.assign(radio, { type: "radio", name: "part", value: name, checked: name === part });
    names[name] = document.createElement("span");
    box.append(radio, names[name]);
    at("parts").append(box);
    radio.addEventListener("change", () => {
      part = name;
      at("hint").textContent = PARTS[name].hint;
      draw();
      drawHandles();
    });
  });
  at("hint").textContent = PARTS[part].hint;
  const changed = () => {
    at("saved").textContent = "Not saved yet.";
    nameParts();
    draw();
    measure();
  };
  const moveTo = (index, x, y) => {
    drawn[part] = points(part).map((place) => [...place]);
    drawn[part][index] = [Math.min(Math.max(x, 0), width), Math.min(Math.max(y, 0), height)];
    const [cx, cy] = drawn[part][index];
    const handle = handles.children[index];
    handle.setAttribute("cx", cx);
    handle.setAttribute("cy", cy);
    changed();
  };
  const place = (event) => {
    const to = new DOMPoint(event.clientX, event.clientY)
      .matrixTransform(drawing.getScreenCTM().inverse());
    return [to.x, to.y];
  };
  drawing.addEventListener("pointerdown", (event) => {
    const index = event.target.dataset && event.target.dataset.index;
    if (index !== undefined) {
      dragged = Number(index);
      event.target.focus();
      drawing.setPointerCapture(event.pointerId);
      event.preventDefault();
    }
  });
  drawing.addEventListener("pointermove", (event) => {
    if (dragged !== null) {
      moveTo(dragged, ...place(event));
    }
  });
  ["pointerup", "pointercancel"].forEach((kind) => drawing.addEventListener(kind, () => {
    dragged = null;
  }));
  drawing.addEventListener("keydown", (event) => {
    const index = Number(event.target.dataset && event.target.dataset.index);
    const step = event.shiftKey ? 10 : 1;
    const moves = {
      ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step],
    };
    if (Number.isNaN(index)) {
      return;
    }
    if (event.key === "Delete" && part === "outline" && points(part).length > 5) {
      drawn[part] = points(part).filter((_, other) => other !== index);
      drawHandles();
      changed();
    } else if (moves[event.key]) {
      event.preventDefault();
      const [x, y] = points(part)[index];
      moveTo(index, x + moves[event.key][0], y + moves[event.key][1]);
    }
  });
  drawing.addEventListener("dblclick", (event) => {
    if (part !== "outline") {
      return;
    }
    const [x, y] = place(event);
    const corners = points(part).map((one) => [...one]);
    // Between the two neighbours whose way over the new point is the shortest detour.
    const detour = corners.map((one, index) => {
      const next = corners[(index + 1) % corners.length];
      return Math.hypot(x - one[0], y - one[1]) + Math.hypot(x - next[0], y - next[1])
        - Math.hypot(next[0] - one[0], next[1] - one[1]);
    });
    corners.splice(detour.indexOf(Math.min(...detour)) + 1, 0, [x, y]);
    drawn[part] = corners;
    drawHandles();
    changed();
  });
  at("automatic").addEventListener("click", () => {
    delete drawn[part];
    changed();
  });
  at("save").addEventListener("click", async () => {
    try {
      const reply = await post("save", drawn);
      if (!reply.ok) {
        throw new Error(await reply.text());
      }
      const { kept } = await reply.json();
      at("saved").textContent = kept
        ? `Saved in ${kept}, beside the picture.` : "Nothing is drawn by hand: no file is kept.";
    } catch (error) {
      at("saved").textContent = `Not saved: ${error.message}`;
    }
  });
  window.addEventListener("resize", drawHandles);
  nameParts();
  draw();
  drawHandles();
  measure();
})();
