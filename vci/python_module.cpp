// The Python module vci._engine: the engine on numpy arrays. The package vci (vci/__init__.py) offers its names.
#include "vci/files.hpp"
#include "vci/results/carried_lumen.hpp"
#include "vci/results/readouts.hpp"

#include <mutex>
#include <pybind11/eigen.h>
#include <pybind11/functional.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace py = pybind11;
using nlohmann::json;
using namespace vci;

namespace {

template <class Value>
using OptionalArray = std::optional<py::array_t<Value, py::array::c_style | py::array::forcecast>>;
constexpr int steps_between_signal_checks = 10; // between checks for Ctrl-C; ten take a fraction of a second
using Log = std::function<void(const std::string&)>;

template <class Value> std::vector<Value> values_of(const OptionalArray<Value>& array) {
  return array ? std::vector<Value>(array->data(), array->data() + array->size()) : std::vector<Value>{};
}

TriangleRows rows_of_triangles(const Triangles& triangles) {
  TriangleRows rows(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t k = 0; k < triangles.size(); ++k)
    for (int c = 0; c < 3; ++c)
      rows(static_cast<Eigen::Index>(k), c) = triangles[k][c];
  return rows;
}

py::dict arrays_of(const Balance& forces) {
  return py::dict(py::arg("pressure_n") = rows_of(forces.pressure), py::arg("contact_n") = rows_of(forces.contact),
                  py::arg("foundation_n") = rows_of(forces.foundation),
                  py::arg("residual_n") = rows_of(forces.residual));
}

py::dict arrays_of(const std::map<std::string, Path>& paths) {
  py::dict arrays;
  for (const auto& [name, path] : paths)
    arrays[py::str(name)] = rows_of(path.points());
  return arrays;
}

/// The values of an array of whole numbers. The type is checked, because numpy would silently cut off fractions.
std::vector<int> whole_numbers(const py::array& array, const std::string& name) {
  if (array.dtype().kind() != 'i' && array.dtype().kind() != 'u')
    throw common::InputError("an array that is not of whole numbers", name, py::str(py::object(array.dtype())),
                             "give integers");
  const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast> wide(array);
  std::vector<int> numbers;
  for (py::ssize_t k = 0; k < wide.size(); ++k) {
    numbers.push_back(static_cast<int>(wide.data()[k]));
    if (numbers.back() != wide.data()[k])
      throw common::InputError("a number out of its range", name, std::to_string(wide.data()[k]),
                               "give 32-bit integers");
  }
  return numbers;
}

py::array array_of(const py::object& object, const std::string& name) {
  py::array array = py::array::ensure(object);
  if (!array)
    throw py::type_error(name + ": neither an array nor a list of numbers");
  return array;
}

TriangleRows triangles_of(const py::object& object) {
  const py::array array = array_of(object, "triangles");
  if (array.ndim() != 2 || array.shape(1) != 3)
    throw common::InputError("triangles of another shape", "triangles", py::str(py::object(array.attr("shape"))),
                             "give (m, 3) indices of points");
  const std::vector<int> numbers = whole_numbers(array, "triangles");
  return Eigen::Map<const TriangleRows>(numbers.data(), array.shape(0), 3);
}

/// Converts Python dicts and lists to JSON, and numpy's arrays and numbers to lists and numbers.
/// @param name name of the Python argument, for messages
json json_of(const py::object& object, const std::string& name) {
  const py::cpp_function to_builtin([](const py::object& value) -> py::object {
    if (!py::hasattr(value, "tolist"))
      throw py::type_error("neither a number, text, list nor dict: " + std::string(py::repr(value)));
    return value.attr("tolist")();
  });
  const py::object dumps = py::module_::import("json").attr("dumps");
  try {
    return json::parse(
        dumps(object, py::arg("default") = to_builtin, py::arg("allow_nan") = false).cast<std::string>());
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_ValueError))
      throw;
    throw common::InputError("a value that is not finite, or that holds itself", name, error.what(),
                             "give finite numbers");
  }
}

py::object python_object(const json& value) {
  return py::module_::import("json").attr("loads")(value.dump());
}

/// A lumen with the axes of its branches.
struct Vessel {
  Lumen lumen;
  std::map<std::string, Path> paths;
};

