/* What the page's viewer uses of three.js, as the global THREE; its copy of fflate inflates the geometry. */
export {
  BackSide,
  BufferAttribute,
  BufferGeometry,
  ColorManagement,
  DirectionalLight,
  Group,
  HemisphereLight,
  LinearSRGBColorSpace,
  Mesh,
  MeshLambertMaterial,
  MeshPhongMaterial,
  PerspectiveCamera,
  Raycaster,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
export { TrackballControls } from "three/examples/jsm/controls/TrackballControls.js";
export { unzlibSync } from "three/examples/jsm/libs/fflate.module.js";
