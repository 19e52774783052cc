// Runs a scene's procedure on the mechanical system: all at once, or step by step.
#pragma once
#include "vci/procedure/snapshot.hpp"

#include <functional>
#include <memory>

namespace vci {

struct StageReport {
  std::string step, stage;
  double seconds;
  RelaxResult result;
};

struct DeploymentResult {
  std::vector<StageReport> stages;
  std::vector<StentHistory> stents;
  std::vector<DeviceShape> devices;                ///< balloons inflated, in the order of their steps, then stents
  std::vector<std::string> switched_off, warnings; ///< texts: parts of the model left out, and warnings
  Vectors points;                                  ///< lumen points at the end, mm
  std::vector<double> wall_stretch;                ///< per lumen point: largest principal stretch
  std::vector<double> malapposition; ///< per lumen point: gap between wall and stent, mm; 0 where no stent faces it
  Balance forces;                    ///< per lumen point at the end, N; 0 where the wall is fixed
  std::map<std::string, Path> paths; ///< axis of each branch at the end
  int vertices = 0;                  ///< number of the wall's vertices in the computation
};

/// Callbacks of a run. Each may be left out.
struct Observer {
  /// Receives the state at the end of each stage and, if `every_steps` is above 0, after every `every_steps` steps.
  std::function<void(const Snapshot&)> see;
  int every_steps = 0;
  /// Takes lines of progress and warnings, without newlines.
  std::function<void(const std::string&)> log;
};

/// A procedure that runs one step at a time and can be asked for its state in between.
class Deployment {
public:
  /// @param lumen, paths surface and axes of the branches before the procedure, mm
  Deployment(Scene scene, Lumen lumen, std::map<std::string, Path> paths, Observer observer = {});
  ~Deployment();
  Deployment(Deployment&&) noexcept;
  Deployment& operator=(Deployment&&) noexcept;

  /// Number of steps in the scene's procedure, and number of the steps that have run.
  std::size_t steps() const;
  std::size_t steps_done() const;
  /// Runs the next step: places its devices, inflates its balloons and takes them out; stents stay. If a stage does not
  /// reach force balance, throws common::ComputationError, which names step, stage, residual and remedy. Throws
  /// std::logic_error if no step is left, or if an earlier one failed.
  void step();
  /// Current positions (mm) of the lumen's points, in the lumen's order.
  Vectors lumen() const;
  /// Current shapes of lumen and devices, with the forces at the end of the last stage.
  Snapshot snapshot() const;
  const std::vector<StageReport>& stages() const;
  /// The result of the steps done. Throws common::ComputationError if a stent touches nothing.
  DeploymentResult result();

private:
  class Run;
  std::unique_ptr<Run> run_;
};

/// Runs all steps of the scene. Throws as Deployment does.
DeploymentResult deploy(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths,
                        const Observer& observer = {});

} // namespace vci