Vessel vessel_from(const Eigen::Ref<const PointRows>& points, const py::object& triangles,
                   const OptionalArray<double>& radius, const std::map<std::string, PointRows>& centreline,
                   const OptionalArray<double>& plaque, const py::object& plaque_type,
                   const OptionalArray<double>& reference, const py::object& branch_id) {
  const auto optional_numbers = [](const py::object& array, const char* name) {
    return array.is_none() ? std::vector<int>{} : whole_numbers(array_of(array, name), name);
  };
  Vessel vessel;
  vessel.lumen = lumen_from(points, triangles_of(triangles), values_of(radius), values_of(plaque),
                            optional_numbers(plaque_type, "plaque_type"), values_of(reference),
                            optional_numbers(branch_id, "branch_id"));
  NamedLines lines;
  for (const auto& [name, line] : centreline)
    lines.emplace_back(name, vectors_of(line));
  vessel.paths = centreline_from(lines, "centreline");
  return vessel;
}

/// The scene that the arguments of a Python call describe. It passes the same checks against the vessel as the scene
/// file of `vci deploy`.
Scene scene_of(const Vessel& vessel, const py::dict& devices, const py::sequence& steps, double map_pa,
               const py::dict& wall, const py::dict& numerics) {
  const json entries{{"patient", {{"map_pa", map_pa}}},
                     {"devices", json_of(devices, "devices")},
                     {"procedure", json_of(steps, "steps")},
                     {"wall", json_of(wall, "wall")},
                     {"numerics", json_of(numerics, "numerics")}};
  const py::gil_scoped_release released;
  Scene scene = scene_from(entries, "arguments");
  check_placements(scene, vessel.paths);
  check_lumen(scene, vessel.lumen, vessel.paths);
  return scene;
}

struct Result {
  DeploymentResult deployment;
  Triangles triangles;
  json readouts;
};

/// A procedure that runs step by step. Python's threads may share a Session; each call waits for the previous one.
class Session {
  /// Throws if the user has pressed Ctrl-C. The solver calls this function, so the computation ends.
  static void stop_if_interrupted(const Snapshot&) {
    const py::gil_scoped_acquire held;
    if (PyErr_CheckSignals() != 0)
      throw py::error_already_set();
  }

  static std::optional<CarriedLumen> carried_by(const Vessel* coarse, const Vessel& vessel) {
    return coarse ? std::optional<CarriedLumen>(std::in_place, coarse->lumen, vessel.lumen, "argument coarse_lumen")
                  : std::nullopt;
  }

  /// Runs a function without Python's interpreter lock, while no other thread runs one of this Session's functions.
  template <class Call> auto run_exclusively(Call call) {
    // Released before the mutex is locked: the thread that holds the mutex may need the interpreter to log.
    const py::gil_scoped_release released;
    const std::lock_guard<std::recursive_mutex> lock(mutex_);
    return call();
  }

public:
  /// @param coarse lumen that is deployed instead of the vessel's and carries its points along; nullptr: none
  Session(Vessel vessel, const Vessel* coarse, Scene scene, const Log& log)
      : vessel_(std::move(vessel)), scene_(std::move(scene)), carried_(carried_by(coarse, vessel_)),
        deployment_(scene_, coarse ? coarse->lumen : vessel_.lumen, vessel_.paths,
                    {.see = stop_if_interrupted, .every_steps = steps_between_signal_checks, .log = log}) {}

  std::size_t steps() {
    return run_exclusively([&] { return deployment_.steps(); });
  }
  std::size_t steps_done() {
    return run_exclusively([&] { return deployment_.steps_done(); });
  }
  void step() {
    run_exclusively([&] { deployment_.step(); });
  }
  void run() {
    while (steps_done() < steps())
      step();
  }
  PointRows points() {
    return rows_of(run_exclusively([&] {
      Vectors deployed = deployment_.lumen();
      return carried_ ? carried_->points(deployed) : deployed;
    }));
  }
  std::vector<DeviceShape> devices() {
    return run_exclusively([&] { return deployment_.snapshot().devices; });
  }
  Result result() {
    return run_exclusively([&] {
      DeploymentResult d = deployment_.result();
      if (carried_)
        d = carried_->carried(std::move(d));
      json figures = readouts(scene_, vessel_.lumen, vessel_.paths, d);
      return Result{std::move(d), vessel_.lumen.triangles, std::move(figures)};
    });
  }

private:
  Vessel vessel_;
  Scene scene_;
  std::optional<CarriedLumen> carried_;
  Deployment deployment_;
  std::recursive_mutex mutex_; ///< recursive: the user's log function may ask for the state
};

