/* The lumens of a case for the 3-D viewer: unpacks geometry and values, colours the walls, places the panes. */
(function () {
  "use strict";

  const QUANTISATION_STEPS = 65535;
  const DEVICE_COLOUR = 0x2b2b33;
  const PLAIN_COLOUR = 0xb5473c;
  const OVERLAY_OPACITY = 0.4;  // opacity of the outer wall, if a lumen is shown inside it
  const NEUTRAL = [0.75, 0.75, 0.75];  // colour where there is no value
  // Values that can colour the wall. beyond: what it means to exceed the limit. none: which walls have no value.
  const FIELDS = {
    ffr: { name: "FFR", digits: 2, none: "a lumen without computed flow" },
    diameter: { name: "Diameter (mm)", digits: 1 },
    stretch: {
      name: "Wall stretch (length after PCI / length before)", digits: 1,
      beyond: "strips of artery tear in tests; usual in a dilated lesion, a hint of dissection next to a stent",
      none: "wall far from all devices, other lumens",
    },
    gap: {
      name: "Gap between stent and wall (mm)", digits: 1,
      beyond: "malapposition to be corrected (European consensus)",
      none: "wall without a stent, other lumens",
    },
  };

  /* The columns of integers that geometry.py packs: unsigned, `size` bytes each. */
  function unpack(text, columns, size) {
    const planes = THREE.unzlibSync(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)));
    const count = planes.length / (columns * size);
    return Array.from({ length: columns }, (_, column) => {
      const out = size === 2 ? new Uint16Array(count) : new Uint32Array(count);
      for (let byte = 0; byte < size; byte++) {
        const at = (column * size + byte) * count;
        for (let k = 0; k < count; k++) out[k] |= planes[at + k] << (8 * byte);
      }
      return out;
    });
  }

  /* Undoes the differences of geometry.py: running sums, modulo the range of the array's type. */
  function cumulativeSums(array) {
    for (let k = 1; k < array.length; k++) array[k] += array[k - 1];
    return array;
  }

  /* Quantised integers as numbers between low and high. */
  function dequantised(array, low, high) {
    return Float32Array.from(array, (v) => low + (v / QUANTISATION_STEPS) * (high - low));
  }

  /* Values at points; NaN where geometry.py had no value. */
  function unpackValues(text, low, high) {
    const steps = unpack(text, 1, 2)[0];
    return dequantised(steps, low, high).map((value, k) => (steps[k] === QUANTISATION_STEPS ? NaN : value));
  }

  function interleaved(columns, kind) {
    const out = new kind(3 * columns[0].length);
    columns.forEach((column, c) => column.forEach((v, k) => { out[3 * k + c] = v; }));
    return out;
  }

  function unpackGeometry(packed, bounds) {
    const points = unpack(packed.points, 3, 2).map(
      (column, c) => dequantised(cumulativeSums(column), bounds[0][c], bounds[1][c]));
    const [first, second, third] = unpack(packed.triangles, 3, packed.wide ? 4 : 2);
    cumulativeSums(first);
    for (let k = 0; k < first.length; k++) {
      second[k] += first[k];
      third[k] += first[k];
    }
    const result = new THREE.BufferGeometry();
    result.setAttribute("position", new THREE.BufferAttribute(interleaved(points, Float32Array), 3));
    result.setIndex(new THREE.BufferAttribute(interleaved([first, second, third], first.constructor), 1));
    result.computeVertexNormals();
    return result;
  }

  /* The colours of values over [low, high] from a table of colours; neutral where there is no value. */
  function rampColours(values, low, high, table) {
    const out = new Float32Array(values.length * 3);
    values.forEach((value, k) => {
      if (Number.isNaN(value)) { out.set(NEUTRAL, 3 * k); return; }
      const at = Math.max(0, Math.min(1, (value - low) / (high - low || 1))) * (table.length - 1);
      const below = Math.min(Math.floor(at), table.length - 2);
      for (let c = 0; c < 3; c++) {
        out[3 * k + c] = table[below][c] + (at - below) * (table[below + 1][c] - table[below][c]);
      }
    });
    return out;
  }

  /* A colour [r, g, b] of 0 to 1 as a text for CSS. */
  function css(colour) {
    return `rgb(${colour.map((v) => Math.round(255 * v)).join(",")})`;
  }

  /* One case: a scene for each state, and one camera for all scenes. */
  class CaseView {
    constructor(element, data, tables) {
      this.element = element;
      this.stage = element.querySelector(".stage");
      this.data = data;
      this.tables = tables;
      this.roles = {};
      element.querySelectorAll("[data-role]").forEach((item) => { this.roles[item.dataset.role] = item; });
      this.states = {};
      for (const [name, packed] of Object.entries(data.states)) this.states[name] = this.makeState(name, packed);
      if (Object.keys(this.states).length < 2) this.roles.mode.value = "single";
      this.whole = this.extent();
      this.camera = new THREE.PerspectiveCamera(25, 1, 0.1, 2000);
      this.light = new THREE.DirectionalLight(0xffffff, 0.6 * Math.PI);
      this.titles = [0, 1].map(() => this.addLabel("title"));
      this.readout = this.addLabel("readout");
      this.stage.tabIndex = 0;
      this.stage.setAttribute("role", "application");  // makes screen readers pass the arrow keys on to the viewer
      this.stage.setAttribute("aria-describedby", this.roles.keys.id);
      element.querySelectorAll(".tools, .hint").forEach((item) => { item.hidden = false; });
      const chosen = () => this.onChange();
      element.querySelectorAll("select, input").forEach((item) => item.addEventListener("input", chosen));
    }

    addLabel(name) {
      const label = document.createElement("div");
      label.className = name;
      this.stage.appendChild(label);
      return label;
    }

    makeState(name, packed) {
      const { ranges, bounds } = this.data;
      const values = {};
      for (const key of Object.keys(ranges).filter((field) => packed[field])) {
        values[key] = unpackValues(packed[key], ...ranges[key]);
      }
      const shape = unpackGeometry(packed, bounds);
      shape.setAttribute("color", new THREE.BufferAttribute(new Float32Array(values.area.length * 3), 3));
      const backMaterial = new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.BackSide });
      const frontMaterial = new THREE.MeshPhongMaterial({
        vertexColors: true, transparent: true, depthWrite: false, shininess: 25, specular: 0x333333,
      });
      const wall = new THREE.Group();
      const front = new THREE.Mesh(shape, frontMaterial);
      front.renderOrder = 2;  // drawn after the stent, which lies behind it
      wall.add(new THREE.Mesh(shape, backMaterial), front);
      const scene = new THREE.Scene();
      scene.add(wall, new THREE.HemisphereLight(0xffffff, 0xb8b8c4, 0.5 * Math.PI));
      const devices = new THREE.Group();
      if (name === "vci") {
        const material = new THREE.MeshPhongMaterial({ color: DEVICE_COLOUR });
        for (const device of this.data.devices) {
          devices.add(new THREE.Mesh(unpackGeometry(device, bounds), material));
        }
      }
      scene.add(devices);
      return { scene, wall, front, backMaterial, frontMaterial, devices, values, shape };
    }

    /* {middle, across, tall} in mm: the middle of all lumens, and half of their width and height in the first view. */
    extent() {
      const [right, up, towards] = this.data.view.map((p) => new THREE.Vector3(...p));
      const p = new THREE.Vector3(), [low, high] = [Infinity, -Infinity].map((v) => new THREE.Vector3(v, v, v));
      for (const state of Object.values(this.states)) {
        const at = state.shape.getAttribute("position");
        for (let k = 0; k < at.count; k++) {
          p.fromBufferAttribute(at, k);
          p.set(p.dot(right), p.dot(up), p.dot(towards));
          low.min(p);
          high.max(p);
        }
      }
      const { x, y, z } = low.clone().add(high).multiplyScalar(0.5);
      const middle = new THREE.Vector3().addScaledVector(right, x).addScaledVector(up, y).addScaledVector(towards, z);
      return { middle, across: (high.x - low.x) / 2, tall: (high.y - low.y) / 2 };
    }

    /* Makes the camera look along the vessel's axis of least extent, and fits the whole vessel into each pane. */
    reset(controls) {
      const [, up, towards] = this.data.view.map((p) => new THREE.Vector3(...p));
      const { middle, across, tall } = this.whole, [pane] = this.panes();
      const half = Math.max(tall, (across * pane.tall) / pane.across);
      const distance = (1.12 * half) / Math.tan((this.camera.fov * Math.PI) / 360);
      this.camera.up.copy(up);
      this.camera.position.copy(middle).addScaledVector(towards, distance + 3);
      controls.target.copy(middle);
      this.fitted = this.camera.position.clone();
    }

    /* Whether the camera is where `reset` put it. */
    isFitted() {
      return !this.fitted || this.fitted.distanceTo(this.camera.position) < 1e-6;
    }

    /* Applies what the user chose. The stage sets `onChange`, which calls this and draws again. */
    apply() {
      const { roles } = this;
      const colour = roles.colour.value, plain = colour === "plain";
      const scale = plain ? null : this.scaleOf(colour);
      for (const state of Object.values(this.states)) {
        if (!plain) {
          const values = state.values[colour] || new Float32Array(state.values.area.length).fill(NaN);
          state.shape.getAttribute("color").array.set(rampColours(values, scale.low, scale.high, scale.table));
          state.shape.getAttribute("color").needsUpdate = true;
        }
        [state.backMaterial, state.frontMaterial].forEach((material) => {
          material.vertexColors = !plain;
          material.color.set(plain ? PLAIN_COLOUR : 0xffffff);
          material.needsUpdate = true;
        });
        state.frontMaterial.opacity = Math.min(Number(roles.opacity.value), this.innerState() ? OVERLAY_OPACITY : 1);
        state.devices.visible = !roles.devices || roles.devices.checked;
      }
      roles.second.hidden = roles.mode.value === "single";
      roles.legend.replaceChildren(...(plain ? [] : this.legend(colour, scale)));
      const shown = this.panes().map((pane) => this.titleOf(pane.state)).join(" and ");
      const chosen = roles.colour.selectedOptions[0].textContent;
      this.stage.setAttribute("aria-label", `3D picture of the lumen: ${shown}; colour: ${chosen}`);
    }

    /* {low, high, limit, table} of a field's colours. Without fixed ends they end where the values end. */
    scaleOf(field) {
      const fixed = this.data.scales[field];
      if (fixed) return { ...fixed, table: this.tables.limit };
      const [low, high] = this.data.ranges[field];
      return { low, high, table: this.tables.plain };
    }

    legend(field, { low, high, limit, table }) {
      const { name, digits, beyond, none } = FIELDS[field];
      const bar = document.createElement("span");
      bar.className = "ramp";
      bar.style.background = `linear-gradient(90deg,${table.map(css).join(",")})`;
      const parts = [`${name}: ${low.toFixed(digits)}`, bar, high.toFixed(digits)];
      if (limit) parts.push(` and more. Beyond ${limit.toFixed(digits)}, in warm colours: ${beyond}.`);
      if (none && Object.values(this.states).some(({ values }) => !values[field] || values[field].some(Number.isNaN))) {
        const grey = document.createElement("span");
        grey.className = "swatch";
        grey.style.background = css(NEUTRAL);
        parts.push(" ", grey, `no value: ${none}.`);
      }
      return parts;
    }

    /* The panes [{state, left, top, across, tall}] in pixels. Two are laid out so that the vessel is shown larger. */
    panes() {
      const { left, right, mode } = this.roles, { clientWidth: width, clientHeight: height } = this.stage;
      const whole = { left: 0, top: 0, across: width, tall: height };
      if (mode.value !== "two") return [{ ...whole, state: mode.value === "single" ? left.value : right.value }];
      const { across, tall } = this.whole;
      const beside = Math.min(width / 2 / across, height / tall) > Math.min(width / across, height / 2 / tall);
      const half = beside ? { ...whole, across: width / 2 } : { ...whole, tall: height / 2 };
      const other = { ...half, left: width - half.across, top: height - half.tall };
      return [{ ...half, state: left.value }, { ...other, state: right.value }];
    }

    /* The state that is drawn inside the other one; null in modes without an inner lumen. */
    innerState() {
      return this.roles.mode.value === "overlay" ? this.roles.left.value : null;
    }

    titleOf(state) {
      return Array.from(this.roles.left.options).find((option) => option.value === state).textContent;
    }
  }

  window.vciViewer = { CaseView, unpackGeometry, unpackValues };
})();
