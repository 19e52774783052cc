/* The parts of three.js that the viewer uses, bundled as the global THREE. unzlibSync unpacks the geometry. */
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