std::unique_ptr<Session> make_session(const Vessel& vessel, const py::dict& devices, const py::sequence& steps,
                                      double map_pa, const py::dict& wall, const py::dict& numerics,
                                      const Vessel* coarse_lumen, const Log& log) {
  Scene scene = scene_of(vessel, devices, steps, map_pa, wall, numerics);
  const py::gil_scoped_release released;
  if (coarse_lumen)
    check_lumen(scene, coarse_lumen->lumen, vessel.paths);
  return std::make_unique<Session>(vessel, coarse_lumen, std::move(scene), log);
}

Result deploy_all(const Vessel& vessel, const py::dict& devices, const py::sequence& steps, double map_pa,
                  const py::dict& wall, const py::dict& numerics, const Vessel* coarse_lumen, const Log& log) {
  const std::unique_ptr<Session> deployment =
      make_session(vessel, devices, steps, map_pa, wall, numerics, coarse_lumen, log);
  deployment->run();
  return deployment->result();
}

PointRows radius_corrected(const Vessel& vessel, const py::dict& devices, const py::sequence& steps) {
  const Scene scene = scene_of(vessel, devices, steps, Scene{}.map_pa, {}, {});
  const py::gil_scoped_release released;
  return rows_of(correct_radius(scene, vessel.lumen, vessel.paths));
}

constexpr const char* argument_docs = R"(

lumen: Lumen before the procedure.
devices: {name: entry}, as `devices` of scene.json (docs/design.md).
steps: list of steps, as `procedure` of scene.json.)";
constexpr const char* option_docs = R"(
map_pa: mean arterial pressure, Pa.
wall, numerics: settings off their defaults, as in scene.json (vci/settings.md).
coarse_lumen: Lumen of the same vessel on longer edges. It is deployed in less time and moves `lumen` along; its
    centreline is not used.
log: function that takes each line of progress and warnings; None for silence.

Raises InputError before any work, ComputationError where a stage does not reach force balance.)";

} // namespace

