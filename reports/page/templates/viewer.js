/* The 3-D viewer. One WebGL canvas serves all cases: browsers allow only a few, so it moves to the case in view. */
(function () {
  "use strict";

  const QUANTISATION_STEPS = 65535;
  const DEVICE_COLOUR = 0x2b2b33;
  const PLAIN_COLOUR = 0xb5473c;
  const OVERLAY_OPACITY = 0.4;  // the outer wall, when a lumen is shown inside it

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

  /* Sums of differences, modulo the range of the array. */
  function cumulativeSums(array) {
    for (let k = 1; k < array.length; k++) array[k] += array[k - 1];
    return array;
  }

  /* Quantised integers as numbers between low and high. */
  function dequantised(array, low, high) {
    return Float32Array.from(array, (v) => low + (v / QUANTISATION_STEPS) * (high - low));
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

  /* The colours of values over [low, high], from the table the figures use too. */
  function rampColours(values, low, high, table) {
    const out = new Float32Array(values.length * 3);
    values.forEach((value, k) => {
      const at = Math.max(0, Math.min(1, (value - low) / (high - low || 1))) * (table.length - 1);
      const below = Math.min(Math.floor(at), table.length - 2);
      for (let c = 0; c < 3; c++) {
        out[3 * k + c] = table[below][c] + (at - below) * (table[below + 1][c] - table[below][c]);
      }
    });
    return out;
  }

  /* All of one case: a scene a state, one camera for all of them. */
  class CaseView {
    constructor(element, data, table) {
      this.element = element;
      this.stage = element.querySelector(".stage");
      this.data = data;
      this.table = table;
      this.roles = {};
      element.querySelectorAll("[data-role]").forEach((item) => { this.roles[item.dataset.role] = item; });
      this.states = {};
      for (const [name, packed] of Object.entries(data.states)) this.states[name] = this.makeState(name, packed);
      if (Object.keys(this.states).length < 2) this.roles.mode.value = "single";
      this.camera = new THREE.PerspectiveCamera(25, 1, 0.1, 2000);
      this.light = new THREE.DirectionalLight(0xffffff, 0.6 * Math.PI);
      this.titles = [0, 1].map(() => this.addLabel("title"));
      this.readout = this.addLabel("readout");
      element.querySelectorAll(".tools, .hint").forEach((item) => { item.hidden = false; });
      element.querySelectorAll("select, input").forEach((item) => item.addEventListener("input", () => this.onChange()));
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
      for (const key of Object.keys(ranges).filter((name) => packed[name])) values[key] = dequantised(unpack(packed[key], 1, 2)[0], ...ranges[key]);
      const shape = unpackGeometry(packed, bounds);
      shape.setAttribute("color", new THREE.BufferAttribute(new Float32Array(values.area.length * 3), 3));
      const backMaterial = new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.BackSide });
      const frontMaterial = new THREE.MeshPhongMaterial({
        vertexColors: true, transparent: true, depthWrite: false, shininess: 25, specular: 0x333333,
      });
      const wall = new THREE.Group();
      const front = new THREE.Mesh(shape, frontMaterial);
      front.renderOrder = 2;  // after the stent behind it
      wall.add(new THREE.Mesh(shape, backMaterial), front);
      const scene = new THREE.Scene();
      scene.add(wall, new THREE.HemisphereLight(0xffffff, 0xb8b8c4, 0.5 * Math.PI));
      const devices = new THREE.Group();
      if (name === "vci") {
        for (const device of this.data.devices) {
          devices.add(new THREE.Mesh(unpackGeometry(device, bounds), new THREE.MeshPhongMaterial({ color: DEVICE_COLOUR })));
        }
      }
      scene.add(devices);
      return { scene, wall, front, backMaterial, frontMaterial, devices, values, shape };
    }

    /* Looks along the axis of least extent, with the whole vessel in the picture. */
    reset(controls, aspect) {
      const [low, high] = this.data.bounds.map((p) => new THREE.Vector3(...p));
      const middle = low.clone().add(high).multiplyScalar(0.5);
      const [right, up, towards] = this.data.view.map((p) => new THREE.Vector3(...p));
      let across = 0, tall = 0;
      for (const state of Object.values(this.states)) {
        const at = state.shape.getAttribute("position"), p = new THREE.Vector3();
        for (let k = 0; k < at.count; k++) {
          p.fromBufferAttribute(at, k).sub(middle);
          across = Math.max(across, Math.abs(p.dot(right)));
          tall = Math.max(tall, Math.abs(p.dot(up)));
        }
      }
      const distance = 1.12 * Math.max(tall, across / aspect) / Math.tan((this.camera.fov * Math.PI) / 360);
      this.camera.up.copy(up);
      this.camera.position.copy(middle).addScaledVector(towards, distance + 3);
      controls.target.copy(middle);
    }

    /* Applies what the user chose; `onChange` is set by the stage to draw again. */
    apply() {
      const { roles, data } = this;
      const colour = roles.colour.value;
      const [low, high] = colour === "plain" ? [0, 1] : data.ranges[colour];
      for (const state of Object.values(this.states)) {
        const plain = colour === "plain" || !state.values[colour];  // a lumen without a flow has no FFR
        if (!plain) {
          state.shape.getAttribute("color").array.set(rampColours(state.values[colour], low, high, this.table));
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
      this.drawLegend(colour, low, high);
    }

    drawLegend(colour, low, high) {
      if (colour === "plain") { this.roles.legend.textContent = ""; return; }
      const stops = this.table.map((c) => `rgb(${c.map((v) => Math.round(255 * v)).join(",")})`).join(",");
      const digits = colour === "ffr" ? 2 : 1;
      const bar = document.createElement("span");
      bar.className = "ramp";
      bar.style.background = `linear-gradient(90deg,${stops})`;
      const name = colour === "ffr" ? "FFR " : "Diameter (mm) ";
      this.roles.legend.replaceChildren(name + low.toFixed(digits), bar, high.toFixed(digits));
    }

    /* The panes to draw: [{state, from, to}] with horizontal shares of the stage. */
    panes() {
      const { left, right, mode } = this.roles;
      if (mode.value === "side") return [{ state: left.value, from: 0, to: 0.5 }, { state: right.value, from: 0.5, to: 1 }];
      return [{ state: mode.value === "single" ? left.value : right.value, from: 0, to: 1 }];
    }

    /* The state drawn inside the other, null in the other modes. */
    innerState() {
      return this.roles.mode.value === "overlay" ? this.roles.left.value : null;
    }

    titleOf(state) {
      return Array.from(this.roles.left.options).find((option) => option.value === state).textContent;
    }
  }

  window.vciViewer = { CaseView, unpackGeometry };
})();
