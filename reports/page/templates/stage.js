/* The viewer's canvas: draws the panes, turns them together, and shows the values under the pointer. */
(function () {
  "use strict";

  const INNER_COLOUR = 0xb5473c;
  const TURN = Math.PI / 18;  // radians for one press of an arrow key
  const ZOOM = 1.2;  // factor of the distance for one press of a key or button
  const NEAREST_MM = 2, FARTHEST_MM = 1000;  // limits of the camera's distance, between the clipping planes
  const TURNS = { ArrowLeft: [-TURN, 0], ArrowRight: [TURN, 0], ArrowUp: [0, -TURN], ArrowDown: [0, TURN] };
  const ZOOMS = { "+": 1 / ZOOM, "=": 1 / ZOOM, "-": ZOOM, "−": ZOOM };  // "=" is "+" without the shift key
  // No conversion of colours, neither of the given nor of the drawn ones: the wall must have the legend's colours.
  THREE.ColorManagement.enabled = false;

  class Stage {
    constructor(data) {
      this.data = data;
      this.views = new Map();
      this.renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
      this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
      this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
      this.renderer.autoClear = false;
      this.canvas = this.renderer.domElement;
      this.innerMaterial = new THREE.MeshLambertMaterial({ color: INNER_COLOUR });
      this.raycaster = new THREE.Raycaster();
      this.canvas.addEventListener("pointerdown", () => this.setFocus(true));
      this.canvas.addEventListener("mouseleave", () => { this.setFocus(false); this.showReadout(""); });
      this.canvas.addEventListener("mousemove", (event) => this.readValues(event));
      window.addEventListener("resize", () => { if (this.view) this.resize(); });
      const tick = () => { if (this.controls) this.controls.update(); requestAnimationFrame(tick); };
      tick();
    }

    /* Shows a case: puts the canvas into its element. */
    show(element) {
      if (this.view && this.view.element === element) return;
      if (this.view) this.view.stage.classList.remove("live");
      if (!this.views.has(element)) this.views.set(element, this.createView(element));
      this.view = this.views.get(element);
      this.view.stage.insertBefore(this.canvas, this.view.stage.firstChild);
      this.view.stage.classList.add("live");
      this.attachControls();
      this.resize();
    }

    createView(element) {
      const view = new window.vciViewer.CaseView(element, this.data.cases[element.dataset.case], this.data.colours);
      view.onChange = () => { this.show(element); view.apply(); this.refit(); };
      const act = (action) => () => { this.show(element); action(); };
      view.roles.reset.addEventListener("click", act(() => this.resetView()));
      view.roles.nearer.addEventListener("click", act(() => this.zoom(1 / ZOOM)));
      view.roles.farther.addEventListener("click", act(() => this.zoom(ZOOM)));
      view.stage.addEventListener("focus", act(() => {}));
      view.stage.addEventListener("keydown", (event) => this.onKey(event));
      view.apply();
      return view;
    }

    /* Makes the mouse controls for the case shown. They keep the camera where the user left it. */
    attachControls() {
      if (this.controls) this.controls.dispose();
      const view = this.view;
      this.controls = new THREE.TrackballControls(view.camera, this.canvas);
      this.controls.staticMoving = true;
      this.controls.rotateSpeed = 3;
      this.controls.panSpeed = 0.6;
      this.controls.noZoom = true;
      this.controls.minDistance = NEAREST_MM;
      this.controls.maxDistance = FARTHEST_MM;
      this.canvas.style.touchAction = "pan-y";  // a finger that moves up or down scrolls the page past the picture
      this.controls.addEventListener("change", () => { view.target = this.controls.target.clone(); this.draw(); });
      if (view.target) this.controls.target.copy(view.target);
    }

    resize() {
      const { clientWidth, clientHeight } = this.view.stage;
      this.renderer.setSize(clientWidth, clientHeight, false);
      this.controls.handleResize();
      this.refit();
    }

    /* Draws. Fits the whole vessel into the panes, unless the user has moved the camera. */
    refit() {
      if (this.view.isFitted()) this.resetView();
      else this.draw();
    }

    resetView() {
      this.view.reset(this.controls);
      this.view.target = this.controls.target.clone();
      this.controls.update();
      this.draw();
    }

    onKey(event) {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const turn = TURNS[event.key], zoom = ZOOMS[event.key];
      if (turn) this.turn(...turn);
      else if (zoom) this.zoom(zoom);
      else if (event.key === "0") this.resetView();
      else return;
      event.preventDefault();  // otherwise the page would scroll as well
    }

    /* Turns the vessel like a drag to the right and downwards. right, down: angles in radians. */
    turn(right, down) {
      const { camera } = this.view, { target } = this.controls;
      const eye = camera.position.clone().sub(target);
      const across = camera.up.clone().cross(eye).normalize();
      const up = camera.up.clone();
      for (const vector of [eye, camera.up]) vector.applyAxisAngle(up, -right).applyAxisAngle(across, -down);
      camera.position.copy(target).add(eye);
      this.controls.update();  // draws if the camera has moved
    }

    /* Multiplies the camera's distance from the middle. */
    zoom(factor) {
      const { camera } = this.view, { target } = this.controls;
      const eye = camera.position.clone().sub(target);
      eye.setLength(Math.min(FARTHEST_MM, Math.max(NEAREST_MM, factor * eye.length())));
      camera.position.copy(target).add(eye);
      this.controls.update();
    }

    draw() {
      const { renderer, view } = this;
      renderer.setScissorTest(false);
      renderer.setClearColor(0xffffff, 0);
      renderer.clear();
      renderer.setScissorTest(true);
      view.titles.forEach((title) => { title.textContent = ""; });
      view.panes().forEach((pane, k) => {
        const state = view.states[pane.state];
        const bottom = view.stage.clientHeight - pane.top - pane.tall;
        const place = [pane.left, bottom, pane.across, pane.tall].map(Math.round);
        renderer.setViewport(...place);
        renderer.setScissor(...place);
        view.camera.aspect = pane.across / pane.tall;
        view.camera.updateProjectionMatrix();
        view.light.position.copy(view.camera.position).addScaledVector(view.camera.up, 30);
        view.light.target.position.copy(this.controls.target);
        state.scene.add(view.light, view.light.target);
        const inner = this.innerMesh(view, pane.state);
        if (inner) state.scene.add(inner);
        renderer.render(state.scene, view.camera);
        if (inner) state.scene.remove(inner);
        view.titles[k].style.left = `calc(${pane.left}px + .6rem)`;
        view.titles[k].style.top = `calc(${pane.top}px + .5rem)`;
        const around = inner ? `, around: ${view.titleOf(view.innerState())} (red)` : "";
        view.titles[k].textContent = view.titleOf(pane.state) + around;
      });
    }

    /* The inner lumen as an opaque body, if one lumen is shown inside the other; else null. */
    innerMesh(view, shown) {
      const name = view.innerState();
      return name && name !== shown ? new THREE.Mesh(view.states[name].shape, this.innerMaterial) : null;
    }

    /* Scrolling zooms only after a click, so that the page can be scrolled past the picture. */
    setFocus(on) {
      if (!this.view) return;
      this.controls.noZoom = !on;
      this.view.stage.classList.toggle("focus", on);
    }

    showReadout(text) {
      if (this.view) this.view.readout.textContent = text;
    }

    readValues(event) {
      if (!this.view || event.buttons) return;
      const box = this.canvas.getBoundingClientRect();
      const x = event.clientX - box.left, y = event.clientY - box.top;
      const inside = ({ left, top, across, tall }) => x >= left && x <= left + across && y >= top && y <= top + tall;
      const pane = this.view.panes().find(inside);
      if (!pane) return;
      const state = this.view.states[pane.state];
      this.view.camera.aspect = pane.across / pane.tall;
      this.view.camera.updateProjectionMatrix();
      const pointer = { x: (2 * (x - pane.left)) / pane.across - 1, y: 1 - (2 * (y - pane.top)) / pane.tall };
      this.raycaster.setFromCamera(pointer, this.view.camera);
      const hit = this.raycaster.intersectObject(state.front)[0];
      if (!hit) { this.showReadout(""); return; }
      const at = hit.face.a, values = state.values;
      const shown = (field, name, digits, unit) => {
        const value = values[field] ? values[field][at] : NaN;
        return Number.isNaN(value) ? [] : [`${name} ${value.toFixed(digits)}${unit}`];
      };
      this.showReadout([
        ...shown("ffr", "FFR", 3, ""),
        ...shown("area", "CSA", 2, " mm²"),
        ...shown("diameter", "diameter", 2, " mm"),
        ...shown("stretch", "wall stretch", 2, ""),
        ...shown("gap", "gap to stent", 2, " mm"),
      ].join(" · "));
    }
  }

  /* The stage, or null where the browser offers no WebGL. */
  window.vciStage = function () {
    const trial = document.createElement("canvas");
    if (!trial.getContext("webgl2")) return null;
    return new Stage(JSON.parse(document.getElementById("viewer-data").textContent));
  };
})();