PYBIND11_MODULE(_engine, m) {
  m.doc() = "Balloons and stents in a lumen, on numpy arrays.";
  py::register_exception<common::InputError>(m, "InputError", PyExc_ValueError).doc() =
      "Bad input. The message says what, where, the value and a remedy.";
  py::register_exception<common::ComputationError>(m, "ComputationError", PyExc_RuntimeError).doc() =
      "A computation that did not converge. The message says what, where, the value and a remedy.";

  py::class_<Vessel>(m, "Lumen", "A lumen's surface with the axes of its branches. Lengths in mm.")
      .def(py::init(&vessel_from), py::arg("points"), py::arg("triangles"), py::arg("radius_mm"), py::arg("centreline"),
           py::kw_only(), py::arg("plaque_thickness_mm") = py::none(), py::arg("plaque_type") = py::none(),
           py::arg("reference_radius_mm") = py::none(), py::arg("branch_id") = py::none(), R"(
points: (n, 3) mm.
triangles: (m, 3) indices of points, counterclockwise seen from outside; the wall without caps.
radius_mm: (n,) local radius of the lumen.
centreline: {branch: (k, 3) mm}. `main` starts at the inlet, a side branch on its parent's axis.
plaque_thickness_mm: (n,); none without it.
plaque_type: (n,) int: 0 none, 1 fibrous, 2 lipid, 3 calcified.
reference_radius_mm: (n,) radius without disease, for the expansion index.
branch_id: (m,) int, number of each triangle's branch. The tissue between two branches keeps their walls apart;
    without it the walls of a bifurcation may cross.

Raises InputError where lengths differ or a value is not possible.)")
      .def_static(
          "read",
          [](const std::filesystem::path& lumen, const std::filesystem::path& centreline) {
            return Vessel{read_lumen(lumen), read_centreline(centreline)};
          },
          py::arg("lumen"), py::arg("centreline"), py::call_guard<py::gil_scoped_release>(),
          "The lumen of lumen.vtp and centreline.vtp as the anatomy step writes them. Raises InputError.")
      .def_property_readonly(
          "points", [](const Vessel& v) { return rows_of(v.lumen.points); }, "(n, 3) mm")
      .def_property_readonly(
          "triangles", [](const Vessel& v) { return rows_of_triangles(v.lumen.triangles); }, "(m, 3)")
      .def_property_readonly(
          "centreline", [](const Vessel& v) { return arrays_of(v.paths); },
          "{branch: (k, 3) mm}; side branches from the inlet on");

  py::class_<DeviceShape>(m, "Device", "The shape of a balloon inflated, or of a stent.")
      .def_readonly("name", &DeviceShape::name, "a balloon's by its step, a stent's device")
      .def_property_readonly(
          "kind", [](const DeviceShape& d) { return d.kind == DeviceShape::Kind::stent ? "stent" : "balloon"; },
          "balloon or stent")
      .def_property_readonly(
          "points", [](const DeviceShape& d) { return rows_of(d.points); }, "(n, 3) mm")
      .def_property_readonly(
          "triangles", [](const DeviceShape& d) { return rows_of_triangles(d.triangles); }, "(m, 3)")
      .def_property_readonly(
          "forces", [](const DeviceShape& d) { return arrays_of(d.forces); },
          "{pressure_n, contact_n, foundation_n, residual_n: (n, 3)}");

  py::class_<Result>(m, "Result", "The lumen and the devices after the procedure.")
      .def_property_readonly(
          "points", [](const Result& r) { return rows_of(r.deployment.points); },
          "(n, 3) mm, in the order of the lumen's")
      .def_property_readonly(
          "triangles", [](const Result& r) { return rows_of_triangles(r.triangles); }, "(m, 3)")
      .def_property_readonly(
          "wall_stretch", [](const Result& r) { return py::array(py::cast(r.deployment.wall_stretch)); },
          "(n,) largest principal stretch")
      .def_property_readonly(
          "malapposition_mm", [](const Result& r) { return py::array(py::cast(r.deployment.malapposition)); },
          "(n,) gap between wall and stent; 0 where no stent faces the wall")
      .def_property_readonly(
          "forces", [](const Result& r) { return arrays_of(r.deployment.forces); },
          "{pressure_n, contact_n, foundation_n, residual_n: (n, 3)}; 0 where the wall is held. At the points of "
          "coarse_lumen, if it was given")
      .def_property_readonly(
          "devices", [](const Result& r) { return r.deployment.devices; },
          "[Device]: balloons inflated, in the order of their steps, then stents")
      .def_property_readonly(
          "centreline", [](const Result& r) { return arrays_of(r.deployment.paths); },
          "{branch: (k, 3) mm} after the procedure")
      .def_property_readonly(
          "readouts", [](const Result& r) { return python_object(r.readouts); },
          "the document deployment.json (docs/design.md): areas, expansion, recoil, stages, warnings");

  py::class_<Session>(m, "Deployment",
                      (std::string("A procedure that runs one step at a time.") + argument_docs + option_docs).c_str())
      .def(py::init(&make_session), py::arg("lumen"), py::arg("devices"), py::arg("steps"), py::kw_only(),
           py::arg("map_pa") = Scene{}.map_pa, py::arg("wall") = py::dict(), py::arg("numerics") = py::dict(),
           py::arg("coarse_lumen") = nullptr, py::arg("log") = py::none())
      .def("step", &Session::step, "Runs the next step. Raises ComputationError, RuntimeError where none is left.")
      .def("run", &Session::run, "Runs the steps that are left. Raises ComputationError.")
      .def("result", &Session::result,
           "The Result of the steps done. Raises ComputationError where a stent touches nothing.")
      .def_property_readonly("steps", &Session::steps, "number of steps")
      .def_property_readonly("steps_done", &Session::steps_done, "number of steps that have run")
      .def_property_readonly("points", &Session::points, "(n, 3) mm: the lumen as it is now")
      .def_property_readonly("devices", &Session::devices, "[Device] as they are now");

  m.def("deploy", &deploy_all, py::arg("lumen"), py::arg("devices"), py::arg("steps"), py::kw_only(),
        py::arg("map_pa") = Scene{}.map_pa, py::arg("wall") = py::dict(), py::arg("numerics") = py::dict(),
        py::arg("coarse_lumen") = nullptr, py::arg("log") = py::none(),
        (std::string("Runs a procedure and returns its Result.") + argument_docs + option_docs).c_str());
  m.def("radius_correct", &radius_corrected, py::arg("lumen"), py::arg("devices"), py::arg("steps"),
        (std::string("The baseline without mechanics: the radius along the stented span becomes the device's.\n"
                     "Returns points (n, 3) mm.") +
         argument_docs)
            .c_str());
}
