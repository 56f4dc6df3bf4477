// Particles that can be turned: shaded spheres, drawn from back to front, between the walls behind
// them and the walls in front of them.
(() => {
  "use strict";

  const scenes = window.grainfitData("particles") ?? {};
  // From low to high, lighter and lighter (after cividis, Nuñez, Anderton & Renslow 2018).
  const STOPS = [
    [53, 85, 143], [93, 115, 150], [139, 141, 140], [194, 171, 112], [254, 232, 56],
  ];
  const BINS = 32;
  const SPRITE = 64;

  const colour = (share) => {
    const place = Math.min(Math.max(share, 0), 1) * (STOPS.length - 1);
    const low = Math.min(Math.floor(place), STOPS.length - 2);
    return STOPS[low].map((v, i) => v + (place - low) * (STOPS[low + 1][i] - v));
  };

  const shade = (rgb, factor) => `rgb(${rgb.map((v) => Math.min(255, v * factor)).join(",")})`;

  const makeSprite = (rgb) => {
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = SPRITE;
    const pen = canvas.getContext("2d");
    const half = SPRITE / 2;
    const light = pen.createRadialGradient(half * 0.7, half * 0.6, 0, half, half, half);
    light.addColorStop(0, shade(rgb, 1.25));
    light.addColorStop(0.55, shade(rgb, 0.95));
    light.addColorStop(1, shade(rgb, 0.5));
    pen.fillStyle = light;
    pen.beginPath();
    pen.arc(half, half, half - 0.5, 0, 2 * Math.PI);
    pen.fill();
    return canvas;
  };
  let sprites = null;

  const unpack = (text) => {
    const bytes = Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    return Float32Array.from({ length: bytes.length / 2 }, (_, i) => view.getInt16(2 * i, true));
  };

  const drawArrow = (pen, [x1, y1], [x2, y2], ink, width) => {
    const length = Math.hypot(x2 - x1, y2 - y1);
    if (length < 1) {
      return;
    }
    const [u, v] = [(x2 - x1) / length, (y2 - y1) / length];
    const head = Math.min(0.4 * length, 5 * width);
    const [nx, ny] = [x2 - head * u, y2 - head * v];
    pen.lineWidth = width;
    pen.strokeStyle = pen.fillStyle = ink;
    pen.beginPath();
    pen.moveTo(x1, y1);
    pen.lineTo(nx, ny);
    pen.stroke();
    pen.beginPath();
    pen.moveTo(x2, y2);
    pen.lineTo(nx - 0.5 * head * v, ny + 0.5 * head * u);
    pen.lineTo(nx + 0.5 * head * v, ny - 0.5 * head * u);
    pen.fill();
  };

  // Several drawings may have one camera: turning one turns all.
  const USUAL = { azimuth: 0.5, elevation: 0.35, zoom: 1 };
  const makeCamera = (view) => ({ ...USUAL, ...view, redraws: new Set() });
  // Place of a particle that is not there.
  const GONE = -32768;

  // Corners of a wall that has moved along an axis, or turned about it.
  const movedCorners = (wall, corners, place) => {
    const moved = corners.slice();
    if (!wall.turns) {
      for (let i = wall.axis; i < moved.length; i += 3) {
        moved[i] += place;
      }
      return moved;
    }
    const [first, second] = [(wall.axis + 1) % 3, (wall.axis + 2) % 3];
    const [cosine, sine] = [Math.cos(place), Math.sin(place)];
    for (let i = 0; i < moved.length; i += 3) {
      const u = corners[i + first] - wall.through[first];
      const v = corners[i + second] - wall.through[second];
      moved[i + first] = wall.through[first] + u * cosine - v * sine;
      moved[i + second] = wall.through[second] + u * sine + v * cosine;
    }
    return moved;
  };

  const show = (canvas, scene, view) => {
    const loose = unpack(scene.particles);
    const looseCount = loose.length / 4;
    const glued = (scene.glued ?? []).map((set) => ({ ...set, table: unpack(set.particles) }));
    const table = Float32Array.from([loose, ...glued.map((set) => set.table)].flatMap((t) => [...t]));
    const count = table.length / 4;
    // Of a glued particle: the number of its set, from 1.
    const setOf = new Uint8Array(count);
    let next = looseCount;
    glued.forEach((set, i) => {
      setOf.fill(i + 1, next, next + set.table.length / 4);
      next += set.table.length / 4;
    });
    const order = Uint32Array.from({ length: count }, (_, i) => i);
    const away = new Float32Array(count);
    let top = 1;
    let topOfAll = 1;
    let reach = 1;
    for (let i = 0; i < count; i += 1) {
      const [x, y, z, r] = table.subarray(4 * i, 4 * i + 4);
      topOfAll = Math.max(topOfAll, z + r);
      top = i < looseCount ? Math.max(top, z + r) : top;
      reach = Math.max(reach, Math.hypot(x, y) + r);
    }
    const shares = scene.shares && Uint8Array.from(atob(scene.shares), (s) => s.charCodeAt(0));
    const binOf = (i, z) =>
      Math.min(BINS - 1, Math.max(0, Math.floor((shares ? shares[i] / 255 : z / top) * BINS)));
    // Walls are one colour each, so that layers of them can be composed without seams.
    const walls = (scene.walls ?? []).map((wall) => {
      const [corners, edges] = [unpack(wall.triangles), unpack(wall.edges ?? "")];
      return { ...wall, corners, edges, begin: { corners, edges }, isThere: true };
    });
    for (const { corners } of walls) {
      for (let i = 0; i < corners.length; i += 3) {
        reach = Math.max(reach, Math.hypot(corners[i], corners[i + 1]));
      }
    }
    const heights = walls.map(({ corners }) => corners.filter((_, i) => i % 3 === 2));
    const highest = (values) => values.reduce((most, value) => Math.max(most, value), 0);
    let roof = Math.max(
      topOfAll,
      ...scene.outlines.flat().map(([, , z]) => z),
      ...heights.map((values) => highest(values)),
    );
    // Half of the width and of the depth that a picture must show.
    let [across, deep] = [reach, reach];
    if (scene.extent) {
      ({ across, deep, roof, top = top } = scene.extent);
    }
    const usual = { ...USUAL, ...scene.view };
    const camera = view?.redraws ? view : makeCamera({ ...usual, ...view });
    let gluedSprites = null;
    let waiting = false;

    const sized = () => {
      const scale = window.devicePixelRatio || 1;
      const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((length) =>
        Math.round(length * scale),
      );
      return { scale, width, height, isNew: canvas.width !== width || canvas.height !== height };
    };
    const draw = () => {
      waiting = false;
      sprites ??= Array.from({ length: BINS }, (_, i) => makeSprite(colour(i / (BINS - 1))));
      gluedSprites ??= glued.map((set) => makeSprite(set.colour));
      const { scale, width, height, isNew } = sized();
      if (isNew) {
        canvas.width = width;
        canvas.height = height;
      }
      if (width === 0 || height === 0) {
        return;
      }
      const pen = canvas.getContext("2d");
      const theme = window.grainfitTheme();
      const [ca, sa] = [Math.cos(camera.azimuth), Math.sin(camera.azimuth)];
      const [ce, se] = [Math.cos(camera.elevation), Math.sin(camera.elevation)];
      const tall = roof * ce + 2 * deep * se;
      const zoom = camera.zoom * 0.94 * Math.min(width / (2 * across), height / tall);
      const middleX = width / 2;
      const middleY = height / 2 + (zoom * roof * ce) / 2;
      const place = (x, y, z) => [
        middleX + (x * ca + y * sa) * zoom,
        middleY - (z * ce + (y * ca - x * sa) * se) * zoom,
      ];

      pen.clearRect(0, 0, width, height);
      pen.lineWidth = scale;
      pen.strokeStyle = theme["quiet-ink"];
      for (const outline of scene.outlines) {
        pen.beginPath();
        for (const [x, y, z] of outline) {
          pen.lineTo(...place(x, y, z));
        }
        pen.stroke();
      }
      for (const { edges } of walls.filter(({ isThere }) => isThere)) {
        for (let i = 0; i < edges.length; i += 6) {
          pen.beginPath();
          pen.moveTo(...place(...edges.subarray(i, i + 3)));
          pen.lineTo(...place(...edges.subarray(i + 3, i + 6)));
          pen.stroke();
        }
      }
      const depth = (x, y, z) => (y * ca - x * sa) * ce - z * se;
      // Upright walls are before or behind the axis, level ones above or below the middle.
      const middle = scene.extent ? roof / 2 : topOfAll / 2;
      const isBefore = ([x, y, z], level) =>
        (y * ca - x * sa) * (1 - level) - (z - middle) * level < 0;
      const layer = (isFront, alpha) => {
        if (walls.length === 0) {
          return;
        }
        const paper = document.createElement("canvas");
        paper.width = width;
        paper.height = height;
        const brush = paper.getContext("2d");
        const faces = walls.filter(({ isThere }) => isThere).flatMap(({ corners, colour: rgb }) =>
          Array.from({ length: corners.length / 9 }, (_, i) => {
            const [a, b, c] = [0, 3, 6].map((at) => corners.subarray(9 * i + at, 9 * i + at + 3));
            const away = (depth(...a) + depth(...b) + depth(...c)) / 3;
            const [u, v] = [b, c].map((end) => end.map((value, axis) => value - a[axis]));
            const normal = [
              u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0],
            ];
            const length = Math.hypot(...normal) || 1;
            const lit = Math.abs(-0.35 * normal[0] - 0.55 * normal[1] + 0.76 * normal[2]) / length;
            const centre = [0, 1, 2].map((axis) => (a[axis] + b[axis] + c[axis]) / 3);
            const before = isBefore(centre, Math.abs(normal[2]) / length);
            return { away, corners: [a, b, c], rgb, lit, before };
          }),
        );
        const shown = faces.filter(({ before }) => before === isFront);
        shown.sort((one, other) => other.away - one.away);
        for (const { corners, rgb, lit } of shown) {
          brush.fillStyle = brush.strokeStyle = shade(rgb, 0.75 + 0.45 * lit);
          brush.beginPath();
          corners.forEach((corner) => brush.lineTo(...place(...corner)));
          brush.closePath();
          brush.fill();
          brush.stroke();
        }
        pen.globalAlpha = alpha;
        pen.drawImage(paper, 0, 0);
        pen.globalAlpha = 1;
      };
      layer(false, 0.28);
      for (let i = 0; i < count; i += 1) {
        away[i] = depth(...table.subarray(4 * i, 4 * i + 3));
      }
      order.sort((a, b) => away[b] - away[a]);
      for (const i of order) {
        const [x, y, z, r] = table.subarray(4 * i, 4 * i + 4);
        if (x === GONE) {
          continue;
        }
        const size = r * zoom;
        const [column, row] = place(x, y, z);
        const sprite = setOf[i] ? gluedSprites[setOf[i] - 1] : sprites[binOf(i, z)];
        pen.drawImage(sprite, column - size, row - size, 2 * size, 2 * size);
      }
      layer(true, 0.28);
      for (const [start, end, rgb] of scene.arrows ?? []) {
        drawArrow(pen, place(...start), place(...end), `rgb(${rgb.join(",")})`, 3 * scale);
      }
      pen.font = `${12 * scale}px ${getComputedStyle(canvas).fontFamily}`;
      pen.textAlign = "center";
      for (const [start, end, words] of scene.dimensions ?? []) {
        const [[x1, y1], [x2, y2]] = [place(...start), place(...end)];
        const [column, row] = [(x1 + x2) / 2, (y1 + y2) / 2 + 4 * scale];
        pen.lineWidth = scale;
        pen.strokeStyle = theme["quiet-ink"];
        pen.beginPath();
        pen.moveTo(x1, y1);
        pen.lineTo(x2, y2);
        pen.stroke();
        pen.lineWidth = 4 * scale;
        pen.strokeStyle = theme.card;
        pen.strokeText(words, column, row);
        pen.fillStyle = theme.ink;
        pen.fillText(words, column, row);
      }
    };
    const redraw = () => {
      if (!waiting) {
        waiting = true;
        requestAnimationFrame(draw);
      }
    };
    camera.redraws.add(redraw);
    const look = (change) => {
      Object.assign(camera, change);
      camera.redraws.forEach((again) => again());
    };
    const turn = (right, up) =>
      look({
        azimuth: camera.azimuth - right,
        elevation: Math.min(1.45, Math.max(0, camera.elevation + up)),
      });
    const zoomBy = (factor) => look({ zoom: Math.min(8, Math.max(0.5, camera.zoom * factor)) });

    let last = null;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      last = [event.clientX, event.clientY];
    });
    canvas.addEventListener("pointermove", (event) => {
      if (last && canvas.hasPointerCapture(event.pointerId)) {
        turn((event.clientX - last[0]) / 150, (event.clientY - last[1]) / 150);
        last = [event.clientX, event.clientY];
      }
    });
    canvas.addEventListener("dblclick", () => look(usual));
    canvas.addEventListener(
      "wheel",
      (event) => {
        // Without focus, the wheel scrolls the page.
        if (event.ctrlKey || document.activeElement === canvas) {
          event.preventDefault();
          zoomBy(Math.exp(-event.deltaY / 500));
        }
      },
      { passive: false },
    );
    const keys = {
      ArrowLeft: () => turn(-0.1, 0),
      ArrowRight: () => turn(0.1, 0),
      ArrowUp: () => turn(0, -0.1),
      ArrowDown: () => turn(0, 0.1),
      "+": () => zoomBy(1.2),
      "=": () => zoomBy(1.2),
      "-": () => zoomBy(1 / 1.2),
    };
    canvas.addEventListener("keydown", (event) => {
      if (keys[event.key] && !event.ctrlKey && !event.altKey && !event.metaKey) {
        event.preventDefault();
        // A row of equals would go on to its next.
        event.stopPropagation();
        keys[event.key]();
      }
    });
    // At once: a drawing that takes another's place would be empty for a moment.
    draw();
    new ResizeObserver(() => {
      if (sized().isNew) {
        redraw();
      }
    }).observe(canvas);
    const repaint = () => {
      if (canvas.isConnected) {
        redraw();
      } else {
        document.removeEventListener("grainfit:theme", repaint);
      }
    };
    document.addEventListener("grainfit:theme", repaint);
    draw.view = () => {
      const { azimuth, elevation, zoom } = camera;
      return { azimuth, elevation, zoom };
    };
    // Another moment: places of the particles, three numbers each, and of the walls, null for one
    // that is not there.
    draw.move = (places, ofWalls) => {
      for (let i = 0; i < count; i += 1) {
        table.set(places.subarray(3 * i, 3 * i + 3), 4 * i);
      }
      walls.forEach((wall, i) => {
        wall.isThere = ofWalls[i] !== null;
        if (wall.isThere) {
          wall.corners = movedCorners(wall, wall.begin.corners, ofWalls[i]);
          wall.edges = movedCorners(wall, wall.begin.edges, ofWalls[i]);
        }
      });
      redraw();
    };
    return draw;
  };
  // For a page whose particles come in later: the view is that of the drawing before, if any.
  window.grainfitParticles = show;
  window.grainfitUnpack = unpack;

  const shown = new Map();
  const cameras = new Map();
  const cameraOf = (canvas) => {
    const name = canvas.dataset.camera;
    if (name && !cameras.has(name)) {
      cameras.set(name, makeCamera());
    }
    return cameras.get(name);
  };
  const once = (canvas) => {
    if (!shown.has(canvas)) {
      shown.set(canvas, show(canvas, scenes[canvas.dataset.particles], cameraOf(canvas)));
    }
  };
  const canvases = [...document.querySelectorAll("canvas[data-particles]")].filter(
    (canvas) => scenes[canvas.dataset.particles],
  );
  canvases.forEach((canvas) => window.grainfitWhenSeen(canvas, once));
  for (const button of document.querySelectorAll("[data-strip]")) {
    button.addEventListener("click", () => {
      const isIn = document.getElementById(button.dataset.strip).classList.toggle("in-3d");
      button.setAttribute("aria-pressed", isIn);
      canvases.filter((canvas) => canvas.clientWidth > 0).forEach(once);
    });
  }
  addEventListener("beforeprint", () => {
    // Those that paper has: silhouettes are smaller than a strip of drawings.
    canvases.filter((canvas) => canvas.clientWidth > 0).forEach(once);
    shown.forEach((draw) => draw());
  });
})();
