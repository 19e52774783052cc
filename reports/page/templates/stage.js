/* The one canvas: draws the panes of the case in view, turns them together, reads values under the pointer. */
(function () {
  "use strict";

  const INNER_COLOUR = 0xb5473c;
  // Colours as the legend has them: no conversion of what is given, nor of what is drawn.
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
      this.canvas.addEventListener("mousedown", () => this.setFocus(true));
      this.canvas.addEventListener("mouseleave", () => { this.setFocus(false); this.showReadout(""); });
      this.canvas.addEventListener("mousemove", (event) => this.readValues(event));
      window.addEventListener("resize", () => { if (this.view) this.resize(); });
      const tick = () => { if (this.controls) this.controls.update(); requestAnimationFrame(tick); };
      tick();
    }

    /* Moves the canvas to a case. */
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
      view.onChange = () => { this.show(element); view.apply(); this.draw(); };
      view.roles.reset.addEventListener("click", () => { this.show(element); this.resetView(); });
      view.apply();
      return view;
    }

    /* Controls for the current case; they keep the camera where the user left it. */
    attachControls() {
      if (this.controls) this.controls.dispose();
      const view = this.view;
      this.controls = new THREE.TrackballControls(view.camera, this.canvas);
      this.controls.staticMoving = true;
      this.controls.rotateSpeed = 3;
      this.controls.panSpeed = 0.6;
      this.controls.noZoom = true;
      this.controls.addEventListener("change", () => { view.target = this.controls.target.clone(); this.draw(); });
      if (view.target) this.controls.target.copy(view.target);
    }

    resize() {
      const { clientWidth, clientHeight } = this.view.stage;
      this.renderer.setSize(clientWidth, clientHeight, false);
      this.controls.handleResize();
      if (this.view.target) this.draw();
      else this.resetView();
    }

    resetView() {
      const panes = this.view.panes();
      const aspect = (this.view.stage.clientWidth * (panes[0].to - panes[0].from)) / this.view.stage.clientHeight;
      this.view.reset(this.controls, aspect);
      this.view.target = this.controls.target.clone();
      this.controls.update();
      this.draw();
    }

    draw() {
      const { renderer, view } = this;
      const width = view.stage.clientWidth, height = view.stage.clientHeight;
      renderer.setScissorTest(false);
      renderer.setClearColor(0xffffff, 0);
      renderer.clear();
      renderer.setScissorTest(true);
      view.titles.forEach((title) => { title.textContent = ""; });
      view.panes().forEach((pane, k) => {
        const state = view.states[pane.state];
        const left = Math.round(pane.from * width), across = Math.round((pane.to - pane.from) * width);
        renderer.setViewport(left, 0, across, height);
        renderer.setScissor(left, 0, across, height);
        view.camera.aspect = across / height;
        view.camera.updateProjectionMatrix();
        view.light.position.copy(view.camera.position).addScaledVector(view.camera.up, 30);
        view.light.target.position.copy(this.controls.target);
        state.scene.add(view.light, view.light.target);
        const inner = this.innerMesh(view, pane.state);
        if (inner) state.scene.add(inner);
        renderer.render(state.scene, view.camera);
        if (inner) state.scene.remove(inner);
        view.titles[k].style.left = `calc(${100 * pane.from}% + .6rem)`;
        view.titles[k].textContent = view.titleOf(pane.state) + (inner ? `, around: ${view.titleOf(view.innerState())} (red)` : "");
      });
    }

    /* The other lumen as a solid body, where one is shown inside the other. */
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
      const x = (event.clientX - box.left) / box.width, y = (event.clientY - box.top) / box.height;
      const pane = this.view.panes().find((item) => x >= item.from && x <= item.to);
      if (!pane) return;
      const state = this.view.states[pane.state];
      const across = pane.to - pane.from;
      this.view.camera.aspect = (across * box.width) / box.height;
      this.view.camera.updateProjectionMatrix();
      this.raycaster.setFromCamera({ x: (2 * (x - pane.from)) / across - 1, y: 1 - 2 * y }, this.view.camera);
      const hit = this.raycaster.intersectObject(state.front)[0];
      if (!hit) { this.showReadout(""); return; }
      const at = hit.face.a, values = state.values;
      this.showReadout(`${values.ffr ? `FFR ${values.ffr[at].toFixed(3)} · ` : ""}CSA ${values.area[at].toFixed(2)} mm² · diameter ${values.diameter[at].toFixed(2)} mm`);
    }
  }

  /* The stage, or null where the browser offers no WebGL. */
  window.vciStage = function () {
    const trial = document.createElement("canvas");
    if (!trial.getContext("webgl2")) return null;
    return new Stage(JSON.parse(document.getElementById("viewer-data").textContent));
  };
})();
